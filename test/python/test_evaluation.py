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
            for evaluated in results["evaluated"]:
                with self.subTest(scene=number, truth=evaluated["kind"]):
                    value = results["inlier"]
                    if evaluated["kind"] != "labels":
                        value = np.reshape(evaluated["matrix"], (3, 3))
                    truth = {evaluated["kind"]: value}
                    errors = corrsel.ground_truth_errors(scene(number), **truth)
                    self.assertEqual(errors.dtype, np.float64)
                    errors[np.isinf(errors)] = np.nan
                    np.testing.assert_array_equal(errors, doubles(evaluated["errors"]))
                    evaluation = corrsel.evaluate(scene(number), np.array(results["inlier"], bool), **truth)
                    for name, values in evaluated["evaluation"].items():
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


def reference_auc(errors, thresholds):
    """The area under the recall curve, as a sum over the trapezoids of the curve's points."""
    errors = np.sort(errors)
    areas = []
    for threshold in thresholds:
        below = np.concatenate([[0.0], errors[errors < threshold]])
        x = np.append(below, threshold)
        y = np.append(np.arange(len(below)), len(below) - 1) / len(errors)
        areas.append(np.sum(np.diff(x) * (y[1:] + y[:-1]) / 2) / threshold)
    return areas


def turned(degrees):
    """A rotation about z."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


class Poses(unittest.TestCase):
    """Errors of poses and homographies, and their areas."""

    def test_pose_errors(self):
        errors = corrsel.pose_errors(turned(33), [0, 2, 0], turned(30), (0, -1, np.tan(0.1)))
        self.assertAlmostEqual(errors.rotation, 3)
        self.assertAlmostEqual(errors.translation, np.degrees(0.1))
        self.assertEqual(errors.pose, errors.translation)
        only_turned = corrsel.pose_errors(turned(33), [[0], [2], [0]], turned(30), np.zeros(3))
        self.assertAlmostEqual(only_turned.pose, 3)
        self.assertTrue(np.isnan(only_turned.translation))

    def test_area(self):
        random = np.random.RandomState(1)
        errors = np.append(random.exponential(6, 200), [180, np.inf])
        areas = corrsel.error_auc(errors)
        np.testing.assert_allclose(areas, reference_auc(errors, (5, 10, 20)), atol=1e-12)
        np.testing.assert_array_equal(corrsel.error_auc(np.append(errors[:-1], np.nan)), areas)
        np.testing.assert_allclose(corrsel.error_auc([1, 3, 10], 5), [0.5])
        self.assertTrue(np.isnan(corrsel.error_auc([])).all())

    def test_accuracy(self):
        self.assertAlmostEqual(corrsel.mean_average_accuracy([0.5, 5, 180, np.nan]), (1 + 0.5) / 4)
        self.assertAlmostEqual(corrsel.mean_average_accuracy([2], [1, 3]), 0.5)
        self.assertTrue(np.isnan(corrsel.mean_average_accuracy([])))

    def test_mean_interval(self):
        # Printed by the C++ function for the same values.
        found = corrsel.mean_interval([0, 0.14, 0.2, 0.44, 0.62, 0.8, 0.9])
        np.testing.assert_allclose(found, (0.4428571428571429, 0.2, 0.6800714285714282), rtol=1e-12)
        self.assertEqual(corrsel.mean_interval([0.25]), (0.25, 0.25, 0.25))
        for values in ([], [1, float("nan")], [[1, 2]]):
            with self.assertRaisesRegex(ValueError, "finite numbers, at least one"):
                corrsel.mean_interval(values)

    def test_epipolar_errors(self):
        matches = corrsel.Matches([[10.0, 20], [10, 20]], [[5.0, 20], [5, 23]])
        camera = [[100, 0, 50], [0, 100, 40], [0, 0, 1]]
        errors = corrsel.epipolar_errors(matches, np.eye(3), [1, 0, 0], camera, camera)
        np.testing.assert_allclose(errors, [0, 2 * 0.03**2], atol=1e-12)

    def test_corner_error(self):
        shift = [[1, 0, 3], [0, 1, 4], [0, 0, 1]]
        self.assertAlmostEqual(corrsel.corner_error(shift, np.eye(3), (101, 51)), 5)
        self.assertAlmostEqual(corrsel.corner_error(np.multiply(shift, -2), np.eye(3), (101, 51)), 5)

    def test_wrong_arguments(self):
        eye, matches = np.eye(3), corrsel.Matches([[1.0, 2]], [[3.0, 4]])
        for words, action in (
            (
                "translation has shape (2,); needed: three numbers",
                lambda: corrsel.pose_errors(eye, [1, 2], eye, [1, 0, 0]),
            ),
            ("is not a rotation", lambda: corrsel.pose_errors(eye, [1, 0, 0], 2 * eye, [1, 0, 0])),
            ("errors is [-1]; needed", lambda: corrsel.error_auc([-1])),
            ("thresholds is 0; needed", lambda: corrsel.error_auc([1], 0)),
            ("only turned", lambda: corrsel.epipolar_errors(matches, eye, [0, 0, 0], eye, eye)),
            ("is not a camera matrix", lambda: corrsel.epipolar_errors(matches, eye, [1, 0, 0], -eye, eye)),
            ("size of the left image is empty", lambda: corrsel.corner_error(eye, eye, (0, 10))),
        ):
            with self.subTest(words), self.assertRaises(ValueError) as caught:
                action()
            self.assertIn(words, str(caught.exception))


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
