"""See README.md."""

import numpy as np
from manual import Accept, plt
from plates import Nodes, stable_step

TITLE = "Taylor's bar: a copper cylinder against a rigid wall"
KAMOULAKOS = "Kamoulakos (1990) and many others since: 227 m/s, 80 us"
LENGTH, RADIUS, SPEED, END = 32.4e-3, 3.2e-3, 227.0, 80e-6
E, NU, RHO, YIELD, HARDENING = 117e9, 0.35, 8930.0, 400e6, 100e6

ACCEPTANCE = [
    Accept("length after 80 us", KAMOULAKOS, low=21.4, high=21.5, unit="mm", digits=4),
    Accept("radius of the foot", KAMOULAKOS, low=7.0, high=7.2, unit="mm", digits=3),
    Accept("largest plastic strain", KAMOULAKOS, low=2.47, high=3.25, digits=3),
    Accept("drift of the energy", "exact", high=0.5, unit="%", digits=2),
]


def disc(n):
    """Nodes and quadrilaterals of a unit disc: a bulged square of 2n x 2n, and n rings around it."""
    half, bulge = 0.55, 0.25
    nodes, quads = Nodes(), []

    def core(a, b):
        """The square, its sides bent towards the circle."""
        p = half * np.array([a, b])
        r, side = np.hypot(a, b), max(abs(a), abs(b))
        return p if r == 0.0 else (1.0 - bulge) * p + bulge * half * 1.2 * side * np.array([a, b]) / r

    t = np.linspace(-1.0, 1.0, 2 * n + 1)
    for i in range(2 * n):
        for j in range(2 * n):
            quads.append([nodes.number(core(t[i + k], t[j + m])) for k, m in ((0, 0), (1, 0), (1, 1), (0, 1))])
    ring = [(x, -1.0) for x in t[:-1]] + [(1.0, y) for y in t[:-1]] + [(-x, 1.0) for x in t[:-1]] + [(-1.0, -y) for y in t[:-1]]

    def outside(k, s):
        a, b = ring[k % len(ring)]
        angle = np.arctan2(b, a)
        return (1.0 - s) * core(a, b) + s * np.array([np.cos(angle), np.sin(angle)])

    s = np.linspace(0.0, 1.0, n + 1)
    for k in range(len(ring)):
        for m in range(n):
            quads.append([nodes.number(outside(k + i, s[m + j])) for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))])
    return np.array(nodes.points), np.array(quads)


class Cylinder:
    def __init__(self, n, layers):
        flat, quads = disc(n)
        self.layer, self.nodes_of_layer = layers, len(flat)
        z = np.linspace(0.0, LENGTH, layers + 1)
        self.X = np.concatenate([np.column_stack([RADIUS * flat, np.full(len(flat), height)]) for height in z])
        self.hex = np.concatenate([np.column_stack([quads + k * len(flat), quads + (k + 1) * len(flat)]) for k in range(layers)])
        edges = np.linalg.norm(flat[quads] - flat[np.roll(quads, -1, axis=1)], axis=2)
        self.size = min(RADIUS * edges.min(), LENGTH / layers)

    def write(self, file):
        with open(file, "w") as out:
            out.write(f"cylinder\n\n{len(self.X)} atoms\n1 atom types\n{len(self.hex)} hexes\n\n-0.012 0.012 xlo xhi\n"
                      "-0.012 0.012 ylo yhi\n-0.002 0.036 zlo zhi\n\nAtoms # sphere\n\n")
            for k, p in enumerate(self.X):
                out.write(f"{k + 1} 1 0 1 {p[0]:.12g} {p[1]:.12g} {p[2]:.12g}\n")
            out.write("\nHexes\n\n")
            for k, h in enumerate(self.hex):
                out.write(f"{k + 1} copper " + " ".join(str(a + 1) for a in h) + "\n")


def last_frame(file):
    """Table of a dump."""
    lines = open(file).read().split("\n")
    start = max(k for k, line in enumerate(lines) if line.startswith("ITEM: TIMESTEP"))
    count = int(lines[start + 3])
    head = next(k for k in range(start, len(lines)) if lines[k].startswith(("ITEM: ENTRIES", "ITEM: ATOMS")))
    return np.array([[float(w) for w in line.split()] for line in lines[head + 1:head + 1 + count]])


