#!/usr/bin/env bash
# Writes the mesh, runs a variant of the laminated beam and analyses it. Called by examples/run.sh,
# which explains the DEFE_ variables:
#   examples/run.sh laminated_beam [laminated | mooney | monolithic | compare] [-np N] [LAMMPS options...]
# variants: laminated mooney monolithic compare
# compare runs the three others one after the other. DEFE_LAYERS=2 puts two elements through the interlayer.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# simulate VARIANT [LAMMPS options...]: mesh, LAMMPS and the analysis. Paths are relative: log files
# do not tell where the tree lies.
simulate() {
  local variant=$1 out=output/$1 run=("$DEFE_LMP") code=0 colour=5
  shift
  if [[ $variant == monolithic ]]; then colour=1; fi
  if ((DEFE_NP > 1)); then run=("$DEFE_MPIRUN" "$DEFE_NP" "$DEFE_LMP"); fi
  mkdir -p "$out"
  rm -f "$out"/*.png "$out"/{events,energies,screen}.txt "$out"/{log.lammps,summary.json}
  ../../tools/layers2data "$out/mesh.data" --layer lower 0.008 4 1 --layer inter 0.00152 "${DEFE_LAYERS:-1}" $colour \
    --layer upper 0.008 4 1 --x -0.100 1 -0.099 99 0.099 1 0.100 --z 0 5 0.010
  run+=(-in in.laminated_beam -log "$out/log.lammps" -var out "$out" -var variant "$variant" "$@")
  if [[ $screen == yes ]]; then
    "${run[@]}" || code=$?
  else
    "${run[@]}" >"$out/screen.txt" 2>&1 || code=$?
    if ((code)); then tail -n 20 "$out/screen.txt" >&2; fi
  fi
  if ((code)); then
    echo "laminated_beam: LAMMPS failed on variant $variant (exit code $code); log in examples/laminated_beam/$out" >&2
    return "$code"
  fi
  "$DEFE_PYTHON" analyse.py run "$out" "$variant"
}

screen=yes
case ${DEFE_VARIANT:=laminated} in
  laminated | mooney | monolithic)
    simulate "$DEFE_VARIANT" "$@"
    ;;
  compare)
    screen=no
    for variant in laminated mooney monolithic; do
      echo "laminated_beam: running $variant" >&2
      simulate "$variant" "$@"
    done
    "$DEFE_PYTHON" analyse.py compare output
    ;;
  *)
    echo "example 'laminated_beam' has no variant '$DEFE_VARIANT': use laminated, mooney, monolithic or compare" >&2
    exit 2
    ;;
esac
