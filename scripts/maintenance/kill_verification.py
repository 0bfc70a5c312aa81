#!/usr/bin/env python3
"""Kills corrsel_verify at random moments, continues it, and compares the rows with those of a run that was left alone.

Usage: kill_verification.py [--kills N] [--seed N] PROGRAM DATABASE [ARGUMENT]...

Writes DATABASE.whole and DATABASE.killed beside the database, which must not exist, and removes them at the end. The
moments are distributed evenly over the time that the undivided run took. Exit status: 0 if all rows are the same, else 1.
"""
import argparse
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path


def rows(path):
    """Return all rows of two_view_geometries of a database of COLMAP."""
    database = sqlite3.connect(str(path))
    found = database.execute("SELECT * FROM two_view_geometries ORDER BY pair_id").fetchall()
    database.close()
    return found


def command(options, output):
    """Return the command that writes an output."""
    return [str(options.program), str(options.database), "--output", str(output), *options.arguments]


def kill_often(options, seconds, killed):
    """Start the program again and again, and kill it; return the numbers of rows that the kills left."""
    part = Path(str(killed) + ".part")
    stored = []
    for _ in range(options.kills):
        process = subprocess.Popen(
            command(options, killed), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(options.random.uniform(0, 2 * seconds / (options.kills + 1)))
        process.send_signal(signal.SIGKILL)
        process.wait()
        if killed.exists():
            break
        stored.append(len(rows(part)) if part.exists() else 0)
    return stored


def parser():
    """Return the parser of the command line."""
    out = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    out.add_argument("program", metavar="PROGRAM", type=Path)
    out.add_argument("database", metavar="DATABASE", type=Path)
    out.add_argument("arguments", metavar="ARGUMENT", nargs=argparse.REMAINDER, help="of the program")
    out.add_argument("--kills", type=int, default=20)
    out.add_argument("--seed", type=int, default=1)
    return out


def main():
    """Run the command line; return the exit status."""
    options = parser().parse_args()
    options.random = random.Random(options.seed)
    whole, killed = (Path(str(options.database) + ending) for ending in (".whole", ".killed"))
    begin = time.monotonic()
    subprocess.run(command(options, whole), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    seconds = time.monotonic() - begin
    stored = kill_often(options, seconds, killed)
    if not killed.exists():
        subprocess.run(command(options, killed), check=True, stderr=subprocess.DEVNULL)
    same = rows(whole) == rows(killed)
    print("%d rows; undivided run: %.1f s; rows after each kill: %s" % (len(rows(whole)), seconds, stored))
    print("the rows are %s" % ("the same" if same else "DIFFERENT"))
    whole.unlink()
    killed.unlink()
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
