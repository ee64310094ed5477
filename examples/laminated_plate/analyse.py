#!/usr/bin/env python3
"""What examples/laminated_plate/run.sh makes of a run: summary.json, energies.png, force.png, crack.png.

analyse.py FOLDER VARIANT     mesh.data, events.txt, energies.txt, log.lammps, *.png of one run
"""

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import laminate

GLASS, PVB, STEEL = 2500.0, 1100.0, 7850.0
TITLES = {"laminated": "glass 3 / PVB 0.76 / glass 3 mm", "single": "glass 6 mm"}
ALLOWED_RISE = 0.1  # percent


def main(folder, variant):
    folder = Path(folder)
    log = laminate.read_log(folder / "log.lammps")
    energies = laminate.read_energies(folder / "energies.txt")
    mesh = laminate.read_mesh(folder / "mesh.data")
    events = laminate.read_events(folder / "events.txt")
    pieces = laminate.Pieces(mesh, events, log["nodes"], {"lower": GLASS, "upper": GLASS, "inter": PVB})
    pieces.check(log["last"])

    # the ball's mass is 2 E/v^2 of the first line
    speed, total = energies["vz"], energies["total"]
    ball = 2 * energies["e_kinetic"][0] / speed[0]**2
    middle, force = laminate.impactor_force(energies, ball, "vz")
    part_of = lambda row: mesh["parts"][row[3] - 1 if row[2] == "convert" else (row[3] - log["nodes"] - 1) // 8]
    plies = {}
    for ply in [p for p in ("lower", "upper") if p in mesh["parts"]]:
        rows = [r for r in events if part_of(r) == ply]
        times = {kind: [r[1] for r in rows if r[2] == kind] for kind in ("convert", "cohesive", "broken")}
        first = lambda t: round(min(t), 3) if t else None
        broken = [r for r in rows if r[2] == "broken"]
        plies[ply] = {
            "first_conversion_us": first(times["convert"]),
            "first_damage_us": first(times["cohesive"] + times["broken"]),
            "first_broken_us": first(times["broken"]),
            "first_broken_at_mm": [round(float(c), 2) for c in min(broken, key=lambda r: r[1])[5]] if broken else None,
            "crack_radius_mm": round(float(max(math.hypot(*r[5][:2]) for r in broken)), 2) if broken else 0.0,
            "elements_converted": len(times["convert"]),
            "joints_broken": len(broken),
        }
    cracked = {p: s["first_damage_us"] for p, s in plies.items() if s["first_damage_us"] is not None}
    held = pieces.summary("inter" if variant != "single" else None)
    s = {
        "variant": variant,
        "element_mm": round(1e3 * float(np.ptp(mesh["x"][mesh["hexes"][0], 0])), 3),
        "speed_m_s": round(-float(speed[0]), 6),
        "cracks_first": min(cracked, key=cracked.get) if cracked else None,
        "first_damage_us": min(cracked.values()) if cracked else None,
        "plies": plies,
        "ball_g": round(1e3 * ball, 3),
        "ball_force_max_kN": round(float(force.max()), 3),
        "ball_force_max_us": round(float(middle[force.argmax()]), 2),
        "ball_energy_lost_J": round(0.5 * ball * (speed[0]**2 - speed[-1]**2), 4),
        "ball_speed_final_m_s": round(-float(speed[-1]), 4),
        "elements_converted": int(log["last"]["converted"]),
        "joints_broken": int(log["last"]["contact"]),
        "ties_broken": int(log["last"]["debonded"]),
        "held_together": held,
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        "energy_initial_J": float(total[0]),
        "energy_max_J": float(total.max()),
        "energy_final_J": float(total[-1]),
        "energy_rise_percent": round(laminate.energy_rise(energies), 5),
        "end_us": float(energies["time_us"][-1]),
        "loop_seconds": log["loop_seconds"],
        "ranks": log["ranks"],
        "steps": log["steps"],
    }
    laminate.write_json(folder / "summary.json", s)

    us = lambda t: "-" if t is None else f"{t:.1f}"
    text = ["", f"Laminated plate, {TITLES[variant]}, elements of {s['element_mm']:g} mm, after {s['end_us']:.0f} us"]
    text += ["  ply      first damage   first broken (us)   crack out to (mm)   elements converted   joints broken"]
    for ply in reversed(list(plies)):
        p = plies[ply]
        text.append(f"  {ply:<8} {us(p['first_damage_us']):>12} {us(p['first_broken_us']):>19} {p['crack_radius_mm']:>19.1f}"
                    f" {p['elements_converted']:>20} {p['joints_broken']:>15}")
    text += [
        f"  ball: force up to {s['ball_force_max_kN']:.2f} kN at {s['ball_force_max_us']:.1f} us, "
        f"{s['ball_energy_lost_J']:.3f} J lost, now {s['ball_speed_final_m_s']:.2f} m/s",
        f"  pieces: {held['pieces_of_more']}, and {held['pieces_of_one_DE']} single DEs of {held['mass_of_loose_DEs_g']:.3f} g; "
        f"the heaviest has {held['heaviest_piece_percent']:.2f} % of the mass",
    ]
    if "glass_on_interlayer_percent" in held:
        text.append(f"  glass that holds on the interlayer: {held['glass_on_interlayer_percent']:.3f} %; ties broken: {s['ties_broken']}")
    text.append(f"  total energy: {total[0]:.6f} J at first, {total[-1]:.6f} J at last, largest rise "
                f"{s['energy_rise_percent']:.4f} % of the initial")
    text = "\n".join(text) + "\n"
    print(text, end="")
    file = folder / "log.lammps"
    file.write_text(file.read_text().split("\nLaminated plate,")[0].rstrip() + "\n" + text)

    damage = [p["first_damage_us"] for p in plies.values()]
    laminate.plot_energies(folder / "energies.png", f"laminated_plate, {TITLES[variant]}; dashed: first damage of the plies",
                           energies, damage)
    plt = laminate.plotting()
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    axis.plot(middle, force, color="k")
    for time in damage:
        if time is not None:
            axis.axvline(time, color="#d33", lw=0.8, ls=(0, (4, 3)), zorder=0)
    axis.set(xlabel="us", ylabel="kN", xlim=(0, s["end_us"]), title=f"force on the ball, {TITLES[variant]}; dashed: first damage")
    figure.savefig(folder / "force.png", dpi=100)

    time = lambda p: int(p.name.split(".")[1]) * s["end_us"] / s["steps"]
    cells = [(p, f"{time(p):.0f} us, from {view}") for view, glob in (("above", "top.*.png"), ("below", "bottom.*.png"))
             for p in sorted(folder.glob(glob), key=time)]
    if cells:
        laminate.sheet(folder / "crack.png", f"{TITLES[variant]}, ball with {s['speed_m_s']:.0f} m/s", cells, len(cells) // 2, 480)
    if s["energy_rise_percent"] > ALLOWED_RISE:
        sys.exit(f"laminated_plate: the total energy rises by {s['energy_rise_percent']} % of its initial value")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
