#!/usr/bin/env python3
"""Measures DEFE and its peers; called by benchmarks/run.sh. Standard library only.

measure.py --build DIR --out DIR [--quick] [--rounds N] [--profile] [--page FILE] [row...]

Every row of the table needs some cases (one LAMMPS run, one Google Benchmark program, ...). The cases
of all wanted rows run one after the other, and that is repeated --rounds times: what is compared has
met the same weather. A rate is the median over the rounds; a ratio is the median of the ratios that
were taken within a round.
"""

import argparse
import datetime
import json
import math
import os
import platform
import random
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT / "python"))
from hexmesh.data_file import data_lines  # noqa: E402
INPUTS = HERE / "inputs"
BEAM = ROOT / "examples" / "glass_beam"
PLATE = ROOT / "examples" / "laminated_plate"
STEPS = 1667  # of 6e-8 s: the paper's 100 us
BEAM_HEXES = 5150  # deformable ones


class Skip(Exception):
    """This case cannot be measured here; the text says why."""


# ---- running programs ---------------------------------------------------------------------------


class Runner:
    def __init__(self, build, out, quick):
        self.build, self.out, self.quick = build, out, quick
        self.lmp = build / "lmp"
        self.cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [0]
        self.taskset = shutil.which("taskset")
        self.environment = dict(os.environ, OMP_NUM_THREADS="1")
        path = os.environ.get("LD_LIBRARY_PATH")
        self.environment["LD_LIBRARY_PATH"] = f"{build}:{path}" if path else str(build)
        for name in ("OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"):
            self.environment[name] = "1"
        self.perf = find_perf()

    def pinned(self, command):
        return [self.taskset, "-c", str(self.cores[-1])] + command if self.taskset else command

    def execute(self, command, folder, log):
        """Wall and processor time, and peak memory of the process (also of mpirun's largest rank)."""
        start = time.monotonic()
        with open(log, "wb") as screen:
            process = subprocess.Popen([str(c) for c in command], cwd=folder, env=self.environment,
                                       stdin=subprocess.DEVNULL, stdout=screen, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status) if hasattr(os, "waitstatus_to_exitcode") else status
        if process.returncode:
            tail = Path(log).read_text(errors="replace").splitlines()[-12:]
            raise RuntimeError(f"{Path(folder).name} failed ({process.returncode}):\n  " + "\n  ".join(tail))
        wall = time.monotonic() - start
        cpu = usage.ru_utime + usage.ru_stime
        return {"wall_s": round(wall, 4), "cpu_s": round(cpu, 4), "cpu_share": round(cpu / wall, 3),
                "rss_kB": usage.ru_maxrss}

    def lammps(self, name, script, variables=(), ranks=1, folder=None, perf_data=None):
        """Runs a script; its last (or, with pieces, whole) loop time, steps and atoms."""
        work = self.out / "runs" / name
        work.mkdir(parents=True, exist_ok=True)
        log = work / "log.lammps"
        command = [str(self.lmp), "-in", str(script), "-log", str(log)]
        for key, value in dict(variables).items():
            command += ["-var", key] + ([str(v) for v in value] if isinstance(value, tuple) else [str(value)])
        if ranks == 1:
            command = self.pinned(command)
        else:
            command = [str(ROOT / "tools" / "mpirun.sh"), str(ranks)] + self.one_core_each(ranks) + command
        fifo = None
        if perf_data:
            fifo = work / "perf.fifo"
            if fifo.exists():
                fifo.unlink()
            os.mkfifo(fifo)
            command = [self.perf, "record", "-q", "-e", "cpu-clock", "-F", "4999", "-D", "-1",
                       f"--control=fifo:{fifo}", "-o", str(perf_data), "--"] + command + ["-var", "perf", "yes", "-var", "fifo", str(fifo)]
        sample = self.execute(command, folder or work, work / "screen.txt")
        text = log.read_text(errors="replace")
        loops = re.findall(r"^Loop time of (\S+) on (\d+) procs for (\d+) steps with (\d+) atoms", text, re.M)
        if not loops or "ERROR" in text:
            raise RuntimeError(f"{name}: no finished run in its log")
        sample.update(loop_s=float(loops[-1][0]), steps=int(loops[-1][2]), atoms=int(loops[-1][3]),
                      ranks=int(loops[-1][1]), all_loops_s=round(sum(float(l[0]) for l in loops), 6))
        # LAMMPS' own figure, of the steps alone
        cpu = re.findall(r"^([\d.]+)% CPU use with", text, re.M)
        sample["cpu_share"] = float(cpu[-1]) / 100 if cpu else None
        sample["log"] = text
        return sample

    def one_core_each(self, ranks):
        if not self.taskset or len(self.cores) < ranks:
            return []
        local = "${OMPI_COMM_WORLD_LOCAL_RANK:-${MPI_LOCALRANKID:-${PMI_RANK:-0}}}"
        cores = " ".join(str(c) for c in self.cores)
        return ["bash", "-c", f'cores=({cores}); exec taskset -c "${{cores[{local}]}}" "$@"', "rank"]

    def google(self, program, pattern):
        path = self.build / "benchmarks" / program
        if not path.exists():
            raise Skip(f"{program} is not built (-D DEFE_BENCHMARKS=ON)")
        work = self.out / "runs" / program
        work.mkdir(parents=True, exist_ok=True)
        result = work / "result.json"
        seconds = "0.01" if self.quick else "0.3"
        command = [str(path), f"--benchmark_filter={pattern}", f"--benchmark_min_time={seconds}",
                   f"--benchmark_out={result}", "--benchmark_out_format=json"]
        sample = self.execute(self.pinned(command), work, work / "screen.txt")
        data = json.loads(result.read_text())
        sample["rates"] = {b["name"]: b["items_per_second"] for b in data["benchmarks"] if "items_per_second" in b}
        if not sample["rates"]:
            raise RuntimeError(f"{program}: no benchmark matches {pattern}")
        return sample


def has_avx512():
    return re.search(r"^flags\s*:.*\bavx512f\b", read("/proc/cpuinfo"), re.M) is not None


def find_perf():
    """perf, if it can sample programs here."""
    perf = shutil.which("perf")
    if not perf:
        return None
    try:
        done = subprocess.run([perf, "record", "-q", "-e", "cpu-clock", "-o", os.devnull, "true"],
                              stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=30)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return perf if done.returncode == 0 else None


# ---- the cases ----------------------------------------------------------------------------------

# A case is a function of a Runner that returns one sample.