def run(s):
    meshes = [(2, 24), (3, 36)] + ([(4, 54)] if s.fine else [])
    laws = {"linear": f"plastic {E:g} {NU} {RHO:g} {YIELD:g} {HARDENING:g}",
            "Johnson-Cook": f"johnson-cook 124e9 0.34 {RHO:g} 90e6 292e6 0.31 0.025 1 thermal 1.09 293 1356 386 0.9"}
    jobs = [(*mesh, "linear", "held") for mesh in meshes] + [(*meshes[0], "linear", "wall"), (*meshes[0], "Johnson-Cook", "held")]

    def one(job):
        n, layers, law, foot = job
        name = f"{n}x{layers}_{law.lower()}_{foot}"
        bar = Cylinder(n, layers)
        bar.write(s.path(name + ".data"))
        # elements at the foot become four times as thin
        dt = 0.2 * stable_step(E, NU, RHO, bar.size)
        steps = int(np.ceil(END / dt / 100)) * 100
        s.lammps("in.taylor", name, mesh=name + ".data", law=laws[law], foot=foot, speed=SPEED, dt=END / steps, steps=steps, every=steps // 100,
                 size=bar.size)
        shape = np.loadtxt(s.path(name + ".shape"))
        return bar, name, END / steps, shape

    found = dict(zip(jobs, s.all(one, jobs)))
    rows = [["law", "foot", "elements", "length (mm)", "radius of the foot (mm)", "largest plastic strain", "hottest element (K above the start)",
             "plastic work over kinetic energy", "drift of the energy (%)", "processor time (s)"]]
    for (_, _, law, foot), (bar, name, dt, shape) in found.items():
        e = s.energies(name)
        state = last_frame(s.path(name + ".state"))    # index, id, x, y, z, plastic strain, heat
        rows.append([law, foot, len(bar.hex), f"{1e3 * shape[-1, 1]:.2f}", f"{1e3 * shape[-1, 2]:.2f}", f"{shape[-1, 3]:.2f}",
                     f"{state[:, 6].max():.0f}" if state[:, 6].any() else "-", f"{e.viscous[-1] / e.e_kinetic[0]:.3f}", f"{100 * e.drift():.3f}", f"{s.loops[name]:.0f}"])
    s.table("All runs:", rows)

    figure, axes = plt.subplots(1, len(found), figsize=(2.6 * len(found) + 1.2, 4.2), sharey=True)
    for ax, ((_, _, law, foot), (bar, name, dt, shape)) in zip(axes, found.items()):
        state = last_frame(s.path(name + ".state"))
        x = last_frame(s.path(name + ".nodes"))[:, 1:]
        cut = np.flatnonzero((bar.X[bar.hex][:, :, 1].min(axis=1) > -1e-9) & (bar.X[bar.hex][:, :, 1].min(axis=1) < 1e-9))
        strain = state[np.argsort(state[:, 1]), 5]
        for k in cut:
            face = [a for a in bar.hex[k] if abs(bar.X[a, 1]) < 1e-9]
            corner = x[face][:, [0, 2]] * 1e3
            middle = corner.mean(axis=0)
            corner = corner[np.argsort(np.arctan2(*(corner - middle).T))]
            ax.fill(*corner.T, color=plt.cm.viridis(min(1.0, strain[k] / 3.0)), lw=0.2, edgecolor="k")
        ax.set(title=f"{law}\n{foot}, {len(bar.hex)}", xlabel="x (mm)", aspect="equal")
    axes[0].set_ylabel("z (mm)")
    figure.tight_layout()
    s.figure(figure, "shapes", "The middle plane after 80 us, in mm, with the number of elements; colour: plastic strain, from 0 (dark) to 3 (yellow).")

    bar, name, dt, shape = found[(*meshes[-1], "linear", "held")]
    figure, ax = plt.subplots(figsize=(5, 3.2))
    ax.plot(shape[:, 0] * dt * 1e6, shape[:, 1] * 1e3, label="length")
    ax.plot(shape[:, 0] * dt * 1e6, shape[:, 2] * 1e3, label="radius of the foot")
    for low, high in ((21.4, 21.5), (7.0, 7.2)):
        ax.axhspan(low, high, color="0.8")
    ax.set(xlabel="time (us)", ylabel="mm")
    ax.legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "lengths", "Length and radius over time, linear hardening, finest mesh; grey: published after 80 us.")
    return {"length after 80 us": 1e3 * shape[-1, 1], "radius of the foot": 1e3 * shape[-1, 2], "largest plastic strain": shape[-1, 3],
            "drift of the energy": 100 * max(s.energies(f[1]).drift() for f in found.values())}
