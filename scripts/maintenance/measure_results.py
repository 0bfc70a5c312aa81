#!/usr/bin/env python3
"""Measures the mean F of every selector on every dataset, and writes it to docs/data/results.json.

Usage: measure_results.py [--data_root FOLDER] [--runs FOLDER] [--check]

FOLDER (default: CORRSEL_TEST_DATA of the environment) holds the datasets vgg, symbench and adelaidermf, and raw frames of
KITTI in kitti_stereo. The run folders are kept, and a second call with the same code continues an interrupted run. Their
default is ~/.cache/corrsel/results_CODE, where CODE is the column of scripts/release_check.sh. Run scripts/generate.py after
it.

--check writes nothing. It compares what was measured with docs/data/results.json. Values are the same for any number of
threads, but other compilers and versions of OpenCV may change them.

Exit status: 0 if every pair was measured and, with --check, every value is that of the file; else 1.
"""
import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PACKAGE / "python"))

from corrsel.report.reading import read_run  # noqa: E402  (the package of this checkout)
from release_check import Problem, check_committed, fingerprint, git  # noqa: E402  (beside this file)

FILE = PACKAGE / "docs/data/results.json"
# What is run, and what docs/results.md shows as the commands of the tables.
COMMANDS = """\
selectors=every,nnsr:lowe,ransac:f,ransac:lo_prosac,usac:f,usac:frames,vfc:guided,gms:rotation_scale,lpm:v2,lpm:guided
selectors=$selectors,acransac:f,adalam:original,laf:guided,logos:opencv,frame_votes:acc,planes:first,tlinkage:motions
arguments="preselection:=none features:=sift+sift,orb+orb,hessian_affine+sift selectors:=$selectors report:=false resume:=true"
datasets=vgg,symbench,adelaidermf,heinly_generated
scripts/benchmark.sh dataset:=$datasets data_root:=$data_root $arguments output_dir:=$runs/folders
scripts/kitti_to_bag.py $data_root/kitti_stereo --output $runs/kitti.bag
cameras="left:=/stereo/left/image_raw/compressed right:=/stereo/right/image_raw/compressed"
scripts/benchmark.sh bag:=$runs/kitti.bag $cameras $arguments output_dir:=$runs/kitti
"""
TITLES = {
    "vgg": "VGG",
    "symbench": "SymBench",
    "adelaidermf": "AdelaideRMF",
    "kitti": "KITTI",
    "heinly_generated": "Heinly, generated",
}


def measure(data_root, runs):
    """Run the commands; return whether every pair was measured."""
    runs.mkdir(parents=True, exist_ok=True)
    environment = dict(os.environ, data_root=str(data_root), runs=str(runs))
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", COMMANDS], cwd=str(PACKAGE), env=environment)
    return done.returncode == 0


def columns_of(runs):
    """Return (run, group) of every column, in the order of TITLES and then of the run."""
    found = [(run, group) for run in runs for group in run.groups]
    order = list(TITLES)
    return sorted(found, key=lambda column: order.index(column[1].dataset))


def results_of(runs):
    """Return what results.json holds."""
    columns = columns_of(runs)
    environment = runs[0].environment
    f_percent = {}
    for selector in runs[0].selectors:
        rows = [run.mean(group, selector, run.tau(group)) for run, group in columns]
        f_percent[selector] = [None if row is None else round(100 * row["f_paper"], 1) for row in rows]
    return {
        "commit": environment["corrsel_commit"],
        "machine": "%(cpu)s, %(compiler)s, OpenCV %(opencv)s" % environment,
        "command": COMMANDS.splitlines(),
        "columns": [
            {
                "dataset": TITLES[group.dataset],
                "features": "given matches" if group.features == "given" else group.features,
                "pairs": run.pair_count(group),
            }
            for run, group in columns
        ],
        "f_percent": f_percent,
    }


def as_text(results):
    """Return the JSON with one line for each command, column and selector, so that changes can be read."""

    def lines(values):
        return ",\n".join("    " + json.dumps(value) for value in values)

    head = "".join(
        "  %s: %s,\n" % (json.dumps(key), json.dumps(results[key])) for key in ("commit", "machine")
    )
    rows = ",\n".join(
        "    %s: %s" % (json.dumps(name), json.dumps(row)) for name, row in results["f_percent"].items()
    )
    return '{\n%s  "command": [\n%s\n  ],\n  "columns": [\n%s\n  ],\n  "f_percent": {\n%s\n  }\n}\n' % (
        head,
        lines(results["command"]),
        lines(results["columns"]),
        rows,
    )


def differences(results, stored):
    """Return a line for every value that differs between two results."""
    if results["columns"] != stored["columns"]:
        return ["other datasets, features or numbers of pairs: %s" % results["columns"]]
    new, old = results["f_percent"], stored["f_percent"]
    lines = ["%s: only in one of the results" % name for name in sorted(set(new) ^ set(old))]
    for name in (name for name in new if name in old):
        for column, value, before in zip(results["columns"], new[name], old[name]):
            if value != before:
                place = "%s, %s, %s" % (name, column["dataset"], column["features"])
                lines.append("%s: %s instead of %s" % (place, value, before))
    return lines


def default_runs():
    """Return the folder of the runs of HEAD's code; raise Problem where the sources differ from it."""
    check_committed()
    cache = Path(os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))) / "corrsel"
    return cache / ("results_" + fingerprint(git("ls-tree", "-r", "HEAD")))


def main():
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS
    )
    parser.add_argument("--data_root", type=Path, default=os.environ.get("CORRSEL_TEST_DATA"))
    parser.add_argument("--runs", type=Path)
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    if arguments.data_root is None:
        parser.error("give the folder of the datasets with --data_root")
    try:
        folder = (arguments.runs or default_runs()).resolve()
    except Problem as problem:
        parser.error(str(problem))
    if not measure(Path(arguments.data_root).resolve(), folder):
        print("measure_results.py: the runs in %s are not complete; call it again" % folder, file=sys.stderr)
        return 1
    results = results_of([read_run(folder / name) for name in ("folders", "kitti")])
    if not arguments.check:
        FILE.write_text(as_text(results), encoding="utf-8")
        print("wrote %s" % FILE)
        return 0
    lines = differences(results, json.loads(FILE.read_text(encoding="utf-8")))
    print("\n".join(lines + ["%d values differ from those of %s" % (len(lines), FILE.relative_to(PACKAGE))]))
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
