#!/usr/bin/env python3
"""Adds up the JUnit files below a folder: names what failed and what was skipped and why, then prints the sums."""

import collections
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def reason(case):
    """First line of what a skipped or failed test case says."""
    for child in case:
        text = (child.get("message") or child.text or "").strip()
        if text:
            return text.splitlines()[-1] if child.tag == "skipped" else text.splitlines()[0]
    return ""


def main():
    """Prints the summary of the folder given as argument; exit code 1 where a test failed or none ran."""
    counts = collections.Counter()
    for file in sorted(pathlib.Path(sys.argv[1]).rglob("*.xml")):
        try:
            root = ElementTree.parse(file).getroot()
        except ElementTree.ParseError as error:
            counts["failed"] += 1
            print(f"FAILED {file.name}: not readable: {error}")
            continue
        for case in root.iter("testcase"):
            tags = {child.tag for child in case}
            name = f"{file.stem}: {case.get('classname', '')}.{case.get('name', '')}"
            if tags & {"failure", "error"}:
                counts["failed"] += 1
                print(f"FAILED {name}: {reason(case)}")
            elif "skipped" in tags or case.get("result") == "skipped" or case.get("status") == "notrun":
                counts["skipped"] += 1
                print(f"skipped {name}: {reason(case)}")
            else:
                counts["passed"] += 1
    print(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return 0 if counts["passed"] and not counts["failed"] else 1


if __name__ == "__main__":
    sys.exit(main())