def block_size(runner, hexes):
    """nx, ny, nz of a block of about that many hexahedra."""
    shapes = {5000: (25, 20, 10), 20000: (40, 25, 20), 50000: (50, 40, 25), 200000: (80, 50, 50), 2000000: (200, 100, 100)}
    if runner.quick:
        hexes = {5000: 5000, 20000: 5000, 50000: 5000, 200000: 20000, 2000000: 20000}[hexes]
    return shapes[hexes]


def block(runner, name, hexes, element_steps=10e6, ranks=1, mesh=None):
    nx, ny, nz = block_size(runner, hexes)
    n = nx * ny * nz
    steps = 5 if runner.quick else max(60, round(element_steps / n))    # a run begins and ends with a look at its energies
    variables = {"nx": nx, "ny": ny, "nz": nz, "steps": steps}
    if mesh:
        path = runner.out / "runs" / f"distorted.{nx}x{ny}x{nz}.data"
        if not path.exists():
            write_distorted_mesh(path, nx, ny, nz)
        variables.update(shape="general", mesh=path)
    sample = runner.lammps(name, INPUTS / "in.block", variables, ranks)
    state = re.search(r"^highest stress (\S+), converted (\d+)", sample["log"], re.M)
    if not state or int(state.group(2)) or not 0 < float(state.group(1)) < 56e6:
        raise RuntimeError(f"{name}: the block is not in the state that it should be timed in")
    sample["hexes"] = n
    sample["rate"] = n * sample["steps"] / sample["loop_s"]
    sample["bytes_per_hex"] = 1024 * sample["rss_kB"] / n
    return sample


def case_kernels_avx2(r):
    if not has_avx512():
        raise Skip("no AVX-512 here: all kernels are built for AVX2 or less")
    return r.google("bench_fe_avx2", "/5150$")


def dem_block(runner, name, des, de_steps=10e6):
    """The same block with all of it DEs from the start, eight for an element."""
    shapes = {30000: (25, 15, 10), 200000: (50, 25, 20), 2000000: (100, 50, 50)}
    nx, ny, nz = shapes[30000 if runner.quick else des]
    n = 8 * nx * ny * nz
    steps = 5 if runner.quick else max(10, round(de_steps / n))
    sample = runner.lammps(name, INPUTS / "in.block", {"nx": nx, "ny": ny, "nz": nz, "steps": steps, "start": "all"})
    if sample["atoms"] != n:
        raise RuntimeError(f"{name}: {sample['atoms']} atoms in place of {n} DEs")
    sample["des"] = n
    sample["rate"] = n * sample["steps"] / sample["loop_s"]
    sample["bytes_per_de"] = 1024 * sample["rss_kB"] / n
    return sample


