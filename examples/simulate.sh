# shellcheck shell=bash
# Sourced by the run.sh of the examples, in the example's folder.
# shellcheck disable=SC2034  # tools is for the sourcing script
tools=${DEFE_TOOLS:-../../tools}

# fresh OUT: an output folder without what an earlier run left there.
fresh() {
  mkdir -p "$1"
  rm -f "$1"/*.{png,hdf,hdf.series,pvsm} "$1"/{events,energies,whole,screen}.txt "$1"/{log.lammps,pieces.dump,summary.json}
}

# simulate SCRIPT OUT [LAMMPS options...]: a run with its log in OUT. Paths are relative: log files do
# not tell where the tree lies. With quiet=yes the screen output is in OUT/screen.txt.
simulate() {
  local script=$1 out=$2 run=("$DEFE_LMP") code=0
  shift 2
  if ((DEFE_NP > 1)); then run=("$DEFE_MPIRUN" "$DEFE_NP" "$DEFE_LMP"); fi
  run+=(-in "$script" -log "$out/log.lammps" -var out "$out" "$@")
  if [[ ${quiet:-no} == yes ]]; then
    "${run[@]}" >"$out/screen.txt" 2>&1 || code=$?
    if ((code)); then tail -n 20 "$out/screen.txt" >&2; fi
  else
    "${run[@]}" || code=$?
  fi
  if ((code)); then
    local name=${PWD##*/}
    echo "$name: LAMMPS failed (exit code $code); log in examples/$name/$out" >&2
  fi
  return "$code"
}
