#!/usr/bin/env python3
"""What examples/glass_beam/run.sh makes of a run: crack timeline, summary.json, energies.png, timeline.png, crack.png.

analyse.py run FOLDER VARIANT     events.txt, energies.txt, log.lammps, *.png of one run
analyse.py bpm FOLDER             log.lammps of in.bpm
analyse.py compare ROOT           summaries and pictures of ROOT/adaptive, ROOT/dem and ROOT/bpm
"""

import itertools
import os
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
import defe
from defe import plots, summary

LAYERS = 20  # of DEs over the depth, 1 mm each
PER_LAYER = 10  # joints across the crack plane x = 0 in a layer
PAPER = {  # us; from its text and Table 1
    "first_damage_us": {"dem": 25, "adaptive": 26},
    "crack_upper_us": {"dem": 45, "adaptive": 44},
    "crack_through_us": {"dem": 70, "adaptive": 70},
}
PAPER_SECONDS = {"dem": 660, "adaptive": 67}


def timeline(events):
    """Per layer of DEs, from below: times (us) when its element converted, and of its joints across x = 0."""
    rows = [{"y": k, "convert": [], "cohesive": [], "broken": []} for k in range(LAYERS)]
    across = events.where((np.abs(events.x[:, 0]) < 1e-4) & ((events.kind == "convert") | (np.abs(events.n[:, 0]) > 0.9)))
    for kind, time, y in zip(across.kind, 1e6 * across.time, 1e3 * across.x[:, 1]):
        for k in (round(y) - 1, round(y)) if kind == "convert" else (int(y),):
            rows[k][kind].append(float(time))
    return rows


def first(times):
    return min(times) if times else None


def summarise(variant, log, energies, events, rows):
    damage = events.first("cohesive", "broken")
    broken = [first(r["broken"]) for r in rows]
    through = None if None in broken else max(broken)
    last = log.thermo.last()
    initial = energies["total"][0]
    before = energies.seconds() < (np.inf if damage is None else damage)

    def us(t, factor=1.0):
        return None if t is None else round(factor * t, 4)

    return {
        "variant": variant,
        "first_conversion_us": us(events.first("convert"), 1e6),
        "first_damage_us": us(damage, 1e6),
        "crack_upper_us": us(broken[15]),
        "crack_through_us": us(through),
        "elements_converted": int(last["converted"]),
        "elements_converted_centre_column": int((np.abs(events.of("convert").x[:, 0]) < 1e-4).sum()),
        "discrete_elements": int(last["des"]),
        "joints_connective": int(last["connective"]),
        "joints_cohesive": int(last["cohesive"]),
        "joints_contact": int(last["broken"]),
        **summary.totals(log, energies),
        "energy_max_J": float(max(energies["total"].max(), log.thermo["total"].max())),
        "energy_final_J": last["total"],
        "energy_drift_before_damage_percent": 100 * float(np.ptp(energies["total"][before])) / initial,
        "end_us": last["time_us"],
    }


def show(value, unit=" us"):
    return "-" if value is None else f"{value:.2f}{unit}" if isinstance(value, float) else f"{value}{unit}"


def timeline_text(s, rows):
    text = [
        f"Crack timeline of the glass beam, {s['variant']} (times in us)",
        f"  first conversion                {show(s['first_conversion_us'])}",
        f"  first damage                    {show(s['first_damage_us'])}",
        f"  crack at y = 16 mm              {show(s['crack_upper_us'])}",
        f"  crack through                   {show(s['crack_through_us'])}",
        f"  converted at {s['end_us']:5.1f} us           {s['elements_converted']} elements, "
        f"{s['elements_converted_centre_column']} of them in the centre column",
        f"  joints at {s['end_us']:5.1f} us              {s['joints_connective']} connective, "
        f"{s['joints_cohesive']} cohesive, {s['joints_contact']} contact",
        f"  total energy                    {s['energy_initial_J']:.6f} J at first, "
        f"{s['energy_final_J']:.6f} J at last, highest {s['energy_max_J']:.6f} J",
        "",
        "  layer of DEs    element      joints across the crack plane x = 0",
        "  y (mm)          converted    first cohesive  first broken   last broken",
    ]
    cell = lambda t: f"{t:10.2f}" if t is not None else f"{'-':>10}"
    for r in reversed(rows):
        full = max(r["broken"]) if len(r["broken"]) == PER_LAYER else None
        text.append(
            f"  {r['y']:2d} to {r['y'] + 1:2d}    {cell(first(r['convert']))}      {cell(first(r['cohesive']))}"
            f"    {cell(first(r['broken']))}    {cell(full)}"
        )
    return text


# ---- pictures -----------------------------------------------------------------------------------


def choose(folder, s):
    """[(file, caption)], as in the paper's figures: three of the front, the last from the oblique view."""
    dt = 1e-6 * s["end_us"] / s["steps"]
    shots = [(path, f"{time:.0f} us") for time, path in plots.pictures(folder, "front.*.png", dt)[:3]]
    shots += [(path, f"{time:.0f} us, oblique view") for time, path in plots.pictures(folder, "oblique.*.png", dt)[-1:]]
    return list(zip((path for path, _ in shots), plots.letters(caption for _, caption in shots)))


