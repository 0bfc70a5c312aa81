#!/usr/bin/env python3
"""The programs in examples/, built against the package as installed into a temporary folder, and run."""

import os
import pathlib
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

    def test_camera_pipeline(self):
        left, right = self.frames()
        try:
            import cv2  # pylint: disable=import-outside-toplevel,unused-import
        except ImportError as error:
            self.skipTest("%s; python3-opencv is needed" % error)
        packages = [path.parent.parent for path in self.prefix.glob("lib/**/corrsel/_core.*.so")]
        paths = [str(path) for path in packages] + [os.environ.get("PYTHONPATH", "")]
        program = [sys.executable, EXAMPLES / "03_camera_pipeline.py", left, right, right]
        code, text = installed.run(program, PYTHONPATH=os.pathsep.join(paths))
        self.assertEqual(code, 0, text)
        first, second = text.splitlines()
        self.assertRegex(first, r"^frame 1: \d+ of \d+, ok, plane_or_rotation: decompose the homography")
        self.assertRegex(second, r"^frame 2: (\d+) of \1, ok, at_rest: standing still")


if __name__ == "__main__":
    unittest.main()
