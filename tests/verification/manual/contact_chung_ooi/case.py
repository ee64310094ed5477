"""See README.md."""

import sys
from pathlib import Path

import numpy as np
from manual import Accept, plt

sys.path.insert(0, str(Path(__file__).resolve().parent))
import balls  # noqa: E402

TITLE = "Chung and Ooi: collisions of two spheres, and of one with a plane"
CHUNG = "Chung and Ooi, Granular Matter 13 (2011) 643"
HERTZ = "Hertz, closed form"
SLIDING = "sliding throughout: the impulse across is mu times that along, closed form"

# young, nu, rho, radius, speed (of each of two that collide, or towards the plane)
NORMAL = {"1, glass": (4.8e10, 0.2, 2800.0, 0.01, 10.0), "1, limestone": (2.0e10, 0.25, 2500.0, 0.01, 10.0),
          "2, aluminium alloy": (7.0e10, 0.3, 2699.0, 0.1, 0.2), "2, magnesium alloy": (4.0e10, 0.35, 1800.0, 0.1, 0.2)}
OXIDE = (3.8e11, 0.23, 4000.0, 2.5e-3, 3.9)
FRICTION, RESTITUTION = 0.092, 0.98
ANGLES = (5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
SLIDES = 40.0    # from this angle on; a rigid sphere begins to slide throughout at 32.5 degrees
LEVELS = (0.2, 0.4, 0.6, 0.8, 1.0)

ACCEPTANCE = [
    Accept("largest force, glass, DEs", CHUNG, target=10.70, tolerance=0.02, unit="kN", digits=4),
    Accept("largest overlap, glass, DEs", CHUNG, target=274.0, tolerance=1.0, unit="um", digits=4),
    Accept("time of contact, glass, DEs", CHUNG, target=40.3, tolerance=0.1, unit="us", digits=4),
    Accept("largest force, limestone, DEs", CHUNG, target=7.11, tolerance=0.02, unit="kN", digits=4),
    Accept("force on the plane over Hertz, worst alloy, DEs", HERTZ, target=1.0, tolerance=0.005, digits=5),
    Accept("largest force, glass, meshed", CHUNG, target=10.70, tolerance=0.54, unit="kN", digits=4),
    Accept("largest overlap, glass, meshed", CHUNG, target=274.0, tolerance=14.0, unit="um", digits=4),
    Accept("time of contact, glass, meshed", CHUNG, target=40.3, tolerance=2.0, unit="us", digits=4),
    Accept("largest force, limestone, meshed", CHUNG, target=7.11, tolerance=0.36, unit="kN", digits=4),
    Accept("restitution, farthest from the given one", "exact", target=0.0, tolerance=0.005, digits=2),
    Accept("tangential restitution, farthest from sliding", SLIDING, target=0.0, tolerance=0.01, digits=2),
    Accept("spin over that of sliding, farthest from 1", SLIDING, target=0.0, tolerance=0.01, digits=2),
    Accept("largest drift of the energy", "exact", high=0.1, unit="%", digits=2),
]


def hertz(young, nu, rho, radius, speed):
    """Of two equal spheres that meet with this speed each, or of one and a rigid plane: largest force, overlap (of the two), time."""
    stiff, mass = 0.5 * young / (1.0 - nu * nu), 0.5 * rho * 4.0 / 3.0 * np.pi * radius**3
    k = 4.0 / 3.0 * stiff * np.sqrt(0.5 * radius)
    overlap = (2.5 * 0.5 * mass * (2.0 * speed) ** 2 / k) ** 0.4
    return k * overlap**1.5, overlap, 2.943275 * overlap / (2.0 * speed)


class Hit:
    """Time series of a collision."""

    def __init__(self, file, dt):
        self.step, self.overlap, self.push, *self.rest = np.loadtxt(file).T
        self.dt, self.total = dt, self.rest[-1]
        touching = np.flatnonzero(self.push > 1e-4 * self.push.max())
        self.force, self.deep = self.push.max(), self.overlap.max()
        self.time = dt * (touching[-1] - touching[0] + 1)

    def drift(self):
        return 100.0 * np.abs(self.total - self.total[0]).max() / self.total[0]


def collide(s, name, young, nu, rho, radius, vn, vt=0.0, restitution=1.0, friction=0.0):
    """Two DEs that are each other's image by a half turn: one that hits a rigid plane."""
    force, overlap, time = hertz(young, nu, rho, radius, vn)
    part = 1000 if restitution > 0.9 else 4000    # damping goes with velocities of half a step before
    dt = time / part
    s.lammps("in.des", name, young=young, nu=nu, rho=rho * np.pi / 6.0, radius=radius, restitution=restitution, friction=friction, vn=vn,
             vt=vt, back=0.5 * time * vt, dt=dt, steps=int((1.3 if restitution > 0.9 else 2.5) * part))
    return Hit(s.path(name + ".hit"), dt)


def oblique(s):
    """Test 4: angle, restitution along and across, spin over that of sliding."""
    *what, speed = OXIDE
    radius, found, hits = what[3], [], []
    for angle in ANGLES:
        vn, vt = speed * np.cos(np.radians(angle)), speed * np.sin(np.radians(angle))
        hit = collide(s, f"oblique_{angle:g}", *what, vn, vt, RESTITUTION, FRICTION)
        vx, vy, spin, _ = (r[-1] for r in hit.rest)
        full = FRICTION * (1.0 + RESTITUTION) * vn
        found.append((angle, -vy / vn, vx / vt, abs(spin) / (2.5 * full / radius), 1.0 - full / vt, np.degrees(np.arctan(abs(spin) * radius / vn))))
        hits.append(hit)
    return np.array(found), hits


def draw(s, curves, found):
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6))
    for (test, how), hit in curves.items():
        if test == "1, glass":
            axes[0].plot(1e6 * hit.overlap, 1e-3 * hit.push, lw=0.9, label=how)
    deep = np.linspace(0.0, 274e-6, 50)
    force, overlap, _ = hertz(*NORMAL["1, glass"])
    axes[0].plot(1e6 * deep, 1e-3 * force * (deep / overlap) ** 1.5, "k:", lw=1.2, label="Hertz")
    axes[0].set(xlim=(0, 290), ylim=(0, 12), xlabel="overlap (um)", ylabel="force (kN)", title="test 1, glass")
    axes[0].legend(fontsize=7)
    axes[1].plot(found[:, 0], found[:, 2], "o-", ms=4, lw=0.8, label="DEs")
    angle = np.linspace(33.0, 85.0, 60)
    axes[1].plot(angle, 1.0 - FRICTION * (1.0 + RESTITUTION) / np.tan(np.radians(angle)), "k:", label="slides throughout")
    axes[1].axhline(5.0 / 7.0, color="0.6", lw=0.8, label="rolls away, rigid")
    axes[1].set(xlabel="angle from the normal (degrees)", ylabel="restitution across", ylim=(0.4, 1.0), title="test 4, aluminium oxide")
    axes[1].legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "collisions", "Force against overlap of two glass spheres, and restitution across in oblique collisions.")