# ---- commands -----------------------------------------------------------------------------------


def analyse_run(folder, variant):
    log = defe.read_log(folder / "log.lammps")
    energies = defe.read_table(folder / "energies.txt")
    events = defe.read_events(folder / "events.txt")
    rows = timeline(events)
    s = summarise(variant, log, energies, events, rows)
    summary.write_json(folder / "summary.json", s)
    summary.report(folder / "log.lammps", "Crack timeline", timeline_text(s, rows))
    plots.energies(folder / "energies.png",
                   f"glass beam, {variant}; dashed: first damage, crack at y = 16 mm, crack through", energies,
                   [s[key] for key in ("first_damage_us", "crack_upper_us", "crack_through_us")],
                   large_elements=variant != "dem")
    plots.timeline(folder / "timeline.png", f"glass beam, {variant}", events, s["end_us"])
    shots = choose(folder, s)
    if shots:
        plots.sheet(folder / "crack.png", f"glass beam, {variant}", shots, 2)
    summary.closing_line(folder, s)


def analyse_bpm(folder):
    log = defe.read_log(folder / "log.lammps")
    kinetic = log.thermo["KinEng"]
    s = {
        "variant": "bpm",
        "discrete_elements": 40000,
        "kinetic_energy_initial_J": kinetic[0],
        "kinetic_energy_max_J": float(kinetic.max()),
        "kinetic_energy_final_J": kinetic[-1],
        "bonds_broken": int(log.thermo["broken"][-1]),
        "end_us": log.thermo["time_us"][-1],
        "loop_seconds": round(log.seconds, 4),
        "ranks": log.ranks,
        "steps": log.steps,
    }
    summary.write_json(folder / "summary.json", s)
    print(f"\nbpm/rotational: kinetic energy {kinetic[0]:.4f} J at first, {kinetic[-1]:.4f} J at last; "
          f"{s['bonds_broken']} bonds broken")
    summary.closing_line(folder, s)


def compare(root):
    s = {v: defe.read_summary(root / v / "summary.json") for v in ("adaptive", "dem", "bpm")}
    loop = {v: s[v]["loop_seconds"] for v in s}
    result = dict(s)
    result["paper"] = {**PAPER, "seconds": PAPER_SECONDS}
    result["speed"] = {
        "dem_over_adaptive": round(loop["dem"] / loop["adaptive"], 3),
        "bpm_over_dem": round(loop["bpm"] / loop["dem"], 3),
        "paper_dem_over_adaptive": round(PAPER_SECONDS["dem"] / PAPER_SECONDS["adaptive"], 3),
    }
    summary.write_json(root / "compare.json", result)

    names = {
        "first_damage_us": "first damage",
        "crack_upper_us": "crack at y = 16 mm",
        "crack_through_us": "crack through",
    }
    line = lambda *cells: print(f"  {cells[0]:<28}" + "".join(f"{c:>15}" for c in cells[1:]))
    print()
    line("", "paper", "", "here", "")
    line("", "DE", "adaptive", "dem", "adaptive")
    for key, name in names.items():
        line(name, f"{PAPER[key]['dem']} us", f"{PAPER[key]['adaptive']} us", show(s["dem"][key]), show(s["adaptive"][key]))
    line("converted", "-", "-", s["dem"]["elements_converted"], s["adaptive"]["elements_converted"])
    line("  in the centre column", "-", "-", s["dem"]["elements_converted_centre_column"],
         s["adaptive"]["elements_converted_centre_column"])
    line("discrete elements", "40000", "-", s["dem"]["discrete_elements"], s["adaptive"]["discrete_elements"])
    line("joints broken", "-", "-", s["dem"]["joints_contact"], s["adaptive"]["joints_contact"])
    line("total energy, end/start", "-", "-",
         *(f"{s[v]['energy_final_J'] / s[v]['energy_initial_J']:.5f}" for v in ("dem", "adaptive")))
    line("run time", *(f"{PAPER_SECONDS[v]} s" for v in ("dem", "adaptive")),
         *(f"{loop[v]:.2f} s" for v in ("dem", "adaptive")))
    print(
        f"\n  adaptive is {loop['dem'] / loop['adaptive']:.1f} times as fast as dem (in the paper "
        f"{PAPER_SECONDS['dem'] / PAPER_SECONDS['adaptive']:.1f} times)"
        f"\n  bpm/rotational, 40 000 spheres: {loop['bpm']:.2f} s, {loop['bpm'] / loop['dem']:.2f} times as long as dem"
    )
    shots = [choose(root / v, s[v]) for v in ("dem", "adaptive")]
    made = "compare.json"
    if all(shots):
        plots.sheet(root / "compare.png", ("DE model", "adaptive"), [cell for row in itertools.zip_longest(*shots) for cell in row], 2)
        made += ", compare.png"
    print(f"\n{made} in {os.path.relpath(root)}")


def main(argv):
    match argv:
        case ["run", folder, variant]:
            analyse_run(Path(folder), variant)
        case ["bpm", folder]:
            analyse_bpm(Path(folder))
        case ["compare", root]:
            compare(Path(root))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    summary.main(main, sys.argv[1:])
