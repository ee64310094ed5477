"""Strength, fracture energy, path, branching and speed of cracks in turned lattices: see run.sh."""

import argparse
import concurrent.futures
import os
import subprocess

import numpy as np

from mesh import Mesh, along, turned    # which makes the package defe known
import defe
from defe import plots

plt = plots.plotting()

HERE = os.path.dirname(os.path.abspath(__file__))
DOC = os.path.join(HERE, '..', '..', '..', 'lammps-package', 'doc')
PAGE = os.path.join(DOC, 'Howto_defe_cracks.rst')
D, H = 1e-3, 2e-3            # spacing of discrete elements, edge of finite elements
E, SIGMA_T = 74.09e9, 60e6
RAYLEIGH = 3192.0            # m/s
CUTTING = 40                 # steps in which the notch is made
RED, BLUE, GREY = '#c0392b', '#1f4e9c', '#888888'


def run_lammps(script, name, **variables):
    """Runs it in the output folder; files begin with `name`."""
    command = [options.lmp, '-in', os.path.join(HERE, script), '-log', name + '.log', '-screen', 'none', '-nocite',
               '-var', 'out', name]
    for key, value in variables.items():
        command += ['-var', key, f'{value:.12g}' if isinstance(value, float) else str(value)]
    environment = dict(os.environ, OMP_NUM_THREADS='1')
    old = os.environ.get('LD_LIBRARY_PATH')
    environment['LD_LIBRARY_PATH'] = options.plugin + (':' + old if old else '')
    done = subprocess.run(command, cwd=options.out, env=environment, stdin=subprocess.DEVNULL)
    if done.returncode:
        raise SystemExit(f'LAMMPS failed, see {os.path.join(options.out, name)}.log')


def path(name):
    return os.path.join(options.out, name)


# ---- strength ----

def strength(direction, law, beta=0.1):
    """Stress at the first damage in tension along this direction of the lattice, over sigma_t."""
    mesh = Mesh([H] * 3, along(direction), lambda c: np.ones(len(c), bool), 1.5 * H)
    mesh.write(path('block.data'), 2)
    unit = SIGMA_T / E
    run_lammps('in.block', 'block', mesh='block.data', law=law, beta=beta, strain=0.95 * unit, grow=0.005 * unit,
               half=6.0 * H)
    return 0.95 + 0.005 * (defe.read_events(path('block.events')).of('cohesive').step.min() - 1)


def plot_strength():
    degrees = np.arange(0.0, 91.0, 7.5)
    planes = {
        'tension in the plane (001)': lambda a: [np.cos(a), np.sin(a), 0.0],
        'tension in the plane (110), with [111] at 54.7 degrees':
            lambda a: [np.sin(a) / np.sqrt(2), np.sin(a) / np.sqrt(2), np.cos(a)]}
    laws = {'lattice, beta 0.1': ('lattice', 0.1, RED, '-'), 'lattice, beta 1': ('lattice', 1.0, RED, ':'),
            'fronts (default)': ('fronts', 0.1, BLUE, '-')}
    figure, axes = plots.polar_pair()
    table, worst = {}, 0.0
    for ax, (title, direction) in zip(axes, planes.items()):
        at, curves = np.unique(np.append(degrees, 54.7356)) if '111' in title else degrees, {}
        for name, (law, beta, colour, line) in laws.items():
            s = np.array([strength(direction(a), law, beta) for a in np.radians(at)])
            for a, value in zip(at, s):
                table[(title, name, round(a, 1))] = value
            if law == 'fronts':
                worst = max(worst, np.abs(s - 1.0).max())
            curves[name] = at, 60.0 * s, {'color': colour, 'ls': line}
        plots.polar(ax, title, [60, 120, 180], 190, curves)
    plots.polar_legend(figure, 'stress at the first damage (MPa), strength 60 MPa')
    save(figure, 'strength')

    rows = [['direction of the tension', '0', '15', '30', '45', '[111]']]
    first, second = planes
    for name in laws:
        values = [table[(first, name, a)] for a in (0.0, 15.0, 30.0, 45.0)] + [table[(second, name, 54.7)]]
        rows.append([name] + [f'{60.0 * v:.1f}' for v in values])
    show('strength', 'Stress at the first damage (MPa), strength 60 MPa', rows)
    print(f'fronts: within {100.0 * worst:.1f} % of sigma_t in all directions')


# ---- strips ----

