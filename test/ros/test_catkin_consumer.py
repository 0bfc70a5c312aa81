#!/usr/bin/env python3
"""Builds and runs a catkin package that uses corrsel through find_package(catkin COMPONENTS corrsel)."""

import pathlib
import shutil
import tempfile
import unittest

import installed
from ros_shell import RosShell

PROGRAM = pathlib.Path(__file__).resolve().parents[1] / "consumer" / "consumer.cpp"
PROJECT = f"""cmake_minimum_required(VERSION 3.16)
project(catkin_consumer CXX)
find_package(catkin REQUIRED COMPONENTS corrsel)
catkin_package(CATKIN_DEPENDS corrsel)
if(NOT TARGET corrsel::core OR NOT TARGET corrsel::features OR NOT TARGET corrsel::benchmark)
  message(FATAL_ERROR "a target of corrsel is missing")
endif()
set(CMAKE_CXX_STANDARD 17)
include_directories(${{catkin_INCLUDE_DIRS}})
add_executable(by_variable {PROGRAM})
target_link_libraries(by_variable ${{catkin_LIBRARIES}})
add_executable(by_package_variable {PROGRAM})
target_link_libraries(by_package_variable ${{corrsel_LIBRARIES}})
add_executable(by_target {PROGRAM})
target_link_libraries(by_target corrsel::core)
"""
MANIFEST = """<package format="2">
  <name>catkin_consumer</name>
  <version>0.0.0</version>
  <description>Uses corrsel.</description>
  <maintainer email="maintainers@corrsel.example">corrsel maintainers</maintainer>
  <license>BSD-3-Clause</license>
  <buildtool_depend>catkin</buildtool_depend>
  <depend>corrsel</depend>
</package>
"""


class CatkinConsumer(unittest.TestCase):
    """The variables that catkin defines and the exported targets are equally good."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_catkin_consumer_"))
        self.addCleanup(shutil.rmtree, self.root)
        (self.root / "source").mkdir()
        (self.root / "source" / "CMakeLists.txt").write_text(PROJECT)
        (self.root / "source" / "package.xml").write_text(MANIFEST)

    def check(self, workspace):
        """Builds the package in the environment of `workspace` and runs its programs."""
        shell = RosShell(pathlib.Path(workspace) / "setup.bash", self.root)
        build = self.root / "build"
        code, text = shell.output_of(
            f"cmake -S {self.root}/source -B {build} -DCATKIN_DEVEL_PREFIX={build}/devel && cmake --build {build}"
        )
        self.assertEqual(code, 0, text)
        for name in ("by_variable", "by_package_variable", "by_target"):
            code, text = shell.output_of(f"$(find {build}/devel -name {name} -type f)")
            self.assertEqual(code, 0, f"{name}: {text}")
            self.assertIn("of 100 matches selected", text)

    def test_devel_space(self):
        """The package as it lies in the build folder."""
        self.check(installed.DEVEL)

    def test_install_space(self):
        """The installed package."""
        self.check(installed.install(self.root / "destination"))


if __name__ == "__main__":
    unittest.main()
