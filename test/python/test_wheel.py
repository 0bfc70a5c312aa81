#!/usr/bin/env python3
"""pip with the backend of the package: the wheel, its installation into a new environment, and the source archive.

The build under test has compiled everything already. So the backend runs with a stand-in for CMake, which installs what that
build has; scripts/maintenance/test_pip.sh compiles by pip, on several releases of Debian.
"""

import base64
import hashlib
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
import unittest.mock
import zipfile

import installed

ROOT = pathlib.Path(__file__).resolve().parents[2]
LARGEST_WHEEL = 5 << 20

#: Installs STAGE, and notes its arguments.
CMAKE = """#!{python}
import shutil, sys
print("{says}")
with open("{notes}", "a") as notes:
    notes.write(" ".join(sys.argv[1:]) + chr(10))
if sys.argv[1] == "--install":
    shutil.copytree("{stage}", sys.argv[sys.argv.index("--prefix") + 1], symlinks=True)
"""
FOUND = "-- Python package: for Python 3, pybind11 2.%d.1"
SELECTION = """
import corrsel, numpy
left = numpy.random.RandomState(0).uniform(0, 600, (500, 2))
selection = corrsel.select(left, left + (8, -5), "usac", left_size=(640, 640), right_size=(640, 640))
print(corrsel.__file__, corrsel.__version__, selection.status, selection.n_selected)
"""


def backend_of(root):
    """Return the backend in a tree of sources, as a module."""
    path = root / "python" / "backend" / "corrsel_backend.py"
    spec = importlib.util.spec_from_file_location("corrsel_backend", str(path))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def stage(folder, installation):
    """Make in a folder what the installation of a wheel's build would be, of what another build has installed."""
    package = folder / "python" / "corrsel"
    shutil.copytree(ROOT / "python" / "corrsel", package, ignore=shutil.ignore_patterns("__pycache__"))
    (package / "lib" / "cmake").mkdir(parents=True)
    (package / "lib" / "cmake" / "corrselConfig.cmake").write_text("")
    (folder / "include").mkdir()
    (folder / "include" / "corrsel.h").write_text("")
    modules = list(installation.rglob("corrsel/_*.so"))
    libraries = set()
    while modules:
        module = modules.pop()
        is_library = module.name.startswith("lib")
        shutil.copy(module, package / ("lib" if is_library else ""), follow_symlinks=True)
        for name in set(re.findall(rb"libcorrsel_\w+\.so\.[\d.]*\d", module.read_bytes())) - libraries:
            libraries.add(name)
            modules.append(next(installation.rglob(name.decode())))
    for library in (package / "lib").glob("*.so.*"):  # as CMake installs them
        version = library.rename(library.with_name(library.name + ".0"))
        library.symlink_to(version.name)
        library.with_name(library.name.split(".so")[0] + ".so").symlink_to(library.name)
    binaries = [path for path in folder.rglob("*.so*") if not path.is_symlink()]
    subprocess.run(["strip", "--strip-unneeded", *map(str, binaries)], check=True)


