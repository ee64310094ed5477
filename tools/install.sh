#!/usr/bin/env bash
# Builds DEFE for any x86-64 (see DEFE_PORTABLE) and installs it, or makes a Debian package of it.
#   tools/install.sh PREFIX [cmake options...]      such as ~/.local or /usr/local
#   tools/install.sh --deb [cmake options...]       the package is in build/portable
# The plugin fits the LAMMPS that it was built for: -D LAMMPS_SOURCE_DIR=..., -D LAMMPS_BINARY_DIR=...
set -euo pipefail
exec </dev/null
# shellcheck source=common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

case ${1:-} in
  '' | -h | --help) sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}"; [[ -n ${1:-} ]]; exit ;;
esac
to=$1
shift
"$DEFE_ROOT/tools/install-deps.sh" build
defe_build portable -- "$@"
if [[ $to == --deb ]]; then
  (cd "$DEFE_ROOT/build/portable" && cpack)
else
  cmake --install "$DEFE_ROOT/build/portable" --prefix "$(realpath -m "$to")" >/dev/null
  echo "DEFE: installed in $to; LAMMPS finds it after: eval \"\$($to/bin/defe-config --env)\"" >&2
fi
