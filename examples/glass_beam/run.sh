#!/usr/bin/env bash
# Runs a variant of the glass beam and analyses it. Called by examples/run.sh, which explains the
# DEFE_ variables:
#   examples/run.sh glass_beam [adaptive | dem | bpm | compare] [-np N] [LAMMPS options...]
# variants: adaptive dem bpm compare
# compare runs the three others one after the other.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# simulate VARIANT [LAMMPS options...]: LAMMPS and the analysis. Paths are relative: log files do not
# tell where the tree lies.
simulate() {
  local variant=$1 out=output/$1 script=in.glass_beam run=("$DEFE_LMP") code=0
  shift
  if [[ $variant == bpm ]]; then script=in.bpm; fi
  if ((DEFE_NP > 1)); then run=("$DEFE_MPIRUN" "$DEFE_NP" "$DEFE_LMP"); fi
  mkdir -p "$out"
  rm -f "$out"/*.png "$out"/{events,energies,screen}.txt "$out"/{log.lammps,summary.json}
  run+=(-in "$script" -log "$out/log.lammps" -var out "$out" -var variant "$variant" "$@")
  if [[ $screen == yes ]]; then
    "${run[@]}" || code=$?
  else
    "${run[@]}" >"$out/screen.txt" 2>&1 || code=$?
    if ((code)); then tail -n 20 "$out/screen.txt" >&2; fi
  fi
  if ((code)); then
    echo "glass_beam: LAMMPS failed on variant $variant (exit code $code); log in examples/glass_beam/$out" >&2
    return "$code"
  fi
  if [[ $variant == bpm ]]; then
    "$DEFE_PYTHON" analyse.py bpm "$out"
  else
    "$DEFE_PYTHON" analyse.py run "$out" "$variant"
  fi
}

screen=yes
case ${DEFE_VARIANT:=adaptive} in
  adaptive | dem | bpm)
    simulate "$DEFE_VARIANT" "$@"
    ;;
  compare)
    screen=no
    rm -f output/compare.json output/compare.png
    for variant in adaptive dem bpm; do
      echo "glass_beam: running $variant" >&2
      simulate "$variant" "$@"
    done
    "$DEFE_PYTHON" analyse.py compare output
    ;;
  *)
    echo "example 'glass_beam' has no variant '$DEFE_VARIANT': use adaptive, dem, bpm or compare" >&2
    exit 2
    ;;
esac
