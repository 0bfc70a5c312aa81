#!/usr/bin/env python3
"""Runs every check of a release on one commit, and prints a table of their results.

    scripts/release_check.sh [--list] [--again] [--steps FILE] [STEP]...

Without STEP, it runs those steps that have not passed with the code of HEAD. They are listed in
scripts/maintenance/release_steps.yaml and take many hours together, so a release is checked in pieces: every result is a
row of docs/data/release.csv, which you commit, and the next call goes on with what is missing, on another machine, too.
Ctrl-C or SIGTERM ends the step that is running and leaves the rows of the others.

    --list         run nothing, print the table
    --again        run steps that have passed, too
    --steps FILE   another list of steps, with `name`, `command`, `summary` and, for a step in pieces, `parts`

Each step runs in a fresh clone of HEAD, which is kept if the step fails. Its output goes to
~/.cache/corrsel/release/STEP.log. The column `code` of the table identifies the tree without the documentation: commits
that differ in texts, pictures and data of docs/ alone share it.

Exit code: 0 every step has passed with the code of HEAD, 1 a step failed, is missing or ran with other code, 2 wrong
arguments or uncommitted changes, 130 interrupted.
"""

import argparse
import csv
import datetime
import hashlib
import os
import pathlib
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import yaml

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
TABLE = "docs/data/release.csv"
COLUMNS = ["step", "result", "seconds", "summary", "commit", "code", "date", "machine"]
DOCUMENTATION = re.compile(r"^(docs/|README\.md$|CHANGELOG\.rst$|CONTRIBUTING\.md$|CITATION\.cff$)")
MAX_SUMMARY = 100  # characters


class Problem(Exception):
    """An error that the user can correct; the text contains the remedy."""


def git(*arguments):
    """Return what git prints in the package's folder."""
    return subprocess.run(
        ["git", "-C", str(PACKAGE), *arguments], check=True, stdout=subprocess.PIPE, universal_newlines=True
    ).stdout


def fingerprint(tree):
    """Return 12 hex digits that identify the files of `git ls-tree -r` which are no documentation."""
    lines = [line for line in tree.splitlines() if not DOCUMENTATION.match(line.split("\t", 1)[1])]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:12]


def check_committed():
    """Raise where a file that is no documentation differs from HEAD."""
    changed = [line[3:] for line in git("status", "--porcelain").splitlines()]
    changed = [name for name in changed if not DOCUMENTATION.match(name)]
    if changed:
        raise Problem("%s is not committed; commit it, because results belong to a commit" % changed[0])


def read_steps(path):
    """Return the list of steps, where each part of a divided step is a step of its own."""
    try:
        steps = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise Problem("%s cannot be read (%s); give a list of steps" % (path, error)) from error
    for step in steps:
        if not isinstance(step, dict) or set(step) - {"parts"} != {"name", "command", "summary"}:
            raise Problem("%s: a step has `name`, `command` and `summary`, not %s" % (path, step))
        parts = step.get("parts", 1)
        if not isinstance(parts, int) or parts < 1:
            raise Problem("%s: `parts` of %s is %s; give a number from 1" % (path, step["name"], parts))
    return [part for step in steps for part in parts_of(step)]


def parts_of(step):
    """Return the steps NAME_1, NAME_2, ... of a divided step, or the step itself."""
    if "parts" not in step:
        return [step]
    return [
        dict(
            step,
            name="%s_%d" % (step["name"], index + 1),
            command="GTEST_TOTAL_SHARDS=%d GTEST_SHARD_INDEX=%d %s" % (step["parts"], index, step["command"]),
        )
        for index in range(step["parts"])
    ]


def read_table(path):
    """Return the rows by step."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {row["step"]: row for row in csv.DictReader(file)}


def write_table(path, steps, rows):
    """Write the rows in the order of the steps, in one go: a kill leaves the former table."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".new")
    with draft.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows[step["name"]] for step in steps if step["name"] in rows)
    os.replace(str(draft), str(path))


def machine():
    """Return the processor and the number of cores."""
    names = re.findall(
        r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.M
    )
    return "%d x %s" % (os.cpu_count(), names[0] if names else platform.machine())


def run_command(command, clone, log):
    """Return the exit code of a command whose output goes to a file. What it builds lies beside the clone."""
    with log.open("w", encoding="utf-8") as file:
        with subprocess.Popen(
            ["bash", "-c", command],
            cwd=str(clone),
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env=dict(os.environ, CORRSEL_BUILD_DIR=str(clone.parent / "products")),
        ) as process:
            try:
                return process.wait()
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGTERM)  # SIGINT is ignored by what runs in the background


