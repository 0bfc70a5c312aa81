#!/usr/bin/env python3
"""The programs in examples/, built against the package as installed into a temporary folder, and run."""

import os
import pathlib
import re
import sys
import tempfile
import unittest

import installed

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


def write_image(path, image):
    """Write a grey image as PGM."""
    path.write_bytes(b"P5 %d %d 255\n" % (image.shape[1], image.shape[0]) + image.tobytes())


class Examples(unittest.TestCase):
    """Each example does what its first lines state."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="corrsel_examples_")
        cls.addClassCleanup(folder.cleanup)
        cls.work = pathlib.Path(folder.name)
        cls.prefix = installed.install(cls.work / "destination")
        cls.build = cls.work / "build"
        code, text = installed.build_project(EXAMPLES, cls.build, cls.prefix)
        if code != 0:
            raise AssertionError("the examples do not build:\n" + text)

    def frames(self):
        """Return the names of two files with images of one scene, of which the first is the left one."""
        try:
            from support import images  # pylint: disable=import-outside-toplevel
        except ImportError as error:
            self.skipTest("%s; the Python package is needed" % error)
        files = [self.work / (name + ".pgm") for name in ("left", "right")]
        for file, image in zip(files, images()):
            write_image(file, image)
        return files

    def test_select(self):
        code, text = installed.run([self.build / "01_select"])
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"^ok: (69\d|70\d) of 1000 matches, model homography, confidence \d+")

    def test_match_images(self):
        picture = self.work / "matches.png"
        code, text = installed.run([self.build / "02_match_images", *self.frames(), picture])
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"^ok: \d+ of \d+ matches, model homography\n")
        self.assertGreater(picture.stat().st_size, 1000)

    def test_match_images_names_what_it_cannot_read(self):
        code, text = installed.run([self.build / "02_match_images", "/nonexistent.png", "/nonexistent.png"])
        self.assertEqual(code, 2)
        self.assertIn("/nonexistent.png", text)

    def test_track_images(self):
        left, right = self.frames()
        file = self.work / "tracks.csv"
        code, text = installed.run(
            [self.build / "06_track_images", file, "sift+sift", "1", left, left, right, left]
        )
        self.assertEqual(code, 0, text)
        self.assertRegex(
            text, r"^4 images: features continued a track \d+ times, and \d+ times after a gap\n"
        )
        lines = file.read_text().splitlines()
        self.assertEqual(lines[0], "track,stamp,keypoint,x,y")
        self.assertGreater(len(lines), 100)

    def run_python(self, *command):
        """Return what an example in Python prints."""
        try:
            import corrsel  # pylint: disable=import-outside-toplevel,unused-import
            import cv2  # pylint: disable=import-outside-toplevel,unused-import
        except ImportError as error:
            self.skipTest("%s; python3-opencv and the Python package are needed" % error)
        packages = [path.parent.parent for path in self.prefix.glob("lib/**/corrsel/_core.*.so")]
        paths = [str(path) for path in packages] + [os.environ.get("PYTHONPATH", "")]
        code, text = installed.run([sys.executable, *command], PYTHONPATH=os.pathsep.join(paths))
        self.assertEqual(code, 0, text)
        return text

    def test_camera_pipeline(self):
        left, right = self.frames()
        text = self.run_python(EXAMPLES / "03_camera_pipeline.py", left, right, right)
        first, second = text.splitlines()
        self.assertRegex(first, r"^frame 1: \d+ of \d+, ok, plane_or_rotation: decompose the homography")
        self.assertRegex(second, r"^frame 2: (\d+) of \1, ok, at_rest: standing still")

    def test_relative_pose(self):
        code, text = installed.run([self.build / "04_relative_pose"])
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"^general: \d+ of \d+ matches, noise 0\.\d+ px\n")
        rotation = re.search(r"\[(.*?);\n(.*?);\n(.*?)\]", text, re.S).groups()
        self.assertAlmostEqual(float(rotation[0].split(",")[2]), 0.1045, delta=0.005)
        translation = re.search(r"translation \[(.*?)\]", text).group(1).split(",")
        for found, true in zip(translation, (-0.9945, 0, 0.1045)):
            self.assertAlmostEqual(float(found), true, delta=0.02)
        deviations = [float(word) for word in re.search(r"deviations (.*) degrees", text).group(1).split()]
        self.assertEqual(len(deviations), 5)
        self.assertTrue(all(0.001 < deviation < 0.5 for deviation in deviations), text)

    def test_epipolar_fisheye(self):
        picture = self.work / "curves.png"
        text = self.run_python(EXAMPLES / "05_epipolar_fisheye.py", picture)
        self.assertRegex(text, r"^general: \d\d\d+ of \d+ matches, noise 0\.\d+ px\n")
        wrong = re.search(r"rotation wrong by ([\d.]+), direction by ([\d.]+) degrees", text).groups()
        self.assertLess(max(map(float, wrong)), 1, text)
        self.assertLess(float(re.search(r"to their curves: ([\d.]+) px", text).group(1)), 0.5, text)
        self.assertGreater(picture.stat().st_size, 100000)


if __name__ == "__main__":
    unittest.main()
