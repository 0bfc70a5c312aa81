#!/usr/bin/env python3
"""Ground-truth errors and metrics: the results of C++, every kind of ground truth, errors."""

import unittest

import corrsel
import numpy as np
from support import expected, scene


def doubles(values):
    """JSON's null stands for NaN or infinity, which cannot be told apart: both become NaN."""
    return np.array([np.nan if value is None else value for value in values])


class Results(unittest.TestCase):
    """Errors and metrics are those of C++."""

    def test_models_and_labels(self):
        for number, results in enumerate(expected()["scenes"]):
            for judged in results["judged"]:
                with self.subTest(scene=number, truth=judged["kind"]):
                    value = results["inlier"]
                    if judged["kind"] != "labels":
                        value = np.reshape(judged["matrix"], (3, 3))
                    truth = {judged["kind"]: value}
                    errors = corrsel.ground_truth_errors(scene(number), **truth)
                    self.assertEqual(errors.dtype, np.float64)
                    errors[np.isinf(errors)] = np.nan
                    np.testing.assert_array_equal(errors, doubles(judged["errors"]))
                    evaluation = corrsel.evaluate(scene(number), np.array(results["inlier"], bool), **truth)
                    for name, values in judged["evaluation"].items():
                        if isinstance(values, list):
                            mine = np.atleast_1d(getattr(evaluation, name))
                            np.testing.assert_array_equal(mine, doubles(values), name)
                        else:
                            self.assertEqual(getattr(evaluation, name), values, name)


class Kinds(unittest.TestCase):
    """Every kind of ground truth by examples worked out by hand."""

    def setUp(self):
        self.matches = corrsel.Matches(
            [[10.0, 10], [20, 10], [30, 10]], [[12.0, 10], [22, 13], [90, 90]], left_size=(100, 100)
        )

    def test_homography(self):
        shift = [[1, 0, 2], [0, 1, 0], [0, 0, 1]]
        errors = corrsel.ground_truth_errors(self.matches, homography=shift)
        np.testing.assert_allclose(errors, [0, 3, np.hypot(58, 80)])
        np.testing.assert_array_equal(
            corrsel.ground_truth_errors(self.matches, homography=-2.0 * np.array(shift)), errors
        )

    def test_fundamental(self):
        sideways = [[0, 0, 0], [0, 0, -1], [0, 1, 0]]
        errors = corrsel.ground_truth_errors(self.matches, fundamental=sideways)
        np.testing.assert_allclose(errors, [0, 3, 80])

    def test_labels(self):
        errors = corrsel.ground_truth_errors(self.matches, labels=[1, 2, 0])
        np.testing.assert_array_equal(errors, [0, 0, np.inf])

    def test_disparity(self):
        disparity = np.full((100, 100), -2.0)
        disparity[10, 20] = np.nan
        errors = corrsel.ground_truth_errors(self.matches, disparity=disparity[:, ::1])
        np.testing.assert_allclose(errors, [0, np.nan, np.hypot(58, 80)])

    def test_metrics(self):
        shift = [[1, 0, 2], [0, 1, 0], [0, 0, 1]]
        evaluation = corrsel.evaluate(
            self.matches, [True, False, True], homography=shift, tolerance=[1, 5], ground_truth_tolerance=5
        )
        self.assertEqual((evaluation.n_putative, evaluation.n_ground_truth, evaluation.n_selected), (3, 2, 2))
        np.testing.assert_array_equal(evaluation.tolerance, [1, 5])
        np.testing.assert_array_equal(evaluation.n_correct, [1, 1])
        np.testing.assert_array_equal(evaluation.precision, [0.5, 0.5])
        np.testing.assert_array_equal(evaluation.recall_paper, [0.5, 0.5])
        np.testing.assert_array_equal(evaluation.recall_same_tau, [1, 0.5])
        np.testing.assert_array_equal(evaluation.f_paper, [0.5, 0.5])
        self.assertIn("2 of 3 matches selected, 2 inliers; tolerance 1: P 0.500", repr(evaluation))

    def test_one_tolerance_gives_numbers(self):
        evaluation = corrsel.evaluate(self.matches, [True, False, True], homography=np.eye(3), tolerance=2)
        self.assertEqual((evaluation.tolerance, evaluation.n_correct, evaluation.precision), (2, 1, 0.5))
        self.assertIn("tolerance 2: P 0.500", repr(evaluation))
        labelled = corrsel.evaluate(self.matches, [True, False, True], labels=[1, 1, 0])
        self.assertEqual((labelled.n_correct, labelled.precision, labelled.f_paper), (1, 0.5, 0.5))

    def test_defaults(self):
        evaluation = corrsel.evaluate(self.matches, np.ones(3, np.uint8), homography=np.eye(3))
        np.testing.assert_array_equal(evaluation.tolerance, np.arange(1, 11))

    def test_no_match(self):
        nothing = corrsel.Matches(np.zeros((0, 2)), np.zeros((0, 2)))
        evaluation = corrsel.evaluate(nothing, [], homography=np.eye(3), tolerance=5)
        self.assertEqual(evaluation.n_putative, 0)
        self.assertTrue(np.isnan(evaluation.precision))


class Errors(unittest.TestCase):
    """Errors name the argument, what came and what is needed."""

    def assert_raises(self, error, words, action, *arguments, **keywords):
        with self.assertRaises(error) as caught:
            action(*arguments, **keywords)
        self.assertEqual(str(caught.exception), words)

    def test_errors(self):
        matches = scene()
        errors, evaluate = corrsel.ground_truth_errors, corrsel.evaluate
        mask = np.ones(len(matches), bool)
        exactly = "needed: exactly one of homography, fundamental, labels and disparity; given: "
        self.assert_raises(TypeError, exactly + "none", errors, matches)
        self.assert_raises(
            TypeError, exactly + "homography, labels", errors, matches, labels=[1], homography=np.eye(3)
        )
        self.assert_raises(
            ValueError,
            "homography has shape (2, 3); needed: (3, 3)",
            errors,
            matches,
            homography=np.eye(3)[:2],
        )
        self.assert_raises(
            TypeError, "fundamental has dtype <U1; needed: real numbers", errors, matches, fundamental="F"
        )
        self.assert_raises(
            ValueError,
            "homography holds a number that is not finite",
            errors,
            matches,
            homography=np.full((3, 3), np.nan),
        )
        self.assert_raises(
            ValueError, "labels has 2 rows; needed: 300, one label per match", errors, matches, labels=[0, 1]
        )
        self.assert_raises(
            ValueError,
            "disparity has shape (3,); needed: (N, N), height and width of the left image",
            errors,
            matches,
            disparity=np.zeros(3),
        )
        self.assert_raises(
            ValueError,
            "mask has 299 rows; needed: 300, one element per match",
            evaluate,
            matches,
            mask[1:],
            homography=np.eye(3),
        )
        self.assert_raises(
            TypeError,
            "mask has dtype int64; needed: bool or uint8",
            evaluate,
            matches,
            np.flatnonzero(mask),
            homography=np.eye(3),
        )
        self.assert_raises(
            ValueError,
            "tolerance is -5; needed: a number or a list of numbers from 0, px",
            evaluate,
            matches,
            mask,
            homography=np.eye(3),
            tolerance=-5,
        )
        self.assert_raises(
            TypeError,
            "matches is ndarray; needed: corrsel.Matches, e.g. corrsel.Matches(left, right)",
            evaluate,
            matches.left,
            mask,
            homography=np.eye(3),
        )


if __name__ == "__main__":
    unittest.main()
