#!/usr/bin/env python3
"""Tests of corrsel.files: readers and writers of match files. Run: python3 test_match_files.py"""
import contextlib
import io
import pathlib
import sqlite3
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np

sys.dont_write_bytecode = True
from corrsel.files import __main__ as export_matches, colmap, hloc, pairs, reading, truth  # noqa: E402

try:
    import h5py
except ImportError:
    h5py = None

LEFT = np.array([[10, 20], [30.5, 40], [50, 60], [70, 80]], np.float32)
RIGHT = np.array([[1, 2], [3, 4.25], [5, 6]], np.float32)
MATCHES = np.array([2, -1, 0, 1])  # of every left keypoint
CONFIDENCES = np.array([0.9, 0.1, 0.75, 0.5], np.float32)


class MatchFiles(unittest.TestCase):
    """A folder of its own for every test."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = pathlib.Path(temporary.name)

    def read(self, source, **options):
        """The pairs of an input, by their keys."""
        request = reading.Request(self.root / source, **options)
        return {pair.key: pair for pair in reading.read_pairs(request)}

    def refusal(self, source, **options):
        """What an input is refused with."""
        with self.assertRaises(pairs.InputError) as caught:
            self.read(source, **options)
        return str(caught.exception)

    def expect_refused(self, parts, source, **options):
        """An input is refused with a message that holds these parts."""
        text = self.refusal(source, **options)
        for part in parts:
            self.assertIn(part, text)

    def npz(self, name, **arrays):
        """Writes an NPZ file."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(str(path), **arrays)

    def expect_three_matches(self, pair):
        """The matches of MATCHES."""
        np.testing.assert_array_equal(pair.left, LEFT[[0, 2, 3]])
        np.testing.assert_array_equal(pair.right, RIGHT[[2, 0, 1]])
        np.testing.assert_array_equal(pair.left_index, [0, 2, 3])
        np.testing.assert_array_equal(pair.right_index, [2, 0, 1])
        self.assertEqual((pair.left_count, pair.right_count), (4, 3))


