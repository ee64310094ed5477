#!/usr/bin/env bash
# Runs the tempered pane and analyses it. Called by examples/run.sh, which explains the DEFE_ variables:
#   examples/run.sh tempered_pane [fine | coarse] [-np N] [LAMMPS options...]
# variants: fine coarse
# DEFE_NAME=NAME puts the results into output/NAME, not output/VARIANT.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

variant=${DEFE_VARIANT:-fine}
case $variant in
  fine) options=() ;;
  coarse) options=(-var edge 2e-3 -var dt 5e-8 -var strength 54e6 -var blow 30) ;;
  *) echo "example 'tempered_pane' has no variant '$variant': use fine or coarse" >&2; exit 2 ;;
esac
out=output/${DEFE_NAME:-$variant}
fresh "$out"
simulate in.tempered_pane "$out" "$@" "${options[@]}"
"$DEFE_PYTHON" analyse.py "$out"
