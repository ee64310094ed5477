"""See README.md."""

import importlib.util

import defe
import numpy as np
from manual import ROOT, Accept, plt

TITLE = "The glass beam of Zang, Lei and Wang, adaptive and all DEs"
PAPER = "Zang, Lei and Wang (adaptive DE/FE method for glass), text and Table 1"
EXAMPLE = ROOT / "examples" / "glass_beam"
TIMES = {"first damage": "first_damage_us", "crack at y = 16 mm": "crack_upper_us", "crack through": "crack_through_us"}
PUBLISHED = {"first damage": (26.0, 25.0), "crack at y = 16 mm": (44.0, 45.0), "crack through": (70.0, 70.0)}    # adaptive, DEs

ACCEPTANCE = [Accept(f"{what}, {how}", PAPER, target=PUBLISHED[what][k], tolerance=tolerance, unit="us", known=what == "crack at y = 16 mm")
              for what, tolerance in (("first damage", 2.0), ("crack at y = 16 mm", 3.0), ("crack through", 3.0))
              for k, how in enumerate(("adaptive", "DEs"))]
ACCEPTANCE += [
    Accept("crack through, DEs less adaptive", PAPER, target=0.0, tolerance=2.0, unit="us"),
    Accept("processor time of DEs over that of adaptive", PAPER + ": 660 s and 67 s", low=5.0),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%"),
]
RUNS = {"adaptive": {"variant": "adaptive"}, "DEs": {"variant": "dem"}, "adaptive, half the time step": {"variant": "adaptive", "dt": 3e-8},
        "adaptive, law lattice": {"variant": "adaptive", "law": "lattice"}}


def run(s):
    spec = importlib.util.spec_from_file_location("glass_beam_analyse", EXAMPLE / "analyse.py")
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)

    def one(how):
        name = how.replace(", ", "_").replace(" ", "_")
        s.lammps(EXAMPLE / "in.glass_beam", name, pictures="no", **RUNS[how])
        events = defe.read_events(s.path(name) / "events.txt")
        rows = example.timeline(events)
        summary = example.summarise(RUNS[how]["variant"], defe.read_log(s.path(name + ".log")), s.energies(name), events, rows)
        return name, events, rows, summary

    found = dict(zip(RUNS, s.all(one, RUNS)))
    rows = [["", *(f"{what} (us)" for what in TIMES), "elements converted", "joints broken", "processor time (s)", "energy rises (%)"]]
    for k, how in enumerate(("adaptive", "DEs")):
        rows.append([f"published, {how}", *(f"{PUBLISHED[what][k]:g}" for what in TIMES), "-", "-", str((67, 660)[k]), "-"])
    for how, (name, _, _, summary) in found.items():
        rows.append([how, *(f"{summary[key]:.1f}" for key in TIMES.values()), summary["elements_converted"], summary["joints_contact"],
                     f"{s.loops[name]:.2f}", f"{100 * s.energies(name).rise():.4f}"])
    s.table("All runs; the times of the published ones are of its computer:", rows)

    figure, ax = plt.subplots(figsize=(6, 3.8))
    for how in ("adaptive", "DEs"):
        layers = found[how][2]
        first = np.array([example.first(r["broken"]) or np.nan for r in layers], float)
        ax.plot(first, [r["y"] + 0.5 for r in layers], "o-", ms=3, lw=0.8, label=how)
    ax.plot([44, 70], [15.5, 19.5], "kx", label="published, adaptive")
    ax.set(xlabel="first broken joint across the middle (us)", ylabel="height of the layer (mm)", xlim=(20, 80), ylim=(0, 20))
    ax.legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "timeline", "How the crack climbs: first broken joint of each layer of DEs.")
    s.plot_energies("adaptive", 6e-8, "adaptive")
    values = {f"{what}, {how}": found[how][3][key] for what, key in TIMES.items() for how in ("adaptive", "DEs")}
    values["crack through, DEs less adaptive"] = values["crack through, DEs"] - values["crack through, adaptive"]
    values["processor time of DEs over that of adaptive"] = s.loops[found["DEs"][0]] / s.loops[found["adaptive"][0]]
    values["largest rise of the total energy"] = 100 * max(s.energies(f[0]).rise() for f in found.values())
    return values
