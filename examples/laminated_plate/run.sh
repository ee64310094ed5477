#!/usr/bin/env bash
# Writes the mesh, runs a variant of the laminated pane and analyses it. Called by examples/run.sh,
# which explains the DEFE_ variables:
#   examples/run.sh laminated_plate [laminated | single] [-np N] [LAMMPS options...]
# variants: laminated single
# DEFE_SIZE=1.5 or 2 makes elements of this size along the pane instead of 1 mm (1 mm through it in any case);
# results are then in output/VARIANT.SIZEmm.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

variant=${DEFE_VARIANT:-laminated} size=${DEFE_SIZE:-1}
case $size in
  1) n=100 ;;
  1.5) n=67 ;;
  2) n=50 ;;
  *) echo "laminated_plate: DEFE_SIZE is 1, 1.5 or 2 (mm)" >&2; exit 2 ;;
esac
case $variant in
  laminated) height=0.00676 layers=(--layer lower 0.003 3 1 --layer inter 0.00076 1 5 --layer upper 0.003 3 1) ;;
  single) height=0.006 layers=(--layer lower 0.006 6 1) ;;
  *) echo "example 'laminated_plate' has no variant '$variant': use laminated or single" >&2; exit 2 ;;
esac
out=output/$variant
if [[ $size != 1 ]]; then out+=.${size}mm; fi
fresh "$out"
../../tools/layers2data "$out/mesh.data" --axis z "${layers[@]}" --x -0.05 $n 0.05 --y -0.05 $n 0.05
simulate in.laminated_plate "$out" -var variant "$variant" -var height "$height" -var edge "${size}e-3" "$@"
"$DEFE_PYTHON" analyse.py "$out" "$variant"
