#!/usr/bin/env python3
"""corrsel.opencv beside OpenCV, on generated pairs and on input that cannot be answered."""

import collections
import time
import unittest

import corrsel
import numpy as np
from corrsel import opencv
from generated_pairs import MATRIX, SIZE, generated_pair

try:
    import cv2
except ImportError:
    cv2 = None

PAIRS = range(50)
FUNCTIONS = {
    "homography": opencv.findHomography,
    "fundamental": opencv.findFundamentalMat,
    "essential": lambda left, right, method="pose", **limits: opencv.findEssentialMat(
        left, right, MATRIX, method, **limits
    ),
}


def kept(function, plane):
    """Return how many inliers a function keeps in all pairs, how many of them are right, the least share of the right
    matches of a pair, and the seconds of the processor."""
    total, right, least, seconds = 0, 0, 1.0, 0.0
    for seed in PAIRS:
        left_points, right_points, truth = generated_pair(seed, plane)
        begin = time.process_time()
        model, mask = function(left_points, right_points)
        seconds += time.process_time() - begin
        if model is not None:
            found = mask.ravel() != 0
            total, right = total + found.sum(), right + found[truth].sum()
            least = min(least, found[truth].mean())
        else:
            least = 0
    return total, right, least, seconds


@unittest.skipUnless(hasattr(cv2, "USAC_MAGSAC"), "needs python3-opencv, 4.5 or newer")
class BesideOpencv(unittest.TestCase):
    """As many inliers as USAC_MAGSAC, and nearly all of them right."""

    def compare(self, name, theirs, ours, plane):
        """Compares functions; prints their numbers."""
        reference = kept(theirs, plane)
        for method, function in ours.items():
            with self.subTest(name, method=method):
                total, right, least, seconds = kept(function, plane)
                print(
                    "%s, %s: %d inliers, %d right, at least %.2f of a pair, %.1f ms a pair; USAC_MAGSAC: %d, %d, %.2f, %.1f ms"
                    % (name, method, total, right, least, 20 * seconds, *reference[:3], 20 * reference[3])
                )
                self.assertGreaterEqual(total, 0.98 * reference[0])
                self.assertGreaterEqual(right, 0.98 * reference[1])
                self.assertGreaterEqual(right, 0.98 * total)

    def test_homography(self):
        self.compare(
            "homography",
            lambda left, right: cv2.findHomography(left, right, cv2.USAC_MAGSAC, 3.0),
            {
                method: lambda left, right, method=method: opencv.findHomography(left, right, method, 3.0)
                for method in ("auto", "lpm", cv2.RANSAC, cv2.LMEDS, cv2.USAC_MAGSAC)
            },
            True,
        )

    def test_fundamental_matrix(self):
        self.compare(
            "fundamental matrix",
            lambda left, right: cv2.findFundamentalMat(left, right, cv2.USAC_MAGSAC, 1.5, 0.999, 10000),
            {
                method: lambda left, right, method=method: opencv.findFundamentalMat(
                    left, right, method, 1.5, 0.999, 10000
                )
                for method in ("auto", cv2.FM_RANSAC, cv2.FM_LMEDS, cv2.USAC_MAGSAC)
            },
            False,
        )

    def test_essential_matrix(self):
        self.compare(
            "essential matrix",
            lambda left, right: cv2.findEssentialMat(left, right, MATRIX, cv2.USAC_MAGSAC, 0.999, 1.0),
            {
                method: lambda left, right, method=method: opencv.findEssentialMat(
                    left, right, MATRIX, method, 0.999, 1.0
                )
                for method in ("pose", "auto", cv2.RANSAC, cv2.LMEDS)
            },
            False,
        )

    def test_the_models_agree(self):
        """Scale and direction of the matrices are those of cv2, which goes on with them."""
        left, right, truth = generated_pair(3, True, 800, 1.0)
        ours, _ = opencv.findHomography(left, right)
        theirs, _ = cv2.findHomography(left, right, cv2.USAC_MAGSAC, 3.0)
        corners = np.array([[[0, 0]], [[SIZE[0], 0]], [SIZE], [[0, SIZE[1]]]], np.float32)
        moved = [cv2.perspectiveTransform(corners, model) for model in (ours, theirs)]
        self.assertLess(np.abs(moved[0] - moved[1]).max(), 1.5)
        left, right, truth = generated_pair(3, False, 800, 0.7)
        fundamental, mask = opencv.findFundamentalMat(left, right, "auto", 1.5)
        lines = cv2.computeCorrespondEpilines(left.reshape(-1, 1, 2), 1, fundamental).reshape(-1, 3)
        distance = np.abs((lines[:, :2] * right).sum(1) + lines[:, 2])
        self.assertLess(np.median(distance[truth]), 1)
        essential, mask = opencv.findEssentialMat(left, right, MATRIX)
        self.assertAlmostEqual(np.linalg.norm(essential), 1)
        count, turn, shift, _ = cv2.recoverPose(essential, left, right, MATRIX, mask=mask.copy())
        self.assertGreater(count, 0.95 * mask.sum())
        theirs = cv2.recoverPose(
            cv2.findEssentialMat(left[truth], right[truth], MATRIX)[0], left[truth], right[truth], MATRIX
        )
        self.assertLess(np.degrees(np.linalg.norm(cv2.Rodrigues(turn @ theirs[1].T)[0])), 0.5)
        self.assertGreater((shift * theirs[2]).sum(), 0.99)

    def test_keypoints_of_cv2(self):
        """matchGMS takes cv2's objects and returns the same ones."""
        left, right, _ = generated_pair(1, True, 900, 0.6)
        keypoints = [[cv2.KeyPoint(float(x), float(y), 1) for x, y in side] for side in (left, right)]
        matches = [cv2.DMatch(i, i, 0.0) for i in range(len(left))]
        kept_matches = opencv.matchGMS(SIZE, SIZE, *keypoints, matches)
        self.assertGreater(len(kept_matches), 100)
        self.assertTrue(all(match is matches[match.queryIdx] for match in kept_matches))


