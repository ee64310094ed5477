#!/usr/bin/env bash
# gate.sh OLD NEW [ranks...]: are the results of two builds the same to the last digit?
#
# OLD and NEW are build folders of this machine, built with the same compiler and options, NEW with the target
# lammps_gate. The scenes of lammps/test_gate.cpp run with the plugin of each, on 1, 2 and 4 ranks; what they
# write (vector of the fix, energies, pressure, atoms, joints, events) is compared byte by byte.
#
#     git worktree add ../old main && cd ../old && cmake --preset release -D DEFE_TESTS=ON
#     cmake --build build/release --target defeplugin
#     tests/gate.sh ../old/build/release build/release
#
# Code that only moves can change last digits: compilers place fused multiply-adds anew. Without them
# (both builds with -D DEFE_NATIVE=OFF) it does not.
set -euo pipefail

if (($# < 2)); then
  sed -n '2,/^set/p' "$0" | sed -n 's/^# \{0,1\}//p' >&2
  exit 2
fi
old=$(realpath "$1")
new=$(realpath "$2")
shift 2
ranks=("$@")
if ((${#ranks[@]} == 0)); then ranks=(1 2 4); fi

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=$new/tests/lammps_gate
plugin_of() { find "$1" -maxdepth 3 -name 'defeplugin.so' -print -quit; }
for build in "$old" "$new"; do
  if [[ -z $(plugin_of "$build") ]]; then
    echo "gate.sh: no defeplugin.so in $build: build the target defeplugin there" >&2
    exit 2
  fi
done
if [[ ! -x $program ]]; then
  echo "gate.sh: no $program: configure with -D DEFE_TESTS=ON and build the target lammps_gate" >&2
  exit 2
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
for np in "${ranks[@]}"; do
  for side in old new; do
    mkdir -p "$folder/$np/$side"
    if ! (cd "$folder/$np/$side" &&
      DEFE_GATE_PLUGIN=$(plugin_of "${!side}") "$root/tools/mpirun.sh" "$np" "$program" >../"$side".log 2>&1); then
      cat "$folder/$np/$side.log"
      echo "gate.sh: the $side build fails on $np ranks" >&2
      exit 1
    fi
    rm -f "$folder/$np/$side"/*.restart # their format may change
  done
  count=0
  for file in "$folder/$np/old"/*; do
    name=$(basename "$file")
    count=$((count + 1))
    if ! cmp -s "$file" "$folder/$np/new/$name"; then
      failed=$((failed + 1))
      echo "$name on $np ranks differs:"
      diff "$file" "$folder/$np/new/$name" | head -n 4 | cut -c 1-300 || true
    fi
  done
  # an empty comparison must not pass
  if ((count < 60)) || [[ $(find "$folder/$np/new" -type f | wc -l) != "$count" ]]; then
    echo "gate.sh: $count files of the old build on $np ranks, and not the same ones of the new build" >&2
    exit 1
  fi
  echo "$np ranks: $count files compared"
done
if ((failed)); then
  echo "gate.sh: $failed files differ" >&2
  exit 1
fi
echo "the same to the last digit"
