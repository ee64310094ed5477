#!/usr/bin/env bash
# Strength, fracture energy, path, branching and speed of cracks in lattices of every orientation, by the law of
# fronts and by the paper's (lattice): builds the plugin, runs LAMMPS some 150 times (5 minutes), prints tables and draws
# the pictures of lammps-package/doc/Howto_defe_cracks.rst.
#   tests/verification/cracks/run.sh [--page] [part...]
# parts   strength paths branching; all without
# --page  also puts tables and pictures into lammps-package/doc
set -euo pipefail
exec </dev/null
# shellcheck source=../../../tools/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/../../../tools/common.sh"
case ${1:-} in
  -h | --help) sed -n '2,7s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
"$DEFE_ROOT/tools/install-deps.sh" build plots
defe_build_plugin
exec "$(defe_python)" "$DEFE_ROOT/tests/verification/cracks/run.py" --lmp "$DEFE_ROOT/build/release/lmp" --plugin "$DEFE_ROOT/build/release" "$@"
