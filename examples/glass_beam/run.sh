#!/usr/bin/env bash
# Runs a variant of the glass beam and analyses it. Called by examples/run.sh, which explains the
# DEFE_ variables:
#   examples/run.sh glass_beam [adaptive | dem | bpm | compare] [-np N] [LAMMPS options...]
# variants: adaptive dem bpm compare
# compare runs the three others one after the other.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

# one VARIANT [LAMMPS options...]: LAMMPS and the analysis
one() {
  local variant=$1 out=output/$1 script=in.glass_beam
  shift
  if [[ $variant == bpm ]]; then script=in.bpm; fi
  fresh "$out"
  simulate "$script" "$out" -var variant "$variant" "$@" || return
  if [[ $variant == bpm ]]; then
    "$DEFE_PYTHON" analyse.py bpm "$out"
  else
    "$DEFE_PYTHON" analyse.py run "$out" "$variant"
  fi
}

case ${DEFE_VARIANT:=adaptive} in
  adaptive | dem | bpm)
    one "$DEFE_VARIANT" "$@"
    ;;
  compare)
    export quiet=yes
    rm -f output/compare.json output/compare.png
    for variant in adaptive dem bpm; do
      echo "glass_beam: running $variant" >&2
      one "$variant" "$@"
    done
    "$DEFE_PYTHON" analyse.py compare output
    ;;
  *)
    echo "example 'glass_beam' has no variant '$DEFE_VARIANT': use adaptive, dem, bpm or compare" >&2
    exit 2
    ;;
esac
