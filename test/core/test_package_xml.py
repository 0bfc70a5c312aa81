#!/usr/bin/env python3
"""Tests of package.xml: its keys exist, and the other lists of packages agree with it."""

import pathlib
import re
import subprocess
import unittest

import yaml
from catkin_pkg.package import parse_package

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
# What Debian's rosdep knows: its ROS packages. It comes with the package python3-rosdep2.
DATABASE = pathlib.Path("/usr/share/python3-rosdep2/debian.yaml")
KINDS = (
    "build_depends",
    "buildtool_depends",
    "build_export_depends",
    "buildtool_export_depends",
    "exec_depends",
    "test_depends",
)


def read_rules(path):
    """Returns Debian's packages of each key in a file of rosdep rules."""
    return {key: systems["debian"] for key, systems in yaml.safe_load(path.read_text()).items()}


def installed_dependencies():
    """Returns the names that each installed Debian package depends on, and the packages that provide a name."""
    output = subprocess.run(
        ["dpkg-query", "-W", "-f=${Package}\t${Pre-Depends}, ${Depends}\t${Provides}\n"],
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    ).stdout
    depends, providers = {}, {}
    for line in output.splitlines():
        package, needed, provided = line.split("\t")
        depends[package] = re.findall(r"(?:^|[,|])\s*([a-z0-9][a-z0-9+.-]+)", needed)
        for name in re.findall(r"(?:^|,)\s*([a-z0-9][a-z0-9+.-]+)", provided):
            providers.setdefault(name, []).append(package)
    return depends, providers


@unittest.skipUnless(DATABASE.exists(), "needs Debian's database of rosdep (package python3-rosdep2)")
class PackageXml(unittest.TestCase):
    """The keys in package.xml, resolved for Debian."""

    @classmethod
    def setUpClass(cls):
        package = parse_package(str(PACKAGE))
        cls.keys = {dependency.name for kind in KINDS for dependency in getattr(package, kind)}
        cls.own_rules = read_rules(PACKAGE / "scripts" / "maintenance" / "debian_rosdep.yaml")
        cls.rules = {**read_rules(DATABASE), **cls.own_rules}

    def test_every_key_exists(self):
        self.assertGreater(len(self.keys), 30)
        self.assertEqual([], sorted(self.keys - set(self.rules)))

    def test_every_own_rule_is_used(self):
        self.assertEqual([], sorted(set(self.own_rules) - self.keys))

    def test_cmake_names_the_same_packages(self):
        """What an error of CMake asks the user to install is what package.xml declares."""
        text = (PACKAGE / "cmake" / "dependencies.cmake").read_text()
        components, packages = (
            re.search(r"set\(%s\n(.*?)\)" % name, text, re.S).group(1).split()
            for name in ("ros_components", "ros_debian_packages")
        )
        self.assertEqual(len(components), len(packages))
        for component, package in zip(components, packages):
            self.assertIn(component, self.keys)
            self.assertIn(package, self.rules[component])
        others = set(re.findall(r'check_found\(\S+ "[^"]+" "[^"]+" ([a-z0-9-]+)\)', text)) - {"catkin"}
        self.assertIn("libmatio-dev", others)
        self.assertEqual(set(), others - {package for key in self.keys for package in self.rules[key]})

    def test_scripts_install_what_is_declared(self):
        """For every key, what common.sh installs, and what that depends on, includes a package of it."""
        command = 'source scripts/common.sh && echo "${build_packages[@]}" "${test_packages[@]}"'
        listed = subprocess.run(
            ["bash", "-c", command], cwd=PACKAGE, stdout=subprocess.PIPE, check=True, text=True
        ).stdout.split()
        depends, providers = installed_dependencies()
        missing = [name for name in listed if name not in depends and name not in providers]
        if missing:
            self.skipTest("what these packages depend on is not known: " + " ".join(missing))
        brought, remaining = set(), list(listed)
        while remaining:
            name = remaining.pop()
            if name not in brought:
                brought.add(name)
                remaining += depends.get(name, []) + providers.get(name, [])
        self.assertEqual([], sorted(key for key in self.keys if not brought & set(self.rules[key])))


if __name__ == "__main__":
    unittest.main()
