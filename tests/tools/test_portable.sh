#!/usr/bin/env bash
# The portable plugin, built here: its loader runs on any x86-64, and each level that this machine has gives the
# events of tests/lammps/gate (a beam that cracks); and its Debian package.
#   test_portable.sh FOLDER LAMMPS_BUILD
# FOLDER is where it is built, and kept; LAMMPS_BUILD is a build folder of LAMMPS.
set -euo pipefail
exec </dev/null
build=$(realpath -m "$1") lammps=$(realpath "$2")
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "test_portable.sh: $*" >&2; exit 1; }

mkdir -p "$build"
cmake -S "$project" -B "$build" -D CMAKE_BUILD_TYPE=Release -D DEFE_PORTABLE=ON -D DEFE_TESTS=OFF \
  -D "LAMMPS_BINARY_DIR=$lammps" >"$build/log.txt" 2>&1 && cmake --build "$build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-2}" >>"$build/log.txt" 2>&1 ||
  { grep -A 8 -E 'error|Error' "$build/log.txt" | head -n 40 >&2; fail "it does not build; the log is $build/log.txt"; }
cd "$work"
lmp=$lammps/lmp plugin=$build/defeplugin.so

# --- instructions: none of AVX (its mnemonics begin with v) in loader and lowest level ---
avx() { objdump -d --no-show-raw-insn "$1" | awk '$2 ~ /^v[a-z]/ || /%[yz]mm/ { n++ } END { print n + 0 }'; }
for file in defeplugin.so defeplugin-v1.so; do
  (($(avx "$build/$file") == 0)) || fail "$file has AVX instructions"
done
(($(avx "$build/defeplugin-v3.so") > 1000)) || fail 'the level v3 has no AVX2'
objdump -d --no-show-raw-insn "$build/defeplugin-v3.so" >v3.txt
if grep -q '%zmm' v3.txt; then fail 'the level v3 has AVX-512'; fi
objdump -d --no-show-raw-insn "$build/defeplugin-v4.so" >v4.txt
grep -q '%zmm' v4.txt || fail 'the level v4 has no AVX-512'

# --- the choice ---
printf 'plugin load %s\nplugin list\n' "$plugin" >in.plugin
run() { "$project/tools/mpirun.sh" 2 "$lmp" -log none -nocite -in in.plugin >out.txt 2>&1; }
flags=" $(sed -n 's/^flags\s*: //p' /proc/cpuinfo | head -n 1) "
levels=(v1)
if [[ $flags == *' avx2 '* && $flags == *' fma '* && $flags == *' bmi2 '* ]]; then levels+=(v3); fi
if [[ $flags == *' avx512dq '* && $flags == *' avx512vl '* && $flags == *' avx512bw '* ]]; then levels+=(v4); fi
best=${levels[-1]}
run || { cat out.txt; fail 'the plugin does not load'; }
grep -q "^DEFE .* with the instructions of x86-64-$best " out.txt || { cat out.txt; fail "not the best level, $best, is taken"; }
if DEFE_LEVEL=v2 run; then fail 'a level that does not exist is taken'; fi
grep -q 'DEFE_LEVEL must be v1, v3 or v4' out.txt || { cat out.txt; fail 'the wrong level is not named'; }
# beside another plugin, whose entry has the same name and is found first
mkdir other
printf 'extern "C" void lammpsplugin_init(void *, void *, void *) {}\n' >other.cpp
c++ -shared -fPIC other.cpp -o other/otherplugin.so
printf 'plugin load other/otherplugin.so\nplugin load %s\nplugin list\n' "$plugin" >in.plugin
run && grep -q "with the instructions of x86-64-$best " out.txt || { cat out.txt; fail 'it does not load beside another plugin'; }
mkdir alone
cp "$plugin" alone
printf 'plugin load %s/alone/defeplugin.so\n' "$work" >in.plugin
if run; then fail 'a loader without its plugins loads'; fi
grep -q "defeplugin-$best.so cannot be loaded" out.txt || { cat out.txt; fail 'the missing plugin is not named'; }

