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
PUBLISHED = {102: 79, 112: 100, 136: 193, 154: 207, 163: 215}    # MPa at the faces: fragments in 50 x 50 mm

ACCEPTANCE = [Accept(f"squares in 50 x 50 mm, {mpa} MPa", COUNTS, target=PUBLISHED[mpa], tolerance=0.2 * PUBLISHED[mpa], known=mpa == 102)
              for mpa in (102, 163)]
ACCEPTANCE += [
    Accept("squares at 163 MPa over those at 102 MPa", COUNTS, target=2.7, tolerance=0.8, digits=2, known=True),
    Accept("speed of the crack front, 163 MPa", "measured", target=1460.0, tolerance=150.0, unit="m/s", digits=4, known=True),
    Accept("energy at rest over the exact one of an infinite pane, 163 MPa", "(1 - nu) sigma^2 h/(5 E)", low=0.6, high=1.0),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%", digits=2),
]


def run(s):
    spec = importlib.util.spec_from_file_location("tempered_pane_analyse", EXAMPLE / "analyse.py")
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    fine = {"edge": 1e-3, "dt": 2.5e-8, "strength": 85e6, "end": 2.4e-5}
    coarse = {"edge": 2e-3, "dt": 5e-8, "strength": 45e6, "blow": 30.0, "end": 2.4e-5}
    jobs = [(163, "1 mm", fine), (102, "1 mm", fine), (163, "2 mm", coarse)]
    if s.fine:
        jobs += [(mpa, "1 mm", fine) for mpa in PUBLISHED if mpa not in (102, 163)]

    def one(job):
        mpa, mesh, options = job
        name = f"{mpa}_{mesh.replace(' ', '')}"
        s.lammps(EXAMPLE / "in.tempered_pane", name, surface=1e6 * mpa, pictures="no", **options)
        shutil.copy(s.path(name + ".log"), s.path(name) / "log.lammps")    # where the example's analysis looks for it
        with contextlib.redirect_stdout(io.StringIO()):
            example.main(s.path(name))
        return name, options["dt"], defe.read_summary(s.path(name) / "summary.json"), defe.read_events(s.path(name) / "events.txt")

    def speed(r):
        """Of the front; faster than waves: it breaks everywhere at once."""
        v = r["crack_speed_m_s"]
        return "-" if v is None else f"{v:.0f}" if v < WAVE else "at once"

    found = dict(zip([(mpa, mesh) for mpa, mesh, _ in jobs], s.all(one, jobs)))
    rows = [["MPa at the faces", "elements", "taken by cracks (J/m2)", "crack area by pane area", "squares in 50 x 50 mm", "published",
             "speed (m/s)", "converted", "processor time (s)", "energy rises (%)"]]
    for (mpa, mesh), (name, _, r, _) in found.items():
        rows.append([mpa, mesh, f"{r['fracture_J_m2']:.0f}", f"{r['crack_area_by_pane_area']:.2f}", f"{r['squares_in_50_x_50_mm']:.0f}", PUBLISHED[mpa],
                     speed(r), r["elements_converted"],
                     f"{s.loops[name]:.0f}", f"{100 * s.energies(name).rise():.3f}"])
    s.table("All runs:", rows)

    shown = [(163, "1 mm"), (102, "1 mm"), (163, "2 mm")]
    figure, axes = plt.subplots(1, len(shown), figsize=(10.5, 3.9), sharey=True)
    for ax, key in zip(axes, shown):
        x = found[key][3].of("broken").x * 1e3
        middle = np.abs(x[:, 2] - 4.0) < 1.01    # what cuts the layers under tension
        ax.scatter(x[middle, 0], x[middle, 1], s=1, color="#1f4e9c", linewidths=0)
        ax.set(xlim=(0, 40), ylim=(0, 40), aspect="equal", title=f"{key[0]} MPa, {key[1]}", xlabel="mm")
    figure.tight_layout()
    s.figure(figure, "cracks", "Broken joints of the middle 2 mm, from above, at the end.")
    name, dt, _, _ = found[(163, "1 mm")]
    s.plot_energies(name, dt, "163 MPa, 1 mm")
    high, low = found[(163, "1 mm")][2], found[(102, "1 mm")][2]
    values = {f"squares in 50 x 50 mm, {mpa} MPa": found[(mpa, "1 mm")][2]["squares_in_50_x_50_mm"] for mpa in (102, 163)}
    values["squares at 163 MPa over those at 102 MPa"] = high["squares_in_50_x_50_mm"] / max(low["squares_in_50_x_50_mm"], 1e-9)
    values["speed of the crack front, 163 MPa"] = high["crack_speed_m_s"]
    values["energy at rest over the exact one of an infinite pane, 163 MPa"] = high["at_rest_J"] / (high["stored_per_area_J_m2"] * 1e-6 * high["area_mm2"])
    values["largest rise of the total energy"] = 100.0 * max(s.energies(f[0]).rise() for f in found.values())
    return values
