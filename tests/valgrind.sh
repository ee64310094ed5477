#!/usr/bin/env bash
# Runs a small crack on two ranks under valgrind's memcheck (tests/valgrind/in.crack): no error may
# come from DEFE's code. What LAMMPS and Open MPI do is left out by name, in tests/valgrind/*.supp.
#   tests/valgrind.sh [steps]     150 without argument: some minutes
# The build is one of its own, without -march=native: valgrind 3.19 does not know AVX-512.
set -euo pipefail
exec </dev/null
# shellcheck source=../tools/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/../tools/common.sh"

steps=${1:-150}
case $steps in
  -h | --help) sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
  *[!0-9]* | '') echo "valgrind.sh: not a number of steps: $steps" >&2; exit 2 ;;
esac

"$DEFE_ROOT/tools/install-deps.sh" build valgrind
command -v valgrind >/dev/null || { echo 'valgrind.sh: no valgrind' >&2; exit 1; }
build=${DEFE_VALGRIND_BUILD:-$DEFE_ROOT/build/valgrind}
mkdir -p "$build/run"
log=$build/build.log
echo "DEFE: building without -march=native" >&2
if ! {
  (cd "$DEFE_ROOT" && cmake --preset release -B "$build" -D CMAKE_BUILD_TYPE=RelWithDebInfo \
    -D DEFE_NATIVE=OFF -D DEFE_TESTS=OFF) &&
    cmake --build "$build" --parallel --target defeplugin
} >"$log" 2>&1; then
  { grep -E -A 8 'error:|Error' "$log" || tail -n 30 "$log"; } | head -n 60 >&2
  exit 1
fi

cd "$build/run"
rm -f valgrind.*.log crack.* events.txt
suppressions=()
for file in "$DEFE_ROOT"/tests/valgrind/*.supp /usr/share/openmpi/openmpi-valgrind.supp; do
  if [[ -f $file ]]; then suppressions+=("--suppressions=$file"); fi
done
# Leaks are not asked for: MPI keeps its memory to the end.
code=0
OMPI_MCA_mpi_yield_when_idle=1 "$DEFE_ROOT/tools/mpirun.sh" 2 valgrind --tool=memcheck --leak-check=no \
  --track-origins=yes --error-exitcode=33 --num-callers=24 --log-file="valgrind.%p.log" "${suppressions[@]}" \
  "$build/lmp" -in "$DEFE_ROOT/tests/valgrind/in.crack" -log none -nocite \
  -var plugin "$build/defeplugin.so" -var steps "$steps" >run.log 2>&1 || code=$?
clean=$(grep -l 'ERROR SUMMARY: 0 errors' valgrind.*.log | wc -l)
if ((code != 0 || clean != 2)); then
  grep -h '^ERROR' run.log | head -n 3 >&2 || true
  sed 's/^==[0-9]*== //' valgrind.*.log | head -n 120 >&2
  echo "valgrind: errors; the logs are in $build/run" >&2
  exit 1
fi
grep -h 'ERROR SUMMARY' valgrind.*.log | sed 's/^==[0-9]*== /rank: /'
