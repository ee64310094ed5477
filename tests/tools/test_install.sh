#!/usr/bin/env bash
# What `cmake --install` writes, used as a user does: LAMMPS finds the plugin by itself, find_package(DEFE) finds
# the libraries, mesh tools and examples run from other folders; uninstall leaves nothing.
#   test_install.sh BUILD_FOLDER
# In the environment: DEFE_CXX, the compiler; DEFE_PLUGIN_OTHER, a plugin for another LAMMPS; DEFE_PYTHON, one
# with the modules for plots, or empty (no example then).
set -euo pipefail
exec </dev/null
build=$(realpath "$1")
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
# what somebody has installed from this build folder stays known to its `uninstall`
manifest=$build/install_manifest.txt
if [[ -f $manifest ]]; then cp "$manifest" "$work/manifest"; fi
trap 'if [[ -f $work/manifest ]]; then cp "$work/manifest" "$manifest"; else rm -f "$manifest"; fi; rm -rf "$work"' EXIT
# a prefix with a space, and not the one of the configuration: nothing may hold its path
prefix="$work/the prefix"
fail() { echo "test_install.sh: $*" >&2; exit 1; }

mkdir -p "$prefix/bin"
touch "$prefix/bin/of_somebody_else"
cmake --install "$build" --prefix "$prefix" >"$work/install.log" || { cat "$work/install.log" >&2; exit 1; }
unset PYTHONDONTWRITEBYTECODE LAMMPS_PLUGIN_PATH LD_LIBRARY_PATH DEFE_LMP DEFE_PLUGIN DEFE_TOOLS
eval "$("$prefix/bin/defe-config" --env)"
lmp=$(defe-config --lmp)
cd "$work"

# --- LAMMPS ---
cat >in.plugin <<'END'
plugin list
plugin load defeplugin.so
plugin list
clear
plugin list
END
LD_LIBRARY_PATH=$(defe-config --plugins) "$lmp" -log none -in in.plugin >lammps.txt 2>&1 || { cat lammps.txt; exit 1; }
(($(grep -c 'fix style plugin defe$' lammps.txt) == 3)) || { cat lammps.txt; fail 'LAMMPS does not find the plugin by itself'; }
grep -q 'DEFE is there already' lammps.txt || { cat lammps.txt; fail 'a second load is not told of'; }
if grep -qE 'Ignoring load|failed' lammps.txt; then cat lammps.txt; fail 'loading is noisy'; fi
# of another LAMMPS: scripts run without it
mkdir other
cp "$DEFE_PLUGIN_OTHER" other/otherplugin.so
echo 'print "it runs"' >in.without
LAMMPS_PLUGIN_PATH=$work/other "$lmp" -log none -in in.without >other.txt 2>&1 || { cat other.txt; fail 'a plugin of another LAMMPS stops all scripts'; }
grep -q '^DEFE is left out. This defeplugin.so was built for LAMMPS 1 Jan 2001' other.txt && grep -q '^it runs' other.txt ||
  { cat other.txt; fail 'a plugin of another LAMMPS is not told of'; }

# --- libraries ---
cmake -S "$project/tests/install" -B user -D "CMAKE_PREFIX_PATH=$prefix" -D CMAKE_BUILD_TYPE=Release \
  ${DEFE_CXX:+-D "CMAKE_CXX_COMPILER=$DEFE_CXX"} >user.log 2>&1 && cmake --build user >>user.log 2>&1 ||
  { cat user.log; fail 'a project with find_package(DEFE) does not build'; }
user/bar || fail 'the installed libraries calculate something else'

# --- tools, pages, examples ---
layers2data two.data --layer lower 0.002 2 1 --layer upper 0.002 2 1 --x 0 2 0.004 --z 0 2 0.004 >/dev/null
[[ -s two.data ]] || fail 'layers2data writes nothing'
grep -q Gmsh <<<"$(mesh2data --help)" || fail 'mesh2data does not run'
grep -q '^elements2stl: ' <<<"$(elements2stl of_no_run 2>&1)" || fail 'elements2stl does not run'
if [[ -n ${DEFE_PYTHON:-} ]]; then
  "$DEFE_PYTHON" -c 'import defe; print(defe.host.plugin_path())' | grep -qF "$prefix" || fail 'Python does not find the package defe, or the plugin'
  "$DEFE_PYTHON" -c 'import defe; print(defe.start("-screen", "none", "-log", "none").has_style("pair", "defe/joint"))' >start.txt 2>&1 || :
  grep -q '^True' start.txt || { cat start.txt; fail 'LAMMPS does not run from Python'; }
fi
[[ -f $(defe-config --doc)/fix_defe.rst ]] || fail 'no pages'
cp -r "$(defe-config --examples)" examples
grep -q glass_beam <<<"$(examples/run.sh --help)" || fail 'the examples are not listed'
if [[ -n ${DEFE_PYTHON:-} ]]; then
  examples/run.sh laminated_beam monolithic -var end 1.2e-5 -var pictures no >example.txt 2>&1 || { cat example.txt; fail 'an example does not run'; }
  grep -q 'DEFE' examples/laminated_beam/output/monolithic/log.lammps || fail 'the example has no log'
fi
# without PATH it is told what is missing
if PATH=/usr/bin:/bin examples/run.sh glass_beam >none.txt 2>&1; then fail 'an example runs without defe-config'; fi
grep -q 'no defe-config in PATH' none.txt || { cat none.txt; fail 'what is missing is not named'; }

# a package for other machines has no link to the lmp of this one
mv "$prefix/share/defe/lmp" here
if PATH=$prefix/bin:/usr/bin:/bin defe-config --lmp >none.txt 2>&1 && ! [[ -x $(cat none.txt) ]]; then fail 'an lmp is named that is not there'; fi
mkdir with_lmp
ln -s "$lmp" with_lmp/lmp
[[ $(PATH=$work/with_lmp:$PATH defe-config --lmp) == "$work/with_lmp/lmp" ]] || fail 'lmp in PATH is not found'
mv here "$prefix/share/defe/lmp"

# --- package: of a portable build only ---
if ! grep -q '^DEFE_PORTABLE:BOOL=ON' "$build/CMakeCache.txt"; then
  if (cd "$work" && cpack --config "$build/CPackConfig.cmake") >cpack.txt 2>&1; then fail 'a plugin for this processor alone is packed'; fi
  tr -s ' \n' ' ' <cpack.txt | grep -q 'tools/install.sh --deb' || { cat cpack.txt; fail 'the remedy is not named'; }
fi

# --- uninstall ---
cmake --build "$build" --target uninstall >uninstall.log 2>&1 || { cat uninstall.log; exit 1; }
left=$(cd "$prefix" && find . -not -type d -o -name defe -o -name DEFE -o -name lammps)
[[ $left == ./bin/of_somebody_else ]] || fail "uninstall leaves $left"
if cmake --build "$build" --target uninstall >uninstall.log 2>&1; then fail 'a second uninstall finds something'; fi
grep -q 'Nothing to uninstall' uninstall.log || { cat uninstall.log; exit 1; }
