#!/usr/bin/env python3
"""Builds and runs CMake projects against the installed package and against the build folder."""

import pathlib
import re
import shutil
import tempfile
import unittest

import installed

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
SOURCE = PACKAGE / "test" / "consumer"
VERSION = re.search(r"<version>([\d.]+)</version>", (PACKAGE / "package.xml").read_text()).group(1)


class Consumer(unittest.TestCase):
    """find_package(corrsel) in projects that are not catkin packages."""

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_consumer_"))
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.prefix = installed.install(cls.root / "destination")

    def configure(self, name, commands):
        """Configures a project that consists of `commands`. Returns exit code and output."""
        source = self.root / name
        source.mkdir()
        lines = ["cmake_minimum_required(VERSION 3.16)", f"project({name} CXX)", *commands]
        (source / "CMakeLists.txt").write_text("\n".join(lines) + "\n")
        return installed.configure_project(source, source / "build", self.prefix)

    def check_program(self, prefix, build):
        """Builds test/consumer with the corrsel below `prefix` and runs it."""
        code, text = installed.build_project(SOURCE, build, prefix)
        self.assertEqual(code, 0, text)
        code, text = installed.run([build / "consumer"])
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"^8\d of 100 matches selected")

    def test_uses_the_installed_package(self):
        """corrsel::core, after the installation has been moved elsewhere."""
        moved = self.root / "moved"
        shutil.copytree(self.prefix, moved, symlinks=True)
        self.check_program(moved, self.root / "build_installed")

    def test_every_public_header_is_installed(self):
        """Those of ROS only where it is there. A build of some libraries installs the headers of these alone."""
        built = {path.name for path in self.prefix.rglob("libcorrsel_*.so")}
        if not {"libcorrsel_%s.so" % name for name in ("benchmark", "database", "features")} <= built:
            self.skipTest("only some of the libraries are built")
        public = {path.relative_to(PACKAGE / "include") for path in (PACKAGE / "include").rglob("*.h")}
        include = self.prefix / "include"
        found = {path.relative_to(include) for path in include.rglob("*.h")}
        ros = {path for path in public if path.parts[1] == "ros"}
        self.assertEqual(sorted(public - found - (set() if installed.DEVEL else ros)), [])

    def test_libraries_have_a_version(self):
        """A program records the name with the version of the interface; other versions can be installed beside it."""
        interface = re.match(r"(0\.)?\d+", VERSION).group(0)
        libraries = sorted(self.prefix.rglob("libcorrsel_*.so"))
        self.assertIn("libcorrsel_core.so", [library.name for library in libraries])
        for library in libraries:
            self.assertTrue(library.is_symlink(), library)
            self.assertEqual(library.resolve().name, f"{library.name}.{VERSION}")
            code, text = installed.run(["objdump", "-p", library])
            self.assertEqual(code, 0, text)
            self.assertEqual(re.findall(r"SONAME +(\S+)", text), [f"{library.name}.{interface}"])
            self.assertTrue((library.parent / f"{library.name}.{interface}").exists())

    def test_uses_the_build_folder(self):
        """corrsel::core of a build that has not been installed."""
        self.check_program(installed.DEVEL or installed.BUILD, self.root / "build_uninstalled")

    def test_loads_only_what_a_component_needs(self):
        """With the component core, the other targets are neither loaded nor looked for."""
        code, text = self.configure(
            "core_alone",
            [
                "find_package(corrsel REQUIRED COMPONENTS core)",
                "if(NOT TARGET corrsel::core OR TARGET corrsel::reference OR TARGET corrsel::features OR TARGET corrsel::benchmark)",
                '  message(FATAL_ERROR "wrong targets")',
                "endif()",
            ],
        )
        self.assertEqual(code, 0, text)

    def test_every_installed_library_is_a_target(self):
        """Without components, all targets are loaded; a component loads what it depends on."""
        libraries = {path.name for path in self.prefix.rglob("corrsel-*.cmake")}
        names = [
            name
            for name in ("core", "reference", "features", "benchmark")
            if f"corrsel-{name}.cmake" in libraries
        ]
        self.assertIn("core", names)
        for asked in ("", f"COMPONENTS {names[-1]}"):
            code, text = self.configure(
                f"all_{len(asked)}",
                [
                    f"find_package(corrsel REQUIRED {asked})",
                    f"foreach(name {' '.join(names)})",
                    "  if(NOT TARGET corrsel::${name})",
                    '    message(FATAL_ERROR "corrsel::${name} is missing")',
                    "  endif()",
                    "endforeach()",
                ],
            )
            self.assertEqual(code, 0, text)

    def test_unknown_component_is_an_error_that_lists_the_valid_ones(self):
        """The message names the component and those that are installed."""
        code, text = self.configure("unknown", ["find_package(corrsel REQUIRED COMPONENTS core engine)"])
        self.assertNotEqual(code, 0, text)
        text = " ".join(text.split())
        self.assertIn("has no library 'engine'", text)
        self.assertRegex(text, "it has: core")

    def test_accepts_its_own_version(self):
        """A project that asks for X.Y finds X.Y.Z."""
        version = VERSION.rpartition(".")[0]
        code, text = self.configure("own_version", [f"find_package(corrsel {version} REQUIRED)"])
        self.assertEqual(code, 0, text)

    def test_other_versions_are_refused(self):
        """A newer version than the installed one is not found."""
        code, text = self.configure("version", ["find_package(corrsel 99.0 REQUIRED)"])
        self.assertNotEqual(code, 0, text)
        self.assertIn("99.0", text)

    def test_installed_headers_include_installed_headers_only(self):
        """A source file that includes all headers of the libraries compiles."""
        include = self.prefix / "include"
        headers = sorted(
            header.relative_to(include).as_posix()
            for header in (include / "corrsel").rglob("*.h")
            # Headers of the ROS side need ROS; those of messages and configurations are generated.
            if header.parent.name != "ros" and header.name[0].islower()
        )
        self.assertIn("corrsel/selectors/factory.h", headers)
        source = self.root / "headers"
        source.mkdir()
        (source / "headers.cpp").write_text("".join(f"#include <{header}>\n" for header in headers))
        (source / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.16)\n"
            "project(headers CXX)\n"
            "find_package(corrsel REQUIRED)\n"
            "add_library(headers OBJECT headers.cpp)\n"
            "target_link_libraries(headers corrsel::core)\n"
        )
        code, text = installed.build_project(source, source / "build", self.prefix)
        self.assertEqual(code, 0, text)


if __name__ == "__main__":
    unittest.main()
