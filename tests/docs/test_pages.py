"""What the pages of the styles, and all README.md files, give to be typed in works.

Blocks of LAMMPS input (Howto_defe and Developer_defe have a test of their own, tests/tools/test_howto.py):
  below "Syntax"          the style must be one of the plugin, or the command known
  with plugin load        a whole script: it runs for 5 steps
  all others              lines that are put into the script of frame(), which runs. Lines that begin as one of its own take
                          its place, and variables at the beginning of a block go to the beginning. Where a block has a line
                          twice, its paragraphs are alternatives: each runs alone.
Shell commands of the pages that make meshes run; of others, and those of README.md files, program, example, variant and
options must be there.

DEFE_LMP, DEFE_PLUGIN: the lmp program and defeplugin.so (ctest sets them)."""

import os
import re
import sys
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(SOURCE / "tests/tools"))
import test_howto as howto  # noqa: E402

PAGES = sorted(p for p in (SOURCE / "lammps-package/doc").glob("*.rst") if p.name not in ("Howto_defe.rst", "Developer_defe.rst"))
RIGID = r"material\s+(\w+)\s+rigid"


def sections(page):
    """(heading, language, text) of all blocks of code of a page."""
    lines = page.read_text().splitlines()
    heading = ""
    for k, line in enumerate(lines):
        if k and re.fullmatch(r"([\"=^])\1{2,}", line):
            heading = lines[k - 1]
        elif match := re.fullmatch(r"\.\. code-block:: *(\S+)", line):
            text = []
            for inner in lines[k + 1:]:
                if inner and not inner.startswith("   "):
                    break
                text.append(inner[3:])
            yield heading, match[1], "\n".join(text).strip("\n") + "\n"


def names(text):
    return [tuple(howto.name_of(c)) for c in howto.commands(text) if not c.startswith("#")]


def alternatives(text):
    """Paragraphs of a block that cannot all be in one script, else the block."""
    once = [n for n in names(text) if n[0] != "thermo_style"]
    return [p + "\n" for p in text.split("\n\n")] if len(set(once)) < len(once) else [text]


def fix_defe(text):
    found = [c for c in howto.commands(text) if re.match(r"fix\s+\w+\s+\S+\s+defe\s", c)]
    return found[0] if found else None


def frame(text):
    """A script for these lines: a body of each part, and another one where they read a mesh."""
    fix = fix_defe(text) or ("fix fe all defe material glass elastic 74.09e9 0.2 2500 part upper glass "
                             "convert glass 56e6 type 4 group particles contact 0.2 friction 0.2\n")
    rigid = re.findall(RIGID, fix)
    parts = [] if "read_data" in text else re.findall(r"(?:material|part)\s+(\w+)\s", fix)
    apart = 0.004 if " tied " in fix else 0.01
    meshes = [f"create_hexes fe {part} {2 if part in rigid else 1} x -0.004 4 0.004 y 0.001 2 0.005 "
              f"z {-apart * k:g} 2 {0.004 - apart * k:g}\n" for k, part in enumerate(parts)]
    if "create_hexes" in text:
        meshes = meshes[:1]
    types = max([4] + [int(n) for pair in re.findall(r"(?:type|create_atoms|pair_coeff\s+\d)\s+(\d)", text) for n in pair])
    return "".join([
        "units si\natom_style sphere\nnewton off on\ncomm_modify vel yes\nboundary f f f\nplugin load defeplugin.so\n",
        f"region box block -0.11 0.11 -0.11 0.11 -0.11 0.11\ncreate_box {types} box\n",
        "pair_style defe/joint\npair_coeff 4 4 connective material cohesive 60e6 10.0 0.1 contact 0.9 0.2\n",
        "group particles empty\n", fix, *meshes, "group nodes type 1\ngroup glass type 1\ngroup upper type 1\n",
        "region middle block -0.002 0.002 INF INF INF INF\n",
        "fix move1 nodes nve\nfix move2 particles nve/sphere\n",
        "group rigid type 2\nfix rigid rigid rigid/nve single\n" if rigid else "",
        "timestep 1e-8\nneighbor 0.0002 bin\nthermo 1\nrun 2\n"])


