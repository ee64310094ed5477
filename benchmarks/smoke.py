#!/usr/bin/env python3
"""smoke.py BUILD: measures every row in quick mode and checks that the report is complete.

No time is looked at. A row may have no value only for a reason that the report names."""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROWS = "kernels bricks general elastic dem adaptive two_clocks laws event event_size event_border plate front ranks size dem_size peers".split()
# where a machine may lack something: Google Benchmark, perf, a second clock, peers
MAY_BE_SKIPPED = {"kernels", "kernels_avx2", "joint_kernels", "profile_elastic", "profile_adaptive", "profile_rebuild", "profile_dem", "two_clocks", "chute", "lulesh"}


def main():
    build = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="defe-benchmarks-") as folder:
        out = Path(folder) / "out"
        page = Path(folder) / "page.md"
        page.write_text((HERE / "README.md").read_text())
        subprocess.run([sys.executable, HERE / "measure.py", "--build", build, "--out", out, "--quick", "--profile",
                        "--page", page], check=True)
        report = json.loads((out / "results.json").read_text())
        table = (out / "results.md").read_text()
        whole = page.read_text()
        assert table in whole, "the table is not in the page"
        for _ in range(2):    # one row anew, twice: the others stay, and it is said once
            subprocess.run([sys.executable, HERE / "measure.py", "--build", build, "--out", out, "--quick", "--page", page, "adaptive"],
                           check=True)
        row = [line for line in (out / "results.md").read_text().splitlines() if line.startswith("| adaptive beam")]
        after = page.read_text().splitlines()
        assert len(after) == len(whole.splitlines()) + 2 and sum(line.startswith("Rows adaptive: ") for line in after) == 1, "the page has more or less than one row anew"
        assert row and set(row) <= set(after), "the row measured anew is not in the page"

    problems = []

    def expect(condition, text):
        if not condition:
            problems.append(text)

    expect(report["quick"] is True, "not marked as quick")
    for key in ("cpu", "cores", "compiler", "flags", "build_type", "simd", "cache"):
        expect(report["machine"].get(key), f"machine: no {key}")
    expect(set(report["skipped"]) <= MAY_BE_SKIPPED, f"skipped: {report['skipped']}")
    expect([r for r in ROWS if r not in {l["row"] for l in report["lines"]}] == [], "rows are missing")
    for line in report["lines"]:
        name = f"{line['row']}: {line['what']}"
        expect(line["what"] in table, f"{name}: not in the table")
        if line["value"] is None:
            # what it needs was skipped, or it compares figures of which one was
            expect(line["note"] and any(reason in line["note"] for reason in report["skipped"].values()), f"{name}: no value and no reason")
            continue
        expect(math.isfinite(line["value"]) and line["samples"] >= 1, f"{name}: {line['value']}")
        expect(line["lowest"] <= line["value"] <= line["highest"], f"{name}: outside its range")
        if line["what"].startswith(("elastic beam: share", "the same from")):
            expect(line["value"] <= 100, f"{name}: {line['value']} %")
        elif not any(words in line["what"] for words in ("extra time", "dearest event", "elements converted", "in seconds", "less by")):
            expect(line["value"] > 0, f"{name}: {line['value']}")
        expect((line["goal"] is None) == ("reached" not in line), f"{name}: goal without verdict")
    expect(report["conversions"], "no conversion was timed")
    for name, profile in report["profiles"].items():
        expect(abs(sum(profile["shares"].values()) - 1) < 0.01, f"{name}: shares do not add up")
        expect(profile["samples"] > 0 and profile["functions"], f"{name}: empty")
    for case, samples in report["cases"].items():
        if case not in report["skipped"]:
            expect(any(samples), f"case {case}: no sample")

    for text in problems:
        print("benchmarks:", text)
    print(f"{len(report['lines'])} lines checked, {len(problems)} problems")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
