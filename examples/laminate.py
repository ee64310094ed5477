"""Reads what a run of a laminated example wrote, and says what still holds together.

Used by the analyse.py of laminated_beam, laminated_plate and curved_pane.
"""

import math
import re
import sys

import numpy as np

import results

# ---- files --------------------------------------------------------------------------------------


def read_log(path):
    """As results.read_log(), with the number of nodes, the mass of the interlayer (kg), and the last line of
    thermo output."""
    log = results.read_log(path)
    nodes = re.findall(r"^Nodes: (\d+)", log["text"], re.M)
    interlayer = re.findall(r"^Interlayer: (\S+) kg", log["text"], re.M)
    if not nodes or not interlayer:
        sys.exit(f"no number of nodes or no mass of the interlayer in {path}")
    return {**log, "nodes": int(nodes[0]), "interlayer": float(interlayer[-1]), "last": {name: column[-1] for name, column in log["thermo"].items()}}


def read_mesh(path):
    """Nodes (m), elements (indices of nodes) and the part of each, as tools/layers2data wrote them."""
    section, nodes, hexes, parts = "", [], [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] in (["Atoms"], ["Hexes"]):
            section = words[0]
        elif words and section == "Atoms":
            nodes.append(words[4:7])
        elif words and section == "Hexes":
            parts.append(words[1])
            hexes.append(words[2:10])
    return {"x": np.array(nodes, float), "hexes": np.array(hexes, int) - 1, "parts": np.array(parts)}


def read_events(path):
    """Rows of the event file: step, time (us), kind, id, id2, position (mm), direction, value."""
    rows = []
    for line in path.read_text().splitlines():
        if line and line[0] != "#":
            w = line.split()
            rows.append((int(w[0]), 1e6 * float(w[1]), w[2], int(w[3]), int(w[4]),
                         1e3 * np.array(w[5:8], float), np.array(w[8:11], float), float(w[11])))
    return rows


# ---- what holds together ------------------------------------------------------------------------


def held_together(path, log, interlayer):
    """Pieces at the end of a run, heaviest first, and the share of the brittle mass that holds on the interlayer.

    path: the dump of compute defe/fragment/atom, per node and DE the mass, the ID of its piece (0: of no
    interest here), and that among the interlayer's elements alone (0: not of the interlayer)."""
    lines = path.read_text().splitlines()
    names = lines[8].split()[2:]  # ITEM: ATOMS ...
    table = np.array([line.split() for line in lines[9:]], float)
    mass, piece, film = (table[:, names.index(name)] for name in ("mass", "c_pieces", "c_film"))
    inside = piece > 0
    heads, place = np.unique(piece[inside], return_inverse=True)
    weight, count = np.bincount(place, mass[inside]), np.bincount(place)
    single = count == 1  # an atom alone is a DE: nodes come by eight
    result = {
        "pieces": len(heads),
        "pieces_of_one_DE": int(single.sum()),
        "pieces_of_more": int((~single).sum()),
        "heaviest_pieces_g": [round(1e3 * w, 4) for w in np.sort(weight)[::-1][:5]],
        "mass_of_loose_DEs_g": round(1e3 * weight[single].sum(), 4),
    }
    if interlayer:
        # nodes between the layers have mass of both: that of the interlayer is what its elements have
        brittle = weight.sum() - log["interlayer"]
        off = weight[~np.isin(heads, piece[inside & (film > 0)])].sum()
        result["glass_on_interlayer_percent"] = round(100 * (1 - off / brittle), 3)
        result["glass_off_interlayer_g"] = round(1e3 * off, 4)
    result["heaviest_piece_percent"] = round(100 * weight.max() / weight.sum(), 3)
    return result


