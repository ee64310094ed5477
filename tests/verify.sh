#!/usr/bin/env bash
# Holds DEFE against published results: builds the plugin, runs cases of tests/verification/manual, prints what comes out
# beside what is published, and writes a page with all plots, build/verification/index.html.
#   tests/verify.sh [--fine] [--quick] [--list] [--page] [case...]
# --fine  finer meshes, which may take an hour (else a case takes at most 10 minutes on two cores)
# --quick without the cases that take minutes, and without the finest meshes of the others
# --list  the cases there are
# --page  also puts the cases and their plots into lammps-package/doc: those that are not named as they ran last, those that were never
#         run here as the page has them
# It fails when a figure whose source is certain is not met.
set -euo pipefail
exec </dev/null
# shellcheck source=../tools/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/../tools/common.sh"
case ${1:-} in
  -h | --help) sed -n '2,10s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
"$DEFE_ROOT/tools/install-deps.sh" build plots
defe_build_plugin
exec "$(defe_python)" "$DEFE_ROOT/tests/verification/manual/manual.py" --lmp "$DEFE_ROOT/build/release/lmp" \
  --plugin "$DEFE_ROOT/build/release" --out "$DEFE_ROOT/build/verification" "$@"
