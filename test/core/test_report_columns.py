#!/usr/bin/env python3
"""Tests of how the report reads large tables: python3 test_report_columns.py"""
import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import large_run  # noqa: E402  (found through the path above)
from corrsel.report import __main__ as report, per_pair, reading, tables, unrelated  # noqa: E402
from corrsel.report.figures import FINEST, visible  # noqa: E402
from test_report import read_pairs, write_pairs  # noqa: E402

HEADER = "dataset,selector,tau_px,f_paper".split(",")


class ColumnsTest(unittest.TestCase):
    """Each test has a file of its own."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def read(self, content, block=tables.BLOCK):
        """Return the Columns of a file with this content below the header, and the notes."""
        path, notes = self.folder / "pairs.csv", []
        path.write_bytes(",".join(HEADER).encode() + b"\n" + content)
        with mock.patch.object(tables, "BLOCK", block):
            return tables.read_columns(path, HEADER, notes), notes

    def test_numbers_and_texts(self):
        columns, notes = self.read(b"a,x,5,0.5\nb,x,,\na,y,inf,nan\n")
        self.assertEqual((len(columns), notes), (3, []))
        np.testing.assert_array_equal(columns["f_paper"], [0.5, np.nan, np.nan])
        np.testing.assert_array_equal(columns["tau_px"], [5, np.nan, np.nan])
        self.assertEqual((columns.texts["dataset"], columns["dataset"].tolist()), (["a", "b"], [0, 1, 0]))
        self.assertEqual(columns.row(1), {"dataset": "b", "selector": "x", "tau_px": None, "f_paper": None})
        self.assertEqual(columns.code("selector", "y"), 1)
        self.assertEqual(columns.code("selector", "z"), -1)

    def test_columns_agree_with_dictionaries_for_any_size_of_blocks(self):
        lines = ["d%d,s%d,%d,%r\n" % (i % 3, i % 2, i % 10, i / 7) for i in range(50)]
        lines[20:20] = ["short\n", "\n", "a,x,5,word\n", '"quo""ted, name",x,5,0.25\n']
        content = "".join(lines).encode()
        for block in (1, 2, 7, 1000):
            columns, notes = self.read(content, block)
            again = []
            rows = tables.read_table(self.folder / "pairs.csv", HEADER, again)
            self.assertEqual([columns.row(i) for i in range(len(columns))], rows)
            self.assertEqual(notes, ["pairs.csv: 2 lines could not be read and left out: line 22, 24."])
            self.assertEqual(notes, again)

    def test_lines_are_counted_through_line_breaks_in_cells(self):
        for block in (1, 2, 100):
            _, notes = self.read(b'"a\nb",x,5,1\nshort\na,x,word,1\n', block)
            self.assertEqual(notes, ["pairs.csv: 2 lines could not be read and left out: line 4, 5."])

    def test_many_unreadable_lines_are_counted_and_ten_are_named(self):
        columns, notes = self.read(b"a,x,5,1\n" + b"a,x,word,1\n" * 30, 7)
        self.assertEqual(len(columns), 1)
        lines = ", ".join(map(str, range(3, 13)))
        self.assertEqual(notes, ["pairs.csv: 30 lines could not be read and left out: line %s, ...." % lines])

    def test_bytes_that_are_no_text_are_replaced(self):
        columns, notes = self.read(b"a\0\x07\xff,x,5,1\n")
        self.assertEqual((columns.texts["dataset"], notes), (["a\ufffd\ufffd\ufffd"], []))

    def test_a_cut_off_last_line_is_left_out(self):
        columns, notes = self.read(b"a,x,5,0.5\na,y,5,0.")
        self.assertEqual(columns.texts["selector"], ["x"])
        self.assertIn("the last line is cut off", notes[0])

    def test_no_rows(self):
        columns, notes = self.read(b"")
        self.assertEqual((len(columns), notes), (0, []))


class RowTableTest(unittest.TestCase):
    """Queries of a run against its rows, read one by one."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        with contextlib.redirect_stdout(io.StringIO()):
            cls.count = large_run.write_run(cls.folder, pairs=30, datasets=2, selectors=4, tolerances=3)
        cls.run_ = reading.read_run(cls.folder)
        cls.rows = read_pairs(cls.folder / "pairs.csv")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_made_up_run_has_the_size_that_was_asked_for(self):
        self.assertEqual((self.count, len(self.rows), len(self.run_.pairs)), (120, 360, 360))
        self.assertEqual(self.run_.datasets, {"large_0": 15, "large_1": 15})
        self.assertEqual(self.run_.seeds, ["1"])

    def test_values_of_pairs(self):
        for group in self.run_.groups:
            pairs = self.run_.pairs_of(group)
            self.assertEqual(len(pairs), self.run_.pair_count(group))
            for selector in self.run_.selectors_of(group):
                for column in ("f_paper", "select_s", "precision"):
                    expected = {
                        (r["sequence"], r["pair"]): r[column]
                        for r in self.rows
                        if (r["dataset"], r["selector"], r["tau_px"]) == (group.dataset, selector, 5)
                        and r["n_ground_truth"]
                    }
                    found = self.run_.pair_values(group, selector, column)
                    expected = [np.nan if expected.get(p) is None else expected[p] for p in pairs]
                    np.testing.assert_array_equal(found, expected)

    def test_repetitions_are_averaged_and_counted_once_per_seed(self):
        rows = [dict(self.rows[0], seed=str(k), f_paper=value) for k, value in enumerate((0.25, 0.5, 0.75))]
        rows = [dict(row, n_ground_truth=100.0, tau_px=5.0) for row in rows]
        rows[1]["status"] = "time_limit"
        run = self.run_of(rows)
        (group,) = run.groups
        self.assertEqual(run.pair_values(group, rows[0]["selector"]).tolist(), [0.5])
        self.assertEqual(run.statuses[group, rows[0]["selector"]], {"ok": 2, "time_limit": 1})

    def run_of(self, rows):
        """Return a Run with rows of pairs.csv."""
        folder = Path(tempfile.mkdtemp(dir=str(self.folder)))
        write_pairs(folder / "pairs.csv", rows)
        return reading.read_run(folder)

    def test_the_order_of_rows_does_not_matter(self):
        run = self.run_of(self.rows[::-1])
        for group in self.run_.groups:
            here, there = self.run_.pairs_of(group), run.pairs_of(group)
            for selector in self.run_.selectors_of(group):
                a = dict(zip(here, self.run_.pair_values(group, selector).tolist()))
                b = dict(zip(there, run.pair_values(group, selector).tolist()))
                self.assertEqual(str(sorted(a.items())), str(sorted(b.items())))
            self.assertEqual(
                run.head_to_head(group, "nnsr", "ransac"), self.run_.head_to_head(group, "nnsr", "ransac")
            )

    def test_sequences(self):
        (first, _) = self.run_.groups
        inside = self.run_.in_sequences(first, ["scene_003", "elsewhere"])
        self.assertEqual(np.flatnonzero(inside).tolist(), [3])
        self.assertTrue(self.run_.in_sequences(first, None).all())


