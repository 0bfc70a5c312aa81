#!/usr/bin/env python3
"""Write a made-up run folder of any size, to measure what reading it costs.

Usage: large_run.py FOLDER [--pairs N] [--datasets N] [--selectors N] [--tolerances N]

The folder holds pairs.csv with a row for each pair and selector, summary.csv, stages.csv, config.yaml. Every row
passes the checks of compare_runs. The same arguments always give
the same bytes. The rows lie in the order of a finished run.
"""
import argparse
import csv
import json
import sys
from pathlib import Path

import numpy as np

from corrsel.report.groups import GROUPS
from corrsel.report.reading import (
    PAIRS_FORMAT,
    PAIRS_VERSION,
    STAGES_HEADER,
    SUMMARY_HEADER,
    at_tolerance,
    average_by_pair,
    pairs_header,
    read_run,
)

BASELINE = "keep_all"
MEANS = ("precision", "recall_paper", "f_paper", "recall_same_tau", "f_same_tau")
STAGES = ("read", "features", "match", "select", "evaluate")


def selector_names(count):
    """Return as many names of selectors, the baseline last; after the known ones come presets."""
    known = [name for names in GROUPS.values() for name in names if name != BASELINE]
    names = (known + ["%s:v%d" % (name, i) for i in range(2, 9) for name in known])[: count - 1]
    return names + [BASELINE]


def pair_lines(random, names, selectors, tolerances):
    """Return the lines of pairs.csv of one pair."""
    putative = int(random.integers(200, 3000))
    # One pair in a hundred has no correct match.
    inliers = 0 if random.random() < 0.01 else int(putative * random.uniform(0.1, 0.9))
    left, right = putative, int(random.integers(200, 3000))
    near = [inliers * (i + 1) // len(tolerances) for i in range(len(tolerances))]
    times = ",".join("%.6f" % t for t in random.uniform(0.01, 0.1, 3))
    head = ",".join(names) + ",sift+sift,none,"
    out = []
    for k, selector in enumerate(selectors):
        # Each selector has a quality of its own, and luck on each pair.
        keep = 1.0 if selector == BASELINE else float(random.beta(2 + k % 7, 2))
        wrong = 1.0 if selector == BASELINE else float(random.beta(1, 3 + k % 5))
        selected = int(inliers * keep) + int((putative - inliers) * wrong)
        correct = [min(int(within * keep), selected) for within in near]
        cells = ["homography", left, right, putative, inliers] + near + [selected, ""] + correct
        end = ",ok,unknown,%s,1,%s,%s" % (
            repr(float(random.exponential(20))),
            times,
            repr(0.001 * (k + 1) * keep),
        )
        out.append("%s%s,%s%s\n" % (head, selector, ",".join(map(str, cells)), end))
    return "".join(out)


def write_summary(folder):
    """Write summary.csv from pairs.csv; the intervals are those of a normal distribution."""
    run = read_run(folder)
    with (folder / "summary.csv").open("w", newline="") as stream:
        writer = csv.DictWriter(stream, SUMMARY_HEADER, lineterminator="\n")
        writer.writeheader()
        for group in run.groups:
            for selector in run.pairs.selectors_of(group):
                rows = run.rows(group, selector)
                for tau in run.taus(group):
                    chosen = at_tolerance(rows, tau)
                    means = {
                        c: average_by_pair(rows, c, chosen & (rows["n_ground_truth"] > 0)) for c in MEANS
                    }
                    f = means["f_paper"][np.isfinite(means["f_paper"])]
                    margin = 1.96 * f.std() / len(f) ** 0.5
                    row = dict(group._asdict(), selector=selector, tau_px="%g" % tau, pairs=len(f))
                    row.update((column, np.nanmean(values)) for column, values in means.items())
                    row.update(f_paper_lo=f.mean() - margin, f_paper_hi=f.mean() + margin)
                    row.update(confidence_median=np.median(rows["confidence"][chosen]))
                    row.update(select_s_median=np.median(rows["select_s"][chosen]))
                    row.update(select_s_p95=np.percentile(rows["select_s"][chosen], 95))
                    writer.writerow(row)


def write_run(folder, pairs=40, datasets=2, selectors=4, tolerances=3):
    """Write the folder; return the number of rows of pairs.csv."""
    folder.mkdir(parents=True, exist_ok=True)
    random, rows = np.random.default_rng(1), 0
    names, taus = selector_names(selectors), list(range(1, tolerances + 1))
    taus[min(4, len(taus) - 1)] = 5  # the tolerance of the tables
    with (folder / "pairs.csv").open("w") as table, (folder / "stages.csv").open("w") as stages:
        table.write("%s%d\n" % (PAIRS_FORMAT, PAIRS_VERSION))
        table.write(",".join(pairs_header(taus)) + "\n")
        stages.write(",".join(STAGES_HEADER) + "\n")
        for number in range(pairs):
            dataset = number * datasets // pairs
            pair = ("large_%d" % dataset, "scene_%03d" % (number % 97), "%d-%d" % (number, number + 1))
            table.write(pair_lines(random, pair, names, taus))
            rows += len(names)
            for stage in STAGES:
                stages.write("%d,%s,%s,%.4f\n" % (number + 1, ",".join(pair), stage, random.random()))
    (folder / "config.yaml").write_text(
        "datasets: [%s]\nseed: 1\n" % ", ".join("large_%d" % d for d in range(datasets))
    )
    state = {"complete": True, "pairs_done": pairs, "pairs_total": pairs}
    (folder / "summary.json").write_text(json.dumps({"state": state}))
    write_summary(folder)
    return rows


def main(arguments=None):
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", metavar="FOLDER", type=Path)
    parser.add_argument("--pairs", type=int, default=40, metavar="N")
    parser.add_argument("--datasets", type=int, default=2, metavar="N")
    parser.add_argument("--selectors", type=int, default=4, metavar="N", help="the baseline among them")
    parser.add_argument("--tolerances", type=int, default=3, metavar="N")
    options = parser.parse_args(arguments)
    rows = write_run(options.folder, options.pairs, options.datasets, options.selectors, options.tolerances)
    print("%s: %d rows" % (options.folder / "pairs.csv", rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
