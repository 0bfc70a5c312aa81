#!/usr/bin/env python3
"""Tests of corrsel_verify: python3 test_verify_program.py"""
import csv
import json
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DEVEL = os.environ.get("CORRSEL_DEVEL_DIR")
BIN = Path(DEVEL) / "lib" / "corrsel" if DEVEL else Path(os.environ["CORRSEL_BINARY_DIR"]) / "bin"
PROGRAM = BIN / "corrsel_verify"
GENERATOR = ROOT / "scripts" / "maintenance" / "generate_database.py"
QUICK = ("--selector", "adalam")  # the fastest one where nothing is found
PAIRS, TRUE = 120, 60


def run(*arguments):
    """Return exit code, output and messages of the program."""
    done = subprocess.run(
        [str(PROGRAM), *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    return done.returncode, done.stdout, done.stderr


def generate(path, *arguments):
    """Write a database of 120 pairs of images of several places, 60 of them of one place."""
    options = ["--pairs", PAIRS, "--matches", 80, "--true-share", TRUE / PAIRS, "--images-of-place", 8]
    subprocess.run([sys.executable, str(GENERATOR), *map(str, options), *arguments, str(path)], check=True)


def rows(path):
    """Return all rows of two_view_geometries."""
    database = sqlite3.connect(str(path))
    found = database.execute("SELECT * FROM two_view_geometries ORDER BY pair_id").fetchall()
    database.close()
    return found


def execute(path, sql, *parameters):
    """Change a database."""
    database = sqlite3.connect(str(path))
    with database:
        database.execute(sql, parameters)
    database.close()


def checksum(text):
    """Return the checksum that the report prints."""
    return next(line.split()[-1] for line in text.splitlines() if "checksum" in line)


class VerifyProgram(unittest.TestCase):
    """One generated database, of which every test has a copy."""

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.TemporaryDirectory(prefix="corrsel_verify_")
        cls.original = Path(cls.shared.name) / "house.db"
        generate(cls.original)
        cls.whole = Path(cls.shared.name) / "whole.db"
        code, cls.text, errors = run(cls.original, "--output", cls.whole, *QUICK)
        assert code == 0, errors
        cls.rows = rows(cls.whole)

    @classmethod
    def tearDownClass(cls):
        cls.shared.cleanup()

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="corrsel_verify_")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.database = self.folder / "house.db"
        shutil.copy(str(self.original), str(self.database))

    def verify(self, *arguments, code=0):
        """Run the program on the test's database; return its output and messages."""
        result, text, errors = run(self.database, *QUICK, *arguments)
        self.assertEqual(result, code, text + errors)
        return text + errors

    def refused(self, *parts, arguments=(), code=2):
        """Expect an exit code and a message with all parts."""
        result, text, errors = run(*arguments)
        self.assertEqual(result, code, text + errors)
        for part in parts:
            self.assertIn(part, errors)

    def test_pairs_of_one_place_are_accepted_and_the_original_is_not_changed(self):
        self.assertEqual(len(self.rows), PAIRS)
        self.assertEqual(sum(row[4] != 0 for row in self.rows), TRUE)
        self.assertIn("accepted                %d" % TRUE, self.text)
        self.assertIn("rejected                %d" % (PAIRS - TRUE), self.text)
        self.assertEqual(rows(self.original), [])
        self.assertFalse(Path(str(self.whole) + ".part").exists())

    def test_the_checksum_is_the_documented_one(self):
        value = 0xCBF29CE484222325
        for pair, count, columns, data, config, *blobs in self.rows:
            stream = b"".join(n.to_bytes(8, "little") for n in (pair, count, columns, config))
            for blob in (data, *blobs):
                stream += len(blob or b"").to_bytes(8, "little") + (blob or b"")
            for byte in stream:
                value = (value ^ byte) * 0x100000001B3 % 2**64
        self.assertEqual(checksum(self.text), "%016x" % value)

    def test_any_number_of_threads_gives_the_same_rows(self):
        for threads in (1, 2, 4):
            output = self.folder / ("threads%d.db" % threads)
            self.verify("--output", output, "--threads", threads)
            self.assertEqual(rows(output), self.rows)

    def test_in_place_and_again(self):
        text = self.verify()
        self.assertEqual(rows(self.database), self.rows)
        self.assertIn("verified by this run    %d" % PAIRS, text)
        text = self.verify()
        self.assertIn("verified by this run    0\n  verified before         %d" % PAIRS, text)
        self.assertIn("verified by this run    %d" % PAIRS, self.verify("--again"))
        self.assertEqual(rows(self.database), self.rows)

    def test_rows_of_another_program_stay(self):
        first = self.rows[0][0]
        execute(
            self.database,
            "INSERT INTO two_view_geometries(pair_id, rows, cols, data, config) VALUES (?, 0, 2, x'', 1)",
            first,
        )
        self.assertIn("by other programs       1 (--again replaces them)", self.verify())
        self.assertEqual(rows(self.database)[0][:5], (first, 0, 2, b"", 1))
        self.verify("--again")
        self.assertEqual(rows(self.database), self.rows)

    def test_killed_at_several_moments_and_continued(self):
        output, part = self.folder / "out.db", self.folder / "out.db.part"
        generator = random.Random(1)
        kills = 0
        for _ in range(8):
            process = subprocess.Popen(
                [
                    str(PROGRAM),
                    str(self.database),
                    *QUICK,
                    "--output",
                    str(output),
                    "--again",
                    "--threads",
                    "2",
                ],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            time.sleep(generator.uniform(0, 0.5))
            process.send_signal(signal.SIGKILL)
            kills += process.wait() == -signal.SIGKILL
            if output.exists():
                break
            for row in rows(part) if part.exists() else []:
                self.assertIn(row, self.rows)  # whole rows only
        self.assertGreater(kills, 0)
        if not output.exists():
            self.verify("--output", output)
        self.assertEqual(rows(output), self.rows)
        self.assertFalse(part.exists())

    def test_an_output_that_another_program_reads_is_not_cut(self):
        output, part = self.folder / "out.db", self.folder / "out.db.part"
        self.verify("--output", output)
        output.rename(part)
        for ending in ("-wal", "-shm"):  # that the checksum has left
            Path(str(output) + ending).unlink()
        reader = sqlite3.connect(str(part), isolation_level=None)
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM matches").fetchall()
        self.refused(
            "another program is reading it",
            arguments=(self.database, *QUICK, "--output", output, "--again"),
            code=3,
        )
        reader.close()
        self.verify("--output", output)
        self.assertEqual(rows(output), self.rows)

    def test_an_interrupt_keeps_the_part_and_the_same_command_continues(self):
        output = self.folder / "out.db"
        process = subprocess.Popen(
            [str(PROGRAM), str(self.database), "--output", str(output), *QUICK],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
        )
        process.stderr.readline()  # The first line of progress comes when the run begins.
        process.send_signal(signal.SIGINT)
        text, _ = process.communicate()
        if process.returncode == 0:
            self.skipTest("the run ended before the interrupt")
        self.assertEqual(process.returncode, 130, text)
        self.assertIn("interrupted; the same command continues", text)
        self.assertTrue(Path(str(output) + ".part").exists())
        self.verify("--output", output)
        self.assertEqual(rows(output), self.rows)

    def test_parts_are_merged_to_the_undivided_run(self):
        parts = [self.folder / ("part%d.db" % k) for k in (1, 2, 3)]
        for k, part in enumerate(parts, 1):
            text = self.verify("--shard", "%d/3" % k, "--output", part)
            self.assertIn("part %d/3: 40 pairs" % k, text)
            self.assertLess(part.stat().st_size, self.database.stat().st_size)
        merged = ",".join(map(str, parts))
        text = self.verify("--output", self.folder / "merged.db", "--merge", merged)
        self.assertIn("verified by this run    0", text)
        self.assertEqual(checksum(text), checksum(self.text))
        self.assertEqual(rows(self.folder / "merged.db"), self.rows)
        self.assertEqual(rows(self.database), [])
        self.verify("--merge", merged)
        self.assertEqual(rows(self.database), self.rows)

    def test_a_merge_verifies_what_no_part_has(self):
        part = self.folder / "part.db"
        self.verify("--shard", "2/3", "--output", part)
        self.assertIn("verified before         40", self.verify("--shard", "2/3", "--output", part))
        text = self.verify("--output", self.folder / "merged.db", "--merge", part)
        self.assertIn("verified by this run    80", text)
        self.assertEqual(checksum(text), checksum(self.text))

    def test_parts_that_do_not_fit_are_refused(self):
        part, output = self.folder / "part.db", self.folder / "out.db"
        self.verify("--shard", "1/2", "--output", part, "--options", "min_matches=16")
        merge = (self.database, *QUICK, "--output", output, "--merge")
        self.refused("part.db", "other settings", "min_matches=15", arguments=(*merge, part))
        self.refused("none.db", "no such file", arguments=(*merge, self.folder / "none.db"))
        self.refused("house.db", "no table corrsel_verify", arguments=(*merge, self.original))
        part.unlink()
        self.verify("--shard", "1/2", "--output", part)
        execute(self.database, "UPDATE matches SET rows = 79, data = substr(data, 1, 79 * 8)")
        output.with_name("out.db.part").unlink()
        self.refused("part.db", "60 pairs have other matches", arguments=(*merge, part))

    def test_listed_pairs(self):
        listed = self.folder / "pairs.txt"
        names = ["place000_000.jpg place000_001.jpg", "place001_002.jpg place001_000.jpg"]
        listed.write_text("\n".join(names) + "\n" + names[0] + "\n")
        self.assertIn("house.db: 2 pairs", self.verify("--pairs", listed))
        self.assertTrue(set(rows(self.database)) <= set(self.rows))
        listed.write_text("place000_000.jpg nothing.jpg\n")
        self.refused("pairs.txt", "nothing.jpg", arguments=(self.database, "--pairs", listed))

    def test_reports(self):
        files = [self.folder / name for name in ("pairs.csv", "run.json", "run.html")]
        execute(self.database, "UPDATE matches SET data = x'00' WHERE pair_id = ?", self.rows[3][0])
        text = self.verify("--report", ",".join(map(str, files)), code=1)
        self.assertIn("faulty: place", text)
        with files[0].open(newline="") as stream:
            table = list(csv.DictReader(stream))
        self.assertEqual(len(table), PAIRS)
        self.assertEqual(table[3]["status"], "faulty")
        self.assertIn("bytes", table[3]["message"])
        self.assertEqual(sum(row["config"] not in ("", "undefined") for row in table), TRUE - 1)
        for row, stored in zip(table[:3], self.rows):
            self.assertEqual((int(row["raw"]), int(row["kept"])), (80, stored[1]))
        summary = json.loads(files[1].read_text())
        self.assertEqual(summary["pairs"]["faulty"], 1)
        self.assertEqual(summary["results"]["accepted"], TRUE - 1)
        self.assertEqual(summary["checksum"], checksum(text))
        page = files[2].read_text()
        for part in ("<image", "data:image/png", "Faulty pairs", "place000_000.jpg"):
            self.assertIn(part, page)
        again = [path.with_name("again_" + path.name) for path in files]
        self.verify("--report", ",".join(map(str, again)), code=1)
        self.assertEqual(again[0].read_bytes(), files[0].read_bytes())

    def test_faulty_pairs_are_named_and_strict_stops(self):
        execute(self.database, "UPDATE matches SET cols = 3 WHERE pair_id = ?", self.rows[5][0])
        text = self.verify("--strict", code=1)
        self.assertIn("faulty", text)
        self.assertEqual(rows(self.database), self.rows[:5])
        self.verify(code=1)
        self.assertEqual(rows(self.database), self.rows[:5] + self.rows[6:])

    def test_tracks(self):
        tracks, summary = self.folder / "tracks.csv", self.folder / "run.json"
        text = self.verify("--tracks", tracks, "--report", summary)
        self.assertIn("triplets of images", text)
        with tracks.open(newline="") as stream:
            table = list(csv.DictReader(stream))
        found = json.loads(summary.read_text())
        self.assertEqual(found["tracks"]["observations"], len(table))
        self.assertEqual(found["tracks"]["tracks"], len({row["track"] for row in table}))
        self.assertGreater(found["cycles"]["triplets"], 0)
        # A track stays in the place whose point it is.
        places = {}
        for row in table:
            places.setdefault(row["track"], set()).add(row["name"][:8])
        self.assertTrue(all(len(names) == 1 for names in places.values()))

    def test_a_dry_run_writes_nothing(self):
        before = self.database.read_bytes()
        text = self.verify("--dry-run", "--report", self.folder / "pairs.csv")
        self.assertIn("dry run: nothing was written", text)
        self.assertIn("accepted                %d" % TRUE, text)
        self.assertEqual(self.database.read_bytes(), before)
        self.assertEqual(len((self.folder / "pairs.csv").read_text().splitlines()), PAIRS + 1)

    def test_a_database_in_use(self):
        other = sqlite3.connect(str(self.database), isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        self.refused("house.db", "another program", arguments=(self.database, *QUICK), code=3)
        other.execute("ROLLBACK")
        other.close()
        self.assertEqual(rows(self.database), [])

    def test_files_that_cannot_be_used(self):
        self.refused("none.db", arguments=(self.folder / "none.db",), code=4)
        text = self.folder / "text.db"
        text.write_text("no database " * 100)
        self.refused("text.db", arguments=(text,), code=2)
        execute(self.database, "DROP TABLE matches")
        self.refused("matches", arguments=(self.database,))

    def test_an_output_is_never_overwritten(self):
        output = self.folder / "out.db"
        self.verify("--output", output)
        self.refused("out.db exists", "remove it", arguments=(self.database, *QUICK, "--output", output))
        other = self.folder / "other.db"
        generate(other, "--seed", "2")
        execute(other, "UPDATE images SET name = 'x' || name")
        shutil.copy(str(other), str(self.folder / "new.db.part"))
        self.refused(
            "new.db.part", "another database", arguments=(self.database, "--output", self.folder / "new.db")
        )
        self.refused(
            "no part of a run",
            arguments=(self.original, *QUICK, "--shard", "1/2", "--output", self.database),
        )

    def test_wrong_arguments(self):
        for arguments, part in (
            ((), "DATABASE"),
            ((self.database, "--treads", "2"), "--threads"),
            ((self.database, "--threads", "-1"), "--threads must be between 0"),
            ((self.database, "--memory", "x"), "--memory"),
            ((self.database, "--selector", "nothing"), "nothing"),
            ((self.database, "--options", "min_matches"), "name=value"),
            ((self.database, "--options", "min_match=3"), "min_matches"),
            ((self.database, "--options", "x.y=3"), "neither match. nor extract."),
            ((self.database, "--report", "pairs.txt"), "none of .csv, .json, .html"),
            ((self.database, "--output", self.database), "is DATABASE itself"),
            ((self.database, "--shard", "1/2"), "--shard needs --output"),
            ((self.database, "--shard", "3/2"), "1 <= i <= n"),
            ((self.database, "--shard", "1/2", "--output", "a", "--merge", "b"), "leave one"),
            ((self.database, "--shard", "1/2", "--output", "a", "--match"), "before the run is divided"),
            ((self.database, "--extract", "photos", "--output", "a"), "--extract fills DATABASE itself"),
            ((self.database, "--camera", "PINHOLE,1,1,1,1"), "without --extract"),
            ((self.database, "--sequential", "3"), "--sequential needs --match"),
            ((self.database, "--dry-run", "--match"), "--dry-run writes nothing"),
            ((self.database, "--features", "f.h5"), "give --output"),
            ((self.database, "--tracks", "t.csv", "--dry-run"), "--tracks needs all stored pairs"),
            ((self.database, "--features", "f.h5", "--shard", "1/2", "--output", "a"), "of COLMAP"),
        ):
            with self.subTest(arguments=arguments):
                self.refused(part, arguments=arguments)
        self.assertEqual(run("--help")[0], 0)


if __name__ == "__main__":
    unittest.main()