def write_distorted_mesh(path, nx, ny, nz, h=2e-3, amplitude=0.1):
    """A block whose inner nodes are moved at random by up to `amplitude` of the edge: no two alike."""
    rng = random.Random(1)
    path.parent.mkdir(parents=True, exist_ok=True)
    node = lambda i, j, k: 1 + i + (nx + 1) * (j + (ny + 1) * k)

    def atoms():
        for k in range(nz + 1):
            for j in range(ny + 1):
                for i in range(nx + 1):
                    x = [h * (c + (rng.uniform(-amplitude, amplitude) if 0 < c < n else 0.0)) for c, n in ((i, nx), (j, ny), (k, nz))]
                    yield node(i, j, k), 1, "%.12g %.12g %.12g" % tuple(x)

    def hexes():
        e = 0
        for k in range(nz):
            for j in range(ny):
                for i in range(nx):
                    e += 1
                    yield e, "glass", [node(i + a, j + b, k + c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]

    with open(path, "w") as f:
        f.writelines(line + "\n" for line in data_lines("distorted block of hexahedra", ((nx + 1) * (ny + 1) * (nz + 1), 1, nx * ny * nz),
                                                       [(-5 * h, (n + 5) * h) for n in (nx, ny, nz)], atoms(), hexes()))


def beam(runner, name, variables=(), steps=None, perf_data=None):
    """The steps of the glass beam alone, without the example's output."""
    work = runner.out / "runs" / name
    variables = {"number": STEPS, "example": BEAM, "out": work, **dict(variables)}
    if runner.quick:
        variables["number"] = min(variables["number"], 50)
    if steps:
        variables["number"] = steps
    return runner.lammps(name, INPUTS / "in.beam", variables, perf_data=perf_data)


def example(runner, name, script, variables=(), end=1e-4):
    """A script of examples/glass_beam as a user runs it, without pictures; all of its loop."""
    work = runner.out / "runs" / name
    if runner.quick:
        end = 1.2e-6
    variables = {"out": work, "pictures": "no", "end": end, **dict(variables)}
    sample = runner.lammps(name, BEAM / script, variables)
    if script == "in.glass_beam":
        sample["converted"] = thermo_column(sample, "converted")[-1][1]
    sample["steps"] = round(end / 6e-8)
    sample["loop_s"] = sample["all_loops_s"]
    return sample


def beam_by_law(runner, name, law, variables=(), end=9e-5):
    """The beam by one of the laws by which joints open, up to when the crack is through; processor time of the loop."""
    sample = example(runner, name, "in.glass_beam", {"law": law, **dict(variables)}, end)
    loops = re.findall(r"^Loop time of (\S+) on .*?^([\d.]+)% CPU use", sample["log"], re.M | re.S)
    sample["loop_cpu_s"] = sum(0.01 * float(seconds) * float(share) for seconds, share in loops)
    return sample


def thermo_column(sample, name):
    """(step, value) of a column of the last run in the log."""
    rows, column = [], None
    for line in sample["log"].splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            column = words.index(name) if name in words else None
            rows = [] if column is not None else rows
        elif line.startswith("Loop time"):
            column = None
        elif column is not None and words and words[0].isdigit():
            rows.append((int(words[0]), float(words[column])))
    return rows


def case_dem(r):
    sample = example(r, "dem", "in.glass_beam", {"variant": "dem"})
    sample["des"] = thermo_column(sample, "des")[0][1]
    sample["joints"] = thermo_column(sample, "connective")[0][1]
    sample["rate"] = sample["des"] * sample["steps"] / sample["loop_s"]
    return sample


def case_bpm(r):
    sample = example(r, "bpm", "in.bpm")
    sample["rate"] = 40000 * sample["steps"] / sample["loop_s"]
    return sample


def case_bpm_spring(r):
    sample = r.lammps("bpm_spring", INPUTS / "in.bpm_spring", {"steps": 20 if r.quick else 1000})
    sample["bonds"] = 199 * 20 * 10 + 200 * 19 * 10 + 200 * 20 * 9
    sample["rate"] = sample["bonds"] * sample["steps"] / sample["loop_s"]
    return sample


def two_clocks_variable():
    """The variable of in.glass_beam that fix defe's keyword `every` reads, if there is one."""
    text = re.sub(r"&\s*\n", " ", (BEAM / "in.glass_beam").read_text())
    found = re.search(r"^fix\s+\S+\s+all\s+defe\b.*\bevery\s+\$\{(\w+)\}", text, re.M)
    return found.group(1) if found else None


def case_two_clocks(r):
    variable = two_clocks_variable()
    if not variable:
        raise Skip("in.glass_beam has no keyword `every` of fix defe yet")
    return example(r, "two_clocks", "in.glass_beam", {variable: 2})


def add_trace(r, name, sample):
    """Wall time of every step, and the steps in which elements convert."""
    stamps = thermo_column(sample, "CPU")
    sample["times"] = {b[0]: b[1] - a[1] for a, b in zip(stamps, stamps[1:])}
    events = (r.out / "runs" / name / "events.txt").read_text()
    sample["conversions"] = sorted({int(line.split()[0]) for line in events.splitlines() if " convert " in line})
    return sample


def case_trace(r):
    return add_trace(r, "trace", beam(r, "trace", {"trace": "yes"}, steps=480 if r.quick else STEPS))


def event(r, hexes, border=False):
    """A bar that cracks beside a block of that many hexahedra; border: upon that of two ranks."""
    name = f"event_border{hexes}" if border else f"event{hexes}"
    nx, ny, nz = block_size(r, hexes)
    variables = {"nx": nx, "ny": ny, "nz": nz, "out": r.out / "runs" / name, "border": "yes" if border else "no"}
    sample = r.lammps(name, INPUTS / "in.event", variables, ranks=2 if border else 1)
    sample["hexes"] = nx * ny * nz
    return add_trace(r, name, sample)


def plate(r, name, variables=(), end="4e-5", fine=False, ranks=1):
    """examples/laminated_plate up to `end`, elements of 2 or 1 mm as its run.sh makes them, without pictures."""
    work = r.out / "runs" / name
    work.mkdir(parents=True, exist_ok=True)
    mesh = work / "mesh.data"
    n, edge = ("25", "4e-3") if r.quick else ("100", "1e-3") if fine else ("50", "2e-3")
    r.execute([sys.executable, ROOT / "tools" / "layers2data", mesh, "--axis", "z", "--layer", "lower", "0.003", "3", "1",
               "--layer", "inter", "0.00076", "1", "5", "--layer", "upper", "0.003", "3", "1",
               "--x", "-0.05", n, "0.05", "--y", "-0.05", n, "0.05"], work, work / "mesh.txt")
    sample = r.lammps(name, PLATE / "in.laminated_plate",
                      {"out": work, "mesh": mesh, "edge": edge, "pictures": "no", "end": "3e-7" if r.quick else end,
                       **dict(variables)}, folder=PLATE, ranks=ranks)
    sample["loop_s"] = sample["all_loops_s"]
    return sample


def front(r, name, cracks, steps):
    """A crack front through a block of 1 000 000 hexes; seconds per step."""
    n = 20 if r.quick else 100
    sample = r.lammps(name, INPUTS / "in.front", {"nx": n, "ny": n, "nz": n, "cracks": cracks, "out": r.out / "runs" / name,
                                                  "steps": 5 if r.quick else steps})
    sample["per_step"] = sample["all_loops_s"] / (20 + sample["steps"])
    sample["converted"] = int(re.search(r"^converted (\d+)", sample["log"], re.M).group(1))
    return sample


def case_chute(r):
    host = dict(line.split("=", 1) for line in (r.build / "lammps-host.txt").read_text().splitlines()) \
        if (r.build / "lammps-host.txt").exists() else {}
    folder = Path(host.get("source", "")) / "bench"
    if not host or not (folder / "data.chute").exists():
        raise Skip("no bench/in.chute in the LAMMPS source tree")
    sample = r.lammps("chute", folder / "in.chute", folder=folder)
    sample["rate"] = sample["atoms"] * sample["steps"] / sample["loop_s"]
    return sample


def case_lulesh(r):
    program = os.environ.get("DEFE_LULESH")
    if not program:
        raise Skip("no LULESH here: DEFE_LULESH=path of a serial lulesh2.0 runs it")
    work = r.out / "runs" / "lulesh"
    work.mkdir(parents=True, exist_ok=True)
    size = 10 if r.quick else 45
    sample = r.execute(r.pinned([program, "-s", str(size), "-i", "10" if r.quick else "100"]), work, work / "screen.txt")
    found = re.search(r"FOM\s*=\s*(\S+)", (work / "screen.txt").read_text())
    if not found:
        raise RuntimeError("LULESH printed no FOM")
    sample["rate"] = float(found.group(1))  # elements times cycles per second
    return sample


def profile_case(name, variables):
    def case(r):
        if not r.perf:
            raise Skip("no perf here that can sample (Debian: linux-perf, kernel.perf_event_paranoid <= 2)")
        data = r.out / "runs" / f"{name}.perf.data"
        sample = beam(r, name, variables, perf_data=data)
        sample["functions"] = read_profile(r.perf, data)
        return sample
    return case


# of the plate: nothing converts, no joint of the interlayer gives way; the whole impact; what is long enough for 1 mm
NO_CRACKS = {"stress": "1e30", "bond": 0}
WHOLE, FINE = "1e-4", "2e-5"

CASES = {
    "kernels": lambda r: r.google("bench_fe", "/5150$"),
    "kernels_avx2": case_kernels_avx2,
    "joint_kernels": lambda r: r.google("bench_joints", "."),
    "bricks": lambda r: block(r, "bricks", 50000, 20e6),
    "general": lambda r: block(r, "general", 50000, 5e6, mesh=True),
    "elastic": lambda r: beam(r, "elastic", {"stress": 1e30}),
    "adaptive": lambda r: example(r, "adaptive", "in.glass_beam"),
    "two_clocks": case_two_clocks,
    "law_rings": lambda r: beam_by_law(r, "law_rings", "stress"),
    "law_lattice": lambda r: beam_by_law(r, "law_lattice", "lattice"),
    "law_dem_rings": lambda r: beam_by_law(r, "law_dem_rings", "stress", {"variant": "dem"}),
    "law_dem_lattice": lambda r: beam_by_law(r, "law_dem_lattice", "lattice", {"variant": "dem"}),
    "trace": case_trace,
    "ranks1": lambda r: block(r, "ranks1", 200000, 20e6),
    "ranks2": lambda r: block(r, "ranks2", 200000, 20e6, ranks=2),
    "size5000": lambda r: block(r, "size5000", 5000, 10e6),
    "size20000": lambda r: block(r, "size20000", 20000, 10e6),
    "size200000": lambda r: block(r, "size200000", 200000, 10e6),
    "size2000000": lambda r: block(r, "size2000000", 2000000, 30e6),
    "dem": case_dem,
    "bpm": case_bpm,
    "bpm_spring": case_bpm_spring,
    "event20000": lambda r: event(r, 20000),
    "event200000": lambda r: event(r, 200000),
    "event2000000": lambda r: event(r, 2000000),
    "event_border200000": lambda r: event(r, 200000, True),
    "event_border2000000": lambda r: event(r, 2000000, True),
    "plate_elastic": lambda r: plate(r, "plate_elastic", NO_CRACKS),
    "plate": lambda r: plate(r, "plate"),
    "plate_dem": lambda r: plate(r, "plate_dem", {"start": "all"}),
    "plate_ranks": lambda r: plate(r, "plate_ranks", ranks=2),
    "plate_whole_elastic": lambda r: plate(r, "plate_whole_elastic", NO_CRACKS, WHOLE),
    "plate_whole": lambda r: plate(r, "plate_whole", end=WHOLE),
    "plate_whole_slower": lambda r: plate(r, "plate_whole_slower", {"speed": 14.99}, WHOLE),
    "plate_whole_faster": lambda r: plate(r, "plate_whole_faster", {"speed": 15.01}, WHOLE),
    "plate_fine_elastic": lambda r: plate(r, "plate_fine_elastic", NO_CRACKS, FINE, True),
    "plate_fine": lambda r: plate(r, "plate_fine", {}, FINE, True),
    "plate_fine_dem": lambda r: plate(r, "plate_fine_dem", {"start": "all"}, FINE, True),
    "front_elastic": lambda r: front(r, "front_elastic", "no", 60),
    "front": lambda r: front(r, "front", "yes", 600),
    "dem30000": lambda r: dem_block(r, "dem30000", 30000),
    "dem200000": lambda r: dem_block(r, "dem200000", 200000),
    "dem2000000": lambda r: dem_block(r, "dem2000000", 2000000, 40e6),
    "chute": case_chute,
    "lulesh": case_lulesh,
    "profile_elastic": profile_case("profile_elastic", {"stress": 1e30}),
    "profile_adaptive": profile_case("profile_adaptive", {}),
    "profile_rebuild": profile_case("profile_rebuild", {"stress": 1e30, "rebuild": "yes", "number": 200}),
    "profile_dem": profile_case("profile_dem", {"variant": "dem", "number": 300}),
}
# the long ones: at most so many rounds
ONCE_OR_TWICE = {"size2000000": 2, "bpm": 2, "plate": 2, "plate_ranks": 2, "plate_dem": 1, "plate_whole": 1, "plate_whole_slower": 1, "plate_whole_faster": 1,
                 "plate_whole_elastic": 1,
                 "plate_fine": 1, "plate_fine_elastic": 1, "plate_fine_dem": 1, "front": 1, "front_elastic": 1,
                 "dem2000000": 2, "event2000000": 2, "event_border2000000": 2}


# ---- profiles -----------------------------------------------------------------------------------

# Where a function belongs; the first that fits.
SHARES = [
    ("element kernel", r"fe::.*(add_forces|add_corotational)"),
    ("joints", r"corner_strain|PairDefe|cohesive|contact_law"),
    ("search for contacts", r"SurfaceSearch|HexPod|face_area|volume|jacobian|shape_gradient"),
    ("surface contact", r"DefeSurface::|[Ff]acet|[Ss]urface|patch_|penalty|friction|hypot"),
    ("criterion", r"DefeMarks::|max_principal|::stress\("),
    ("conversion", r"DefeConversion|FixDefe::pre_exchange|update_positions|birth|shield"),
    ("energy ledger", r"DefeWork|DefeAccount|EnergyWatch|FixDefe::(post_force|initial_integrate|end_of_step|setup|compute_)|DefeElements::energy"),
    ("local indices", r"FixDefe::|DefeTables|DefeElements|closest_image|is_orthogonal"),
    ("neighbour lists", r"NPair|NBin|NStencil|Neigh|MyPage"),
    ("time integration", r"FixNVE|FixSetForce"),
    ("rigid body", r"FixRigid"),
    ("communication", r"Comm|AtomVec|AtomMap|Atom::|opal|ompi|mca_|MPI_|PMPI"),
    ("memset, memcpy", r"mem(set|cpy|move)"),
    ("malloc, free", r"malloc|free|unlink_chunk|operator (new|delete)"),
    ("system", r"\[kernel|clock_gettime"),
    ("rest of LAMMPS", r""),
]


def read_profile(perf, data):
    """Samples by function: [(samples, library, function)], most first."""
    done = subprocess.run([perf, "report", "-i", str(data), "--stdio", "--no-children", "-n", "--sort", "dso,sym",
                           "-t", ";", "-q"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL,
                          text=True, check=True)
    functions = []
    for line in done.stdout.splitlines():
        words = [w.strip() for w in line.split(";", 3)]
        if len(words) == 4 and words[0].endswith("%"):
            functions.append((int(words[1]), words[2], re.sub(r"^\[.\]\s*", "", words[3])))
    if not functions:
        raise RuntimeError("perf report gave nothing")
    return sorted(functions, reverse=True)


def share_of(library, function):
    return next(name for name, pattern in SHARES if re.search(pattern, function) or (pattern and re.search(pattern, library)))


def pooled_profile(samples):
    """Fractions by share and by function, over all rounds."""
    shares, functions, total = {}, {}, 0
    for sample in samples:
        for count, library, function in sample["functions"]:
            total += count
            name = share_of(library, function)
            shares[name] = shares.get(name, 0) + count
            key = library, short(function)  # instances of one template together
            functions[key] = functions.get(key, 0) + count
    order = lambda d: sorted(((v / total, k) for k, v in d.items()), reverse=True)
    return {"samples": total, "shares": {k: round(v, 4) for v, k in order(shares)},
            "functions": [{"fraction": round(v, 4), "library": k[0], "function": k[1]} for v, k in order(functions)[:15]]}


# ---- the rows of the table ----------------------------------------------------------------------


class Line:
    """One figure. sense: +1 = at least the goal, -1 = at most."""

    def __init__(self, what, unit, values, goal=None, sense=+1, note=""):
        self.what, self.unit, self.goal, self.sense, self.note = what, unit, goal, sense, note
        self.values = [v for v in values if v is not None and math.isfinite(v)]

    def json(self, row):
        line = {"row": row, "what": self.what, "unit": self.unit, "goal": self.goal, "note": self.note,
                "goal_is": None if self.goal is None else "at least" if self.sense > 0 else "at most"}
        if self.values:
            value = statistics.median(self.values)
            line.update(value=value, lowest=min(self.values), highest=max(self.values), samples=len(self.values))
            if self.goal is not None:
                line["reached"] = self.sense * value >= self.sense * self.goal
        else:
            line.update(value=None)
        return line


class Samples:
    """What the rounds gave: samples[case] = list over the rounds, None where it was skipped."""

    def __init__(self, quick=False):
        self.of, self.skipped, self.quick = {}, {}, quick

    def values(self, case, key, scale=1.0):
        return [scale * s[key] for s in self.of.get(case, []) if s is not None]

    def ratios(self, a, b, key="loop_s"):
        """a / b within the rounds that have both."""
        return [x[key] / y[key] for x, y in zip(self.of.get(a, []), self.of.get(b, [])) if x and y]

    def google(self, case, name):
        return [s["rates"][name] for s in self.of.get(case, []) if s and name in s["rates"]]

    def why(self, *cases):
        return "; ".join(self.skipped[c] for c in cases if c in self.skipped)


def row_kernels(s):
    M = 1e-6
    def rate(name, what, note=""):
        return Line(what, "M element-steps/s", [M * v for v in s.google("kernels", name)], note=s.why("kernels") or note)
    def share(case):
        return [100 * a / b for a, b in zip(s.google(case, "add_forces/brick_bound/5150"), s.google(case, "bare<brick_K>/5150"))]
    return [
        rate("bare<gather_scatter>/5150", "bare loop: gather and scatter alone", "what any kernel is bound by"),
        rate("bare<brick_K>/5150", "bare loop: gather, Walsh-Hadamard brick K u, scatter"),
        rate("bare<dense_K>/5150", "bare loop: gather, dense K u, scatter"),
        rate("add_forces/brick_bound/5150", "brick kernel with criterion, outside LAMMPS"),
        Line("brick kernel with criterion by the bare transformed loop", "%", share("kernels"), 70.0 if has_avx512() else 60.0,
             note=s.why("kernels")),
        Line("the same built for AVX2", "%", share("kernels_avx2"), 60.0, note=s.why("kernels_avx2")),
        Line("brick kernel with criterion, AVX-512 by AVX2", "", [a / b for a, b in zip(
            s.google("kernels", "add_forces/brick_bound/5150"), s.google("kernels_avx2", "add_forces/brick_bound/5150"))],
             note=s.why("kernels_avx2")),
        rate("add_forces/enhanced_bound/5150", "total Lagrangian, enhanced elements, with criterion, outside LAMMPS"),
        rate("add_forces/lagrangian_bound/5150", "the same with plain elements"),
        Line("corner-strain joints, outside LAMMPS", "M DE-steps/s", [M * v for v in s.google("joint_kernels", "orthogonal/forces/0")],
             note=s.why("joint_kernels")),
    ]


def row_bricks(s):
    return [Line("congruent elastic bricks inside LAMMPS", "M element-steps/s", s.values("bricks", "rate", 1e-6), 12.0)]


def row_general(s):
    return [Line("general hexes, total Lagrangian, inside LAMMPS", "M element-steps/s", s.values("general", "rate", 1e-6), 3.5)]


def row_elastic(s):
    whole = [t / n * 1e6 for t, n in zip(s.values("elastic", "loop_s"), s.values("elastic", "steps"))]
    lines = [Line("elastic beam: a step", "us", whole)]
    kernel = s.google("kernels", "add_forces/brick_bound/5150")
    by_rate = [100 * (1 - 1e6 * BEAM_HEXES / k / t) for k, t in zip(kernel, whole)]
    samples = [x for x in s.of.get("profile_elastic", []) if x]
    sampled = []
    for x in samples:
        total = sum(c for c, _, _ in x["functions"])
        inside = sum(c for c, lib, f in x["functions"] if share_of(lib, f) == "element kernel")
        sampled.append(100 * (1 - inside / total))
    note = "samples of perf" if sampled else s.why("profile_elastic", "kernels")
    lines.append(Line("elastic beam: share of a step outside the element kernel", "%", sampled or by_rate, 35.0, -1, note))
    lines.append(Line("the same from the kernel's rate outside LAMMPS", "%", by_rate, note=s.why("kernels")))
    return lines


def row_dem(s):
    joints = [x["joints"] * x["steps"] / x["loop_s"] * 1e-6 for x in s.of.get("dem", []) if x]
    per_de = [b["rate"] and a["rate"] / b["rate"] for a, b in zip(s.of.get("dem", []), s.of.get("bpm", [])) if a and b]
    return [
        Line("pure DEM", "M DE-steps/s", s.values("dem", "rate", 1e-6), 6.0),
        Line("pure DEM", "M joint-steps/s", joints, 18.0),
        Line("pure DEM: times faster than bpm/rotational, per sphere", "", per_de, 6.5,
             note="39 600 DEs, 200 hexes, contact and output against 40 000 spheres"),
        Line("bpm/rotational, the same beam", "M atom-steps/s", s.values("bpm", "rate", 1e-6)),
        Line("bpm/spring, the same lattice, nothing breaks", "M bond-steps/s", s.values("bpm_spring", "rate", 1e-6)),
    ]


def row_adaptive(s):
    return [
        Line("adaptive beam, whole loop, 1667 steps", "s", s.values("adaptive", "loop_s"), 1.1, -1),
        Line("adaptive beam: times faster than bpm/rotational", "", s.ratios("bpm", "adaptive"), 24.0),
        Line("adaptive beam: times faster than our pure DEM", "", s.ratios("dem", "adaptive"), 8.0),
        Line("pure DEM, whole loop", "s", s.values("dem", "loop_s")),
        Line("bpm/rotational, whole loop", "s", s.values("bpm", "loop_s")),
    ]


def row_two_clocks(s):
    one = s.values("adaptive", "converted")
    note = s.why("two_clocks") or (f"{one[0]:.0f} with one clock; 50 to 60 wanted" if one else "")
    return [
        Line("adaptive beam with two clocks (elements every 2nd step)", "s", s.values("two_clocks", "loop_s"), 0.6, -1,
             s.why("two_clocks")),
        Line("two clocks: elements converted", "", s.values("two_clocks", "converted"), note=note),
    ]


def row_laws(s):
    return [
        Line("adaptive beam, 90 us: cracks by the stress by the law lattice, processor time", "",
             s.ratios("law_rings", "law_lattice", "loop_cpu_s"), 1.10, -1),
        Line("pure DEM, 90 us: cracks by the stress by the law lattice, processor time", "",
             s.ratios("law_dem_rings", "law_dem_lattice", "loop_cpu_s"), 1.15, -1),
    ]


def conversion_cost(traces):
    """Extra time of every conversion event, in ordinary steps and in seconds: [(step, cost, seconds)].

    The runs are the same step by step, so that the shortest time of a step over the rounds is free of
    what else the machine did. An event costs what the step in which it happens and the two after it
    take longer than the median of the steps around."""
    if not traces:
        return []
    steps = sorted(traces[0]["times"])
    best = {n: min(t["times"][n] for t in traces) for n in steps}
    events = [n for n in traces[0]["conversions"] if n in best]
    cost = []
    for n in events:
        around = [best[m] for m in range(n - 25, n + 26) if m in best and all(abs(m - e) > 2 for e in events)]
        if len(around) < 5:
            around = [best[m] for m in steps if all(abs(m - e) > 2 for e in events) and abs(m - n) < 100]
        after = [m for m in (n, n + 1, n + 2) if m in best and not (m > n and any(m >= e > n for e in events))]
        ordinary = statistics.median(around)
        extra = sum(best[m] - ordinary for m in after)
        cost.append((n, extra / ordinary, extra))
    return cost


def row_event(s):
    traces = [t for t in s.of.get("trace", []) if t]
    cost = [c for _, c, _ in conversion_cost(traces)]
    return [
        Line("one conversion event: extra time in ordinary steps (median of the events)", "steps",
             [statistics.median(cost)] if cost else [], 3.0, -1, f"{len(cost)} events" if cost else "no conversion"),
        Line("the dearest event", "steps", [max(cost)] if cost else [], 3.0, -1),
    ]


EVENTS = ["event20000", "event200000", "event2000000"]


def row_event_size(s):
    lines, seconds = [], {}
    for case in EVENTS:
        traces = [t for t in s.of.get(case, []) if t]
        cost = conversion_cost(traces)
        if cost:
            hexes = grouped(traces[0]["hexes"])
            lines.append(Line(f"one conversion event beside {hexes} hexes: extra time in ordinary steps (median)", "steps",
                              [statistics.median(c for _, c, _ in cost)], 0.05, -1, f"{len(cost)} events"))
            seconds[case] = statistics.median(t for _, _, t in cost)
    lines.append(Line("the same in seconds: largest by smallest mesh", "",
                      [seconds[EVENTS[-1]] / seconds[EVENTS[0]]] if EVENTS[-1] in seconds and EVENTS[0] in seconds else [], 1.0, -1))
    return lines


BORDERS = ["event_border200000", "event_border2000000"]


def row_event_border(s):
    lines = []
    for case in BORDERS:
        traces = [t for t in s.of.get(case, []) if t]
        cost = conversion_cost(traces)
        if cost:
            lines.append(Line(f"one conversion event upon the border of two ranks, {grouped(traces[0]['hexes'])} hexes: extra time in ordinary steps (median)", "steps",
                              [statistics.median(c for _, c, _ in cost)], 0.05, -1, "; ".join([f"{len(cost)} events"] + [w for w in [few_cores()] if w])))
    return lines


def row_plate(s):
    # how much breaks depends on the last digits once glass is crushed: three balls
    whole = [ratio for case in ("plate_whole_slower", "plate_whole", "plate_whole_faster") for ratio in s.ratios(case, "plate_whole_elastic")]
    return [
        Line("laminated plate 2 mm, 100 us: adaptive by elastic", "", whole, 3.0, -1, "balls of 14.99, 15 and 15.01 m/s"),
        Line("laminated plate 2 mm, 40 us: adaptive by elastic", "", s.ratios("plate", "plate_elastic"), 3.0, -1),
        Line("laminated plate 2 mm, 40 us: pure DEM by adaptive", "", s.ratios("plate_dem", "plate"), 8.0),
        Line("laminated plate 2 mm, 40 us: speed-up on two ranks", "", s.ratios("plate", "plate_ranks"), 1.7, note=few_cores()),
        Line("laminated plate 1 mm, 20 us: adaptive by elastic", "", s.ratios("plate_fine", "plate_fine_elastic"), 3.0, -1),
        Line("laminated plate 1 mm, 20 us: pure DEM by adaptive", "", s.ratios("plate_fine_dem", "plate_fine"), 8.0),
    ]


def row_front(s):
    pairs = [(a, b) for a, b in zip(s.of.get("front", []), s.of.get("front_elastic", [])) if a and b]
    hexes = grouped(20**3 if s.quick else 100**3)
    return [Line(f"crack front through {hexes} hexes, a step by an elastic one", "", [a["per_step"] / b["per_step"] for a, b in pairs],
                 1.5, -1, f"{pairs[0][0]['converted']} elements convert" if pairs else s.why("front", "front_elastic"))]


def few_cores():
    return "" if len(os.sched_getaffinity(0)) >= 2 else "fewer than two cores here"


def grouped(n):
    return f"{n:,}".replace(",", " ")


def row_ranks(s):
    return [Line("two ranks, block of 200 000 hexes: speed-up", "", s.ratios("ranks1", "ranks2"), 1.8, note=few_cores())]


SIZES = ["size5000", "size20000", "size200000", "size2000000"]


def row_size(s):
    lines = []
    medians = {}
    for case in SIZES:
        samples = [x for x in s.of.get(case, []) if x]
        if samples:
            cost = [1e9 / x["rate"] for x in samples]
            medians[case] = statistics.median(cost)
            hexes = grouped(samples[0]["hexes"])
            lines.append(Line(f"cost of an element-step, {hexes} hexes", "ns", cost))
    spread = [max(medians.values()) / min(medians.values())] if len(medians) == len(SIZES) else []
    lines.append(Line("dearest by cheapest of these", "", spread, 1.5, -1))
    big = [x for x in s.of.get(SIZES[-1], []) if x]
    lines.append(Line("peak memory per hex, LAMMPS included, largest block", "kB", [x["bytes_per_hex"] / 1000 for x in big], 1.0, -1))
    return lines


DEMS = ["dem30000", "dem200000", "dem2000000"]


def row_dem_size(s):
    lines, medians = [], {}
    for case in DEMS:
        samples = [x for x in s.of.get(case, []) if x]
        if samples:
            rates = [1e-6 * x["rate"] for x in samples]
            medians[case] = statistics.median(rates)
            lines.append(Line(f"pure DEM, block of {grouped(samples[0]['des'])} DEs", "M DE-steps/s", rates))
    slower = [100 * (1 - min(medians.values()) / max(medians.values()))] if len(medians) == len(DEMS) else []
    lines.append(Line("slowest of these by the fastest: less by", "%", slower, 15.0, -1))
    big = [x for x in s.of.get(DEMS[-1], []) if x]
    lines.append(Line("pure DEM: peak memory per DE, LAMMPS included, largest block", "kB", [x["bytes_per_de"] / 1000 for x in big], 0.7, -1))
    return lines


def row_peers(s):
    return [
        Line("LAMMPS' chute benchmark", "M atom-steps/s", s.values("chute", "rate", 1e-6), note=s.why("chute")),
        Line("LULESH, one-point hex", "M element-steps/s", s.values("lulesh", "rate", 1e-6),
             note=s.why("lulesh") + "; 1.55 on a machine like this, as given" if "lulesh" in s.skipped else ""),
    ]


ROWS = {
    "kernels": (row_kernels, ["kernels", "kernels_avx2", "joint_kernels"]),
    "bricks": (row_bricks, ["bricks"]),
    "general": (row_general, ["general"]),
    "elastic": (row_elastic, ["elastic", "kernels", "profile_elastic"]),
    "dem": (row_dem, ["dem", "bpm", "bpm_spring"]),
    "adaptive": (row_adaptive, ["adaptive", "dem", "bpm"]),
    "two_clocks": (row_two_clocks, ["two_clocks", "adaptive"]),
    "laws": (row_laws, ["law_rings", "law_lattice", "law_dem_rings", "law_dem_lattice"]),
    "event": (row_event, ["trace"]),
    "event_size": (row_event_size, EVENTS),
    "event_border": (row_event_border, BORDERS),
    "plate": (row_plate, ["plate_elastic", "plate", "plate_ranks", "plate_dem", "plate_whole_elastic", "plate_whole", "plate_whole_slower",
                          "plate_whole_faster", "plate_fine_elastic", "plate_fine", "plate_fine_dem"]),
    "front": (row_front, ["front_elastic", "front"]),
    "ranks": (row_ranks, ["ranks1", "ranks2"]),
    "size": (row_size, SIZES),
    "dem_size": (row_dem_size, DEMS),
    "peers": (row_peers, ["chute", "lulesh"]),
}
PROFILES = {"profile_elastic": "elastic beam", "profile_adaptive": "adaptive beam",
            "profile_rebuild": "elastic beam, reneighbouring in every step (most of what a conversion costs)",
            "profile_dem": "pure DEM"}


# ---- the machine --------------------------------------------------------------------------------


def read(path, default=""):
    try:
        return Path(path).read_text(errors="replace")
    except OSError:
        return default


def command_output(*command):
    try:
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL,
                              text=True, cwd=ROOT).stdout.strip()
    except OSError:
        return ""


def machine(build):
    cpu = read("/proc/cpuinfo")
    field = lambda name: (re.search(rf"^{name}\s*:\s*(.*)", cpu, re.M) or [None, ""])[1]
    cache = {}
    for folder in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        cache[f"L{read(folder / 'level').strip()} {read(folder / 'type').strip()}"] = read(folder / "size").strip()
    settings = dict(re.findall(r"^(\w+):\w+=(.*)$", read(build / "CMakeCache.txt"), re.M))
    compiler = settings.get("CMAKE_CXX_COMPILER", "c++")
    flags = field("flags").split()
    return {
        "cpu": field("model name") or platform.processor(),
        "cores": len(os.sched_getaffinity(0)),
        "hypervisor": "hypervisor" in flags,
        "simd": [f for f in ("sse2", "avx", "avx2", "fma", "avx512f", "avx512dq") if f in flags],
        "cache": cache,
        "memory_GB": round(int((re.search(r"MemTotal:\s*(\d+)", read("/proc/meminfo")) or [0, 0])[1]) / 1e6, 1),
        "kernel": platform.release(),
        "compiler": command_output(compiler, "--version").split("\n")[0],
        "build_type": settings.get("CMAKE_BUILD_TYPE", ""),
        "flags": settings.get("CMAKE_CXX_FLAGS_RELEASE", ""),
        "native": settings.get("DEFE_NATIVE", ""),
        "commit": command_output("git", "describe", "--always", "--dirty"),
        "load_before": os.getloadavg()[0],
    }


# ---- the page -----------------------------------------------------------------------------------


def number(value):
    if value is None:
        return "-"
    if value == 0:
        return "0"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:.{digits}f}"


