"""See README.md."""

import dataclasses
import sys
from pathlib import Path

import numpy as np
from manual import Accept, plt

sys.path.insert(0, str(Path(__file__).resolve().parent))
import balls  # noqa: E402

TITLE = "Chung and Ooi: collisions of two spheres, and of one with a plane"
CHUNG = "Chung and Ooi, Granular Matter 13 (2011) 643"
CURVES = CHUNG + ", curves read off"
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

# tests 5 to 8: young, nu, rho, radius; speed along the line of centres, friction, restitution
STEEL, POLYETHYLENE = (2.08e11, 0.3, 7850.0, 1e-5), (1e9, 0.4, 1400.0, 1e-5)
ALLOY, NYLON, COPPER = (7e10, 0.33, 2700.0, 0.1), (2.5e9, 0.4, 1000.0, 0.1), (1.2e11, 0.35, 8900.0, 0.1)
LARGE = (7e13, 0.33, 2.7e6, 0.5)    # of test 8: the alloy a thousand times as stiff and heavy
PLANE = 100.0    # a sphere as many times as large, and 1e4 times as stiff, is as good as a rigid plane: its line of centres does not turn
OBLIQUE = (5.0, 0.3, 1.0)
SPINNING = (0.2, 0.4, 0.5)
SPEEDS_ACROSS = (0.34, 0.67, 1.0, 1.34, 1.67, 2.0, 2.34, 3.0, 3.34, 4.0, 5.0, 6.0, 10.0, 13.0)    # over friction times speed along
SURFACE_ANGLES = (5.0, 15.0, 25.0, 35.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0, 80.0)    # of the surface at the point of contact
SLIDES_5, SLIDES_6 = 5.9, 68.0    # from here on tests 5 and 6 slide throughout: 4 chi - 1 of Maw et al. (Wear 38 (1976) 101); a rigid sphere

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
    Accept("test 5: impulse across over that of sliding, farthest from 1", SLIDING, target=0.0, tolerance=0.01, digits=2),
    Accept("test 5: spin given over that of sliding, farthest from 1", SLIDING, target=0.0, tolerance=0.01, digits=2),
    Accept("tests 6 and 8: impulse across over that of sliding, farthest from 1", SLIDING, target=0.0, tolerance=0.01, digits=2, known=True),
    Accept("tests 6 and 8: restitution along, farthest from the given one", "exact", target=0.0, tolerance=0.005, digits=2),
    Accept("test 7: largest change of the spin, and speed across over that along", "exact: the surfaces do not slip", target=0.0, tolerance=1e-6, digits=2),
    Accept("test 8 less test 6, tangent of the angle of recoil, largest", "exact: the ball of test 8 is as good as a plane", target=0.0,
           tolerance=0.02, digits=2),
    Accept("test 5, steel: tangents of recoil over friction, farthest from finite elements", CURVES, high=0.3, certain=False, digits=2),
    Accept("test 6, alloy: tangents of recoil, farthest from the published curve", CURVES, high=0.15, certain=False, digits=2),
    Accept("largest drift of the energy", "exact", high=0.1, unit="%", digits=2),
]

# Published curves, read off by others: tests of KratosMultiphysics (DEMApplication, basic_benchmarks/paper_data). Tangents of the angles of incidence
# and recoil of the point of contact; of test 5 both over the friction.
PUBLISHED = {
    "5, steel": ((0.33, -0.28), (0.67, -0.49), (1.01, -0.75), (1.34, -1.00), (1.66, -1.27), (2.00, -1.53), (2.35, -1.81), (2.99, -2.44), (3.34, -2.69),
                 (4.01, -2.79), (5.00, -2.00), (6.00, -1.01), (9.99, 3.01), (12.96, 6.01)),
    "5, finite elements": ((0.27, -0.03), (0.59, -0.03), (0.88, -0.08), (1.19, -0.21), (1.55, -0.37), (1.92, -0.63), (2.31, -0.95), (2.79, -1.25),
                           (3.32, -1.52), (3.97, -1.72), (4.76, -1.71), (5.76, -1.20), (7.12, 0.13), (9.12, 2.15), (12.36, 5.43)),
    "6, alloy": ((0.085, 0.02), (0.173, 0.06), (0.268, 0.09), (0.363, 0.10), (0.465, 0.09), (0.574, 0.09), (0.696, 0.05), (0.838, -0.03), (1.00, -0.15),
                 (1.20, -0.27), (1.43, -0.35), (1.73, -0.38), (2.15, 0.05), (2.75, 1.27), (3.73, 3.24), (5.68, 7.13)),
    "6, nylon": ((0.085, 0.02), (0.180, 0.05), (0.261, 0.05), (0.363, 0.09), (0.465, 0.06), (0.574, 0.04), (0.696, -0.03), (0.838, -0.12), (0.99, -0.23),
                 (1.19, -0.32), (1.42, -0.38), (1.73, -0.38), (2.14, 0.05), (2.75, 1.27), (3.73, 3.25), (5.67, 7.13)),
}


