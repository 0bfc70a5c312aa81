#!/usr/bin/env python3
"""Pairs of one's own through make_dataset_bag, benchmark and report: python3 test_pairs.py"""
import csv
import os
import pathlib
import shutil
import tempfile
import unittest

import numpy as np
from ros_shell import RosShell

DEVEL = pathlib.Path(os.environ["CORRSEL_DEVEL_DIR"])
RECTIFIED = "0 0 0\n0 0 -1\n0 1 0\n"  # x'^T F x = 0 for points in the same row


def matches():
    """200 matches (x, y, x', y') in the same row of both images, 100 wrong ones, and the labels of both."""
    random = np.random.default_rng(3)
    left = random.uniform([100, 10], [600, 470], (300, 2))
    right = left - np.column_stack([random.uniform(5, 90, 300), np.zeros(300)])
    right[200:] = random.uniform([10, 10], [600, 470], (100, 2))
    return np.column_stack([left, right]), np.repeat([1, 0], [200, 100])


def write_ppm(path, image):
    """An H x W x 3 image."""
    path.write_bytes(b"P6\n%d %d\n255\n" % (image.shape[1], image.shape[0]) + image.tobytes())


class Pairs(unittest.TestCase):
    """One folder for each kind of ground truth."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_pairs_"))
        self.addCleanup(shutil.rmtree, str(self.root))
        self.shell = RosShell(DEVEL / "setup.bash", self.root)
        self.data = self.root / "data" / "mine"
        for name in ("labels", "lines", "rig"):
            (self.data / name).mkdir(parents=True)
        points, labels = matches()
        header = "x_left,y_left,x_right,y_right"
        for name, columns, names in (
            ("labels", np.column_stack([points, labels]), header + ",label"),
            ("lines", points, header),
        ):
            np.savetxt(str(self.data / name / "matches.csv"), columns, delimiter=",", header=names)
            np.savetxt(str(self.data / name / "size.txt"), [[640, 480], [640, 480]], fmt="%d")
        for name in ("lines", "rig"):
            (self.data / name / "F.txt").write_text(RECTIFIED)
        random = np.random.default_rng(5)
        scene = np.kron(random.integers(0, 255, (40, 60, 3)), np.ones((6, 6, 1))).astype(np.uint8)
        write_ppm(self.data / "rig" / "left.ppm", np.ascontiguousarray(scene[:, :320]))
        write_ppm(self.data / "rig" / "right.ppm", np.ascontiguousarray(scene[:, 24:344]))

    def test_check_finds_them(self):
        """Also without images; a broken list is named by line, column and value."""
        check = f"rosrun corrsel make_dataset_bag --dataset mine --path {self.data} --check"
        code, text = self.shell.output_of(check)
        self.assertEqual((code, text), (0, "mine: found 3 sequences, 3 pairs, none of them broken\n"))
        list_file = self.data / "labels" / "matches.csv"
        list_file.write_text("x_left,y_left,x_right,y_right,label\n1,2,3,4,1\n1,2,three,4,0\n")
        code, text = self.shell.output_of(check)
        self.assertEqual(code, 1)
        self.assertIn(f"{list_file}: line 3: column 'x_right': 'three' is not a number", text)

    def test_benchmark_and_report(self):
        """Every kind is evaluated; usac fits a fundamental matrix."""
        run = self.root / "run"
        code, text = self.shell.output_of(
            f"rosrun corrsel benchmark --dataset mine --data_root {self.root}/data --features orb+orb "
            f"--selectors keep_all,usac --tolerances 2 --output_dir {run}"
        )
        self.assertEqual(code, 0, text)
        with open(str(run / "pairs.csv"), newline="") as file:
            next(file)  # the format
            rows = {
                (row["sequence"], row["selector"]): row
                for row in csv.DictReader(file)
                if row["preselection"] == "none"
            }
        for name, features in (("labels", "given"), ("lines", "given"), ("rig", "orb+orb")):
            row = rows[name, "usac"]
            self.assertEqual(row["features"], features)
            labelled = row["truth"] == "labels"
            correct = int(row["n_correct_labels" if labelled else "n_correct_2px"])
            self.assertGreater(correct, 0.9 * int(row["n_selected"]), name)
            self.assertGreater(
                correct, 0.8 * int(row["n_ground_truth" if labelled else "n_inliers_2px"]), name
            )
        row = rows["labels", "keep_all"]
        self.assertEqual((row["n_correct_labels"], row["n_selected"]), ("200", "300"))
        report = (run / "report.html").read_text(encoding="utf-8")
        self.assertTrue("on mine (3 pairs), with given matches, orb+orb" in report)


if __name__ == "__main__":
    unittest.main()