def table(report):
    text = ["| what | measured | range | to reach | |", "|---|---|---|---|---|"]
    for line in report["lines"]:
        goal = "" if line["goal"] is None else f"{line['goal_is']} {line['goal']:g}"
        mark = {True: "reached", False: "**not reached**", None: ""}[line.get("reached")]
        spread = "" if line.get("samples", 0) < 2 else f"{number(line['lowest'])} to {number(line['highest'])}"
        note = "; ".join(t for t in (mark, line["note"]) if t)
        unit = f" {line['unit']}" if line["unit"] and line["value"] is not None else ""
        text.append(f"| {line['what']} | {number(line['value'])}{unit} | {spread} | {goal} | {note} |")
    return "\n".join(text)


def short(function):
    """A function's name without its arguments and template parameters."""
    name = re.sub(r"\(anonymous namespace\)::|\[clone [^]]*\]", "", function)
    depth, out = 0, ""
    for c in name:
        if c in "<(":
            depth += 1
        elif c in ">)":
            depth -= 1
        elif depth == 0:
            out += c
    out = out.replace("LAMMPS_NS::", "").replace("defe::", "").strip()
    return re.sub(r"^(void|double|int|bool|auto) ", "", out) or function


def profile_tables(report):
    text = []
    for key, profile in report["profiles"].items():
        text += ["", f"**{PROFILES[key][0].upper() + PROFILES[key][1:]}** ({profile['samples']} samples of the steps alone): " +
                 ", ".join(f"{name} {100 * f:.1f} %" for name, f in profile["shares"].items() if f >= 0.002) + ".", "",
                 "| % | function | in |", "|---|---|---|"]
        text += [f"| {100 * f['fraction']:.1f} | `{f['function']}` | {f['library']} |" for f in profile["functions"] if f["fraction"] >= 0.005]
    return "\n".join(text)


