"""Tables of numbers over the steps of a run: files of fix ave/time, and what they say of the energies."""

import re

import numpy as np

from .errors import InputError, at, needed, text_of

ENTRIES = ("elements converted des connective cohesive contact ties s1max e_elements e_joints e_ties e_cohesive e_contact "
           "e_kinetic fracture released damping friction conv_strain conv_kinetic external total balance t_conversion "
           "t_damage viscous softening_ties broken_ties let_through e_let_through").split()
"""Names of the 30 entries of fix defe's global vector, in its order: table["total"] is f_fe[22]."""

STORED = ("e_elements", "e_joints", "e_ties", "e_cohesive", "e_contact")


class Table:
    """Columns by name, each an array (n,) over the rows: table["total"], or table.total."""

    def __init__(self, columns, path="table"):
        self.columns, self.path = dict(columns), path

    def __getitem__(self, name):
        if name not in self.columns:
            raise InputError(at(self.path) + f"there is no column '{name}'; there are: {', '.join(self.columns)}")
        return self.columns[name]

    def __getattr__(self, name):
        columns = vars(self).get("columns", {})
        if name in columns:
            return columns[name]
        raise AttributeError(f"no column '{name}'; there are: {', '.join(columns)}")

    def __contains__(self, name):
        return name in self.columns

    def __iter__(self):
        return iter(self.columns)

    def __len__(self):
        """Number of rows."""
        return len(next(iter(self.columns.values()), ()))

    def last(self):
        """{name: value} of the last row."""
        return {name: column[-1] for name, column in self.columns.items()}

    def seconds(self):
        """Times (n,) in s: the column time_us (of the examples), else Time or time."""
        if "time_us" in self:
            return 1e-6 * self["time_us"]
        for name in ("Time", "time"):
            if name in self:
                return self[name]
        raise InputError(at(self.path) + "there is no column of times (Time, time or time_us): add the keyword time to it")

    def to_pandas(self):
        """As a DataFrame; needs pandas."""
        return needed("pandas", "python3-pandas", "to_pandas()").DataFrame(self.columns)


def name_of(word, fix="fe"):
    """The column of a word in the title of a file or of a thermo table: an entry of the vector of the fix by its name,
    a variable without v_."""
    entry = re.fullmatch(rf"f_{re.escape(fix)}\[(\d+)\]", word)
    if entry and 1 <= int(entry[1]) <= len(ENTRIES):
        return ENTRIES[int(entry[1]) - 1]
    if word in ("TimeStep", "Step"):
        return "step"
    return word[2:] if word.startswith("v_") else word


def read_table(path, fix="fe", running=False):
    """A file of fix ave/time (mode scalar) as a Table; energies of fix defe under the names in ENTRIES.

    Columns are named by the last line of titles before the numbers; fix: the ID of fix defe. Where a restarted run has
    written a step again, the later row counts. running: a run still writes it, and an unfinished last line is left out.

    Raises InputError: no such file, no titles, a line of another length, a word that is no number, no rows."""
    title, rows = None, []
    text = text_of(path)
    lines = text.splitlines()
    if running and not text.endswith("\n"):
        lines = lines[:-1]
    for number, line in enumerate(lines, 1):
        if line.startswith("#"):
            title = line
            continue
        words = line.split()
        if title is None:
            raise InputError(at(path, number) + "no line of titles (# TimeStep ...) before it: is this a file of fix ave/time?")
        names = title.lstrip("# ").split()
        if len(words) != len(names):
            raise InputError(at(path, number) + f"{len(words)} words, but the titles name {len(names)} columns: it is cut off or "
                             "damaged; run again, or delete the line")
        try:
            rows.append([float(word) for word in words])
        except ValueError:
            bad = next(word for word in words if not is_number(word))
            raise InputError(at(path, number) + f"'{bad}' is not a number: the line is damaged; run again, or delete it") from None
    if not rows:
        raise InputError(at(path) + "there are no rows: has the run reached the first step that is written?")
    names = [name_of(word, fix) for word in names]
    if len({len(row) for row in rows}) > 1:
        raise InputError(at(path) + "its columns change on the way: two runs with different columns have written it")
    table = by_step(np.array(rows))
    return Table({name: table[:, k] for k, name in enumerate(names)}, path)


def by_step(rows):
    """The rows (n, k) in the order of their first column, the step; of those of one step the last one."""
    _, last = np.unique(rows[::-1, 0], return_index=True)
    return rows[len(rows) - 1 - last]


def is_number(word):
    try:
        float(word)
        return True
    except ValueError:
        return False


# ---- energies -------------------------------------------------------------------------------------


def largest_rise(values):
    """Largest rise of values (n,) above an earlier one, in their units; 0 if they only fall."""
    values = np.asarray(values, float)
    return float((values - np.minimum.accumulate(values)).max())


def energy_rise(energies):
    """Largest rise of the total energy above an earlier value, in percent of the initial one: for bodies that hit each other."""
    if not energies["total"][0] > 0:
        raise InputError("the total energy is not above 0 at first: compare largest_rise() with energy_scale() instead")
    return 100 * largest_rise(energies["total"]) / float(energies["total"][0])


def energy_scale(energies):
    """The largest energy (J) that was put in or was there: what rises are compared with where bodies are loaded."""
    e = energies
    there = e["e_kinetic"] + e["e_elements"] + e["e_joints"]
    return float(max(np.abs(e["external"]).max(), np.abs(e["total"]).max(), there.max()))


def balance_drift(energies):
    """Largest deviation of the balance, which should be constant, from its first value (J)."""
    return float(np.abs(energies["balance"] - energies["balance"][0]).max())


def stored(energies):
    """What elements, joints, ties and contacts store (n,), J."""
    return sum(energies[name] for name in STORED)


def force_from_velocity(time, velocity, mass):
    """Mean force between two rows on a body that nothing else moves: (times (n-1,) in s at their middles, force (n-1,) in N),
    from times (n,) in s, velocities (n,) in m/s and the mass in kg."""
    time, velocity = np.asarray(time, float), np.asarray(velocity, float)
    if len(time) < 2:
        raise InputError("a force needs velocities at two times: the run is too short, or writes too seldom")
    return 0.5 * (time[1:] + time[:-1]), mass * np.diff(velocity) / np.diff(time)
