"""What mesh2data and layers2data do with their output files: replaced whole or not at all, and nothing but regular
files; every failure is one line and status 2. And what layers2data writes and refuses."""

import os
import resource
import signal
import subprocess
import unittest
from pathlib import Path

from meshes import Case, Data, SOURCE, block, call, inp, layers2data, mesh2data

LAYERS = ["--layer", "a", "0.002", "1", "1", "--x", "0", "2", "0.004", "--z", "0", "1", "0.002"]


class Output(Case):
    def setUp(self):
        super().setUp()
        points, hexes = block((2, 1, 1), 1.0)
        self.mesh = self.write("m.inp", inp(points, [("glass", hexes)], "*NSET, NSET=s\n1, 2\n"))
        self.out = self.folder / "out"
        self.out.mkdir()

    def state(self):
        """All in the output folder: kind, mode and content."""
        found = {}
        for entry in os.scandir(self.out):
            info = entry.stat(follow_symlinks=False)
            found[entry.name] = info.st_mode, info.st_ino, (
                os.readlink(entry.path) if entry.is_symlink() else Path(entry.path).read_text() if entry.is_file() else None)
        return found

    def both(self, name):
        yield "mesh2data", mesh2data, [self.mesh, name]
        yield "layers2data", layers2data, [name, *LAYERS]

    def refused(self, tool, arguments, *words):
        before = self.state()
        result = call(tool, *arguments)
        self.assertEqual((result.returncode, result.stdout, result.stderr.count("\n")), (2, "", 1), result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(self.state(), before)

    def test_only_regular_files_are_replaced(self):
        (self.out / "folder").mkdir()
        (self.out / "file").write_text("mine\n")
        (self.out / "link").symlink_to("file")
        (self.out / "dangling").symlink_to("nothing")
        os.mkfifo(self.out / "pipe")
        for name, words in (("folder", ["folder", "a file name is needed"]), ("folder/", ["a file name"]), ("", ["a file name"]),
                            (".", ["a file name"]), ("new/", ["a file name"]), ("link", ["symbolic link"]),
                            ("dangling", ["symbolic link"]), ("pipe", ["no regular file"]), ("no/file", ["no folder"]),
                            ("file/x", ["no folder"]), ("line\nend", ["control characters"]), ("x" * 300, ["too long"])):
            path = f"{self.out}/{name}" if name else ""
            for program, tool, arguments in self.both(path):
                with self.subTest(name=name, program=program):
                    self.refused(tool, arguments, *words)
            if name:
                with self.subTest(name=name, program="--groups"):
                    self.refused(mesh2data, [self.mesh, self.out / "new", "--groups", path], *words)

    def test_what_is_read_is_not_replaced(self):
        """By any name: links, other spellings, and what the mesh includes."""
        included = self.out / "more.txt"
        included.write_text("1, 2\n")
        self.mesh.write_text(self.mesh.read_text() + f"*NSET, NSET=t\n*INCLUDE, INPUT={included}\n")
        hard = self.out / "hard"
        os.link(self.mesh, hard)
        spelled = f"{self.out}/../{self.mesh.name}"
        for name in self.mesh, hard, spelled, included:
            self.refused(mesh2data, [self.mesh, name], "overwritten")
            self.refused(mesh2data, [self.mesh, self.out / "x", "--groups", name], "overwritten")
        data = self.out / "x"
        self.refused(mesh2data, [self.mesh, data, "--groups", data], "two outputs")
        self.refused(mesh2data, [self.mesh, data, "--groups", f"{self.out}/../out/x"], "two outputs")

    def test_replaced_files_keep_their_rights(self):
        for program, tool, arguments in self.both(self.out / "d"):
            (self.out / "d").write_text("old\n")
            (self.out / "d").chmod(0o640)
            self.assertEqual(call(tool, *arguments).returncode, 0)
            self.assertEqual((self.out / "d").stat().st_mode & 0o777, 0o640)
            Data(self.out / "d")
        old = os.umask(0o027)
        try:
            self.assertEqual(call(layers2data, self.out / "new", *LAYERS).returncode, 0)
        finally:
            os.umask(old)
        self.assertEqual((self.out / "new").stat().st_mode & 0o777, 0o640)
        self.assertEqual(set(self.state()), {"d", "d.groups", "new"})

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_write_protected(self):
        (self.out / "d").write_text("old\n")
        (self.out / "d").chmod(0o444)
        for _, tool, arguments in self.both(self.out / "d"):
            self.refused(tool, arguments, "write-protected")
        self.out.chmod(0o555)
        for _, tool, arguments in self.both(self.out / "new"):
            self.refused(tool, arguments, "cannot write")
        self.out.chmod(0o755)

    def program(self, arguments, **more):
        return subprocess.run([SOURCE / "tools" / arguments[0], *map(str, arguments[1:])], text=True, stderr=subprocess.PIPE,
                              **{"stdout": subprocess.PIPE, **more})

    def test_full_disk(self):
        """A limit of the file's size, which ends the writing as a full disk does."""
        points, hexes = block((10, 10, 10), 1.0)
        self.mesh.write_text(inp(points, [("glass", hexes)]))
        for name, old in (("d", "old\n"), ("new", None)):
            if old:
                (self.out / name).write_text(old)
            before = self.state()
            limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))
            for arguments in (["mesh2data", self.mesh, self.out / name],
                              ["layers2data", self.out / name, "--layer", "a", "1", "10", "1", "--x", "0", "10", "1", "--z", "0", "10", "1"]):
                run = self.program(arguments, preexec_fn=limit)
                self.assertEqual((run.returncode, run.stderr.count("\n")), (2, 1), run.stderr)
                self.assertIn("File too large; nothing was changed", run.stderr)
                self.assertEqual(self.state(), before)

    def test_second_file_fails(self):
        """Neither file is changed when the second cannot be put in its place."""
        rename = os.replace
        for old in None, "old\n":
            for name in ("d", "d.groups") if old else ():
                (self.out / name).write_text(old)
            before = self.state()

            def fails(source, target):
                if str(target).endswith(".groups"):
                    raise OSError(5, "Input/output error")
                rename(source, target)

            os.replace = fails
            try:
                self.refused(mesh2data, [self.mesh, self.out / "d"], "d.groups: Input/output error; nothing was changed")
            finally:
                os.replace = rename
            self.assertEqual(self.state(), before)

    def test_interrupted(self):
        """A signal leaves no temporary file, and the old file whole."""
        (self.out / "d").write_text("old\n")
        before = self.state()
        for number in signal.SIGTERM, signal.SIGINT:
            # about 10^9 nodes: it writes until it is stopped
            run = subprocess.Popen([SOURCE / "tools" / "layers2data", self.out / "d", "--layer", "a", "1", "1000", "1", "--x", "0",
                                    "1000", "1", "--z", "0", "1000", "1"], stderr=subprocess.PIPE, text=True)
            while not any(p.stat().st_size for p in self.out.glob(".defe-*")) and run.poll() is None:
                pass
            run.send_signal(number)
            errors = run.communicate(timeout=60)[1]
            self.assertEqual((run.returncode, errors), (2, "layers2data: interrupted\n"))
            self.assertEqual(self.state(), before)

    def test_summary_that_cannot_be_printed(self):
        for arguments in (["mesh2data", self.mesh, self.out / "d"], ["layers2data", self.out / "d", *LAYERS]):
            with open("/dev/full", "w") as full:
                run = self.program(arguments, stdout=full)
            self.assertEqual((run.returncode, run.stderr.count("\n")), (2, 1), run.stderr)
            self.assertIn("the files are written, but", run.stderr)
            read, write = os.pipe()
            os.close(read)
            run = self.program(arguments, stdout=write)
            os.close(write)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            self.assertEqual(self.program(arguments, env=dict(os.environ, PYTHONIOENCODING="ascii")).returncode, 0)
            Data(self.out / "d")

    def test_names_of_files_in_groups(self):
        """They stand in a comment and in a message in quotes."""
        odd = self.out / "it's \"$x\" & é #1"
        mesh = self.mesh.rename(self.folder / "a\nquit 1 ü.inp")
        result = call(mesh2data, mesh, odd)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        groups = (self.out / (odd.name + ".groups")).read_text()
        self.assertEqual(groups.splitlines()[0], "# node groups of it_s __x_ _ _ _1, written by DEFE's mesh2data; read the mesh first")
        self.assertNotIn("$x", groups)
        self.assertTrue(odd.read_text().startswith("a_quit 1 _.inp: hexahedral mesh"))
        self.assertEqual(len(Data(odd).groups), 2)
        self.assertEqual(call(mesh2data, mesh, self.out / "with blank").stdout.splitlines()[-2],
                         f"  read_data \"{self.out}/with blank\" add append fix fe hexes Hexes")
        result = self.program(["mesh2data", os.fsencode(self.folder) + b"/\xff\n.inp", self.out / "x"])
        self.assertEqual((result.returncode, result.stderr.count("\n")), (2, 1))