def summary_of(log, pattern):
    """Return the last line of a log that matches, without colours."""
    lines = [
        re.sub(r"\x1b\[[0-9;]*m", "", line).strip() for line in log.read_text(errors="replace").splitlines()
    ]
    found = [line for line in lines if re.search(pattern, line)]
    return found[-1][:MAX_SUMMARY] if found else ""


def run_step(step, logs):
    """Run a step in a fresh clone of HEAD and return its row."""
    commit = git("rev-parse", "HEAD").strip()
    log = logs / (step["name"] + ".log")
    print("== %s: %s (log: %s)" % (step["name"], step["command"], log), flush=True)
    folder = pathlib.Path(tempfile.mkdtemp(prefix="clone_", dir=str(logs)))
    begin = time.monotonic()
    code = None
    try:
        clone = folder / "corrsel"
        subprocess.run(["git", "clone", "-q", str(PACKAGE), str(clone)], check=True)
        subprocess.run(["git", "-C", str(clone), "checkout", "-q", commit], check=True)
        code = run_command(step["command"], clone, log)
    finally:
        if code:
            print("   the clone and what it built stay in %s" % folder, flush=True)
        else:
            shutil.rmtree(str(folder), ignore_errors=True)
    return {
        "step": step["name"],
        "result": "passed" if code == 0 else "failed (exit code %d)" % code,
        "seconds": "%.0f" % (time.monotonic() - begin),
        "summary": summary_of(log, step["summary"]),
        "commit": commit[:12],
        "code": fingerprint(git("ls-tree", "-r", commit)),
        "date": datetime.date.today().isoformat(),
        "machine": machine(),
    }


def faults_of(steps, rows, code):
    """Return why the release is not complete, a sentence for each step concerned."""
    faults = []
    for name in (step["name"] for step in steps):
        if name not in rows:
            faults.append("%s has not run" % name)
        elif rows[name]["result"] != "passed":
            faults.append("%s %s" % (name, rows[name]["result"]))
        elif rows[name]["code"] != code:
            faults.append("%s ran with other code: commit %s" % (name, rows[name]["commit"]))
    return faults


def print_table(steps, rows, code):
    """Print a line for each step, and what is missing. Return whether the release is complete."""
    print("\n%-20s %-22s %8s  %-13s %s" % ("step", "result", "seconds", "commit", "summary"))
    for name in (step["name"] for step in steps):
        row = rows.get(name, dict.fromkeys(COLUMNS, "-"))
        print(
            "%-20s %-22s %8s  %-13s %s" % (name, row["result"], row["seconds"], row["commit"], row["summary"])
        )
    faults = faults_of(steps, rows, code)
    if faults:
        print("\nThe release is not complete:\n  " + "\n  ".join(faults))
    else:
        print("\nEvery step has passed with the code of HEAD.")
    return not faults


def main(arguments):
    """Run what is asked for and return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, prog="release_check.sh"
    )
    parser.add_argument("--list", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--again", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument(
        "--steps",
        type=pathlib.Path,
        default=PACKAGE / "scripts/maintenance/release_steps.yaml",
        help=argparse.SUPPRESS,
    )
    parser.add_argument("names", nargs="*", metavar="STEP", help=argparse.SUPPRESS)
    chosen = parser.parse_args(arguments)
    steps = read_steps(chosen.steps)
    names = [step["name"] for step in steps]
    for name in chosen.names:
        if name not in names:
            raise Problem("unknown step '%s'; valid: %s" % (name, ", ".join(names)))
    table = PACKAGE / TABLE
    rows = read_table(table)
    code = fingerprint(git("ls-tree", "-r", "HEAD"))
    if not chosen.list:
        check_committed()
        logs = (
            pathlib.Path(os.environ.get("XDG_CACHE_HOME", str(pathlib.Path.home() / ".cache")))
            / "corrsel/release"
        )
        logs.mkdir(parents=True, exist_ok=True)
        for step in steps:
            name = step["name"]
            if chosen.names and name not in chosen.names:
                continue
            if not chosen.again and not faults_of([step], rows, code):
                continue
            row = run_step(step, logs)
            rows = dict(read_table(table), **{name: row})  # another call may have written meanwhile
            write_table(table, steps, rows)
            print("   %(result)s after %(seconds)s s: %(summary)s" % rows[name], flush=True)
    return 0 if print_table(steps, rows, code) else 1


if __name__ == "__main__":
    # In the background SIGINT is ignored, and SIGTERM would leave the step running.
    for ending in (signal.SIGINT, signal.SIGTERM):
        signal.signal(ending, signal.default_int_handler)
    try:
        sys.exit(main(sys.argv[1:]))
    except Problem as problem:
        print("release_check.sh: %s" % problem, file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("release_check.sh: interrupted; the same command goes on", file=sys.stderr)
        sys.exit(130)
