#!/usr/bin/env python3
"""Print the results of a benchmark run as text: the winners of each dataset, and what limits the comparison.

Usage: print_results.py [--all] RUN_FOLDER

Reads pairs.csv (needed), summary.csv, failures.csv and remarks.csv and writes nothing. With --all it prints the table
of all selectors for each dataset, kind of features and preselection, too.
Exit status: 0 printed, 2 unusable input.
"""
import argparse
import os
import sys
from pathlib import Path

# The package lies beside this file, in the source tree as in the install space.
sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from corrsel_report import terminal  # noqa: E402  (found through the path above)
from corrsel_report.reading import ReportError, read_run  # noqa: E402


def main(arguments=None):
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(description="Print the results of a benchmark run as text.")
    parser.add_argument(
        "run_folder", metavar="RUN_FOLDER", help="output folder of a benchmark run; holds pairs.csv"
    )
    parser.add_argument("--all", action="store_true", help="print the tables of all selectors, too")
    options = parser.parse_args(arguments)
    try:
        text = terminal.text(read_run(Path(options.run_folder)), options.all)
    except ReportError as error:
        print("print_results.py: error: %s" % error, file=sys.stderr)
        return 2
    # A terminal may know fewer characters than the names of datasets have.
    encoding = sys.stdout.encoding or "ascii"
    print(text.encode(encoding, errors="replace").decode(encoding))
    return 0


if __name__ == "__main__":
    sys.exit(main())
