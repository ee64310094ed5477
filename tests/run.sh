#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests.
#   tests/run.sh [--slow] [--builds] [--sanitize] [--lammps RELEASE] [--valgrind] [ctest options...]
# --slow      with the slow verification tests
# --builds    with the tests that build anew: the portable plugin with its package, and a LAMMPS that holds DEFE
# --lammps    with another release of LAMMPS, in a build folder of its own: 4Jul2026
# --sanitize  with address and undefined-behaviour sanitizers in DEFE's own code
# --valgrind  instead of the tests, a small crack on two ranks under memcheck (tests/valgrind.sh)
set -euo pipefail
exec </dev/null
# shellcheck source=../tools/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/../tools/common.sh"

slow=OFF builds=OFF preset=release ctest_args=() options=()
while (($#)); do
  arg=$1
  shift
  case $arg in
    --slow) slow=ON ;;
    --builds) builds=ON ;;
    --lammps)
      (($#)) || { echo 'tests/run.sh: --lammps needs a release, such as 4Jul2026' >&2; exit 2; }
      release=$1
      options+=(-D "DEFE_LAMMPS_RELEASE=$1")
      shift ;;
    --sanitize) preset=sanitize ;;
    --valgrind) exec "$DEFE_ROOT/tests/valgrind.sh" ;;
    -h | --help) sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) ctest_args+=("$arg") ;;
  esac
done

"$DEFE_ROOT/tools/install-deps.sh" build tests meshes plots docs vtk
export DEFE_FOLDER=$preset${release:+-$release}
defe_build "$preset" -- -D DEFE_TESTS=ON -D "DEFE_SLOW_TESTS=$slow" -D "DEFE_BUILD_TESTS=$builds" "${options[@]}"

# A broken test can print without end: 1000 lines are shown as they come, then the last 150.
build=$DEFE_ROOT/build/$DEFE_FOLDER
jobs=$(defe_cores)
code=0
echo "DEFE: running the tests, $jobs processes at a time" >&2
ctest --test-dir "$build" --output-on-failure --no-tests=error -j "$jobs" "${ctest_args[@]}" 2>&1 |
  tee "$build/ctest.log" |
  awk -v head=1000 -v tail=150 -v log_name="build/$DEFE_FOLDER/ctest.log" '
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
