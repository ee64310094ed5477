#!/usr/bin/env bash
# Runs the tempered pane and analyses it. Called by examples/run.sh, which explains the DEFE_ variables:
#   examples/run.sh tempered_pane [fine | coarse | piece] [-np N] [LAMMPS options...]
# variants: fine coarse piece
# DEFE_NAME=NAME puts the results into output/NAME, not output/VARIANT.
# piece: a piece of a large pane, closed with itself, DEFE_SIDE (m, 0.016) long, elements of DEFE_EDGE (m, 0.5e-3);
# output/fragments.png has all output/piece* beside what is published.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

variant=${DEFE_VARIANT:-fine}
out=output/${DEFE_NAME:-$variant}
fresh "$out"
case $variant in
  fine) options=() ;;
  coarse) options=(-var edge 2e-3 -var dt 5e-8 -var strength 54e6 -var blow 30) ;;
  piece)
    side=${DEFE_SIDE:-0.016} edge=${DEFE_EDGE:-0.5e-3}
    dt=$("$DEFE_PYTHON" -c 'import sys; print(2.5e-5 * float(sys.argv[1]))' "$edge")
    options=(-var sides periodic -var side "$side" -var edge "$edge" -var dt "$dt" -var strength auto -var end 1.2e-5
      -var element plain -var nuclei auto -var branch 1.3)
    ;;
  *) echo "example 'tempered_pane' has no variant '$variant': use fine, coarse or piece" >&2; exit 2 ;;
esac
simulate in.tempered_pane "$out" "$@" "${options[@]}"
"$DEFE_PYTHON" analyse.py "$out"
if [[ $variant == piece ]]; then
  done_before=(output/piece*/summary.json)
  "$DEFE_PYTHON" analyse.py --compare output/fragments.png "${done_before[@]%/summary.json}"
fi
