"""The one exception of this package."""

import importlib
from pathlib import Path


class InputError(ValueError):
    """A file that is missing or damaged, or a value that cannot be used: one line that names file, line and remedy."""


def needed(module, package, what):
    """The module; where it is missing, an InputError that says what needs it and which package of Debian has it."""
    try:
        found = importlib.import_module(module)
    except ImportError:
        found = None
    if getattr(found, "__file__", None) is None:    # or only folders are left of it: Python takes these for a package, too
        raise InputError(f"{what} needs {module.split('.')[0]}: install {package}")
    return found


def at(path, line=None):
    """'FILE: ' or 'FILE, line N: ', the begin of a message."""
    return f"{path}, line {line}: " if line else f"{path}: "


def text_of(path):
    """The text of a file, or an InputError that says why it cannot be read."""
    try:
        return Path(path).read_text()
    except FileNotFoundError:
        raise InputError(at(path) + "there is no such file: has the run been made that writes it, and in this folder?") from None
    except IsADirectoryError:
        raise InputError(at(path) + "is a folder: name a file in it") from None
    except UnicodeDecodeError:
        raise InputError(at(path) + "is not a text file: is it packed, or written in binary?") from None
    except OSError as error:
        raise InputError(at(path) + f"cannot be read ({error.strerror}): look at its rights") from None