def run(s):
    values, rows = {}, [["test", "", "largest force (kN)", "Hertz", "largest overlap (um)", "Hertz", "time of contact (us)", "Hertz", "processor time (s)"]]
    curves, drift = {}, []

    def keep(test, how, hit, exact, name):
        rows.append([test, how] + [f"{x:.4g}" for pair in zip((1e-3 * hit.force, 1e6 * hit.deep, 1e6 * hit.time),
                                                             (1e-3 * exact[0], 1e6 * exact[1], 1e6 * exact[2])) for x in pair]
                    + [f"{s.loops[name]:.1f}"])
        curves[(test, how)] = hit
        drift.append(hit.drift())

    worst = 1.0
    for test, (young, nu, rho, radius, speed) in NORMAL.items():
        name = "des_" + test.replace(", ", "_").replace(" ", "_")
        hit = collide(s, name, young, nu, rho, radius, speed)
        exact = hertz(young, nu, rho, radius, speed)
        keep(test, "DEs", hit, exact, name)
        ratio = hit.force / exact[0]
        if test.startswith("2") and abs(ratio - 1.0) >= abs(worst - 1.0):
            worst = ratio
    values["force on the plane over Hertz, worst alloy, DEs"] = worst

    meshes = [(6, 6, 2.0), (8, 8, 2.5)] + ([(12, 12, 2.5)] if s.fine else [])
    units = {mesh: balls.sphere(*mesh) for mesh in meshes}
    jobs = [("1, glass", mesh) for mesh in meshes] + [("1, limestone", meshes[1])]

    def meshed(job):
        test, mesh = job
        young, nu, rho, radius, speed = NORMAL[test]
        name = f"balls_{test[3:]}_{mesh[0]}"
        balls.write_pair(s.path(name + ".data"), radius, units[mesh], 2e-6 * radius, 0.35)
        shortest = radius * balls.shortest_edge(units[mesh])
        lam, mu = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
        dt = 0.4 * shortest / np.sqrt((lam + 2 * mu) / rho)
        steps = int(1.25 * hertz(*NORMAL[test])[2] / dt)
        s.lammps("in.balls", name, mesh=name + ".data", young=young, nu=nu, rho=rho, radius=radius, speed=speed, fs=4.0, dt=dt, steps=steps)
        s.path(name + ".data").unlink()
        return name, Hit(s.path(name + ".hit"), dt)

    for (test, mesh), (name, hit) in zip(jobs, s.all(meshed, jobs)):
        how = f"meshed, {len(units[mesh][1])} elements each"
        keep(test, how, hit, hertz(*NORMAL[test]), name)
        if mesh == meshes[-1] or test == "1, limestone":
            values[f"largest force, {test[3:]}, meshed"] = 1e-3 * hit.force
            if test == "1, glass":
                values["largest overlap, glass, meshed"] = 1e6 * hit.deep
                values["time of contact, glass, meshed"] = 1e6 * hit.time
    s.table("Head-on collisions:", rows)
    for test in ("glass", "limestone"):
        values[f"largest force, {test}, DEs"] = 1e-3 * curves[("1, " + test, "DEs")].force
    values["largest overlap, glass, DEs"] = 1e6 * curves[("1, glass", "DEs")].deep
    values["time of contact, glass, DEs"] = 1e6 * curves[("1, glass", "DEs")].time

    given = []
    for e in LEVELS:
        hit = collide(s, f"restitution_{e:g}", *OXIDE, restitution=e)
        given.append(-hit.rest[1][-1] / OXIDE[4])
        drift.append(hit.drift())
    found, hits = oblique(s)
    drift += [hit.drift() for hit in hits]
    s.table("Test 3, restitution (aluminium oxide, 3.9 m/s):", [["given"] + [f"{e:g}" for e in LEVELS], ["comes out"] + [f"{e:.4f}" for e in given]])
    s.table("Test 4, oblique (aluminium oxide, 3.9 m/s), angles from the normal; sliding: if it slides throughout:",
            [["angle (degrees)", "restitution along", "across", "sliding", "spin over that of sliding"]]
            + [[f"{a:g}", f"{n:.4f}", f"{t:.4f}", f"{exact:.4f}", f"{w:.3f}"] for a, n, t, w, exact, _ in found])
    sliding = found[found[:, 0] >= SLIDES]

    draw(s, curves, found)
    values["restitution, farthest from the given one"] = float(max(abs(a - e) for a, e in zip(given, LEVELS)))
    values["tangential restitution, farthest from sliding"] = float(np.abs(sliding[:, 2] - sliding[:, 4]).max())
    values["spin over that of sliding, farthest from 1"] = float(np.abs(sliding[:, 3] - 1.0).max())
    values["largest drift of the energy"] = float(max(drift))
    return values
