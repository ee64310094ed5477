"""Files that are written whole or not at all, and failures in one line: shared by mesh2data and layers2data.

Python's own modules only."""

import argparse
import math
import os
import re
import shutil
import signal
import stat
import sys
import tempfile

LARGEST_ID = 2**31 - 1  # of atoms and types, as LAMMPS is usually built


class Refused(Exception):
    """What is wrong with the input or the command, in one line."""


# --- numbers and names of the command line ---------------------------------------------------------


def real(text):
    """A finite number. Python itself also takes nan, inf, 1_000 and digits of other scripts."""
    value = float(text) if re.fullmatch(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", text, re.ASCII) else math.nan
    if not math.isfinite(value):
        raise ValueError(f"needs a finite number, not '{text}'")
    return value


def integer(text, low, high=LARGEST_ID):
    # not more than 10 digits: Python refuses very long ones in words of its own
    value = int(text) if re.fullmatch(r"\s*[-+]?\d{1,10}\s*", text, re.ASCII) else None
    if value is None or not low <= value <= high:
        raise ValueError(f"needs an integer from {low} to {high}, not '{text}'")
    return value


def printable(text, limit=200):
    """For one line of a terminal, and for comments and messages in scripts of LAMMPS: neither quotes nor
    $ nor & nor control characters."""
    text = re.sub(r"[^\w.,:;+=/@%()\[\]{}<>~* -]", "_", str(text), flags=re.ASCII)
    return text if len(text) <= limit else text[:limit] + " ..."


def script_word(text):
    """A file name as one word of a LAMMPS script."""
    text = str(text)
    if not re.search(r"[\s#\"'&$]", text):
        return text
    return f'"{text}"' if '"' not in text else f"'{text}'"


# --- output ----------------------------------------------------------------------------------------


def check_target(path, inputs=()):
    """Refuses a name that is not a new file or a regular one that may be replaced."""
    path = os.fspath(path)
    shown = printable(path)
    if re.search(r"[\x00-\x1f\x7f]", path):
        raise Refused(f"the output name '{shown}' has control characters (shown as _)")
    if not path or path.endswith("/") or os.path.isdir(path):
        raise Refused(f"the output '{shown}' is a folder: a file name is needed")
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise Refused(f"there is no folder '{printable(folder)}' to write to")
    try:
        mode = os.lstat(path).st_mode
    except FileNotFoundError:
        return
    if stat.S_ISLNK(mode):
        raise Refused(f"the output '{shown}' is a symbolic link, which is not replaced: name the file itself")
    if not stat.S_ISREG(mode):
        raise Refused(f"the output '{shown}' is no regular file (a device, pipe or socket), and is not replaced")
    if not os.access(path, os.W_OK):
        raise Refused(f"the output '{shown}' is write-protected")
    for source in inputs:
        if os.path.samefile(path, source):
            raise Refused(f"the output '{shown}' is what is read, {printable(source)}, and would be overwritten: "
                          "give it another name")


def same_target(a, b):
    """Whether two names, of files that may not exist yet, are one file."""
    if os.path.exists(a) and os.path.exists(b):
        return os.path.samefile(a, b)
    return (os.path.basename(a) == os.path.basename(b)
            and os.path.samefile(os.path.dirname(a) or ".", os.path.dirname(b) or "."))


def write_all(files, inputs=()):
    """Writes (path, iterable of lines) for all files, or changes none of them."""
    files = [(os.fspath(path), lines) for path, lines in files]
    for k, (path, _) in enumerate(files):
        check_target(path, inputs)
        for other, _ in files[:k]:
            if same_target(path, other):
                raise Refused(f"two outputs have one name, '{printable(path)}'")
    ready, leftover = [], []
    path = files[0][0]
    try:
        for path, lines in files:
            # beside the target: a rename within one file system is all or nothing
            handle, name = tempfile.mkstemp(dir=os.path.dirname(path) or ".", prefix=".defe-")
            leftover.append(name)
            with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
                file.writelines(line + "\n" for line in lines)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(name, stat.S_IMODE(os.stat(path).st_mode) if os.path.exists(path) else 0o666 & ~umask())
            ready.append((name, path))
        put_in_place(ready, inputs)
    except OSError as error:
        raise Refused(f"cannot write {printable(path)}: {error.strerror or error}; nothing was changed") from None
    finally:
        for name in leftover:
            if os.path.lexists(name):
                os.unlink(name)


def put_in_place(ready, inputs):
    """Renames the finished files; if one cannot be renamed, those before it are undone."""
    undo = []
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        for name, path in ready:
            check_target(path, inputs)  # it may have changed meanwhile
            if (name, path) != ready[-1]:
                undo.append((keep(path, name + ".old"), path))
            os.replace(name, path)
    except (OSError, Refused):
        for old, path in undo:
            if old:
                os.replace(old, path)
            else:
                os.unlink(path)
        raise
    finally:
        for old, _ in undo:
            if old and os.path.lexists(old):
                os.unlink(old)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def keep(path, name):
    """The file by a second name, or None if there is none."""
    if not os.path.exists(path):
        return None
    try:
        os.link(path, name)
    except OSError:  # a file system without links
        shutil.copy2(path, name)
    return name


def umask():
    old = os.umask(0)
    os.umask(old)
    return old


# --- programs --------------------------------------------------------------------------------------


class Parser(argparse.ArgumentParser):
    def error(self, message):
        print(f"{self.prog}: {plain(' '.join(message.split()))} (see {self.prog} --help)", file=sys.stderr)
        sys.exit(2)


def plain(text):
    """Names may hold line ends and what a terminal obeys."""
    return re.sub(r"[\x00-\x1f\x7f-\x9f]", "_", text)


def one_line(program, about, message):
    print(plain(f"{program}: {about + ': ' if about else ''}{' '.join(str(message).split())}"), file=sys.stderr)
    return 2


def run(program, about, work):
    """Calls work(), which writes the files and gives the lines to print; every failure is one line and status 2."""
    try:
        lines = work()
    except (Refused, OSError) as error:
        return one_line(program, about, error)
    except MemoryError:
        return one_line(program, about, "not enough memory")
    except KeyboardInterrupt:
        return one_line(program, about, "interrupted")
    try:
        print("\n".join(map(plain, lines)), flush=True)
    except BrokenPipeError:  # nobody reads on
        silence()
    except OSError as error:
        silence()
        return one_line(program, about, f"the files are written, but this cannot be printed: {error.strerror}")
    return 0


def silence():
    """What is left in the buffer would be tried again at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def start(main):
    """The program's process: any name can be printed, and a signal to stop removes the temporary files."""
    def stop(*_):
        raise KeyboardInterrupt

    for stream in sys.stdout, sys.stderr:
        if stream is not None:
            stream.reconfigure(errors="backslashreplace")
    signal.signal(signal.SIGTERM, stop)
    sys.exit(main(sys.argv[1:]))
