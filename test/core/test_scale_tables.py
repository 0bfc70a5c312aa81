#!/usr/bin/env python3
"""Tests of scripts/scale_tables.py and of the script that measures what they show: python3 test_scale_tables.py"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEVEL = os.environ.get("CORRSEL_DEVEL_DIR")
BIN = (
    pathlib.Path(DEVEL) / "lib" / "corrsel"
    if DEVEL
    else pathlib.Path(os.environ["CORRSEL_BINARY_DIR"]) / "bin"
)
MEASURE = ROOT / "scripts" / "maintenance" / "measure_scale.py"

sys.path.insert(0, str(ROOT / "scripts"))
import scale_tables  # noqa: E402  (found through the path above)


def steps(growth, constant, sizes=(1000, 4000, 16000)):
    """Return measurements in which every quantity grows on a line; a database has 4000 bytes a pair."""
    found = {}
    for step in ("undivided", "begin", "parts", "merge"):
        for pairs in sizes:
            value = str(constant + growth * pairs)
            row = {"pairs": str(pairs), "parts": "8", "processor_s": value, "memory_mib": value}
            row.update(database_bytes=str(4000 * pairs), written_bytes=str(5000 * pairs))
            found.setdefault(step, {})[pairs] = row
    return found


def cells(table, first):
    """Return the cells of the row of a Markdown table that begins with a text, without this text."""
    (row,) = (line for line in table.splitlines() if line.startswith("| %s |" % first))
    return row.split(" | ")[1:-1] + [row.split(" | ")[-1][:-2]]


class ScaleTables(unittest.TestCase):
    """Lines through measured points, and their continuation."""

    def test_the_line_goes_through_the_first_and_the_last_point(self):
        growth, constant, deviation = scale_tables.line([(10, 5.0), (20, 9.0), (30, 9.0)])
        self.assertAlmostEqual(growth, 0.2)
        self.assertAlmostEqual(constant, 3.0)
        self.assertAlmostEqual(deviation, 9 / 7 - 1)

    def test_two_points_have_no_deviation(self):
        self.assertEqual(scale_tables.line([(10, 5.0), (30, 9.0)])[2], 0)

    def test_numbers_have_two_digits_that_count(self):
        texts = [scale_tables.amount(number) for number in (0.01234, 9.96, 42.4, 123.4, 12345.0)]
        self.assertEqual(texts, ["0.012", "10", "42", "120", "12,000"])

    def test_more_pairs_continue_the_line(self):
        # 0.0036 s a pair: 10^9 pairs take 1000 hours and the constant part, 3.6 s, which no longer shows.
        hours, merge, database, rows, memory = cells(scale_tables.undivided_rows(steps(0.0036, 3.6)), "10^9")
        self.assertEqual((hours, merge, database, rows), ("1,000", "1,000", "4,000", "1,000"))
        self.assertEqual(memory, "3,500")  # 3.6e6 MiB

    def test_the_beginnings_of_all_parts_grow_with_the_square(self):
        measured = steps(0.0036, 0)
        for row in measured["begin"].values():
            row["processor_s"] = str(float(row["processor_s"]) / 360)  # 1e-5 s a pair
        table = scale_tables.divided_rows(measured)
        self.assertEqual(cells(table, "10^8"), ["100", "17", "28", "0.28"])
        self.assertEqual(cells(table, "10^9"), ["1,000", "170", "2,800", "2.8"])

    def test_the_growth_is_that_of_a_million_pairs(self):
        table = scale_tables.growth_rows(steps(0.0036, 3.6))
        self.assertEqual(cells(table, scale_tables.VERIFICATION), ["1.00 processor hours", "0 %"])
        self.assertEqual(cells(table, scale_tables.ROWS), ["1.00 GB", "0 %"])


class MeasureScale(unittest.TestCase):
    """The script, with small databases."""

    def test_what_it_writes_can_be_shown(self):
        with tempfile.TemporaryDirectory() as folder:
            data = pathlib.Path(folder) / "docs" / "data"
            data.mkdir(parents=True)
            command = [
                MEASURE,
                "--sizes",
                "30,60,90",
                "--parts",
                "3",
                "--csv",
                data / "scale.csv",
                BIN / "corrsel_verify",
            ]
            done = subprocess.run(
                [sys.executable, *map(str, command)],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                universal_newlines=True,
                check=False,
            )
            self.assertEqual(done.returncode, 0, done.stdout)
            found, _ = scale_tables.read(data / "scale.csv")
            tables = scale_tables.scale_tables(pathlib.Path(folder))
        self.assertEqual(set(found), {"undivided", "begin", "parts", "merge"})
        for pairs in (30, 60, 90):
            self.assertRegex(found["merge"][pairs]["checksum"], "^[0-9a-f]{16}$")
            self.assertEqual(found["merge"][pairs]["checksum"], found["undivided"][pairs]["checksum"])
            self.assertGreater(float(found["parts"][pairs]["processor_s"]), 0)
        self.assertIn("| 3 parts, s |", tables["points"])
        self.assertEqual(len(cells(tables["points"], "60")), 9)

    def test_a_program_that_fails_is_shown(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [sys.executable, str(MEASURE), "--sizes", "30", "--csv", folder + "/scale.csv", "/bin/false"],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                universal_newlines=True,
                check=False,
            )
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertRegex(done.stdout, "error: /bin/false .* failed")
            self.assertFalse((pathlib.Path(folder) / "scale.csv").exists())


if __name__ == "__main__":
    unittest.main()
