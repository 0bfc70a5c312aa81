#!/usr/bin/env python3
"""Runs the performance program on a few comparisons: python3 test_performance.py"""
import csv
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = Path(os.environ.get("CORRSEL_BINARY_DIR", ".")) / "devel" / "lib" / "corrsel" / "performance"


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], text=True, capture_output=True, timeout=60)


class Performance(unittest.TestCase):
    def test_measures_compares_and_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            table, document = Path(folder, "a.csv"), Path(folder, "a.md")
            done = run(
                "--filter", "^gms/N:1000|^growth/nnsr", "--csv", str(table), "--markdown", str(document)
            )
            # 1 = a target was missed, which a busy machine may bring about.
            self.assertIn(done.returncode, (0, 1), done.stderr)
            rows = list(csv.DictReader(table.read_text().splitlines()))
            text = document.read_text()
        self.assertEqual([row["comparison"] for row in rows], ["gms/N:1000/eps:0.5"] + 5 * ["growth/nnsr"])
        gms, *growth = rows
        self.assertEqual(gms["identical_masks"], "yes")
        self.assertEqual(gms["ours_f"], gms["peer_f"])
        self.assertGreater(float(gms["ours_f"]), 60)
        self.assertGreaterEqual(int(gms["ours_repetitions"]), 20)
        ratio = float(gms["peer_ms"]) / float(gms["ours_ms"])
        self.assertAlmostEqual(float(gms["ratio"]), ratio, places=6)
        self.assertGreater(ratio, 1)
        self.assertEqual([row["n"] for row in growth], ["500", "2000", "5000", "20000", "100000"])
        self.assertEqual([row["exponent"] == "" for row in growth], 4 * [True] + [False])
        self.assertLess(0.5, float(growth[-1]["exponent"]))
        self.assertLess(float(growth[0]["ours_ms"]), float(growth[-1]["ours_ms"]))
        for row in rows:
            self.assertEqual(None, row.get(None))
            self.assertTrue(row["cpu"] and row["compiler"] and row["kernels"] and row["corrsel_commit"])
            self.assertEqual(row["threads"], "1")
        self.assertTrue(text.startswith("Written by `"), text[:80])
        self.assertIn("| gms | textbook GMS | 1000 | 0.5 |", text)
        # A line for each target, good or bad, on the console and in the document.
        verdicts = [line for line in done.stdout.splitlines() if line.startswith(("PASS  ", "FAIL  "))]
        self.assertEqual(len(verdicts), 2, done.stdout)
        self.assertEqual(done.returncode, 1 if any(line.startswith("FAIL") for line in verdicts) else 0)
        for line in verdicts:
            self.assertIn(line[6:], text)

    def test_times_features_beside_those_of_opencv(self):
        cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
        samples = cache / "corrsel" / "sample"
        if not samples.is_dir():
            self.skipTest("no sample photographs: run scripts/fetch_samples.sh")
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "a.csv")
            names = "^features/(orb.orb/640x480/1000|pair/orb.orb/640x480|threads/orb)"
            done = run("--filter", names, "--csv", str(table), "--samples", str(samples))
            self.assertIn(done.returncode, (0, 1), done.stderr)
            rows = list(csv.DictReader(table.read_text().splitlines()))
        beside, threads, *stages = rows
        self.assertEqual(
            (beside["selector"], beside["against"], beside["scene"]), ("orb+orb", "cv::ORB", "640x480")
        )
        self.assertLessEqual(int(beside["n"]), 1000)
        self.assertGreater(int(beside["n"]), 500)
        self.assertGreaterEqual(int(beside["ours_repetitions"]), 20)
        ratio = float(beside["peer_ms"]) / float(beside["ours_ms"])
        self.assertAlmostEqual(float(beside["ratio"]), ratio, places=6)
        self.assertEqual(threads["identical_masks"], "yes")
        self.assertEqual([row["selector"] for row in stages], ["orb+orb", "matching", "usac"])
        for row in stages:
            self.assertGreater(float(row["ours_ms"]), 0)
        verdicts = [line for line in done.stdout.splitlines() if line.startswith(("PASS  ", "FAIL  "))]
        self.assertEqual(len(verdicts), 1, done.stdout)
        self.assertIn("orb+orb, 640x480, 1000", verdicts[0])

    def test_names_missing_photographs(self):
        done = run("--filter", "^features/orb.orb/640x480/1000", "--samples", "/nonexistent")
        self.assertEqual(done.returncode, 1)
        self.assertIn("/nonexistent/aloeL.jpg", done.stdout)
        self.assertIn("fetch_samples.sh", done.stdout)

    def test_selectors_without_a_counterpart_have_the_yardstick(self):
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "a.csv")
            done = run("--filter", "^nnsr/N:5000", "--csv", str(table))
            self.assertIn(done.returncode, (0, 1), done.stderr)
            rows = list(csv.DictReader(table.read_text().splitlines()))
        # It stands for the machine and is no alternative, so the tables leave it out.
        self.assertEqual([(row["comparison"], row["against"]) for row in rows], [("nnsr/N:5000/eps:0.5", "")])
        verdict = re.search(r"nnsr: (\S+)x the time of the yardstick \((\S+) and (\S+) ms", done.stdout)
        self.assertIsNotNone(verdict, done.stdout)
        ratio, ours, yardstick = map(float, verdict.groups())
        self.assertAlmostEqual(ratio, ours / yardstick, delta=0.05 * ratio)

    def test_poses_are_compared_with_those_of_opencv(self):
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "a.csv")
            done = run("--filter", "^pose/N:2000/eps:0.5/order/it", "--csv", str(table))
            self.assertIn(done.returncode, (0, 1), done.stderr)
            rows = list(csv.DictReader(table.read_text().splitlines()))
        self.assertEqual([row["against"] for row in rows[:2]], ["cv RANSAC", "cv USAC_MAGSAC"])
        for row in rows:
            self.assertEqual((row["selector"], row["n"], row["inlier_ratio"]), ("pose/order", "2000", "0.5"))
            self.assertGreater(float(row["ours_precision"]), 95)
            self.assertGreater(float(row["ours_recall"]), 50)
        self.assertGreater(float(rows[0]["peer_precision"]), 80)
        self.assertRegex(done.stdout, r"pose/N:2000/eps:0.5/order: \S+x the time of the yardstick")

    def test_says_what_it_cannot_do(self):
        self.assertEqual(run("--nonsense").returncode, 2)
        self.assertEqual(run("--csv").returncode, 2)
        self.assertEqual(run("--filter", "no such comparison").returncode, 2)

    def test_every_selector_is_compared_in_the_full_grid(self):
        names = run("--all", "--benchmark_list_tests").stdout.splitlines()
        for spec in ("nnsr", "ransac:h", "ransac:f", "usac:h", "usac:f", "gms", "vfc", "lpm:v2", "st", "gtm"):
            for n in (1000, 5000, 20000):
                self.assertTrue(any(name.startswith(f"{spec}/N:{n}/eps:0.5") for name in names), (spec, n))
        for scene in (
            "plane/N:2000/eps:0.5",
            "space/N:2000/eps:0.5",
            "plane/N:2000/eps:0.9",
            "plane/N:100000/eps:0.5",
        ):
            self.assertTrue(any(name.startswith("auto/" + scene) for name in names), scene)


if __name__ == "__main__":
    unittest.main()
