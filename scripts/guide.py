#!/usr/bin/env python3
"""Print which selectors are superior and inferior in each scenario of a benchmark run, beside the paper's table.

Usage: guide.py [--choices] RUN_FOLDER

Reads pairs.csv (needed) and scaling.csv; writes RUN_FOLDER/guide.csv and prints the guide as plain text. The same
folder always gives the same bytes. With --choices it prints another table instead, as Markdown, and writes nothing:
for each dataset the best of all selectors of the run, those that cannot be separated from it, and faster ones. Exit status: 0 done, 2 unusable input.
"""
import argparse
import csv
import io
import os
import sys
from pathlib import Path

# The package lies beside this file, in the source tree as in the install space.
sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from corrsel_report import guide  # noqa: E402  (found through the path above)
from corrsel_report.inference import ProgramError  # noqa: E402
from corrsel_report.reading import ReportError, read_run  # noqa: E402


def write_csv(path, rows):
    """Write guide.csv so that readers see the old file or the whole new one."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, guide.GUIDE_HEADER, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    temporary = path.with_name(".guide-%d.tmp" % os.getpid())
    try:
        with open(temporary, "w", encoding="utf-8", errors="replace", newline="\n") as file:
            file.write(stream.getvalue())
        os.replace(str(temporary), str(path))
    except OSError as error:
        if temporary.exists():
            temporary.unlink()
        raise ReportError(
            "%s: cannot be written (%s). Remedy: check the folder's permissions and the space left."
            % (path, error.strerror)
        )


def main(arguments=None):
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        description="Print superior and inferior selectors of each scenario of a benchmark run."
    )
    parser.add_argument(
        "run_folder", metavar="RUN_FOLDER", help="output folder of a benchmark run; holds pairs.csv"
    )
    parser.add_argument(
        "--choices",
        action="store_true",
        help="print a Markdown table with the best and the fastest selectors of each dataset instead; writes nothing",
    )
    parsed = parser.parse_args(arguments)
    folder = Path(parsed.run_folder)
    try:
        run = read_run(folder)
        if parsed.choices:
            print(guide.choices_markdown(run), end="")
            return 0
        rows = guide.derive(run)
        write_csv(folder / "guide.csv", guide.csv_rows(rows))
    except (ReportError, ProgramError) as error:
        print("guide.py: error: %s" % error, file=sys.stderr)
        return 2
    print(guide.text(run, rows), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
