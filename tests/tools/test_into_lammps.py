#!/usr/bin/env python3
"""tools/into-lammps: what LAMMPS' build and pages get, and that plugin, headers and pages name the same styles.

DEFE_LAMMPS_SOURCE is a source tree of LAMMPS. That it builds and runs is the claim of test_built_in.sh.
"""

import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
LAMMPS = Path(os.environ["DEFE_LAMMPS_SOURCE"])
PACKAGE = SOURCE / "lammps-package"
LISTS = ("Commands_all", "Commands_fix", "Commands_compute", "Commands_pair", "commands_list", "fix", "compute",
         "pair_style", "Howto", "Packages", "Packages_list", "Packages_details")


def in_headers():
    """{("fix", "defe"), ...}: the styles that LAMMPS' CMake finds."""
    found = set()
    for header in (PACKAGE / "src").glob("*.h"):
        for kind, name in re.findall(r"^(Fix|Compute|Pair|Command)Style\((\S+),\w+\);?$", header.read_text(), re.MULTILINE):
            found.add((kind.lower(), name))
    return found


class IntoLammps(unittest.TestCase):
    def setUp(self):
        self.tree = Path(tempfile.mkdtemp(prefix="defe-lammps-"))
        self.addCleanup(shutil.rmtree, self.tree)
        (self.tree / "src").mkdir()
        shutil.copy(LAMMPS / "src" / "version.h", self.tree / "src")
        (self.tree / "cmake" / "Modules" / "Packages").mkdir(parents=True)
        shutil.copy(LAMMPS / "cmake" / "CMakeLists.txt", self.tree / "cmake")
        (self.tree / "doc" / "src").mkdir(parents=True)
        for name in LISTS:
            if (LAMMPS / "doc" / "src" / f"{name}.rst").exists():    # releases differ
                shutil.copy(LAMMPS / "doc" / "src" / f"{name}.rst", self.tree / "doc" / "src")

    def run_tool(self, *options):
        return subprocess.run([SOURCE / "tools" / "into-lammps", *options], stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def contents(self):
        return {str(f.relative_to(self.tree)): f.read_bytes() for f in sorted(self.tree.rglob("*")) if f.is_file()}

    def test_styles_are_the_same_everywhere(self):
        plugin = (PACKAGE / "plugin" / "defeplugin.cpp").read_text()
        loaded = set(re.findall(r'\(\s*"(fix|pair|compute|command)",\s*"(\S+)"', plugin))
        self.assertEqual(loaded, in_headers())
        pages = set()
        for page in (PACKAGE / "doc").glob("*.rst"):
            for kind, name in re.findall(r"^\.\. index:: (?:(fix|compute|pair)(?:_style)? )?(\S+)$", page.read_text(), re.MULTILINE):
                pages.add((kind or "command", name))
        self.assertEqual(pages, in_headers())
        self.assertGreaterEqual(len(pages), 11)

    def test_lists(self):
        for option in ((), ("--copy",)):
            run = self.run_tool(self.tree, *option)
            self.assertEqual(run.returncode, 0, run.stdout)
            self.assertEqual((self.tree / "src" / "DEFE").is_symlink(), not option)
            self.assertTrue((self.tree / "src" / "DEFE" / "fix_defe.cpp").is_file())
            self.assertFalse((self.tree / "src" / "DEFE" / "defeplugin.cpp").exists())
            self.assertTrue((self.tree / "lib" / "defe" / "coupling" / "include" / "defe" / "coupling" / "words.h").is_file())
            self.assertTrue((self.tree / "examples" / "PACKAGES" / "defe" / "glass_beam" / "in.glass_beam").is_file())
        lists = (self.tree / "cmake" / "CMakeLists.txt").read_text()
        self.assertEqual(len(re.findall(r"^  DEFE$", lists, re.MULTILINE)), 1)
        self.assertEqual(len(re.findall(r"PKG_WITH_INCL DEFE ", lists)), 1)
        doc = self.tree / "doc" / "src"
        for kind, name in in_headers():
            page = doc / ("Commands_all.rst" if kind == "command" else f"Commands_{kind}.rst")
            entries = re.findall(r"\* :doc:`([^ `]+)[^<`]*<(\w+)>`", page.read_text())
            where = [n for n, (entry, _) in enumerate(entries) if entry == name]
            self.assertEqual(len(where), 1, name)
            self.assertLess(entries[where[0] - 1][0], name)
            self.assertTrue((doc / f"{entries[where[0]][1]}.rst").is_file())
        pictures = 0
        listed = (doc / "Howto.rst").read_text() + (doc / "commands_list.rst").read_text()
        for page in (doc / page.name for page in (PACKAGE / "doc").glob("*.rst")):
            for picture in re.findall(r"(?:image|figure):: (\S+)", page.read_text()):
                pictures += 1
                self.assertTrue((doc / picture).is_file(), f"{page.name}: {picture}")
            # LAMMPS lists those of styles by the beginning of their names (doc/utils/make-globbed-tocs.py)
            if not re.match("fix_|compute_|pair_", page.name):
                self.assertRegex(listed, rf"(?m)^   {page.stem}$")
        self.assertGreater(pictures, 30)

    def test_again(self):
        self.run_tool(self.tree)
        first = self.contents()
        self.assertEqual(self.run_tool(self.tree).returncode, 0)
        self.assertEqual(self.contents(), first)

    def test_refused(self):
        run = self.run_tool(self.tree / "src")
        self.assertEqual((run.returncode, run.stdout.count("\n")), (2, 1))
        self.assertIn("is no source tree of LAMMPS (no src/version.h)", run.stdout)
        (self.tree / "src" / "DEFE").mkdir()
        (self.tree / "src" / "DEFE" / "mine.cpp").touch()
        run = self.run_tool(self.tree)
        self.assertEqual((run.returncode, run.stdout.count("\n")), (2, 1))
        self.assertIn("is there and not DEFE's", run.stdout)
        self.assertTrue((self.tree / "src" / "DEFE" / "mine.cpp").exists())


if __name__ == "__main__":
    unittest.main()
