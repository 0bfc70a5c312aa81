#!/usr/bin/env python3
"""The package as a whole: what importing it loads, and what it does where modules in C++ are missing."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import corrsel

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(program, **environment):
    """Return what a Python program prints, its output and its errors."""
    return subprocess.run(
        [sys.executable, "-u", "-c", program],  # unbuffered: what is printed stays before the traceback
        env=dict(os.environ, **environment),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        universal_newlines=True,
        check=False,
    ).stdout.strip()


class Package(unittest.TestCase):
    """Importing corrsel."""

    def test_no_ros_is_imported(self):
        program = (
            "import corrsel, sys; [getattr(corrsel, name) for name in corrsel.__all__]; "
            "print(sorted({name.split('.')[0] for name in sys.modules} & {'rospy', 'genpy', 'rosgraph', 'roslib'}))"
        )
        self.assertEqual(run(program), "[]")

    def test_import_alone_loads_nothing_in_cpp(self):
        self.assertEqual(run("import corrsel, sys; print('corrsel._core' in sys.modules)"), "False")

    def test_every_name_is_there_and_documented(self):
        self.assertIn("select", corrsel.__all__)
        for name in corrsel.__all__:
            self.assertIn(name, dir(corrsel))
            self.assertIn(name, corrsel.__doc__)
            self.assertTrue(getattr(corrsel, name).__doc__, name)
        with self.assertRaisesRegex(AttributeError, "has no attribute 'selekt'"):
            corrsel.selekt  # pylint: disable=pointless-statement

    def test_the_version_is_that_of_the_package(self):
        self.assertIn(
            "<version>%s</version>" % corrsel.__version__, (ROOT / "package.xml").read_text("utf-8")
        )

    def test_docstrings_may_be_missing(self):
        for level in ("1", "2"):
            program = "import corrsel; [getattr(corrsel, name) for name in corrsel.__all__]; print(corrsel.select.__name__)"
            self.assertEqual(run(program, PYTHONOPTIMIZE=level), "select")

    def test_without_the_modules_in_cpp(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(ROOT / "python" / "corrsel", pathlib.Path(folder) / "corrsel")
            program = (
                "import sys; sys.path.insert(0, %r); import corrsel, corrsel.matches; print(corrsel.__all__); "
                "corrsel.select" % folder
            )
            output = run(program)
        lines = output.splitlines()
        self.assertEqual(lines[0], "[]", output)
        self.assertIn("ImportError: corrsel.select needs the module corrsel._core", lines[-1])


if __name__ == "__main__":
    unittest.main()
