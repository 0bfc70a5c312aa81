#!/usr/bin/env python3
"""Tests of the documentation: links and file names in *.md lead somewhere, pictures have a maker, numbers agree.

Needs Python and PyYAML: run it as `python3 test/core/test_docs.py`.
"""
import csv
import pathlib
import re
import tempfile
import unittest
from urllib.parse import unquote

import yaml

PACKAGE = pathlib.Path(__file__).resolve().parent.parent.parent
# Files in backticks may be written relative to these folders.
ROOTS = (
    "",
    "include",
    "include/corrsel",
    "src",
    "docs",
    "scripts",
    "test",
    "test/core",
    "examples/corrsel_example_selector",
)
SKIPPED = {".git", "build", "devel", "install"}

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)[^)]*\)")
FILE_NAME = re.compile(
    r"`([A-Za-z0-9_.]+(?:/[A-Za-z0-9_.]+)+\.(?:h|cpp|py|sh|md|launch|cfg|msg|test|in|cmake))`"
)


def documents(package):
    """Return all Markdown files of a package."""
    files = sorted(package.rglob("*.md"))
    return [file for file in files if not SKIPPED & set(file.relative_to(package).parts)]


def prose(text):
    """Return Markdown without its fenced code."""
    return re.sub(r"^(```|~~~).*?^\1", "", text, flags=re.M | re.S)


def anchors(text):
    """Return the anchors that GitHub gives to the headings of a Markdown text."""
    found = {}
    for heading in re.findall(r"^#{1,6}\s+(.+?)\s*#*\s*$", prose(text), flags=re.M):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        anchor = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        count = found.get(anchor, 0)
        found[anchor] = count + 1
        if count:
            found["%s-%d" % (anchor, count)] = 1
    return set(found)


def broken_links(package):
    """Return a line for every relative link of a package's Markdown files that leads nowhere."""
    broken = []
    for file in documents(package):
        text = file.read_text(encoding="utf-8")
        for link in LINK.findall(re.sub(r"`[^`\n]*`", "", prose(text))):
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = unquote(link).partition("#")
            target = file.parent / path if path else file
            name = "%s: %s" % (file.relative_to(package), link)
            if not target.exists():
                broken.append(name + ": no such file")
            elif anchor and target.suffix != ".md":
                broken.append(name + ": anchors are known in Markdown files only")
            elif anchor and anchor not in anchors(target.read_text(encoding="utf-8")):
                broken.append(name + ": no such heading")
    return broken


def broken_file_names(package):
    """Return a line for every file of the package that is named in backticks but does not exist.

    NAME stands for any name. The dated pages in docs/studies name the files of their day.
    """
    broken = []
    for file in documents(package):
        if file.parent.name == "studies":
            continue
        roots = [package / root for root in ROOTS] + [file.parent]
        for name in FILE_NAME.findall(prose(file.read_text(encoding="utf-8"))):
            if "NAME" not in name and not any((root / name).exists() for root in roots):
                broken.append("%s: `%s`: no such file" % (file.relative_to(package), name))
    return broken


class Links(unittest.TestCase):
    """What documents refer to exists."""

    maxDiff = None

    def test_all_links_lead_somewhere(self):
        self.assertEqual([], broken_links(PACKAGE))

    def test_all_files_named_in_backticks_exist(self):
        self.assertEqual([], broken_file_names(PACKAGE))

    def test_the_index_names_every_document(self):
        index = (PACKAGE / "docs" / "README.md").read_text(encoding="utf-8")
        named = {link.partition("#")[0] for link in LINK.findall(index)}
        present = {file.name for file in (PACKAGE / "docs").glob("*.md")} - {"README.md"}
        self.assertEqual(set(), present - named)


class Pictures(unittest.TestCase):
    """Every picture is used and made by a script."""

    def test_every_picture_is_used_and_made_by_a_script(self):
        text = "".join(file.read_text(encoding="utf-8") for file in documents(PACKAGE))
        script = (PACKAGE / "scripts" / "docs_images.py").read_text(encoding="utf-8")
        pictures = {file.name for file in (PACKAGE / "docs" / "images").iterdir()}
        self.assertTrue(pictures)
        self.assertEqual(pictures, set(re.findall(r"images/([^/)\s]+)\)", text)))
        self.assertEqual(set(), {picture for picture in pictures if '"%s"' % picture not in script})