def whole(lines):
    """The script of frame() with these lines."""
    given = howto.commands(re.sub(r"(?m)^#.*\n", "", lines))
    first = next((k for k, c in enumerate(given) if c.split()[0] not in ("variable", "include")), len(given))
    if first == len(given):
        first = 0
    return "".join(given[:first]) + howto.changed(frame(lines), "".join(given[first:]))


def makes_meshes(text):
    return all(re.match(r"tools/(mesh2data|layers2data)\s", line) for line in text.replace("\\\n", " ").splitlines())


def msh(path):
    """A plate of 4 x 4 elements of 1 mm with the volume glass and the rim of its lower side, as Gmsh writes it in format 2."""
    number = {at: k + 1 for k, at in enumerate((x, y, z) for z in range(2) for y in range(5) for x in range(5))}
    cells = [(5, 1, [number[x + i, y + j, z] for z in range(2) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
             for y in range(4) for x in range(4)]
    corners = [(0, 0), (4, 0), (4, 4), (0, 4)]
    for k in range(4):
        (x, y), (u, v) = corners[k], corners[(k + 1) % 4]
        step = ((u - x) // 4, (v - y) // 4)
        cells += [(1, 2, [number[x + n * step[0], y + n * step[1], 0], number[x + (n + 1) * step[0], y + (n + 1) * step[1], 0]])
                  for n in range(4)]
    path.write_text("\n".join([
        "$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '3 1 "glass"', '1 2 "rim"', "$EndPhysicalNames",
        "$Nodes", str(len(number)), *(f"{n} {x - 2} {y - 2} {z}" for (x, y, z), n in number.items()), "$EndNodes",
        "$Elements", str(len(cells)),
        *(f"{k + 1} {kind} 2 {group} {group} " + " ".join(map(str, nodes)) for k, (kind, group, nodes) in enumerate(cells)),
        "$EndElements", ""]))


class Pages(unittest.TestCase):
    def setUp(self):
        self.here = howto.Run(self)

    def failures(self, scripts):
        """What fails among (name, script): as many as possible in one process, which is what takes the time."""
        found, first = [], 0
        while first < len(scripts):
            pieces = [f"clear\nprint \"piece {k}\"\n{script}\n" for k, (_, script) in enumerate(scripts[first:], first)]
            run = self.here.lmp("".join(pieces))
            if run.returncode == 0:
                break
            last = int(re.findall(r"(?m)^piece (\d+)", run.stdout)[-1])
            error = re.search(r"(?m)^ERROR.*(?:\nLast input line.*)?", run.stdout)
            found.append((scripts[last][0], error[0] if error else run.stdout[-1000:], scripts[last][1]))
            first = last + 1
        return found

    def files(self):
        """What the blocks read."""
        for file in (SOURCE / "tools").glob("*.inc"):
            (self.here.folder / file.name).symlink_to(file)
        msh(self.here.folder / "pane.msh")
        run = self.here.call("tools/layers2data", "mesh.data", "--layer", "glass", "0.002", "1", "1",
                             "--x", "0", "2", "0.004", "--z", "0", "2", "0.004")
        self.assertEqual(run.returncode, 0, run.stdout)

    def styles(self, known, text):
        for line in text.splitlines():
            words = line.split()
            style = words[{"fix": 3, "compute": 3}.get(words[0], 0)]
            self.assertTrue(style in [*known, "pair_style", "pair_coeff"], f"no style or command {style}")

    def test_input(self):
        self.files()
        known = self.here.lmp("plugin load defeplugin.so\ninfo styles all\n").stdout.split()
        scripts = []
        for page in PAGES:
            for heading, language, text in sections(page):
                name = f"{page.name}: {text.splitlines()[0]}"
                with self.subTest(name):
                    if language == "bash" and makes_meshes(text):
                        run = self.here.call("bash", "-e", "-c", text)
                        self.assertEqual(run.returncode, 0, run.stdout)
                    elif language == "LAMMPS" and heading == "Syntax":
                        self.styles(known, text)
                    elif language == "LAMMPS" and "plugin " in text:
                        scripts.append((name, re.sub(r"(?m)^run +\d+", "run 5", text)))
                    elif language == "LAMMPS":
                        scripts += [(name, whole(lines).replace(".png", ".ppm")) for lines in alternatives(text)]
        self.assertGreater(len(scripts), 20)
        for name, error, script in self.failures(scripts):
            with self.subTest(name):
                if "built without HDF5" in error:
                    self.skipTest(error)
                self.fail(f"{error}\n{script}")

    def test_wrong_lines_are_found(self):
        """The frame does not swallow mistakes, and the pieces behind one run."""
        wrong = ["compute 1 all defe/atom damige\n", "fix fe all defe material glass elastic 74e9 0.2 2500 contct 0.1\n",
                 "fix floor all defe/wall yplan 0.0 NULL\n", "pair_coeff 4 4 connective material cohesive 60e6\n"]
        right = ["compute 1 all defe/atom damage\n", "fix floor all defe/wall yplane 0.0 NULL\n"]
        lines = [wrong[0], right[0], wrong[1], wrong[2], right[1], wrong[3]]
        found = self.failures([(line, whole(line)) for line in lines])
        self.assertEqual([name for name, *_ in found], wrong)


class Commands(unittest.TestCase):
    """Lines of all pages that call a script of this repository, and links between README.md files."""

    MARKDOWN = [SOURCE / "README.md", SOURCE / "CHANGELOG.md", *SOURCE.glob("*/README.md"), *SOURCE.glob("examples/*/README.md"),
                *SOURCE.glob("tests/**/README.md")]

    def lines(self, page):
        """Program and arguments. (Blocks are indented by four in Markdown and by three in rst.)"""
        text = re.sub(r"\\\n\s*", "", page.read_text())
        variable = r'(?:[A-Z_]+=(?:"[^"]*"|\S+) )*'
        for line in re.findall(rf"(?m)^ {{3,4}}{variable}((?:examples|tests|tools|benchmarks)/\S+.*)$", text):
            yield re.split(r"\s{2,}|\s#", line)[0].split()

    def test_links(self):
        seen = 0
        for page in self.MARKDOWN:
            for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
                if not re.match(r"[a-z]+:|#", target):
                    with self.subTest(page=page.relative_to(SOURCE), target=target):
                        self.assertTrue((page.parent / target.split("#")[0]).exists())
                    seen += 1
        self.assertGreater(seen, 40)

    def test_two_screens(self):
        self.assertLessEqual(len((SOURCE / "README.md").read_text().splitlines()), 130)

    def test_programs_and_options(self):
        seen = 0
        for page in [*self.MARKDOWN, *(SOURCE / "lammps-package/doc").glob("*.rst")]:
            for program, *words in self.lines(page):
                with self.subTest(page=page.relative_to(SOURCE), command=" ".join([program, *words])):
                    path = SOURCE / program
                    self.assertTrue(path.is_file() and os.access(path, os.X_OK))
                    seen += 1
                    if program == "examples/run.sh":
                        self.example(words)
                    elif program != "tools/layers2data":  # which makes --x, --y and --z in a loop
                        text = self.sources(path)
                        missing = [w for w in words if w.startswith("--") and not re.search(rf"{w}\b", text)]
                        self.assertEqual(missing, [])
        self.assertGreater(seen, 30)

    def sources(self, path):
        """Of a script and of those that it hands its options to."""
        text = path.read_text()
        for other in re.findall(r"[\w/]+\.py", text):
            name = Path(other).name
            for found in (SOURCE / other, path.parent / name, SOURCE / "tests/verification/manual" / name):
                if found.is_file():
                    text += found.read_text()
        return text

    def example(self, words):
        if not words:
            return
        folder = SOURCE / "examples" / words[0]
        self.assertTrue(folder.is_dir())
        own = (folder / "run.sh").read_text()
        inputs = own + "".join(p.read_text() for pattern in ("in.*", "*.inc") for p in folder.glob(pattern))
        if len(words) > 1 and not words[1].startswith("-"):
            variants = re.search(r"(?m)^# variants:(.*)", own)[1].split()
            self.assertIn(words[1], variants)
        given = [words[k + 1] for k, w in enumerate(words[:-1]) if w == "-var"]
        self.assertEqual([name for name in given if not re.search(rf"variable\s+{name}\b", inputs)], [])


if __name__ == "__main__":
    unittest.main()