class Wheel(unittest.TestCase):
    """`pip install .`"""

    @classmethod
    def setUpClass(cls):
        if importlib.util.find_spec("ensurepip") is None:
            raise unittest.SkipTest("ensurepip is missing: install python3-venv")
        folder = tempfile.TemporaryDirectory(prefix="corrsel_wheel_test_")
        cls.addClassCleanup(folder.cleanup)
        cls.work = pathlib.Path(folder.name)
        cls.notes = cls.work / "notes.txt"
        stage(cls.work / "stage", installed.install(cls.work / "destination"))
        cls.path = cls.cmake("found", FOUND % 12)
        cls.python = cls.work / "venv" / "bin" / "python"
        code, text = installed.run(
            [sys.executable, "-m", "venv", "--system-site-packages", cls.work / "venv"]
        )
        if code != 0:
            raise AssertionError(text)
        code, text = cls.pip("install", ROOT)
        if code != 0:
            raise AssertionError(text)

    @classmethod
    def cmake(cls, name, says):
        """Make a stand-in for CMake that prints a line. Return a PATH in which it comes first."""
        folder = cls.work / name
        folder.mkdir()
        program = folder / "cmake"
        program.write_text(
            CMAKE.format(python=sys.executable, says=says, notes=cls.notes, stage=cls.work / "stage")
        )
        program.chmod(0o755)
        return "%s:%s" % (folder, os.environ["PATH"])

    @classmethod
    def pip(cls, command, *arguments, path=None):
        """Run pip of the environment without a network, and without a system's rules. Return exit code and output."""
        return installed.run(
            [cls.python, "-m", "pip", command, "--no-build-isolation", "--no-index", "--no-cache-dir"]
            + list(arguments),
            PATH=path or cls.path,
            PIP_CONFIG_FILE=os.devnull,
        )

    def run_installed(self, program):
        """Run a program with the installed package, in no folder that Python searches. Return exit code and output."""
        return installed.run([self.python, "-I", "-c", program])

    def build(self, name, hook="build_wheel", root=ROOT, path=None):
        """Call the backend of a tree of sources, without pip. Return the path of what it writes."""
        folder = self.work / name
        folder.mkdir()
        program = "import sys; sys.path.insert(0, sys.argv[1]); import corrsel_backend; corrsel_backend.%s(sys.argv[2])"
        code, text = installed.run(
            [sys.executable, "-B", "-c", program % hook, root / "python" / "backend", folder],
            PATH=path or self.path,
        )
        self.assertEqual(code, 0, text)
        (written,) = folder.iterdir()
        return written

    def unpacked(self, name):
        """Unpack the source archive. Return the folder with the sources."""
        with tarfile.open(self.build(name, "build_sdist")) as archive:
            archive.extractall(self.work / name)
            (top,) = {member.name.split("/")[0] for member in archive}
        return self.work / name / top

    def test_is_installed_and_used(self):
        code, text = self.run_installed(SELECTION)
        self.assertEqual(code, 0, text)
        file, version, status, selected = text.split()
        self.assertTrue(file.startswith(str(self.work / "venv" / "lib")), file)
        self.assertIn("<version>%s</version>" % version, (ROOT / "package.xml").read_text("utf-8"))
        self.assertEqual((status, selected), ("ok", "500"))

    def test_cmake_compiles_the_package_alone(self):
        configured, built, *_ = self.notes.read_text().splitlines()
        for option in ("ROS=OFF", "BENCHMARK=OFF", "PYTHON_DESTINATION=python"):
            self.assertIn("-Dcorrsel_" + option, configured)
        self.assertIn("-DPython3_EXECUTABLE=%s" % self.python, configured)
        self.assertRegex(built, r"--build \S+ --parallel \d+$")

    def test_holds_package_and_libraries(self):
        wheel = self.build("holds")
        self.assertRegex(wheel.name, r"^corrsel-[\d.]+-(cp3\d+)-\1-linux_\w+\.whl$")
        self.assertLess(wheel.stat().st_size, LARGEST_WHEEL)
        with zipfile.ZipFile(wheel) as archive:
            names = archive.namelist()
        sources = {path.relative_to(ROOT / "python") for path in (ROOT / "python" / "corrsel").rglob("*")}
        for source in sources:
            if (ROOT / "python" / source).is_file() and "__pycache__" not in source.parts:
                self.assertIn(source.as_posix(), names)
        self.assertRegex(" ".join(names), r"corrsel/_core\.cpython\S+\.so ")
        self.assertRegex(" ".join(names), r"corrsel/lib/libcorrsel_core\.so\.\d+(\.\d+)? ")
        self.assertFalse([name for name in names if re.search(r"\.so(\.\d+)?\.0$|\.h$|cmake|pyc$", name)])
        libraries = [name for name in names if "/libcorrsel_core" in name]
        self.assertEqual(len(libraries), 1, libraries)

    @staticmethod
    def metadata(wheel):
        """Return the metadata of a wheel."""
        with zipfile.ZipFile(wheel) as archive:
            (name,) = [name for name in archive.namelist() if name.endswith("/METADATA")]
            return archive.read(name).decode()

    def test_names_what_it_needs(self):
        text = self.metadata(self.build("names"))
        libraries = set(re.findall(r"^Requires-External: (.*)$", text, re.M))
        self.assertRegex(
            " ".join(sorted(libraries)), r"\blibopencv_core\.so\.[\d.]+ .*\blibstdc\+\+\.so\.6\b"
        )
        self.assertFalse([name for name in libraries if "corrsel" in name])
        self.assertIn("\nRequires-Dist: numpy\n", text)
        self.assertIn('\nRequires-Dist: jinja2; extra == "report"\n', text)

    def test_older_versions_of_pybind11_do_not_know_numpy_2(self):
        wheel = self.build("numpy_1", path=self.cmake("found_older", FOUND % 11))
        self.assertIn("\nRequires-Dist: numpy<2\n", self.metadata(wheel))

    def test_lists_its_files(self):
        with zipfile.ZipFile(self.build("lists")) as archive:
            (record,) = [name for name in archive.namelist() if name.endswith("/RECORD")]
            rows = [row.split(",") for row in archive.read(record).decode().splitlines()]
            self.assertEqual({row[0] for row in rows}, set(archive.namelist()))
            for name, digest, size in rows:
                if name != record:
                    data = archive.read(name)
                    expected = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip("=")
                    self.assertEqual((digest, size), ("sha256=" + expected, str(len(data))))

    def test_is_the_same_each_time(self):
        self.assertEqual(self.build("first").read_bytes(), self.build("second").read_bytes())

    def test_keeps_a_build_of_the_same_sources(self):
        kept = self.work / "kept"
        kept.mkdir()
        for sources, used in ((ROOT, True), ("/nonexistent", False)):
            (kept / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=%s\n" % sources)
            with unittest.mock.patch.dict(os.environ, CORRSEL_PIP_BUILD_DIR=str(kept)):
                self.build("kept_%s" % used)
            install = self.notes.read_text().splitlines()[-1]
            self.assertEqual(install.startswith("--install %s --prefix" % kept), used, install)

    def test_says_why_there_is_no_package(self):
        says = "-- Python package: not built, since pybind11 is missing (pybind11-dev)"
        code, text = self.pip("wheel", "--wheel-dir", self.work, ROOT, path=self.cmake("missing", says))
        self.assertNotEqual(code, 0)
        self.assertRegex(
            text, r"pybind11 is missing \(pybind11-dev\)\. On Debian: apt-get install .*pybind11-dev"
        )

    def test_documentation_lists_what_the_backend_needs(self):
        text = (ROOT / "docs" / "python.md").read_text("utf-8")
        (line,) = re.findall(r"^apt-get install (.*)$", text, re.MULTILINE)
        self.assertEqual(set(backend_of(ROOT).PACKAGES.split()) - set(line.split()), set())

    def test_says_that_options_left_the_package_out(self):
        path = self.cmake("left_out", "-- corrsel VERSION: building core")
        code, text = self.pip("wheel", "--wheel-dir", self.work, ROOT, path=path)
        self.assertNotEqual(code, 0)
        self.assertIn("CMake builds no Python package: look at CMAKE_ARGS", text)

    def test_says_that_cmake_is_missing(self):
        code, text = self.pip("wheel", "--wheel-dir", self.work, ROOT, path=str(self.work / "stage"))
        self.assertNotEqual(code, 0)
        self.assertIn("CMake is missing. On Debian: apt-get install cmake", text)

    def with_a_missing_library(self, folder, library):
        """Return what the package prints where the version of a library of the system does not exist, and that version."""
        other = self.work / folder
        (installation,) = (self.work / "venv" / "lib").glob("python3*/site-packages/corrsel")
        shutil.copytree(installation, other / "corrsel")
        (core,) = (other / "corrsel" / "lib").glob("libcorrsel_core.so.*")
        name = re.compile(rb"(?<=%s\.so\.)[\d.]*\d" % library)
        needed = name.search(core.read_bytes()).group()
        for file in other.rglob("*.so*"):
            file.write_bytes(name.sub(lambda match: re.sub(rb"\d", b"9", match.group()), file.read_bytes()))
        code, text = self.run_installed(
            'import sys; sys.path.insert(0, "%s"); %s' % (other, SELECTION.strip())
        )
        self.assertNotEqual(code, 0)
        return text, re.sub(r"\d", "9", needed.decode())

    def test_names_the_package_of_a_missing_library(self):
        text, version = self.with_a_missing_library("without_opencv", b"libopencv_core")
        self.assertIn("Install Debian's package libopencv-core%s; where the release" % version, text)
        text, version = self.with_a_missing_library("without_other", rb"libstdc\+\+")
        self.assertIn("(libstdc++.so.%s: cannot open" % version, text)
        self.assertIn("This library is one of the system. Install the package that has it", text)

    def test_archive_holds_the_sources(self):
        sources = self.unpacked("archive")
        self.assertRegex(sources.name, r"^corrsel-[\d.]+$")
        names = {path.relative_to(sources).as_posix() for path in sources.rglob("*") if path.is_file()}
        for name in ("LICENSE", "PKG-INFO", "package.xml", "pyproject.toml", "python/corrsel/py.typed"):
            self.assertIn(name, names)
        for folder in ("cmake", "examples", "include", "python", "src"):
            for path in (ROOT / folder).rglob("*"):
                if path.is_file() and path.suffix not in (".pyc", ".swp"):
                    self.assertIn(path.relative_to(ROOT).as_posix(), names)
        self.assertFalse([name for name in names if name.startswith(".git/") or name.endswith(".pyc")])

    def test_archive_makes_the_same_wheel_and_the_same_archive(self):
        sources = self.unpacked("again")
        self.assertEqual(
            self.build("wheel_of_archive", root=sources).read_bytes(), self.build("wheel").read_bytes()
        )
        with tarfile.open(self.build("archive_of_archive", "build_sdist", sources)) as archive:
            names = {member.name for member in archive}
        expected = {
            path.relative_to(sources.parent).as_posix() for path in sources.rglob("*") if path.is_file()
        }
        self.assertEqual(names, {name for name in expected if not name.endswith(".pyc")})

    def test_archive_is_complete_for_cmake(self):
        toolchain = installed.BUILD / "consumer_toolchain.cmake"
        options = ["-Dcorrsel_ROS=OFF", "-Dcorrsel_BENCHMARK=OFF", "-DCMAKE_TOOLCHAIN_FILE=%s" % toolchain]
        sources = self.unpacked("complete")
        code, text = installed.run(["cmake", "-S", sources, "-B", self.work / "configured", *options])
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"corrsel [\d.]+: building core, reference, features")


if __name__ == "__main__":
    unittest.main()
