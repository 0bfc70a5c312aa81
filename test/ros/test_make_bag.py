#!/usr/bin/env python3
"""Runs examples/make_bag.py, and the benchmark on the bag that it writes: python3 test_make_bag.py"""
import csv
import os
import pathlib
import shutil
import tempfile
import unittest

import cv2
import numpy as np
from ros_shell import RosShell

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DEVEL = pathlib.Path(os.environ["CORRSEL_DEVEL_DIR"])


def write_pair(folder, truth, matrix, shift):
    """Two views of one plane, the right one `shift` = (x, y) px further."""
    folder.mkdir(parents=True)
    random = np.random.default_rng(3)
    plane = np.full((300, 400, 3), 40, np.uint8)
    for _ in range(250):
        centre = (int(random.integers(400)), int(random.integers(300)))
        colour = [int(value) for value in random.integers(60, 255, 3)]
        cv2.circle(plane, centre, int(random.integers(2, 10)), colour, -1)
    left, right = plane[:240, :320], plane[shift[1] : shift[1] + 240, shift[0] : shift[0] + 320]
    cv2.imwrite(str(folder / "left.png"), left)
    cv2.imwrite(str(folder / "right.png"), right)
    (folder / truth).write_text(matrix)


class MakeBag(unittest.TestCase):
    """A folder with one pair of each kind."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_make_bag_"))
        self.addCleanup(shutil.rmtree, str(self.root))
        self.shell = RosShell(DEVEL / "setup.bash", self.root)

    def make_bag(self):
        """Exit code and output of the example."""
        script = SOURCE / "examples" / "make_bag.py"
        return self.shell.output_of(f"python3 {script} {self.root}/mine {self.root}/mine.bag")

    def test_benchmark_evaluates_the_bag(self):
        """By the homography and by the fundamental matrix; images and truth arrive as they were written."""
        write_pair(self.root / "mine" / "plane", "H.txt", "1 0 -12\n0 1 -7\n0 0 1\n", (12, 7))
        write_pair(self.root / "mine" / "rig", "F.txt", "0 0 0\n0 0 -1\n0 1 0\n", (15, 0))
        code, text = self.make_bag()
        self.assertEqual((code, text), (0, f"2 pairs written to {self.root}/mine.bag\n"))
        arguments = "--features orb+orb --selectors keep_all,usac --report false --tolerances 2"
        code, text = self.shell.output_of(
            f"rosrun corrsel benchmark --bag {self.root}/mine.bag {arguments} --output_dir {self.root}/run"
        )
        self.assertEqual(code, 0, text)
        with open(str(self.root / "run" / "pairs.csv"), newline="") as file:
            next(file)  # the format
            rows = [row for row in csv.DictReader(file) if row["preselection"] == "none"]
        self.assertEqual({row["dataset"] for row in rows}, {"mine"})
        selected = {row["sequence"]: row for row in rows if row["selector"] == "usac"}
        self.assertEqual(set(selected), {"plane", "rig"})
        for sequence, row in selected.items():
            self.assertGreater(int(row["n_selected"]), 30, sequence)
            self.assertGreater(int(row["n_correct_2px"]), 0.9 * int(row["n_selected"]), sequence)

    def test_a_missing_image_is_named(self):
        """The bag is not made in silence."""
        write_pair(self.root / "mine" / "plane", "H.txt", "1 0 -12\n0 1 -7\n0 0 1\n", (12, 7))
        (self.root / "mine" / "plane" / "right.png").unlink()
        code, text = self.make_bag()
        self.assertEqual(code, 1)
        self.assertIn("mine/plane: left.png or right.png is missing or cannot be decoded", text)


if __name__ == "__main__":
    unittest.main()
