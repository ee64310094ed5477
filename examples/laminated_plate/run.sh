#!/usr/bin/env bash
# Writes the mesh, runs a variant of the laminated pane and analyses it. Called by examples/run.sh,
# which explains the DEFE_ variables:
#   examples/run.sh laminated_plate [laminated | single] [-np N] [LAMMPS options...]
# variants: laminated single
# DEFE_SIZE=1.5 or 2 makes elements of this size along the pane instead of 1 mm (1 mm through it in any case),
# DEFE_MESH=turned or free turns them by 45 degrees, or makes quadrilaterals without a direction (mesh.py);
# results are then in output/VARIANT.SIZEmm, output/VARIANT.MESH, output/VARIANT.MESH.SIZEmm.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

variant=${DEFE_VARIANT:-laminated} size=${DEFE_SIZE:-1} mesh=${DEFE_MESH:-edges}
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
case $mesh in
  edges | turned | free) ;;
  *) echo "laminated_plate: DEFE_MESH is edges, turned or free" >&2; exit 2 ;;
esac
# short edges of quadrilaterals without a direction: smaller steps, and none that the two clocks resonate with
options=()
case $mesh$size in
  free1) options=(-var dt 1.5e-8 -var clock 2) ;;
  free1.5) options=(-var dt 2e-8 -var clock 2) ;;
  free2) options=(-var clock 1) ;;
esac
out=output/$variant
if [[ $mesh != edges ]]; then out+=.$mesh; fi
if [[ $size != 1 ]]; then out+=.${size}mm; fi
fresh "$out"
if [[ $mesh == edges ]]; then
  "$tools/layers2data" "$out/mesh.data" --axis z "${layers[@]}" --x -0.05 $n 0.05 --y -0.05 $n 0.05
else
  "$DEFE_PYTHON" mesh.py "$out/mesh.data" "$mesh" --size "$size" "${layers[@]}"
fi
simulate in.laminated_plate "$out" -var variant "$variant" -var height "$height" -var edge "${size}e-3" "$@" "${options[@]}"
"$DEFE_PYTHON" analyse.py "$out" "$variant"