def stiffness(one, two):
    """k of Hertz' law, force = k overlap^(3/2). one, two: young, nu, rho, radius."""
    soft = sum((1.0 - nu * nu) / young for young, nu, _, _ in (one, two))
    return 4.0 / 3.0 / soft * np.sqrt(one[3] * two[3] / (one[3] + two[3]))


def hertz_of(one, two, apart):
    """Two spheres that meet with this relative speed: largest force, overlap, time of contact."""
    masses = [rho * 4.0 / 3.0 * np.pi * radius**3 for _, _, rho, radius in (one, two)]
    k = stiffness(one, two)
    overlap = (2.5 * 0.5 * masses[0] * masses[1] / sum(masses) * apart**2 / k) ** 0.4
    return k * overlap**1.5, overlap, 2.943275 * overlap / apart


def contact_time(one, two, apart):
    return hertz_of(one, two, apart)[2]


def hertz(young, nu, rho, radius, speed):
    """Of two equal spheres that meet with this speed each, or of one and a rigid plane: largest force, overlap (of the two), time."""
    return hertz_of((young, nu, rho, radius), (young, nu, rho, radius), 2.0 * speed)


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


def collide(s, name, one, vn, vt=0.0, spin=0.0, restitution=1.0, friction=0.0, other=None):
    """Two DEs. one: young, nu, rho, radius; spin about the axis that is normal to both speeds (rad/s).
    other: None for the image of the first by a half turn, which makes a rigid plane of the middle between them; "mirrored" for its mirror image,
    with the opposite spin; else young, nu, rho, radius of one at rest."""
    apart = (2.0 if not isinstance(other, tuple) else 1.0) * vn
    two = other if isinstance(other, tuple) else one
    time = contact_time(one, two, apart)
    part = 1000 if restitution > 0.9 else 4000    # damping goes with velocities of half a step before
    dt = time / part
    moving = not isinstance(other, tuple)
    across = -vt if moving and other != "mirrored" else vt if moving else 0.0
    given = {f"{what}{k}": value for k, of in ((1, one), (2, two)) for what, value in zip(("young", "nu", "rho", "radius"), of)}
    for k in (1, 2):
        given[f"rho{k}"] *= np.pi / 6.0
    s.lammps("in.des", name, **given, restitution=restitution, friction=friction, vn1=vn, vt1=vt, spin1=spin, vn2=-vn if moving else 0.0, vt2=across,
             spin2=(-spin if other == "mirrored" else spin) if moving else 0.0, back1=0.5 * time * vt, back2=0.5 * time * across, dt=dt,
             steps=int((1.3 if restitution > 0.9 else 2.5) * part))
    return Hit(s.path(name + ".hit"), dt)


def oblique(s):
    """Test 4: angle, restitution along and across, spin over that of sliding."""
    *what, speed = OXIDE
    radius, found, hits = what[3], [], []
    for angle in ANGLES:
        vn, vt = speed * np.cos(np.radians(angle)), speed * np.sin(np.radians(angle))
        hit = collide(s, f"oblique_{angle:g}", tuple(what), vn, vt, 0.0, RESTITUTION, FRICTION)
        vx, vy, spin, _ = (r[-1] for r in hit.rest)
        full = FRICTION * (1.0 + RESTITUTION) * vn
        found.append((angle, -vy / vn, vx / vt, abs(spin) / (2.5 * full / radius), 1.0 - full / vt, np.degrees(np.arctan(abs(spin) * radius / vn))))
        hits.append(hit)
    return np.array(found), hits