class Copies(unittest.TestCase):
    """What stands in two places is the same in both."""

    def test_the_times_of_the_readme_are_those_of_the_performance_suite(self):
        readme = (PACKAGE / "README.md").read_text(encoding="utf-8")
        with (PACKAGE / "docs" / "data" / "performance.csv").open(encoding="utf-8", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["comparison"].startswith("growth/")]
        # Selector -> ms for N = 5000; usac has a row for each model.
        measured = {
            row["selector"].replace(":h", ""): float(row["ours_ms"]) for row in rows if row["n"] == "5000"
        }
        table = re.findall(r"^\|.* \| ([\d.]+) ms \| `([\w:]+)` \|$", readme, flags=re.M)
        self.assertGreater(len(table), 7)
        for written, selector in table:
            with self.subTest(selector=selector):
                self.assertLess(abs(float(written) / measured[selector] - 1), 0.2)  # rounded

    def test_the_citation_and_the_example_have_the_version_of_the_package(self):
        version, example = (
            re.search("<version>(.+)</version>", (PACKAGE / folder / "package.xml").read_text("utf-8")).group(
                1
            )
            for folder in ("", "examples/corrsel_example_selector")
        )
        citation = yaml.safe_load((PACKAGE / "CITATION.cff").read_text(encoding="utf-8"))
        changes = (PACKAGE / "CHANGELOG.rst").read_text(encoding="utf-8")
        released = re.search(r"^(\d+\.\d+\.\d+) \((\d{4}-\d\d-\d\d)\)\n-+$", changes, flags=re.M)
        self.assertEqual(example, version)
        self.assertEqual((str(citation["version"]), str(citation["date-released"])), released.groups())
        self.assertEqual(released.group(1), version)

    def test_the_citation_names_what_its_format_requires(self):
        citation = yaml.safe_load((PACKAGE / "CITATION.cff").read_text(encoding="utf-8"))
        package = (PACKAGE / "package.xml").read_text(encoding="utf-8")
        self.assertEqual(citation["cff-version"], "1.2.0")
        self.assertEqual(
            [author["name"] for author in citation["authors"]], re.findall("<author>(.+)</author>", package)
        )
        self.assertEqual(citation["license"], re.search("<license[^>]*>(.+)</license>", package).group(1))
        for entry in [citation] + citation["references"]:
            self.assertTrue(entry["title"] and entry["authors"], entry)
        self.assertTrue(citation["message"])


class Checks(unittest.TestCase):
    """The checks above find what is wrong."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.package = pathlib.Path(folder.name)
        (self.package / "docs").mkdir()

    def write(self, name, text):
        (self.package / name).write_text(text, encoding="utf-8")

    def test_links(self):
        self.write("docs/a.md", "# One, two: `three`\n\n## Twice\n\n## Twice\n")
        self.write(
            "README.md",
            "[good](docs/a.md#one-two-three) [good](docs/a.md#twice-1) [good](https://example.org) [good](docs)\n"
            "[bad](docs/b.md) [bad](docs/a.md#four) ![bad](docs/a.png) [bad](#nowhere)\n"
            "`[code](x.md)`\n```\n[code](y.md)\n```\n",
        )
        self.assertEqual(
            [
                "README.md: docs/b.md: no such file",
                "README.md: docs/a.md#four: no such heading",
                "README.md: docs/a.png: no such file",
                "README.md: #nowhere: no such heading",
            ],
            broken_links(self.package),
        )

    def test_file_names(self):
        self.write("docs/a.md", "`docs/a.md`, `docs/b.md`, `x/y`, `other.h`\n")
        self.assertEqual(["docs/a.md: `docs/b.md`: no such file"], broken_file_names(self.package))


if __name__ == "__main__":
    unittest.main()
