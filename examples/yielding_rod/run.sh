#!/usr/bin/env bash
# Runs the rod on the pane and analyses it. Called by examples/run.sh, which explains the DEFE_ variables:
#   examples/run.sh yielding_rod [yielding | elastic | compare] [-np N] [LAMMPS options...]
# variants: yielding elastic compare
# compare runs both others.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

# one VARIANT [LAMMPS options...]: LAMMPS and the analysis
one() {
  local variant=$1 out=output/$1
  shift
  fresh "$out"
  rm -f "$out/rod.dump"
  simulate in.yielding_rod "$out" -var variant "$variant" -var materials "$tools/materials.inc" "$@" || return
  "$DEFE_PYTHON" analyse.py run "$out"
}

case ${DEFE_VARIANT:=yielding} in
  yielding | elastic)
    one "$DEFE_VARIANT" "$@"
    ;;
  compare)
    export quiet=yes
    for variant in yielding elastic; do
      echo "yielding_rod: running $variant" >&2
      one "$variant" "$@"
    done
    "$DEFE_PYTHON" analyse.py compare output
    ;;
  *)
    echo "example 'yielding_rod' has no variant '$DEFE_VARIANT': use yielding, elastic or compare" >&2
    exit 2
    ;;
esac
