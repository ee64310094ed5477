"""The site of tools/docs.sh: it builds without a warning, is whole, and does not build with a link into nowhere."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from urllib.parse import unquote

SOURCE = Path(__file__).resolve().parent.parent.parent


class Site(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="defe-site-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def docs(self, *arguments):
        return subprocess.run([SOURCE / "tools/docs.sh", *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, env=dict(os.environ, DEFE_PYTHON=sys.executable))

    def test_whole(self):
        run = self.docs(self.folder)
        self.assertEqual(run.returncode, 0, run.stdout[-3000:])
        self.assertNotIn("WARNING", run.stdout)
        front = (self.folder / "index.html").read_text()
        for page in [*(SOURCE / "lammps-package/doc").glob("*.rst"), *(SOURCE / "examples").glob("*/README.md"),
                     *(SOURCE / "tests/verification/manual").glob("*/README.md"), SOURCE / "benchmarks/README.md",
                     SOURCE / "python/README.md"]:
            name = page.relative_to(SOURCE).with_suffix(".html")
            with self.subTest(page=name):
                self.assertIn(f'href="{name}"', front)
                self.linked(self.folder / name)
        # a link to a file, and its name alone, become links to its page
        for page, link, text in (("Howto_defe", "benchmarks", "benchmark page"), ("Theory_defe", "coupling", "coupling/README.md")):
            body = (self.folder / f"lammps-package/doc/{page}.html").read_text()
            self.assertRegex(body, rf'href="../../{link}/README.html"[^>]*>(<[^>]*>)*{text}<')
        # formulas and what draws them, without the web
        text = (self.folder / "lammps-package/doc/pair_defe_joint.html").read_text()
        self.assertRegex(text, r'class="math[^"]*">\s*\\\[')
        self.assertNotRegex(text, r'<script[^>]*src="https?:')
        static = self.folder / "_static/mathjax"
        for part in ("MathJax.js", "config/TeX-AMS_CHTML-full.js", "jax/output/CommonHTML/jax.js"):
            self.assertTrue((static / part).is_file(), part)
        self.assertTrue(list((static / "fonts/HTML-CSS/TeX/woff").glob("*.woff")))

    def linked(self, page):
        """Whatever the page shows or leads to is there, and no cell of a table was taken for the beginning of a list."""
        text = page.read_text()
        self.assertNotRegex(text, r"<li>(<p></p>)?</li>")
        local = [uri.split("#")[0].split("?")[0] for uri in re.findall(r'(?:href|src)="([^"]+)"', text)]
        for uri in {u for u in local if u and not re.match(r"[a-z]+:", u)}:
            self.assertTrue((page.parent / unquote(uri)).exists(), uri)

    def test_links_into_nowhere(self):
        shutil.copy(SOURCE / "examples/laminated_beam/force.png", self.folder / "there.png")
        (self.folder / "there.txt").write_text("a file")
        for links in (("fix_nve", "there.txt", "there.png"), ("no_such_defe", "no/such.txt", "no_such.png")):
            page, file, picture = links
            (self.folder / "index.rst").write_text(f"Page\n====\n\n:doc:`a <{page}>` `b <{file}>`_\n\n.. image:: {picture}\n")
            run = subprocess.run([sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-E", "-b", "dummy",
                                  "-c", SOURCE / "tools/docs", self.folder, self.folder / "out"],
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            with self.subTest(links=links):
                bad = [link for link in links if link.startswith("no")]
                self.assertEqual(run.returncode != 0, bool(bad), run.stdout)
                for link in bad:
                    self.assertIn(link, run.stdout)

    def test_folder_of_something_else(self):
        (self.folder / "letter.txt").write_text("kept")
        run = self.docs(self.folder)
        self.assertEqual((run.returncode, run.stdout.count("\n")), (2, 1), run.stdout)
        self.assertIn("no site", run.stdout)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["letter.txt"])


if __name__ == "__main__":
    unittest.main()
