#!/usr/bin/env python3
"""What examples/glass_beam/run.sh makes of a run: crack timeline, summary.json, energies.png, crack.png.

analyse.py run FOLDER VARIANT     events.txt, energies.txt, log.lammps, *.png of one run
analyse.py bpm FOLDER             log.lammps of in.bpm
analyse.py compare ROOT           summaries and pictures of ROOT/adaptive, ROOT/dem and ROOT/bpm
"""

import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import results
from results import read_energies, read_log, write_json

LAYERS = 20  # of DEs over the depth, 1 mm each
PER_LAYER = 10  # joints across the crack plane x = 0 in a layer
PAPER = {  # us; from its text and Table 1
    "first_damage_us": {"dem": 25, "adaptive": 26},
    "crack_upper_us": {"dem": 45, "adaptive": 44},
    "crack_through_us": {"dem": 70, "adaptive": 70},
}
PAPER_SECONDS = {"dem": 660, "adaptive": 67}


def read_events(path):
    """Lists of (time in us, reference position in mm, direction) of every kind of event."""
    events = {"convert": [], "cohesive": [], "broken": []}
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            continue
        w = line.split()
        events[w[2]].append((float(w[1]) * 1e6, np.array(w[5:8], float) * 1e3, np.array(w[8:11], float)))
    return events


def timeline(events):
    """Per layer of DEs, from below: when its element converted, and its joints across x = 0."""
    rows = [{"y": k, "convert": [], "cohesive": [], "broken": []} for k in range(LAYERS)]
    for time, x, _ in events["convert"]:
        if abs(x[0]) < 0.1:
            for k in (round(x[1]) - 1, round(x[1])):
                rows[k]["convert"].append(time)
    for kind in ("cohesive", "broken"):
        for time, x, n in events[kind]:
            if abs(x[0]) < 0.1 and abs(n[0]) > 0.9:
                rows[int(x[1])][kind].append(time)
    return rows


def first(times):
    return min(times) if times else None


