#!/usr/bin/env python3
"""What examples/tempered_pane/run.sh makes of a run: summary.json, energies.png, timeline.png, crack.png, a table in log.lammps.

analyse.py FOLDER     events.txt, energies.txt, pieces.dump, log.lammps, *.png of one run
"""

import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[2] / "python")]
import defe
import laminate
from defe import plots, summary

ALLOWED_RISE = 0.5  # of the total energy, percent: there is no other than that of the stress
THICKNESS = 8e-3
E, NU = 72e9, 0.22


def speed_of_crack(events):
    """m/s between a quarter and three quarters of the way that joints break away from the edge, or None."""
    broken = events.of("broken")
    if not len(broken):
        return None
    order = np.argsort(broken.time, kind="stable")
    time, reach = broken.time[order], np.maximum.accumulate(broken.x[order, 0])
    low, high = (float(time[np.argmax(reach >= share * reach[-1])]) for share in (0.25, 0.75))
    return round(0.5 * float(reach[-1]) / (high - low), 0) if high > low else None


def main(folder):
    log = defe.read_log(folder / "log.lammps")
    energies = defe.read_table(folder / "energies.txt")
    events = defe.read_events(folder / "events.txt")
    frame = defe.read_dump(folder / "pieces.dump")[-1]
    pieces = defe.fragments(frame["c_pieces"], frame["mass"])
    surface = log.value(r"Fix defe: prestress of part glass: parabola z 0 0\.008 surface -(\S+),", "the prestress")
    dt = float(log.value(r"Elements of \S+ m, steps of (\S+) s", "the time step"))
    area = pieces.mass.sum() / (2500 * THICKNESS)
    # a piece of 2 x 2 mm through the two middle layers; smaller ones are dust
    core = defe.fragments(frame["c_core"], frame["mass"])
    counted = int((core.mass >= 2500 * 4e-6 * 2 * float(log.value(r"Elements of (\S+) m,", "the size of elements"))).sum())
    took = (energies["fracture"][-1] + energies["released"][-1]) / area
    # what is shut in by so much crack through the whole thickness, in squares
    per_joint = max(float(log.value(r"Joints of part glass .* a joint releases (\S+) per area", "what a joint releases")), 8.0)
    squares = 2.5e-3 * (0.5 * took / per_joint / THICKNESS) ** 2
    s = {
        "surface_MPa": round(1e-6 * float(surface), 3),
        "area_mm2": round(1e6 * area, 1),
        "stored_per_area_J_m2": round((1 - NU) / E * float(surface) ** 2 * THICKNESS / 5, 2),
        "at_rest_J": float(log.value(r"Energy of the pane at rest: (\S+) J", "the energy at rest")),
        "first_damage_us": laminate.us(events.first("cohesive", "broken")),
        "crack_speed_m_s": speed_of_crack(events),
        "elements_converted": len(events.of("convert")),
        "joints_broken": len(events.of("broken")),
        "pieces": len(pieces),
        "single_DEs": int(pieces.single.sum()),
        "pieces_of_the_middle": counted,
        "squares_in_50_x_50_mm": round(squares, 1),
        "fracture_J_m2": round(took, 2),
        "crack_area_by_pane_area": round(took / per_joint, 3),
        **summary.totals(log, energies),
    }
    summary.write_json(folder / "summary.json", s)
    summary.report(folder / "log.lammps", "Tempered,", [
        f"Tempered, {s['surface_MPa']:g} MPa at the faces, after {s['end_us']:.0f} us",
        f"  stored {s['stored_per_area_J_m2']:.1f} J per m2 of pane, of which cracks took {s['fracture_J_m2']:.1f}",
        f"  crack: {laminate.shown(s['crack_speed_m_s'])} m/s; {s['elements_converted']} elements converted, {s['joints_broken']} joints broken",
        f"  pieces: {s['pieces']}, of the middle layers {counted} above 2 x 2 mm; {s['crack_area_by_pane_area']:.2f} times the area of the pane "
        f"has cracked, which would shut in {s['squares_in_50_x_50_mm']:.0f} squares in 50 x 50 mm",
        f"  total energy: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last, "
        f"largest rise {s['energy_rise_percent']:.4f} %",
    ])
    title = f"tempered pane, {s['surface_MPa']:g} MPa"
    plots.energies(folder / "energies.png", f"{title}; dashed: first damage", energies, [s["first_damage_us"]], limit=ALLOWED_RISE)
    plots.timeline(folder / "timeline.png", title, events, s["end_us"])
    cells = [(path, f"{time:.0f} us") for time, path in plots.pictures(folder, "top.*.png", dt)]
    if cells:
        plots.sheet(folder / "crack.png", title, cells, (len(cells) + 1) // 2, 480)
    summary.closing_line(folder, s)
    if s["energy_rise_percent"] > ALLOWED_RISE:
        sys.exit(f"the total energy rises by {s['energy_rise_percent']} % of its initial value")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    summary.main(main, Path(sys.argv[1]))
