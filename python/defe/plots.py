"""Plots of runs; needs matplotlib, and PIL for sheet(). Times are in us and energies in mJ on all axes."""

import importlib
import importlib.util
import string

import numpy as np

from . import cracks as crack_measures
from .errors import InputError, needed
from .tables import STORED, energy_scale, stored

RED = "#d33"


def available():
    """Whether matplotlib is there."""
    return importlib.util.find_spec("matplotlib") is not None


def plotting():
    """matplotlib.pyplot, drawing into files."""
    needed("matplotlib", "python3-matplotlib", "plotting").use("Agg")
    return importlib.import_module("matplotlib.pyplot")


def marks(axis, times):
    """Dashed lines at times (us); None is left out."""
    for time in times:
        if time is not None:
            axis.axvline(time, color=RED, lw=0.8, ls=(0, (4, 3)), zorder=0)


def energies(path, title, e, times=(), limit=None, large_elements=False):
    """Four plots of the energies of a run, a Table with all entries of fix defe: stored, dissipated, kinetic, total.

    times: marked (us). limit: a line for the total energy (%). large_elements: a logarithmic scale, on which joints can be
    seen beside the elements."""
    plt = plotting()
    t = 1e6 * e.seconds()
    figure, axes = plt.subplots(2, 2, figsize=(11, 7), sharex=True, constrained_layout=True)
    (kept, dissipated), (kinetic, total) = axes
    for name, label in zip(STORED, ("finite elements", "connective joints", "ties", "cohesive joints", "contact")):
        kept.plot(t, 1e3 * e[name], label=label)
    kept.set(title="stored", ylabel="mJ")
    if large_elements:
        kept.set_yscale("symlog", linthresh=1)
        kept.set_ylim(0, None)
    for name, label in (("fracture", "fracture, $G_f$"), ("released", "released at breaking"), ("damping", "damping"),
                        ("friction", "friction"), ("viscous", "interlayer, viscous"),
                        ("conv_strain", "lost at conversion: strain"), ("conv_kinetic", "lost at conversion: kinetic")):
        dissipated.plot(t, 1e3 * e[name], label=label, ls=":" if "conv" in name else "-")
    dissipated.set(title="dissipated, and lost at conversions", ylabel="mJ")
    kinetic.plot(t, 1e3 * (e["e_kinetic"] - e["e_kinetic"][0]), color="k", label="kinetic")
    kinetic.plot(t, -1e3 * stored(e), ls="--", label="$-$ stored")
    kinetic.set(title=f"change of the kinetic energy (initially {e['e_kinetic'][0]:.4f} J)", ylabel="mJ", xlabel="us")
    initial = float(e["total"][0])
    scale = initial if initial > 0 else energy_scale(e)
    total.plot(t, 100 * (e["total"] - initial) / scale, color="k", label="kinetic + stored + dissipated $-$ external work")
    total.plot(t, 100 * (e["balance"] - initial) / scale, ls="--", label="with what conversions lose")
    if limit is not None:
        total.axhline(limit, color=RED, lw=0.8)
    total.axhline(0, color="0.6", lw=0.8)
    total.set(title=f"total energy, change in % of the {'initial' if initial > 0 else 'largest that was put in'}", ylabel="%", xlabel="us")
    for axis in axes.flat:
        marks(axis, times)
        if t[-1] > t[0]:
            axis.set_xlim(t[0], t[-1])
        axis.legend(fontsize=8)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path, dpi=100)
    plt.close(figure)


def loaded(axis, time, e):
    """Energies of a body that is loaded, over the time (n,) in us, into one plot: work of loads, kinetic, stored, fracture."""
    axis.plot(time, e["external"], label="work of loads")
    axis.plot(time, e["e_kinetic"], label="kinetic")
    axis.plot(time, stored(e), label="stored")
    axis.plot(time, e["fracture"] + e["released"], label="fracture")
    axis.plot(time, e["total"], color="k", lw=0.8, label="total less work of loads")
    axis.set(xlabel="time (us)", ylabel="energy (J)")
    axis.legend(fontsize=7)


def force(path, title, curves, end=None, times=()):
    """Forces over time. curves: {label: (times (n,) in s, forces (n,) in N)}, label "" for one without a legend; end of the
    axis and marked times in us."""
    plt = plotting()
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    for label, (t, f) in curves.items():
        axis.plot(1e6 * np.asarray(t), 1e-3 * np.asarray(f), label=label, color="k" if len(curves) == 1 else None)
    marks(axis, times)
    axis.set(xlabel="us", ylabel="kN", xlim=(0, end), title=title)
    if any(curves):
        axis.legend(fontsize=8)
    figure.savefig(path, dpi=100)
    plt.close(figure)


def timeline(path, title, events, end=None):
    """The crack over time, from Events: what has converted, softens and is broken, and how far the crack has come from
    where it began. end of the axis in us."""
    plt = plotting()
    broken = events.of("broken")
    end = end if end is not None else 1e6 * float(events.time.max(initial=0.0))
    t = np.linspace(0, max(end, 1e-9), 500)
    figure, (number, reach) = plt.subplots(2, 1, figsize=(8, 6), sharex=True, constrained_layout=True)
    for (kind, values), label in zip(crack_measures.counts(events, 1e-6 * t).items(),
                                     ("elements converted", "joints that have softened", "joints broken",
                                      "ties that have softened", "ties broken")):
        if values[-1]:
            number.plot(t, values, label=label)
    number.set(title=title, ylabel="number so far", xlim=(0, max(end, 1e-9)))
    if len(events):
        number.legend(fontsize=8)
    if len(broken):
        way = np.linalg.norm(broken.x - broken.x[np.argmin(broken.time)], axis=1)
        when, far = crack_measures.farthest(broken.time, way)
        reach.step(np.append(1e6 * when, end), 1e3 * np.append(far, far[-1]), where="post", color="k")
    reach.set(xlabel="us", ylabel="farthest broken joint\nfrom the first (mm)")
    figure.savefig(path, dpi=100)
    plt.close(figure)


