#!/usr/bin/env python3
"""Verification of databases of COLMAP: what is stored, what is reported, interruption, errors."""

import contextlib
import os
import pathlib
import signal
import sqlite3
import tempfile
import threading
import unittest

import corrsel
import numpy as np
from corrsel.files import colmap

try:
    import h5py
except ImportError:
    h5py = None
from support import releases_the_lock

CAMERA = np.array([[700, 0, 320], [0, 700, 240], [0, 0, 1.0]])
SIZE = (640, 480)
IMAGES = ("a.jpg", "b.jpg", "c.jpg", "other.jpg")


def view(points, angle, position):
    """Return positions in the image of a camera that is turned by `angle` about y, px."""
    rotation = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    seen = (points - position) @ rotation.T @ CAMERA.T
    return seen[:, :2] / seen[:, 2:]


def write_house(path):
    """Write a database with three images of one scene and one of another scene; all pairs have 120 matches."""
    random = np.random.RandomState(5)
    points = random.uniform((-2, -1.5, 6), (2, 1.5, 10), (120, 3))
    positions = [view(points, 0, (0, 0, 0)), view(points, 0.05, (0.6, 0, 0)), view(points, 0.1, (1, 0.2, 0))]
    positions.append(random.uniform((0, 0), SIZE, (120, 2)))
    images = [(name, SIZE, place, None) for name, place in zip(IMAGES, positions)]
    rows = np.stack([np.arange(120)] * 2, 1)
    colmap.write_database(path, images, [(i, j, rows) for i in range(4) for j in range(i + 1, 4)])


