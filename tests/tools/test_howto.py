"""The pages Howto_defe.rst, Theory_defe.rst and Developer_defe.rst: all scripts run, and what the pages say is so.

A comment of the page before a block says what it is:
  .. script NAME   a whole script
  .. change NAME   lines that take the place of those of NAME with the same command and ID, or come before timestep
  .. next          a script that goes on where the block before it ended
  .. shell         commands
  .. output NAME   some lines of the thermo output of NAME
  .. source FILE   the text of a file of the repository, without its comment at the top
Blocks of code without one are refused.

DEFE_LMP, DEFE_PLUGIN: the lmp program and defeplugin.so (ctest sets them)."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parent.parent.parent
DOC = SOURCE / "lammps-package" / "doc"
# words of a command that say which of its kind it is
NAMED_BY = {"fix": 2, "group": 2, "region": 2, "compute": 2, "variable": 2, "dump": 2, "dump_modify": 2,
            "velocity": 2, "create_hexes": 3, "pair_coeff": 3, "create_atoms": 2, "set": 3}


def blocks(page):
    """(what it is, name, kind of block, text) of all blocks of a page."""
    found = []
    mark = (None, "")
    lines = (DOC / page).read_text().splitlines()
    for k, line in enumerate(lines):
        if match := re.fullmatch(r"\.\. (script|change|next|shell|output|source)(?: (\S+))?", line):
            mark = (match[1], match[2] or "")
        elif match := re.fullmatch(r"\.\. (code-block|parsed-literal)::(.*)", line):
            text = []
            for inner in lines[k + 1:]:
                if inner and not inner.startswith("   "):
                    break
                text.append(inner[3:])
            found.append((*mark, match[2].strip() or match[1], "\n".join(text).strip("\n") + "\n"))
            mark = (None, "")
        elif line and mark[0]:
            raise AssertionError(f"{page}: no block after '.. {mark[0]} {mark[1]}'")
    return found


def commands(script):
    """Commands of a script, with their continuation lines."""
    return [c for c in re.findall(r"(?:.*&\n)*.*\n", script) if c.strip()]


def name_of(command):
    words = command.split()
    return words[:NAMED_BY.get(words[0], 1)]


def changed(script, changes):
    old = commands(script)
    for new in commands(changes):
        same = [k for k, c in enumerate(old) if name_of(c) == name_of(new)]
        if same:
            assert len(same) == 1, f"which one is replaced by {new}?"
            old[same[0]] = new
        else:
            old.insert([c.split()[0] for c in old].index("timestep"), new)
    return "".join(old)


def list_table(page, head):
    """Rows of the list-table whose first cell begins so."""
    text = (DOC / page).read_text()
    start = text.index(f"   * - {head}")
    lines = re.match(r"(?:   .*\n|\n)+", text[start:])[0]
    rows = [re.split(r"\n     - ", row.strip()) for row in re.split(r"(?m)^   \* - ", lines)[1:]]
    return [[" ".join(cell.split()) for cell in row] for row in rows]


class Run:
    """A folder with the tools, in which scripts run."""

    def __init__(self, case):
        self.folder = Path(tempfile.mkdtemp(prefix="defe-howto-"))
        case.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "tools").symlink_to(SOURCE / "tools")
        plugin = Path(os.environ["DEFE_PLUGIN"])
        self.environment = dict(os.environ, LD_LIBRARY_PATH=f"{plugin.parent}:{os.environ.get('LD_LIBRARY_PATH', '')}")

    def call(self, *command):
        return subprocess.run([str(c) for c in command], cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def lmp(self, script, ranks=1):
        # LAMMPS may have been built without PNG
        (self.folder / "in.script").write_text(script.replace(".png", ".ppm"))
        return self.call(SOURCE / "tools/mpirun.sh", ranks, os.environ["DEFE_LMP"], "-in", "in.script", "-nocite")


def table(text):
    """Rows of numbers under the last line that begins with Step."""
    head, rows = [], []
    for line in text.splitlines():
        words = line.split()
        if words and words[0] == "Step":
            head, rows = words, []
        elif words and re.fullmatch(r"\d+", words[0]) and len(words) == len(head):
            rows.append(dict(zip(head, map(float, words))))
    return rows


class Howto(unittest.TestCase):
    def succeeded(self, run):
        self.assertEqual(run.returncode, 0, run.stdout[-2000:])
        self.assertNotRegex(run.stdout, "ERROR|WARNING: Fix defe")
        return run.stdout

    def test_every_script_runs_and_gives_what_the_page_says(self):
        scripts, outputs = {}, {}
        here = Run(self)
        said = 0
        for what, name, kind, text in blocks("Howto_defe.rst"):
            with self.subTest(what=what, name=name, begins=text.split("\n")[0]):
                if what is None:
                    self.assertEqual(kind, "parsed-literal", "say what this block is")
                elif what == "shell":
                    self.assertEqual(kind, "bash")
                    self.succeeded(here.call("bash", "-e", "-c", text))
                elif what == "output":
                    measured = {row["Step"]: row for row in table(outputs[name])}
                    for row in table(text):
                        self.same(row, measured[row["Step"]])
                        said += 1
                else:
                    if what == "script":
                        scripts[name] = text
                    self.assertEqual(kind, "LAMMPS")
                    script = changed(scripts[name], text) if what == "change" else text
                    outputs[name if what == "script" else what] = self.succeeded(here.lmp(script))
        self.assertGreater(said, 8)
        self.assertEqual(set(scripts), {"in.bar", "in.pane"})
        self.assertEqual(len(list(here.folder.glob("bar.*.ppm"))), 6)

        # what OVITO asks for: particles at both ends of each bond
        def entries(file):
            return [list(map(float, line.split())) for line in (here.folder / file).read_text().splitlines()[9:]]
        ids = {row[0] for row in entries("bar.atoms.1000.dump")}
        bonds = entries("bar.joints.1000.dump")
        self.assertGreater(len(bonds), 100)
        self.assertEqual({row[2] for row in bonds}, {1, 2})
        self.assertLessEqual({end for row in bonds for end in row[:2]}, ids)
        self.assertIn("ITEM: NUMBER OF BONDS\n", (here.folder / "bar.joints.1000.dump").read_text())

    def same(self, row, measured):
        """Rounding decides on single joints late in a run, and processors differ by it."""
        self.assertEqual(set(row), set(measured))
        for key, value in row.items():
            loose = {"Step": 0, "Time": 1e-12, "pieces": 1, "total": 5e-4 * value, "balance": 5e-4 * value,
                     "kinetic": 0.01 * value, "force": 0.05 * value}.get(key, 4 + 0.1 * value)
            self.assertLessEqual(abs(measured[key] - value), loose, f"{key} at step {row['Step']}: {measured[key]}, not {value}")

    def test_figures_of_the_choices(self):
        """Times of the first conversion and damage, and elements converted, that the tables have."""
        page = "Howto_defe.rst"
        bar = next(text for what, name, _, text in blocks(page) if what == "script" and name == "in.bar")
        bar = changed(bar, "variable first equal f_fe[24]*1e6\nvariable damage equal f_fe[25]*1e6\n")
        bar += 'print "found $(f_fe[2]) $(v_first) $(v_damage)"\n'
        here = Run(self)

        def found(*changes):
            script = bar
            for old, new in changes:
                self.assertEqual(script.count(old), 1, old)
                script = script.replace(old, new)
            return list(map(float, re.search(r"(?m)^found (.*)", here.lmp(script).stdout)[1].split()))

        stresses = list_table(page, "Conversion stress")[1:]
        self.assertEqual(len(stresses), 9)
        for name, first, damage, elements, _ in stresses:
            with self.subTest(name):
                stress = "56" if name.startswith("all") else name.split()[0]
                changes = [("convert glass 56e6", f"convert glass {stress}e6")]
                if "gauss" in name:
                    changes.append(("contact 0.2", "stress gauss contact 0.2"))
                if name.startswith("all"):
                    changes.append(("group particles &", "group particles start all &"))
                self.said([elements, first, damage], found(*changes))
        factors, firsts = list_table(page, "*contact*")
        for factor, first in zip(factors[1:], firsts[1:]):
            with self.subTest(contact=factor):
                self.said([None, first, None], found(("contact 0.2", f"contact {factor}")))

    def said(self, said, measured):
        for text, value in zip(said, measured):
            if text == "never":
                self.assertLess(value, 0)
            elif text is not None:
                number = float(text.split()[0])
                self.assertLessEqual(abs(value - number), 0.3 if "us" in text else 2 + 0.1 * number, (said, measured))

    def test_script_of_the_readme(self):
        text = (SOURCE / "README.md").read_text().split("## In your own script\n")[1]
        script = "".join(line[4:] for line in re.match(r"\n((?:    .*\n|\n)+)", text)[1].splitlines(True))
        self.assertIn("all defe material", script)
        self.succeeded(Run(self).lmp(re.sub(r"run .*", "run 20", script)))

    def test_changes_are_made_where_they_are_meant(self):
        script = "a 1\nfix x all nve\nfix y all &\n  nve\ntimestep 1\nrun 5\n"
        self.assertEqual(changed(script, "fix y all z\nfix w all q\nb 2\nrun 6\n"),
                         "a 1\nfix x all nve\nfix y all z\nfix w all q\nb 2\ntimestep 1\nrun 6\n")

    def test_comparing_the_events_of_one_and_two_ranks(self):
        bar = next(text for what, name, _, text in blocks("Howto_defe.rst") if what == "script" and name == "in.bar")
        events = []
        for ranks in (1, 2):
            here = Run(self)
            self.succeeded(here.lmp(changed(bar, "run 850\n"), ranks))
            lines = [line.split() for line in (here.folder / "events.txt").read_text().splitlines() if line[0] != "#"]
            events.append([(w[0], w[2], w[3], w[4]) for w in lines])
        self.assertGreater(len(events[0]), 100)
        self.assertEqual(events[0], events[1])


class Developer(unittest.TestCase):
    """What the page names is there."""

    def setUp(self):
        self.text = (DOC / "Developer_defe.rst").read_text()
        self.literals = set(re.findall(r"``([^`]+)``", self.text))

    def test_files_and_folders(self):
        paths = {name for name in self.literals if re.fullmatch(r"[\w./-]+(\.(h|cpp|py|sh|rst|md|txt)|/)", name)}
        self.assertGreater(len(paths), 10)
        self.assertEqual([name for name in sorted(paths) if not (SOURCE / name).exists()], [])

    def test_functions(self):
        code = "".join(path.read_text() for folder in ("fe-module", "coupling", "lammps-package", "tests")
                       for path in (SOURCE / folder).rglob("*") if path.suffix in (".h", ".cpp"))
        names = {match[1] for name in self.literals if (match := re.fullmatch(r"(?:\w+::)*(\w+)\(\)", name))}
        self.assertGreater(len(names), 10)
        self.assertEqual([name for name in sorted(names) if not re.search(rf"\b{name}\(", code)], [])

    def test_sources(self):
        shown = [(name, text) for what, name, _, text in blocks("Developer_defe.rst") if what == "source"]
        self.assertGreater(len(shown), 0)
        for name, text in shown:
            source = re.sub(r"\A(//.*\n)+\n", "", (SOURCE / name).read_text())
            self.assertEqual(source, text)


class Theory(unittest.TestCase):
    def test_numbers_are_those_of_the_code(self):
        rows = list_table("Theory_defe.rst", "What")[1:]
        self.assertGreater(len(rows), 10)
        for what, value, where in rows:
            with self.subTest(what):
                file, text = re.fullmatch(r"``([^`]+)``: ``([^`]+)``", where).groups()
                self.assertIn(text, (SOURCE / file).read_text())
                self.assertTrue(set(map(float, re.findall(r"[\d.]+", value))) <= set(map(float, re.findall(r"\d+\.?\d*", text))), where)


class Pages(unittest.TestCase):
    def test_links_and_pictures(self):
        """Pages and pictures that are not LAMMPS' own are there; with docutils, the pages have no errors."""
        for page in DOC.glob("*.rst"):
            text = page.read_text()
            targets = set(re.findall(r":doc:`[^<`]*<([^>`]+)>`", text)) | set(re.findall(r":doc:`([^<`]+)`", text))
            own = [t for t in targets if "defe" in t or t == "create_hexes"]
            files = re.findall(r"(?m)^\.\. (?:image|figure):: (\S+)", text) + re.findall(r"<(\.\./[^>]+)>`_", text)
            for target in [f"{t}.rst" for t in own] + files:
                with self.subTest(page=page.name, target=target):
                    self.assertTrue((DOC / target).exists())

    def test_labels_are_there_once(self):
        """Those of all pages: they are one space of names."""
        texts = {page.name: page.read_text() for page in DOC.glob("*.rst")}
        labels = [(label, name) for name, text in texts.items() for label in re.findall(r"(?m)^\.\. _(\w+):", text)]
        own = {label for label, _ in labels}
        self.assertEqual(sorted(label for label in own if [a for a, _ in labels].count(label) > 1), [])
        for name, text in texts.items():
            for label in re.findall(r":ref:`[^<`]*<(\w+)>`", text):
                self.assertIn(label, own, name)

    def test_markup(self):
        try:
            from docutils import core, nodes
            from docutils.parsers.rst import Directive, directives, roles
        except ImportError:
            self.skipTest("no docutils")

        class Ignored(Directive):
            has_content, optional_arguments, final_argument_whitespace = True, 1, True

            def run(self):
                return []

        directives.register_directive("index", Ignored)
        for role in ("doc", "ref"):
            roles.register_local_role(role, lambda name, raw, text, *rest, **more: ([nodes.emphasis(raw, text)], []))
        for page in DOC.glob("*.rst"):
            with self.subTest(page=page.name):
                core.publish_doctree(page.read_text(), settings_overrides={
                    "halt_level": 2, "report_level": 2, "syntax_highlight": "none"})


if __name__ == "__main__":
    unittest.main()