@dataclasses.dataclass
class Recoil:
    """What a collision makes of the speed of the point of contact, of the first sphere. Tangents: over the speed along."""

    incident: float
    recoil: float
    impulse: float    # across, over friction times that along
    spin: float    # given, over what that impulse gives if it slides throughout
    restitution: float    # along


def recoil(s, name, one, vn, vt=0.0, spin=0.0, restitution=1.0, friction=0.0, other=None):
    hit = collide(s, name, one, vn, vt, spin, restitution, friction, other)
    radius = one[3]
    vx, vy, turning, _ = (r[-1] for r in hit.rest)
    along = vn - vy    # impulse over mass
    given = 2.5 * friction * along / radius
    return Recoil((vt - spin * radius) / vn, (vx - turning * radius) / -vy, abs(vx - vt) / (friction * along), abs(turning - spin) / given,
                  -vy / vn), hit


def spinning(s):
    """Tests 5 to 8: {test: list of Recoil}, changes of test 7, all collisions."""
    found, hits = {}, []

    def plane(young, nu, rho, radius):
        return 1e4 * young, nu, rho, PLANE * radius

    def keep(test, *arguments, **more):
        r, hit = recoil(s, f"{test.replace(', ', '_')}_{len(hits)}", *arguments, **more)
        found.setdefault(test, []).append(r)
        hits.append(hit)

    vn, friction, restitution = OBLIQUE
    for test, what in (("5, steel", STEEL), ("5, polyethylene", POLYETHYLENE)):
        for across in SPEEDS_ACROSS:
            keep(test, what, vn, across * friction * vn, 0.0, restitution, friction, plane(*what))
    vn, friction, restitution = SPINNING
    for test, what, other in (("6, alloy", ALLOY, plane(*ALLOY)), ("6, nylon", NYLON, plane(*NYLON)), ("8, alloy", ALLOY, LARGE)):
        for angle in SURFACE_ANGLES:
            # the surface slips towards +x if the sphere turns towards -z
            keep(test, what, vn, 0.0, -np.tan(np.radians(angle)) * vn / what[3], restitution, friction, other)
    change = 0.0
    for name, what in (("alloy", ALLOY), ("copper", COPPER)):
        for spin in (0.175, 2.0, 22.9):
            hit = collide(s, f"7_{name}_{spin:g}", what, vn, 0.0, spin, restitution, friction, "mirrored")
            vx, _, turning, _ = (r[-1] for r in hit.rest)
            change = max(change, abs(turning / spin - 1.0), abs(vx) / vn)
            hits.append(hit)
    return found, change, hits


def slides(test, r):
    """Whether it does so throughout."""
    return r.incident / OBLIQUE[1] > SLIDES_5 if test.startswith("5") else r.incident > np.tan(np.radians(SLIDES_6))


def off_curve(found, curve, scale=1.0):
    """Largest distance of the tangents of recoil from a published curve, over `scale`, at the angles of ours that it covers."""
    x, y = np.array(PUBLISHED[curve]).T
    ours = [(r.incident / scale, r.recoil / scale) for r in found if x[0] <= r.incident / scale <= x[-1]]
    return max(abs(b - float(np.interp(a, x, y))) for a, b in ours)