class Strip:
    """A notched strip, x from left to right, between grips at y = +-height/2 (all in D)."""

    def __init__(self, turn, thickness=6.0, left=-16.0, right=20.0, height=24.0, tough_end=0.0, moved=0.0):
        self.turn, self.thickness = turn, thickness
        self.left, self.right, self.height, self.moved, self.tough_end = left, right, height, moved, tough_end

    def run(self, name, law, start, gf, strain=1.6e-4, rate=4.0, stop=16.0, steps=2000):
        half = np.array([max(self.right, -self.left), self.height / 2, self.thickness / 2]) * D

        def inside(c):
            return ((c[:, 0] > self.left * D) & (c[:, 0] < self.right * D) & (np.abs(c[:, 1:]) < half[1:]).all(axis=1))

        self.mesh = mesh = Mesh([H] * 3, self.turn, inside, np.linalg.norm(half) + H, self.moved)
        held = np.abs(mesh.centre[:, 1]) > half[1] - 2.5 * D
        tough = held | (mesh.centre[:, 0] > (self.right - self.tough_end) * D)
        mesh.write(path(name + '.data'), 5, np.where(tough, 'grip', 'glass'), held)
        run_lammps('in.strip', name, mesh=name + '.data', law=law, gf=gf, start=start, strain=strain, rate=rate,
                   stop=stop * D, steps=steps, **mesh.box())
        self.gf = gf
        self.read(name)
        for end in ('data', 'joints', 'events', 'log'):
            os.remove(path(f'{name}.{end}'))
        return self

    def read(self, name):
        events = defe.read_events(path(name + '.events'))
        self.broken, self.converted = events.of('broken'), events.of('convert')
        self.started = events.where(events.step > CUTTING).of('cohesive')
        self.thermo = defe.read_log(path(name + '.log')).runs[2].thermo
        joints = defe.read_dump(path(name + '.joints'))[-1].table
        one, two, damage = list(joints.columns.values())[1:4]
        self.softening = {(int(a), int(b)): d for a, b, d in zip(one, two, damage) if d > 0.0}

    def area(self, events):
        """Projected areas of joints (m2); with the law lattice n is their own direction."""
        axis = self.mesh.de(events.ids[:, 1]) - self.mesh.de(events.ids[:, 0])
        axis /= np.linalg.norm(axis, axis=1)[:, None]
        return D * D * np.abs((axis * events.n).sum(axis=1))

    def measure(self, begin=2.0):
        """Tilts (degrees) and scatter (D) of the crack, fracture energy by its area over G_f, stray joints."""
        b = self.broken.where(self.broken.step > CUTTING)
        a, x, z_end = self.area(b), b.x / D, self.thickness / 2 - 0.5
        r = {'tip': x[:, 0].max() if len(b) else 0.0}
        w = a * (x[:, 0] > begin)
        if (w > 0.0).sum() < 10 or r['tip'] < begin + 6.0:
            return None
        rows = np.stack([np.ones(len(x)), x[:, 0], x[:, 2]], axis=1)
        k = np.linalg.solve(rows.T @ (w[:, None] * rows), rows.T @ (w * x[:, 1]))
        n = np.array([-k[1], 1.0, -k[2]]) / np.sqrt(1.0 + k[1]**2 + k[2]**2)
        r['tilt'], r['across'] = np.degrees(np.arctan(k[1:]))
        off = (x - [0.0, k[0], 0.0]) @ n
        r['scatter'] = np.sqrt((w * off**2).sum() / w.sum())
        ahead = self.started.x / D
        r['stray'] = int(((ahead[:, 0] > begin) & (np.abs((ahead - [0.0, k[0], 0.0]) @ n) > 1.5)).sum())

        def window(s, lo, hi):
            return np.clip(np.minimum(s - lo, hi - s) / 2.0, 0.0, 1.0)

        end = r['tip'] - 2.0
        inside = (a * window(x[:, 0], begin, end) * window(x[:, 2], -z_end, z_end)).sum()
        sx, sz = np.arange(begin, end, 0.05), np.arange(-z_end, z_end, 0.05)
        true = window(sx, begin, end).sum() * window(sz, -z_end, z_end).sum() * 0.0025 * D * D / n[1]
        damage = np.array([self.softening.get(tuple(i), 0.0) for i in self.started.ids])
        t = self.thermo
        fracture = t['fracture'][-1] - t['fracture'][0]
        work = fracture / (self.gf * (a.sum() + (damage * self.area(self.started)).sum()))
        r['energy'] = work * inside / true
        held = t['e_kinetic'] + t['PotEng']
        r['rise'] = defe.largest_rise(held - t['external']) / held.max()
        return r

    def beyond(self):
        """Times (s) of the joints broken beyond the notch, and where (m)."""
        e = self.broken.where(self.broken.x[:, 0] > 0.0)
        return e.time, e.x[:, 0]

    def speed(self, x1, x2):
        return defe.cracks.speed(*self.beyond(), x1 * D, x2 * D)

    def arms(self, at):
        return defe.cracks.arms(self.broken.x, at * D, 2.0 * D, 3.0 * D)


