#!/usr/bin/env bash
# Finds or builds the LAMMPS host of DEFE; called by cmake/Lammps.cmake.
#
#   get-lammps.sh --result FILE [--release 4Feb2025] [--source DIR] [--cxx COMPILER]
#                 [--mpicxx WRAPPER] [--mpi-id TEXT] [--sha256 HASH] [--jobs N]
#
# Writes to FILE two lines, source=DIR and build=DIR. LAMMPS lives in a cache
# outside the project tree, keyed by release, options, compiler and MPI:
#   ${DEFE_CACHE_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/defe}
# An interrupted build has no stamp and is started afresh.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

say() { printf 'DEFE: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

result='' release=4Feb2025 source_dir='' cxx=c++ mpicxx='' mpi_id='' upstream_sha=''
# GNU nproc would answer with OMP_NUM_THREADS, which the run scripts set to 1.
jobs=$(env -u OMP_NUM_THREADS -u OMP_THREAD_LIMIT nproc 2>/dev/null || echo 2)
while (($#)); do
  (($# > 1)) || die "get-lammps.sh: no value for $1"
  case $1 in
    --result) result=$2 ;;
    --release) release=$2 ;;
    --source) source_dir=$2 ;;
    --cxx) cxx=$2 ;;
    --mpicxx) mpicxx=$2 ;;
    --mpi-id) mpi_id=$2 ;;
    --sha256) upstream_sha=$2 ;;
    --jobs) jobs=$2 ;;
    *) die "get-lammps.sh: unknown argument $1" ;;
  esac
  shift 2
done
[[ -n $result ]] || die 'get-lammps.sh: --result FILE is needed'
command -v "$cxx" >/dev/null || die "get-lammps.sh: no compiler '$cxx'"

# The releases DEFE knows: where Debian has the source, and the checksum of that tarball.
packages=(GRANULAR RIGID MOLECULE BPM EXTRA-FIX EXTRA-COMPUTE EXTRA-DUMP PLUGIN)
case $release in
  4Feb2025)
    suite=trixie debian_version=20250204+dfsg.1-2
    debian_sha=3671165bd52fad36734e0a9136c5bc5ecb225e03988f8c89aa13366a8b53b1c7 ;;
  4Jul2026)
    suite=forky debian_version=20260704+dfsg-2
    debian_sha=cddbc45a047416bd48a4a0b87f24a5b61b3446982b74d18cafe619c22b17eb62 ;;
  *)
    [[ -n $source_dir ]] || die "LAMMPS release '$release' is not known; give your own tree with -D LAMMPS_SOURCE_DIR=..." ;;
esac

options=(
  -D CMAKE_BUILD_TYPE=Release -D BUILD_SHARED_LIBS=ON -D BUILD_MPI=ON -D BUILD_OMP=OFF
  -D BUILD_TOOLS=OFF -D BUILD_DOC=OFF -D LAMMPS_SIZES=smallbig
  -D WITH_PNG=ON -D WITH_JPEG=OFF -D WITH_GZIP=ON -D WITH_FFMPEG=OFF -D WITH_CURL=OFF
  -D CMAKE_EXPORT_COMPILE_COMMANDS=ON
)
for p in "${packages[@]}"; do options+=(-D "PKG_$p=ON"); done

cache=${DEFE_CACHE_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/defe}
# One lock for each release, and for all trees of one's own: builds of different ones do not wait for each other.
lock=lammps-$release.lock
if [[ -n $source_dir ]]; then lock=lammps-own.lock; fi
{ mkdir -p "$cache" && : >>"$cache/$lock"; } 2>/dev/null ||
  die "no right to write into the folder $cache, where LAMMPS is kept: make it writable, or name another one in DEFE_CACHE_DIR"
cache=$(cd "$cache" && pwd)

# Two configures at the same time: the second waits and then finds the build.
if command -v flock >/dev/null; then
  exec 9>"$cache/$lock"
  if ! flock -n 9; then
    say "waiting for another build of LAMMPS (${lock%.lock})"
    flock 9
  fi
fi

# --- source ---------------------------------------------------------------

# Address of the machine's own Debian mirror, as apt is set up here. The second way is for
# machines without package lists (fresh containers).
# shellcheck disable=SC2016  # the parentheses are apt's
debian_mirror() {
  grep -qx 'ID=debian' /etc/os-release 2>/dev/null || return 1
  {
    apt-get indextargets --format '$(REPO_URI) $(RELEASE)' 'Created-By: Packages'
    apt-get update --print-uris | sed -n "s|^'\\(.*/\\)dists/\\([^/']*\\)/InRelease'.*|\\1 \\2|p"
  } 2>/dev/null | awk '$2 !~ /security|updates|backports/ && $1 !~ /security/ && !found { print $1; found = 1 } END { exit !found }'
}

