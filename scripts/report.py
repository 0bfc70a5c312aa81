#!/usr/bin/env python3
"""Turn the folder of a benchmark run into one self-contained HTML file.

Usage: report.py RUN_FOLDER [--output FILE]

Reads pairs.csv (needed) and, where present, summary.csv, summary.json, environment.json, config.yaml,
failures.csv, stages.csv, scaling.csv and images/index.csv. Tables and curves show the numbers of summary.csv;
pairs.csv gives the values per pair, the counts and the failures. Figures are also written as files below
RUN_FOLDER/figures. The same folder always gives the same bytes.
Exit status: 0 written, 2 unusable input.
"""
import argparse
import os
import sys
import tempfile
from pathlib import Path
from urllib.parse import quote

# The package lies beside this file, in the source tree as in the install space.
sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from corrsel_report.page import build  # noqa: E402  (found through the path above)
from corrsel_report.inference import ProgramError  # noqa: E402
from corrsel_report.reading import ReportError, read_run  # noqa: E402

LARGE_BYTES = 8e6  # above this a remark goes to stderr


def write_atomically(path, text):
    """Write a file so that readers see the old one or the whole new one."""
    mask = os.umask(0)
    os.umask(mask)
    try:
        handle, temporary = tempfile.mkstemp(prefix=".report-", suffix=".tmp", dir=str(path.parent))
    except OSError as error:
        raise ReportError(
            "%s: cannot be written (%s). Remedy: give another file with --output." % (path, error.strerror)
        )
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n", errors="replace") as stream:
            stream.write(text)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, str(path))
    except OSError as error:
        os.unlink(temporary)
        raise ReportError(
            "%s: cannot be written (%s). Remedy: give another file with --output." % (path, error.strerror)
        )
    except BaseException:
        os.unlink(temporary)
        raise


def link_between(page_folder, run_folder):
    """Return the relative link from the page's folder to the run's: "" or a path that ends in "/"."""
    path = os.path.relpath(os.path.realpath(str(run_folder)), os.path.realpath(str(page_folder)))
    return "" if path == "." else quote(path.replace(os.sep, "/")) + "/"


def figures_folder(run):
    """Return the folder for the figures' files; None, with a note, where it cannot be written to."""
    folder = run.folder / "figures"
    try:
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=str(folder)):
            return folder
    except OSError as error:
        run.notes.append(
            "The figures were not written as files: %s cannot be written (%s)."
            % (folder.name, error.strerror)
        )
        return None


def main(arguments=None):
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        description="Turn the folder of a benchmark run into one self-contained HTML file."
    )
    parser.add_argument(
        "run_folder", metavar="RUN_FOLDER", help="output folder of a benchmark run; holds pairs.csv"
    )
    parser.add_argument("--output", metavar="FILE", help="file to write (default: RUN_FOLDER/report.html)")
    options = parser.parse_args(arguments)
    folder = Path(options.run_folder)
    try:
        run = read_run(folder)
        output = Path(options.output) if options.output else folder / "report.html"
        run.link = link_between(output.parent, folder)
        try:
            text = build(run, figures_folder(run))
        except OSError as error:
            raise ReportError(
                "%s: %s. Remedy: check the folder's permissions and the space left."
                % (error.filename or folder, error.strerror)
            )
        write_atomically(output, text)
    except (ReportError, ProgramError) as error:
        print("report.py: error: %s" % error, file=sys.stderr)
        return 2
    if len(text) > LARGE_BYTES:
        print(
            "report.py: note: %s has %.1f MB, mostly example images" % (output, len(text) / 1e6),
            file=sys.stderr,
        )
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
