#!/usr/bin/env python3
"""Measures how the processor time, the memory and the files of corrsel_verify grow with the number of pairs.

Usage: measure_scale.py [--sizes N,N...] [--parts N] [--csv FILE] PROGRAM

Generates a database of every size with generate_database.py, and verifies it on one thread: undivided, in parts that are
then merged, and the part of a single pair, which shows what beginning a part takes. Writes a row for every step; docs/scale.md
is made from it by scripts/generate.py. Processor times hardly depend on what else the machine does, so no wall time is kept.
The databases lie in a temporary folder (TMPDIR), about 4 kB a pair three times over. Exit status: 0 if the merged
rows are those of the undivided run, else 1.
"""
import argparse
import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
MATCHES, TRUE_SHARE = 370, 0.41
COLUMNS = (
    "commit",
    "machine",
    "pairs",
    "matches",
    "true_share",
    "parts",
    "step",
    "command",
    "processor_s",
    "memory_mib",
    "database_bytes",
    "written_bytes",
    "checksum",
)


def machine():
    """Return the name of the processor."""
    names = re.findall(r"^model name\s*: (.+)$", Path("/proc/cpuinfo").read_text("utf-8"), flags=re.M)
    return names[0] if names else "unknown"


def commit():
    """Return the commit of the sources, or "unknown" where they or git are missing."""
    if shutil.which("git") is None:
        return "unknown"
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    return done.stdout.decode().strip() or "unknown"


def measured(command):
    """Run a command; return its processor time in s, the largest memory in MiB, and its checksum of the rows."""
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen([str(word) for word in command], stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = status
        output.seek(0)
        text = output.read()
    checksum = re.search(r"checksum of the rows +([0-9a-f]{16})", text)
    if status != 0 or not checksum:
        sys.exit("measure_scale.py: error: %s failed:\n%s" % (" ".join(map(str, command)), text))
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, checksum.group(1)


def step(name, program, database, output, arguments, parts=1):
    """Run the program, once for each of the parts, whose number takes the place of PART; return the row of the step."""
    row = dict(step=name, database_bytes=database.stat().st_size, written_bytes=0)
    shown = ["corrsel_verify", database, "--output", output, "--threads", "1", *arguments]
    row["command"] = " ".join(map(str, shown)).replace(str(database.parent) + "/", "")
    seconds = memory = 0.0
    for i in range(1, parts + 1):
        words = [str(word).replace("PART", str(i)) for word in shown[1:]]
        time, peak, row["checksum"] = measured([program, *words])
        seconds, memory = seconds + time, max(memory, peak)
        row["written_bytes"] += Path(words[2]).stat().st_size
    if parts > 1:
        row["checksum"] = ""
    return dict(row, processor_s="%.3f" % seconds, memory_mib="%.1f" % memory)


def steps(program, folder, pairs, parts):
    """Yield the row of every step with one database."""
    database = folder / "database.db"
    generate = [
        sys.executable,
        PACKAGE / "scripts" / "maintenance" / "generate_database.py",
        "--pairs",
        pairs,
    ]
    generate += ["--matches", MATCHES, "--true-share", TRUE_SHARE, database]
    subprocess.run([str(word) for word in generate], check=True)
    undivided = step("undivided", program, database, folder / "whole.db", [])
    yield undivided
    yield step("begin", program, database, folder / "single.db", ["--shard", "1/%d" % pairs])
    yield step("parts", program, database, folder / "partPART.db", ["--shard", "PART/%d" % parts], parts)
    files = ",".join(str(folder / ("part%d.db" % i)) for i in range(1, parts + 1))
    merged = step("merge", program, database, folder / "merged.db", ["--merge", files])
    if merged["checksum"] != undivided["checksum"]:
        sys.exit(
            "measure_scale.py: error: with %d pairs, the merged rows are not those of the undivided run"
            % pairs
        )
    yield merged


def parser():
    """Return the parser of the command line."""
    out = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    out.add_argument("program", metavar="PROGRAM", type=Path, help="corrsel_verify")
    out.add_argument(
        "--sizes", default="1000,4000,16000,64000", help="numbers of pairs [1000,4000,16000,64000]"
    )
    out.add_argument("--parts", type=int, default=8, help="parts of the divided runs [8]")
    out.add_argument(
        "--csv", type=Path, default=PACKAGE / "docs" / "data" / "scale.csv", help="file to write"
    )
    return out


def main():
    """Run the command line."""
    options = parser().parse_args()
    where = dict(zip(COLUMNS, (commit(), machine())))
    rows = []
    for pairs in map(int, options.sizes.split(",")):
        with tempfile.TemporaryDirectory(prefix="corrsel_scale_") as folder:
            for row in steps(options.program, Path(folder), pairs, options.parts):
                fixed = dict(where, pairs=pairs, matches=MATCHES, true_share=TRUE_SHARE, parts=options.parts)
                rows.append(dict(fixed, **row))
                print(pairs, row["step"], row["processor_s"], "s", row["memory_mib"], "MiB", flush=True)
    with options.csv.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
