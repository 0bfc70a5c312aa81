#!/usr/bin/env python3
"""Make a bag of matches from files: NPZ, HDF5 of hloc, CSV or a database of COLMAP.

Usage: matches_to_bag.py MATCHES --output FILE.bag [--features FILE] [--pairs FILE] [--images FOLDER]
                         [--truth FOLDER] [--size WxH] [--scores MEANING] [--dataset NAME] [--period S]

docs/matches.md describes the forms, their keys and columns, and the ground truth that they may hold. The benchmark
(bag:=FILE) and the live nodelets (replay.launch) read the bag. The same files always give the same messages.
Exit status: 0 written, 2 unusable input.
"""
import argparse
import sys
from pathlib import Path

from corrsel.files.pairs import SCORES, InputError, parse_size
from corrsel.files.program import run
from corrsel.files.reading import FORMS, Request, read_pairs


def convert(arguments):
    """Write the bag; return what is to be printed."""
    # The help and errors of arguments need no ROS.
    from corrsel.files.bag import write_bag  # pylint: disable=import-outside-toplevel

    if arguments.images is not None and not arguments.images.is_dir():
        raise InputError("%s is not a folder of images" % arguments.images)
    request = Request(
        arguments.matches, arguments.features, arguments.pairs, arguments.truth, arguments.scores
    )
    count, matches, evaluated = write_bag(
        read_pairs(request),
        arguments.output,
        arguments.dataset or arguments.matches.resolve().stem,
        arguments.images,
        (0, 0) if arguments.size is None else parse_size(arguments.size),
        arguments.period,
    )
    return "%d pairs with %d matches, %d of them with ground truth, written to %s" % (
        count,
        matches,
        evaluated,
        arguments.output,
    )


def main(argv=None):
    """Run with these arguments, by default those of the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="matches_to_bag.py",
        description=__doc__.split("\n", maxsplit=1)[0],
        epilog="Then: roslaunch corrsel benchmark.launch bag:=FILE",
    )
    parser.add_argument("matches", type=Path, metavar="MATCHES", help=FORMS)
    parser.add_argument("--output", type=Path, required=True, help="the bag; an older one is replaced")
    parser.add_argument("--features", type=Path, help="HDF5 file of hloc with the keypoints")
    parser.add_argument(
        "--pairs", type=Path, help="list of pairs of images, one on each line; K, K' and T are used"
    )
    parser.add_argument(
        "--images", type=Path, help="folder of the images, which are written into the bag, too"
    )
    parser.add_argument("--truth", type=Path, help="folder with PAIR/H.txt, F.txt or pose.txt")
    parser.add_argument("--size", help="WIDTHxHEIGHT of images whose size is not known otherwise, px")
    parser.add_argument(
        "--scores",
        choices=SCORES,
        default=SCORES[0],
        help="what the scores of NPZ and HDF5 files are; a confidence is the probability of a match (default: %(default)s)",
    )
    parser.add_argument("--dataset", help="name of the dataset in the results (default: that of MATCHES)")
    parser.add_argument(
        "--period", type=float, default=0.5, help="between two pairs, s (default: %(default)s)"
    )
    return run(parser, convert, argv)


if __name__ == "__main__":
    sys.exit(main())
