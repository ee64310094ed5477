#!/usr/bin/env bash
# Runs arch.py. Called by examples/run.sh, which explains the DEFE_ variables:
#   examples/run.sh python
# variants: arch
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
variant=${DEFE_VARIANT:-arch}
if [[ $variant != arch ]]; then
  echo "example 'python' has no variant '$variant': use arch" >&2
  exit 2
fi
if ((DEFE_NP > 1)) || (($#)); then
  echo "example 'python' takes neither -np nor options of LAMMPS: edit arch.py and in.arch" >&2
  exit 2
fi
PYTHONPATH=$(dirname "$DEFE_PLUGIN")/python${PYTHONPATH:+:$PYTHONPATH} exec "$DEFE_PYTHON" arch.py "output/$variant"