class ManyPairsTest(unittest.TestCase):
    """What the page shows does not grow with the number of pairs."""

    def test_figures_are_bounded_and_say_so(self):
        sizes = {}
        for pairs in (20, 500, 1500):
            with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
                folder = Path(folder)
                large_run.write_run(folder, pairs=pairs, datasets=1, selectors=4, tolerances=2)
                config = "datasets: [large_0]\nsections: [per_pair]\ncells: [sift+sift/none]\n"
                (folder / "config.yaml").write_text(config)
                self.assertEqual(report.main([str(folder)]), 0)
                sizes[pairs] = len((folder / "report.html").read_text(encoding="utf-8"))
                text = (folder / "report.html").read_text(encoding="utf-8")
                limited = pairs > per_pair.MAX_PAIRS
                self.assertEqual("are too many for a row each; pairs.csv has them all" in text, limited)
        self.assertLess(sizes[1500], 1.1 * sizes[500])

    def test_dots(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            large_run.write_run(folder, pairs=300, datasets=1, selectors=2, tolerances=1)
            run = reading.read_run(folder)
        (group,) = run.groups
        self.assertIn("200 dots for the 300 pairs", per_pair.distribution_text(run, group))

    def test_curves(self):
        x = np.linspace(0, 1, 100000)
        shown = visible(x, x**2)
        self.assertTrue(shown[0] and shown[-1])
        self.assertLess(shown.sum(), 4 * FINEST)
        self.assertTrue(visible(x[:FINEST], x[:FINEST]).all())
        right, wrong = np.repeat([0.5, 2.0], 3), np.array([1.0, 0.25])
        x, y = unrelated.roc(right, wrong)
        self.assertEqual((x.tolist(), y.tolist()), ([0, 0, 0.5, 0.5, 1], [0, 0.5, 0.5, 1, 1]))


if __name__ == "__main__":
    unittest.main()
