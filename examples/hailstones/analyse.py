#!/usr/bin/env python3
"""What examples/hailstones/run.sh makes of a run: summary.json, energies.png, hail.png, a table in log.lammps.

analyse.py FOLDER     mesh.data, events.txt, energies.txt, hail.txt, pieces.dump, log.lammps, *.png of one run
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import laminate
import results


def main(folder):
    log = laminate.read_log(folder / "log.lammps")
    energies = results.read_energies(folder / "energies.txt")
    hail = results.read_energies(folder / "hail.txt")
    mesh = laminate.read_mesh(folder / "mesh.data")
    events = laminate.read_events(folder / "events.txt")
    held = laminate.held_together(folder / "pieces.dump", log, True)
    first = lambda *kinds: round(min(times), 3) if (times := [r[1] for r in events if r[2] in kinds]) else None
    s = {
        "hail_speed_m_s": round(-float(hail["vz"][0]), 6),
        "hail_speed_final_m_s": round(-float(hail["vz"][-1]), 4),
        "beads_speed_final_m_s": round(-float(hail["vbeads"][-1]), 4),
        "ice_bonds": int(hail["bonds"][0]),
        "ice_bonds_broken": int(hail["bonds"][0] - hail["bonds"][-1]),
        "first_conversion_us": first("convert"),
        "first_damage_us": first("cohesive", "broken"),
        "elements": len(mesh["hexes"]),
        "elements_converted": int(log["last"]["converted"]),
        "joints_broken": int(log["last"]["contact"]),
        "ties_broken": int(log["last"]["debonded"]),
        "held_together": held,
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        **results.totals(log, energies),
    }
    results.write_json(folder / "summary.json", s)
    us = lambda t: "-" if t is None else f"{t:.1f} us"
    results.report(folder / "log.lammps", "Hail,", [
        f"Hail, {s['hail_speed_m_s']:g} m/s, after {s['end_us']:.0f} us",
        f"  ice: {s['ice_bonds_broken']} of {s['ice_bonds']} bonds broken, mean velocity now {s['hail_speed_final_m_s']:.2f} m/s "
        f"downwards; beads {s['beads_speed_final_m_s']:.2f} m/s",
        f"  glass: first conversion {us(s['first_conversion_us'])}, first damage {us(s['first_damage_us'])}, "
        f"{s['elements_converted']} elements converted, {s['joints_broken']} joints broken",
        f"  glass that holds on the interlayer: {held['glass_on_interlayer_percent']:.3f} %; ties broken: {s['ties_broken']}",
        f"  energy without that of bonds and grains: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last",
    ])
    results.plot_energies(folder / "energies.png", "hail on a laminated pane; dashed: first damage", energies,
                          [s["first_damage_us"]])
    plt = results.plotting()
    figure, (bonds, speed) = plt.subplots(1, 2, figsize=(11, 4), constrained_layout=True)
    bonds.plot(hail["time_us"], hail["bonds"][0] - hail["bonds"], color="#36c", label="bonds of the ice")
    bonds.plot(energies["time_us"], energies["contact"], color="#d33", label="joints of the glass")
    bonds.set(title="broken", xlabel="us", xlim=(0, s["end_us"]))
    speed.plot(hail["time_us"], -hail["vz"], color="#36c", label="ice")
    speed.plot(hail["time_us"], -hail["vbeads"], color="#383", label="beads")
    speed.set(title="mean velocity downwards", xlabel="us", ylabel="m/s", xlim=(0, s["end_us"]))
    bonds.legend()
    speed.legend()
    figure.savefig(folder / "hail.png", dpi=100)
    plt.close(figure)
    time = lambda p: int(p.name.split(".")[1]) * s["end_us"] / s["steps"]
    cells = [(p, f"{time(p):.0f} us") for glob in ("side.*.png", "bottom.*.png") for p in sorted(folder.glob(glob), key=time)]
    if cells:
        laminate.sheet(folder / "crack.png", f"hail and beads on a laminated pane, {s['hail_speed_m_s']:g} m/s", cells,
                       len(cells) // 2, 520)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