class Npz(MatchFiles):
    """One file for each pair."""

    def test_superglue(self):
        """A number for every left keypoint, -1 = none; the ending of the file is no part of the name."""
        self.npz(
            "set/a/x_y_matches.npz",
            keypoints0=LEFT,
            keypoints1=RIGHT,
            matches=MATCHES,
            match_confidence=CONFIDENCES,
        )
        found = self.read("set")
        self.assertEqual(list(found), ["a/x_y"])
        self.expect_three_matches(found["a/x_y"])
        np.testing.assert_allclose(found["a/x_y"].probability, [0.9, 0.75, 0.5], atol=1e-6)
        self.assertIsNone(found["a/x_y"].distance)
        self.assertIsNone(found["a/x_y"].second_distance)
        self.assertEqual(found["a/x_y"].truth.kind, "none")

    def test_lightglue(self):
        """Pairs of numbers with a score for each, or matches0 with matching_scores0, in batches of one."""
        rows = np.array([[0, 2], [2, 0], [3, 1]])
        self.npz(
            "pairs.npz",
            keypoints0=LEFT[None],
            keypoints1=RIGHT[None],
            matches=rows,
            scores=CONFIDENCES[[0, 2, 3]],
        )
        self.npz(
            "batch.npz",
            keypoints0=LEFT[None],
            keypoints1=RIGHT[None],
            matches0=MATCHES[None],
            matching_scores0=CONFIDENCES[None],
        )
        for name in ("pairs", "batch"):
            pair = self.read(name + ".npz")[name]
            self.expect_three_matches(pair)
            np.testing.assert_allclose(pair.probability, [0.9, 0.75, 0.5], atol=1e-6)

    def test_loftr(self):
        """Matched points, row by row, without numbers."""
        self.npz("a.npz", mkpts0=LEFT[:3], mkpts1=RIGHT, mconf=CONFIDENCES[:3])
        self.npz("b.npz", keypoints0=LEFT[:3], keypoints1=RIGHT, confidence=CONFIDENCES[:3])
        for name in "ab":
            pair = self.read(name + ".npz")[name]
            np.testing.assert_array_equal(pair.left, LEFT[:3])
            np.testing.assert_array_equal(pair.right, RIGHT)
            np.testing.assert_allclose(pair.probability, [0.9, 0.1, 0.75], atol=1e-6)
            self.assertIsNone(pair.left_index)

    def test_scores(self):
        """Confidences are probabilities, descriptor distances stay as they are, and both can be left out."""
        self.npz("a.npz", mkpts0=LEFT[:3], mkpts1=RIGHT, mconf=[200, 3, 0.5])
        pair = self.read("a.npz", scores="distance")["a"]
        np.testing.assert_array_equal(pair.distance, [200, 3, 0.5])
        self.assertIsNone(pair.probability)
        pair = self.read("a.npz", scores="none")["a"]
        self.assertEqual((pair.distance, pair.probability), (None, None))
        self.expect_refused(
            ["a.npz: mconf, row 0 is 200", "confidence from 0 to 1", "--scores distance"], "a.npz"
        )
        self.npz("b.npz", mkpts0=LEFT[:1], mkpts1=RIGHT[:1], distance=[np.inf])
        self.expect_refused(["b.npz: distance, row 0 is inf, expected a finite distance from 0"], "b.npz")
        self.npz("b.npz", mkpts0=LEFT[:1], mkpts1=RIGHT[:1], mconf=[np.float16(1.0005)])
        self.assertEqual(self.read("b.npz")["b"].probability, [1])
        columns = {"distance": [9, 8, 7], "match_probability": [0.5, np.nan, 1]}
        self.npz("c.npz", mkpts0=LEFT[:3], mkpts1=RIGHT, **columns)
        pair = self.read("c.npz", scores="none")["c"]
        np.testing.assert_array_equal(pair.distance, [9, 8, 7])
        np.testing.assert_array_equal(pair.probability, np.float32([0.5, np.nan, 1]))

    def test_truth_and_images(self):
        """Names, sizes and ground truth of a file; labels of the keypoints or of the matches."""
        common = {"keypoints0": LEFT, "keypoints1": RIGHT, "matches": MATCHES}
        homography = np.array([[1, 0, 5], [0, 1, 0], [0, 0, 1]])
        self.npz("h.npz", H=homography, image0="db/1.jpg", image_size0=(640, 480), **common)
        pair = self.read("h.npz")["h"]
        self.assertEqual((pair.truth.kind, pair.left_name, pair.right_name), ("homography", "db/1.jpg", ""))
        self.assertEqual((pair.left_size, pair.right_size), ((640, 480), (0, 0)))
        np.testing.assert_array_equal(pair.truth.matrix, homography)
        for labels in ([1, 5, 0, 2], [1, 0, 2]):
            self.npz("l.npz", labels=labels, **common)
            np.testing.assert_array_equal(self.read("l.npz")["l"].truth.labels, [1, 0, 2])
        self.npz("two.npz", H=homography, F=homography, **common)
        self.expect_refused(["two.npz", "H and F are several ground truths"], "two.npz")
        self.npz("half.npz", labels=[1, 0.5, 0], **common)
        self.expect_refused(["half.npz: labels, row 1 is 0.5"], "half.npz")
        self.npz("small.npz", H=np.eye(2), **common)
        self.expect_refused(["small.npz: H has the shape 2x2, expected 3x3"], "small.npz")

    def test_pose(self):
        """K0, K1 and T_0to1 become a fundamental matrix that the points of a scene fulfil."""
        left_camera, right_camera = np.diag([500.0, 510, 1]), np.diag([600.0, 590, 1])
        left_camera[:2, 2], right_camera[:2, 2] = (320, 240), (300, 200)
        motion = np.eye(4)
        motion[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        motion[:3, 3] = (0.5, -0.2, 0.1)
        points = np.random.default_rng(0).uniform((-1, -1, 3), (1, 1, 9), (20, 3))
        left, right = points @ left_camera.T, (points @ motion[:3, :3].T + motion[:3, 3]) @ right_camera.T
        arrays = {
            "mkpts0": LEFT[:3],
            "mkpts1": RIGHT,
            "K0": left_camera,
            "K1": right_camera,
            "T_0to1": motion,
        }
        self.npz("a.npz", **arrays)
        found = self.read("a.npz")["a"].truth
        self.assertEqual(found.kind, "fundamental")
        np.testing.assert_allclose(np.einsum("ni,ij,nj->n", right, found.matrix, left), 0, atol=1e-9)
        np.testing.assert_array_equal(found.pose[2], motion[:3, :3])
        self.npz("b.npz", **{**arrays, "T_0to1": np.diag([1, 1, 2, 1])})
        self.expect_refused(["b.npz: R is", "not a rotation"], "b.npz")
        self.npz("c.npz", **{**arrays, "K1": np.zeros((3, 3))})
        self.expect_refused(["c.npz: K of the right image is"], "c.npz")

    def test_exchanged_sides_keep_their_truth(self):
        """The ground truth of a pair that is read the other way round."""
        motion = np.eye(4)
        motion[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        motion[:3, 3] = (0.5, -0.2, 0.1)
        numbers = np.concatenate(
            [np.diag([500.0, 510, 1]).ravel(), np.diag([600.0, 590, 1]).ravel(), motion.ravel()]
        )
        pair = pairs.MatchedPair(
            "s", "k", LEFT[:3], RIGHT, left_name="a", truth=truth.pose_of_numbers(numbers, "s")
        )
        other = pair.exchanged()
        self.assertEqual((other.left_name, other.right_name), ("", "a"))
        np.testing.assert_array_equal(other.left, RIGHT)
        back = truth.pose_truth(*other.truth.pose, "s").matrix
        for matrix in (other.truth.matrix, -other.truth.matrix):
            if np.allclose(matrix, back, atol=1e-12):
                return
        self.fail("the fundamental matrix of the exchanged pose differs")

    def test_wrong_input(self):
        """Every error names the file, the key and the value."""
        common = {"keypoints0": LEFT, "keypoints1": RIGHT}
        cases = {
            "out": (
                {"matches": [0, 1, 2, 3]},
                ["matches, row 3 names the right keypoint 3, but there are 3"],
            ),
            "under": ({"matches": [0, -2, 2, 1]}, ["matches, row 1 names the right keypoint -2"]),
            "half": ({"matches": [0, 0.5, 2, 1]}, ["matches has the shape 4 and the type float64"]),
            "short": ({"matches": [0, 1]}, ["matches has the shape 2", "expected 4 whole numbers"]),
            "scores": (
                {"matches": MATCHES, "scores": [1, 1]},
                ["scores has the shape 2", "expected 4 numbers"],
            ),
            "nan": ({"matches": MATCHES, "scores": [1, 1, np.nan, 1]}, ["scores, row 1 is nan"]),
            "size": ({"matches": MATCHES, "image_size1": (0, 5)}, ["image_size1 is [0, 5]"]),
            "rows": ({}, ["keypoints0 has 4 rows and keypoints1 has 3"]),
        }
        for name, (arrays, parts) in cases.items():
            self.npz(name + ".npz", **common, **arrays)
            self.expect_refused([name + ".npz"] + parts, name + ".npz")
        self.npz("wide.npz", keypoints0=np.zeros((4, 3)), keypoints1=RIGHT, matches=MATCHES)
        self.expect_refused(["wide.npz: keypoints0 has the shape 4x3"], "wide.npz")
        self.npz("where.npz", keypoints0=np.where(LEFT > 60, np.nan, LEFT), keypoints1=RIGHT, matches=MATCHES)
        self.expect_refused(["where.npz: keypoints0, row 3 is (nan, nan)"], "where.npz")
        self.npz("far.npz", keypoints0=LEFT * np.float64(1e300), keypoints1=RIGHT, matches=MATCHES)
        self.expect_refused(["far.npz: keypoints0, row 0 is (1e+301, 2e+301)"], "far.npz")
        self.npz("other.npz", points=LEFT)
        self.expect_refused(["other.npz has no key keypoints0 (it has points)"], "other.npz")
        self.npz("one.npz", keypoints0=LEFT, matches=MATCHES)
        self.expect_refused(["one.npz has no key keypoints1"], "one.npz")
        (self.root / "cut.npz").write_bytes((self.root / "one.npz").read_bytes()[:200])
        self.expect_refused(["cut.npz is damaged or no NPZ file"], "cut.npz")
        (self.root / "text.npz").write_text("text", encoding="utf-8")
        self.expect_refused(["text.npz does not begin like a file of its kind"], "text.npz")

    def test_wrong_truth_and_names(self):
        """Ground truth and names of other shapes and types than those of the documentation."""
        pose = {"K0": np.eye(3), "K1": np.eye(3), "T_0to1": np.eye(4)}
        turned = np.eye(4)
        turned[3, :3] = (1, 2, 3)
        for arrays, part in (
            ({**pose, "T_0to1": np.eye(3)}, "T has the shape 3x3, expected 4x4"),
            ({**pose, "T_0to1": turned}, "last row of T is [1.0, 2.0, 3.0, 1.0], expected 0 0 0 1"),
            ({**pose, "T_0to1": "x"}, "T is not numeric"),
            ({**pose, "K0": [[1, 1, 0], [1, 1, 0], [0, 0, 1]]}, "K of the left image is"),
            ({"H": np.eye(3) * 1j}, "H is not numeric"),
            ({"H": np.ones((3, 3))}, "which has the rank 1, expected 3"),
            ({"F": np.outer((1, 2, 3), (1, 2, 3))}, "which has the rank 1, expected 2"),
            ({"image_size0": ["a", "b"]}, "image_size0 is ['a', 'b']"),
            ({"image0": 3}, "image0 has the shape of one value and the type int64, expected a text"),
            ({"image0": ["a", "b"]}, "image0 has the shape 2"),
            ({"image0": np.array(b"\xff")}, "image0 is no UTF-8 text"),
        ):
            self.npz("a.npz", mkpts0=LEFT[:3], mkpts1=RIGHT, **arrays)
            self.expect_refused(["a.npz", part], "a.npz")
        for name in ("db/1.jpg", ["db/1.jpg"], np.array(b"db/1.jpg")):
            self.npz("a.npz", mkpts0=LEFT[:3], mkpts1=RIGHT, image0=name)
            self.assertEqual(self.read("a.npz")["a"].left_name, "db/1.jpg")

    def test_damaged_files(self):
        """A compressed array that cannot be unpacked, and an array without a key."""
        path = self.root / "set/a.npz"
        path.parent.mkdir()
        np.savez_compressed(str(path), mkpts0=np.random.default_rng(0).random((99, 2)), mkpts1=RIGHT)
        whole = path.read_bytes()
        path.write_bytes(whole[:60] + bytes(20) + whole[80:])
        self.expect_refused(["a.npz is damaged or no NPZ file (Error -3"], "set")
        with open(str(path), "wb") as file:
            np.save(file, LEFT)
        self.expect_refused(["a.npz is damaged or no NPZ file (it holds an array without a key)"], "set")

    def test_objects_are_not_unpickled(self):
        """A file may not run programs."""
        self.npz("a.npz", mkpts0=LEFT[:3], mkpts1=RIGHT, mconf=np.array([{}, 1, 2], dtype=object))
        self.assertIsNone(self.read("a.npz")["a"].probability)


class Lists(MatchFiles):
    """Lists of pairs, folders of ground truth, and inputs as a whole."""

    def test_list_of_pairs(self):
        """SuperGlue's lists name the images of a file and hold poses."""
        for name in ("a_b_matches", "b_c"):
            self.npz("set/%s.npz" % name, keypoints0=LEFT, keypoints1=RIGHT, matches=MATCHES)
        numbers = " ".join(
            map(
                str,
                [500, 0, 320, 0, 500, 240, 0, 0, 1] * 2 + [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
            )
        )
        list_file = self.root / "pairs.txt"
        list_file.write_text("# two pairs\nx/a.jpg y/b.png 0 0 %s\nb.png c.png\n" % numbers, encoding="utf-8")
        found = self.read("set", pairs=list_file)
        self.assertEqual(list(found), ["a_b", "b_c"])
        self.assertEqual((found["a_b"].left_name, found["a_b"].right_name), ("x/a.jpg", "y/b.png"))
        self.assertEqual([pair.truth.kind for pair in found.values()], ["fundamental", "none"])
        for line, parts in (
            ("a b c", ["line 1 has 3 words", "expected 2"]),
            ("a.jpg b.jpg 0 1", ["line 1: the images are to be rotated by 0 and 1"]),
            ("a.jpg b.jpg 0 0 " + numbers.replace("500", "x", 1), ["line 1", "'x'"]),
            ("a.jpg b.jpg\na.jpg b.jpg", ["line 2: the pair a.jpg b.jpg stands in line 1, too"]),
            ("a.jpg z.jpg", ["line 1: neither a_z_matches.npz nor a_z.npz is in"]),
            ("", ["holds no pair"]),
        ):
            list_file.write_text(line + "\n", encoding="utf-8")
            self.expect_refused(["pairs.txt"] + parts, "set", pairs=list_file)

    def test_truth_in_a_folder(self):
        """H.txt, F.txt or pose.txt of each pair."""
        self.npz("set/s/one.npz", mkpts0=LEFT[:3], mkpts1=RIGHT)
        self.npz("set/two.npz", mkpts0=LEFT[:3], mkpts1=RIGHT)
        folder = self.root / "truth"
        (folder / "s/one").mkdir(parents=True)
        (folder / "s/one/H.txt").write_text("1 0 5\n0 1 0\n0 0 1\n", encoding="utf-8")
        found = self.read("set", truth=folder)
        self.assertEqual([found[key].truth.kind for key in ("s/one", "two")], ["homography", "none"])
        (folder / "s/one/H.txt").write_text("1 0 5", encoding="utf-8")
        self.expect_refused(["s/one/H.txt holds 3 numbers, expected 9"], "set", truth=folder)
        (folder / "s/one/F.txt").write_text("1 0 5", encoding="utf-8")
        self.expect_refused(["s/one", "several ground truths"], "set", truth=folder)
        self.expect_refused(["nowhere is not a folder of ground truth"], "set", truth=self.root / "nowhere")

    def test_csv(self):
        """The columns of matches.csv, and those of a run's folder."""
        (self.root / "set/desk").mkdir(parents=True)
        file = self.root / "set/desk/matches.csv"
        file.write_text(
            "# x_left,y_left,x_right,y_right,ratio,label\n1,2,3,4,0.5,1\n5,6,7,8,0.9,0\n", encoding="utf-8"
        )
        pair = self.read("set")["desk"]
        np.testing.assert_array_equal(pair.right, [[3, 4], [7, 8]])
        np.testing.assert_allclose(pair.distance, [0.5, 0.9], atol=1e-6)
        np.testing.assert_array_equal(pair.second_distance, [1, 1])
        self.assertIsNone(pair.probability)
        np.testing.assert_array_equal(pair.truth.labels, [1, 0])
        file.write_text(
            "x_left,y_left,x_right,y_right,match_probability\n1,2,3,4,0.25\n5,6,7,8,nan\n", encoding="utf-8"
        )
        pair = self.read("set")["desk"]
        np.testing.assert_array_equal(pair.probability, np.float32([0.25, np.nan]))
        self.assertIsNone(pair.distance)
        frames = "a11_left,a12_left,a21_left,a22_left,a11_right,a12_right,a21_right,a22_right"
        file.write_text(
            "row,x_left,y_left,x_right,y_right,%s,score,group\n4,1,2,3,4,5,6,7,8,9,10,11,12,nan,-1\n"
            % frames,
            encoding="utf-8",
        )
        pair = self.read("set")["desk"]
        np.testing.assert_array_equal(pair.right_shape, [[9, 10, 11, 12]])
        file.write_text(
            "x_left,y_left,x_right,y_right,size_left,angle_left,size_right,angle_right\n1,2,3,4,6,90,2,0\n",
            encoding="utf-8",
        )
        pair = self.read("set")["desk"]
        np.testing.assert_allclose(pair.left_shape, [[0, -3, 3, 0]], atol=1e-6)
        np.testing.assert_allclose(pair.right_shape, [[1, 0, 0, 1]], atol=1e-6)

    def test_wrong_csv(self):
        """Every error names the file, the line, the column and the value."""
        header = "x_left,y_left,x_right,y_right"
        for text, parts in (
            ("", ["is empty"]),
            ("x_left,y_left,x_right\n", ["line 1", "y_right is missing"]),
            (header + ",depth\n", ["line 1: 'depth' is not a column"]),
            (header + ",x_left\n", ["'x_left' stands there twice"]),
            (header + ",index_left\n", ["index_right is missing"]),
            (header + ",ratio,second_distance\n", ["state the same"]),
            (header + "\n1,2,3\n", ["line 2 has 3 values"]),
            (header + "\n\n1,2,3,4\n1,2,x,4\n", ["line 4, column 'x_right': 'x' is not a number"]),
            (header + ",label\n1,2,3,4,-1\n", ["line 2, column 'label': '-1' is not a whole number"]),
            (header + ",distance\n1,2,3,4,-1\n", ["column 'distance': '-1' is not a finite number from 0"]),
            (header + ",distance\n1,2,3,4,inf\n", ["column 'distance': 'inf' is not a finite number from 0"]),
            (header + ",ratio\n1,2,3,4,1e39\n", ["column 'ratio': '1e39' is not a finite number from 0"]),
            (
                header + ",match_probability\n1,2,3,4,1.5\n",
                ["column 'match_probability': '1.5' is not a number from 0 to 1"],
            ),
            (header + "\n1,2,nan,4\n", ["x_right, y_right, row 0 is (nan, 4.0)"]),
        ):
            (self.root / "m.csv").write_text(text, encoding="utf-8")
            self.expect_refused(["m.csv"] + parts, "m.csv")

    def test_other_inputs(self):
        """A folder without files, with both kinds, or nothing at all; pairs of one name."""
        (self.root / "set").mkdir()
        self.expect_refused(["set holds neither .npz nor .csv files"], "set")
        self.expect_refused(["nowhere cannot be read (No such file"], "nowhere")
        self.npz("set/a.npz", mkpts0=LEFT[:3], mkpts1=RIGHT)
        (self.root / "set/a.csv").write_text("", encoding="utf-8")
        self.expect_refused(["set holds both"], "set")
        (self.root / "set/a.csv").unlink()
        self.npz("set/a_matches.npz", mkpts0=LEFT[:3], mkpts1=RIGHT)
        self.expect_refused(["a.npz", "a_matches.npz", "have the same name 'a'"], "set")

    def test_names_of_pairs_of_images(self):
        """The common folder is the sequence."""
        self.assertEqual(reading.key_of("db/1.jpg", "db/2.jpg"), "db/1.jpg-2.jpg")
        self.assertEqual(reading.key_of("s/db/1.jpg", "s/q/2.jpg"), "s/db:1.jpg-q:2.jpg")
        self.assertEqual(reading.key_of("1.jpg", "q/2.jpg"), "1.jpg-q:2.jpg")
        self.assertEqual(reading.key_of("/db/1.jpg", "db/2.jpg"), "db/1.jpg-2.jpg")
        self.assertEqual(reading.key_of("/1.jpg", "/2.jpg"), "1.jpg-2.jpg")


@unittest.skipUnless(h5py, "needs h5py")
class Hloc(MatchFiles):
    """Two HDF5 files."""

    def setUp(self):
        super().setUp()
        self.features = self.root / "features.h5"
        with h5py.File(str(self.features), "w") as file:
            for name, points in (("db/1.jpg", LEFT), ("db/2_b.jpg", RIGHT), ("q.jpg", LEFT)):
                file[name + "/keypoints"] = points
                file[name + "/image_size"] = [640, 480]

    def matches(self, groups):
        """Writes the file of the matches."""
        with h5py.File(str(self.root / "matches.h5"), "w") as file:
            for name, values in groups.items():
                file[name + "/matches0"] = values.astype(np.int16)
                file[name + "/matching_scores0"] = CONFIDENCES[: len(values)].astype(np.float16)

    def test_both_encodings(self):
        """A/B, and A_B of older files, whose names may have '_' themselves."""
        for group in ("db-1.jpg/db-2_b.jpg", "db-1.jpg_db-2_b.jpg"):
            self.matches({group: MATCHES})
            found = self.read("matches.h5", features=self.features)
            self.assertEqual(list(found), ["db/1.jpg-2_b.jpg"])
            pair = found["db/1.jpg-2_b.jpg"]
            self.expect_three_matches(pair)
            self.assertEqual((pair.left_name, pair.right_name), ("db/1.jpg", "db/2_b.jpg"))
            self.assertEqual((pair.left_size, pair.right_size), ((640, 480), (640, 480)))
            np.testing.assert_allclose(pair.probability, [0.9, 0.75, 0.5], atol=1e-3)

    def test_listed_pairs(self):
        """In the order of the list, which also exchanges the sides."""
        self.matches({"db-1.jpg/db-2_b.jpg": MATCHES, "q.jpg/db-2_b.jpg": MATCHES})
        list_file = self.root / "pairs.txt"
        list_file.write_text("db/2_b.jpg db/1.jpg\n", encoding="utf-8")
        found = self.read("matches.h5", features=self.features, pairs=list_file)
        pair = found["db/2_b.jpg-1.jpg"]
        np.testing.assert_array_equal(pair.right, LEFT[[0, 2, 3]])
        np.testing.assert_array_equal(pair.right_index, [0, 2, 3])
        list_file.write_text("db/1.jpg q.jpg\n", encoding="utf-8")
        self.expect_refused(
            ["pairs.txt, line 1: the pair db/1.jpg q.jpg is not in"],
            "matches.h5",
            features=self.features,
            pairs=list_file,
        )

    def test_names_that_are_encoded_alike(self):
        """Cannot be told apart without a list."""
        with h5py.File(str(self.features), "a") as file:
            file["db-1.jpg/keypoints"] = LEFT
        self.matches({"db-1.jpg/q.jpg": np.array([0, 1, 2, 3])})
        self.expect_refused(
            ["'db-1.jpg' stands for db-1.jpg or db/1.jpg", "--pairs"], "matches.h5", features=self.features
        )

    def test_wrong_files(self):
        """Every error names the file, the group and the value."""
        self.matches({"db-1.jpg/db-2_b.jpg": MATCHES + 1})
        self.expect_refused(
            ["matches.h5: db-1.jpg/db-2_b.jpg/matches0, row 0 names the right keypoint 3"],
            "matches.h5",
            features=self.features,
        )
        self.matches({"db-1.jpg/z.jpg": MATCHES})
        self.expect_refused(
            ["group db-1.jpg/z.jpg: 'z.jpg' is no image of", "features.h5"],
            "matches.h5",
            features=self.features,
        )
        self.matches({"db-1.jpg_z.jpg": MATCHES})
        self.expect_refused(["none of its splits at '_'"], "matches.h5", features=self.features)
        self.matches({})
        self.expect_refused(["matches.h5 has no group with matches0"], "matches.h5", features=self.features)
        self.expect_refused(["name the file of the keypoints by --features"], "matches.h5")
        self.expect_refused(
            ["matches.h5 has no group with keypoints"], "matches.h5", features=self.root / "matches.h5"
        )
        for place, values, part in (
            ("features.h5", {"q.jpg/keypoints": 3.0}, "q.jpg/keypoints has the shape of one value"),
            ("features.h5", {"q.jpg/keypoints": LEFT[0]}, "q.jpg/keypoints has the shape 2"),
            ("features.h5", {"q.jpg/keypoints/x": LEFT}, "q.jpg/keypoints is a group, expected numbers"),
            ("features.h5", {"q.jpg/image_size/x": 3}, "q.jpg/image_size is a group, expected numbers"),
            ("matches.h5", {"q.jpg/db-1.jpg/matches0/x": 3}, "matches0 is a group, expected numbers"),
        ):
            with h5py.File(str(self.features), "a") as file:
                del file["q.jpg"]
                file["q.jpg/keypoints"] = LEFT
            self.matches({"q.jpg/db-1.jpg": MATCHES})
            with h5py.File(str(self.root / place), "a") as file:
                for name, value in values.items():
                    if name.split("/x")[0] in file:
                        del file[name.split("/x")[0]]
                    file[name] = value
                file["q.jpg/remark"] = "no pair"
            self.expect_refused([place, part], "matches.h5", features=self.features)
        self.matches({"q.jpg/db-1.jpg": MATCHES})
        whole, text = (self.root / "matches.h5").read_bytes(), ""
        for place in range(0, len(whole), 97):
            (self.root / "hit.h5").write_bytes(
                whole[:place] + bytes(~b & 255 for b in whole[place : place + 4]) + whole[place + 4 :]
            )
            try:
                self.read("hit.h5", features=self.features)
            except pairs.InputError as error:
                text += str(error)
        self.assertIn(" is damaged (", text)
        (self.root / "cut.h5").write_bytes(self.features.read_bytes()[:500])
        self.expect_refused(["cut.h5 is damaged or no HDF5 file"], "cut.h5", features=self.features)

    def test_without_the_package(self):
        """The message names it."""
        self.matches({"db-1.jpg/db-2_b.jpg": MATCHES})
        with mock.patch.object(hloc, "h5py", None):
            self.expect_refused(["apt install python3-h5py"], "matches.h5", features=self.features)


class Colmap(MatchFiles):
    """Databases."""

    def setUp(self):
        super().setUp()
        self.path = self.root / "database.db"
        rows = np.array([[0, 2], [2, 0], [3, 1]])
        images = [("b/2.jpg", (700, 500), RIGHT, None), ("b/1.jpg", (640, 480), LEFT, None)]
        colmap.write_database(self.path, images, [(1, 0, rows)])

    def change(self, statement, *values):
        """Runs SQL on the database."""
        database = sqlite3.connect(str(self.path))
        database.execute(statement, values)
        database.commit()
        database.close()

    def test_what_is_written_is_read(self):
        """The pair has the order of the numbers of the images, and positions that differ by half a pixel in the file."""
        pair = self.read("database.db")["b/2.jpg-1.jpg"].exchanged()
        self.expect_three_matches(pair)
        self.assertEqual((pair.left_name, pair.right_name), ("b/1.jpg", "b/2.jpg"))
        self.assertEqual((pair.left_size, pair.right_size), ((640, 480), (700, 500)))
        self.assertIsNone(pair.distance)
        database = sqlite3.connect(str(self.path))
        ((number, count, columns),) = database.execute("SELECT pair_id, rows, cols FROM matches").fetchall()
        self.assertEqual((number, count, columns), (2147483647 * 1 + 2, 3, 2))
        (data,) = database.execute("SELECT data FROM keypoints WHERE image_id = 2").fetchone()
        np.testing.assert_array_equal(np.frombuffer(data, np.float32).reshape(-1, 2), LEFT + 0.5)
        self.assertEqual(database.execute("SELECT count(*) FROM two_view_geometries").fetchone(), (0,))
        self.assertEqual(database.execute("PRAGMA integrity_check").fetchone(), ("ok",))
        self.assertEqual(database.execute("PRAGMA foreign_key_check").fetchall(), [])
        database.close()

    def test_frames(self):
        """Keypoints of four columns are similarities, those of six are affine."""
        affine = np.arange(16, dtype=np.float32).reshape(4, 4)
        for columns, shape in (
            (np.array([[2, np.pi / 2]] * 4, np.float32), [[0, -2, 2, 0]] * 3),
            (affine, affine[[0, 2, 3]]),
        ):
            data = np.concatenate([LEFT + 0.5, columns], axis=1).astype(np.float32)
            self.change(
                "UPDATE keypoints SET cols = ?, data = ? WHERE image_id = 2", data.shape[1], data.tobytes()
            )
            self.assertIsNone(
                self.read("database.db")["b/2.jpg-1.jpg"].right_shape, "the other image has no frames"
            )
            other = np.concatenate([RIGHT + 0.5, columns[:3]], axis=1).astype(np.float32)
            self.change(
                "UPDATE keypoints SET cols = ?, data = ? WHERE image_id = 1", other.shape[1], other.tobytes()
            )
            pair = self.read("database.db")["b/2.jpg-1.jpg"].exchanged()
            np.testing.assert_allclose(pair.left_shape, shape, atol=1e-6)
            np.testing.assert_array_equal(pair.left, LEFT[[0, 2, 3]])
            self.change("UPDATE keypoints SET cols = 2, data = ? WHERE image_id = 1", (RIGHT + 0.5).tobytes())

    def test_listed_pairs(self):
        """The list gives the order of the images."""
        list_file = self.root / "pairs.txt"
        list_file.write_text("b/1.jpg b/2.jpg\n", encoding="utf-8")
        self.expect_three_matches(self.read("database.db", pairs=list_file)["b/1.jpg-2.jpg"])
        list_file.write_text("b/1.jpg b/3.jpg\n", encoding="utf-8")
        self.expect_refused(
            ["pairs.txt, line 1: there is no image 'b/3.jpg'"], "database.db", pairs=list_file
        )

    def test_wrong_databases(self):
        """Every error names the table and the row."""
        whole = self.path.read_bytes()
        for statement, values, parts in (
            (
                "UPDATE matches SET data = ?",
                (b"123",),
                ["table matches, pair_id 2147483649: data has 3 bytes, expected 24"],
            ),
            (
                "UPDATE matches SET data = ?",
                (np.array([[0, 2], [9, 0], [3, 1]], np.uint32).tobytes(),),
                ["match 1 names the keypoint 9 of image_id 1, which has 3"],
            ),
            ("UPDATE matches SET pair_id = 2147483647 * 1 + 7", (), ["there is no image_id 7"]),
            (
                "UPDATE keypoints SET cols = 3",
                (),
                ["table keypoints, image_id 1 has 3 columns, expected 2, 4 or 6"],
            ),
            ("DELETE FROM keypoints", (), ["table keypoints, image_id 1 is missing"]),
            ("DELETE FROM matches", (), ["the table matches is empty"]),
            ("DELETE FROM images", (), ["the table images is empty"]),
            (
                "UPDATE cameras SET width = 0",
                (),
                ["table images, image_id 1 (b/2.jpg): its camera has the size 0x500"],
            ),
            ("UPDATE matches SET data = 5", (), ["pair_id 2147483649: data is 5, expected a BLOB"]),
            ("UPDATE matches SET data = 'text'", (), ["data is 'text', expected a BLOB"]),
            ("UPDATE matches SET rows = 'two'", (), ["rows is 'two', expected a whole number"]),
            ("UPDATE cameras SET width = 'wide'", (), ["its camera has the size widex500"]),
            (
                "UPDATE images SET name = x'ff' WHERE image_id = 1",
                (),
                ["image_id 1 has the name b'\\xff', expected a text"],
            ),
            (
                "UPDATE keypoints SET data = ? WHERE image_id = 1",
                (np.full((3, 2), np.nan, np.float32).tobytes(),),
                ["keypoints of image_id 1, row 0 is (nan, nan)"],
            ),
            ("DROP TABLE matches", (), ["no database of COLMAP (no such table: matches)"]),
        ):
            self.path.write_bytes(whole)
            self.change(statement, *values)
            self.expect_refused(["database.db"] + parts, "database.db")
        self.path.write_bytes(whole.replace(b"CREATE TABLE matches", b"CREATE TABLE m\xfftches"))
        self.expect_refused(["database.db is damaged"], "database.db")
        self.path.write_bytes(whole[: len(whole) // 2])
        self.expect_refused(["database.db is damaged"], "database.db")

    def test_numbers_of_pairs(self):
        """COLMAP's numbers, both ways."""
        self.assertEqual(colmap.pair_id(7, 3), 2147483647 * 3 + 7)
        self.assertEqual(colmap.image_ids(2147483647 * 3 + 7), (3, 7))


def write_run(folder, numbered=True, sizes=True, names=True):
    """A folder of saved matches: two pairs a-b and a-c, whose left image is the same, and two selectors."""
    columns = "row,x_left,y_left,x_right,y_right,match_probability" + (
        ",index_left,index_right" if numbered else ""
    )
    rows = {
        "ab": ["1,2,3,4,0.5,10,0", "5,6,7,8.5,1,11,1", "5,6,9,9,nan,11,2"],
        "ac": ["5,6,1,1,0,11,0", "20,21,2,2,1,12,5"],
    }
    kept = {"usac": {"ab": [0, 2], "ac": [1]}, "lpm%3Av2": {"ab": [], "ac": [0, 1]}}
    header = (
        "file,dataset,sequence,pair,features,preselection,selector,seed,status,n_putative,n_selected,model_kind,model,"
        "putative,left_image,right_image,left_width,left_height,right_width,right_height\n"
    )
    index = header
    size = "640,480,700,500" if sizes else "0,0,0,0"
    for pair, lines in rows.items():
        lines = [line if numbered else line.rsplit(",", 2)[0] for line in lines]
        place = folder / "matches/csv/set/s" / pair / "given/none"
        place.mkdir(parents=True)
        (place / "putative.csv").write_text(
            "\n".join([columns.replace("row,", "")] + lines) + "\n", encoding="utf-8"
        )
        for selector, chosen in kept.items():
            text = "\n".join([columns] + ["%d,%s" % (row, lines[row]) for row in chosen[pair]])
            (place / (selector + ".csv")).write_text(text + "\n", encoding="utf-8")
            name = selector.replace("%3A", ":")
            images = "a.jpg,%s.jpg" % pair[1] if names else "#1,#%s" % pair[1]
            index += (
                "csv/set/s/%s/given/none/%s.csv,set,s,%s,given,none,%s,0,ok,%d,%d,homography,1 0 5 0 1 0 0 0 1,"
                % ((pair, selector, pair, name, len(lines), len(chosen[pair])))
            )
            index += "csv/set/s/%s/given/none/putative.csv,%s,%s\n" % (pair, images, size)
    (folder / "matches/index.csv").write_text(index, encoding="utf-8")


class Export(MatchFiles):
    """Saved matches of a run as NPZ files and databases."""

    def export(self, *arguments):
        """Exit status and output of python3 -m corrsel.files."""
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
            code = export_matches.main([str(self.root), *arguments])
        return code, text.getvalue()

    def test_npz(self):
        """Keypoints are those of the putative matches, and the mask is that of the selection."""
        write_run(self.root)
        self.assertEqual(
            self.export("--format", "npz"), (0, "4 selections written to %s/matches/npz\n" % self.root)
        )
        with np.load(str(self.root / "matches/npz/set/s/ab/given/none/usac.npz")) as file:
            arrays = dict(file)
        np.testing.assert_array_equal(arrays["keypoints0"], [[1, 2], [5, 6]])
        np.testing.assert_array_equal(arrays["keypoints1"], [[3, 4], [7, 8.5], [9, 9]])
        np.testing.assert_array_equal(arrays["index0"], [10, 11])
        np.testing.assert_array_equal(arrays["putative_matches"], [[0, 0], [1, 1], [1, 2]])
        np.testing.assert_array_equal(arrays["mask"], [1, 0, 1])
        np.testing.assert_array_equal(arrays["matches"], [[0, 0], [1, 2]])
        np.testing.assert_array_equal(arrays["model"], [[1, 0, 5], [0, 1, 0], [0, 0, 1]])
        np.testing.assert_array_equal(arrays["image_size1"], [700, 500])
        self.assertEqual(
            (str(arrays["image0"]), str(arrays["model_kind"]), str(arrays["status"])),
            ("a.jpg", "homography", "ok"),
        )
        pair = self.read("matches/npz/set/s/ab/given/none/usac.npz")["usac"]
        np.testing.assert_array_equal(pair.right, [[3, 4], [9, 9]])
        np.testing.assert_array_equal(pair.probability, np.float32([0.5, np.nan]))
        self.assertEqual(pair.left_name, "a.jpg")

    def test_colmap(self):
        """One database for each selector; an image of two pairs is one image with the keypoints of both."""
        for numbered in (True, False):
            write_run(self.root, numbered)
            output = self.root / ("out%d" % numbered)
            code, text = self.export("--format", "colmap", "--output", str(output))
            self.assertEqual((code, text), (0, "2 databases written to %s\n" % output))
            found = self.read(str(output.relative_to(self.root) / "set/given/none/usac.db"))
            self.assertEqual(list(found), ["a.jpg-b.jpg", "a.jpg-c.jpg"])
            np.testing.assert_array_equal(found["a.jpg-b.jpg"].left, [[1, 2], [5, 6]])
            np.testing.assert_array_equal(found["a.jpg-b.jpg"].right, [[3, 4], [9, 9]])
            np.testing.assert_array_equal(found["a.jpg-c.jpg"].left, [[20, 21]])
            self.assertEqual(found["a.jpg-c.jpg"].left_count, 3)
            self.assertEqual(found["a.jpg-c.jpg"].right_size, (700, 500))
            np.testing.assert_array_equal(found["a.jpg-c.jpg"].left_index, [2])
            empty = self.read(str(output.relative_to(self.root) / "set/given/none/lpm%3Av2.db"))
            self.assertEqual([len(pair.left) for pair in empty.values()], [0, 2])
            listed = (output / "set/given/none/usac.pairs.txt").read_text(encoding="utf-8")
            self.assertEqual(listed, "a.jpg b.jpg\na.jpg c.jpg\n")
            for file in sorted((self.root / "matches").rglob("*"), reverse=True):
                file.rmdir() if file.is_dir() else file.unlink()

    def test_the_command_line_of_sqlite(self):
        """Finds a well-formed database with COLMAP's tables."""
        write_run(self.root)
        self.export("--format", "colmap")
        file = str(self.root / "matches/colmap/set/given/none/usac.db")
        try:
            run = subprocess.run(
                ["sqlite3", file, "PRAGMA integrity_check;", ".tables"], stdout=subprocess.PIPE, check=True
            )
        except FileNotFoundError:
            self.skipTest("needs sqlite3")
        words = run.stdout.decode().split()
        self.assertEqual(
            sorted(words),
            sorted("ok cameras images keypoints descriptors matches two_view_geometries".split()),
        )

    def test_images_without_names(self):
        """Equal checksums are one image, which is called like its first pair."""
        write_run(self.root, names=False)
        self.export("--format", "colmap")
        found = self.read("matches/colmap/set/given/none/usac.db")
        names = [(pair.left_name, pair.right_name) for pair in found.values()]
        self.assertEqual(names, [("set/s/ab/left", "set/s/ab/right"), ("set/s/ab/left", "set/s/ac/right")])

    def test_spaces(self):
        """COLMAP splits the lines of a list at spaces."""
        write_run(self.root)
        index = self.root / "matches/index.csv"
        index.write_text(index.read_text(encoding="utf-8").replace("c.jpg", "my c.jpg"), encoding="utf-8")
        code, text = self.export("--format", "colmap")
        self.assertEqual(code, 0, text)
        self.assertIn("2 lines are left out of the lists of pairs, because a name has a space", text)
        folder = self.root / "matches/colmap/set/given/none"
        self.assertEqual((folder / "usac.pairs.txt").read_text(encoding="utf-8"), "a.jpg b.jpg\n")
        self.assertEqual(len(self.read("matches/colmap/set/given/none/usac.db")), 2)

    def test_one_name_for_two_images(self):
        """The sizes tell."""
        write_run(self.root)
        index = self.root / "matches/index.csv"
        text = index.read_text(encoding="utf-8")
        for other in ("99,88", "999,888"):
            place = text.rindex("640,480")
            index.write_text(text[:place] + other + text[place + 7 :], encoding="utf-8")
            code, message = self.export("--format", "colmap")
            self.assertEqual(code, 2, message)
            self.assertIn("the image a.jpg has %s px, but 640x480 px in" % other.replace(",", "x"), message)

    def test_nothing_selected(self):
        """numpy before 1.19 finds no distinct rows in an array without rows."""
        whole = np.unique

        def old_unique(array, *arguments, **options):
            if options.get("axis") == 0 and len(array) == 0:
                raise ValueError("cannot reshape array of size 0 into shape (0,newaxis)")
            return whole(array, *arguments, **options)

        write_run(self.root)
        for name in ("putative", "usac", "lpm%3Av2"):
            file = self.root / "matches/csv/set/s/ab/given/none" / (name + ".csv")
            file.write_text(file.read_text(encoding="utf-8").split("\n", 1)[0] + "\n", encoding="utf-8")
        index = self.root / "matches/index.csv"
        text = index.read_text(encoding="utf-8").replace("ok,3,2,", "ok,0,0,").replace("ok,3,0,", "ok,0,0,")
        index.write_text(text, encoding="utf-8")
        with mock.patch.object(np, "unique", old_unique):
            for form in ("npz", "colmap"):
                code, text = self.export("--format", form)
                self.assertEqual(code, 0, text)
        counts = [len(pair.left) for pair in self.read("matches/colmap/set/given/none/usac.db").values()]
        self.assertEqual(counts, [0, 1])

    def test_sizes(self):
        """COLMAP needs them."""
        write_run(self.root, sizes=False)
        code, text = self.export("--format", "colmap")
        self.assertEqual(code, 2)
        self.assertIn("the size of the image a.jpg is not known; give it by --size", text)
        code, text = self.export("--format", "colmap", "--size", "640x480")
        self.assertEqual(code, 0, text)
        code, text = self.export("--format", "colmap", "--size", "640")
        self.assertIn("size '640' does not read as WIDTHxHEIGHT", text)

    def test_into_a_database_of_the_images(self):
        """Cameras, images and keypoints stay; matches are replaced, verified geometries removed."""
        write_run(self.root)
        points = np.zeros((13, 2), np.float32)
        images = [(name, (99, 88), points, None) for name in ("x.jpg", "c.jpg", "b.jpg", "a.jpg")]
        source = self.root / "source.db"
        colmap.write_database(source, images, [(0, 1, np.array([[0, 0]]))])
        database = sqlite3.connect(str(source))
        database.execute("INSERT INTO two_view_geometries(pair_id, rows, cols, config) VALUES (5, 0, 2, 1)")
        database.commit()
        database.close()
        before = source.read_bytes()
        code, text = self.export("--format", "colmap", "--database", str(source))
        self.assertEqual(code, 0, text)
        found = self.read("matches/colmap/set/given/none/usac.db")
        self.assertEqual(list(found), ["c.jpg-a.jpg", "b.jpg-a.jpg"])
        np.testing.assert_array_equal(found["b.jpg-a.jpg"].right_index, [10, 11])
        np.testing.assert_array_equal(found["c.jpg-a.jpg"].left_index, [5])
        self.assertEqual(found["b.jpg-a.jpg"].left_size, (99, 88))
        database = sqlite3.connect(str(self.root / "matches/colmap/set/given/none/usac.db"))
        self.assertEqual(database.execute("SELECT count(*) FROM two_view_geometries").fetchone(), (0,))
        database.close()
        self.assertEqual(source.read_bytes(), before)
        writer = sqlite3.connect(str(source))  # as COLMAP does: what it wrote last is in another file
        self.addCleanup(writer.close)
        writer.execute("PRAGMA journal_mode = WAL")
        writer.execute("UPDATE cameras SET width = 77")
        writer.commit()
        code, text = self.export("--format", "colmap", "--database", str(source))
        self.assertEqual(code, 0, text)
        found = self.read("matches/colmap/set/given/none/usac.db")
        self.assertEqual(found["b.jpg-a.jpg"].left_size, (77, 88))
        self.assertEqual(list(self.root.glob("matches/colmap/**/*.part*")), [])
        writer.close()
        colmap.write_database(source, [(name, size, rows[:11], None) for name, size, rows, _ in images], [])
        code, text = self.export("--format", "colmap", "--database", str(source))
        self.assertEqual(code, 2)
        self.assertIn("the image 'a.jpg' has 11 keypoints, the run has a keypoint 11 of it", text)
        colmap.write_database(source, images[:3], [])
        code, text = self.export("--format", "colmap", "--database", str(source))
        self.assertIn("has no image 'a.jpg'", text)

    def test_wrong_runs(self):
        """Every error names the file and the remedy."""
        code, text = self.export("--format", "npz")
        self.assertEqual(code, 2)
        self.assertIn("holds no saved matches; run the benchmark with save_matches:=csv", text)
        write_run(self.root)
        cell = self.root / "matches/csv/set/s/ab/given/none"
        file = cell / "usac.csv"
        whole = file.read_text(encoding="utf-8")
        for wrong, part in (
            (whole.rsplit("\n", 2)[0] + "\n", "usac.csv holds 1 matches of 3, but index.csv states 2"),
            (whole.replace("\n2,", "\n3,"), "usac.csv holds 2 matches of 3"),
            (whole.replace("9,9", "9,x"), "usac.csv, line 3, column 'y_right': 'x' is not a number"),
        ):
            file.write_text(wrong, encoding="utf-8")
            for form in ("npz", "colmap"):
                code, text = self.export("--format", form)
                self.assertEqual(code, 2, text)
                self.assertIn(part, text)
        file.write_text(whole, encoding="utf-8")
        putative = cell / "putative.csv"
        putative.write_text(putative.read_text(encoding="utf-8").rsplit("\n", 2)[0] + "\n", encoding="utf-8")
        for form in ("npz", "colmap"):
            code, text = self.export("--format", form)
            self.assertEqual(code, 2, text)
            self.assertIn("putative.csv holds 2 matches, but index.csv states 3", text)
        index = self.root / "matches/index.csv"
        lines = index.read_text(encoding="utf-8").splitlines()
        index.write_text("\n".join(lines[:2] + [lines[2][:60]]) + "\n", encoding="utf-8")
        self.assertIn("index.csv, line 3 is damaged", self.export("--format", "npz")[1])
        for wrong in (lines[1].replace("csv/set", "set", 1), lines[1].replace("1 0 5", "1 5")):
            index.write_text("\n".join([lines[0], wrong]) + "\n", encoding="utf-8")
            self.assertIn("index.csv, line 2 is damaged", self.export("--format", "npz")[1])
        index.write_bytes("\n".join(lines).encode("utf-8") + b"\xff\n")
        self.assertIn("index.csv cannot be read as CSV", self.export("--format", "npz")[1])
        index.write_text(lines[0] + "\n", encoding="utf-8")
        self.assertIn("index.csv lists no selection", self.export("--format", "npz")[1])


if __name__ == "__main__":
    unittest.main()
