#!/usr/bin/env python3
"""Configures the package with packages hidden from CMake and checks its requirements and messages."""

import json
import pathlib
import re
import shutil
import tempfile
import unittest

import installed

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def without(*names):
    """Arguments that hide packages from find_package()."""
    return [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in names]


class CMakeOptions(unittest.TestCase):
    """Each part of the package demands only what it needs."""

    def setUp(self):
        self.build = tempfile.mkdtemp(prefix="corrsel_options_")
        self.addCleanup(shutil.rmtree, self.build)

    def configure(self, *arguments):
        """Configures the package. Returns the exit code and the output on one line."""
        code, text = installed.run(["cmake", "-S", SOURCE, "-B", self.build, *arguments])
        return code, " ".join(text.split())

    def test_core_needs_opencv_core_and_eigen_only(self):
        """Without features and benchmark, nothing else is looked for."""
        hidden = without("yaml-cpp", "nlohmann_json", "PkgConfig", "catkin")
        code, text = self.configure("-Dcorrsel_FEATURES=OFF", *hidden)
        self.assertEqual(code, 0, text)
        self.assertIn("building core, reference --", text)
        self.assertNotIn("catkin", text.replace("CMAKE_DISABLE_FIND_PACKAGE_catkin", ""))
        code, text = self.configure("-Dcorrsel_FEATURES=OFF", *without("Eigen3"))
        self.assertNotEqual(code, 0, text)
        self.assertIn("Eigen 3, needed by corrsel::core (Debian package libeigen3-dev)", text)

    def test_everything_that_is_missing_is_named_at_once(self):
        """With the Debian package and the option that leaves the part out."""
        code, text = self.configure("-Dcorrsel_ROS=OFF", *without("yaml-cpp", "nlohmann_json"))
        self.assertNotEqual(code, 0, text)
        self.assertIn("nlohmann-json, needed by corrsel::benchmark", text)
        self.assertIn("-Dcorrsel_BENCHMARK=OFF builds without it (Debian package libyaml-cpp-dev)", text)
        self.assertIn("apt-get install nlohmann-json3-dev libyaml-cpp-dev", text)

    def test_ros_is_left_out_where_catkin_is_missing_unless_asked_for(self):
        """AUTO, ON, OFF and typing errors."""
        code, text = self.configure(*without("catkin"))
        self.assertEqual(code, 0, text)
        self.assertIn("building core, reference, features, benchmark, database --", text)
        code, text = self.configure("-Dcorrsel_ROS=ON", *without("catkin"))
        self.assertNotEqual(code, 0, text)
        self.assertIn("-Dcorrsel_ROS=OFF builds without ROS (Debian package catkin)", text)
        code, text = self.configure("-Dcorrsel_ROS=maybe")
        self.assertNotEqual(code, 0, text)
        self.assertIn("corrsel_ROS is 'maybe'; valid values: AUTO, ON, OFF", text)
        code, text = self.configure("-Dcorrsel_ROS=ON", "-Dcorrsel_BENCHMARK=OFF")
        self.assertNotEqual(code, 0, text)
        self.assertIn("corrsel_ROS=ON needs corrsel::benchmark", text)

    def test_loops_are_vectorised_whatever_the_flags_of_the_build(self):
        """-O3 replaces -O2, which Debian's packages and RelWithDebInfo use, but no other level."""
        for build_type, flags, level in (
            ("None", "-g -O2", "-O3"),
            ("RelWithDebInfo", "", "-O3"),
            ("Release", "", "-O3"),
            ("Debug", "", None),
            ("None", "-g -O2 -O0", "-O0"),
        ):
            code, text = self.configure(
                "-Dcorrsel_FEATURES=OFF",
                "-Dcorrsel_PYTHON=OFF",
                f"-DCMAKE_BUILD_TYPE={build_type}",
                f"-DCMAKE_CXX_FLAGS={flags}",
                "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
            )
            self.assertEqual(code, 0, text)
            commands = json.loads(pathlib.Path(self.build, "compile_commands.json").read_text())
            commands = [entry["command"] for entry in commands if "/level_baseline.cpp" in entry["file"]]
            self.assertEqual(len(commands), 1)
            levels = re.findall(r"-O\d", commands[0])
            self.assertEqual(levels[-1] if levels else None, level, commands)


if __name__ == "__main__":
    unittest.main()
