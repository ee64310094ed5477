#!/usr/bin/env bash
# What cannot be written, or is broken in the cache of LAMMPS, is named in one line: the right that is
# missing, or the folder to delete. Files in the place of folders stand for folders that cannot be written,
# since root may write everywhere.
#   test_build_messages.sh PROJECT_FOLDER
set -euo pipefail
project=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

# expect WORDS COMMAND...: the command fails, its last line has these words, and there is no other
expect() {
  local words=$1 text status=0
  shift
  text=$("$@" 2>&1 </dev/null) || status=$?
  if ((status == 0)) || [[ $text != *"$words"* || $text == *$'\n'* ]]; then
    printf 'expected: %s\nexit status %s, got: %s\n' "$words" "$status" "$text" >&2
    failures=$((failures + 1))
  fi
}

# a checkout in which nothing can be built
mkdir "$work/checkout"
cp -r "$project/tools" "$project/cmake" "$work/checkout"
touch "$work/checkout/build"
# shellcheck disable=SC2016  # expanded in the other shell
build=(env -u DEFE_FOLDER bash -c 'source "$0/tools/common.sh" && defe_build release --' "$work/checkout")
expect "no right to write $work/checkout/build/release/build.log" "${build[@]}"

# the cache
# shellcheck disable=SC2317  # called by expect
lammps() { DEFE_CACHE_DIR=$work/cache bash "$project/cmake/get-lammps.sh" --result "$work/result" --cxx "$compiler" --mpi-id none; }
compiler=$(command -v c++ || command -v g++ || command -v clang++)
touch "$work/cache"
expect "no right to write into the folder $work/cache" lammps
rm "$work/cache"
source=$work/cache/lammps-4Feb2025-source
mkdir -p "$source/src"
echo '#define LAMMPS_VERSION "4 Feb 2025"' >"$source/src/version.h"
expect "delete the folder $source and start again" lammps
mkdir "$source/cmake"
touch "$source/cmake/CMakeLists.txt"
# a build that says it is complete and is not; the name holds a hash of options, which the message shows
fake=$work/bin
mkdir "$fake"
printf '#!/bin/sh\nexit 0\n' >"$fake/cmake" # builds nothing and is content
chmod +x "$fake/cmake"
export PATH=$fake:$PATH
DEFE_CACHE_DIR=$work/cache bash "$project/cmake/get-lammps.sh" --result "$work/result" --cxx "$compiler" --mpi-id none >/dev/null 2>&1 || true
expect "the cached build of LAMMPS is broken (no lmp): delete the folder $work/cache/lammps-4Feb2025-" lammps

# a build of another release is not waited for, one of the same is
if command -v flock >/dev/null; then
  exec 8>"$work/cache/lammps-4Jul2026.lock"
  flock 8
  expect "the cached build of LAMMPS is broken (no lmp)" timeout 30 env "DEFE_CACHE_DIR=$work/cache" \
    bash "$project/cmake/get-lammps.sh" --result "$work/result" --cxx "$compiler" --mpi-id none
  exec 8>"$work/cache/lammps-4Feb2025.lock"
  flock 8
  expect 'waiting for another build of LAMMPS (lammps-4Feb2025)' timeout 2 env "DEFE_CACHE_DIR=$work/cache" \
    bash "$project/cmake/get-lammps.sh" --result "$work/result" --cxx "$compiler" --mpi-id none
fi
exit $((failures > 0))
