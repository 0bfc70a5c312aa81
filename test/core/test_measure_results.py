#!/usr/bin/env python3
"""Tests scripts/maintenance/measure_results.py on the folder of a run that is written here."""

import copy
import json
import sys
import tempfile
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PACKAGE / "scripts" / "maintenance"))

import measure_results  # noqa: E402
from corrsel.report.reading import read_run  # noqa: E402
from test_report import SCORES, write_run  # noqa: E402


class MeasureResults(unittest.TestCase):
    """What is written to docs/data/results.json, and how it is compared."""

    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        folder = Path(work.name)
        write_run(folder, "vgg")
        environment = {"corrsel_commit": "abc", "cpu": "Example", "compiler": "gcc 12", "opencv": "4.6.0"}
        (folder / "environment.json").write_text(json.dumps(environment))
        self.results = measure_results.results_of([read_run(folder)])

    def test_a_column_for_every_dataset_and_its_features(self):
        columns = [tuple(column.values()) for column in self.results["columns"]]
        self.assertEqual(columns, [("VGG", "sift+sift", 4), ("AdelaideRMF", "given matches", 2)])

    def test_the_mean_f_in_percent_at_5_px(self):
        self.assertEqual(set(self.results["f_percent"]), set(SCORES))
        f = round(100 * SCORES["ransac"][2], 1)
        self.assertEqual(self.results["f_percent"]["ransac"], [f, f])
        self.assertIsNone(self.results["f_percent"]["nnsr"][1], "no distances, no result")

    def test_the_file_reads_back(self):
        self.assertEqual(json.loads(measure_results.as_text(self.results)), self.results)

    def test_differences_are_listed(self):
        other = copy.deepcopy(self.results)
        self.assertEqual(measure_results.differences(self.results, other), [])
        other["f_percent"]["ransac"][0] = 1.0
        del other["f_percent"]["nnsr"]
        found = measure_results.differences(self.results, other)
        self.assertEqual(len(found), 2)
        self.assertIn("nnsr: only in one of the results", found)
        self.assertRegex(found[1], r"^ransac, VGG, sift\+sift: [\d.]+ instead of 1\.0$")
        other["columns"][0]["pairs"] = 9
        self.assertRegex(measure_results.differences(self.results, other)[0], "^other datasets")


if __name__ == "__main__":
    unittest.main()
