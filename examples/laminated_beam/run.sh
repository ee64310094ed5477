#!/usr/bin/env bash
# Writes the mesh, runs a variant of the laminated beam and analyses it. Called by examples/run.sh,
# which explains the DEFE_ variables:
#   examples/run.sh laminated_beam [laminated | mooney | monolithic | compare] [-np N] [LAMMPS options...]
# variants: laminated mooney monolithic compare
# compare runs the three others one after the other. DEFE_LAYERS=2 puts two elements through the interlayer.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

# one VARIANT [LAMMPS options...]: mesh, LAMMPS and the analysis
one() {
  local variant=$1 out=output/$1 colour=5
  shift
  if [[ $variant == monolithic ]]; then colour=1; fi
  fresh "$out"
  "$tools/layers2data" "$out/mesh.data" --layer lower 0.008 4 1 --layer inter 0.00152 "${DEFE_LAYERS:-1}" $colour \
    --layer upper 0.008 4 1 --x -0.100 1 -0.099 99 0.099 1 0.100 --z 0 5 0.010
  simulate in.laminated_beam "$out" -var variant "$variant" "$@" || return
  "$DEFE_PYTHON" analyse.py run "$out" "$variant"
}

case ${DEFE_VARIANT:=laminated} in
  laminated | mooney | monolithic)
    one "$DEFE_VARIANT" "$@"
    ;;
  compare)
    export quiet=yes
    for variant in laminated mooney monolithic; do
      echo "laminated_beam: running $variant" >&2
      one "$variant" "$@"
    done
    "$DEFE_PYTHON" analyse.py compare output
    ;;
  *)
    echo "example 'laminated_beam' has no variant '$DEFE_VARIANT': use laminated, mooney, monolithic or compare" >&2
    exit 2
    ;;
esac
