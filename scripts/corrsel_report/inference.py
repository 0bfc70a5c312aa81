"""Statistics of the report: bootstrap intervals, paired differences, rank correlation. Numpy alone."""
from collections import namedtuple

import numpy as np

RESAMPLES = 2000
LEVEL = 95.0  # %
SEED = 0
BLOCK = 1 << 21  # numbers held at a time

Estimate = namedtuple("Estimate", "mean low high count")
Estimate.__doc__ = "A mean, its 95 % percentile bootstrap interval, and the number of values it is made of."


def bootstrap_means(values, resamples=RESAMPLES, seed=SEED):
    """Return the means of `resamples` samples drawn with replacement from n values, in O(resamples n).

    The engine is owned and seeded: the same values always give the same means. Two calls with the same n and
    seed draw the same samples.
    """
    values = np.asarray(values, dtype=float)
    if values.ndim != 1 or len(values) == 0:
        raise ValueError("bootstrap: expected at least one value, got an array of shape %s" % (values.shape,))
    generator = np.random.Generator(np.random.PCG64(seed))
    step = max(1, BLOCK // len(values))
    means = [
        values[generator.integers(0, len(values), size=(min(step, resamples - start), len(values)))].mean(
            axis=1
        )
        for start in range(0, resamples, step)
    ]
    return np.concatenate(means)


def mean_interval(values):
    """Return the Estimate of the mean of n values; with n = 1 the interval is the value."""
    values = np.asarray(values, dtype=float)
    low, high = np.percentile(bootstrap_means(values), [(100 - LEVEL) / 2, (100 + LEVEL) / 2])
    return Estimate(float(values.mean()), float(low), float(high), len(values))


def paired_difference(first, second):
    """Return the Estimate of the mean of first[i] - second[i]; pairs, not values, are drawn anew."""
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if first.shape != second.shape:
        raise ValueError("paired difference: %s values against %s" % (first.shape, second.shape))
    return mean_interval(first - second)


def is_above(difference):
    """Tell whether the whole interval of a difference lies above 0."""
    return difference.low > 0


def is_separate(difference):
    """Tell whether the interval of a difference leaves 0 out."""
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
