#!/usr/bin/env python3
"""Tests of corrsel_match, and of python3 -m corrsel, its second front: python3 test_match_program.py"""
import csv
import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

DEVEL = os.environ.get("CORRSEL_DEVEL_DIR")
BIN = Path(DEVEL) / "lib" / "corrsel" if DEVEL else Path(os.environ["CORRSEL_BINARY_DIR"]) / "bin"
PROGRAM = [str(BIN / "corrsel_match")]
MODULE = [sys.executable, "-m", "corrsel"]
SHIFT = np.array([-12, -7])


def has(*modules):
    """Whether modules of Python can be found."""
    try:
        return all(importlib.util.find_spec(module) is not None for module in modules)
    except ImportError:
        return False


HAS_MODULE = has("corrsel", "corrsel._features", "cv2", "yaml")
needs_module = unittest.skipUnless(HAS_MODULE, "corrsel's modules in C++, cv2 or yaml are missing")
FRONTS = [PROGRAM, MODULE] if HAS_MODULE else [PROGRAM]


def write_image(path, pixels):
    """Write a grey image as PGM, which needs no library."""
    path.write_bytes(b"P5\n%d %d\n255\n" % pixels.shape[::-1] + pixels.astype(np.uint8).tobytes())


class MatchProgram(unittest.TestCase):
    """Two images of the same blocks, shifted, and one of others."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="corrsel_match_")
        self.addCleanup(temporary.cleanup)
        self.root = Path(temporary.name)
        random = np.random.default_rng(1)
        blocks, others = (np.kron(random.integers(0, 255, (24, 29)), np.ones((8, 8))) for _ in range(2))
        x, y = -SHIFT
        for name, pixels in (
            ("left", blocks[:160, :200]),
            ("right", blocks[y : y + 160, x : x + 200]),
            ("other", others[:160, :200]),
        ):
            write_image(self.root / (name + ".pgm"), pixels)

    def call(self, *words, front=None, images=("left.pgm", "right.pgm")):
        """Return exit code, output and errors of the program."""
        command = (front or PROGRAM) + list(images) + list(words)
        done = subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=str(self.root),
            universal_newlines=True,
        )
        return done.returncode, done.stdout, done.stderr

    def rows(self, name):
        """Return the rows of a CSV file."""
        with open(str(self.root / name), newline="", encoding="utf-8") as stream:
            return list(csv.DictReader(stream))

    def test_it_tells_what_was_found(self):
        code, text, errors = self.call()
        self.assertEqual((code, errors), (0, ""))
        for pattern in (
            r"^left +left.pgm, 200 x 160 px, \d+ features$",
            r"^scene +a plane, or a camera that only turns$",
            r"^matches +\d+ of \d+ kept \(\d+\.\d %\), by auto of sift\+sift$",
            r"^status +ok",
            r"^confidence +\d+\.\d: ",
            r"^noise +\d\.\d\d px, the standard deviation of each coordinate of the residuals$",
            r"^homography( +\S+){3}$",
            r"^ +maps points of the left image to the right one, px$",
            r"^time +reading \d+ ms, features \d+ ms, matching \d+ ms, selection \d+\.\d ms$",
        ):
            self.assertTrue(re.search(pattern, text, re.MULTILINE), pattern + "\n" + text)

    def test_a_small_confidence_is_explained(self):
        code, text, _ = self.call(images=("left.pgm", "other.pgm"))
        self.assertEqual(code, 1)
        self.assertRegex(text, r"(?m)^status +uncertain: ")
        self.assertRegex(text, r"(?m)^confidence +0: chance explains the agreement$")
        self.assertRegex(text, r"(?m)^ +\S.*; do not rely on it$")

    def test_json_has_the_same(self):
        code, text, _ = self.call("--json", "--features", "orb+orb")
        found = json.loads(text)
        self.assertEqual(code, 0)
        self.assertEqual((found["status"], found["scene"]), ("ok", "plane_or_rotation"))
        self.assertEqual((found["left"]["width"], found["left"]["height"]), (200, 160))
        self.assertEqual((found["features"], found["selector"], found["pose"]), ("orb+orb", "auto", None))
        model = np.reshape(found["model"], (3, 3)) / found["model"][8]
        np.testing.assert_allclose(model[:2, 2], SHIFT, atol=0.5)
        self.assertEqual(set(found["seconds"]), {"read", "features", "match", "select"})

    def test_matches_are_written(self):
        code, text, _ = self.call("--csv", "kept.csv", "--putative", "all.csv")
        self.assertEqual(code, 0)
        self.assertRegex(text, r"(?m)^written +kept.csv, all.csv$")
        kept, putative = self.rows("kept.csv"), self.rows("all.csv")
        self.assertGreater(len(kept), 50)
        self.assertGreater(len(putative), len(kept))
        for row in kept:
            left, right = ([float(row[axis + side]) for axis in "xy"] for side in ("_left", "_right"))
            self.assertLess(np.linalg.norm(np.subtract(right, left) - SHIFT), 6)
            of_all = putative[int(row["row"])]
            self.assertEqual({name: row[name] for name in of_all}, of_all)
            self.assertTrue(0 <= float(row["probability"]) <= 1)

    def test_the_picture_is_an_image_of_the_given_width(self):
        self.assertEqual(self.call("--picture", "found.png", "--width", "640", "--lines", "5")[0], 0)
        data = (self.root / "found.png").read_bytes()
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        width, height = (int.from_bytes(data[start : start + 4], "big") for start in (16, 20))
        self.assertAlmostEqual(width, 640, delta=1)
        self.assertGreater(height, 250)

    def test_groups_are_counted(self):
        code, text, _ = self.call("--selector", "planes", "--json")
        found = json.loads(text)
        self.assertEqual(code, 0)
        self.assertEqual(sum(found["groups"]), found["n_selected"])

    def test_options_of_the_selector(self):
        strict, loose = (
            json.loads(self.call("--json", "--selector", "usac", "--set", values)[1])
            for values in ("threshold=0.3,seed=2", "threshold=5,seed=2")
        )
        self.assertLess(strict["n_selected"], loose["n_selected"])

    def test_threads_change_nothing(self):
        texts = []
        for threads in ("1", "2", "3"):
            self.assertEqual(self.call("--csv", "kept.csv", "--threads", threads)[0], 0)
            texts.append((self.root / "kept.csv").read_bytes())
        self.assertEqual(len(set(texts)), 1)

    def test_different_places_are_no_success(self):
        code, text, _ = self.call(images=("left.pgm", "other.pgm"))
        self.assertEqual(code, 1, text)
        self.assertIn("nothing in common beyond chance", text)

    def test_cameras_give_a_pose(self):
        (self.root / "chain.yaml").write_text(
            "cam0:\n  T_cam_imu:\n  - [1, 0, 0, 0]\n  camera_model: pinhole\n  intrinsics: [150, 150, 100, 80]\n"
            "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [200, 160]\n"
            "cam1:\n  camera_model: pinhole\n  intrinsics: [150, 150, 100, 80]\n"
            "  distortion_model: equidistant\n  distortion_coeffs: [0.1, 0, 0, 0]\n  resolution: [200, 160]\n"
        )
        poses = {}
        for camera in ("150,150,100,80", "chain.yaml", "chain.yaml:cam1"):
            for front in FRONTS:
                code, text, errors = self.call("--camera", camera, "--json", front=front)
                found = json.loads(text)
                self.assertEqual((code, found["selector"], found["status"]), (0, "pose", "ok"), errors)
                poses.setdefault(camera, []).append(found["pose"])
        for both in poses.values():
            self.assertEqual(both[0], both[-1])
        self.assertEqual(poses["chain.yaml"], poses["150,150,100,80"])
        self.assertNotEqual(poses["chain.yaml"], poses["chain.yaml:cam1"])
        self.assertIn(poses["chain.yaml"][0]["motion"], ("rotation", "planar"))
        code, text, _ = self.call("--left-camera", "chain.yaml", "--right-camera", "chain.yaml:cam1")
        self.assertTrue(re.search(r"^rotation +\S+ degrees", text, re.MULTILINE), text)

    @needs_module
    def test_both_fronts_agree(self):
        texts, files = [], []
        for front in (PROGRAM, MODULE):
            code, text, errors = self.call("--csv", "kept.csv", "--picture", "found.png", front=front)
            self.assertEqual((code, errors), (0, ""))
            texts.append([line for line in text.splitlines() if not line.startswith("time")])
            files.append([(self.root / name).read_bytes() for name in ("kept.csv", "found.png")])
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(files[0], files[1])

    @needs_module
    def test_npz_is_what_a_run_writes(self):
        code, text, errors = self.call("--npz", "kept.npz", "--json", front=MODULE)
        self.assertEqual((code, errors), (0, ""))
        found = json.loads(text)
        with np.load(str(self.root / "kept.npz")) as arrays:
            self.assertEqual(len(arrays["matches"]), found["n_selected"])
            self.assertEqual(len(arrays["mask"]), found["n_putative"])
            left, right = (arrays["keypoints%d" % i][arrays["matches"][:, i]] for i in (0, 1))
            self.assertLess(np.abs(right - left - SHIFT).max(), 6)
            np.testing.assert_allclose(arrays["model"].ravel(), found["model"])
            self.assertEqual((str(arrays["image0"]), str(arrays["status"])), ("left.pgm", "ok"))
            self.assertEqual(arrays["image_size1"].tolist(), [200, 160])
        from corrsel.files.npz import read_npz  # pylint: disable=import-outside-toplevel

        pair = read_npz(self.root / "kept.npz", "pair")
        self.assertEqual(len(pair.left), found["n_selected"])

    def test_errors_name_the_input_and_the_remedy(self):
        (self.root / "empty.png").write_bytes(b"")
        (self.root / "page.jpg").write_text("<html>not found</html>")
        (self.root / "small.yaml").write_text(
            "camera_model: pinhole\nintrinsics: [9, 9, 4, 4]\ndistortion_model: radtan\n"
            "distortion_coeffs: [0, 0, 0, 0]\nresolution: [8, 8]\n"
        )
        both = ("left.pgm", "right.pgm")
        cases = [
            (("none.png", "right.pgm"), (), ("none.png", "no such file")),
            (("left.pgm", "."), (), ("folder", "image file")),
            (("left.pgm", "empty.png"), (), ("empty.png", "0 bytes")),
            (("left.pgm", "page.jpg"), (), ("page.jpg", "web page")),
            (("left.pgm", "./left.pgm"), (), ("same file", "left.pgm")),
            (("left.pgm",), (), ("LEFT, RIGHT", "1 given", "--help")),
            (both, ("--selector", "gsm"), ("gsm", "did you mean 'gms'")),
            (both, ("--set", "threshold"), ("--set has 'threshold'", "NAME=VALUE")),
            (both, ("--set", "seed=1,seed=2"), ("'seed' twice",)),
            (both, ("--set", "tresh=1"), ("tresh", "threshold")),
            (both, ("--features", "sift+sft"), ("sft", "sift")),
            (both, ("--threads", "0"), ("threads", "0", "256")),
            (both, ("--picture", "found.xyz"), ("found.xyz", ".png")),
            (both, ("--camera", "1,2,3"), ("1,2,3", "fx,fy,cx,cy")),
            (both, ("--camera", "1,2,3,x"), ("'x'", "1,2,3,x")),
            (both, ("--camera", "-1,2,3,4"), ("matrix", "positive")),
            (both, ("--camera", "page.jpg"), ("page.jpg", "Kalibr")),
            (both, ("--camera", "small.yaml"), ("small.yaml", "8x8", "200x160")),
            (both, ("--left-camera", "150,150,100,80"), ("right image", "--right_camera")),
        ]
        for images, words, parts in cases:
            # What the fronts do by themselves.
            own = "page.jpg" in images + words or "found.xyz" in words
            for front in FRONTS if own else [PROGRAM]:
                with self.subTest(front=front[-1], images=images, words=words):
                    code, text, errors = self.call(*words, front=front, images=images)
                    self.assertEqual((code, text), (2, ""), errors)
                    self.assertEqual(len(errors.splitlines()), 1, errors)
                    for part in parts:
                        self.assertIn(part, errors)

    def test_a_file_that_cannot_be_written_does_not_cost_the_answer(self):
        for words in (("--csv", "no/kept.csv"), ("--picture", "no/found.png")):
            code, text, errors = self.call(*words)
            self.assertEqual((code, len(errors.splitlines())), (2, 1), errors)
            self.assertIn(words[1], errors)
            self.assertIn("folder", errors)
            self.assertRegex(text, r"(?m)^homography ")
            self.assertNotIn("written", text)

    @needs_module
    def test_an_npz_file_that_cannot_be_written(self):
        code, _, errors = self.call("--npz", "no/kept.npz", front=MODULE)
        self.assertEqual((code, len(errors.splitlines())), (2, 1), errors)
        self.assertIn("no/kept.npz", errors)
        self.assertIn("folder", errors)

    def test_help_states_the_exit_codes(self):
        for front in FRONTS:
            code, text, _ = self.call("--help", front=front, images=())
            self.assertEqual(code, 0)
            self.assertIn("exit code: 0 =", text)
            self.assertEqual("--npz" in text, front is MODULE)

    @needs_module
    def test_without_cv2_the_error_names_the_package(self):
        (self.root / "cv2.py").write_text("raise ImportError('none here')\n")
        code, _, errors = self.call(front=MODULE)
        self.assertEqual(code, 2)
        self.assertIn("python3-opencv", errors)


if __name__ == "__main__":
    unittest.main()
