#!/usr/bin/env bash
# Builds all pages as one site: open build/docs/index.html, or FOLDER/index.html.
#   tools/docs.sh [FOLDER] [--external]
# --external  also asks the web for every address that a page links to
# Sources stay where they are: pages of lammps-package/doc, README.md files, CHANGELOG.md; front page and gallery are in
# tools/docs. Warnings are errors: a link into nowhere, a page or picture that is missing, wrong markup. Pages of LAMMPS
# are linked to docs.lammps.org, and must be in its source if that is in the cache. Formulas are drawn by Debian's MathJax,
# which is copied into the site: nothing is fetched.
set -euo pipefail
exec </dev/null
# shellcheck source=common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

folder='' external=''
for arg; do
  case $arg in
    --external) external=1 ;;
    -h | --help) sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "docs.sh: unknown option $arg (--external)" >&2; exit 2 ;;
    *)
      if [[ -n $folder ]]; then echo 'docs.sh: one folder at most' >&2; exit 2; fi
      folder=$arg ;;
  esac
done
work=$DEFE_ROOT/build/docs-work
folder=${folder:-$DEFE_ROOT/build/docs}
# Sphinx adds to a folder and leaves there what it finds.
if [[ -e $folder && ! -f $folder/objects.inv && -n $(ls -A "$folder" 2>&1) ]]; then
  echo "docs.sh: $folder holds something that is no site: name an empty folder or a new one" >&2
  exit 2
fi

"$DEFE_ROOT/tools/install-deps.sh" docs
python=''
for try in ${DEFE_PYTHON:+"$DEFE_PYTHON"} python3 /usr/bin/python3; do
  if "$try" -c 'import sphinx, sphinx_rtd_theme, myst_parser' >/dev/null 2>&1; then python=$try; break; fi
done
if [[ -z $python || ! -f ${DEFE_MATHJAX:=/usr/share/javascript/mathjax}/MathJax.js ]]; then
  echo 'DEFE: the site needs Sphinx, its theme sphinx_rtd_theme, myst_parser and MathJax 2: as root,' \
    'apt-get install python3-sphinx python3-sphinx-rtd-theme python3-myst-parser libjs-mathjax fonts-mathjax' >&2
  exit 1
fi
export DEFE_MATHJAX
# The pages of LAMMPS that there are, if its source is at hand (cmake/get-lammps.sh).
for pages in "${DEFE_CACHE_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/defe}"/lammps-*-source/doc/src; do
  if [[ -d $pages ]]; then export DEFE_LAMMPS_DOC=$pages; fi
done

# A tree of links, in which the front page is at the top and all paths between pages are as in the repository.
rm -rf "$work/source"
mkdir -p "$work/source"
ln -s "$DEFE_ROOT"/tools/docs/*.rst "$DEFE_ROOT"/*.md "$DEFE_ROOT/LICENSE" "$work/source"
for part in benchmarks coupling examples fe-module lammps-package python tests tools; do
  ln -s "$DEFE_ROOT/$part" "$work/source/$part"
done

# All pages anew (-E -a): Sphinx does not see that its own set-up has changed.
build() {
  "$python" -m sphinx -W --keep-going -q -E -a -c "$DEFE_ROOT/tools/docs" -d "$work/doctrees" -b "$1" "$work/source" "$2"
}
build html "$folder"
if [[ -n $external ]]; then build linkcheck "$work/linkcheck"; fi
echo "DEFE: $folder/index.html"
