"""Statistics of the report: means with their intervals, paired differences, rank correlation.

The interval of a mean is defined in corrsel/evaluation/statistics.h. The program mean_intervals computes it, so that
the report and the tables of a run show the same interval for the same values.
"""
import functools
import os
import shutil
import subprocess
import weakref
from collections import namedtuple
from pathlib import Path

import numpy as np

from .tables import ReportError

PROGRAM = "mean_intervals"

Estimate = namedtuple("Estimate", "mean low high count")
Estimate.__doc__ = "A mean, its 95 % percentile bootstrap interval, and the number of values it is made of."


class ProgramError(ReportError):
    """The program that computes intervals is missing or failed; the message names the remedy."""


def program_folders():
    """Return the folders that may hold the package's programs, the most likely first."""
    scripts = Path(__file__).resolve().parents[1]
    folders = [scripts]  # of an installed package
    for prefix in filter(None, os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)):
        folders += [Path(prefix) / "lib" / "corrsel", Path(prefix) / "bin"]
    return folders + [Path(folder) for folder in os.environ.get("PATH", "").split(os.pathsep) if folder]


def find_program():
    """Return the path of the program; raises ProgramError where it is in none of program_folders()."""
    path = shutil.which(PROGRAM, path=os.pathsep.join(map(str, program_folders())))
    if path is None:
        raise ProgramError(
            "the program %s, which computes the intervals, was not found. Remedy: build the package and source"
            " its workspace (source devel/setup.bash), or add the folder of the program to PATH" % PROGRAM
        )
    return path


class MeanIntervals:
    """The running program. For each line of numbers it prints one line with the result."""

    def __init__(self):
        """Start the program; it ends with this object."""
        self.process = subprocess.Popen(
            [find_program()], stdin=subprocess.PIPE, stdout=subprocess.PIPE, universal_newlines=True
        )
        weakref.finalize(self, self.end, self.process)

    @staticmethod
    def end(process):
        """End the program."""
        process.communicate()

    def estimate(self, values):
        """Return the Estimate of the mean of a list of floats."""
        try:
            self.process.stdin.write(" ".join(map(repr, values)) + "\n")
            self.process.stdin.flush()
            numbers = self.process.stdout.readline().split()
        except OSError:
            numbers = []
        if len(numbers) != 3:
            raise ProgramError(
                "the program %s ended without a result. Remedy: build the package again" % PROGRAM
            )
        return Estimate(*(float(number) for number in numbers), len(values))


@functools.lru_cache(maxsize=None)
def running_program():
    """Return the program, which runs from its first use to the end of this process."""
    return MeanIntervals()


def mean_interval(values):
    """Return the Estimate of the mean of n >= 1 finite values; with n = 1 the interval is the value."""
    values = np.asarray(values, dtype=float)
    if values.ndim != 1 or len(values) == 0 or not np.isfinite(values).all():
        raise ValueError("interval: expected finite values, got an array of shape %s" % (values.shape,))
    return running_program().estimate(values.tolist())


def paired_difference(first, second):
    """Return the Estimate of the mean of first[i] - second[i]; pairs, not values, are resampled."""
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if first.shape != second.shape:
        raise ValueError("paired difference: %s values against %s" % (first.shape, second.shape))
    return mean_interval(first - second)


def is_above(difference):
    """Tell whether the whole interval of a difference lies above 0."""
    return difference.low > 0


def is_separate(difference):
    """Tell whether the interval of a difference does not contain 0."""
    return difference.low > 0 or difference.high < 0


def average_ranks(values):
    """Return the ranks 1..n of n values, the lowest first; equal values share the mean of their ranks."""
    _, inverse, counts = np.unique(np.asarray(values, dtype=float), return_inverse=True, return_counts=True)
    return (np.cumsum(counts) - (counts - 1) / 2.0)[inverse]


def spearman(first, second):
    """Return Spearman's rank correlation, -1..1, with average ranks for ties.

    It is Pearson's correlation of the ranks (the form that holds with ties). None where it is undefined: fewer
    than two values, or all values of one side equal.
    """
    if len(first) != len(second):
        raise ValueError("rank correlation: %d values against %d" % (len(first), len(second)))
    if len(first) < 2:
        return None
    a, b = average_ranks(first), average_ranks(second)
    a, b = a - a.mean(), b - b.mean()
    scale = np.sqrt((a * a).sum() * (b * b).sum())
    return float((a * b).sum() / scale) if scale > 0 else None