def heading(report):
    m = report["machine"]
    disturbed = f" {report['disturbed']} of {report['runs']} runs did not have their core to themselves (see README.md)." if report["disturbed"] else ""
    return (f"{report['date']}, commit {m['commit']}{', quick: figures mean nothing' if report['quick'] else ''}. "
            f"{m['cpu']}, {m['cores']} cores{' of a virtual machine' if m['hypervisor'] else ''}, "
            f"{', '.join(f'{k} {v}' for k, v in m['cache'].items())}; {m['compiler']}, {m['build_type']}, "
            f"{'-march=native' if m['native'] == 'ON' else 'portable'}. One core per rank; {report['rounds']} rounds.{disturbed}")


def page(report):
    text = [heading(report), "", table(report)]
    if report["profiles"]:
        text += ["", "Where the time of a step goes (perf, by function):", profile_tables(report)]
    return "\n".join(text) + "\n"


def in_page(path, replace):
    """Replaces what the page has between its marks."""
    begin, end = "<!-- results: written by run.sh --page -->", "<!-- end of results -->"
    old = path.read_text()
    if begin not in old or end not in old:
        sys.exit(f"{path.name} has no place for results")
    first, last = old.index(begin) + len(begin), old.index(end)
    path.write_text(old[:first] + "\n\n" + replace(old[first:last].strip()) + "\n" + old[last:])