def draw_spinning(s, found):
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.8))
    for ax, number, scale, own in ((axes[0], "5", OBLIQUE[1], "5, finite elements"), (axes[1], "6", 1.0, None)):
        for k, test in enumerate(t for t in found if t[0] == number or (number, t[0]) == ("6", "8")):
            ax.plot([r.incident / scale for r in found[test]], [r.recoil / scale for r in found[test]], "o-", ms=3.5, lw=0.8, color=f"C{k}",
                    label="test " + test)
            if test in PUBLISHED:
                ax.plot(*np.array(PUBLISHED[test]).T, "x", ms=5, color=f"C{k}", label=f"published, {test[3:]}")
        if own:
            ax.plot(*np.array(PUBLISHED[own]).T, "k+", ms=5, label="published, finite elements")
    x = np.linspace(SLIDES_5, 13.0, 10)
    axes[0].plot(x, x - 7.0, "k:", label="slides throughout")
    x = np.linspace(2.1, 5.8, 10)
    axes[1].plot(x, (x - 3.5 * SPINNING[1] * (1.0 + SPINNING[2])) / SPINNING[2], "k:", label="slides throughout")
    axes[0].set(xlabel="tangent of the angle of incidence over friction", ylabel="tangent of recoil over friction", title="test 5")
    axes[1].set(xlabel="tangent of the angle of incidence", ylabel="tangent of the angle of recoil", title="tests 6 and 8", ylim=(-1.1, 3.0), xlim=(0, 4))
    for ax in axes:
        ax.legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "recoil", "Recoil of the point of contact: oblique impacts on a plane (test 5), spinning spheres on a plane (6) and on a large sphere (8).")


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
        hit = collide(s, name, (young, nu, rho, radius), speed)
        exact = hertz(young, nu, rho, radius, speed)
        keep(test, "DEs", hit, exact, name)
        ratio = hit.force / exact[0]
        if test.startswith("2") and abs(ratio - 1.0) >= abs(worst - 1.0):
            worst = ratio
    values["force on the plane over Hertz, worst alloy, DEs"] = worst

    meshes = [(6, 6, 2.0)] + ([] if s.quick else [(8, 8, 2.5)]) + ([(12, 12, 2.5)] if s.fine else [])
    units = {mesh: balls.sphere(*mesh) for mesh in meshes}
    jobs = [("1, glass", mesh) for mesh in meshes] + [("1, limestone", meshes[:2][-1])]

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
        hit = collide(s, f"restitution_{e:g}", OXIDE[:4], OXIDE[4], restitution=e)
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

    spun, change, hits = spinning(s)
    drift += [hit.drift() for hit in hits]
    for test, scale, what in (("5", OBLIQUE[1], "over friction, oblique on a plane"), ("6", 1.0, "spinning sphere on a plane"),
                              ("8", 1.0, "spinning sphere on a large one")):
        tests = [t for t in spun if t[0] == test]
        s.table(f"Test {test}, {what}: tangents of the angles of incidence and recoil of the point of contact:",
                [["incidence"] + [f"{r.incident / scale:.2f}" for r in spun[tests[0]]]]
                + [[t[3:]] + [f"{r.recoil / scale:.3f}" for r in spun[t]] for t in tests])
    draw_spinning(s, spun)
    slid = {number: [r for test, all_of in spun.items() if test[0] == number for r in all_of if slides(test, r)] for number in "568"}
    values["test 5: impulse across over that of sliding, farthest from 1"] = max(abs(r.impulse - 1.0) for r in slid["5"])
    values["test 5: spin given over that of sliding, farthest from 1"] = max(abs(r.spin - 1.0) for r in slid["5"])
    values["tests 6 and 8: impulse across over that of sliding, farthest from 1"] = max(abs(r.impulse - 1.0) for r in slid["6"] + slid["8"])
    values["tests 6 and 8: restitution along, farthest from the given one"] = max(
        abs(r.restitution - SPINNING[2]) for test, all_of in spun.items() if test[0] in "68" for r in all_of)
    values["test 7: largest change of the spin, and speed across over that along"] = change
    values["test 8 less test 6, tangent of the angle of recoil, largest"] = max(
        abs(a.recoil - b.recoil) for a, b in zip(spun["8, alloy"], spun["6, alloy"]))
    values["test 5, steel: tangents of recoil over friction, farthest from finite elements"] = off_curve(
        spun["5, steel"], "5, finite elements", OBLIQUE[1])
    values["test 6, alloy: tangents of recoil, farthest from the published curve"] = off_curve(spun["6, alloy"], "6, alloy")
    values["restitution, farthest from the given one"] = float(max(abs(a - e) for a, e in zip(given, LEVELS)))
    values["tangential restitution, farthest from sliding"] = float(np.abs(sliding[:, 2] - sliding[:, 4]).max())
    values["spin over that of sliding, farthest from 1"] = float(np.abs(sliding[:, 3] - 1.0).max())
    values["largest drift of the energy"] = float(max(drift))
    return values
