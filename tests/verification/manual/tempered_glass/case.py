"""See README.md."""

import contextlib
import dataclasses
import importlib.util
import io
import shutil

import defe
import numpy as np
from manual import ROOT, Accept, number, plt

SLOW = True
WAVE = 5700.0    # m/s, of longitudinal waves
TITLE = "Fragments of tempered glass"
COUNTS = "counts of 8 mm panes, means of 4 to 15 panes each"
EXAMPLE = ROOT / "examples" / "tempered_pane"
FINE, COARSE = 0.5e-3, 1e-3    # m, elements
# --fine: elements, side of the piece (m) and time (s). What cracks take too much goes with strength^2 times the size of elements, so more stress wants
# finer ones; as fine as some twenty minutes of a core give.
FINEST = {102: (0.25e-3, 0.016, 1e-5), 112: (0.25e-3, 0.016, 1e-5), 136: (0.25e-3, 0.016, 9e-6), 154: (0.2e-3, 0.012, 6e-6), 163: (0.2e-3, 0.012, 6e-6)}
STRESSES = (102, 136, 163)    # MPa at the faces; --fine has all that are published
BLOWS = (19.0, 20.0, 21.0)    # m/s, of FINE: which should not matter, and says how much chance does
BLOW = 20.0
RING, MOVED, ALL = "ring", "moved", "all"    # planes of symmetry and a ring that does not convert, with an irregular mesh; DEs from the start
ONE, NUCLEI = "one", "nuclei"    # the strength of the pane of 163 MPa for all; nuclei at the strength, branches at twice of it
SIDE, END = 0.016, 1.2e-5    # m, s


def strength_of(mpa):
    """(Pa) just above the highest tension, half of what is at the faces."""
    return 1.08 * 0.5e6 * mpa