def of_line(line):
    """What a line of the table is about: two may have the same words and other units."""
    columns = [c.strip() for c in line.split(" | ")]
    return columns[0], columns[1].partition(" ")[2] if len(columns) > 1 else ""


def with_rows(old, report, rows):
    """The page's results with these rows measured anew, each in its place, and said so in its heading."""
    fresh = {of_line(line): line for line in table(report).splitlines()[2:]}
    order = list(fresh)
    lines = [fresh.get(of_line(line), line) if line.startswith("| ") else line for line in old.splitlines()]
    for k, what in enumerate(order):    # those that the page does not have yet: behind the one before
        here = [n for n, line in enumerate(lines) if line.startswith("| ") and of_line(line) == what]
        if not here:
            before = [n for n, line in enumerate(lines) if k and line.startswith("| ") and of_line(line) == order[k - 1]]
            lines.insert(before[-1] + 1 if before else len(lines), fresh[what])
    about = f"Rows {', '.join(rows)}: "
    lines = [line for line in lines if not line.startswith(about)]
    first = next(n for n, line in enumerate(lines) if line.startswith("|"))
    said = [line for line in lines[:first] if line] + [about + heading(report)]
    return "\n\n".join(said) + "\n\n" + "\n".join(lines[first:]) + "\n"


