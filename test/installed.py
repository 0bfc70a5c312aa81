"""What tests need that use corrsel from outside: an installation of the build, and projects that are built with it."""

import os
import pathlib
import subprocess

BUILD = pathlib.Path(os.environ["CORRSEL_BINARY_DIR"])
# In a catkin workspace, the packages' build folders lie below the one that CMake was called for.
WORKSPACE_BUILD = next(folder for folder in (BUILD, *BUILD.parents) if (folder / "CMakeCache.txt").exists())
DEVEL = os.environ.get("CORRSEL_DEVEL_DIR")  # empty without catkin


def run(command, **environment):
    """Runs a command (a list). Returns its exit code and its output, both streams together."""
    result = subprocess.run(
        [str(argument) for argument in command],
        env=dict(os.environ, **environment),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return result.returncode, result.stdout


def install(folder):
    """Installs what has been built below `folder`. Returns the prefix, e.g. folder/usr/local."""
    commands = [["cmake", "--install", BUILD]]
    if WORKSPACE_BUILD != BUILD:  # setup.bash belongs to the workspace
        commands += [
            ["cmake", "-DCMAKE_INSTALL_LOCAL_ONLY=ON", "-P", WORKSPACE_BUILD / "cmake_install.cmake"]
        ]
    for command in commands:
        code, text = run(command, DESTDIR=str(folder))
        if code != 0:
            raise AssertionError(f"{command} failed:\n{text}")
    configs = [*pathlib.Path(folder).rglob("corrselConfig.cmake")]
    if len(configs) != 1:
        raise AssertionError(f"expected one corrselConfig.cmake below {folder}, found {configs}")
    # PREFIX/share/corrsel/cmake with catkin, PREFIX/LIBRARY_FOLDER/cmake/corrsel without.
    return next(parent for parent in configs[0].parents if (parent / "include").is_dir())


def configure_project(source, build, prefix):
    """Configures a CMake project that finds corrsel below `prefix`. Returns exit code and output."""
    # The compiler and the flags of the build under test, which a sanitized library needs in its user, too.
    toolchain = BUILD / "consumer_toolchain.cmake"
    paths = [f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_TOOLCHAIN_FILE={toolchain}"]
    return run(["cmake", "-S", source, "-B", build, *paths])


def build_project(source, build, prefix):
    """Configures and builds a CMake project that finds corrsel below `prefix`. Returns exit code and output."""
    code, text = configure_project(source, build, prefix)
    if code == 0:
        code, compiled = run(["cmake", "--build", build])
        text += compiled
    return code, text
