#!/usr/bin/env bash
# Writes the mesh, runs the example and analyses it. Called by examples/run.sh, which explains the DEFE_
# variables:
#   examples/run.sh hailstones [-np N] [LAMMPS options...]
# variants: hail
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

variant=${DEFE_VARIANT:-hail}
if [[ $variant != hail ]]; then
  echo "example 'hailstones' has no variant '$variant': use hail" >&2
  exit 2
fi
out=output/$variant
fresh "$out"
rm -f "$out/hail.txt"
"$tools/layers2data" "$out/mesh.data" --axis z --layer lower 0.002 2 1 --layer inter 0.00076 1 5 \
  --layer upper 0.002 2 1 --x -0.03 40 0.03 --y -0.03 40 0.03
# atom_style bpm/sphere wants a molecule ID (none) between ID and type
awk '/^[A-Z]/ { atoms = $1 == "Atoms" } atoms && NF == 7 { $1 = $1 " 0" } { print }' "$out/mesh.data" >"$out/mesh.bpm.data"
simulate in.hailstones "$out" "$@"
"$DEFE_PYTHON" analyse.py "$out"
