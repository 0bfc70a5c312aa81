#!/usr/bin/env python3
"""Matches go from files into a bag, through the benchmark, and out again: python3 test_matches_to_bag.py"""
import contextlib
import csv
import io
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

import corrsel
import cv2
import genpy
import numpy as np
import rosbag
from corrsel.msg import GroundTruth
from ros_shell import RosShell

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DEVEL = pathlib.Path(os.environ["CORRSEL_DEVEL_DIR"])

sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE / "scripts"))
import matches_to_bag  # noqa: E402  (found through the path above)
from corrsel.files import colmap, csv_list, reading  # noqa: E402

LEFT_SIZE, RIGHT_SIZE = (640, 480), (700, 520)
HOMOGRAPHY = np.array([[0.95, 0.05, 12], [-0.04, 1.02, 7], [1e-5, -2e-5, 1]])


def scene(seed, count=300, wrong=120):
    """Keypoints of two views of a plane, for each left one the number of the right one, and confidences."""
    random = np.random.default_rng(seed)
    left = random.uniform((20, 20), (600, 440), (count, 2)).astype(np.float32)
    mapped = np.column_stack([left, np.ones(count)]) @ HOMOGRAPHY.T
    right = mapped[:, :2] / mapped[:, 2:] + random.normal(0, 0.5, left.shape)
    outliers = random.permutation(count)[:wrong]
    right[outliers] = random.uniform((0, 0), RIGHT_SIZE, (wrong, 2))
    order = random.permutation(count)
    matches = np.argsort(order)
    matches[random.permutation(count)[:20]] = -1
    confidences = random.uniform(0.4, 1, count)
    confidences[outliers] = random.uniform(0, 0.6, wrong)
    return left, np.clip(right, 0, 519)[order].astype(np.float32), matches, confidences.astype(np.float32)


