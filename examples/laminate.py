"""What still holds together after a run of a laminated example, and all that is made of a pane under a ball.

Used by the analyse.py of laminated_beam, laminated_plate, curved_pane and hailstones.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))
import defe
from defe import summary

ALLOWED_RISE = 0.1  # of the total energy, percent


def numbers(log):
    """What in.* print: the number of nodes, and the mass of the interlayer (kg)."""
    return (int(log.value(r"Nodes: (\d+)", "the number of nodes")),
            float(log.value(r"Interlayer: (\S+) kg", "the mass of the interlayer")))


def held_together(path, interlayer=None):
    """Pieces at the end of a run, and the share of the brittle mass that holds on the interlayer.

    path: the dump of compute defe/fragment/atom, per node and DE the mass, the ID of its piece (0: of no
    interest here), and that among the interlayer's elements alone (0: not of the interlayer); interlayer: its mass (kg)."""
    frame = defe.read_dump(path)[-1]
    pieces = defe.fragments(frame["c_pieces"], frame["mass"])
    result = {
        "pieces": len(pieces),
        "pieces_of_one_DE": int(pieces.single.sum()),
        "pieces_of_more": int((~pieces.single).sum()),
        "heaviest_pieces_g": [round(1e3 * w, 4) for w in pieces.mass[:5]],
        "mass_of_loose_DEs_g": round(1e3 * pieces.mass[pieces.single].sum(), 4),
    }
    if interlayer is not None:
        # nodes between the layers have mass of both: that of the interlayer is what its elements have
        brittle = pieces.mass.sum() - interlayer
        off = pieces.mass[~np.isin(pieces.id, frame["c_pieces"][frame["c_film"] > 0])].sum()
        result["glass_on_interlayer_percent"] = round(100 * (1 - off / brittle), 3)
        result["glass_off_interlayer_g"] = round(1e3 * off, 4)
    result["heaviest_piece_percent"] = round(100 * pieces.mass.max() / pieces.mass.sum(), 3)
    return result


def used_conversions(events, nodes, edge):
    """Of the elements that were converted: the share (percent) that holds a joint which softens or is broken, and how
    many lie farther than four edges (m) from any such joint. nodes: IDs of DEs follow this one."""
    converted, damaged = events.of("convert"), events.of("cohesive", "broken")
    cracked = np.isin(converted.ids[:, 0] - 1, defe.element_of(damaged.ids, nodes))
    share = round(100 * float(cracked.mean()), 1) if len(converted) else None
    far = defe.cracks.far_from(converted.x[~cracked], damaged.x, 4 * edge)
    return {"converted_that_crack_percent": share, "converted_far_from_cracks": int(far.sum())}


def us(time, digits=3):
    """us of s; None stays None."""
    return None if time is None else round(1e6 * time, digits)


def damage_of(events):
    """Times and numbers of what has happened in a part: its events."""
    return {
        "first_conversion_us": us(events.first("convert")),
        "first_damage_us": us(events.first("cohesive", "broken")),
        "first_broken_us": us(events.first("broken")),
        "elements_converted": len(events.of("convert")),
        "joints_broken": len(events.of("broken")),
    }


def cracks_first(plies):
    """Which part is damaged first, and when (us)."""
    cracked = {p: s["first_damage_us"] for p, s in plies.items() if s["first_damage_us"] is not None}
    return {"cracks_first": min(cracked, key=cracked.get) if cracked else None,
            "first_damage_us": min(cracked.values()) if cracked else None}


def shown(time):
    return "-" if time is None else f"{time:.1f}"


# ---- a pane under a ball --------------------------------------------------------------------------


def measure_pane(folder, plies, interlayer, cracks):
    """summary.json of a pane, and what is drawn: log, energies, events, force on the ball (s, N)."""
    log = defe.read_log(folder / "log.lammps")
    energies = defe.read_table(folder / "energies.txt")
    mesh = defe.read_mesh(folder / "mesh.data")
    events = defe.read_events(folder / "events.txt")
    nodes, film = numbers(log)

    # the ball's mass is 2 E/v^2 of the first line
    speed = energies["vz"]
    ball = 2 * energies["e_kinetic"][0] / speed[0]**2
    middle, force = defe.force_from_velocity(energies.seconds(), speed, ball)
    part = mesh.parts[events.elements_of(nodes)]
    found = {}
    for ply in plies:
        mine = events.where(part == ply)
        broken = 1e3 * mine.of("broken").x
        first = broken[np.argmin(mine.of("broken").time)] if len(broken) else None
        found[ply] = {
            **damage_of(mine),
            "first_broken_at_mm": None if first is None else [round(float(c), 2) for c in first],
            "crack_radius_mm": round(float(np.hypot(broken[:, 0], broken[:, 1]).max(initial=0.0)), 2),
        }
    edge, last = mesh.edge(plies[0]), log.thermo.last()
    result = {
        "variant": folder.name,
        "element_mm": round(1e3 * edge, 3),
        "elements": len(mesh.hexes),
        "speed_m_s": round(-float(speed[0]), 6),
        **cracks_first(found),
        "plies": found,
        "ball_g": round(1e3 * ball, 3),
        "ball_force_max_kN": round(1e-3 * float(force.max()), 3),
        "ball_force_max_us": round(1e6 * float(middle[force.argmax()]), 2),
        "ball_energy_lost_J": round(0.5 * ball * (speed[0]**2 - speed[-1]**2), 4),
        "ball_speed_final_m_s": round(-float(speed[-1]), 4),
        "cracks": cracks,
        "elements_converted": int(last["converted"]),
        **used_conversions(events, nodes, edge),
        "joints_broken": int(last["broken"]),
        "ties_broken": int(last["debonded"]),
        "held_together": held_together(folder / "pieces.dump", film if interlayer else None),
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        **summary.totals(log, energies),
    }
    return result, energies, events, (middle, force)