class Layers(Case):
    def layers(self, *arguments):
        result = call(layers2data, self.folder / "l.data", *arguments)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return Data(self.folder / "l.data")

    def test_nodes_parts_and_types(self):
        data = self.layers("--axis", "z", "--from", "-0.5", "--layer", "low", "0.5", "2", "1", "--layer", "top", "1", "1", "5",
                           "--x", "-1", "1", "0", "2", "4", "--y", "-.5", "1", "1e0")
        self.assertEqual(sorted(set(data.x.values())), [(x, y, z) for x in (-1, 0, 2, 4) for y in (-.5, 1) for z in (-.5, -.25, 0, 1)])
        self.assertEqual([data.part[e] for e in (1, 4, 7, 9)], ["low", "low", "top", "top"])
        self.assertEqual({x[2]: data.type[n] for n, x in data.x.items()}, {-.5: 1, -.25: 1, 0: 5, 1: 5})
        for nodes in data.nodes.values():
            x = [data.x[n] for n in nodes]
            self.assertTrue(x[1][0] > x[0][0] and x[3][1] > x[0][1] and x[4][2] > x[0][2])

    def test_box_holds_what_is_far_away(self):
        data = self.layers("--layer", "a", "1e-3", "1", "1", "--x", "1000000", "1", "1000000.001", "--z", "0", "1", "1e-3")
        self.assertTrue(data.box["x"][0] < 1000000 < 1000000.001 < data.box["x"][1])

    def test_refused(self):
        good = {"layer": ["a", "1", "1", "1"], "x": ["0", "1", "1"], "z": ["0", "1", "1"]}
        for option, values, words in (
                ("layer", ["a b", "1", "1", "1"], ["'a b'", "letters"]), ("layer", ["a#", "1", "1", "1"], ["'a#'"]),
                ("layer", ["", "1", "1", "1"], ["letters"]), ("layer", ["a\nb", "1", "1", "1"], ["letters"]),
                ("layer", ["é", "1", "1", "1"], ["letters"]),
                ("layer", ["a", "nan", "1", "1"], ["--layer a", "'nan'"]), ("layer", ["a", "inf", "1", "1"], ["'inf'"]),
                ("layer", ["a", "1e999", "1", "1"], ["'1e999'"]), ("layer", ["a", "0", "1", "1"], ["above 0"]),
                ("layer", ["a", "-1", "1", "1"], ["above 0"]), ("layer", ["a", "1_0", "1", "1"], ["'1_0'"]),
                ("layer", ["a", "1", "0", "1"], ["from 1 to"]), ("layer", ["a", "1", "1.5", "1"], ["'1.5'"]),
                ("layer", ["a", "1", "1", "0"], ["from 1 to"]), ("layer", ["a", "1", "1", "3000000000"], ["from 1 to"]),
                ("layer", ["a", "1", "2000000000", "1"], ["2000000000 elements along one axis"]),
                ("layer", ["a", "1e150", "1", "1"], ["1e100"]),
                ("x", ["0", "1"], ["START N END"]), ("x", ["0", "1", "0"], ["go up"]), ("x", ["0", "1", "nan"], ["'nan'"]),
                ("x", ["inf", "1", "1"], ["'inf'"]), ("x", ["1", "9", "1.00000000000001"], ["too thin"]),
                ("from", ["nan"], ["--from", "'nan'"]), ("y", ["0", "1", "1"], ["axis of the layers"]),
                ("colour", ["1"], ["--colour"])):
            options = dict(good, **{option: values})
            arguments = [word for name, words_of in options.items() for word in ["--" + name, *words_of]]
            with self.subTest(option=option, values=values):
                result = call(layers2data, self.folder / "l.data", *arguments)
                self.assertEqual((result.returncode, result.stdout, result.stderr.count("\n")), (2, "", 1), result.stderr)
                for word in words:
                    self.assertIn(word, result.stderr)
                self.assertFalse((self.folder / "l.data").exists())
        result = call(layers2data, self.folder / "l.data", "--layer", *good["layer"], "--x", "0", "100000", "1", "--z", "0", "100000", "1")
        self.assertEqual(result.returncode, 2)
        self.assertIn("20000400002 nodes: LAMMPS' largest ID is 2147483647", result.stderr)


if __name__ == "__main__":
    unittest.main()
