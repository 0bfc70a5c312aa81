#!/usr/bin/env python3
"""The Python module for consumers, as it is found in the build folder."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

import cv2
import numpy as np
from corrsel import matches
from corrsel.msg import Correspondences, Selection, Tracks


def example():
    """Return three matches; the first two share the left feature 7."""
    return Correspondences(
        left_x=[1, 1, 5],
        left_y=[2, 2, 6],
        right_x=[10, 20, 30],
        right_y=[11, 21, 31],
        distance=[0.5, 0.25, 0.75],
        left_index=[7, 7, 3],
        right_index=[0, 1, 2],
    )


class Matches(unittest.TestCase):
    """Points, keypoints and rows from messages."""

    def test_points_are_arrays_that_opencv_takes(self):
        """Two float32 arrays of one row a match."""
        left, right = matches.points(example())
        self.assertEqual((left.dtype, left.shape), (np.float32, (3, 2)))
        np.testing.assert_array_equal(left, [[1, 2], [1, 2], [5, 6]])
        np.testing.assert_array_equal(right, [[10, 11], [20, 21], [30, 31]])
        affine, inliers = cv2.estimateAffinePartial2D(left[1:], right[1:])
        self.assertEqual((affine.shape, len(inliers)), ((2, 3), 2))

    def test_no_matches(self):
        """An empty message gives empty arrays and lists."""
        left, right = matches.points(Correspondences())
        self.assertEqual((left.shape, right.shape), ((0, 2), (0, 2)))
        self.assertEqual(matches.keypoints(Correspondences()), ([], [], []))

    def test_a_shared_feature_is_one_keypoint(self):
        """Keypoints are as many as features, matches point to them."""
        result = matches.keypoints(example())
        self.assertEqual([point.pt for point in result.left], [(1, 2), (5, 6)])
        self.assertEqual([point.class_id for point in result.left], [7, 3])
        self.assertEqual([match.queryIdx for match in result.matches], [0, 0, 1])
        self.assertEqual([match.trainIdx for match in result.matches], [0, 1, 2])
        self.assertEqual([match.distance for match in result.matches], [0.5, 0.25, 0.75])
        self.assertEqual((result.left[0].size, result.left[0].angle), (0, -1))
        image = np.zeros((40, 40), np.uint8)
        drawn = cv2.drawMatches(image, result.left, image, result.right, result.matches, None)
        self.assertEqual(drawn.shape, (40, 80, 3))

    def test_without_feature_numbers(self):
        """Every match has keypoints of its own."""
        message = example()
        message.left_index, message.distance = [], []
        result = matches.keypoints(message)
        self.assertEqual([point.class_id for point in result.left], [-1, -1, -1])
        self.assertEqual([match.queryIdx for match in result.matches], [0, 1, 2])
        self.assertEqual(result.matches[0].distance, np.finfo(np.float32).max)
        message.probability = [0.25, 1, 0.75]
        self.assertEqual([match.distance for match in matches.keypoints(message).matches], [0.75, 0, 0.25])

    def test_frames_give_size_and_angle(self):
        """Diameter of the circle of equal area, angle of the first axis."""
        message = example()
        message.left_index = []
        message.left_frame = [0, -3, 1, 3, 0, 2, 2, 0, 1, 0, 8, 2, 0, 1, 5, -1, 0, 6]
        result = matches.keypoints(message)
        np.testing.assert_allclose([point.size for point in result.left], [6, 8, 2])
        np.testing.assert_allclose([point.angle for point in result.left], [90, 0, 270])

    def test_selected_rows(self):
        """The ones of the mask, whether it was sent (bytes) or made here (a list)."""
        for mask in ([0, 1, 0, 1], b"\0\1\0\1"):
            np.testing.assert_array_equal(matches.selected_rows(Selection(mask=mask, n_input=4)), [1, 3])
        with self.assertRaisesRegex(ValueError, "mask has 2 elements, expected 3"):
            matches.selected_rows(Selection(mask=[0, 1], n_input=3))

    def test_groups(self):
        """One number for each element of the mask, or none at all."""
        numbers = matches.groups(Selection(mask=[1, 0, 1], group=[0, -1, 1]))
        self.assertEqual((numbers.dtype, numbers.tolist()), (np.int32, [0, -1, 1]))
        self.assertIsNone(matches.groups(Selection(mask=[1, 0, 1])))
        with self.assertRaisesRegex(ValueError, "group has 2 elements, expected 0 or 3"):
            matches.groups(Selection(mask=[1, 0, 1], group=[0, 1]))

    def test_wrong_lengths_are_named(self):
        """The error names the array and its number of elements."""
        for field, values in (
            ("left_y", [1]),
            ("right_index", [1]),
            ("left_frame", [1]),
            ("probability", [1]),
        ):
            message = example()
            setattr(message, field, values)
            with self.assertRaisesRegex(ValueError, field + " has 1 elements, expected"):
                matches.keypoints(message)

    def test_tracks_of_a_message(self):
        """A structured array with one row for each feature."""
        message = Tracks(id=[2**60 + 1, 7], age=[3, 2], x=[1.5, 2], y=[4, 5], feature_index=[9, 0])
        message.previous_x, message.previous_y = [1, float("nan")], [3, float("nan")]
        message.header.stamp.secs, message.header.stamp.nsecs = 1700000000, 1
        rows = matches.tracks(message)
        self.assertEqual(rows["track"].tolist(), [2**60 + 1, 7])
        self.assertEqual(rows["stamp"].tolist(), [1700000000000000001] * 2)
        self.assertEqual(rows["keypoint"].tolist(), [9, 0])
        self.assertEqual(rows["x"].tolist(), [1.5, 2])
        self.assertEqual(rows["age"].tolist(), [3, 2])
        self.assertTrue(np.isnan(rows["previous_y"][1]))
        message.y.append(1)
        with self.assertRaisesRegex(ValueError, "y has 3 elements, expected 2"):
            matches.tracks(message)
        self.assertEqual(len(matches.tracks(Tracks())), 0)

    def test_tracks_of_a_file(self):
        """The same fields; a line that is not complete is left out, a wrong one is named."""
        head = "track,stamp,keypoint,x,y\n2,1700000000000000001,5,1000.125,0.5\n"
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "tracks.csv"
            path.write_text(head + "3,17000", encoding="ascii")
            rows = matches.tracks(path)
            self.assertEqual(rows.tolist(), [(2, 1700000000000000001, 5, 1000.125, 0.5)])
            path.write_text(head + "3,17000\n", encoding="ascii")
            with self.assertRaisesRegex(ValueError, "tracks.csv, line 3 is '3,17000'"):
                matches.tracks(path)
            path.write_text("track,image\n", encoding="ascii")
            with self.assertRaisesRegex(ValueError, "no file of tracks"):
                matches.tracks(path)

    def test_without_opencv(self):
        """points() works; keypoints() names the package to install."""
        program = """
import sys
sys.modules["cv2"] = None
from corrsel import matches
from corrsel.msg import Correspondences
print(len(matches.points(Correspondences())))
matches.keypoints(Correspondences())
"""
        result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
        self.assertEqual(result.stdout, "2\n", result.stderr)
        self.assertIn("install python3-opencv", result.stderr)


if __name__ == "__main__":
    unittest.main()
