"""See README.md."""

import numpy as np
from manual import Accept, plt
from plates import Mesh, stable_step, turned

TITLE = "Fragments of a bar that is drawn apart everywhere at once"
ZHOU = "Zhou, Molinari, Ramesh, Appl. Phys. Lett. 88 (2006) 261918"
E, NU, RHO, GF, SIGMA_T, LENGTH = 275e9, 0.0, 2750.0, 100.0, 300e6, 0.05
RATES = (1e3, 1e4, 1e5)


def formula(rate):
    """Number of fragments: LENGTH over s0 4.5/(1 + 4.5 (rate/rate0)^(2/3))."""
    s0 = E * GF / SIGMA_T**2
    rate0 = np.sqrt(E / RHO) * SIGMA_T**3 / (E**2 * GF)
    return LENGTH / (s0 * 4.5 / (1.0 + 4.5 * (rate / rate0) ** (2.0 / 3.0)))


ACCEPTANCE = [Accept(f"fragments at {rate:.0e} per s", ZHOU, target=round(formula(rate)), tolerance=round(0.25 * formula(rate)),
                     certain=False) for rate in RATES]
ACCEPTANCE.append(Accept("largest rise of the total energy", "exact", high=0.1, unit="%"))


def run(s):
    sizes = [0.2e-3, 0.1e-3] if s.quick else [0.2e-3, 0.1e-3, 0.05e-3]
    if s.fine:
        sizes.append(0.025e-3)
    jobs = [(h, rate, "no") for h in sizes for rate in RATES] + [(sizes[1], 1e4, "all")]

    def one(job):
        h, rate, start = job
        name = f"{h * 1e6:.0f}um_{rate:.0e}_{start}"
        mesh = Mesh([h, h, h], turned(0.0), lambda c: (np.abs(c[:, 0]) < LENGTH / 2) & (np.abs(c[:, 1:]) < h / 2).all(axis=1),
                    np.array([LENGTH / 2 + h, h, h]), shift=(0.5, 0.0, 0.0))
        ends = np.abs(mesh.centre[:, 0]) > LENGTH / 2 - 2 * h
        mesh.write(s.path(name + ".data"), 3, np.where(ends, "edge", "body"), ends, margin=6.0 * h)
        dt = 0.5 * stable_step(E, NU, RHO, h)    # thousands of softening joints that rattle: the total would rise by 0.2 %
        # until the strength is reached, and twenty times as long as a fragment of the formula takes to be unloaded, and to open
        end = SIGMA_T / (E * rate) + 20.0 * LENGTH / formula(rate) / 1e4 + 4.0 * 2.0 * GF / SIGMA_T / (rate * LENGTH / formula(rate))
        steps = int(end / dt)
        s.lammps("in.bar", name, mesh=name + ".data", rate=rate, young=E, nu=NU, rho=RHO, sigma=SIGMA_T, gf=GF, start=start, dt=dt,
                 steps=steps, every=max(1, steps // 60), skin=0.15 * h, **mesh.box(6.0 * h))
        s.path(name + ".data").unlink()
        pieces = np.loadtxt(s.path(name + ".pieces"))
        return name, dt, pieces

    found = dict(zip(jobs, s.all(one, jobs)))
    rows = [["elements (mm)", "rate (1/s)", "", "fragments", "formula", "dissipated over G_f A per cut", "processor time (s)", "energy rises (%)"]]
    for (h, rate, start), (name, dt, pieces) in found.items():
        e = s.energies(name)
        n = int(pieces[-1, 1])
        cut = (e.fracture[-1] + e.released[-1]) / (GF * h * h * max(n - 1, 1))
        rows.append([f"{h * 1e3:g}", f"{rate:.0e}", "DEs" if start == "all" else "adaptive", n, f"{formula(rate):.0f}", f"{cut:.2f}",
                     f"{s.loops[name]:.1f}", f"{100 * e.rise():.3f}"])
    s.table("All runs:", rows)

    figure, ax = plt.subplots(figsize=(6, 4))
    r = np.logspace(2.5, 5.5, 50)
    ax.loglog(r, formula(r), color="k", lw=0.8, label="formula of Zhou, Molinari and Ramesh")
    for h in sizes:
        ax.loglog(RATES, [found[(h, rate, "no")][2][-1, 1] for rate in RATES], "o-", ms=4, lw=0.6, label=f"elements of {h * 1e3:g} mm")
    ax.set(xlabel="rate (1/s)", ylabel="fragments of 50 mm")
    ax.legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "fragments", "Number of fragments against the rate of stretching.")
    best = sizes[-1]
    for rate in RATES[1:2]:
        name, dt, _ = found[(best, rate, "no")]
        s.plot_energies(name, dt, f"{best * 1e3:g} mm, {rate:.0e} per s")
    values = {f"fragments at {rate:.0e} per s": float(found[(best, rate, "no")][2][-1, 1]) for rate in RATES}
    values["largest rise of the total energy"] = 100 * max(s.energies(f[0]).rise() for f in found.values())
    return values
