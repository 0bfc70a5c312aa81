"""Convert the matches that a benchmark run has saved to NPZ files or to databases of COLMAP.

Usage: python3 -m corrsel.files --format npz|colmap RUN_FOLDER [--output FOLDER] [--size WxH] [--database FILE]

RUN_FOLDER is the output folder of a run with save_matches. docs/matches.md describes the files that are written.
Exit status: 0 written, 2 unusable input.
"""
import argparse
import sys
from pathlib import Path

from .pairs import InputError, parse_size
from .program import run
from .saved import Run, write_colmap, write_npz

FORMS = ("npz", "colmap")


def export(arguments):
    """Write the files; return what is to be printed."""
    saved = Run(arguments.run_folder)
    output = arguments.output or arguments.run_folder / "matches" / arguments.format
    if arguments.format == "npz":
        if arguments.database is not None:
            raise InputError("--database is for --format colmap")
        return "%d selections written to %s" % (write_npz(saved, output), output)
    size = (0, 0) if arguments.size is None else parse_size(arguments.size)
    count, same, spaced = write_colmap(saved, output, size, arguments.database)
    text = "%d databases written to %s" % (count, output)
    if same:
        text += "; %d selections of an image with itself are left out" % same
    if spaced:
        text += "; %d lines are left out of the lists of pairs, because a name has a space" % spaced
    return text


def main(argv=None):
    """Run with these arguments, by default those of the command line; return the exit status."""
    parser = argparse.ArgumentParser(prog="corrsel.files", description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument(
        "run_folder", type=Path, metavar="RUN_FOLDER", help="output folder of a run with save_matches"
    )
    parser.add_argument("--format", choices=FORMS, required=True, help="form of the files")
    parser.add_argument(
        "--output", type=Path, help="folder of the files (default: RUN_FOLDER/matches/FORMAT)"
    )
    parser.add_argument("--size", help="WIDTHxHEIGHT of images whose size is not known, px; for colmap")
    parser.add_argument(
        "--database",
        type=Path,
        help="database of COLMAP from which the matches came: its cameras, images, keypoints and descriptors are kept",
    )
    return run(parser, export, argv)


if __name__ == "__main__":
    sys.exit(main())
