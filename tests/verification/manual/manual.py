"""Runs the cases of the verification manual, prints a table of what comes out beside what is published, and writes a page
with all plots: see tests/verify.sh. A case is a folder here with a README.md (problem, model, result, comparison, limits) and a
case.py that has

    TITLE       one line
    ACCEPTANCE  list of Accept
    run(s)      s: a Session. Returns {quantity: value} for the quantities of ACCEPTANCE
"""

import argparse
import concurrent.futures
import dataclasses
import datetime
import html
import importlib.util
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
RESULT = "result.json"    # of a case, in its folder of results
sys.path[:0] = [str(HERE), str(ROOT / "python")]
import defe  # noqa: E402

plt = defe.plots.plotting()

@dataclasses.dataclass
class Accept:
    """One figure to be held against: |value - target| <= tolerance, or low <= value <= high."""

    quantity: str
    source: str    # of the target
    target: float = math.nan
    tolerance: float = math.nan
    low: float = -math.inf
    high: float = math.inf
    unit: str = ""
    certain: bool = True    # False: the source is not certain; shown, does not fail
    known: bool = False    # it is known not to be met, README.md says why; shown, does not fail
    digits: int = 3
    fine: bool = False    # of --fine alone

    def bounds(self):
        if math.isfinite(self.target) and math.isfinite(self.tolerance):
            return self.target - self.tolerance, self.target + self.tolerance
        return self.low, self.high

    def published(self):
        low, high = self.bounds()
        if math.isfinite(self.target) and math.isfinite(self.tolerance):
            return f"{number(self.target, self.digits)} +- {number(self.tolerance, self.digits)}"
        if math.isfinite(low) and math.isfinite(high):
            return f"{number(low, self.digits)} to {number(high, self.digits)}"
        return f"below {number(high, self.digits)}" if math.isfinite(high) else f"above {number(low, self.digits)}"

    def verdict(self, value):
        low, high = self.bounds()
        inside = value is not None and math.isfinite(value) and low <= value <= high
        return "within" if inside else "not within, known" if self.known else "not within"


def number(value, digits=3):
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def processor_seconds(log):
    """Of all runs in the text of a log file of one rank: what else the machine does hardly changes it."""
    loops = re.findall(r"^Loop time of (\S+) on .*?^(\S+)% CPU use", log, re.M | re.S)
    return sum(0.01 * float(seconds) * float(share) for seconds, share in loops)


class Energies(defe.Table):
    """A file of fix ave/time with fix defe's vector: columns by name, and how well they are conserved."""

    def __init__(self, file):
        super().__init__(defe.read_table(file).columns, file)
        self.scale = defe.energy_scale(self)

    def rise(self):
        """Largest rise of the total above an earlier value, over the largest of what was put in or was there."""
        return defe.largest_rise(self.total) / self.scale

    def drift(self):
        """Largest deviation of the balance, which should be constant, over the same."""
        return defe.balance_drift(self) / self.scale


class Session:
    """What a case runs with: LAMMPS, its folder of results, and what it shows."""

    def __init__(self, name, options):
        self.name, self.options, self.fine, self.quick = name, options, options.fine, options.quick    # quick: without the finest mesh
        self.folder = HERE / name
        self.out = options.out / name
        self.out.mkdir(parents=True, exist_ok=True)
        for old in self.out.iterdir():
            shutil.rmtree(old) if old.is_dir() else old.unlink()
        self.shown = []    # (kind, ...) in the order of the page
        self.loops = {}

    def path(self, name):
        return self.out / name

    def lammps(self, script, name, **variables):
        """Runs it in the folder of results; the files that it writes begin with `name`."""
        o = self.options
        command = [o.lmp, "-in", str((self.folder / script).resolve()), "-log", name + ".log", "-screen", "none", "-nocite", "-var",
                   "out", name]
        for key, value in variables.items():
            command += ["-var", key, f"{value:.12g}" if isinstance(value, float) else str(value)]
        environment = dict(os.environ, OMP_NUM_THREADS="1")
        old = os.environ.get("LD_LIBRARY_PATH")
        environment["LD_LIBRARY_PATH"] = str(o.plugin) + (":" + old if old else "")
        done = subprocess.run(command, cwd=self.out, env=environment, stdin=subprocess.DEVNULL)
        log = defe.read_log(self.path(name + ".log"))    # whose message has LAMMPS' error
        if done.returncode:
            raise defe.InputError(f"LAMMPS failed in {self.name}: {log.errors[0] if log.errors else name + '.log'}")
        self.loops[name] = processor_seconds(self.path(name + ".log").read_text())

    def all(self, function, items):
        """function(item) for all items, as many at a time as there are cores."""
        with concurrent.futures.ThreadPoolExecutor(self.options.jobs) as pool:
            return list(pool.map(function, items))

    def energies(self, name):
        """Of a run of a case, or of an example, which has a folder of results."""
        file = self.path(name + ".energies")
        return Energies(file if file.exists() else self.path(name) / "energies.txt")

    def text(self, words):
        self.shown.append(("text", words))

    def table(self, title, rows):
        """First row: heads."""
        self.shown.append(("table", title, [[str(c) for c in row] for row in rows]))

    def figure(self, figure, name, caption):
        figure.savefig(self.path(name + ".png"), dpi=100)
        plt.close(figure)
        self.shown.append(("figure", f"{self.name}/{name}.png", caption))

    def plot_energies(self, name, dt, title):
        """Energies of one run over time."""
        e = self.energies(name)
        figure, ax = plt.subplots(figsize=(6, 3.4))
        defe.plots.loaded(ax, e.step * dt * 1e6, e)
        ax.set_title(title, fontsize=9)
        figure.tight_layout()
        self.figure(figure, "energies_" + name, f"{title}: energies. The total rises by at most {100 * e.rise():.2g} % of what was put in; "
                    f"the balance is constant within {100 * e.drift():.2g} %.")


