"""See README.md."""

import argparse
import importlib.util
import sys

import numpy as np
from manual import HERE, Accept, plt

TITLE = "Strength, fracture energy and path over the direction of the lattice"
EXACT = "isotropy: the strength given, the line of the notch, G_f"
PERIDYNAMICS = "peridynamics in print, 1 to 3 degrees"

ACCEPTANCE = [
    Accept("strength over the given one, farthest from 1", EXACT, target=0.0, tolerance=0.01, digits=2),
    Accept("direction of the crack, all DEs, largest error", PERIDYNAMICS, high=3.0, unit="degrees", certain=False, digits=2),
    Accept("direction of the crack, adaptive, largest error", PERIDYNAMICS, high=3.0, unit="degrees", certain=False, digits=2),
    Accept("fracture energy over G_f, G_f resolved, farthest from 1", EXACT, target=0.0, tolerance=0.12, digits=2),
    Accept("fracture energy over G_f, G_f not resolved, farthest from 1", EXACT, target=0.0, tolerance=0.2, digits=2),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%", digits=2),
]


def load_cracks(s):
    """tests/verification/cracks/run.py, told where this case keeps its results."""
    folder = HERE.parent / "cracks"
    sys.path.insert(0, str(folder))
    spec = importlib.util.spec_from_file_location("cracks_run", folder / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.options = argparse.Namespace(lmp=s.options.lmp, plugin=str(s.options.plugin), out=str(s.out), page=False, jobs=s.options.jobs)
    return module


def run(s):
    cracks = load_cracks(s)
    degrees = np.arange(0.0, 91.0, 7.5) if s.fine else np.array([0.0, 22.5, 45.0, 54.7356, 90.0])

    def direction(a):
        """In the plane (110), which has all the axes of symmetry of a cube: [001], [111], [110]."""
        return [np.sin(a) / np.sqrt(2), np.sin(a) / np.sqrt(2), np.cos(a)]

    strength = np.array([cracks.strength(direction(a), "fronts") for a in np.radians(degrees)])
    s.table("Stress at the first damage over the strength, tension in the plane (110) of the lattice:",
            [["degrees from [001]"] + [f"{a:g}" for a in degrees], ["stress"] + [f"{v:.4f}" for v in strength]])

    names = None if s.fine else ("0", "22.5", "45", "0, 45")
    cases = [(gf, *o, label, law, start) for gf in (50.0, 10.0) for o in cracks.ORIENTATIONS if names is None or o[0] in names
             for label, law, start in cracks.CASES if law == "fronts"]

    def one(k):
        gf, name, turn, thickness, label, law, start = cases[k]
        strip = cracks.Strip(turn, thickness).run(f"strip{k}", law, start, gf)
        return strip, strip.measure()

    found = {(gf, name, label): f for (gf, name, _, _, label, _, _), f in zip(cases, s.all(one, range(len(cases))))}
    rows = [["G_f (J/m2)", "lattice turned by", "", "tilt along", "across", "scatter (d)", "energy / G_f", "beside it", "energy rises (%)"]]
    for (gf, name, label), (_, r) in found.items():
        how = "adaptive" if "adaptive" in label else "DEs"
        rows.append([f"{gf:g}", name, how] + (["does not run"] + ["-"] * 5 if r is None else
                    [f"{r['tilt']:.1f}", f"{r['across']:.1f}", f"{r['scatter']:.2f}", f"{r['energy']:.2f}", r["stray"], f"{100 * r['rise']:.3f}"]))
    s.table("Cracks in notched strips, in degrees and spacings d of DEs:", rows)

    flat = ["0", "22.5", "45"] if names else ["0", "11.25", "22.5", "33.75", "45"]
    figure, axes = plt.subplots(2, len(flat), figsize=(2.4 * len(flat), 5.0), sharex=True, sharey=True, squeeze=False)
    for row, label in enumerate(("fronts", "fronts, adaptive")):
        for ax, name in zip(axes[row], flat):
            x = found[(10.0, name, label)][0].broken
            x = x.where(x.step > cracks.CUTTING).x * 1e3
            for sign in (-1, 1):
                a = np.radians(float(name) if sign > 0 else float(name) - 90.0)
                ax.plot([0, 30 * np.cos(a)], [0, 30 * np.sin(a)], color="0.85", lw=0.8, zorder=0)
            ax.plot([-5, 0], [0, 0], color="k", lw=2)
            ax.scatter(x[:, 0], x[:, 1], s=3, color="#1f4e9c")
            ax.set(xlim=(-5, 20), ylim=(-10, 10), aspect="equal")
            ax.set_title(f"{name} degrees, {'adaptive' if row else 'DEs'}", fontsize=8)
    figure.tight_layout()
    s.figure(figure, "paths", "Cracks from above, G_f = 10 J/m2, in mm; grey: rows of the lattice.")

    figure, ax = plt.subplots(figsize=(6, 3.6))
    for (label, colour) in (("fronts", "#c0392b"), ("fronts, adaptive", "#1f4e9c")):
        key = (10.0, "22.5", label)
        t = found[key][0].thermo
        ax.plot(1e6 * t["Time"], 1e3 * (t["e_kinetic"] + t["PotEng"]), color=colour, lw=0.9, label=f"{'adaptive' if 'ad' in label else 'DEs'}: kinetic and stored")
        ax.plot(1e6 * t["Time"], 1e3 * (t["e_kinetic"] + t["PotEng"] - t["external"]), color=colour, ls=":", label="less the work of the grips")
    ax.set(xlabel="time (us)", ylabel="energy (mJ)", title="lattice turned by 22.5 degrees, G_f = 10 J/m2")
    ax.legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "energies", "Energies of a strip: what falls is what the crack takes.")

    whole = {k: r for k, (_, r) in found.items() if r is not None}

    def worst(key, *, label=None, gf=None):
        return max(abs(r[key] - (1.0 if key == "energy" else 0.0)) for (g, _, lab), r in whole.items()
                   if (label is None or lab == label) and (gf is None or g == gf))

    missing = len(whole) < len(found)
    return {
        "strength over the given one, farthest from 1": float(np.abs(strength - 1.0).max()),
        "direction of the crack, all DEs, largest error": np.nan if missing else worst("tilt", label="fronts"),
        "direction of the crack, adaptive, largest error": np.nan if missing else worst("tilt", label="fronts, adaptive"),
        "fracture energy over G_f, G_f resolved, farthest from 1": worst("energy", gf=50.0),
        "fracture energy over G_f, G_f not resolved, farthest from 1": worst("energy", gf=10.0),
        "largest rise of the total energy": 100.0 * max(r["rise"] for r in whole.values()),
    }