def module_of(name):
    spec = importlib.util.spec_from_file_location("tempered_pane_" + name, EXAMPLE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


example, piece = module_of("analyse"), module_of("piece")
PUBLISHED = example.PUBLISHED
ACCEPTANCE = [Accept(f"cells in 50 x 50 mm, {mpa} MPa, 0.5 mm", COUNTS, low=0.5 * PUBLISHED[mpa], high=2.0 * PUBLISHED[mpa], known=True) for mpa in STRESSES]
ACCEPTANCE += [Accept(f"cells in 50 x 50 mm, {mpa} MPa, {1e3 * FINEST[mpa][0]:g} mm", COUNTS, low=0.5 * count, high=2.0 * count, fine=True)
               for mpa, count in sorted(PUBLISHED.items())]
ACCEPTANCE += [
    Accept("cells at 154 and 163 MPa over those at 102 and 112 MPa", COUNTS, target=2.4, tolerance=0.8, digits=2, fine=True, known=True),
    Accept("speed of the crack front, 163 MPa", "measured", target=1460.0, tolerance=150.0, unit="m/s", digits=4, known=True),
    Accept("energy at rest over the exact one of an infinite pane, 163 MPa", "(1 - nu) sigma^2 h/(5 E)", low=0.95, high=1.0),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%", digits=2),
]


@dataclasses.dataclass(frozen=True)
class Job:
    mpa: int    # at the faces
    edge: float    # m, of the elements
    side: float = SIDE    # m, of the piece
    end: float = END    # s
    how: str = ""
    blow: float = BLOW    # m/s

    @property
    def name(self):
        return f"{self.mpa}_{1e3 * self.edge:.3g}{'_' if self.how else ''}{self.how}" + ("" if self.blow == BLOW else f"_{self.blow:g}")

    @property
    def dt(self):
        return 2.5e-5 * self.edge

    @property
    def options(self):
        """What is special, of the input's variables."""
        return {ONE: {"strength": strength_of(163)}, NUCLEI: {"nuclei": 0, "branch": 2}}.get(self.how, {})


def run(s):
    stresses = sorted(PUBLISHED) if s.fine else STRESSES
    finest = {mpa: Job(mpa, *FINEST[mpa]) if s.fine else Job(mpa, FINE) for mpa in stresses}
    jobs = list(finest.values()) if s.fine else []    # the longest first
    jobs += [Job(mpa, FINE, blow=blow) for mpa in stresses for blow in BLOWS]
    jobs += [Job(102, FINE, how=ONE), Job(163, FINE, how=NUCLEI)]
    jobs += [Job(mpa, COARSE) for mpa in STRESSES] + [Job(163, COARSE, how=how) for how in (RING, MOVED, ALL)]
    for how in (RING, MOVED):
        defe.write_mesh(s.path(f"{how}.data"), piece.mesh(SIDE, COARSE, 0.2 if how == MOVED else 0.0))

    def simulate(job):
        options = {"strength": strength_of(job.mpa), "nuclei": "auto", "branch": 1.3, **job.options}
        s.lammps(EXAMPLE / "in.tempered_pane", job.name, surface=1e6 * job.mpa, side=job.side, edge=job.edge, dt=job.dt, end=job.end, element="plain", pictures="no",
                 blow=job.blow, sides="symmetric" if job.how in (RING, MOVED) else "periodic", mesh=f"{job.how}.data", start="all" if job.how == ALL else "no", **options)
        shutil.copy(s.path(job.name + ".log"), s.path(job.name) / "log.lammps")    # where the example's analysis looks for it

    def analysed(job):
        with contextlib.redirect_stdout(io.StringIO()):    # of the whole process: not while others run
            example.main(s.path(job.name))
        return defe.read_summary(s.path(job.name) / "summary.json")

    def speed(r):
        """Of the front; faster than waves: it breaks everywhere at once."""
        v = r["crack_speed_m_s"]
        return "-" if v is None else f"{v:.0f}" if v < WAVE else "at once"

    s.all(simulate, jobs)
    found = {job: analysed(job) for job in jobs}
    rows = [["MPa at the faces", "elements (mm)", "", "piece (mm)", "after (us)", "strength (MPa)", "stored (J/m2)", "at rest (J/m2)", "taken by cracks (J/m2)",
             "crack area by pane area", "taken per crack area (J/m2)", "squares in 50 x 50 mm", "cells", "closed", "in one layer", "published", "speed (m/s)", "converted",
             "processor time (s)", "energy rises (%)"]]
    words = {RING: "ring", MOVED: "ring, nodes moved by 20 %", ALL: "all DEs", ONE: "strength of 163 MPa", NUCLEI: "nuclei at the strength"}
    for job, r in found.items():
        rows.append([job.mpa, f"{1e3 * job.edge:.3g}", words.get(job.how, "" if job.blow == BLOW else f"blow of {job.blow:g} m/s"), f"{1e3 * job.side:g}",
                     f"{1e6 * job.end:g}", f"{1e-6 * job.options.get('strength', strength_of(job.mpa)):.0f}", f"{r['stored_per_area_J_m2']:.0f}", f"{r['at_rest_per_area_J_m2']:.0f}",
                     f"{r['fracture_J_m2']:.0f}", f"{r['crack_area_by_pane_area']:.2f}", number(r["taken_per_crack_area_J_m2"]), f"{r['squares_in_50_x_50_mm']:.0f}",
                     f"{r['cells_of_layers_in_50_x_50_mm']:.0f}", f"{r['closed_cells_of_layers_in_50_x_50_mm']:.0f}", f"{r['pieces_of_the_middle_in_50_x_50_mm']:.0f}",
                     PUBLISHED[job.mpa], speed(r),
                     r["elements_converted"], f"{s.loops[job.name]:.0f}", f"{100 * s.energies(job.name).rise():.3f}"])
    s.table("All runs, with a blow of 20 m/s where nothing else is said:", rows)

    def cells_of(job):
        return found[job]["cells_of_layers_in_50_x_50_mm"]

    def squares_of(job):
        return found[job]["squares_in_50_x_50_mm"]

    blows = {mpa: [cells_of(Job(mpa, FINE, blow=blow)) for blow in BLOWS] for mpa in stresses}
    figure, ax = plt.subplots(figsize=(6, 4))
    published = np.array(sorted(PUBLISHED.items()), float).T
    ax.fill_between(published[0], 0.5 * published[1], 2.0 * published[1], color="0.9", label="half to twice of it")
    ax.plot(*published, "k-s", label="published")
    if s.fine:
        ax.plot(stresses, [cells_of(finest[m]) for m in stresses], "o-", color="#c0504d", label="cells here, 0.25 and 0.2 mm")
        ax.plot(stresses, [squares_of(finest[m]) for m in stresses], "o:", mfc="none", color="#1f4e9c", label="squares here, 0.25 and 0.2 mm")
    ax.errorbar(stresses, [np.mean(blows[m]) for m in stresses], [np.std(blows[m], ddof=1) for m in stresses], fmt="^--", capsize=3, color="#e0a030",
                label=f"cells here, 0.5 mm, {len(BLOWS)} blows")
    ax.plot(STRESSES, [cells_of(Job(m, COARSE)) for m in STRESSES], "x:", color="0.5", label="cells here, 1 mm")
    ax.set(xlabel="compression at the faces (MPa)", ylabel="in 50 x 50 mm", ylim=(0, 2.2 * max(PUBLISHED.values())))
    ax.legend(fontsize=8)
    figure.tight_layout()
    s.figure(figure, "fragments", "Fragments that were counted, and cells and squares of the cracks beside the middle plane here"
             + (" (squares beyond the plot are in the table)." if s.fine else "."))

    figure, axes = plt.subplots(1, len(STRESSES), figsize=(10.5, 3.9))
    for ax, mpa in zip(axes, STRESSES):
        job = finest[mpa]
        x = defe.read_events(s.path(job.name) / "events.txt").of("broken").x * 1e3
        middle = np.abs(x[:, 2] - 4.0) < 0.51
        ax.scatter(x[middle, 0], x[middle, 1], s=1, color="#1f4e9c", linewidths=0)
        ax.set(xlim=(0, 1e3 * job.side), ylim=(0, 1e3 * job.side), aspect="equal", title=f"{mpa} MPa", xlabel="mm")
    figure.tight_layout()
    s.figure(figure, "cracks", "Broken joints of the middle millimetre, from above, at the end.")
    s.plot_energies(finest[163].name, finest[163].dt, "163 MPa")

    values = {f"cells in 50 x 50 mm, {mpa} MPa, 0.5 mm": np.mean(blows[mpa]) for mpa in STRESSES}
    if s.fine:
        values.update({f"cells in 50 x 50 mm, {mpa} MPa, {1e3 * FINEST[mpa][0]:g} mm": cells_of(finest[mpa]) for mpa in stresses})
        values["cells at 154 and 163 MPa over those at 102 and 112 MPa"] = (
            (cells_of(finest[154]) + cells_of(finest[163])) / max(cells_of(finest[102]) + cells_of(finest[112]), 1e-9))
    high = found[finest[163]]
    values["speed of the crack front, 163 MPa"] = high["crack_speed_m_s"]
    values["energy at rest over the exact one of an infinite pane, 163 MPa"] = high["at_rest_per_area_J_m2"] / high["stored_per_area_J_m2"]
    values["largest rise of the total energy"] = 100.0 * max(s.energies(job.name).rise() for job in jobs)
    return values
