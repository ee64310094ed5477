"""See README.md."""

import contextlib
import importlib.util
import io
import shutil

import defe
import numpy as np
from manual import ROOT, Accept, plt

SLOW = True
WAVE = 5700.0    # m/s, of longitudinal waves
TITLE = "Fragments of tempered glass"
COUNTS = "counts of 8 mm panes, means of 4 to 15 panes each"
EXAMPLE = ROOT / "examples" / "tempered_pane"
FINE, COARSE = 0.5e-3, 1e-3    # m, elements
FINEST = {102: 0.25e-3, 112: 0.25e-3, 136: 1e-3 / 3, 154: 1e-3 / 3, 163: 1e-3 / 3}    # --fine: finer where little drives the cracks
STRENGTH = 88e6    # Pa, of all panes: 1.08 times the highest tension, that of 163 MPa
STRESSES = (102, 136, 163)    # MPa at the faces; --fine has all that are published
RING, MOVED, ALL = "ring", "moved", "all"    # planes of symmetry and a ring that does not convert, with an irregular mesh; DEs from the start
SCALED = (102, 163)    # with a strength in proportion to the stress, beside them
SMALL, LARGE, LARGEST = 0.016, 0.02, 0.024    # m, pieces of a pane: larger where cracks run far before they branch


def side(mpa, fine):
    return SMALL if mpa > 120 else LARGE if fine else LARGEST


