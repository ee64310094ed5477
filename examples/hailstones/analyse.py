#!/usr/bin/env python3
"""What examples/hailstones/run.sh makes of a run: summary.json, energies.png, timeline.png, hail.png, a table in log.lammps.

analyse.py FOLDER     mesh.data, events.txt, energies.txt, hail.txt, pieces.dump, log.lammps, *.png of one run
"""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[2] / "python")]
import defe
import laminate
from defe import plots, summary


def main(folder):
    log = defe.read_log(folder / "log.lammps")
    energies = defe.read_table(folder / "energies.txt")
    hail = defe.read_table(folder / "hail.txt")
    mesh = defe.read_mesh(folder / "mesh.data")
    events = defe.read_events(folder / "events.txt")
    held = laminate.held_together(folder / "pieces.dump", laminate.numbers(log)[1])
    last = log.thermo.last()
    s = {
        "hail_speed_m_s": round(-float(hail["vz"][0]), 6),
        "hail_speed_final_m_s": round(-float(hail["vz"][-1]), 4),
        "beads_speed_final_m_s": round(-float(hail["vbeads"][-1]), 4),
        "ice_bonds": int(hail["bonds"][0]),
        "ice_bonds_broken": int(hail["bonds"][0] - hail["bonds"][-1]),
        "first_conversion_us": laminate.us(events.first("convert")),
        "first_damage_us": laminate.us(events.first("cohesive", "broken")),
        "elements": len(mesh.hexes),
        "elements_converted": int(last["converted"]),
        "joints_broken": int(last["broken"]),
        "ties_broken": int(last["debonded"]),
        "held_together": held,
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        **summary.totals(log, energies),
    }
    summary.write_json(folder / "summary.json", s)
    summary.report(folder / "log.lammps", "Hail,", [
        f"Hail, {s['hail_speed_m_s']:g} m/s, after {s['end_us']:.0f} us",
        f"  ice: {s['ice_bonds_broken']} of {s['ice_bonds']} bonds broken, mean velocity now {s['hail_speed_final_m_s']:.2f} m/s "
        f"downwards; beads {s['beads_speed_final_m_s']:.2f} m/s",
        f"  glass: first conversion {laminate.shown(s['first_conversion_us'])} us, first damage {laminate.shown(s['first_damage_us'])} us, "
        f"{s['elements_converted']} elements converted, {s['joints_broken']} joints broken",
        f"  glass that holds on the interlayer: {held['glass_on_interlayer_percent']:.3f} %; ties broken: {s['ties_broken']}",
        f"  energy without that of bonds and grains: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last",
    ])
    plots.energies(folder / "energies.png", "hail on a laminated pane; dashed: first damage", energies,
                          [s["first_damage_us"]])
    plt = plots.plotting()
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
    plots.timeline(folder / "timeline.png", "hail on a laminated pane: glass", events, s["end_us"])
    cells = [(path, f"{time:.0f} us") for pattern in ("side.*.png", "bottom.*.png")
             for time, path in plots.pictures(folder, pattern, 1e-6 * s["end_us"] / s["steps"])]
    if cells:
        plots.sheet(folder / "crack.png", f"hail and beads on a laminated pane, {s['hail_speed_m_s']:g} m/s", cells,
                    len(cells) // 2, 520)
    summary.closing_line(folder, s)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    summary.main(main, Path(sys.argv[1]))