class VerificationCase(unittest.TestCase):
    """What the tests share: a folder with a database."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.path = self.folder / "house.db"
        write_house(self.path)

    @staticmethod
    @contextlib.contextmanager
    def opened(path):
        with contextlib.closing(sqlite3.connect(str(path))) as database:
            yield database

    def change(self, sql, *values):
        with self.opened(self.path) as database:
            database.execute(sql, values)
            database.commit()

    def rows(self, path):
        """Return the rows of the table two_view_geometries."""
        with self.opened(path) as database:
            return database.execute("SELECT * FROM two_view_geometries ORDER BY pair_id").fetchall()

    def assert_raises(self, error, words, *arguments, **keywords):
        with self.assertRaises(error) as caught:
            corrsel.verify(*arguments, **keywords)
        for word in words:
            self.assertIn(word, str(caught.exception))


class Results(VerificationCase):
    """Pairs are accepted and rejected, stored and reported."""

    def test_pairs_of_one_scene_are_accepted(self):
        report = corrsel.verify(self.path)
        self.assertEqual(len(report), 6)
        self.assertEqual(report.path, str(self.path))
        self.assertEqual(report.images, dict(enumerate(IMAGES, 1)))
        self.assertEqual(
            [tuple(pair) for pair in report.pairs], [(1, 2), (1, 3), (1, 4), (2, 3), (2, 4), (3, 4)]
        )
        self.assertEqual(report.names()[1], ("a.jpg", "c.jpg"))
        np.testing.assert_array_equal(report.accepted, [True, True, False, True, False, False])
        np.testing.assert_array_equal(report.putative, [120] * 6)
        np.testing.assert_array_equal(report.inliers, np.where(report.accepted, 120, 0))
        self.assertEqual(report.configs, {"undefined": 3, "uncalibrated": 3})
        self.assertTrue((report.confidence[report.accepted] > 20).all())
        self.assertEqual((report.verified, report.skipped, report.of_others), (6, 0, 0))
        self.assertEqual((report.faulty, report.warnings), ([], []))
        self.assertIn("auto", report.configuration)

    def test_rows_are_those_of_the_report(self):
        report = corrsel.verify(self.path)
        rows = self.rows(self.path)
        self.assertEqual([row[0] for row in rows], [colmap.pair_id(*map(int, pair)) for pair in report.pairs])
        self.assertEqual([row[1] for row in rows], report.inliers.tolist())
        self.assertEqual([row[4] for row in rows], report.config.tolist())
        _, count, columns, data, _, fundamental = rows[0][:6]
        inliers = np.frombuffer(data, np.uint32).reshape(count, columns)
        np.testing.assert_array_equal(inliers, np.stack([np.arange(120)] * 2, 1))
        with self.opened(self.path) as database:
            blobs = database.execute(
                "SELECT data FROM keypoints WHERE image_id < 3 ORDER BY image_id"
            ).fetchall()
        left, right = (
            np.insert(np.frombuffer(blob, np.float32).reshape(-1, 2), 2, 1, axis=1) for blob, in blobs
        )
        matrix = np.frombuffer(fundamental).reshape(3, 3)
        lines = left @ matrix.T
        distances = np.abs((right * lines).sum(1)) / np.hypot(lines[:, 0], lines[:, 1])
        self.assertLess(distances.max(), 0.05)  # px

    def test_a_copy_leaves_the_database_as_it_is(self):
        before = self.path.read_bytes()
        output = self.folder / "verified.db"
        report = corrsel.verify(self.path, output)
        self.assertEqual(report.path, str(output))
        self.assertEqual(self.path.read_bytes(), before)
        self.assertEqual(len(self.rows(output)), 6)
        self.assertEqual(sorted(self.folder.iterdir()), [self.path, output])
        self.assert_raises(FileExistsError, ["verified.db", "remove it"], self.path, output)

    def test_threads_give_the_same_rows(self):
        rows = []
        for threads in (1, 3):
            output = self.folder / ("%d.db" % threads)
            corrsel.verify(str(self.path), str(output), threads=threads)
            rows.append(self.rows(output))
        self.assertEqual(rows[0], rows[1])

    def test_runs_continue(self):
        self.assertEqual(corrsel.verify(self.path, pairs=[("c.jpg", "a.jpg")]).pairs.tolist(), [[1, 3]])
        report = corrsel.verify(self.path)
        self.assertEqual((report.verified, report.skipped, len(report)), (5, 1, 6))
        self.assertEqual(corrsel.verify(self.path, again=True).verified, 6)
        self.assertEqual(corrsel.verify(self.path, min_matches=20).verified, 6)

    def test_rows_of_other_programs_stay(self):
        self.change(
            "INSERT INTO two_view_geometries(pair_id, rows, cols, config) VALUES (2147483649, 0, 2, 0)"
        )
        report = corrsel.verify(self.path)
        self.assertEqual((report.of_others, len(report)), (1, 5))
        self.assertEqual(self.rows(self.path)[0][1], 0)
        self.assertEqual(corrsel.verify(self.path, self.folder / "copy.db").of_others, 0)
        self.assertEqual(corrsel.verify(self.path, again=True).inliers[0], 120)

    def test_dry_runs_write_nothing(self):
        report = corrsel.verify(self.path, dry_run=True)
        self.assertEqual(report.accepted.sum(), 3)
        self.assertEqual(self.rows(self.path), [])

    def test_options(self):
        options = {option.name: option for option in corrsel.options("verification")}
        self.assertEqual(options["min_matches"].value, 15)
        self.assertEqual(corrsel.verify(self.path, min_matches=121).accepted.sum(), 0)
        self.assertIn("lpm", corrsel.verify(self.path, selector="lpm", dry_run=True).configuration)

    def test_numbers_have_names(self):
        report = corrsel.verify(self.path)
        self.assertEqual(report.CONFIGS[report.config[0]], "uncalibrated")
        self.assertEqual(report.STATUSES[report.status[0]], "ok")
        self.assertEqual(report.SCENES[report.scene[0]], "rigid")


@unittest.skipUnless(h5py, "needs python3-h5py")
class FilesOfHloc(VerificationCase):
    """Files of hloc are verified like databases."""

    def setUp(self):
        super().setUp()
        self.features, self.matches = self.folder / "features.h5", self.folder / "matches.h5"
        with self.opened(self.path) as database:
            blobs = database.execute("SELECT data FROM keypoints ORDER BY image_id").fetchall()
        with h5py.File(str(self.features), "w") as file:
            for name, (blob,) in zip(IMAGES, blobs):
                group = file.create_group(name)
                group["keypoints"] = np.frombuffer(blob, np.float32).reshape(-1, 2)
                group["image_size"] = np.array(SIZE)
        with h5py.File(str(self.matches), "w") as file:
            for i, first in enumerate(IMAGES):
                for second in IMAGES[i + 1 :]:
                    file["%s/%s/matches0" % (first, second)] = np.arange(120, dtype=np.int16)

    def test_output(self):
        output = self.folder / "verified.h5"
        report = corrsel.verify(self.matches, output, features=self.features)
        self.assertEqual((report.path, len(report), report.accepted.sum()), (str(output), 6, 3))
        with h5py.File(str(output), "r") as file:
            self.assertTrue((file["a.jpg/b.jpg/matches0"][()] == np.arange(120)).all())
            self.assertTrue((file["a.jpg/other.jpg/matches0"][()] == -1).all())
        self.assert_raises(OSError, ["verified.h5"], self.matches, output, features=self.features)

    def test_dry_runs_and_missing_outputs(self):
        report = corrsel.verify(self.matches, features=self.features, dry_run=True)
        self.assertEqual(report.accepted.sum(), 3)
        self.assert_raises(ValueError, ["output", "never changed"], self.matches, features=self.features)


class Progress(VerificationCase):
    """The run tells how far it is, and ends when it is asked to."""

    def test_calls(self):
        calls = []
        corrsel.verify(self.path, progress=lambda *values: calls.append(values))
        self.assertEqual(calls[0][:3], (0, 6, 0))
        self.assertEqual(calls[-1][:3], (6, 6, 3))

    def test_what_it_raises_is_raised(self):
        def refuse(*_):
            raise RuntimeError("enough")

        output = self.folder / "verified.db"
        self.assert_raises(RuntimeError, ["enough"], self.path, output, threads=2, progress=refuse)
        self.assertFalse(output.exists())
        self.assertTrue((self.folder / "verified.db.part").exists())
        report = corrsel.verify(self.path, output)
        self.assertEqual((len(report), report.path), (6, str(output)))
        self.assertFalse((self.folder / "verified.db.part").exists())

    def test_interruption(self):
        with self.assertRaises(KeyboardInterrupt):
            corrsel.verify(self.path, progress=lambda *_: os.kill(os.getpid(), signal.SIGINT))
        self.assertEqual(len(corrsel.verify(self.path)), 6)

    def test_other_threads_run_meanwhile(self):
        self.assertTrue(releases_the_lock(lambda: corrsel.verify(self.path, again=True)))

    def test_two_databases_at_once(self):
        other = self.folder / "other.db"
        write_house(other)
        reports = {}
        threads = [
            threading.Thread(target=lambda path=path: reports.update({path: corrsel.verify(path, threads=2)}))
            for path in (self.path, other)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({len(report) for report in reports.values()}, {6})
        self.assertEqual(self.rows(self.path), self.rows(other))


class Errors(VerificationCase):
    """Messages name the file, what is wrong, and the remedy."""

    def test_rows_that_cannot_be_used(self):
        self.change("UPDATE matches SET data = zeroblob(7) WHERE pair_id = 2147483649")
        self.change("DELETE FROM keypoints WHERE image_id = 4")
        report = corrsel.verify(self.path)
        self.assertEqual(
            [fault[:2] for fault in report.faulty][:2], [("a.jpg", "b.jpg"), ("a.jpg", "other.jpg")]
        )
        self.assertIn("7 bytes", report.faulty[0].message)
        self.assertIn("table keypoints, image_id 4", report.faulty[1].message)
        self.assertEqual(report.pairs.tolist(), [[1, 3], [2, 3]])
        self.assertEqual(len(self.rows(self.path)), 2)
        strict = corrsel.verify(self.path, self.folder / "strict.db", strict=True)
        self.assertEqual(len(strict.faulty), 1)
        self.assertTrue(strict.path.endswith(".part"))

    def test_cameras_that_are_not_known(self):
        self.change("UPDATE cameras SET model = 99 WHERE camera_id = 2")
        report = corrsel.verify(self.path)
        self.assertEqual(len(report.warnings), 1)
        self.assertIn("camera_id 2", report.warnings[0])
        self.assertEqual(report.accepted.sum(), 3)

    def test_files(self):
        self.assert_raises(OSError, ["none.db", "does not exist"], self.folder / "none.db")
        (self.folder / "text.db").write_text("text" * 1000)
        self.assert_raises(ValueError, ["text.db", "no database"], self.folder / "text.db")
        self.change("ALTER TABLE two_view_geometries RENAME COLUMN F TO G")
        self.assert_raises(ValueError, ["house.db", "two_view_geometries", "column F"], self.path)

    def test_arguments(self):
        self.assert_raises(ValueError, ["min_matches"], self.path, min_matches=-1)
        self.assert_raises(ValueError, ["colour"], self.path, colour=1)
        self.assert_raises(ValueError, ["none"], self.path, selector="none")
        self.assert_raises(ValueError, ["no image 'd.jpg'"], self.path, pairs=[("a.jpg", "d.jpg")])
        self.assert_raises(ValueError, ["'a.jpg'", "itself"], self.path, pairs=[("a.jpg", "a.jpg")])
        self.assert_raises(TypeError, ["progress", "3"], self.path, progress=3)
        self.assert_raises(ValueError, ["threads"], self.path, threads=0)
        self.assert_raises(ValueError, ["memory"], self.path, memory=-1)
        self.assert_raises(TypeError, ["min_matches"], self.path, min_matches=[1])


if __name__ == "__main__":
    unittest.main()
