"""What pip calls to build corrsel (PEP 517): build_wheel and build_sdist, with Python's standard library alone.

Debian 11 and 12 have no backend for CMake projects, and pip has to work without a network. CMake compiles, and everything
that `cmake --install` puts into the folder for Python packages becomes part of the wheel. The libraries of corrsel lie in corrsel/lib,
where the modules find them by a relative path. OpenCV's libraries are those of the system, so the wheel has the tag of Linux
and none of manylinux.

CMAKE_ARGS holds further arguments for CMake, and CMAKE_BUILD_PARALLEL_LEVEL the number of compilers. CORRSEL_PIP_BUILD_DIR
names a folder that keeps what is compiled, so that the next call compiles only what has changed. It is of no use to pip
before 21.3, which copies the sources into a new folder each time.
"""

import base64
import hashlib
import io
import os
import pathlib
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile
from xml.etree import ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = (
    "cmake g++ libeigen3-dev libhdf5-dev libopencv-dev libsqlite3-dev make nlohmann-json3-dev pkg-config"
    " pybind11-dev python3-dev"
)
#: What a part of the package needs besides numpy, by the name of the extra.
EXTRAS = {"hloc": ("h5py",), "images": ("opencv-python",), "report": ("jinja2", "matplotlib", "pyyaml")}
#: A compiler takes at most this much memory, bytes.
MEMORY_OF_COMPILER = 800 << 20


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Compile, and write the wheel into a folder. Return its file name."""
    del config_settings, metadata_directory  # part of the interface of pip
    with tempfile.TemporaryDirectory(prefix="corrsel_wheel_") as folder:
        prefix = os.path.join(folder, "prefix")
        build = _kept_build() or os.path.join(folder, "build")
        configured = _cmake("-S", str(ROOT), "-B", build, *_cmake_options())
        pybind11 = re.search(r"Python package: for .*pybind11 (\d+)\.(\d+)", configured)
        if not pybind11:
            raise RuntimeError(_without_package(configured))
        _cmake("--build", build, *_parallel())
        _cmake("--install", build, "--prefix", prefix, "--strip")
        return pack(pathlib.Path(prefix, "python"), wheel_directory, tuple(map(int, pybind11.groups())))


def build_sdist(sdist_directory, config_settings=None):
    """Write the source archive, from which build_wheel() can build, into a folder. Return its file name."""
    del config_settings  # part of the interface of pip
    name = "corrsel-" + _package_xml("version")
    metadata = _metadata(["numpy"], []).encode()
    with tarfile.open(
        os.path.join(sdist_directory, name + ".tar.gz"), "w:gz", format=tarfile.PAX_FORMAT
    ) as archive:
        for file in _sources():
            archive.add(str(ROOT / file), "%s/%s" % (name, file), recursive=False)
        entry = tarfile.TarInfo(name + "/PKG-INFO")
        entry.size = len(metadata)
        archive.addfile(entry, io.BytesIO(metadata))
    return name + ".tar.gz"


def pack(folder, wheel_directory, pybind11):
    """Write the wheel of an installation. Return its file name.

    folder     Python's folder of packages, which holds corrsel with its libraries in corrsel/lib
    pybind11   its version as a tuple
    """
    python = "cp%d%d" % sys.version_info[:2]
    tag = "-".join((python, python + sys.abiflags, re.sub(r"\W", "_", sysconfig.get_platform())))
    name = "corrsel-" + _package_xml("version")
    contents = {file: path.read_bytes() for file, path in _installed(folder)}
    # Earlier versions of pybind11 read arrays of numpy 2 wrongly.
    numpy = "numpy" if pybind11 >= (2, 12) else "numpy<2"
    info = name + ".dist-info/"
    contents[info + "METADATA"] = _metadata([numpy], _needed(contents)).encode()
    contents[info + "WHEEL"] = (
        "Wheel-Version: 1.0\nGenerator: corrsel_backend\nRoot-Is-Purelib: false\nTag: %s\n" % tag
    ).encode()
    contents[info + "LICENSE"] = (ROOT / "LICENSE").read_bytes()
    rows = ["%s,sha256=%s,%d\n" % (file, _digest(data), len(data)) for file, data in contents.items()]
    contents[info + "RECORD"] = "".join(rows + [info + "RECORD,,\n"]).encode()
    wheel = "%s-%s.whl" % (name, tag)
    with zipfile.ZipFile(os.path.join(wheel_directory, wheel), "w", zipfile.ZIP_DEFLATED) as archive:
        for file, data in contents.items():
            entry = zipfile.ZipInfo(file)  # of 1980, so that equal files make equal wheels
            entry.external_attr = (0o100755 if ".so" in file else 0o100644) << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return wheel


def _kept_build():
    """Return the folder of CORRSEL_PIP_BUILD_DIR; None where there is none, or where it belongs to sources elsewhere."""
    folder = os.environ.get("CORRSEL_PIP_BUILD_DIR")
    cache = pathlib.Path(folder or "", "CMakeCache.txt")
    if folder and cache.exists() and "CMAKE_HOME_DIRECTORY:INTERNAL=%s\n" % ROOT not in cache.read_text():
        print("%s is of other sources and is left alone" % folder)
        return None
    return folder


def _cmake(*arguments):
    """Run CMake, show what it prints, and return that."""
    lines = []
    try:
        process = subprocess.Popen(
            ("cmake",) + arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True
        )
    except FileNotFoundError as error:
        raise RuntimeError("CMake is missing. On Debian: apt-get install " + PACKAGES) from error
    with process:
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line)
    if process.returncode:
        raise RuntimeError(
            "cmake %s failed: the reason is above, before this traceback" % shlex.quote(arguments[0])
        )
    return "".join(lines)


def _without_package(configured):
    """Return why CMake would build no Python package."""
    reason = re.search(r"Python package: not built.*", configured)
    if not reason:
        return "CMake builds no Python package: look at CMAKE_ARGS, '%s'" % os.environ.get("CMAKE_ARGS", "")
    return "%s. On Debian: apt-get install %s" % (reason.group(), PACKAGES)


def _cmake_options():
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_INSTALL_LIBDIR": "python/corrsel/lib",
        "Python3_EXECUTABLE": sys.executable,
        "corrsel_BENCHMARK": "OFF",
        "corrsel_PYTHON_DESTINATION": "python",
        "corrsel_ROS": "OFF",
    }
    given = shlex.split(os.environ.get("CMAKE_ARGS", ""))
    return ["-D%s=%s" % option for option in options.items()] + given


def _parallel():
    """Return the arguments for a compiler on every core, but for no more than fit into the memory that is free."""
    if "CMAKE_BUILD_PARALLEL_LEVEL" in os.environ:
        return []
    free = re.search(r"MemAvailable: +(\d+)", pathlib.Path("/proc/meminfo").read_text())
    fitting = int(free.group(1)) * 1024 // MEMORY_OF_COMPILER
    return ["--parallel", str(max(1, min(len(os.sched_getaffinity(0)), fitting)))]


def _installed(folder):
    """Yield name in the wheel and path of every file; libraries under the name that programs look for.

    A library is installed as libname.so -> libname.so.X.Y -> libname.so.X.Y.Z, and a wheel has no links.
    """
    links = [path for path in folder.rglob("*.so.*") if path.is_symlink()]
    names = {link.resolve(): link for link in links}
    for path in sorted(folder.rglob("*")):
        name = names.get(path.resolve(), path).relative_to(folder).as_posix()
        if path.is_file() and not path.is_symlink() and not name.startswith("corrsel/lib/cmake/"):
            yield name, path


def _needed(contents):
    """Return the names of the shared libraries that files need and that are none of them."""
    found = set()
    for file, data in contents.items():
        if ".so" in file:
            found |= {name.decode() for name in re.findall(rb"(?<=\0)lib[\w+.-]+\.so[.\d]*(?=\0)", data)}
    return sorted(found - {file.rpartition("/")[2] for file in contents})


def _sources():
    """Return the names of the files that the source archive holds: those of git, or all of an unpacked archive."""
    if (ROOT / ".git").exists():
        command = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        listed = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode().split("\0")
    else:
        listed = [path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*") if path.suffix != ".pyc"]
    return sorted(file for file in listed if (ROOT / file).is_file() and file != "PKG-INFO")


def _metadata(requirements, libraries):
    lines = [
        "Metadata-Version: 2.1",
        "Name: corrsel",
        "Version: " + _package_xml("version"),
        "Summary: Selects the correct ones among putative matches of image features",
        "Maintainer: " + _package_xml("maintainer"),
        "License: " + _package_xml("license"),
        "Requires-Python: >=3.8",
    ]
    lines += ["Requires-Dist: " + requirement for requirement in requirements]
    lines += ["Requires-External: " + library for library in libraries]
    for extra, names in EXTRAS.items():
        lines.append("Provides-Extra: " + extra)
        lines += ['Requires-Dist: %s; extra == "%s"' % (name, extra) for name in names]
    return "\n".join(lines) + "\n\n" + " ".join(_package_xml("description").split()) + "\n"


def _package_xml(element):
    return ElementTree.parse(str(ROOT / "package.xml")).findtext(element)


def _digest(data):
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
