#!/usr/bin/env python3
"""Tests of corrsel_benchmark, the benchmark without ROS: python3 test_benchmark_program.py"""
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

DEVEL = os.environ.get("CORRSEL_DEVEL_DIR")
BIN = Path(DEVEL) / "lib" / "corrsel" if DEVEL else Path(os.environ["CORRSEL_BINARY_DIR"]) / "bin"
PROGRAM = BIN / "corrsel_benchmark"


def write_image(path, pixels):
    """Write a grey image as PGM, which needs no library."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"P5\n%d %d\n255\n" % pixels.shape[::-1] + pixels.astype(np.uint8).tobytes())


class BenchmarkProgram(unittest.TestCase):
    """A dataset of two pairs: a shifted image, and one whose right image is missing."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="corrsel_benchmark_")
        self.addCleanup(temporary.cleanup)
        self.root = Path(temporary.name)
        blocks = np.kron(np.random.default_rng(1).integers(0, 255, (40, 50)), np.ones((8, 8)))
        for name in ("one", "two"):
            folder = self.root / "data" / "mine" / name
            write_image(folder / "left.pgm", blocks)
            write_image(folder / "right.pgm", np.roll(blocks, (-7, -12), (0, 1)))
            (folder / "H.txt").write_text("1 0 -12\n0 1 -7\n0 0 1\n")

    def call(self, *arguments):
        """Return exit code and output of the program."""
        command = [str(PROGRAM), "--data_root", str(self.root / "data"), "--features", "orb+orb", *arguments]
        environment = dict(os.environ, XDG_DATA_HOME=str(self.root / "home"))
        done = subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=environment,
            universal_newlines=True,
        )
        return done.returncode, done.stdout

    def test_a_folder_is_run_and_reported(self):
        run = self.root / "run"
        code, text = self.call(
            "--dataset", "mine", "--selectors", "gms", "--report", "false", f"--output_dir={run}"
        )
        self.assertEqual(code, 0, text)
        self.assertIn("Highest mean F", text)
        self.assertIn("; --verbose prints them", text)
        lines = (run / "pairs.csv").read_text().splitlines()
        # Two pairs, with and without preselection, gms and keep_all.
        self.assertEqual((lines[0], len(lines)), ("# corrsel pairs 2", 2 + 2 * 2 * 2))
        self.assertFalse((run / "report.html").exists())

    def test_a_pair_that_cannot_be_read_is_a_failure(self):
        (self.root / "data" / "mine" / "two" / "right.pgm").write_text("no image")
        code, text = self.call("--dataset", "mine", "--selectors", "gms", "--report", "false")
        self.assertEqual(code, 1, text)
        self.assertIn("failed (read): mine", text)
        self.assertIn("1 of 2 pairs done, 1 failed", text)
        self.assertEqual(len(list((self.root / "home" / "corrsel").iterdir())), 1)

    def test_a_bag_needs_the_program_of_the_ros_package(self):
        code, text = self.call("--bag", "my.bag")
        self.assertEqual(code, 2, text)
        self.assertIn("rosrun corrsel benchmark", text)


if __name__ == "__main__":
    unittest.main()
