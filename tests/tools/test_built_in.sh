#!/usr/bin/env bash
# LAMMPS with DEFE in it: a tree that tools/into-lammps made, built with few packages. It lists the styles, runs a
# beam that cracks with the events of tests/lammps/gate, asks for citations, and leaves the plugin out.
#   test_built_in.sh LAMMPS_SOURCE PLUGIN FOLDER
# FOLDER is where the tree is built, and kept.
set -euo pipefail
exec </dev/null
source=$(realpath "$1") plugin=$(realpath "$2") folder=$(realpath -m "$3")
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
fail() { echo "test_built_in.sh: $*" >&2; exit 1; }

# the tree stays with its build: the second time only what changed is built
mkdir -p "$folder/tree"
for part in src cmake lib doc examples; do
  if [[ ! -d $folder/tree/$part ]]; then cp -a "$source/$part" "$folder/tree"; fi
done
"$project/tools/into-lammps" "$folder/tree"
cmake -S "$folder/tree/cmake" -B "$folder/build" -D CMAKE_BUILD_TYPE=Release -D BUILD_OMP=OFF -D WITH_JPEG=OFF \
  -D WITH_CURL=OFF -D BUILD_SHARED_LIBS=ON -D PKG_RIGID=ON -D PKG_GRANULAR=ON -D PKG_PLUGIN=ON -D PKG_DEFE=ON >"$folder/log.txt" 2>&1 &&
  cmake --build "$folder/build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-2}" --target lmp >>"$folder/log.txt" 2>&1 ||
  { grep -A 8 -E 'error|Error' "$folder/log.txt" | head -n 40 >&2; fail "LAMMPS with DEFE does not build; the log is $folder/log.txt"; }
built=$folder/build/lmp
cd "$folder"

"$built" -h >help.txt
while read -r style; do
  grep -qE "(^| )$style( |\$)" help.txt || fail "lmp -h does not list $style"
done < <(sed -nE 's/^(Fix|Compute|Pair)Style\(([^,]+),.*/\2/p' "$project"/lammps-package/src/*.h)
grep -qE '(^| )DEFE( |$)' help.txt || fail 'lmp -h does not list the package'

beam=$project/tests/tools/inputs/in.gate_beam
{ echo "plugin load $plugin"; cat "$beam"; } >in.plugin
run() { # NAME COMMAND...
  local name=$1
  shift
  rm -f "$name.events"
  "$@" -log none -var name "$name" >"$name.txt" 2>&1 || { tail -n 20 "$name.txt" >&2; fail "the beam does not run ($name)"; }
}
list() { awk '!/^#/ { print $1, $3, $4, $5 }' "$1.events"; }
run built "$built" -in "$beam" -cite built.bib
run both "$built" -in in.plugin -nocite
run two "$project/tools/mpirun.sh" 2 "$built" -in "$beam" -nocite
for name in built both two; do
  diff <(list $name) "$project/tests/lammps/gate/beam.events" >different.txt ||
    { head different.txt; fail "$name has other events than the plugin"; }
done
grep -q '^DEFE is there already' both.txt || fail 'a plugin changes the LAMMPS that holds DEFE'
grep -q 'Lei2010' built.bib || fail 'nothing is asked to be cited'