ORIENTATIONS = [('0', turned(0), 6.0), ('11.25', turned(11.25), 6.0), ('22.5', turned(22.5), 6.0),
                ('33.75', turned(33.75), 6.0), ('45', turned(45), 6.0), ('0, 22.5', turned(0, 22.5), 20.0),
                ('0, 45', turned(0, 45), 28.0), ('22.5, 22.5', turned(22.5, 22.5), 20.0),
                ('[111]', along([1, 1, 1]), 20.0)]
CASES = [('lattice', 'lattice', 'all'), ('fronts', 'fronts', 'all'), ('fronts, adaptive', 'fronts', 'seam')]


def plot_paths():
    cases = [(gf, name, turn, thickness, label, law, start) for gf in (50.0, 10.0)
             for name, turn, thickness in ORIENTATIONS for label, law, start in CASES
             if law != 'lattice' or thickness <= 6.0]    # of lattice the plane says enough

    def one(k):
        gf, name, turn, thickness, label, law, start = cases[k]
        strip = Strip(turn, thickness).run(f'strip{k}', law, start, gf)
        return (gf, name, label), (strip.broken.where(strip.broken.step > CUTTING).x, strip.measure())

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        found = dict(pool.map(one, range(len(cases))))
    for gf in (50.0, 10.0):
        rows = [['lattice turned by', 'law', 'tilt along', 'across', 'scatter (d)', 'energy / G_f', 'beside it',
                 'energy rises']]
        for name, _, _ in ORIENTATIONS:
            for label, _, _ in CASES:
                if (gf, name, label) not in found:
                    continue
                _, r = found[(gf, name, label)]
                if r is None:
                    rows.append([name, label] + ['does not run'] + [''] * 5)
                    continue
                rows.append([name, label, f'{r["tilt"]:.1f}', f'{r["across"]:.1f}', f'{r["scatter"]:.2f}',
                             f'{r["energy"]:.2f}', str(r['stray']), f'{100 * r["rise"]:.3f} %'])
        show(f'paths{gf:.0f}', f'Crack in a notched strip, G_f = {gf:.0f} J/m2', rows)

    angles = [0.0, 11.25, 22.5, 33.75, 45.0]
    names = ['0', '11.25', '22.5', '33.75', '45']
    figure, axes = plt.subplots(2, 5, figsize=(11, 4.6), sharex=True, sharey=True)
    for row, label in enumerate(('lattice', 'fronts')):
        for ax, name, angle in zip(axes[row], names, angles):
            x, _ = found[(10.0, name, label)]
            for s in (-1, 1):    # rows of the lattice
                a = np.radians(angle if s > 0 else angle - 90.0)
                ax.plot([0, 30 * np.cos(a)], [0, 30 * np.sin(a)], color='0.85', lw=0.8, zorder=0)
            ax.plot([-5, 0], [0, 0], color='k', lw=2)
            ax.scatter(x[:, 0] * 1e3, x[:, 1] * 1e3, s=3, color=RED if label == 'lattice' else BLUE)
            ax.set(xlim=(-5, 20), ylim=(-10, 10), aspect='equal')
            if row == 0:
                ax.set_title(f'lattice turned by {name}', fontsize=9)
        axes[row][0].set_ylabel(label + '\ny (mm)')
    for ax in axes[1]:
        ax.set_xlabel('x (mm)')
    figure.tight_layout()
    save(figure, 'paths')

    figure, axes = plots.polar_pair()
    for ax, gf in zip(axes, (50.0, 10.0)):
        curves = {}
        for label, colour, marker in (('lattice', RED, 's'), ('fronts', BLUE, 'o'), ('fronts, adaptive', BLUE, '^')):
            e = np.array([found[(gf, n, label)][1]['energy'] if found[(gf, n, label)][1] else np.nan for n in names])
            curves[label] = angles, e, {'color': colour, 'marker': marker, 'ms': 4, 'ls': '-' if marker != '^' else ':'}
        plots.polar(ax, f'G_f = {gf:.0f} J/m2', [0.5, 1.0, 1.5, 2.0], 2.2, curves, mirrors=(45, 90, 180))
        ax.plot(np.linspace(0, 2 * np.pi, 100), np.ones(100), color=GREY, lw=0.8)
    plots.polar_legend(figure, 'fracture energy by the area of the crack, over G_f')
    save(figure, 'energy')


