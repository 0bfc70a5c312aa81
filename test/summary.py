#!/usr/bin/env python3
"""Adds up the tests of one or several build folders: prints what failed, what was skipped and why, and the sums.

The results are the JUnit files below test_results in a build folder, and the output of ctest in tests.log. A program can fail after its last test has passed (a crash when it ends). Such
failures are found in ctest's output.
"""

import collections
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree


def reason(case):
    """First line of the message of a failed test case, last line of that of a skipped one."""
    for child in case:
        text = (child.get("message") or child.text or "").strip()
        if text:
            return text.splitlines()[-1] if child.tag == "skipped" else text.splitlines()[0]
    return ""


def failed_programs(log):
    """What ctest lists as failed, as tuples of kind ("gtest", "rostest", ...; "" without catkin), name and reason."""
    line = re.compile(r"^\s*\d+ - (?:_ctest_[^_]+_([^_]+)_)?(\S+) \((.+)\)\s*$")
    _, _, listing = log.rpartition("The following tests FAILED:")
    return [(match[1] or "", match[2], match[3]) for match in map(line.match, listing.splitlines()) if match]


def is_known(kind, name, failed_files):
    """Whether a failed program has a result file that names the failed test."""
    if kind == "rostest":  # the file has the name of the test in the launch file
        return any(stem.startswith(("rostest-", "rosunit-")) for stem in failed_files)
    return any(stem.endswith(name) for stem in failed_files)


def count(build, counts):
    """Adds the tests of one build folder to `counts` and prints those that failed or were skipped."""
    failed_files = set()
    for file in sorted((build / "test_results").rglob("*.xml")):
        try:
            root = ElementTree.parse(file).getroot()
        except ElementTree.ParseError as error:
            counts["failed"] += 1
            failed_files.add(file.stem)
            print(f"FAILED {file.name}: not readable: {error}")
            continue
        for case in root.iter("testcase"):
            tags = {child.tag for child in case}
            name = f"{file.stem}: {case.get('classname', '')}.{case.get('name', '')}"
            if tags & {"failure", "error"}:
                counts["failed"] += 1
                failed_files.add(file.stem)
                print(f"FAILED {name}: {reason(case)}")
            elif "skipped" in tags or case.get("result") == "skipped" or case.get("status") == "notrun":
                counts["skipped"] += 1
                print(f"skipped {name}: {reason(case)}")
            else:
                counts["passed"] += 1
    log = build / "tests.log"
    for kind, name, how in failed_programs(log.read_text(errors="replace")):
        if not is_known(kind, name, failed_files):
            counts["failed"] += 1
            print(f"FAILED {kind} {name}: the program failed ({how}), but none of its tests did: see {log}")


def main():
    """Prints the summary of the build folders. Returns 1 if a test failed or none ran in one of them."""
    counts = collections.Counter()
    incomplete = False
    for folder in map(pathlib.Path, sys.argv[1:]):
        before = counts["passed"]
        count(folder, counts)
        if counts["passed"] == before:
            incomplete = True
            print(f"FAILED: no test passed in {folder}")
    print(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return 1 if counts["failed"] or incomplete else 0


if __name__ == "__main__":
    sys.exit(main())
