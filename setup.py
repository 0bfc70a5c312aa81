"""Installs the Python module; called by catkin, not by people."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["corrsel", "corrsel.files", "corrsel.report"],
        package_dir={"": "python"},
        package_data={
            "corrsel": ["*.pyi", "py.typed"],
            "corrsel.report": ["*.css", "*.js", "templates/*.html"],
        },
    )
)