def load(name):
    spec = importlib.util.spec_from_file_location("case_" + name, HERE / name / "case.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def cases():
    return sorted(p.parent.name for p in HERE.glob("*/case.py"))


def judge(module, values, fine):
    rows = []
    for a in module.ACCEPTANCE:
        if a.fine and not fine:
            continue
        value = values.get(a.quantity)
        rows.append({"quantity": a.quantity, "unit": a.unit, "here": value, "published": a.published(), "verdict": a.verdict(value),
                     "source": a.source, "certain": a.certain, "digits": a.digits})
    return rows


def print_table(results):
    head = ["case", "quantity", "here", "published", "", "source"]
    rows = [head]
    for name, r in results.items():
        for row in r["rows"]:
            unit = f" ({row['unit']})" if row["unit"] else ""
            rows.append([name, row["quantity"] + unit, number(row["here"], row["digits"]), row["published"],
                         row["verdict"] + ("" if row["certain"] else " (source not certain)"), row["source"]])
    widths = [max(len(r[k]) for r in rows) for k in range(len(head) - 1)]
    for r in rows:
        print("  ".join([c.ljust(w) for c, w in zip(r, widths)] + [r[-1]]))


# ---- the page ----

STYLE = ("body{font:15px/1.45 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}table{border-collapse:collapse;margin:.8em 0}"
         "td,th{border:1px solid #ccc;padding:.25em .6em;text-align:left;font-size:13px}th{background:#eee}img{max-width:100%}"
         ".no{background:#fdd}.open{background:#ffd}figcaption{font-size:13px;color:#444}figure{margin:1em 0}")


def inline(words):
    words = html.escape(words)
    words = re.sub(r"`([^`]+)`", r"<code>\1</code>", words)
    return re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", words)


def markdown(text):
    """Of a case's README.md: headings, paragraphs, lists."""
    out = []
    for block in re.split(r"\n\s*\n", text.strip()):
        if block.startswith("#"):
            level = len(block) - len(block.lstrip("#"))
            head, _, rest = block.partition("\n")
            out.append(f"<h{level + 1}>{inline(head.lstrip('# '))}</h{level + 1}>")
            block = rest
        if not block.strip():
            continue
        if block.lstrip().startswith("* "):
            items = re.split(r"\n\* ", "\n" + block.strip())[1:]
            out.append("<ul>" + "".join(f"<li>{inline(' '.join(i.split()))}</li>" for i in items) + "</ul>")
        else:
            out.append(f"<p>{inline(' '.join(block.split()))}</p>")
    return "\n".join(out)


def html_table(rows, classes=None):
    body = []
    for k, row in enumerate(rows):
        tag = "th" if k == 0 else "td"
        kind = f' class="{classes[k]}"' if classes and classes[k] else ""
        body.append(f"<tr{kind}>" + "".join(f"<{tag}>{inline(c)}</{tag}>" for c in row) + "</tr>")
    return "<table>" + "".join(body) + "</table>"


def acceptance_table(rows):
    table, classes = [["quantity", "here", "published", "", "source"]], [""]
    for r in rows:
        unit = f" ({r['unit']})" if r["unit"] else ""
        table.append([r["quantity"] + unit, number(r["here"], r["digits"]), r["published"],
                      r["verdict"] + ("" if r["certain"] else ", source not certain"), r["source"]])
        classes.append("" if r["verdict"] == "within" else "no" if r["certain"] else "open")    # known ones are red, too
    return html_table(table, classes)


def overview(results):
    """Rows of a table: per case how many of its figures are met, of certain sources and of others, and what is known not to be."""
    table = [["case", "certain sources: within", "others: within", "not within"]]
    for r in results.values():
        certain, others = ([row for row in r["rows"] if row["certain"] == c] for c in (True, False))
        within = ["-" if not rows else f"{sum(row['verdict'] == 'within' for row in rows)} of {len(rows)}" for rows in (certain, others)]
        table.append([r["title"], *within, "; ".join(row["quantity"] for row in r["rows"] if row["verdict"] != "within") or "-"])
    return table


def when(r):
    """When a case was run, and how."""
    return (f"Run on {r['date']}{' with finer meshes (--fine)' if r['fine'] else ''}: {r['processor_seconds']:.0f} s of processor time.")


def page(results, out):
    parts = [f"<!doctype html><meta charset='utf-8'><title>DEFE: verification</title><style>{STYLE}</style>",
             "<h1>DEFE held against published results</h1>",
             "<p>Made by <code>tests/verify.sh</code>. Red: not within the published figure; yellow: nor is the source certain.</p>",
             html_table(overview(results))]
    for name, r in results.items():
        parts.append(f"<h2 id='{name}'>{html.escape(r['title'])}</h2>")
        parts.append(markdown(re.sub(r"\A# .*\n", "", (HERE / name / "README.md").read_text())))
        parts.append(acceptance_table(r["rows"]))
        for kind, *what in r["shown"]:
            if kind == "text":
                parts.append(f"<p>{inline(what[0])}</p>")
            elif kind == "table":
                parts.append(f"<p>{inline(what[0])}</p>" + html_table(what[1]))
            else:
                parts.append(f"<figure><img src='{what[0]}' alt=''><figcaption>{inline(what[1])}</figcaption></figure>")
        parts.append(f"<p>{when(r)}</p>")
    (out / "index.html").write_text("\n".join(parts) + "\n")


# ---- its source in the docs: lammps-package/doc/Howto_defe_verification.rst ----

RST_HEAD = """Verification
============

What DEFE makes of published cases, beside what is published.  All of this page is written by ::

   tests/verify.sh --page

which also writes a page of its own with all plots (``build/verification/index.html``).  The cases are in
``tests/verification/manual``; nothing is tuned for one, and what a source leaves open is chosen once and said.  What does not agree stays
on the page, with the reason as far as it is found.  Times are of one processor of a virtual machine, beside other work.
Wave speeds, cantilevers, patch tests, Hertz, locking and sandwich beams have closed forms and are tested with every change
(``tests/verification/manual/README.md`` says where); more on cracks in all directions is on the page
:doc:`Cracks and the mesh <Howto_defe_cracks>`.

"""


def rst_inline(words):
    words = re.sub(r"`([^`]+)`", r"``\1``", words)
    return words.replace("|", "\\|")


def rst_text(text):
    """Of a case's README.md, without its first heading."""
    out = []
    for block in re.split(r"\n\s*\n", text.strip()):
        if block.startswith("#"):
            head, _, block = block.partition("\n")
            if head.startswith("## "):
                out.append(f"*{head.lstrip('# ')}.*")
        if not block.strip():
            continue
        if block.lstrip().startswith("* "):
            items = re.split(r"\n\* ", "\n" + block.strip())[1:]
            out.append("\n".join("* " + rst_inline(" ".join(i.split())) for i in items))
        else:
            out.append(rst_inline(" ".join(block.split())))
    return "\n\n".join(out)


def rst_cell(text):
    """Quoted; a dash alone would begin a list."""
    return r'"\-"' if text == "-" else '"' + rst_inline(text).replace('"', '""') + '"'


def rst_row(row):
    return "   " + ", ".join(rst_cell(str(c)) for c in row)


def rst_csv(rows):
    return ".. csv-table::\n   :header-rows: 1\n\n" + "\n".join(rst_row(row) for row in rows)


def rst_section(name, r, out, doc):
    """Of one case, below its heading; its pictures go into `doc`."""
    parts = [rst_text(re.sub(r"\A# .*\n", "", (HERE / name / "README.md").read_text())) + "\n"]
    head = [["quantity", "here", "published", "", "source"]]
    parts.append(rst_csv(head + [[a["quantity"] + (f" ({a['unit']})" if a["unit"] else ""), number(a["here"], a["digits"]), a["published"],
                                  a["verdict"] + ("" if a["certain"] else ", source not certain"), a["source"]] for a in r["rows"]]) + "\n")
    for kind, *what in r["shown"]:
        if kind == "table":
            parts.append(rst_inline(what[0]) + "\n\n" + rst_csv(what[1]) + "\n")
        elif kind == "figure":
            picture = f"Howto_defe_verification_{what[0].replace('/', '_')}"
            (doc / picture).write_bytes((out / what[0]).read_bytes())
            parts.append(f".. image:: {picture}\n   :alt: {what[1]}\n\n{rst_inline(what[1])}\n")
        else:
            parts.append(rst_inline(what[0]) + "\n")
    parts.append(rst_inline(when(r)).replace("--fine", "``--fine``") + "\n")
    return "\n".join(parts)


def page_sections(text):
    """{title: (line of the overview, what is below the heading)} of a page that was written before."""
    pieces = re.split(r'^(.+)\n"{3,}\n', text, flags=re.M)
    lines = {line.split('"')[1]: line for line in pieces[0].splitlines() if line.startswith('   "')}
    return {title: (lines[title], below.strip("\n") + "\n") for title, below in zip(pieces[1::2], pieces[2::2]) if title in lines}


def rst_page(results, out, doc, titles):
    """titles: {name: title} of all cases. Those that have no results keep their section of the page. Returns the names of those that have none."""
    page = doc / "Howto_defe_verification.rst"
    before = page_sections(page.read_text()) if page.exists() else {}
    missing = [name for name, title in titles.items() if name not in results and title not in before]
    if missing:
        return missing
    lines, sections = [], []
    head, *rows = overview(results)
    fresh = dict(zip(results, rows))
    for name, title in titles.items():
        if name in results:
            for old in doc.glob(f"Howto_defe_verification_{name}_*.png"):
                old.unlink()
            line, below = rst_row(fresh[name]), rst_section(name, results[name], out, doc)
        else:
            line, below = before[title]
        lines.append(line)
        sections.append(f"{title}\n{chr(34) * len(title)}\n\n{below}")
    page.write_text("\n".join([RST_HEAD, rst_csv([head]) + "\n" + "\n".join(lines) + "\n", *sections]))
    return []


def children_seconds():
    """Processor time of all runs up to now."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_case(name, options):
    """Runs it, and leaves what the pages need in its folder of results."""
    module = load(name)
    print(f"verify: {name}: {module.TITLE}", file=sys.stderr, flush=True)
    session = Session(name, options)
    before = children_seconds()
    rows = judge(module, module.run(session), options.fine)
    result = {"title": module.TITLE, "rows": rows, "shown": session.shown, "date": datetime.date.today().isoformat(), "fine": options.fine,
              "processor_seconds": children_seconds() - before, "loop_seconds": session.loops}
    session.path(RESULT).write_text(json.dumps(result, indent=1, default=float) + "\n")
    return result


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--lmp", type=os.path.abspath, required=True)
    parser.add_argument("--plugin", type=os.path.abspath, required=True, help="folder of defeplugin.so")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--fine", action="store_true", help="finer meshes, may take an hour")
    parser.add_argument("--quick", action="store_true", help="only the cases that are not marked as slow, without their finest meshes")
    parser.add_argument("--page", action="store_true", help="put the cases into lammps-package/doc, too; those that were never run here stay as they are there")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at the same time")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("case", nargs="*")
    options = parser.parse_args()
    if options.quick and (options.page or options.fine):
        parser.error("--quick leaves out the finest meshes: leave it out for the page, and with --fine")
    if options.list:
        for name in cases():
            print(f"{name:24} {load(name).TITLE}")
        return 0
    unknown = [c for c in options.case if c not in cases()]
    if unknown:
        sys.exit(f"verify: no case '{unknown[0]}': {', '.join(cases())}")
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    named = options.case or [c for c in cases() if not (options.quick and getattr(load(c), "SLOW", False))]
    results = {}
    for name in named:
        results[name] = run_case(name, options)
    failed = [f"{n}: {row['quantity']}" for n, r in results.items() for row in r["rows"] if row["certain"] and row["verdict"] == "not within"]
    print_table(results)
    stored = {n: json.loads(f.read_text()) for n in cases() if (f := options.out / n / RESULT).exists()}
    page(stored, options.out)
    if options.page:
        missing = rst_page(stored, options.out, ROOT / "lammps-package" / "doc", {n: load(n).TITLE for n in cases()})
        if missing:
            sys.exit(f"verify: {missing[0]} has not been run yet, and the page does not have it: run it, too")
    print(f"\nThe page with all plots: {options.out / 'index.html'}")
    for f in failed:
        print(f"not within: {f}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(defe.summary.main(main))
