"""Reads what a run of an example wrote, and writes its results. Used by the analyse.py of all examples."""

import json
import re
import sys

import numpy as np


def read_log(path):
    """Loop time, ranks and steps over all pieces of the run, the thermo output by column, and the text."""
    text = path.read_text()
    loops = re.findall(r"^Loop time of (\S+) on (\d+) procs for (\d+) steps", text, re.M)
    if not loops:
        sys.exit(f"no finished run in {path}")
    thermo, columns = {}, []
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            columns = words
        elif columns and len(words) == len(columns) and words[0].isdigit():
            thermo[int(words[0])] = [float(w) for w in words]
        elif line.startswith("Loop time"):
            names, columns = columns, []
    table = np.array([thermo[s] for s in sorted(thermo)])
    return {
        "loop_seconds": round(sum(float(l[0]) for l in loops), 4),
        "ranks": int(loops[0][1]),
        "steps": sum(int(l[2]) for l in loops),
        "thermo": {name: table[:, k] for k, name in enumerate(names)},
        "text": text,
    }


def read_energies(path):
    """A file of fix ave/time with our titles, by column."""
    lines = path.read_text().splitlines()
    names = lines[1].lstrip("# ").split()
    table = np.array([[float(w) for w in line.split()] for line in lines[2:]], ndmin=2)
    return {name: table[:, k] for k, name in enumerate(names)}


def energy_rise(energies):
    """Largest rise of the total energy above an earlier value, in percent of the initial one."""
    total = energies["total"]
    return 100 * float(np.max(total - np.minimum.accumulate(total))) / total[0]


def totals(log, energies):
    """The end of every summary.json: energies and cost."""
    total = energies["total"]
    return {
        "energy_initial_J": float(total[0]),
        "energy_max_J": float(total.max()),
        "energy_final_J": float(total[-1]),
        "energy_rise_percent": round(energy_rise(energies), 5),
        "end_us": float(energies["time_us"][-1]),
        "loop_seconds": log["loop_seconds"],
        "ranks": log["ranks"],
        "steps": log["steps"],
    }


def write_json(path, data):
    path.write_text(json.dumps(data, indent=2, default=lambda x: x.item()) + "\n")  # numpy's numbers


def report(log_file, title, lines):
    """Prints the lines, the first of which starts with the title, and puts them at the end of the log."""
    text = "\n".join(["", *lines]) + "\n"
    print(text, end="")
    log_file.write_text(log_file.read_text().split("\n" + title)[0].rstrip() + "\n" + text)


def plotting():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def plot_energies(path, title, e, marks, limit=None, large_elements=False):
    """marks: times (us) or None. limit: a line for the total energy (%). large_elements: a logarithmic scale,
    on which joints can be seen beside the elements."""
    plt = plotting()
    t = e["time_us"]
    figure, axes = plt.subplots(2, 2, figsize=(11, 7), sharex=True, constrained_layout=True)
    (stored, dissipated), (kinetic, total) = axes
    for name, label in (("e_elements", "finite elements"), ("e_joints", "connective joints"), ("e_ties", "ties"),
                        ("e_cohesive", "cohesive joints"), ("e_contact", "contact")):
        stored.plot(t, 1e3 * e[name], label=label)
    stored.set(title="stored", ylabel="mJ")
    if large_elements:
        stored.set_yscale("symlog", linthresh=1)
        stored.set_ylim(0, None)
    for name, label in (("fracture", "fracture, $G_f$"), ("released", "released at breaking"), ("damping", "damping"),
                        ("friction", "friction"), ("viscous", "interlayer, viscous"),
                        ("conv_strain", "lost at conversion: strain"), ("conv_kinetic", "lost at conversion: kinetic")):
        dissipated.plot(t, 1e3 * e[name], label=label, ls=":" if "conv" in name else "-")
    dissipated.set(title="dissipated, and lost at conversions", ylabel="mJ")
    kinetic.plot(t, 1e3 * (e["e_kinetic"] - e["e_kinetic"][0]), color="k", label="kinetic")
    kinetic.plot(t, -1e3 * sum(e[n] for n in ("e_elements", "e_joints", "e_ties", "e_cohesive", "e_contact")),
                 ls="--", label="$-$ stored")
    kinetic.set(title=f"change of the kinetic energy (initially {e['e_kinetic'][0]:.4f} J)", ylabel="mJ", xlabel="us")
    total.plot(t, 100 * (e["total"] / e["total"][0] - 1), color="k", label="kinetic + stored + dissipated $-$ external work")
    total.plot(t, 100 * (e["balance"] / e["total"][0] - 1), ls="--", label="with what conversions lose")
    if limit is not None:
        total.axhline(limit, color="#d33", lw=0.8)
    total.axhline(0, color="0.6", lw=0.8)
    total.set(title="total energy, change in % of the initial", ylabel="%", xlabel="us")
    for axis in axes.flat:
        for mark in marks:
            if mark is not None:
                axis.axvline(mark, color="#d33", lw=0.8, ls=(0, (4, 3)), zorder=0)
        axis.set_xlim(0, t[-1])
        axis.legend(fontsize=8)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path, dpi=100)
    plt.close(figure)