def summarise(variant, log, energies, events, rows):
    converted = [e[0] for e in events["convert"]]
    damage = first([e[0] for e in events["cohesive"] + events["broken"]])
    broken = [first(r["broken"]) for r in rows]
    through = None if None in broken else max(broken)
    last = {name: column[-1] for name, column in log["thermo"].items()}
    total = np.concatenate([energies["total"], log["thermo"]["total"]])
    initial = energies["total"][0]
    before = energies["time_us"] < (damage or 1e9)
    us = lambda t: None if t is None else round(t, 4)
    return {
        "variant": variant,
        "first_conversion_us": us(first(converted)),
        "first_damage_us": us(damage),
        "crack_upper_us": us(broken[15]),
        "crack_through_us": us(through),
        "elements_converted": int(last["converted"]),
        "elements_converted_centre_column": sum(abs(e[1][0]) < 0.1 for e in events["convert"]),
        "discrete_elements": int(last["des"]),
        "joints_connective": int(last["connective"]),
        "joints_cohesive": int(last["cohesive"]),
        "joints_contact": int(last["contact"]),
        "energy_initial_J": initial,
        "energy_max_J": float(total.max()),
        "energy_final_J": last["total"],
        "energy_rise_percent": results.energy_rise(energies),
        "energy_drift_before_damage_percent": 100 * float(np.ptp(energies["total"][before])) / initial,
        "end_us": last["time_us"],
        "loop_seconds": log["loop_seconds"],
        "ranks": log["ranks"],
        "steps": log["steps"],
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


def pictures(folder, dt):
    """(view, time in us, file) of a run, in order of time."""
    found = [(p.name.split(".")[0], int(p.name.split(".")[1]) * dt * 1e6, p) for p in folder.glob("*.*.png")]
    return sorted(found, key=lambda p: p[1])


def choose(shots):
    """As in the paper's figures: three of the front, the last from the oblique view."""
    front = [p for p in shots if p[0] == "front"][:3]
    return front + [p for p in shots if p[0] == "oblique"][-1:]


def font(size):
    import matplotlib.font_manager as fonts
    from PIL import ImageFont

    return ImageFont.truetype(fonts.findfont("DejaVu Sans"), size)


def sheet(path, runs, titles):
    """The pictures of a run under each other, a column per run; one run alone fills two columns."""
    from PIL import Image, ImageDraw

    width, head, bar, gap = 720, 44, 34, 8

    def cells(shots):
        for letter, (view, time, file) in zip("abcd", shots):
            im = Image.open(file).convert("RGB")
            im = im.resize((width, round(im.height * width / im.width)), Image.LANCZOS)
            yield im, f"({letter})  {time:.0f} us" + ("" if view == "front" else ", oblique view")

    runs = [list(cells(shots)) for shots in runs]
    columns = [runs[0][0::2], runs[0][1::2]] if len(runs) == 1 else runs
    heights = [max(c[r][0].height for c in columns if r < len(c)) + bar for r in range(max(map(len, columns)))]
    size = (len(columns) * (width + gap) + gap, head + sum(heights) + len(heights) * gap)
    out = Image.new("RGB", size, "#d8d8d8")
    draw = ImageDraw.Draw(out)
    for i, column in enumerate(columns):
        left, top = gap + i * (width + gap), head
        if i < len(titles):
            draw.text((left + 4, 8), titles[i], fill="black", font=font(24))
        for (im, text), height in zip(column, heights):
            draw.rectangle((left, top, left + width - 1, top + height - 1), fill="white")
            out.paste(im, (left, top + (height - bar - im.height) // 2))
            draw.text((left + 12, top + height - bar + 4), text, fill="black", font=font(20))
            top += height + gap
    out.save(path, optimize=True)


# ---- commands -----------------------------------------------------------------------------------


def analyse_run(folder, variant):
    log = read_log(folder / "log.lammps")
    energies = read_energies(folder / "energies.txt")
    events = read_events(folder / "events.txt")
    rows = timeline(events)
    s = summarise(variant, log, energies, events, rows)
    write_json(folder / "summary.json", s)
    results.report(folder / "log.lammps", "Crack timeline", timeline_text(s, rows))
    results.plot_energies(folder / "energies.png",
                          f"glass beam, {variant}; dashed: first damage, crack at y = 16 mm, crack through", energies,
                          [s[key] for key in ("first_damage_us", "crack_upper_us", "crack_through_us")],
                          large_elements=variant != "dem")
    made = ["summary.json", "energies.png"]
    shots = choose(pictures(folder, s["end_us"] * 1e-6 / s["steps"]))
    if shots:
        sheet(folder / "crack.png", [shots], [f"glass beam, {variant}"])
        made.append("crack.png")
    print(f"\nloop time {s['loop_seconds']:.2f} s on {s['ranks']} rank(s); {', '.join(made)} in {folder}")


def analyse_bpm(folder):
    log = read_log(folder / "log.lammps")
    kinetic = log["thermo"]["KinEng"]
    s = {
        "variant": "bpm",
        "discrete_elements": 40000,
        "kinetic_energy_initial_J": kinetic[0],
        "kinetic_energy_max_J": float(kinetic.max()),
        "kinetic_energy_final_J": kinetic[-1],
        "bonds_broken": int(log["thermo"]["broken"][-1]),
        "end_us": log["thermo"]["time_us"][-1],
        "loop_seconds": log["loop_seconds"],
        "ranks": log["ranks"],
        "steps": log["steps"],
    }
    write_json(folder / "summary.json", s)
    print(
        f"\nbpm/rotational: kinetic energy {kinetic[0]:.4f} J at first, {kinetic[-1]:.4f} J at last; "
        f"{s['bonds_broken']} bonds broken; loop time {s['loop_seconds']:.2f} s on {s['ranks']} rank(s)"
    )


def compare(root):
    s = {v: json.loads((root / v / "summary.json").read_text()) for v in ("adaptive", "dem", "bpm")}
    loop = {v: s[v]["loop_seconds"] for v in s}
    result = dict(s)
    result["paper"] = {**PAPER, "seconds": PAPER_SECONDS}
    result["speed"] = {
        "dem_over_adaptive": round(loop["dem"] / loop["adaptive"], 3),
        "bpm_over_dem": round(loop["bpm"] / loop["dem"], 3),
        "paper_dem_over_adaptive": round(PAPER_SECONDS["dem"] / PAPER_SECONDS["adaptive"], 3),
    }
    write_json(root / "compare.json", result)

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
    shots = [choose(pictures(root / v, s[v]["end_us"] * 1e-6 / s[v]["steps"])) for v in ("dem", "adaptive")]
    made = "compare.json"
    if all(shots):
        sheet(root / "compare.png", shots, ["DE model", "adaptive"])
        made += ", compare.png"
    print(f"\n{made} in {root}")


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
    main(sys.argv[1:])
