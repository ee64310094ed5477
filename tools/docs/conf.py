"""Sphinx: all pages of DEFE as one site. tools/docs.sh calls it."""

import os
import re
import shutil
import sys
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.util import logging

sys.path.insert(0, str(Path(__file__).parent))
from lammps_lexer import LAMMPSLexer  # noqa: E402

project = "DEFE"
copyright = "the DEFE developers; GPL-2.0"  # pylint: disable=redefined-builtin
extensions = ["myst_parser", "sphinx.ext.mathjax", "sphinx_rtd_theme"]
root_doc = "index"
# README.md at the top is not among them: the front page takes its place.
include_patterns = ["*.rst", "CHANGELOG.md", "lammps-package/doc/*.rst", "examples/*/README.md", "benchmarks/README.md",
                    "coupling/README.md", "fe-module/README.md", "python/README.md", "tests/verification/manual/README.md",
                    "tests/verification/manual/*/README.md"]
highlight_language = "none"
myst_heading_anchors = 3

html_theme = "sphinx_rtd_theme"
html_theme_options = {"navigation_depth": 3, "collapse_navigation": True}
html_title = "DEFE"
html_static_path = ["style"]
html_css_files = ["defe.css"]
html_show_sourcelink = False
html_copy_source = False
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_CHTML-full"
mathjax_options = {"async": "async"}
linkcheck_timeout = 20
linkcheck_retries = 2

LAMMPS = "https://docs.lammps.org/"
log = logging.getLogger(__name__)


def lammps_page(app, env, node, contnode):
    """Pages of LAMMPS, which :doc: names as if they were here."""
    target = node.get("reftarget", "")
    if node.get("reftype") != "doc" or "/" in target or "defe" in target:
        return None
    sources = os.environ.get("DEFE_LAMMPS_DOC")
    if sources and not (Path(sources) / f"{target}.rst").is_file():
        return None
    return nodes.reference("", "", contnode, internal=False, refuri=f"{LAMMPS}{target}.html")


def page_link(docname, page, text):
    new = addnodes.pending_xref("", reftype="doc", refdomain="std", refexplicit=True, refwarn=True, reftarget="/" + page,
                                refdoc=docname)
    new += nodes.inline("", "", *text)
    return new


def local_links(app, doctree):
    """Links of rst pages to files of the repository: to their page if they have one, else to a copy of the file. What is
    written as the name of such a file gets a link, too."""
    docname, pages = app.env.docname, app.env.found_docs
    for node in list(doctree.findall(nodes.reference)):
        uri = node.get("refuri", "")
        if not uri or re.match(r"[a-z]+:|#", uri):
            continue
        path, _ = app.env.relfn2path(uri, docname)
        page = re.sub(r"\.(rst|md)$", "", path)
        if page in pages:
            node.replace_self(page_link(docname, page, node.children))
        elif (Path(app.srcdir) / path).is_file():
            new = addnodes.download_reference("", refdoc=docname, reftarget="/" + path, refwarn=True)
            new += nodes.inline("", "", *node.children)
            node.replace_self(new)
        else:
            log.warning("link into nowhere: %s", uri, location=node)
    for node in list(doctree.findall(nodes.literal)):
        page = re.sub(r"\.(rst|md)$", "", node.astext())
        if page != node.astext() and page in pages and page != docname:
            node.replace_self(page_link(docname, page, [node.deepcopy()]))


def with_mathjax(app, error):
    """What MathJax needs for TeX formulas as HTML: 2 MB of 54."""
    if error or app.builder.name != "html":
        return
    source, to = Path(os.environ["DEFE_MATHJAX"]), Path(app.outdir) / "_static" / "mathjax"
    for part in ("MathJax.js", "config/TeX-AMS_CHTML-full.js", "extensions", "jax/element", "jax/input/TeX",
                 "jax/output/CommonHTML", "fonts/HTML-CSS/TeX/woff"):
        (to / part).parent.mkdir(parents=True, exist_ok=True)
        if (source / part).is_dir():
            shutil.copytree(source / part, to / part, dirs_exist_ok=True)
        else:
            shutil.copy(source / part, to / part)


def setup(app):
    app.add_lexer("LAMMPS", LAMMPSLexer)
    app.connect("missing-reference", lammps_page)
    app.connect("doctree-read", local_links)
    app.connect("build-finished", with_mathjax)