# ---- branching ----

def plot_branching():
    rows = [['lattice turned by', 'law', 'speed, x = 5 to 25 mm (m/s)', '25 to 45 mm', 'cracks at x = 45 mm']]
    figure, axes = plt.subplots(3, 3, figsize=(10, 7.2), sharex=True, sharey=True)
    plot, ax_speed = plt.subplots(figsize=(6, 4))
    angles = (0.0, 22.5, 45.0)

    def one(k):
        plate = Strip(turned(angles[k // 3]), 2.0, -10.0, 60.0, 60.0, 4.0)
        return plate.run(f'plate{k}', *CASES[k % 3][1:], 10.0, strain=4.5e-4, rate=0.0, stop=54.0, steps=560)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        plates = list(pool.map(one, range(9)))
    for column, angle in enumerate(angles):
        for row, (label, law, start) in enumerate(CASES):
            plate = plates[3 * column + row]
            ax, colour = axes[row][column], RED if law == 'lattice' else BLUE
            if start == 'seam':
                c = plate.converted.x * 1e3
                ax.scatter(c[:, 0], c[:, 1], s=9, marker='s', color='0.8', zorder=0)
            x = plate.broken.x[plate.broken.x[:, 0] > 0.0] * 1e3
            ax.scatter(x[:, 0], x[:, 1], s=2, color=colour)
            ax.plot([-5, 0], [0, 0], color='k', lw=2)
            ax.set(xlim=(-5, 60), ylim=(-25, 25), aspect='equal')
            if row == 0:
                ax.set_title(f'lattice turned by {angle:g}', fontsize=9)
            if column == 0:
                ax.set_ylabel(label + '\ny (mm)')
            if row == 2:
                ax.set_xlabel('x (mm)')
            speeds = [plate.speed(5.0, 25.0), plate.speed(25.0, 45.0)]
            rows.append([f'{angle:g}', label] + ['-' if np.isnan(v) else f'{v:.0f}' for v in speeds]
                        + [str(plate.arms(45.0))])
            t, far = defe.cracks.farthest(*plate.beyond())
            ax_speed.plot(t * 1e6, far * 1e3, color=colour, ls=('-', '--', ':')[column], lw=0.8 + 0.6 * (start == 'seam'),
                          label=f'{label}, {angle:g}')
    t = np.array([0.0, 18.0])
    ax_speed.plot(t, RAYLEIGH * t * 1e-3, color='k', lw=0.8, label='Rayleigh waves, 3192 m/s')
    ax_speed.set(xlabel='time (us)', ylabel='farthest broken joint (mm)', ylim=(0, 56), xlim=(0, 24))
    ax_speed.legend(fontsize=7)
    figure.tight_layout()
    plot.tight_layout()
    save(figure, 'branching')
    save(plot, 'speed')
    show('branching', 'A plate strained by 4.5e-4 before its notch is cut', rows)


# ---- output ----

def save(figure, name):
    figure.savefig(path(name + '.png'), dpi=100)
    if options.page:
        figure.savefig(os.path.join(DOC, f'Howto_defe_cracks_{name}.png'), dpi=100)
    plt.close(figure)


def show(name, title, rows):
    """Prints a table, and puts it into the page."""
    print('\n' + title)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        print('  ' + '  '.join(cell.ljust(w) for cell, w in zip(row, widths)), flush=True)
    if not options.page:
        return
    lines = ['.. csv-table::', '   :header-rows: 1', '']
    lines += ['   ' + ', '.join(f'"{cell}"' for cell in row) for row in rows]
    text = open(PAGE).read()
    begin, end = f'.. begin {name}\n', f'.. end {name}\n'
    head, rest = text.split(begin)
    tail = rest.split(end)[1]
    with open(PAGE, 'w') as out:
        out.write(head + begin + '\n' + '\n'.join(lines) + '\n\n' + end + tail)


if __name__ == '__main__':
    parts = {'strength': plot_strength, 'paths': plot_paths, 'branching': plot_branching}
    parser = argparse.ArgumentParser()
    parser.add_argument('--lmp', required=True)
    parser.add_argument('--plugin', required=True, help='folder of defeplugin.so')
    parser.add_argument('--out', default=os.path.join(HERE, 'output'))
    parser.add_argument('--page', action='store_true', help='put tables and pictures into the page')
    parser.add_argument('--jobs', type=int, default=os.cpu_count(), help='strips at the same time')
    parser.add_argument('part', nargs='*', choices=[[], *parts])
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    for part in options.part or parts:
        defe.summary.main(parts[part])
