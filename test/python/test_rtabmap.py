#!/usr/bin/env python3
"""corrsel_rtabmap, called and read as rtabmap's PyMatcher.cpp does."""

import ctypes
import importlib
import pathlib
import sys
import unittest

import corrsel_rtabmap
import numpy as np
from generated_pairs import SIZE, described_pair

INDOOR = 0.2, 20, 1, "indoor"  # rtabmap's defaults


def read(result):
    """Return the pairs that rtabmap reads: numbers of the array's type, one after another from the start of its memory,
    as many as the first two lengths of its shape say."""
    types = {np.dtype(np.int64): ctypes.c_int64, np.dtype(np.int32): ctypes.c_int32}
    number, lengths = types[result.dtype], result.shape
    count = lengths[0] * lengths[1]
    values = (number * count).from_address(result.ctypes.data) if count else []
    return [(values[i], values[i + 1]) for i in range(0, count, 2)]


def matched(keypoints, descriptors, size=SIZE):
    """Return the result of match() for the arrays of two images, which are overwritten afterwards."""
    arrays = [np.array(side, np.float32) for side in (*keypoints, *descriptors)]
    scores = [np.ones(len(side), np.float32) for side in keypoints]
    result = corrsel_rtabmap.match(arrays[0], arrays[1], *scores, arrays[2], arrays[3], *size)
    for array in arrays + scores:  # rtabmap frees them
        array[:] = -1
    return result


class Rtabmap(unittest.TestCase):
    """init() and match()."""

    def setUp(self):
        corrsel_rtabmap.init(32, *INDOOR)
        self.keypoints, self.descriptors, self.partner = described_pair(1)

    def test_the_right_matches_come_back(self):
        result = matched(self.keypoints, self.descriptors)
        self.assertEqual((result.dtype, result.ndim, result.shape[1]), (np.dtype(np.int64), 2, 2))
        self.assertTrue(result.flags.c_contiguous)
        pairs = read(result)
        right = [pair for pair in pairs if self.partner[pair[0]] == pair[1]]
        self.assertGreater(len(right), 0.9 * (self.partner >= 0).sum())
        self.assertGreater(len(right), 0.95 * len(pairs))
        for column in zip(*pairs):
            self.assertEqual(len(set(column)), len(column))

    def test_nothing_comes_back_as_an_empty_array_of_two_columns(self):
        """Its second length is read, too, so that it must exist."""
        random = np.random.RandomState(0)
        empty, none = np.empty((0, 2)), np.empty((0, 32))
        nan = np.full_like(self.descriptors[0], np.nan)
        for keypoints, descriptors in (
            ((empty, empty), (none, none)),
            ((self.keypoints[0], empty), (self.descriptors[0], none)),
            ((self.keypoints[0][:1], self.keypoints[1][:1]), (nan[:1], nan[:1])),
            (self.keypoints, (nan, nan)),
            (([[np.nan, 1]] * 600, self.keypoints[1]), self.descriptors),
            (self.keypoints, random.normal(size=(2, 600, 32))),
        ):
            result = matched(keypoints, descriptors)
            self.assertEqual((result.dtype, result.shape), (np.dtype(np.int64), (0, 2)))
            self.assertEqual(read(result), [])

    def test_the_model_chooses_the_selector(self):
        counts = {}
        for model in (
            "indoor",
            "auto",
            "usac:f",
            "lpm",
            "usac[model=fundamental;threshold=0.2]",
            "no/such.pth",
        ):
            corrsel_rtabmap.init(32, 0.0, 20, 0, model)
            counts[model] = len(matched(self.keypoints, self.descriptors))
        self.assertEqual(counts["indoor"], counts["auto"])
        self.assertEqual(counts["no/such.pth"], counts["auto"])
        self.assertLess(counts["usac[model=fundamental;threshold=0.2]"], 0.7 * counts["usac:f"])
        with self.assertRaisesRegex(ValueError, "preset .v9. of selector lpm"):
            corrsel_rtabmap.init(32, *INDOOR[:3], "lpm:v9")

    def test_the_threshold_is_a_probability(self):
        counts = []
        for threshold in (0.0, 0.9, 0.999):
            corrsel_rtabmap.init(32, threshold, *INDOOR[1:])
            counts.append(len(matched(self.keypoints, self.descriptors)))
        self.assertGreater(counts[0], counts[1])
        self.assertGreater(counts[1], counts[2])

    def test_rtabmap_imports_the_file_by_its_folder_alone(self):
        """It appends the folder to the path, and imports the file's name up to the first dot."""
        path = pathlib.Path(corrsel_rtabmap.__file__)
        self.assertEqual(path.name.split(".")[0], "corrsel_rtabmap")
        self.assertTrue((path.parent / "corrsel" / "__init__.py").exists(), path)
        del sys.modules["corrsel_rtabmap"]
        self.assertTrue(callable(importlib.import_module("corrsel_rtabmap").match))


if __name__ == "__main__":
    unittest.main()
