#!/usr/bin/env bash
# Installs the Debian packages that DEFE needs and this machine lacks.
#   install-deps.sh [build] [tests] [plots] [meshes] [benchmarks] [fuzz] [valgrind] [docs] [vtk]
# Without arguments: the first five.
# Where it cannot install, it says what is needed and goes on: things may be there under other names.
set -euo pipefail

if (($# == 0)); then set -- build tests plots meshes benchmarks; fi
packages=()
for group; do
  case $group in
    build)
      packages+=(g++ ccache cmake ninja-build libopenmpi-dev openmpi-bin libeigen3-dev
        libhdf5-openmpi-dev libpng-dev zlib1g-dev dpkg-dev xz-utils ca-certificates) ;;
    tests) packages+=(libgtest-dev libgmock-dev) ;;
    plots) packages+=(python3 python3-numpy python3-matplotlib python3-pil) ;;
    meshes) packages+=(python3 python3-numpy python3-meshio python3-gmsh python3-netcdf4 python3-h5py) ;;
    benchmarks) packages+=(libbenchmark-dev linux-perf python3) ;;
    fuzz) packages+=(clang libclang-rt-dev) ;;
    valgrind) packages+=(valgrind libc6-dbg) ;;
    docs) packages+=(python3-sphinx python3-sphinx-rtd-theme python3-myst-parser libjs-mathjax fonts-mathjax) ;;
    vtk)
      packages+=(python3 python3-numpy xvfb libgl1-mesa-dri)
      # ParaView's Python has VTK as well, and would be removed
      # shellcheck disable=SC2016  # the braces are dpkg-query's
      if [[ $(dpkg-query -W -f '${db:Status-Status}' python3-paraview 2>/dev/null) != installed ]]; then
        packages+=(python3-vtk9)
      fi ;;
    *) echo "install-deps.sh: unknown group $group (build, tests, plots, meshes, benchmarks, fuzz, valgrind, docs, vtk)" >&2; exit 2 ;;
  esac
done

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  for program in c++ cmake mpirun; do
    command -v "$program" >/dev/null || missing=1
  done
  if [[ -n ${missing:-} ]]; then
    echo "DEFE: not a Debian system; needed are what Debian calls: ${packages[*]}" >&2
  fi
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  # shellcheck disable=SC2016  # the braces are dpkg-query's
  [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then exit 0; fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "DEFE: please install, as root: apt-get install ${missing[*]}" >&2
    exit 0
  fi
  as_root=(sudo)
fi
echo "DEFE: installing Debian packages: ${missing[*]}" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300)
if ! { "${apt[@]}" update && "${apt[@]}" install --no-install-recommends "${missing[@]}"; } >"$log" 2>&1 </dev/null; then
  tail -n 15 "$log" >&2
  echo 'DEFE: the packages above could not be installed; trying without' >&2
fi
