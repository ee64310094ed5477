#!/usr/bin/env python3
"""What examples/laminated_beam/run.sh makes of a run: summary.json, energies.png, timeline.png, crack.png.

analyse.py run FOLDER VARIANT     mesh.data, events.txt, energies.txt, whole.txt, pieces.dump, log.lammps, *.png of one run
analyse.py compare ROOT           force.png and compare.json of the variants in ROOT
"""

import os
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[2] / "python")]
import defe
import laminate
from defe import plots, summary

IMPACTOR = 1.0  # kg
PLIES = ("lower", "inter", "upper")
TITLES = {"laminated": "glass / PVB (Prony) / glass", "mooney": "glass / PVB (Mooney-Rivlin) / glass",
          "monolithic": "monolithic glass"}


def measure(folder, variant):
    """summary.json of a run, and its energies and events."""
    log = defe.read_log(folder / "log.lammps")
    energies = defe.read_table(folder / "energies.txt")
    mesh = defe.read_mesh(folder / "mesh.data")
    events = defe.read_events(folder / "events.txt")
    whole = defe.read_table(folder / "whole.txt")
    nodes, film = laminate.numbers(log)

    part = mesh.parts[events.elements_of(nodes)]
    plies = {}
    for ply in PLIES:
        if ply == "inter" and variant != "monolithic":
            continue
        severed = whole["time_us"][whole[ply] == 0]  # its ends are in two pieces of it
        plies[ply] = {
            **laminate.damage_of(events.where(part == ply)),
            "cracked_through_us": round(float(severed[0]), 3) if len(severed) else None,
        }
    speed = energies["vy"]
    middle, force = defe.force_from_velocity(energies.seconds(), speed, IMPACTOR)
    last = log.thermo.last()
    return {
        "variant": variant,
        **laminate.cracks_first(plies),
        "plies": plies,
        "impactor_force_max_kN": round(1e-3 * float(force.max()), 3),
        "impactor_force_max_us": round(1e6 * float(middle[force.argmax()]), 2),
        "impactor_leaves_us": round(1e6 * float(middle[np.flatnonzero(np.abs(force) > 1e-3 * force.max())[-1]]), 1),
        "impactor_energy_initial_J": round(0.5 * IMPACTOR * speed[0]**2, 5),
        "impactor_energy_final_J": round(0.5 * IMPACTOR * speed[-1]**2, 5),
        "impactor_energy_lost_J": round(0.5 * IMPACTOR * (speed[0]**2 - speed[-1]**2), 5),
        "elements_converted": int(last["converted"]),
        "joints_broken": int(last["broken"]),
        "held_together": laminate.held_together(folder / "pieces.dump", None if variant == "monolithic" else film),
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        **summary.totals(log, energies),
    }, energies, events


def table(s, variant):
    plies, us = s["plies"], laminate.shown
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
    return text


def analyse_run(folder, variant):
    s, energies, events = measure(folder, variant)
    summary.write_json(folder / "summary.json", s)
    summary.report(folder / "log.lammps", "Laminated beam,", table(s, variant))
    plots.energies(folder / "energies.png", f"laminated_beam, {TITLES[variant]}; dashed: first damage of the plies",
                   energies, [p["first_damage_us"] for p in s["plies"].values()], limit=laminate.ALLOWED_RISE)
    plots.timeline(folder / "timeline.png", f"laminated_beam, {TITLES[variant]}", events, s["end_us"])
    dt = 1e-6 * s["end_us"] / s["steps"]
    shots = [(path, f"{time:.0f} us") for time, path in plots.pictures(folder, "front.*.png", dt)]
    if shots:
        last = [(path, f"{time:.0f} us, all of the beam") for time, path in plots.pictures(folder, "oblique.*.png", dt)[-1:]]
        plots.sheet(folder / "crack.png", TITLES[variant], shots + last, 2)
    summary.closing_line(folder, s)
    if s["energy_rise_percent"] > laminate.ALLOWED_RISE:
        sys.exit(f"laminated_beam: the total energy rises by {s['energy_rise_percent']} % of its initial value")


def compare(root):
    summaries, curves = {}, {}
    for variant in ("laminated", "mooney", "monolithic"):
        if (root / variant / "summary.json").exists():
            summaries[variant] = defe.read_summary(root / variant / "summary.json")
            curves[variant] = defe.read_table(root / variant / "energies.txt")
    summary.write_json(root / "compare.json", summaries)
    plt = plots.plotting()
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(9, 7), sharex=True, constrained_layout=True)
    for (variant, e), colour in zip(curves.items(), ("#1f77b4", "#e08a1e", "#444444")):
        t, force = defe.force_from_velocity(e.seconds(), e["vy"], IMPACTOR)
        top.plot(1e6 * t, 1e-3 * force, color=colour, lw=1.3, label=TITLES[variant])
        bottom.plot(e["time_us"], 0.5 * IMPACTOR * (e["vy"][0]**2 - e["vy"]**2), color=colour, lw=1.3, label=TITLES[variant])
        for ply, style in (("lower", (0, (4, 3))), ("upper", (0, (1, 2)))):
            at = summaries[variant]["plies"][ply]["first_damage_us"]
            if at is not None:
                top.axvline(at, color=colour, lw=0.9, ls=style, zorder=0)
    top.set(ylabel="kN", title="force on the impactor; dashed: first damage of the lower ply, dotted: of the upper")
    bottom.set(ylabel="J", xlabel="us", title="energy that the impactor has lost", xlim=(0, 1e6 * t[-1]))
    top.legend()
    figure.savefig(root / "force.png", dpi=100)
    print(f"compare.json and force.png of {', '.join(summaries)} in {os.path.relpath(root)}")


def main(argv):
    match argv:
        case ["run", folder, variant]:
            analyse_run(Path(folder), variant)
        case ["compare", root]:
            compare(Path(root))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    summary.main(main, sys.argv[1:])
