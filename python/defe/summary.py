"""What is left of a run: summary.json, a table at the end of the log, one closing line."""

import json
import os
import sys

from . import plots
from .errors import InputError, at, text_of
from .events import read_events
from .logs import read_log
from .tables import energy_rise


def totals(log, energies):
    """{name: number}, the end of every summary.json: energies (J, and the largest rise in %) and cost."""
    total = energies["total"]
    return {
        "energy_initial_J": float(total[0]),
        "energy_max_J": float(total.max()),
        "energy_final_J": float(total[-1]),
        "energy_rise_percent": round(energy_rise(energies), 5),
        "end_us": 1e6 * float(energies.seconds()[-1]) if "time_us" not in energies else float(energies["time_us"][-1]),
        "loop_seconds": round(log.seconds, 4),
        "ranks": log.ranks,
        "steps": log.steps,
    }


def read_summary(path):
    """{name: value} of a summary.json. Raises InputError: no such file, a damaged one."""
    try:
        found = json.loads(text_of(path))
    except json.JSONDecodeError as error:
        raise InputError(at(path, error.lineno) + "the file is damaged: run the example again") from None
    if not isinstance(found, dict):
        raise InputError(at(path) + "this is no summary of a run")
    return found


def write_json(path, data):
    """numpy's numbers are written as Python's."""
    path.write_text(json.dumps(data, indent=2, default=lambda x: x.item()) + "\n")


def report(log_file, title, lines):
    """Prints the lines, the first of which starts with the title, and puts them at the end of the log."""
    text = "\n".join(["", *lines]) + "\n"
    print(text, end="")
    log_file.write_text(log_file.read_text().split("\n" + title)[0].rstrip() + "\n" + text)


MADE = ("summary.json", "compare.json", "arch.png", "energies.png", "timeline.png", "force.png", "hail.png",
        "rod.png", "cells.png", "strength.png", "meshes.png", "crack.png")


def closing_line(folder, summary):
    """Prints one line: how far the crack is, the run time, and the files in the folder that an example makes for its user."""
    there = [name for name in MADE if (folder / name).exists()]
    broken = summary.get("joints_broken", summary.get("joints_contact"))
    crack = [f"{summary['elements_converted']} elements converted"] if "elements_converted" in summary else []
    crack += [f"{broken} joints broken"] if broken is not None else []
    print(f"\n{', '.join(crack)}{'; ' if crack else ''}loop time {summary['loop_seconds']:.2f} s on {summary['ranks']} rank(s); "
          f"{', '.join(there)} in {os.path.relpath(folder)}")


def finish(folder, title):
    """What a run that wrote events.txt and log.lammps into the folder leaves there: timeline.png (with matplotlib), summary.json,
    and the closing line. Returns the summary."""
    events, log = read_events(folder / "events.txt"), read_log(folder / "log.lammps")
    if plots.available():
        plots.timeline(folder / "timeline.png", title, events)
    summary = {"first_damage_s": events.first("cohesive"), "elements_converted": len(events.of("convert")),
               "joints_broken": len(events.of("broken")), "loop_seconds": log.seconds, "ranks": log.ranks}
    write_json(folder / "summary.json", summary)
    closing_line(folder, summary)
    return summary


def main(function, *arguments):
    """Calls it; an InputError, or an error of LAMMPS in this process, ends the program with one line."""
    try:
        return function(*arguments)
    except Exception as error:
        # LAMMPS' module raises Exception itself
        if not isinstance(error, InputError) and not (type(error) is Exception and str(error).startswith("ERROR")):
            raise
        sys.exit(f"{os.path.basename(sys.argv[0])}: {' '.join(str(error).split())}")
