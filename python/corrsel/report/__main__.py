"""Prints the results of a benchmark run and writes its report, one self-contained HTML file.

Usage: python3 -m corrsel.report [--all] [--guide] [--no-page] [--output FILE] [--export FORM]... RUN_FOLDER
       python3 -m corrsel.report --choices RUN_FOLDER

Reads the files of the run, of which pairs.csv is needed (docs/evaluation.md describes them). Prints the winners, and the
guide where the run's experiment has one, which is also written to RUN_FOLDER/guide.csv. The page shows the numbers of
summary.csv; its figures are also written as files to RUN_FOLDER/figures. The same folder always gives the same bytes.
Exit status: 0 if everything could be made, else 2.
"""
import argparse
import csv
import io
import os
import sys
import tempfile
from pathlib import Path
from urllib.parse import quote

from ..files import __main__ as export_matches
from .tables import ReportError

LARGE_BYTES = 8e6  # above this size of the page a remark goes to stderr
PROGRAM = "corrsel.report"


def write_atomically(path, text, remedy):
    """Write a file so that readers see the old one or the whole new one; ReportError where that fails."""
    mask = os.umask(0)
    os.umask(mask)
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(prefix=".%s-" % path.stem, suffix=".tmp", dir=str(path.parent))
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n", errors="replace") as stream:
            stream.write(text)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, str(path))
        temporary = None
    except OSError as error:
        raise ReportError(
            "%s: cannot be written (%s). Remedy: %s." % (path, error.strerror, remedy)
        ) from error
    finally:
        if temporary:
            os.unlink(temporary)


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


def show(text):
    """Print a text; a terminal may know fewer characters than the names of datasets have."""
    encoding = sys.stdout.encoding or "ascii"
    print(text.encode(encoding, errors="replace").decode(encoding), flush=True)


def print_results(run, options):
    """Print the winners; with --all the tables of all selectors, too."""
    from . import terminal

    show(terminal.text(run, options.all))


def print_choices(run, _):
    """Print the choice among all selectors as Markdown."""
    from . import guide

    show(guide.choices_markdown(run).rstrip("\n"))


def make_guide(run, _):
    """Write guide.csv and print the guide."""
    from . import guide

    rows = guide.derive(run)
    stream = io.StringIO()
    writer = csv.DictWriter(stream, guide.GUIDE_HEADER, lineterminator="\n")
    writer.writeheader()
    writer.writerows(guide.csv_rows(rows))
    remedy = "check the folder's permissions and the space left"
    write_atomically(run.folder / "guide.csv", stream.getvalue(), remedy)
    show(guide.text(run, rows).rstrip("\n"))


def write_page(run, options):
    """Write the page and print its path."""
    from .page import build

    output = Path(options.output) if options.output else run.folder / "report.html"
    run.link = link_between(output.parent, run.folder)
    try:
        text = build(run, figures_folder(run))
    except OSError as error:
        raise ReportError(
            "%s: %s. Remedy: check the folder's permissions and the space left."
            % (error.filename or run.folder, error.strerror)
        ) from error
    write_atomically(output, text, "give another file with --output")
    if len(text) > LARGE_BYTES:
        note = "%s: note: %s has %.1f MB, mostly example images"
        print(note % (PROGRAM, output, len(text) / 1e6), file=sys.stderr)
    show(str(output))


def succeeded(work, *arguments):
    """Tell whether work(*arguments) could be done; print the reason where it could not."""
    try:
        work(*arguments)
        return True
    except ReportError as error:
        print("%s: error: %s" % (PROGRAM, error), file=sys.stderr)
    except ModuleNotFoundError as error:
        if error.name not in ("jinja2", "markupsafe", "matplotlib", "numpy", "yaml"):
            raise
        remedy = "apt install python3-%s" % error.name
        print("%s: error: needs the Python package %s: %s" % (PROGRAM, error.name, remedy), file=sys.stderr)
    return False


def export(form, folder):
    """Convert the saved matches of a run to another form; ReportError where that fails."""
    if export_matches.main(["--format", form, str(folder)]) != 0:
        command = "python3 -m corrsel.files --format %s %s" % (form, folder)
        raise ReportError(
            "the matches could not be written as %s. Remedy: see above, then run %s" % (form, command)
        )


def parser():
    """Return the parser of the command line."""
    out = argparse.ArgumentParser(
        prog=PROGRAM, description="Print the results of a benchmark run and write its report."
    )
    out.add_argument("run_folder", metavar="RUN_FOLDER", type=Path, help="output folder of a benchmark run")
    out.add_argument("--all", action="store_true", help="print the tables of all selectors, too")
    out.add_argument("--guide", action="store_true", help="make the guide whatever the run's experiment is")
    out.add_argument(
        "--choices",
        action="store_true",
        help="print nothing but a Markdown table of the best and the fastest selectors of each dataset; write nothing",
    )
    out.add_argument("--no-page", action="store_true", help="write no page")
    out.add_argument("--output", metavar="FILE", help="page to write (default: RUN_FOLDER/report.html)")
    out.add_argument(
        "--export",
        metavar="FORM",
        action="append",
        default=[],
        choices=export_matches.FORMS,
        help="convert the matches that the run has saved to this form (npz or colmap); may be repeated",
    )
    return out


def main(arguments=None):
    """Run the command line; return the exit status."""
    options = parser().parse_args(arguments)
    from .reading import read_run

    runs = []
    if not succeeded(lambda: runs.append(read_run(options.run_folder))):
        return 2
    run = runs[0]
    if options.choices:
        return 0 if succeeded(print_choices, run, options) else 2
    steps = [print_results]
    if options.guide or "guide" in run.sections:
        steps.append(make_guide)
    if not options.no_page:
        steps.append(write_page)
    done = [succeeded(step, run, options) for step in steps]
    done += [succeeded(export, form, options.run_folder) for form in options.export]
    return 0 if all(done) else 2


if __name__ == "__main__":
    sys.exit(main())