# ---- main ---------------------------------------------------------------------------------------


def main():
    parser = argparse.ArgumentParser(description="Measures DEFE and its peers.")
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--profile", action="store_true")
    parser.add_argument("--page", type=Path)
    parser.add_argument("rows", nargs="*", help=", ".join(ROWS))
    args = parser.parse_args()
    unknown = [r for r in args.rows if r not in ROWS]
    if unknown:
        sys.exit(f"unknown row {unknown[0]}: use {', '.join(ROWS)}")
    rows = args.rows or list(ROWS)
    rounds = args.rounds or (1 if args.quick else 5)
    args.build, args.out = args.build.resolve(), args.out.resolve()
    args.out.mkdir(parents=True, exist_ok=True)
    runner = Runner(args.build, args.out, args.quick)
    if not runner.lmp.exists() or not (args.build / "defeplugin.so").exists():
        sys.exit(f"no lmp or no defeplugin.so in {args.build}: build DEFE first")

    about = machine(args.build)
    if about["load_before"] > 0.5 and not args.quick:
        print(f"benchmarks: load {about['load_before']:.1f} before the first run: something else is running", file=sys.stderr)

    cases = list(dict.fromkeys(c for r in rows for c in ROWS[r][1]))
    if args.profile:
        cases += [c for c in PROFILES if c not in cases]
    samples = Samples(args.quick)
    samples.of = {c: [] for c in cases}
    for turn in range(rounds):
        for case in cases:
            if case in samples.skipped or turn >= ONCE_OR_TWICE.get(case, rounds):
                samples.of[case].append(None)
                continue
            print(f"benchmarks: round {turn + 1} of {rounds}: {case}", file=sys.stderr, flush=True)
            try:
                samples.of[case].append(CASES[case](runner))
            except Skip as reason:
                samples.skipped[case] = str(reason)
                samples.of[case].append(None)

    lines = [line.json(row) for row in rows for line in ROWS[row][0](samples)]
    # a run that waits for nothing uses all of its core: less means that something else had a share
    single = [s for c in cases for s in samples.of[c] if s and s["cpu_share"] is not None and s["wall_s"] > 0.2]
    report = {
        "date": datetime.date.today().isoformat(),
        "quick": args.quick,
        "rounds": rounds,
        "machine": about,
        "lines": lines,
        "profiles": {c: pooled_profile([x for x in samples.of[c] if x]) for c in PROFILES
                     if args.profile and any(samples.of.get(c, []))},
        "skipped": samples.skipped,
        "runs": len(single),
        "disturbed": sum(s["cpu_share"] < 0.97 for s in single),
        "cases": {c: [{k: v for k, v in s.items() if k not in ("log", "times", "functions", "conversions")} if s else None
                      for s in samples.of[c]] for c in cases},
        "conversions": [{"step": n, "cost": round(c, 3)} for n, c, _ in conversion_cost([t for t in samples.of.get("trace", []) if t])],
    }
    (args.out / "results.json").write_text(json.dumps(report, indent=1) + "\n")
    text = page(report)
    (args.out / "results.md").write_text(text)
    print(text)
    if args.page:
        in_page(args.page, lambda old: with_rows(old, report, args.rows) if args.rows else text)


if __name__ == "__main__":
    main()
