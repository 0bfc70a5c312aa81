#!/usr/bin/env python3
"""Tests of what corrsel.report prints: python3 test_print_results.py"""
import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
from corrsel.report import __main__ as report, reading  # noqa: E402  (without byte code)
from test_report import (
    pair_row,
    read_csv,
    read_pairs,
    write_csv,
    write_pairs,
    write_run,
    SCORES,
)  # noqa: E402


class PrintResults(unittest.TestCase):
    """What a run prints at its end."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="corrsel_print_")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_run(self.folder, "photos")

    def printed(self, *arguments):
        """Return the exit status, what is printed, and the errors."""
        out, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            status = report.main(list(arguments) + ["--no-page", str(self.folder)])
        return status, out.getvalue(), errors.getvalue()

    def lines(self, *arguments):
        """Return the printed lines of a run that can be read."""
        status, text, errors = self.printed(*arguments)
        self.assertEqual((status, errors), (0, ""), text)
        return text.splitlines()

    def add_pairs(self, *changes):
        """Append pairs of photos without ground-truth inlier; returns nothing."""
        rows = read_pairs(self.folder / "pairs.csv")
        for i, change in enumerate(changes):
            row = pair_row("photos", "new%d" % i, "sift+sift", "keep_all", 5, SCORES["keep_all"])
            row.update(n_ground_truth=0, recall_paper="", recall_same_tau="", f_paper="", f_same_tau="")
            row.update(change)
            rows.append(row)
        write_pairs(self.folder / "pairs.csv", rows)

    def remark(self, *rows):
        """Write remarks.csv."""
        write_csv(
            self.folder / "remarks.csv",
            reading.REMARKS_HEADER,
            [dict(zip(reading.REMARKS_HEADER, row)) for row in rows],
        )

    def test_winners_come_first_and_alone(self):
        lines = self.lines()
        self.assertEqual(
            lines[0],
            "Highest mean F in percent (tau = 5 px, labelled truth), with its 95 % interval:",
        )
        self.assertEqual(
            lines[1].split(),
            "pairs highest F runner-up intervals better on fastest keep_all".split(),
        )
        self.assertEqual(
            " ".join(lines[2].split()),
            "photos, sift+sift 3 lpm:v2 91.0 (90.0..92.0) ransac 86.9 (85.9..87.9) separate 3 of 3"
            " nnsr 0.020 ms 99.9",
        )
        self.assertIn("adelaidermf, given matches", lines[3])
        self.assertNotIn("nnsr", lines[3])
        self.assertFalse(any("median ms" in line for line in lines))

    def test_one_pair_has_no_interval(self):
        rows = [dict(row, pairs="1") for row in read_csv(self.folder / "summary.csv")]
        write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, rows)
        self.assertIn("sift+sift 1 lpm:v2 91.0 ransac 86.9 - 3 of 3", " ".join(self.lines()[2].split()))
        rows = [line.split() for line in self.lines("--all") if line.startswith("  ransac")]
        self.assertEqual([row[5] for row in rows], ["-", "-"])

    def test_poses_follow_the_winners(self):
        header = reading.POSE_SUMMARY_HEADER
        rows = []
        for selector, area in (("nnsr", 0.5), ("ransac", 0.75), ("keep_all", 0.25), ("ground_truth", 0.9)):
            row = dict(dataset="photos", features="sift+sift", preselection="none", selector=selector)
            row.update(poses=3, auc_10=area, auc_10_lo=area - 0.1, auc_10_hi=area + 0.1, homographies=0)
            rows.append(row)
        write_csv(self.folder / "pose_summary.csv", header, rows)
        lines = self.lines()
        start = lines.index("Highest pose AUC at 10 degrees in percent, with its 95 % interval:")
        self.assertEqual(
            lines[start + 1].split(), "pairs highest runner-up keep_all ground-truth inliers".split()
        )
        self.assertEqual(
            " ".join(lines[start + 2].split()),
            "photos, sift+sift 3 ransac 75.0 (65.0..85.0) nnsr 50.0 (40.0..60.0) 25.0 90.0",
        )
        self.assertNotIn("corner", "\n".join(lines))
        table = [line for line in self.lines("--all") if line.split()[:1] in (["selector"], ["ransac"])]
        self.assertIn("pose AUC 10 deg %", table[0])
        self.assertIn(" 75.0 ", table[1])

    def test_ties_are_counted(self):
        rows = read_pairs(self.folder / "pairs.csv")
        for row in rows:
            if row["selector"] == "ransac" and row["sequence"] == "graf":
                row["f_paper"] = SCORES["lpm:v2"][2]
        write_pairs(self.folder / "pairs.csv", rows)
        self.assertIn("  2 of 3 (1 tie)  ", self.lines()[2])

    def test_everything_has_a_table_of_each_group(self):
        lines = self.lines("--all")
        title = lines.index("photos, sift+sift, no preselection, tau = 5 px")
        rows = {line.split()[0]: line.split() for line in lines[title + 2 : title + 6]}
        self.assertEqual(
            rows["ransac"], ["ransac", "3", "95.0", "80.0", "86.9", "85.9..87.9", "5.00", "10.0"]
        )
        self.assertEqual(list(rows), ["nnsr", "ransac", "lpm:v2", "keep_all"])
        title = lines.index("adelaidermf, given matches, no preselection, labelled truth")
        self.assertEqual(lines[title + 5].strip(), "did not run: nnsr")

    def test_pairs_that_are_not_in_the_means_are_counted_with_their_reasons(self):
        no_match = dict(n_putative=0, n_selected=0, status="too_few", precision="")
        self.add_pairs(
            dict(no_match, n_left=0),
            dict(no_match, n_right=0),
            dict(no_match, n_right=0, n_left=0),
            dict(no_match, n_right=0, n_left=0),
            dict(no_match),
            {},
        )
        failures = read_csv(self.folder / "failures.csv")
        failures.append(dict(dataset="photos", stage="read", error="gone"))
        failures.append(dict(dataset="other", stage="read", error="gone"))
        write_csv(self.folder / "failures.csv", reading.FAILURES_HEADER, failures)
        self.assertIn(
            "photos, sift+sift: 8 of 11 pairs are not in the means: 2 have no correct putative match, 2 have no features"
            " in either image, 1 has no features in the left image, 1 has no features in the right image, 1 has no"
            " putative match, 1 failed (failures.csv).",
            self.lines(),
        )

    def test_pairs_without_truth_and_without_survivors_of_the_preselection(self):
        untold = dict(truth="none", n_selected=300)
        empty = dict(n_putative=0, n_selected=0, preselection="nnsr", status="too_few")
        self.add_pairs(untold, empty)
        text = "\n".join(self.lines())
        self.assertIn("1 has no ground truth", text)
        self.assertIn(
            "photos, sift+sift, after nnsr: 1 of 1 pair is not in the means: 1 has no match after preselection by"
            " nnsr.",
            text,
        )

    def test_selectors_that_do_not_run_are_told_once_with_the_reason(self):
        self.remark(
            ("adelaidermf", "", "nnsr", "nnsr needs the column distance"),
            ("photos", "", "nnsr", "nnsr needs the column distance"),
            ("photos", "", "", "images of 16 bits are stretched"),
            ("", "", "", "large images are reduced"),
        )
        lines = self.lines()
        self.assertEqual(
            lines[-3:],
            [
                "nnsr does not run on adelaidermf, photos: nnsr needs the column distance.",
                "photos: images of 16 bits are stretched.",
                "large images are reduced.",
            ],
        )

    def test_groups_in_which_nothing_runs_have_no_line(self):
        rows = read_pairs(self.folder / "pairs.csv")
        rows += [dict(row, preselection="nnsr", status="unsupported_input") for row in rows]
        write_pairs(self.folder / "pairs.csv", rows)
        means = read_csv(self.folder / "summary.csv")
        means += [dict(row, preselection="nnsr", pairs=0, f_paper="") for row in means]
        write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, means)
        self.assertFalse([line for line in self.lines("--all") if "after" in line])

    def test_nothing_to_compare(self):
        write_pairs(self.folder / "pairs.csv", [])
        write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, [])
        self.assertEqual(self.lines(), ["No pair with ground truth was evaluated."])
        (self.folder / "pairs.csv").unlink()
        status, text, errors = self.printed()
        self.assertEqual((status, text), (2, ""))
        self.assertIn("pairs.csv", errors)


if __name__ == "__main__":
    unittest.main()
