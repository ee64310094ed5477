#!/usr/bin/env bash
# Meshes the pane with Gmsh, converts the mesh, runs a variant and analyses it. Called by examples/run.sh,
# which explains the DEFE_ variables:
#   examples/run.sh curved_pane [ball | elastic] [-np N] [LAMMPS options...]
# variants: ball elastic
# DEFE_MESH holds options for mesh.py, such as "--size 3 --size-middle 1", or is a mesh that is there: FILE.msh.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

variant=${DEFE_VARIANT:-ball}
case $variant in
  ball) script=in.curved_pane ;;
  elastic) script=in.elastic ;;
  *) echo "example 'curved_pane' has no variant '$variant': use ball or elastic" >&2; exit 2 ;;
esac
out=output/$variant
fresh "$out"
"$tools/install-deps.sh" meshes
if [[ ${DEFE_MESH:-} == *.msh ]]; then
  cp "$DEFE_MESH" "$out/mesh.msh"
else
  read -ra options <<<"${DEFE_MESH:-}"
  ./mesh.py "$out/mesh.msh" "${options[@]}"
fi
"$tools/mesh2data" "$out/mesh.msh" "$out/mesh.data" --scale 1e-3
simulate "$script" "$out" "$@"
"$DEFE_PYTHON" analyse.py "$out" "$variant"