def used_conversions(events, nodes, edge):
    """Of the elements that were converted: the share (percent) that holds a joint which softens or is broken, and how
    many lie farther than four edges from any such joint. edge in mm; nodes: IDs of DEs follow this one."""
    converted = {e[3] - 1: e[5] for e in events if e[2] == "convert"}
    damaged, cells, reach = set(), {}, 4 * edge
    cell = lambda x: tuple(int(c // reach) for c in x)
    for e in events:
        if e[2] in ("cohesive", "broken"):
            damaged.update((de - nodes - 1) // 8 for de in (e[3], e[4]))
            cells.setdefault(cell(e[5]), []).append(e[5])
    far = 0
    for x in (x for element, x in converted.items() if element not in damaged):
        i, j, k = cell(x)
        near = [p for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1) for p in cells.get((i + a, j + b, k + c), ())]
        far += not near or float(np.min(np.linalg.norm(np.array(near) - x, axis=1))) > reach
    share = round(100 * len(damaged & converted.keys()) / len(converted), 1) if converted else None
    return {"converted_that_crack_percent": share, "converted_far_from_cracks": far}


# ---- pictures -----------------------------------------------------------------------------------


def impactor_force(energies, mass, name):
    """Force on the impactor (kN, upwards) from its velocity: the mean between two lines, at their middle."""
    t, v = energies["time_us"], energies[name]
    return 0.5 * (t[1:] + t[:-1]), 1e-3 * mass * np.diff(v) / (1e-6 * np.diff(t))


def sheet(path, title, cells, columns, width=720):
    """Pictures (file, caption) side by side and under each other."""
    import matplotlib.font_manager as fonts
    from PIL import Image, ImageDraw, ImageFont

    font = lambda size: ImageFont.truetype(fonts.findfont("DejaVu Sans"), size)
    head, bar, gap = 44, 34, 8
    images = []
    for file, caption in cells:
        image = Image.open(file).convert("RGB")
        images.append((image.resize((width, round(image.height * width / image.width)), Image.LANCZOS), caption))
    rows = [images[k:k + columns] for k in range(0, len(images), columns)]
    heights = [max(i.height for i, _ in row) + bar for row in rows]
    out = Image.new("RGB", (columns * (width + gap) + gap, head + sum(heights) + len(rows) * gap), "#d8d8d8")
    draw = ImageDraw.Draw(out)
    draw.text((gap + 4, 8), title, fill="black", font=font(24))
    top = head
    for row, height in zip(rows, heights):
        for k, (image, caption) in enumerate(row):
            left = gap + k * (width + gap)
            draw.rectangle((left, top, left + width - 1, top + height - 1), fill="white")
            out.paste(image, (left, top + (height - bar - image.height) // 2))
            draw.text((left + 12, top + height - bar + 4), caption, fill="black", font=font(20))
        top += height + gap
    out.quantize(256).save(path, optimize=True)  # few colours: small files


# ---- a pane under a ball --------------------------------------------------------------------------

ALLOWED_RISE = 0.1  # percent


def pane_report(folder, title, plies, interlayer, cracks=None):
    """All that laminated_plate and curved_pane make of a run in the folder: summary.json, energies.png,
    force.png, crack.png, and a table at the end of log.lammps. Fails if the total energy rises.

    plies: the parts of glass, from above; interlayer: whether there is one; cracks: what else was measured.
    """
    log = read_log(folder / "log.lammps")
    energies = results.read_energies(folder / "energies.txt")
    mesh = read_mesh(folder / "mesh.data")
    events = read_events(folder / "events.txt")

    # the ball's mass is 2 E/v^2 of the first line
    speed = energies["vz"]
    ball = 2 * energies["e_kinetic"][0] / speed[0]**2
    middle, force = impactor_force(energies, ball, "vz")
    part_of = lambda row: mesh["parts"][row[3] - 1 if row[2] == "convert" else (row[3] - log["nodes"] - 1) // 8]
    found = {}
    for ply in plies:
        rows = [r for r in events if part_of(r) == ply]
        times = {kind: [r[1] for r in rows if r[2] == kind] for kind in ("convert", "cohesive", "broken")}
        first = lambda t: round(min(t), 3) if t else None
        broken = [r for r in rows if r[2] == "broken"]
        found[ply] = {
            "first_conversion_us": first(times["convert"]),
            "first_damage_us": first(times["cohesive"] + times["broken"]),
            "first_broken_us": first(times["broken"]),
            "first_broken_at_mm": [round(float(c), 2) for c in min(broken, key=lambda r: r[1])[5]] if broken else None,
            "crack_radius_mm": round(float(max(math.hypot(*r[5][:2]) for r in broken)), 2) if broken else 0.0,
            "elements_converted": len(times["convert"]),
            "joints_broken": len(broken),
        }
    cracked = {p: s["first_damage_us"] for p, s in found.items() if s["first_damage_us"] is not None}
    held = held_together(folder / "pieces.dump", log, interlayer)
    brittle = np.flatnonzero(mesh["parts"] == plies[0])
    edge = 1e3 * float(np.median(np.linalg.norm(np.diff(mesh["x"][mesh["hexes"][brittle][:, :2]], axis=1), axis=2)))
    s = {
        "variant": folder.name,
        "element_mm": round(edge, 3),
        "elements": len(mesh["hexes"]),
        "speed_m_s": round(-float(speed[0]), 6),
        "cracks_first": min(cracked, key=cracked.get) if cracked else None,
        "first_damage_us": min(cracked.values()) if cracked else None,
        "plies": found,
        "ball_g": round(1e3 * ball, 3),
        "ball_force_max_kN": round(float(force.max()), 3),
        "ball_force_max_us": round(float(middle[force.argmax()]), 2),
        "ball_energy_lost_J": round(0.5 * ball * (speed[0]**2 - speed[-1]**2), 4),
        "ball_speed_final_m_s": round(-float(speed[-1]), 4),
        "cracks": cracks,
        "elements_converted": int(log["last"]["converted"]),
        **used_conversions(events, log["nodes"], edge),
        "joints_broken": int(log["last"]["contact"]),
        "ties_broken": int(log["last"]["debonded"]),
        "held_together": held,
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        **results.totals(log, energies),
    }
    results.write_json(folder / "summary.json", s)

    us = lambda t: "-" if t is None else f"{t:.1f}"
    lines = [f"Pane, {title}, elements of {s['element_mm']:g} mm, after {s['end_us']:.0f} us",
             "  ply      first damage   first broken (us)   crack out to (mm)   elements converted   joints broken"]
    for ply, p in found.items():
        lines.append(f"  {ply:<8} {us(p['first_damage_us']):>12} {us(p['first_broken_us']):>19} {p['crack_radius_mm']:>19.1f}"
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
    results.report(folder / "log.lammps", "Pane,", lines)

    damage = [p["first_damage_us"] for p in found.values()]
    results.plot_energies(folder / "energies.png", f"{title}; dashed: first damage of the plies", energies, damage,
                          limit=ALLOWED_RISE)
    plt = results.plotting()
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    axis.plot(middle, force, color="k")
    for time in damage:
        if time is not None:
            axis.axvline(time, color="#d33", lw=0.8, ls=(0, (4, 3)), zorder=0)
    axis.set(xlabel="us", ylabel="kN", xlim=(0, s["end_us"]), title=f"force on the ball, {title}; dashed: first damage")
    figure.savefig(folder / "force.png", dpi=100)

    time = lambda p: int(p.name.split(".")[1]) * s["end_us"] / s["steps"]
    cells = [(p, f"{time(p):.0f} us, from {view}") for view, glob in (("above", "top.*.png"), ("below", "bottom.*.png"))
             for p in sorted(folder.glob(glob), key=time)]
    if cells:
        sheet(folder / "crack.png", f"{title}, ball with {s['speed_m_s']:.0f} m/s", cells, len(cells) // 2, 480)
    if s["energy_rise_percent"] > ALLOWED_RISE:
        sys.exit(f"the total energy rises by {s['energy_rise_percent']} % of its initial value")
