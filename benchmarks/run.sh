#!/usr/bin/env bash
# Builds, and measures DEFE and its peers side by side on this machine, on one core unless a row says
# otherwise. Writes a table and a JSON file to benchmarks/output.
#   benchmarks/run.sh [--quick] [--profile] [--rounds N] [--page] [row...]
# --quick    a few steps of everything, in seconds: shows that it works, figures mean nothing
# --profile  also where the time goes, by function (Debian's linux-perf)
# --rounds   repetitions of the whole list (5)
# --page     also puts the table, or these rows of it, into benchmarks/README.md
# rows       kernels bricks general elastic dem adaptive two_clocks laws event event_size plate front ranks size
#            dem_size peers; all without
# DEFE_LULESH=PATH runs a LULESH of your own (serial build) among the peers.
set -euo pipefail
exec </dev/null
# shellcheck source=../tools/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/../tools/common.sh"

args=()
while (($#)); do
  case $1 in
    -h | --help) sed -n '2,11s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
    --page) args+=(--page "$DEFE_ROOT/benchmarks/README.md") ;;
    --rounds)
      [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || { echo '--rounds needs a number' >&2; exit 2; }
      args+=("$1" "$2")
      shift ;;
    *) args+=("$1") ;;
  esac
  shift
done

"$DEFE_ROOT/tools/install-deps.sh" build benchmarks
configure=(-D DEFE_BENCHMARKS=ON)
if [[ ! -f $DEFE_ROOT/build/release/CMakeCache.txt ]]; then configure+=(-D DEFE_TESTS=OFF); fi
defe_build release -- "${configure[@]}"

# An old Python may be first in the path: any of 3.7 and later will do.
exec python3 "$DEFE_ROOT/benchmarks/measure.py" --build "$DEFE_ROOT/build/release" \
  --out "$DEFE_ROOT/benchmarks/output" "${args[@]}"