def module_of(name):
    spec = importlib.util.spec_from_file_location("tempered_pane_" + name, EXAMPLE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


example, piece = module_of("analyse"), module_of("piece")
PUBLISHED = example.PUBLISHED
ACCEPTANCE = [Accept(f"cells in 50 x 50 mm, {mpa} MPa, within a factor of two", COUNTS, low=0.5 * PUBLISHED[mpa], high=2.0 * PUBLISHED[mpa],
                     known=True) for mpa in STRESSES]
ACCEPTANCE += [
    Accept("cells at 163 MPa over those at 102 MPa", COUNTS, target=2.7, tolerance=0.8, digits=2, known=True),
    Accept("speed of the crack front, 163 MPa", "measured", target=1460.0, tolerance=150.0, unit="m/s", digits=4, known=True),
    Accept("energy at rest over the exact one of an infinite pane, 163 MPa", "(1 - nu) sigma^2 h/(5 E)", low=0.95, high=1.0),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%", digits=2),
]


def run(s):
    # stress at the faces, elements, side of the piece, strength, and what is special
    jobs = [(mpa, FINEST[mpa] if s.fine else FINE, side(mpa, s.fine), STRENGTH, "") for mpa in (sorted(PUBLISHED) if s.fine else STRESSES)]
    jobs += [(mpa, COARSE, SMALL, STRENGTH, "") for mpa in STRESSES] + [(mpa, COARSE, SMALL, 0.54e6 * mpa, "scaled") for mpa in SCALED]
    jobs += [(163, COARSE, SMALL, STRENGTH, how) for how in (RING, MOVED, ALL)]
    for how in (RING, MOVED):
        defe.write_mesh(s.path(f"{how}.data"), piece.mesh(SMALL, COARSE, 0.2 if how == MOVED else 0.0))

    def one(job):
        mpa, edge, length, strength, how = job
        name = f"{mpa}_{1e3 * length:g}_{1e3 * edge:.3g}{'_' if how else ''}{how}"
        dt = 2.5e-5 * edge
        s.lammps(EXAMPLE / "in.tempered_pane", name, surface=1e6 * mpa, strength=strength, side=length, edge=edge, dt=dt, end=1.2e-5, element="plain", pictures="no",
                 sides="symmetric" if how in (RING, MOVED) else "periodic", mesh=f"{how}.data",
                 start="all" if how == ALL else "no")
        shutil.copy(s.path(name + ".log"), s.path(name) / "log.lammps")    # where the example's analysis looks for it
        with contextlib.redirect_stdout(io.StringIO()):
            example.main(s.path(name))
        return name, dt, defe.read_summary(s.path(name) / "summary.json"), defe.read_events(s.path(name) / "events.txt")

    def speed(r):
        """Of the front; faster than waves: it breaks everywhere at once."""
        v = r["crack_speed_m_s"]
        return "-" if v is None else f"{v:.0f}" if v < WAVE else "at once"

    found = dict(zip(jobs, s.all(one, jobs)))
    rows = [["MPa at the faces", "elements (mm)", "", "piece (mm)", "strength (MPa)", "stored (J/m2)", "at rest (J/m2)", "taken by cracks (J/m2)",
             "crack area by pane area", "squares in 50 x 50 mm", "with joints that soften", "cells", "published", "speed (m/s)", "converted",
             "processor time (s)", "energy rises (%)"]]
    for (mpa, edge, length, strength, how), (name, _, r, _) in found.items():
        rows.append([mpa, f"{1e3 * edge:.3g}", {RING: "ring", MOVED: "ring, nodes moved by 20 %", ALL: "all DEs"}.get(how, ""), f"{1e3 * length:g}", f"{1e-6 * strength:.0f}", f"{r['stored_per_area_J_m2']:.0f}",
                     f"{r['at_rest_per_area_J_m2']:.0f}", f"{r['fracture_J_m2']:.0f}", f"{r['crack_area_by_pane_area']:.2f}",
                     f"{r['squares_in_50_x_50_mm']:.0f}", f"{r['squares_of_softening_joints_too']:.0f}",
                     f"{r['pieces_of_the_middle_in_50_x_50_mm']:.0f}", PUBLISHED[mpa], speed(r), r["elements_converted"],
                     f"{s.loops[name]:.0f}", f"{100 * s.energies(name).rise():.3f}"])
    s.table("All runs:", rows)

    figure, ax = plt.subplots(figsize=(6, 4))
    published = np.array(sorted(PUBLISHED.items()), float).T
    ax.fill_between(published[0], 0.5 * published[1], 2.0 * published[1], color="0.9", label="half to twice of it")
    ax.plot(*published, "k-s", label="published")
    finest = "here, 0.25 and 0.33 mm" if s.fine else "here, 0.5 mm"
    for chosen, style, label in ((lambda j: j[1] < COARSE, "o-", finest),
                                 (lambda j: j[1] == COARSE and not j[4], "^--", "here, 1 mm"),
                                 (lambda j: j[4] == "scaled", "x:", "here, 1 mm, strength in proportion")):
        runs = sorted((job[0], found[job][2]) for job in jobs if chosen(job))
        line = ax.plot([m for m, _ in runs], [r["squares_in_50_x_50_mm"] for _, r in runs], style, label=label)
        if style == "o-":
            ax.plot([m for m, _ in runs], [r["pieces_of_the_middle_in_50_x_50_mm"] for _, r in runs], "o", mfc="none", color=line[0].get_color(),
                    label=f"{finest}, closed cells")
    ax.set(xlabel="compression at the faces (MPa)", ylabel="in 50 x 50 mm", ylim=(0, None))
    ax.legend(fontsize=8)
    figure.tight_layout()
    s.figure(figure, "fragments", "Fragments that were counted, and squares and cells of the cracks beside the middle plane here.")

    fine = {job[0]: found[job] for job in jobs if job[1] < COARSE}
    figure, axes = plt.subplots(1, len(STRESSES), figsize=(10.5, 3.9))
    for ax, mpa in zip(axes, STRESSES):
        x = fine[mpa][3].of("broken").x * 1e3
        middle = np.abs(x[:, 2] - 4.0) < 0.51
        ax.scatter(x[middle, 0], x[middle, 1], s=1, color="#1f4e9c", linewidths=0)
        length = 1e3 * side(mpa, s.fine)
        ax.set(xlim=(0, length), ylim=(0, length), aspect="equal", title=f"{mpa} MPa", xlabel="mm")
    figure.tight_layout()
    s.figure(figure, "cracks", f"Broken joints of the middle millimetre, from above, at the end.")
    name, dt, high, _ = fine[163]
    s.plot_energies(name, dt, "163 MPa")
    cells = {mpa: fine[mpa][2]["pieces_of_the_middle_in_50_x_50_mm"] for mpa in STRESSES}
    values = {f"cells in 50 x 50 mm, {mpa} MPa, within a factor of two": cells[mpa] for mpa in STRESSES}
    values["cells at 163 MPa over those at 102 MPa"] = cells[163] / max(cells[102], 1e-9)
    values["speed of the crack front, 163 MPa"] = high["crack_speed_m_s"]
    values["energy at rest over the exact one of an infinite pane, 163 MPa"] = high["at_rest_per_area_J_m2"] / high["stored_per_area_J_m2"]
    values["largest rise of the total energy"] = 100.0 * max(s.energies(f[0]).rise() for f in found.values())
    return values
