#!/usr/bin/env python3
"""What examples/four_point_bending/run.sh makes of a run: strengths.txt, summary.json, strength.png.

analyse.py FOLDER     force.N.txt and flaws.N.dump of the specimens
"""

import json
import math
import os
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / "python")]
import defe
import numpy as np
from defe import plots, summary

SHAPE, SCALE, AREA = 7.0, 70e6, 0.01    # flaws of the script
LENGTH, WIDTH, HEIGHT, OUTER, INNER = 0.06, 0.01, 0.004, 0.05, 0.02
THROUGH = 4                             # elements through the thickness
COMPARED = 1.0 - (1.0 - math.sqrt(1.0 / 3.0)) / THROUGH    # tension at the outermost Gauss points, over that of the surface


def fit(sample):
    """Shape and scale of a Weibull distribution, by maximum likelihood."""
    logs = np.log(sample)
    low, high = 0.1, 200.0
    for _ in range(80):
        shape = 0.5 * (low + high)
        powers = np.exp(shape * (logs - logs.mean()))
        if np.sum(powers * (logs - logs.mean())) / np.sum(powers) < 1.0 / shape:
            low = shape
        else:
            high = shape
    return shape, math.exp(logs.mean()) * np.mean(np.exp(shape * (logs - logs.mean())))**(1.0 / shape)


def moment_at(x):
    """Bending moment over that in the middle."""
    return np.clip((0.5 * OUTER - abs(x)) / (0.5 * (OUTER - INNER)), 0.0, 1.0)


def weakest(frame):
    """Tension at the outermost Gauss points in the middle of the beam at which the weakest of its elements breaks, by beam theory."""
    x, y, strength = (frame[f"c_flaws[{k}]"] for k in (1, 2, 3))
    outwards = 0.5 * HEIGHT / THROUGH * math.sqrt(1.0 / 3.0)
    tension = moment_at(x) * (outwards - y) / (0.5 * HEIGHT * COMPARED)
    pulled = tension > 0.01
    return float(np.min(strength[pulled] / tension[pulled]))


def effective_area():
    """Area of the surface of the DEs, weighted with the power SHAPE of their tension over the largest one."""
    d = 0.5 * HEIGHT / THROUGH
    x = (np.arange(round(LENGTH / d)) + 0.5) * d - 0.5 * LENGTH
    moment = moment_at(x)
    y = (np.arange(THROUGH) + 0.5) / (THROUGH - 0.5)    # of the DEs in tension, the outermost ones are 1
    below = WIDTH * d * np.sum(moment**SHAPE)
    sides = 2.0 * d * d * np.sum(moment**SHAPE) * np.sum(y**SHAPE)
    return below + sides


def main(folder):
    strengths, flaws = {}, {}
    for path in sorted(folder.glob("force.*.txt"), key=lambda p: int(p.name.split(".")[1])):
        force = defe.read_table(path)
        begins = 1e6 * force["t_damage"][-1]    # as the crack runs the beam shakes
        if begins > 0.0:
            number = int(path.name.split(".")[1])
            strengths[number] = COMPARED * float(np.interp(begins, force["time_us"], force["tension"]))
            flaws[number] = weakest(defe.read_dump(folder / f"flaws.{number}.dump")[0])
    if len(strengths) < 5:
        raise defe.InputError(f"{folder}: only {len(strengths)} specimens broke: raise the load (-var end)")
    sample = np.sort(np.array(list(strengths.values())))
    n = len(sample)
    shape, scale = fit(sample)
    drawn = np.array(list(flaws.values()))
    over = np.array(list(strengths.values())) / drawn
    drawn_shape, drawn_scale = fit(drawn)
    expected = SCALE * (AREA / effective_area())**(1.0 / SHAPE)
    draws = np.sort(expected * np.random.default_rng(1).weibull(SHAPE, (4000, n)), axis=1)
    fits = np.array([fit(draw) for draw in draws[:1000]])
    below = 1.0 - np.exp(-(sample / expected)**SHAPE)
    ranks = np.arange(n)
    distance = math.sqrt(n) * max(np.max((ranks + 1) / n - below), np.max(below - ranks / n))
    limits = np.percentile(fits, [5, 95], axis=0)
    s = {"specimens": n, "shape": round(shape, 3), "scale_MPa": round(1e-6 * scale, 3), "expected_shape": SHAPE,
         "expected_scale_MPa": round(1e-6 * expected, 3), "shape_90_percent": [round(v, 2) for v in limits[:, 0]],
         "scale_90_percent_MPa": [round(1e-6 * v, 2) for v in limits[:, 1]], "mean_MPa": round(1e-6 * sample.mean(), 3),
         "least_MPa": round(1e-6 * sample[0], 3), "most_MPa": round(1e-6 * sample[-1], 3), "kolmogorov": round(distance, 3),
         "drawn_shape": round(drawn_shape, 3), "drawn_scale_MPa": round(1e-6 * drawn_scale, 3),
         "over_drawn": round(float(np.median(over)), 4)}
    summary.write_json(folder / "summary.json", s)
    (folder / "strengths.txt").write_text("# specimen, tension at the outermost Gauss points at its break, and that at which its weakest element should break (MPa)\n" + "".join(
        f"{k} {1e-6 * v:.4f} {1e-6 * flaws[k]:.4f}\n" for k, v in strengths.items()))
    plot(folder / "strength.png", sample, shape, scale, expected, np.percentile(draws, [5, 95], axis=0))
    print(json.dumps(s, indent=1))
    made = [name for name in ("summary.json", "strengths.txt", "strength.png", "beam.png") if (folder / name).exists()]
    print(f"\n{n} specimens broken at {s['least_MPa']:.0f} to {s['most_MPa']:.0f} MPa, mean {s['mean_MPa']:.1f} MPa; "
          f"{', '.join(made)} in {os.path.relpath(folder)}")


def plot(path, sample, shape, scale, expected, band):
    plt = plots.plotting()
    figure, axis = plt.subplots(figsize=(7, 5), constrained_layout=True)
    n = len(sample)
    level = np.log(-np.log(1.0 - (np.arange(n) + 0.5) / n))
    axis.fill_betweenx(level, 1e-6 * band[0], 1e-6 * band[1], color="#cde", label="90 % of samples of as many")
    for m, s, style, label in ((SHAPE, expected, "k--", f"flaws of the script: shape {SHAPE:g}, {1e-6 * expected:.0f} MPa"),
                               (shape, scale, "r-", f"fit: shape {shape:.1f}, {1e-6 * scale:.0f} MPa")):
        axis.plot(1e-6 * s * np.exp(level / m), level, style, label=label)
    axis.plot(1e-6 * sample, level, "o", color="#36c", label=f"{n} specimens")
    axis.set(xscale="log", xlabel="tension at the outermost Gauss points at the break (MPa)", ylabel="broken (%)",
             title="four-point bending of glass")
    shares = [2, 5, 10, 20, 40, 63, 90, 98]
    axis.set_yticks([math.log(-math.log(1.0 - 0.01 * p)) for p in shares], [str(p) for p in shares])
    ticks = [60, 80, 100, 120, 140, 160, 180]
    axis.set_xticks(ticks, [str(t) for t in ticks])
    axis.minorticks_off()
    axis.set_xlim(0.9e-6 * min(sample[0], band[0][0]), 1.1e-6 * max(sample[-1], band[1][-1]))
    axis.grid(alpha=0.3)
    axis.legend(loc="lower right")
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    summary.main(main, Path(sys.argv[1]))