class Arguments(unittest.TestCase):
    """The lists of arguments of cv2, and shapes."""

    def setUp(self):
        self.left, self.right, self.truth = generated_pair(5, True, 400, 0.7)
        self.model, self.mask = opencv.findHomography(self.left, self.right)

    def test_what_comes_back(self):
        self.assertEqual((self.model.shape, self.model.dtype), ((3, 3), np.float64))
        self.assertEqual(self.model[2, 2], 1)
        self.assertEqual((self.mask.shape, self.mask.dtype), ((400, 1), np.uint8))
        self.assertEqual(set(self.mask.ravel().tolist()), {0, 1})
        self.assertGreater(self.mask.ravel()[self.truth].mean(), 0.97)

    def test_shapes_and_types_of_points(self):
        rows = self.left.reshape(-1, 1, 2), self.right.reshape(1, -1, 2)
        lists = self.left.tolist(), [tuple(point) for point in self.right.tolist()]
        for left, right in (rows, lists, (self.left.astype(np.float64), self.right.astype(np.float64))):
            model, mask = opencv.findHomography(left, right)
            np.testing.assert_array_equal(mask, self.mask)
            np.testing.assert_array_equal(model, self.model)
        model, mask = opencv.findHomography(np.round(self.left).astype(int), np.round(self.right).astype(int))
        self.assertGreater(mask.ravel()[self.truth].mean(), 0.95)

    def test_the_mask_of_the_caller_is_filled(self):
        buffer = np.full((400, 1), 7, np.uint8)
        for call in (
            lambda: opencv.findHomography(self.left, self.right, 8, 3.0, buffer),
            lambda: opencv.findFundamentalMat(self.left, self.right, 8, 3.0, 0.99, buffer),
            lambda: opencv.findFundamentalMat(self.left, self.right, 8, 3.0, 0.99, 1000, buffer),
            lambda: opencv.findEssentialMat(self.left, self.right, MATRIX, 8, 0.999, 1.0, buffer),
            lambda: opencv.findEssentialMat(self.left, self.right, MATRIX, 8, 0.999, 1.0, 1000, buffer),
        ):
            buffer[:] = 7
            model, mask = call()
            self.assertIsNotNone(model)
            self.assertIs(mask, buffer)
            self.assertLess(buffer.max(), 2)

    def test_the_mask_holds_what_is_within_the_threshold(self):
        """With a number of cv2, as cv2 defines it: in the right image."""
        for threshold in (1.0, 3.0):
            model, mask = opencv.findHomography(self.left, self.right, 8, threshold)
            moved = np.column_stack([self.left, np.ones(400)]) @ model.T
            error = np.linalg.norm(moved[:, :2] / moved[:, 2:] - self.right, axis=1)
            clear = np.abs(error - threshold) > 1e-3
            np.testing.assert_array_equal(mask.ravel()[clear] != 0, (error <= threshold)[clear])

    def test_limits_of_cv2_do_not_weaken_the_search(self):
        """Those of the defaults of cv2 are below ours; larger ones have an effect."""
        weak = opencv.findFundamentalMat(self.left, self.right, 8, 1.5, 0.5, 10)
        usual = opencv.findFundamentalMat(self.left, self.right, 8, 1.5)
        np.testing.assert_array_equal(weak[1], usual[1])
        random = np.random.RandomState(0).uniform(0, 1000, (2, 300, 2))
        times = []
        for iterations in (2000, 300000):
            begin = time.process_time()
            opencv.findHomography(*random, 8, 3.0, None, iterations, 0.999999)
            times.append(time.process_time() - begin)
        self.assertGreater(times[1], 2 * times[0])

    def test_the_lists_of_findEssentialMat(self):
        left, right, _ = generated_pair(5, False, 400, 0.7)
        expected, mask = opencv.findEssentialMat(left, right, MATRIX)
        self.assertIsNotNone(expected)
        focal, centre = MATRIX[0, 0], tuple(MATRIX[:2, 2])
        for arguments, keywords in (
            ((MATRIX, "pose", 0.999, 1.0), {}),
            ((), {"cameraMatrix": MATRIX, "threshold": 1.0}),
            ((focal, centre), {}),
            ((focal, centre, "pose", 0.999, 1.0), {}),
            ((), {"focal": focal, "pp": centre}),
            ((MATRIX, None, MATRIX, None), {}),
            ((MATRIX, np.zeros(5), MATRIX, np.zeros((1, 4)), "pose", 0.999, 1.0), {}),
            ((MATRIX,), {"distCoeffs1": None, "cameraMatrix2": MATRIX, "distCoeffs2": None}),
        ):
            model, found = opencv.findEssentialMat(left, right, *arguments, **keywords)
            np.testing.assert_allclose(model, expected, atol=1e-9)
            np.testing.assert_array_equal(found, mask)

    def test_distorted_and_normalised_points(self):
        left, right, truth = generated_pair(5, False, 400, 0.7)
        rays = [(side - MATRIX[:2, 2]) / MATRIX[0, 0] for side in (left, right)]
        model, mask = opencv.findEssentialMat(*rays, threshold=1 / MATRIX[0, 0])
        expected, _ = opencv.findEssentialMat(left, right, MATRIX)
        self.assertGreater(mask.ravel()[truth].mean(), 0.75)
        self.assertGreater(abs((model * expected).sum()), 0.999)
        radius = [(side**2).sum(1, keepdims=True) for side in rays]
        bent = [(ray * (1 - 0.2 * r)) @ MATRIX[:2, :2] + MATRIX[:2, 2] for ray, r in zip(rays, radius)]
        distortion = np.array([-0.2, 0, 0, 0, 0])
        model, mask = opencv.findEssentialMat(*bent, MATRIX, distortion, MATRIX, distortion)
        self.assertGreater(mask.ravel()[truth].mean(), 0.75)
        self.assertGreater(abs((model * expected).sum()), 0.999)

    def test_every_selector_answers_or_names_what_it_needs(self):
        for kind, function in FUNCTIONS.items():
            left, right, truth = generated_pair(8, kind == "homography", 300, 0.7)
            answered = 0
            for name in corrsel.selector_names() + ["auto:f", "usac[threshold=2]", "lpm:v2"]:
                with self.subTest(kind, selector=name):
                    try:
                        model, mask = function(left, right, name)
                    except ValueError as error:
                        self.assertRegex(
                            str(error), "^method '%s' needs .*(distance|frame|size|camera)" % name
                        )
                        continue
                    self.assertEqual(model.shape, (3, 3))
                    self.assertGreater(truth[mask.ravel() != 0].mean(), 0.97)
                    answered += 1
            self.assertGreater(answered, 20)

    def test_wrong_arguments(self):
        for error, text, call in (
            (ValueError, "method 0 rejects no matches; call cv2 itself", lambda: self.call(0)),
            (ValueError, "method FM_8POINT rejects no matches", lambda: self.call(2)),
            (ValueError, "method is 99; needed: a robust method of cv2", lambda: self.call(99)),
            (TypeError, "method is None; needed", lambda: self.call(None)),
            (TypeError, "method is array", lambda: self.call(self.left)),
            (ValueError, "unknown selector 'ransak'", lambda: self.call("ransak")),
            (ValueError, "'gms' needs left_size and right_size.*corrsel.select", lambda: self.call("gms")),
            (ValueError, "threshold", lambda: self.call("usac", 1e6)),
            (ValueError, r"srcPoints has shape \(400, 3\); needed: N x 2", lambda: self.shape((400, 3))),
            (ValueError, r"srcPoints has shape \(2, 200, 2\)", lambda: self.shape((2, 200, 2))),
            (ValueError, "srcPoints has 3 points and dstPoints has 400", lambda: self.shape((3, 2))),
            (TypeError, "srcPoints has dtype", lambda: opencv.findHomography(["a", "b"], self.right)),
            (ValueError, "cameraMatrix has shape", lambda: self.essential(np.eye(2))),
            (TypeError, "unexpected keyword argument 'thresh'", lambda: self.essential(MATRIX, thresh=1)),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                call()

    def call(self, *arguments):
        """Calls findHomography with a method."""
        return opencv.findHomography(self.left, self.right, *arguments)

    def shape(self, shape):
        """Calls findHomography with left points of a shape."""
        return opencv.findHomography(np.zeros(shape, np.float32), self.right)

    def essential(self, *arguments, **keywords):
        """Calls findEssentialMat with a camera."""
        return opencv.findEssentialMat(self.left, self.right, *arguments, **keywords)


class Data(unittest.TestCase):
    """Data never raise: the answer is None and a mask of zeros."""

    def test_nothing_to_find(self):
        random = np.random.RandomState(7)
        line = np.column_stack([np.arange(50.0), np.arange(50.0)])
        for name, left, right in (
            ("none", [], []),
            ("none of N x 2", np.empty((0, 2)), np.empty((0, 1, 2))),
            ("two", [[1, 2], [3, 4]], [[1, 2], [3, 5]]),
            ("one place", np.ones((30, 2)), np.ones((30, 2))),
            ("a line", line, 2 * line),
            ("NaN", np.full((30, 2), np.nan), np.ones((30, 2))),
            ("huge", np.full((30, 2), 1e300), np.full((30, 2), -np.inf)),
            ("unrelated", random.uniform(0, 800, (200, 2)), random.uniform(0, 800, (200, 2))),
        ):
            for kind, function in FUNCTIONS.items():
                default = "pose" if kind == "essential" else "auto"
                for method in (default, "lpm", 4, 8, 38) if name != "unrelated" else (default, 4):
                    with self.subTest(name, kind=kind, method=method):
                        model, mask = function(left, right, method)
                        if name != "a line":  # of which some selectors find the scale
                            self.assertIsNone(model)
                        self.assertEqual((mask.shape, mask.dtype), ((len(left), 1), np.uint8))
                        self.assertEqual(mask.any(), model is not None)

    def test_few_exact_matches_suffice(self):
        random = np.random.RandomState(1)
        points = np.column_stack([random.uniform((-2, -2, 4), (2, 2, 8), (12, 3))])
        left, right = ((view @ MATRIX.T)[:, :2] / view[:, 2:] for view in (points, points + (0.5, 0, 0.1)))
        plane = left @ [[1.1, -0.05], [0.1, 0.9]] + (5, 8)
        for method in (8, 38):
            for count, function, other in (
                (6, opencv.findHomography, plane),
                (12, opencv.findFundamentalMat, right),
                (12, FUNCTIONS["essential"], right),
            ):
                model, mask = function(left[:count], other[:count], method)
                self.assertIsNotNone(model)
                self.assertEqual(mask.sum(), count)

    def test_some_matches_with_nan(self):
        left, right, truth = generated_pair(2, True, 300, 0.8)
        left[::10] = np.nan
        model, mask = opencv.findHomography(left, right)
        self.assertIsNotNone(model)
        self.assertEqual(mask[::10].sum(), 0)
        truth[::10] = False
        self.assertGreater(mask.ravel()[truth].mean(), 0.95)

    def test_a_camera_that_only_turned_has_no_essential_matrix(self):
        random = np.random.RandomState(3)
        left = random.uniform((200, 200), (800, 600), (300, 2))
        right = left + (60, 0) + random.normal(0, 0.1, (300, 2))
        rays = np.column_stack([left, np.ones(300)]) @ np.linalg.inv(MATRIX).T
        c, s = np.cos(0.1), np.sin(0.1)
        turned = rays @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T @ MATRIX.T
        right = turned[:, :2] / turned[:, 2:] + random.normal(0, 0.3, (300, 2))
        for method in ("pose", "auto"):
            model, mask = opencv.findEssentialMat(left, right, MATRIX, method)
            self.assertIsNone(model)
            self.assertEqual(mask.sum(), 0)


KeyPoint = collections.namedtuple("KeyPoint", "pt")
DMatch = collections.namedtuple("DMatch", "queryIdx trainIdx")


class Gms(unittest.TestCase):
    """matchGMS by its contract; Debian's OpenCV is built without it."""

    def setUp(self):
        self.left, self.right, self.truth = generated_pair(1, True, 1200, 0.6)
        self.keypoints = [[KeyPoint(tuple(point)) for point in side] for side in (self.left, self.right)]
        self.matches = [DMatch(i, i) for i in range(1200)]

    def keep(self, *arguments):
        """Returns the numbers of the kept matches."""
        found = opencv.matchGMS(SIZE, SIZE, *self.keypoints, self.matches, *arguments)
        return [match.queryIdx for match in found]

    def test_right_matches_are_kept(self):
        found = self.keep()
        self.assertEqual(found, sorted(found))
        self.assertGreater(self.truth[found].mean(), 0.95)
        self.assertGreater(len(found), 0.5 * self.truth.sum())

    def test_the_options_have_an_effect(self):
        self.assertLess(len(self.keep(False, False, 12.0)), len(self.keep(False, False, 2.0)))
        turned = [KeyPoint((SIZE[0] - x, SIZE[1] - y)) for x, y in self.right]
        self.keypoints[1] = turned
        self.assertLess(len(self.keep(False, False)), 0.2 * self.truth.sum())
        self.assertGreater(len(self.keep(True, False)), 0.5 * self.truth.sum())

    def test_wrong_input(self):
        self.assertEqual(opencv.matchGMS(SIZE, SIZE, [], [], []), [])
        self.matches.append(DMatch(1200, 0))
        with self.assertRaises(IndexError):
            self.keep()
        with self.assertRaisesRegex(ValueError, "left_size"):
            opencv.matchGMS((640, -1), SIZE, [], [], [])


if __name__ == "__main__":
    unittest.main()
