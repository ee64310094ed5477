#!/usr/bin/env bash
# Breaks 30 specimens in one LAMMPS job, a partition for each rank, and analyses them. Called by examples/run.sh, which explains
# the DEFE_ variables:
#   examples/run.sh four_point_bending [-np N] [LAMMPS options...]
# variants: float
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# shellcheck source=../simulate.sh
source ../simulate.sh

variant=${DEFE_VARIANT:-float}
if [[ $variant != float ]]; then
  echo "example 'four_point_bending' has no variant '$variant': use float" >&2
  exit 2
fi
out=output/$variant
fresh "$out"
rm -f "$out"/{events,force}.*.txt "$out"/flaws.*.dump "$out"/log.lammps.* "$out"/screen.* tmp.lammps.variable*
options=(-plog "$out/log.lammps" -pscreen none)
if ((DEFE_NP > 1)); then options+=(-partition "${DEFE_NP}x1"); else options=(); fi
simulate in.four_point_bending "$out" "${options[@]}" "$@"
rm -f tmp.lammps.variable*
"$DEFE_PYTHON" analyse.py "$out"