class MatchesToBag(unittest.TestCase):
    """A folder of its own for every test."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_matches_"))
        self.addCleanup(shutil.rmtree, str(self.root))
        self.shell = RosShell(DEVEL / "setup.bash", self.root)
        self.bag = self.root / "matches.bag"

    def write_npz(self, names=("one", "two"), **more):
        """Files of matches in the folder `set`."""
        (self.root / "set").mkdir(exist_ok=True)
        for seed, name in enumerate(names):
            left, right, matches, confidences = scene(seed)
            np.savez(
                str(self.root / "set" / (name + ".npz")),
                keypoints0=left,
                keypoints1=right,
                matches=matches,
                match_confidence=confidences,
                image_size0=LEFT_SIZE,
                image_size1=RIGHT_SIZE,
                **more,
            )

    def convert(self, source, *arguments):
        """Exit status and output of the script."""
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
            code = matches_to_bag.main([str(self.root / source), "--output", str(self.bag), *arguments])
        return code, text.getvalue()

    def messages(self):
        """[(topic, message, time)] of the bag."""
        with rosbag.Bag(str(self.bag)) as bag:
            return list(bag.read_messages())

    def expect_refused(self, parts, source, *arguments):
        """The script refuses with a message and leaves no file."""
        code, text = self.convert(source, *arguments)
        self.assertEqual(code, 2, text)
        for part in parts:
            self.assertIn(part, text)
        self.assertEqual(list(self.root.glob("*.bag*")), [])

    def run_benchmark(self, arguments):
        """Runs the benchmark on the bag; returns the rows of matches/index.csv."""
        command = "rosrun corrsel benchmark --bag %s --report false --output_dir %s/run %s"
        code, text = self.shell.output_of(command % (self.bag, self.root, arguments))
        self.assertEqual(code, 0, text)
        with open(str(self.root / "run/matches/index.csv"), newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_messages(self):
        """Matches and ground truth of a pair have one stamp; nothing depends on the time of the conversion."""
        self.write_npz(H=HOMOGRAPHY, image0="a.png", image1="b.png")
        code, text = self.convert("set", "--period", "2")
        self.assertEqual(
            (code, text),
            (0, "2 pairs with 560 matches, 2 of them with ground truth, written to %s\n" % self.bag),
        )
        messages = self.messages()
        self.assertEqual([topic for topic, _, _ in messages], ["/ground_truth", "/correspondences"] * 2)
        self.assertEqual([time for _, _, time in messages], [genpy.Time(1)] * 2 + [genpy.Time(3)] * 2)
        truth, matches = messages[0][1], messages[1][1]
        self.assertEqual(
            (truth.dataset, truth.sequence, truth.pair, truth.kind),
            ("set", "set", "one", GroundTruth.KIND_HOMOGRAPHY),
        )
        np.testing.assert_array_equal(truth.matrix, HOMOGRAPHY.ravel())
        self.assertEqual(
            (matches.dataset, matches.sequence, matches.pair, matches.features),
            ("set", "set", "one", "given"),
        )
        self.assertEqual((matches.header.frame_id, matches.right_frame_id), ("image:a.png", "image:b.png"))
        self.assertEqual((matches.left_width, matches.left_height), LEFT_SIZE)
        self.assertEqual((matches.right_width, matches.right_height), RIGHT_SIZE)
        self.assertEqual((matches.n_left_features, matches.n_right_features), (300, 300))
        left, right, numbers, confidences = scene(0)
        rows = np.flatnonzero(numbers >= 0)
        np.testing.assert_array_equal(matches.left_x, left[rows, 0])
        np.testing.assert_array_equal(matches.right_y, right[numbers[rows], 1])
        np.testing.assert_array_equal(matches.right_index, numbers[rows])
        np.testing.assert_allclose(matches.probability, confidences[rows], atol=1e-6)
        self.assertEqual(len(matches.distance), 0)
        self.assertEqual(len(matches.second_distance), 0)
        self.assertTrue(np.isnan(matches.seconds.select))
        first = self.bag.read_bytes()
        self.convert("set", "--period", "2")
        self.assertEqual(self.bag.read_bytes(), first)

    def test_images(self):
        """The files are written as they are, and give the sizes."""
        (self.root / "set/s").mkdir(parents=True)
        self.write_npz(("s/one",))
        folder = self.root / "images/s/one"
        folder.mkdir(parents=True)
        for side, (width, height) in (("left", LEFT_SIZE), ("right", RIGHT_SIZE)):
            cv2.imwrite(str(folder / (side + ".png")), np.full((height, width), 90, np.uint8))
        code, text = self.convert("set", "--images", str(self.root / "images"), "--dataset", "mine")
        self.assertEqual(code, 0, text)
        messages = {topic: message for topic, message, _ in self.messages()}
        self.assertEqual(messages["/left/image/compressed"].data, (folder / "left.png").read_bytes())
        self.assertEqual(messages["/right/image/compressed"].format, "png")
        self.assertEqual(messages["/ground_truth"].kind, GroundTruth.KIND_NONE)
        rows = self.run_benchmark("--preselection none --selectors usac --save_matches csv")
        self.assertEqual(
            [(row["dataset"], row["sequence"], row["pair"]) for row in rows], [("mine", "s", "one")] * 2
        )
        self.assertTrue(all(row["left_image"].startswith("#") for row in rows))
        cv2.imwrite(str(folder / "right.png"), np.zeros((520, 699), np.uint8))
        self.bag.unlink()
        arguments = ("set", "--images", str(self.root / "images"))
        self.expect_refused(
            ["the right image", "has 699x520 px, but its matches are of 700x520 px"], *arguments
        )
        (folder / "right.png").write_bytes(b"no image")
        self.expect_refused(["right.png cannot be decoded"], *arguments)
        (folder / "right.png").unlink()
        self.expect_refused(["right.png is missing or cannot be read"], *arguments)
        self.expect_refused(
            ["nowhere is not a folder of images"], "set", "--images", str(self.root / "nowhere")
        )

    def test_wrong_input(self):
        """Every message names what is wrong and what to do, and no half bag is left."""
        self.write_npz()
        self.expect_refused(["period = 0 is outside [0.001, 3600] s"], "set", "--period", "0")
        self.expect_refused(["size '640' does not read as WIDTHxHEIGHT"], "set", "--size", "640")
        np.savez(str(self.root / "set/three.npz"), mkpts0=[[5, 5]], mkpts1=[[900.0, 5]])
        self.expect_refused(
            ["three.npz: match 0 has the right position (900, 5), outside the image of 640x480 px"],
            "set",
            "--size",
            "640x480",
        )
        self.bag = self.root / "no/such/folder.bag"
        self.expect_refused(["cannot write", "folder.bag"], "set")

    def selected_by_python(self, pair, selector, **options):
        """The mask of the same selector in Python; None where the package is not built."""
        try:
            select = corrsel.select
        except ImportError:
            return None
        return select(
            pair.left,
            pair.right,
            selector,
            left_size=LEFT_SIZE,
            right_size=RIGHT_SIZE,
            probability=pair.probability,
            left_index=pair.left_index,
            right_index=pair.right_index,
            **options,
        ).mask

    def test_round_trip(self):
        """What is written in all three forms is the selection among the matches that were given."""
        self.write_npz(H=HOMOGRAPHY)
        self.assertEqual(self.convert("set")[0], 0)
        rows = self.run_benchmark("--preselection none --selectors usac,lpm:v2 --save_matches csv,npz,colmap")
        self.assertEqual(len(rows), 2 * 3)
        given = {pair.key: pair for pair in reading.read_pairs(reading.Request(self.root / "set"))}
        with open(str(self.root / "run/pairs.csv"), newline="", encoding="utf-8") as file:
            next(file)  # the format
            counts = {(row["pair"], row["selector"]): int(row["n_selected"]) for row in csv.DictReader(file)}
        for row in rows:
            pair, selector = given[row["pair"]], row["selector"]
            columns = csv_list.read_columns(self.root / "run/matches" / row["file"])
            chosen = columns["row"].astype(int)
            self.assertEqual(len(chosen), counts[row["pair"], selector])
            if selector == "keep_all":
                self.assertEqual(len(chosen), len(pair.left))
            else:
                self.assertTrue(0 < len(chosen) < len(pair.left))
            options = {"model": "homography"} if selector == "usac" else {}
            mask = self.selected_by_python(pair, selector, **options)
            if mask is not None:
                np.testing.assert_array_equal(chosen, np.flatnonzero(mask), selector)

            in_csv = csv_list.matched_pair(columns, "", "")
            np.testing.assert_array_equal(in_csv.left, pair.left[chosen])
            np.testing.assert_array_equal(in_csv.right, pair.right[chosen])
            np.testing.assert_array_equal(in_csv.probability, pair.probability[chosen])
            np.testing.assert_array_equal(in_csv.left_index, pair.left_index[chosen])

            npz = (self.root / "run/matches" / row["file"].replace("csv/", "npz/", 1)).with_suffix(".npz")
            with np.load(str(npz)) as file:
                np.testing.assert_array_equal(np.flatnonzero(file["mask"]), chosen)
                np.testing.assert_array_equal(file["keypoints0"][file["matches"][:, 0]], pair.left[chosen])
                np.testing.assert_array_equal(file["keypoints1"][file["matches"][:, 1]], pair.right[chosen])
                np.testing.assert_array_equal(file["index1"][file["matches"][:, 1]], pair.right_index[chosen])
                self.assertEqual(np.isnan(file["model"]).any(), selector != "usac")

            name = row["file"].split("/")[-1][: -len(".csv")]
            database = self.root / "run/matches/colmap/set/given/none" / (name + ".db")
            found = [
                item
                for item in colmap.read_database(database)
                if item.left_name == "set/set/%s/left" % row["pair"]
            ]
            self.assertEqual(len(found), 1)
            np.testing.assert_allclose(found[0].left, pair.left[chosen], atol=1e-4)
            np.testing.assert_allclose(found[0].right, pair.right[chosen], atol=1e-4)
            self.assertEqual((found[0].left_size, found[0].right_size), (LEFT_SIZE, RIGHT_SIZE))

    def test_database_to_database(self):
        """COLMAP, bag, benchmark, COLMAP: keep_all gives back the same images, keypoints and matches, with frames."""
        random = np.random.default_rng(5)
        images, matches = [], []
        for number in range(3):
            left, _, _, _ = scene(number)
            shapes = random.normal(0, 3, (len(left), 4)).astype(np.float32)
            images.append(("cam/%d.jpg" % number, LEFT_SIZE, left, shapes))
        for first, second in ((0, 1), (0, 2), (1, 2)):
            rows = np.column_stack([random.permutation(300)[:200], random.permutation(300)[:200]])
            matches.append((first, second, rows))
        source = self.root / "source.db"
        colmap.write_database(source, images, matches)
        code, text = self.convert("source.db")
        self.assertEqual(code, 0, text)
        self.assertIn("3 pairs with 600 matches, 0 of them with ground truth", text)
        self.run_benchmark("--preselection none --selectors gms --save_matches colmap")
        path = self.root / "run/matches/colmap/source/given/none/keep_all.db"
        before = {pair.key: pair for pair in reading.read_pairs(reading.Request(source))}
        after = {pair.key: pair for pair in reading.read_pairs(reading.Request(path))}
        self.assertEqual(list(after), list(before))
        self.assertEqual(list(after), ["cam/0.jpg-1.jpg", "cam/0.jpg-2.jpg", "cam/1.jpg-2.jpg"])
        for key, pair in before.items():
            for side in ("left", "right"):
                for field, tolerance in (("", 1e-4), ("_shape", 0)):
                    wanted, found = (getattr(item, side + field) for item in (pair, after[key]))
                    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance)
                self.assertEqual(getattr(after[key], side + "_name"), getattr(pair, side + "_name"))
        command = "rosrun corrsel export_matches.py --format colmap --database %s --output %s/kept %s/run"
        code, text = self.shell.output_of(command % (source, self.root, self.root))
        self.assertEqual(code, 0, text)
        kept = self.root / "kept/source/given/none/keep_all.db"
        for pair in reading.read_pairs(reading.Request(kept)):
            np.testing.assert_array_equal(pair.left_index, before[pair.key].left_index)
            np.testing.assert_array_equal(pair.right_index, before[pair.key].right_index)
            np.testing.assert_array_equal(pair.left, before[pair.key].left)

    def test_sizes_for_colmap_are_asked_for(self):
        """A form that cannot be written is reported, and the run itself is kept."""
        (self.root / "set").mkdir()
        left, right, _, _ = scene(1)
        np.savez(str(self.root / "set/one.npz"), mkpts0=left, mkpts1=right)
        self.assertEqual(self.convert("set")[0], 0)
        command = "rosrun corrsel benchmark --bag %s --report false --output_dir %s/run --preselection none --selectors lpm"
        code, text = self.shell.output_of(command % (self.bag, self.root) + " --save_matches colmap")
        self.assertEqual(code, 1, text)
        self.assertIn(
            "the size of the image set/set/one/left is not known; give it by --size WIDTHxHEIGHT", text
        )
        self.assertIn("rosrun corrsel report.py --no-page --export colmap", text)
        code, text = self.shell.output_of(
            "rosrun corrsel export_matches.py --format colmap --size 640x480 %s/run" % self.root
        )
        self.assertEqual(code, 0, text)
        code, text = self.shell.output_of(command % (self.bag, self.root) + " --save_matches npy")
        self.assertEqual(code, 2)
        self.assertIn("save_matches: unknown form 'npy'; did you mean 'npz'? valid: csv, npz, colmap", text)


if __name__ == "__main__":
    unittest.main()
