# shellcheck shell=bash
# Sourced by the run scripts: where things are, and how to configure and build.
# shellcheck disable=SC2034  # DEFE_ROOT is for the sourcing script
DEFE_ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}"

# Cores of this machine. GNU nproc obeys OMP_NUM_THREADS, which is about threads per rank, not about builds.
defe_cores() {
  env -u OMP_NUM_THREADS -u OMP_THREAD_LIMIT nproc 2>/dev/null || getconf _NPROCESSORS_ONLN 2>/dev/null || echo 1
}

# What was compiled for this processor once is not compiled again, in another clone or after a look at another commit:
# objects are kept by ccache, where LAMMPS is kept, too. Where the user has a launcher or a ccache of his own, that is used.
defe_compiler_cache() {
  if [[ -n ${CMAKE_CXX_COMPILER_LAUNCHER:-} ]] || ! command -v ccache >/dev/null; then return; fi
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
  if [[ -n ${CCACHE_DIR:-} ]]; then return; fi
  export CCACHE_DIR=${DEFE_CACHE_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/defe}/ccache
  export CCACHE_MAXSIZE=1G CCACHE_BASEDIR=$DEFE_ROOT CCACHE_NOHASHDIR=1
  # precompiled headers are found by what they hold, not by when they were written
  export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
  # -march=native is not the same on all machines that may share a folder
  CCACHE_NAMESPACE=$("${CXX:-c++}" -march=native -Q --help=target 2>/dev/null | cksum | cut -d ' ' -f 1)
  export CCACHE_NAMESPACE
}

# defe_build PRESET [target] -- [cmake options]: configures and builds into build/PRESET, or build/$DEFE_FOLDER.
# Says what it does and how far it is; everything else goes into a log, of which a failure shows the end.
defe_build() {
  local preset=$1 folder=build/${DEFE_FOLDER:-$1} target=() what log jobs start
  shift
  what='plugin and tests'
  if [[ $1 != -- ]]; then
    target=(--target "$1")
    what=$1
    shift
  fi
  shift
  if [[ $what == defeplugin ]]; then what=plugin; fi
  log=$DEFE_ROOT/$folder/build.log
  # A new log at once: one of an earlier build would be shown if nothing can be written.
  if ! { mkdir -p "$DEFE_ROOT/$folder" && : >"$log"; } 2>/dev/null; then
    echo "DEFE: no right to write $log: make that folder writable, or work in a copy of this checkout" >&2
    return 1
  fi
  jobs=$(defe_cores)
  start=$SECONDS
  defe_compiler_cache

  local generator=()
  # An existing build keeps its generator.
  if [[ ! -f $DEFE_ROOT/$folder/CMakeCache.txt ]] && command -v ninja >/dev/null; then generator=(-G Ninja); fi
  echo "DEFE: configuring $folder" >&2
  # The progress of building LAMMPS comes on stderr in lines that begin with DEFE: they are shown.
  if ! (
    set -o pipefail
    cd "$DEFE_ROOT"
    cmake --preset "$preset" -B "$folder" "${generator[@]}" "$@" </dev/null 2>&1 |
      tee "$log" | { grep --line-buffered '^DEFE:' || true; } >&2
  ); then
    tail -n 40 "$log" >&2
    echo "DEFE: configuring failed; the whole log is $folder/build.log" >&2
    return 1
  fi
  echo "DEFE: building $what in $folder, $jobs files at a time" >&2
  if ! (
    set -o pipefail
    cmake --build "$DEFE_ROOT/$folder" --parallel "$jobs" "${target[@]}" 2>&1 </dev/null |
      tee -a "$log" | awk -v what="$what" -f "$DEFE_ROOT/cmake/progress.awk" >&2
  ); then
    { grep -E -A 8 'error:|FAILED:|undefined reference|\*\*\*' "$log" || tail -n 40 "$log"; } | head -n 120 >&2
    echo "DEFE: the build failed; the whole log is $folder/build.log" >&2
    return 1
  fi
  echo "DEFE: built in $((SECONDS - start)) s" >&2
  grep -E 'warning:' "$log" | sort -u | head -n 20 >&2 || true
}

# defe_build_plugin: the plugin alone. A new build/release gets by without the tests; an existing one stays as it is.
defe_build_plugin() {
  local configure=()
  if [[ ! -f $DEFE_ROOT/build/release/CMakeCache.txt ]]; then configure=(-D DEFE_TESTS=OFF); fi
  defe_build release defeplugin -- "${configure[@]}"
}

# The first Python that has what the plots need (a python3 in PATH may not be Debian's).
defe_python() {
  local python
  for python in ${DEFE_PYTHON:+"$DEFE_PYTHON"} python3 /usr/bin/python3; do
    if "$python" -c 'import numpy, matplotlib, PIL' >/dev/null 2>&1 </dev/null; then
      echo "$python"
      return
    fi
  done
  echo python3
}
