#!/usr/bin/env bash
# Installs what is missing, builds the plugin, and runs an example.
#   examples/run.sh NAME [variant] [-np N] [LAMMPS options...]
# -np N  on N MPI ranks
#
# Runs in examples/NAME; results go to examples/NAME/output/VARIANT. The script is in.VARIANT, else
# in.NAME, which finds the variables `out` (the output folder) and `variant`.
# An example with a run.sh of its own is handed over to that, with these in its environment:
#   DEFE_LMP        the lmp program         DEFE_PLUGIN   path of defeplugin.so
#   DEFE_MPIRUN     launcher: "$DEFE_MPIRUN" N program ...      DEFE_NP  number of ranks
#   DEFE_VARIANT    variant, empty if none was given
#   DEFE_OUT_ROOT   examples/NAME/output    DEFE_OUT      the folder of the variant in it
#   DEFE_PYTHON     a Python with numpy, matplotlib and PIL
#   DEFE_TOOLS      the folder of mesh2data and layers2data
#   LD_LIBRARY_PATH such that `plugin load defeplugin.so` needs no path
# and the LAMMPS options as arguments.
#
# A copy of the examples of an installed DEFE (cp -r "$(defe-config --examples)" FOLDER) builds nothing: it
# takes plugin, tools and LAMMPS from defe-config.
set -euo pipefail
exec </dev/null
examples=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
installed=no
DEFE_TOOLS=$examples/../tools
if [[ ! -f $examples/../CMakeLists.txt ]]; then
  installed=yes
  DEFE_TOOLS=$(defe-config --tools) || {
    echo 'examples/run.sh: no defe-config in PATH: add the bin folder of the installed DEFE to it' >&2
    exit 2
  }
fi
export DEFE_TOOLS
# shellcheck source=../tools/common.sh
source "$DEFE_TOOLS/common.sh"

list() {
  echo 'usage: examples/run.sh NAME [variant] [-np N] [LAMMPS options...]'
  echo 'examples (variants):'
  local folder script name variants
  for folder in "$examples"/*/; do
    name=$(basename "$folder")
    variants=''
    if [[ -f $folder/run.sh ]]; then
      # its own run.sh names them in a line "# variants: A B ..."
      variants=$(sed -n 's/^# variants://p' "$folder/run.sh" | head -n 1)
      echo "  $name${variants:+ ($(sed 's/^ //; s/ /, /g' <<<"$variants"))}"
      continue
    fi
    for script in "$folder"in.*; do
      if [[ -f $script && $script != *~ ]]; then variants+=" ${script##*/in.}"; fi
    done
    if [[ -n $variants ]]; then echo "  $name${variants:+ ($(sed 's/^ //; s/ /, /g' <<<"$variants"))}"; fi
  done
}

case ${1:-} in
  '' | -h | --help) list; [[ -n ${1:-} ]]; exit ;;
esac
name=${1%/}
shift
example=$examples/$name
if [[ $name == */* || ! -d $example ]]; then
  echo "no example '$name'" >&2
  list >&2
  exit 2
fi

variant='' np=1 options=()
if (($#)) && [[ $1 != -* ]]; then
  variant=$1
  shift
fi
while (($#)); do
  case $1 in
    -np)
      [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || { echo '-np needs a number of ranks' >&2; exit 2; }
      np=$2
      shift 2 ;;
    *)
      options+=("$1")
      shift ;;
  esac
done

if [[ $installed == yes ]]; then
  "$DEFE_TOOLS/install-deps.sh" plots
  DEFE_LMP=$(defe-config --lmp)
  plugins=$(defe-config --plugins)
  unset LAMMPS_PLUGIN_PATH # the scripts load it themselves
else
  "$DEFE_TOOLS/install-deps.sh" build plots
  defe_build_plugin
  plugins=$DEFE_ROOT/build/release
  DEFE_LMP=$plugins/lmp
fi

export DEFE_LMP
export DEFE_PLUGIN=$plugins/defeplugin.so
export DEFE_MPIRUN=$DEFE_TOOLS/mpirun.sh
export DEFE_NP=$np
export DEFE_VARIANT=$variant
export DEFE_OUT_ROOT=$example/output
export DEFE_OUT=$DEFE_OUT_ROOT${variant:+/$variant}
DEFE_PYTHON=$(defe_python)
export DEFE_PYTHON
export PYTHONPATH=$DEFE_TOOLS/../python${PYTHONPATH:+:$PYTHONPATH} # for copies of installed examples
export LD_LIBRARY_PATH=$plugins${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
mkdir -p "$DEFE_OUT" 2>/dev/null || {
  echo "examples/run.sh: no right to write $DEFE_OUT: copy the folder $examples and run its run.sh" >&2
  exit 1
}
cd "$example"

if [[ -f run.sh ]]; then exec bash run.sh "${options[@]}"; fi

variant=${variant:-$name}
if [[ -f in.$variant ]]; then
  script=in.$variant
elif [[ -f in.$name ]]; then
  script=in.$name
else
  echo "example '$name' has no variant '$variant'" >&2
  list >&2
  exit 2
fi
# A relative path: log files do not tell where the tree lies.
out=output/$variant
mkdir -p "$out"
run=("$DEFE_LMP")
if ((np > 1)); then run=("$DEFE_MPIRUN" "$np" "$DEFE_LMP"); fi
exec "${run[@]}" -in "$script" -log "$out/log.lammps" -var out "$out" -var variant "$variant" "${options[@]}"
