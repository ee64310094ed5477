#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests.
#   tests/run.sh [--slow] [--sanitize] [--valgrind] [ctest options...]
# --slow      with the slow verification tests
# --sanitize  with address and undefined-behaviour sanitizers in DEFE's own code
# --valgrind  instead of the tests, a small crack on two ranks under memcheck (tests/valgrind.sh)
set -euo pipefail
exec </dev/null
# shellcheck source=../tools/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/../tools/common.sh"

slow=OFF preset=release ctest_args=()
for arg; do
  case $arg in
    --slow) slow=ON ;;
    --sanitize) preset=sanitize ;;
    --valgrind) exec "$DEFE_ROOT/tests/valgrind.sh" ;;
    -h | --help) sed -n '2,6s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) ctest_args+=("$arg") ;;
  esac
done

"$DEFE_ROOT/tools/install-deps.sh" build tests meshes plots docs vtk
defe_build "$preset" -- -D DEFE_TESTS=ON -D "DEFE_SLOW_TESTS=$slow"

# A broken test can print without end: 1000 lines are shown as they come, then the last 150.
build=$DEFE_ROOT/build/$preset
jobs=$(defe_cores)
code=0
echo "DEFE: running the tests, $jobs processes at a time" >&2
ctest --test-dir "$build" --output-on-failure --no-tests=error -j "$jobs" "${ctest_args[@]}" 2>&1 |
  tee "$build/ctest.log" |
  awk -v head=1000 -v tail=150 -v log_name="build/$preset/ctest.log" '
    { if (length($0) > 2000) $0 = substr($0, 1, 2000) " ..." }
    NR <= head { print; fflush(); next }
    { ring[NR % tail] = $0 }
    END {
      first = NR - tail + 1
      if (first <= head) first = head + 1
      else if (first > head + 1) print "[" first - head - 1 " lines left out; the whole output is in " log_name "]"
      for (i = first; i <= NR; i++) print ring[i % tail]
    }' || code=$?
exit "$code"