def live(path, names, rows):
    """A picture of what a run has done so far, to be drawn again after each piece of it: names (k,), rows (n, k), the first
    column over which the others are drawn. Without matplotlib nothing is drawn. The file is there whole at any time."""
    if not available():
        return
    plt, table = plotting(), np.asarray(rows, float)
    figure, axes = plt.subplots(len(names) - 1, 1, figsize=(7, 2 * len(names) - 1), sharex=True, squeeze=False, constrained_layout=True)
    for axis, name, column in zip(axes[:, 0], names[1:], table.T[1:]):
        axis.plot(table[:, 0], column, "o-", ms=3, color="k")
        axis.set_ylabel(name)
    axes[-1, 0].set_xlabel(names[0])
    new = path.with_name("." + path.name)
    figure.savefig(new, dpi=100)
    new.replace(path)
    plt.close(figure)


def unfold(degrees, values, mirrors=(90, 180)):
    """Values (n,) at angles (n,) over the whole circle, by symmetry about lines at the angles `mirrors`, one after the other:
    (90, 180) from a quarter, (45, 90, 180) from an eighth. Returns angles and values."""
    degrees, values = np.asarray(degrees, float), np.asarray(values, float)
    for mirror in mirrors:
        keep = degrees[::-1] < mirror    # what lies on the line is its own image
        degrees = np.concatenate([degrees, 2.0 * mirror - degrees[::-1][keep]])
        values = np.concatenate([values, values[::-1][keep]])
    return degrees, values


def polar_pair():
    """A figure with two polar axes side by side, for polar()."""
    figure, axes = plotting().subplots(1, 2, subplot_kw={"projection": "polar"}, figsize=(9.5, 4.8))
    return figure, axes


def polar(axis, title, ticks, largest, curves, mirrors=(90, 180)):
    """Values over directions. curves: {label: (degrees (n,), values (n,), options of plot)}; see unfold()."""
    for label, (degrees, values, options) in curves.items():
        angle, value = unfold(degrees, values, mirrors)
        axis.plot(np.radians(angle), value, label=label, **options)
    axis.set_title(title, fontsize=9, pad=14)
    axis.set_rlim(0, largest)
    axis.set_rticks(ticks)
    axis.set_rlabel_position(100)
    axis.tick_params(labelsize=8)


def polar_legend(figure, title):
    """One legend below both, and a title above."""
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="lower center", ncol=3, frameon=False, fontsize=9)
    figure.suptitle(title, fontsize=11)
    figure.subplots_adjust(bottom=0.14, top=0.8, wspace=0.3)


# ---- pictures of LAMMPS --------------------------------------------------------------------------


def pictures(folder, pattern, dt):
    """[(time in us, file)] of the pictures NAME.STEP.png in a folder, in order of time; dt: the time step in s."""
    found = []
    for path in folder.glob(pattern):
        step = path.name.split(".")[1]
        if not step.isdigit():
            raise InputError(f"{path}: the name of a picture is NAME.STEP.png")
        found.append((1e6 * dt * int(step), path))
    return sorted(found)


def letters(captions):
    """(a), (b), ... before captions."""
    return [f"({letter})  {caption}" for letter, caption in zip(string.ascii_lowercase, captions)]


def sheet(path, titles, cells, columns, width=720):
    """Pictures side by side and under each other: cells [(file, caption)], row by row, or None for an empty place. titles:
    one for the whole, or one per column."""
    fonts = needed("matplotlib.font_manager", "python3-matplotlib", "a sheet of pictures")
    Image, ImageDraw, ImageFont = (needed(f"PIL.{name}", "python3-pil", "a sheet of pictures") for name in ("Image", "ImageDraw", "ImageFont"))

    def font(size):
        return ImageFont.truetype(fonts.findfont("DejaVu Sans"), size)

    def load(file):
        image = Image.open(file).convert("RGB")
        return image.resize((width, round(image.height * width / image.width)), Image.LANCZOS)

    head, bar, gap = 44, 34, 8
    images = [cell and (load(cell[0]), cell[1]) for cell in cells]
    rows = [images[k:k + columns] for k in range(0, len(images), columns)]
    heights = [max((cell[0].height for cell in row if cell), default=0) + bar for row in rows]
    out = Image.new("RGB", (columns * (width + gap) + gap, head + sum(heights) + len(rows) * gap), "#d8d8d8")
    draw = ImageDraw.Draw(out)
    for k, title in enumerate([titles] if isinstance(titles, str) else titles):
        draw.text((gap + k * (width + gap) + 4, 8), title, fill="black", font=font(24))
    top = head
    for row, height in zip(rows, heights):
        for k, cell in enumerate(row):
            if cell:
                left = gap + k * (width + gap)
                draw.rectangle((left, top, left + width - 1, top + height - 1), fill="white")
                out.paste(cell[0], (left, top + (height - bar - cell[0].height) // 2))
                draw.text((left + 12, top + height - bar + 4), cell[1], fill="black", font=font(20))
        top += height + gap
    out.quantize(256).save(path, optimize=True)    # few colours: small files
