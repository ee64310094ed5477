#!/usr/bin/env bash
# Fuzzes what DEFE reads: section Hexes of data files, and the options of its styles and commands.
#   tests/fuzz.sh [seconds]     1800 without argument; half of it for each of the two targets
# Needs clang (installed where possible). The corpus in tests/fuzz/corpus is what one run starts
# from; what a run adds to the coverage is kept in build/fuzz/corpus, and
#   tests/fuzz.sh --keep
# puts some kB of a smallest set of inputs with the same coverage into tests/fuzz/corpus.
# An input that crashes or hangs is left in build/fuzz/found, and the script fails.
#   tests/fuzz.sh --files [seconds]
# damages restart and event files instead, on one and two ranks, with a seed that it says.
set -euo pipefail
exec </dev/null
# shellcheck source=../tools/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/../tools/common.sh"

keep=0 files=0 seconds=1800
for arg; do
  case $arg in
    --keep) keep=1 ;;
    --files) files=1 ;;
    -h | --help) sed -n '2,10s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *[!0-9]* | '') echo "fuzz.sh: not a number of seconds: $arg" >&2; exit 2 ;;
    *) seconds=$arg ;;
  esac
done

if ((files)); then
  "$DEFE_ROOT/tools/install-deps.sh" build tests
  defe_build release lammps_file_fuzz -- -D DEFE_TESTS=ON
  export DEFE_FUZZ_SECONDS=$((seconds / 2)) DEFE_FUZZ_SEED=${DEFE_FUZZ_SEED:-$(date +%s)}
  echo "DEFE: DEFE_FUZZ_SEED=$DEFE_FUZZ_SEED" >&2
  mkdir -p "$DEFE_ROOT/build/release/file_fuzz"
  cd "$DEFE_ROOT/build/release/file_fuzz"
  for ranks in 1 2; do "$DEFE_ROOT/tools/mpirun.sh" "$ranks" ../tests/lammps_file_fuzz; done
  exit
fi

"$DEFE_ROOT/tools/install-deps.sh" build tests fuzz
clang=${DEFE_CLANG:-}
for name in clang++ clang++-{19,18,17,16,15,14}; do
  if [[ -z $clang ]] && command -v "$name" >/dev/null; then clang=$name; fi
done
[[ -n $clang ]] || { echo 'fuzz.sh: no clang++ (DEFE_CLANG names one)' >&2; exit 1; }

# LAMMPS itself stays as it is, built by the usual compiler.
build=${DEFE_FUZZ_BUILD:-$DEFE_ROOT/build/fuzz}
mkdir -p "$build"
(cd "$DEFE_ROOT" && cmake --preset release -B "$build/lammps" -D DEFE_TESTS=OFF) >"$build/lammps.log" 2>&1 ||
  { tail -n 30 "$build/lammps.log" >&2; exit 1; }
lammps=$(sed -n 's/^build=//p' "$build/lammps/lammps-host.txt")
echo "DEFE: building with $clang" >&2
log=$build/build.log
if ! {
  (cd "$DEFE_ROOT" && cmake --preset sanitize -B "$build" -D "CMAKE_CXX_COMPILER=$clang" -D DEFE_TESTS=ON \
    -D DEFE_FUZZ=ON -D "LAMMPS_BINARY_DIR=$lammps") &&
    cmake --build "$build" --parallel --target fuzz_hexes fuzz_options
} >"$log" 2>&1; then
  grep -E -A 8 'error:|Error' "$log" | head -n 60 >&2 || tail -n 30 "$log" >&2
  exit 1
fi

code=0
mkdir -p "$build/found"
for name in hexes options; do
  corpus=$DEFE_ROOT/tests/fuzz/corpus/$name
  mine=$build/corpus/$name
  mkdir -p "$mine"
  program=$build/tests/fuzz/fuzz_$name
  if ((keep)); then
    merged=$(mktemp -d)
    "$program" -merge=1 -max_len=1024 "$merged" "$corpus" "$mine" >"$build/$name.merge.log" 2>&1
    # Inputs with a name were written by hand, or crashed once: they stay.
    find "$corpus" -regextype posix-extended -regex '.*/[0-9a-f]{40}' -delete
    # Of the rest the longest ones, some kB in all: they get furthest, mutations shorten them by themselves.
    while read -r size file; do
      ((total = ${total:-0} + size, total <= 6000)) || break
      cp "$file" "$corpus/"
    done < <(find "$merged" -type f -printf '%s %p\n' | sort -k 1,1rn -k 2)
    total=0
    rm -rf "$merged"
    echo "$name: $(find "$corpus" -type f | wc -l) inputs, $(cat "$corpus"/* | wc -c) bytes"
    continue
  fi
  # A leak of the fuzzed process would end the run: LAMMPS' objects die with an exception.
  if ! "$DEFE_ROOT/tools/mpirun.sh" 1 "$program" -max_total_time=$((seconds / 2)) -timeout=20 -max_len=1024 -rss_limit_mb=6000 \
    -detect_leaks=0 -artifact_prefix="$build/found/$name-" -dict="$DEFE_ROOT/tests/fuzz/$name.dict" \
    -print_final_stats=1 "$mine" "$corpus" >"$build/$name.log" 2>&1; then
    code=1
    grep -E -A 25 'ERROR|runtime error|terminate' "$build/$name.log" | head -n 60 >&2 || true
  fi
  echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$build/$name.log") inputs;" \
    "$(grep -E 'cov:' "$build/$name.log" | tail -n 1 | cut -c 1-90)"
done
if ((code)); then echo "inputs that crash or hang: build/fuzz/found" >&2; fi
exit "$code"
