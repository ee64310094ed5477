"""Reads, measures and plots runs of DEFE: event files, energies, logs, dumps, meshes. See README.md beside this folder.

    import defe
    events = defe.read_events("events.txt")
    events.first("broken")                     # s
    energies = defe.read_table("energies.txt")
    defe.energy_rise(energies)                 # percent
    defe.plots.energies("energies.png", "my beam", energies)

Needs numpy; plots need matplotlib. Everything is in SI units, unless a name ends with another one (time_us). What is wrong
with a file raises defe.InputError, a line that names file, line and remedy.
"""

from . import cracks, plots, summary
from .dumps import Fragments, Frame, fragments, read_dump
from .errors import InputError
from .events import KINDS, Events, element_of, read_events
from .host import entries, plugin_path, start
from .logs import Log, Run, read_log
from .mesh import Mesh, block, read_mesh, write_mesh
from .summary import read_summary
from .tables import (ENTRIES, STORED, Table, balance_drift, energy_rise, energy_scale, force_from_velocity, largest_rise,
                     read_table, stored)
