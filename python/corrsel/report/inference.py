"""Statistics of the report: means with their intervals, paired differences, rank correlation."""
from collections import namedtuple

import numpy as np

from .tables import ReportError

Estimate = namedtuple("Estimate", "mean low high count")
Estimate.__doc__ = "A mean, its 95 % percentile bootstrap interval, and the number of values it is made of."


def mean_interval(values):
    """Return the Estimate of the mean of n >= 1 finite values; with n = 1 the interval is the value.

    corrsel/evaluation/statistics.h defines the interval, so that the tables of a run show the same one for the same
    values. ReportError where the binding is not built.
    """
    try:
        from ..evaluation import mean_interval as interval
    except ImportError as error:
        raise ReportError(
            "intervals need the module corrsel._core, which cannot be loaded (%s). Remedy: install pybind11-dev and"
            " python3-dev, build the package again and source its workspace" % error
        ) from error
    return Estimate(*interval(values), len(values))


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
