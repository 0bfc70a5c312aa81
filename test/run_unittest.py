#!/usr/bin/env python3
"""Runs the unittest file given first and writes its results as JUnit XML to the file given second."""

import importlib.util
import pathlib
import sys
import unittest

from rosunit.xmlrunner import XMLTestRunner


def main():
    """Exit code 1 where a test failed."""
    source, results = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    sys.path.insert(0, str(source.parent))  # as if it were run itself
    spec = importlib.util.spec_from_file_location(source.stem, source)
    module = importlib.util.module_from_spec(spec)
    sys.modules[source.stem] = module
    spec.loader.exec_module(module)
    results.parent.mkdir(parents=True, exist_ok=True)
    with open(results, "w", encoding="utf-8") as stream:
        outcome = XMLTestRunner(stream).run(unittest.defaultTestLoader.loadTestsFromModule(module))
    return 0 if outcome.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
