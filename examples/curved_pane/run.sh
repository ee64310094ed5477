#!/usr/bin/env bash
# Meshes the pane with Gmsh, converts the mesh, and runs a variant. Called by examples/run.sh, which
# explains the DEFE_ variables:
#   examples/run.sh curved_pane [elastic] [-np N] [LAMMPS options...]
# variants: elastic
# DEFE_MESH holds options for mesh.py, such as "--size 3 --size-middle 1".
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

variant=${DEFE_VARIANT:-elastic}
if [[ ! -f in.$variant ]]; then
  echo "example 'curved_pane' has no variant '$variant'" >&2
  exit 2
fi
out=output/$variant
mkdir -p "$out"
../../tools/install-deps.sh meshes
read -ra options <<<"${DEFE_MESH:-}"
./mesh.py "$out/pane.msh" "${options[@]}"
../../tools/mesh2data "$out/pane.msh" "$out/pane.data" --scale 1e-3

run=("$DEFE_LMP")
if ((DEFE_NP > 1)); then run=("$DEFE_MPIRUN" "$DEFE_NP" "$DEFE_LMP"); fi
# A relative path: log files do not tell where the tree lies.
exec "${run[@]}" -in "in.$variant" -log "$out/log.lammps" -var out "$out" "$@"