# --- events, and a restart file of one level read by another ---
{ echo "plugin load $plugin"; cat "$project/tests/tools/inputs/in.gate_beam"; } >in.beam
list() { awk '!/^#/ { print $1, $3, $4, $5 }' "$1.events"; }
beam() { # LEVEL RANKS NAME LIST [LAMMPS options...]: the events of a run are the last ones of LIST
  local level=$1 ranks=$2 name=$3 expected=$project/tests/lammps/gate/$4.events
  shift 4
  rm -f "$name.events"
  DEFE_LEVEL=$level "$project/tools/mpirun.sh" "$ranks" "$lmp" -log none -nocite -in in.beam -var name "$name" "$@" >out.txt 2>&1 ||
    { tail out.txt; fail "level $level does not run $name"; }
  (($(list "$name" | wc -l) > 100)) || fail "level $level has only $(list "$name" | wc -l) events in $name"
  diff <(list "$name") <(tail -n "$(list "$name" | wc -l)" "$expected") >different.txt ||
    { head different.txt; fail "level $level has other events in $name"; }
}
for level in "${levels[@]}"; do
  beam "$level" 1 one.$level beam
  beam "$level" 2 two.$level beam -var exact yes
  beam "$level" 2 every2.$level beam.every2 -var every 2
  beam "$level" 1 planes.$level beam.planes -var law planes
  (($(list one.$level | wc -l) == $(wc -l <"$project/tests/lammps/gate/beam.events"))) || fail "level $level has too few events"
  beam "$best" 2 again.$level beam -var again yes -var from one.$level.restart
done

# --- older processors, where there is an emulator (Debian: qemu-user) ---
if command -v qemu-x86_64 >/dev/null; then
  for level in Nehalem:v1 Haswell:v3; do
    name=emulated.${level#*:}
    rm -f "$name.events"
    qemu-x86_64 -cpu "${level%:*}" "$lmp" -log none -nocite -in in.beam -var name "$name" >out.txt 2>&1 ||
      { tail out.txt; fail "it does not run on ${level%:*}"; }
    grep -q "with the instructions of x86-64-${level#*:} " out.txt || { head out.txt; fail "${level%:*} does not get level ${level#*:}"; }
    diff <(list "$name") "$project/tests/lammps/gate/beam.events" >different.txt || { head different.txt; fail "other events on ${level%:*}"; }
  done
fi

# --- Debian package: all of it, and no path of this machine ---
if command -v dpkg-shlibdeps >/dev/null; then
  (cd "$build" && rm -f defe_*.deb && cpack) >cpack.txt 2>&1 || { cat cpack.txt; fail 'no Debian package'; }
  package=("$build"/defe_*.deb)
  dpkg-deb -f "${package[0]}" >control.txt
  grep -qE '^Depends: .*libc6' control.txt && grep -qE '^Depends: .*mpi' control.txt || { cat control.txt; fail 'libraries are missing in Depends'; }
  release=$(sed -n 's/.*DEFE_LAMMPS_VERSION "\(.*\)"/\1/p' "$build/generated/defe_build_info.h")
  grep -qE "fits LAMMPS $release with|^Depends: .*lammps \(= " control.txt || { cat control.txt; fail 'the package does not say which LAMMPS it fits'; }
  dpkg-deb -x "${package[0]}" unpacked
  if grep -rqF -e "$build" -e "$project" unpacked; then
    fail "the package holds a path of this machine: $(grep -rlF -e "$build" -e "$project" unpacked | head -n 3)"
  fi
  eval "$(unpacked/usr/bin/defe-config --env)"
  printf 'plugin list\n' >in.list
  "$lmp" -log none -in in.list >out.txt 2>&1
  grep -q 'fix style plugin defe$' out.txt || { cat out.txt; fail 'LAMMPS does not find the plugin of the package'; }
  grep -q Gmsh <<<"$(unpacked/usr/bin/mesh2data --help)" || fail 'mesh2data of the package does not run'
  # a program with other instructions than the library has
  cmake -S "$project/tests/install" -B user -D "CMAKE_PREFIX_PATH=$PWD/unpacked/usr" -D CMAKE_CXX_FLAGS=-march=native >user.txt 2>&1 &&
    cmake --build user >>user.txt 2>&1 && user/bar || { cat user.txt; fail 'find_package(DEFE) of the package does not work'; }
fi