fetch_debian() { # into directory $1
  local keyring=/usr/share/keyrings/debian-archive-keyring.gpg mirror apt_dir=$1/apt
  command -v apt-get >/dev/null && [[ -r $keyring ]] || return 1
  mirror=$(debian_mirror) || return 1
  mkdir -p "$apt_dir/lists/partial" "$apt_dir/cache/archives/partial"
  # A source list of its own: the system's lists stay as they are, and no root is needed.
  printf 'deb-src [signed-by=%s] %s %s main\n' "$keyring" "$mirror" "$suite" >"$apt_dir/sources.list"
  local apt=(apt-get -qq -o "Dir::Etc::sourcelist=$apt_dir/sources.list" -o Dir::Etc::sourceparts=/dev/null
    -o "Dir::State::lists=$apt_dir/lists" -o "Dir::Cache=$apt_dir/cache" -o Acquire::Languages=none)
  if ((EUID == 0)); then apt+=(-o APT::Sandbox::User=root); fi
  "${apt[@]}" update >"$1/apt.log" 2>&1 || return 1
  (cd "$1" && "${apt[@]}" source --download-only --tar-only "lammps=$debian_version") >>"$1/apt.log" 2>&1 || return 1
  local found=("$1"/lammps_*.orig.tar.*)
  [[ -f ${found[0]} ]] || return 1
  echo "$debian_sha  ${found[0]}" | sha256sum --check --status ||
    die "The LAMMPS source from Debian has another checksum than expected; not used"
  mv "${found[0]}" "$1/tarball"
}

fetch_upstream() { # into directory $1
  local url=https://github.com/lammps/lammps/archive/refs/tags/patch_$release.tar.gz
  cmake -D "URL=$url" -D "FILE=$1/tarball" -D "SHA256=$upstream_sha" -P "$here/download.cmake" >&2
}

if [[ -n $source_dir ]]; then
  [[ -d $source_dir ]] || die "no folder $source_dir"
  source_dir=$(cd "$source_dir" && pwd)
  if [[ -f $source_dir/version.h ]]; then source_dir=$(dirname "$source_dir"); fi # its src was given
  own_tree=1
else
  own_tree=0
  source_dir=$cache/lammps-$release-source
  if [[ ! -f $source_dir/src/version.h ]]; then
    work=$(mktemp -d "$cache/fetch.XXXXXX")
    trap 'rm -rf "$work"' EXIT
    say "fetching the source of LAMMPS $release"
    fetch_debian "$work" || fetch_upstream "$work" ||
      die "The source of LAMMPS $release cannot be fetched; give your own tree with -D LAMMPS_SOURCE_DIR=..."
    mkdir "$work/tree"
    tar -xf "$work/tarball" -C "$work/tree"
    tree=$work/tree
    if [[ ! -f $tree/src/version.h ]]; then tree=$(echo "$work"/tree/*); fi # one folder that holds it all
    [[ -f $tree/src/version.h ]] || die "The tarball of LAMMPS $release holds no LAMMPS source"
    rm -rf "$source_dir"
    mv "$tree" "$source_dir" # whole or not at all
    rm -rf "$work"
    trap - EXIT
  fi
fi
if [[ ! -f $source_dir/src/version.h || ! -f $source_dir/cmake/CMakeLists.txt ]]; then
  if ((own_tree)); then die "$source_dir is no LAMMPS source tree (no src/version.h or cmake/CMakeLists.txt)"; fi
  die "the cached source of LAMMPS is broken (no cmake/CMakeLists.txt): delete the folder $source_dir and start again"
fi

# --- build ----------------------------------------------------------------

# Packages that other releases have and this one does not (or the reverse).
if [[ -d $source_dir/src/GRAPHICS ]]; then options+=(-D PKG_GRAPHICS=ON); fi # dump image moved there in 2026

version=$(sed -n 's/.*LAMMPS_VERSION *"\([^"]*\)".*/\1/p' "$source_dir/src/version.h" | tr -d ' ')
key=("${options[@]}" "$("$cxx" --version | head -n 1)" "$("$cxx" -dumpmachine)" "$mpi_id")
if ((own_tree)); then key+=("$source_dir"); fi
hash=$(printf '%s\n' "${key[@]}" | sha256sum | cut -c 1-12)
base=$cache/lammps-$version-$hash
build=$base/build
stamp=$base/complete

# Somebody's own tree may have changed since: its build is brought up to date every time.
if [[ ! -f $stamp ]] || ((own_tree)); then
  log=$base/build.log
  if [[ ! -f $stamp ]]; then
    rm -rf "$base"
    mkdir -p "$build"
    say "building LAMMPS $version once, in $base (some 7 minutes of processor time, $jobs at a time)"
    printf '%s\n' "${key[@]}" >"$base/key.txt"
    generator=()
    if command -v ninja >/dev/null; then generator=(-G Ninja); fi
    mpi=()
    if [[ -n $mpicxx ]]; then mpi=(-D "MPI_CXX_COMPILER=$mpicxx"); fi
    cmake -S "$source_dir/cmake" -B "$build" "${generator[@]}" "${options[@]}" \
      -D "CMAKE_CXX_COMPILER=$cxx" "${mpi[@]}" >"$log" 2>&1 </dev/null || {
      tail -n 30 "$log" >&2
      die "LAMMPS cannot be configured; the whole log is $log"
    }
  fi
  # One line of progress per tenth of the build, the rest into the log.
  cmake --build "$build" --parallel "$jobs" 2>&1 </dev/null | tee -a "$log" |
    awk -v what=LAMMPS -f "$here/progress.awk" >&2 || {
    grep -E -A 5 'error|FAILED' "$log" | tail -n 30 >&2
    die "LAMMPS cannot be built; the whole log is $log"
  }
  touch "$stamp"
fi

for file in lmp compile_commands.json CMakeCache.txt; do
  [[ -e $build/$file ]] ||
    die "the cached build of LAMMPS is broken (no $file): delete the folder $base and start again"
done
printf 'source=%s\nbuild=%s\n' "$source_dir" "$build" >"$result"
