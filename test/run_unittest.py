#!/usr/bin/env python3
"""Runs the unittest file given first and writes its results as JUnit XML to the file given second."""

import importlib.util
import pathlib
import re
import sys
import time
import unittest
import xml.etree.ElementTree as ElementTree


class JUnitResult(unittest.TextTestResult):
    """Collects one XML element per test, in addition to the text output."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.suite = ElementTree.Element("testsuite")
        self.case = None
        self.begin = 0.0

    def startTest(self, test):
        super().startTest(test)
        self.begin = time.monotonic()
        self.case = self.element(test)

    def stopTest(self, test):
        self.case.set("time", f"{time.monotonic() - self.begin:.3f}")
        self.case = None
        super().stopTest(test)

    def element(self, test):
        """A new XML element for a test, or for what failed outside of tests (e.g. setUpClass)."""
        is_test = isinstance(test, unittest.TestCase)
        class_name, _, name = test.id().rpartition(".") if is_test else ("", "", test.id())
        return ElementTree.SubElement(self.suite, "testcase", classname=class_name, name=name)

    def outcome(self, test, tag, message):
        """Adds a child element with the outcome of a test."""
        case = self.element(test) if self.case is None else self.case
        # XML allows no control characters, which the output of a program may contain.
        ElementTree.SubElement(case, tag, message=re.sub(r"[\x00-\x08\x0b-\x1f]", "?", message))

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self.outcome(test, "failure", str(err[1]))

    def addError(self, test, err):
        super().addError(test, err)
        self.outcome(test, "error", f"{err[0].__name__}: {err[1]}")

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.outcome(test, "skipped", reason)

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self.outcome(test, "failure", f"{subtest.id()}: {err[1]}")

    def addUnexpectedSuccess(self, test):
        super().addUnexpectedSuccess(test)
        self.outcome(test, "failure", "unexpected success")


def main():
    """Returns the exit code: 1 if a test failed."""
    source, results = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    # Tests import modules that lie beside them and the helpers in the folder of this file.
    sys.path[:0] = [str(source.parent), str(pathlib.Path(__file__).resolve().parent)]
    spec = importlib.util.spec_from_file_location(source.stem, source)
    module = importlib.util.module_from_spec(spec)
    sys.modules[source.stem] = module
    spec.loader.exec_module(module)
    tests = unittest.defaultTestLoader.loadTestsFromModule(module)
    outcome = unittest.TextTestRunner(resultclass=JUnitResult, verbosity=2).run(tests)
    # catkin requires these sums.
    outcome.suite.set("tests", str(len(outcome.suite)))
    for attribute, tag in (("errors", "error"), ("failures", "failure"), ("skipped", "skipped")):
        outcome.suite.set(attribute, str(len(outcome.suite.findall("testcase/" + tag))))
    results.parent.mkdir(parents=True, exist_ok=True)
    ElementTree.ElementTree(outcome.suite).write(results, encoding="utf-8", xml_declaration=True)
    return 0 if outcome.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
