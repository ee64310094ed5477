#!/usr/bin/env python3
"""What examples/laminated_beam/run.sh makes of a run: summary.json, energies.png, crack.png.

analyse.py run FOLDER VARIANT     mesh.data, events.txt, energies.txt, whole.txt, pieces.dump, log.lammps, *.png of one run
analyse.py compare ROOT           force.png and compare.json of the variants in ROOT
"""

import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import laminate
import results

IMPACTOR = 1.0  # kg
PLIES = ("lower", "inter", "upper")
TITLES = {"laminated": "glass / PVB (Prony) / glass", "mooney": "glass / PVB (Mooney-Rivlin) / glass",
          "monolithic": "monolithic glass"}


def first(times):
    return round(min(times), 3) if times else None


def analyse_run(folder, variant):
    log = laminate.read_log(folder / "log.lammps")
    energies = results.read_energies(folder / "energies.txt")
    mesh = laminate.read_mesh(folder / "mesh.data")
    events = laminate.read_events(folder / "events.txt")
    whole = results.read_energies(folder / "whole.txt")

    part_of = lambda row: mesh["parts"][row[3] - 1 if row[2] == "convert" else (row[3] - log["nodes"] - 1) // 8]
    plies = {}
    for ply in PLIES:
        times = {kind: [r[1] for r in events if r[2] == kind and part_of(r) == ply] for kind in ("convert", "cohesive", "broken")}
        if ply == "inter" and variant != "monolithic":
            continue
        severed = whole["time_us"][whole[ply] == 0]  # its ends are in two pieces of it
        plies[ply] = {
            "first_conversion_us": first(times["convert"]),
            "first_damage_us": first(times["cohesive"] + times["broken"]),
            "first_broken_us": first(times["broken"]),
            "cracked_through_us": round(float(severed[0]), 3) if len(severed) else None,
            "elements_converted": len(times["convert"]),
            "joints_broken": len(times["broken"]),
        }
    cracked = {p: s["first_damage_us"] for p, s in plies.items() if s["first_damage_us"] is not None}
    speed = energies["vy"]
    middle, force = laminate.impactor_force(energies, IMPACTOR, "vy")
    s = {
        "variant": variant,
        "cracks_first": min(cracked, key=cracked.get) if cracked else None,
        "first_damage_us": min(cracked.values()) if cracked else None,
        "plies": plies,
        "impactor_force_max_kN": round(float(force.max()), 3),
        "impactor_force_max_us": round(float(middle[force.argmax()]), 2),
        "impactor_leaves_us": round(float(middle[np.flatnonzero(np.abs(force) > 1e-3 * force.max())[-1]]), 1),
        "impactor_energy_initial_J": round(0.5 * IMPACTOR * speed[0]**2, 5),
        "impactor_energy_final_J": round(0.5 * IMPACTOR * speed[-1]**2, 5),
        "impactor_energy_lost_J": round(0.5 * IMPACTOR * (speed[0]**2 - speed[-1]**2), 5),
        "elements_converted": int(log["last"]["converted"]),
        "joints_broken": int(log["last"]["contact"]),
        "held_together": laminate.held_together(folder / "pieces.dump", log, variant != "monolithic"),
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        **results.totals(log, energies),
    }
    results.write_json(folder / "summary.json", s)

    us = lambda t: "-" if t is None else f"{t:.1f}"
    text = [f"Laminated beam, {TITLES[variant]}, after {s['end_us']:.0f} us",
            "  ply      first damage   first broken   cracked through (us)   elements converted   joints broken"]
    for ply in reversed(list(plies)):
        p = plies[ply]
        text.append(f"  {ply:<8} {us(p['first_damage_us']):>12} {us(p['first_broken_us']):>14} {us(p['cracked_through_us']):>22}"
                    f" {p['elements_converted']:>20} {p['joints_broken']:>15}")
    held = s["held_together"]
    text += [
        f"  impactor: force up to {s['impactor_force_max_kN']:.2f} kN, {s['impactor_energy_lost_J']:.4f} of "
        f"{s['impactor_energy_initial_J']:.4f} J lost, leaves at {s['impactor_leaves_us']:.0f} us",
        f"  pieces: {held['pieces_of_more']}, and {held['pieces_of_one_DE']} single DEs; the heaviest has "
        f"{held['heaviest_piece_percent']:.2f} % of the mass",
    ]
    if "glass_on_interlayer_percent" in held:
        text.append(f"  glass that holds on the interlayer: {held['glass_on_interlayer_percent']:.3f} %")
    text.append(f"  total energy: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last, largest rise "
                f"{s['energy_rise_percent']:.4f} % of the initial")
    results.report(folder / "log.lammps", "Laminated beam,", text)

    results.plot_energies(folder / "energies.png", f"laminated_beam, {TITLES[variant]}; dashed: first damage of the plies",
                          energies, [p["first_damage_us"] for p in plies.values()], limit=laminate.ALLOWED_RISE)
    time = lambda p: int(p.name.split(".")[1]) * s["end_us"] / s["steps"]
    shots = sorted(folder.glob("front.*.png"), key=time)
    last = sorted(folder.glob("oblique.*.png"), key=time)[-1:]
    cells = [(p, f"{time(p):.0f} us") for p in shots] + [(p, f"{time(p):.0f} us, all of the beam") for p in last]
    if shots:
        laminate.sheet(folder / "crack.png", TITLES[variant], cells, 2)
    if s["energy_rise_percent"] > laminate.ALLOWED_RISE:
        sys.exit(f"laminated_beam: the total energy rises by {s['energy_rise_percent']} % of its initial value")


def compare(root):
    summaries, curves = {}, {}
    for variant in ("laminated", "mooney", "monolithic"):
        if (root / variant / "summary.json").exists():
            summaries[variant] = json.loads((root / variant / "summary.json").read_text())
            curves[variant] = results.read_energies(root / variant / "energies.txt")
    results.write_json(root / "compare.json", summaries)
    plt = results.plotting()
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(9, 7), sharex=True, constrained_layout=True)
    for (variant, e), colour in zip(curves.items(), ("#1f77b4", "#e08a1e", "#444444")):
        t, force = laminate.impactor_force(e, IMPACTOR, "vy")
        top.plot(t, force, color=colour, lw=1.3, label=TITLES[variant])
        bottom.plot(e["time_us"], 0.5 * IMPACTOR * (e["vy"][0]**2 - e["vy"]**2), color=colour, lw=1.3, label=TITLES[variant])
        for ply, style in (("lower", (0, (4, 3))), ("upper", (0, (1, 2)))):
            at = summaries[variant]["plies"][ply]["first_damage_us"]
            if at is not None:
                top.axvline(at, color=colour, lw=0.9, ls=style, zorder=0)
    top.set(ylabel="kN", title="force on the impactor; dashed: first damage of the lower ply, dotted: of the upper")
    bottom.set(ylabel="J", xlabel="us", title="energy that the impactor has lost", xlim=(0, t[-1]))
    top.legend()
    figure.savefig(root / "force.png", dpi=100)
    print(f"compare.json and force.png of {', '.join(summaries)} in {root}")


def main(argv):
    match argv:
        case ["run", folder, variant]:
            analyse_run(Path(folder), variant)
        case ["compare", root]:
            compare(Path(root))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
