#!/usr/bin/env bash
# Meshes the pane with Gmsh, converts the mesh, runs a variant and analyses it. Called by examples/run.sh,
# which explains the DEFE_ variables:
#   examples/run.sh curved_pane [ball | elastic] [-np N] [LAMMPS options...]
# variants: ball elastic
# DEFE_MESH holds options for mesh.py, such as "--size 3 --size-middle 1".
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

variant=${DEFE_VARIANT:-ball} code=0
case $variant in
  ball) script=in.curved_pane ;;
  elastic) script=in.elastic ;;
  *) echo "example 'curved_pane' has no variant '$variant': use ball or elastic" >&2; exit 2 ;;
esac
# Paths are relative: log files do not tell where the tree lies.
out=output/$variant
mkdir -p "$out"
rm -f "$out"/*.png "$out"/{events,energies}.txt "$out"/{log.lammps,summary.json}
../../tools/install-deps.sh meshes
read -ra options <<<"${DEFE_MESH:-}"
./mesh.py "$out/mesh.msh" "${options[@]}"
../../tools/mesh2data "$out/mesh.msh" "$out/mesh.data" --scale 1e-3

run=("$DEFE_LMP")
if ((DEFE_NP > 1)); then run=("$DEFE_MPIRUN" "$DEFE_NP" "$DEFE_LMP"); fi
"${run[@]}" -in "$script" -log "$out/log.lammps" -var out "$out" "$@" || code=$?
if ((code)); then
  echo "curved_pane: LAMMPS failed on variant $variant (exit code $code); log in examples/curved_pane/$out" >&2
  exit "$code"
fi
if [[ $variant == ball ]]; then "$DEFE_PYTHON" analyse.py "$out"; fi