def pane_table(s, title, interlayer):
    held, cracks = s["held_together"], s["cracks"]
    lines = [f"Pane, {title}, elements of {s['element_mm']:g} mm, after {s['end_us']:.0f} us",
             "  ply      first damage   first broken (us)   crack out to (mm)   elements converted   joints broken"]
    for ply, p in s["plies"].items():
        lines.append(f"  {ply:<8} {shown(p['first_damage_us']):>12} {shown(p['first_broken_us']):>19} {p['crack_radius_mm']:>19.1f}"
                     f" {p['elements_converted']:>20} {p['joints_broken']:>15}")
    lines += [
        f"  ball: force up to {s['ball_force_max_kN']:.2f} kN at {s['ball_force_max_us']:.1f} us, "
        f"{s['ball_energy_lost_J']:.3f} J lost, now {s['ball_speed_final_m_s']:.2f} m/s",
        f"  pieces: {held['pieces_of_more']}, and {held['pieces_of_one_DE']} single DEs of {held['mass_of_loose_DEs_g']:.3f} g; "
        f"the heaviest has {held['heaviest_piece_percent']:.2f} % of the mass",
    ]
    if s["converted_that_crack_percent"] is not None:
        lines.append(f"  of the elements converted {s['converted_that_crack_percent']:.1f} % hold a joint that softens or is broken; "
                     f"{s['converted_far_from_cracks']} are more than four edges from any")
    if cracks:
        ratio = cracks["ring_axes_to_diagonals"]
        lines.append(f"  {cracks['radial_cracks']} radial cracks; radius of the first rings along the axes of the pane to that along "
                     f"the diagonals: {'-' if ratio is None else ratio}")
    if interlayer:
        lines.append(f"  glass that holds on the interlayer: {held['glass_on_interlayer_percent']:.3f} %; "
                     f"ties broken: {s['ties_broken']}")
    lines.append(f"  total energy: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last, "
                 f"largest rise {s['energy_rise_percent']:.4f} % of the initial")
    return lines


def pane_report(folder, title, plies, interlayer, cracks=None):
    """All that laminated_plate and curved_pane make of a run in the folder: summary.json, energies.png, timeline.png,
    force.png, crack.png, and a table at the end of log.lammps. Fails if the total energy rises.

    plies: the parts of glass, from above; interlayer: whether there is one; cracks: what else was measured.
    """
    s, energies, events, force = measure_pane(folder, plies, interlayer, cracks)
    summary.write_json(folder / "summary.json", s)
    summary.report(folder / "log.lammps", "Pane,", pane_table(s, title, interlayer))

    damage = [p["first_damage_us"] for p in s["plies"].values()]
    defe.plots.energies(folder / "energies.png", f"{title}; dashed: first damage of the plies", energies, damage,
                        limit=ALLOWED_RISE)
    defe.plots.timeline(folder / "timeline.png", title, events, s["end_us"])
    defe.plots.force(folder / "force.png", f"force on the ball, {title}; dashed: first damage", {"": force}, s["end_us"], damage)
    cells = [(path, f"{time:.0f} us, from {view}") for view, glob in (("above", "top.*.png"), ("below", "bottom.*.png"))
             for time, path in defe.plots.pictures(folder, glob, 1e-6 * s["end_us"] / s["steps"])]
    if cells:
        defe.plots.sheet(folder / "crack.png", f"{title}, ball with {s['speed_m_s']:.0f} m/s", cells, len(cells) // 2, 480)
    summary.closing_line(folder, s)
    if s["energy_rise_percent"] > ALLOWED_RISE:
        sys.exit(f"the total energy rises by {s['energy_rise_percent']} % of its initial value")
