#!/usr/bin/env bash
# Formats DEFE's C++ sources with clang-format, in LAMMPS' style.
#   tools/format.sh           rewrites them
#   tools/format.sh --check   only says which are not formatted
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v clang-format >/dev/null || { echo 'clang-format is not installed' >&2; exit 2; }

mapfile -d '' files < <(find fe-module coupling lammps-package tests benchmarks \
  \( -name '*.cpp' -o -name '*.h' \) -print0 | sort -z)
if ((${#files[@]} == 0)); then exit 0; fi
if [[ ${1:-} == --check ]]; then
  bad=0
  for file in "${files[@]}"; do
    clang-format --dry-run --Werror "$file" >/dev/null 2>&1 || { echo "$file"; bad=1; }
  done
  exit "$bad"
fi
clang-format -i "${files[@]}"
