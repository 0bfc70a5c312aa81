#!/usr/bin/env python3
"""Tests of the documentation: links and file names in *.md lead somewhere, pictures have a maker, numbers agree.

Needs Python and PyYAML: run it as `python3 test/core/test_docs.py`.
"""
import collections
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

LINK = re.compile(r"\]\(([^)\s]+)[^)]*\)")  # of a picture that is a link, both
HTML_LINK = re.compile(r"<(?:a|img)\b[^>]*\b(?:href|src)=\"([^\"]+)\"")
NAMELESS = re.compile(r"!\[\s*\]\(([^)\s]+)")
FILE_NAME = re.compile(
    r"`([A-Za-z0-9_.]+(?:/[A-Za-z0-9_.]+)+\.(?:h|cpp|py|sh|md|launch|cfg|msg|test|in|cmake))`"
)


def documents(package):
    """Return all Markdown files of a package."""
    files = sorted(package.rglob("*.md"))
    return [file for file in files if not SKIPPED & set(file.relative_to(package).parts)]


def fences(text):
    """Return the lines of a Markdown text, each with whether it belongs to fenced code, and the line of an unclosed fence."""
    lines, fence, begun = [], None, 0
    for number, line in enumerate(text.split("\n"), 1):
        mark = re.match(r"\s*(`{3,}|~{3,})(.*)$", line)
        lines.append((line, bool(fence or mark)))
        if mark and not fence:
            fence, begun = mark.group(1), number
        elif mark and mark.group(1).startswith(fence) and not mark.group(2).strip():
            fence = None
    return lines, begun if fence else None


def prose(text):
    """Return Markdown without its fenced code; the lines keep their numbers."""
    return "\n".join("" if fenced else line for line, fenced in fences(text)[0])


def headings(text):
    """Return the texts of the headings of a Markdown text as a reader sees them."""
    found = re.findall(r"^ {0,3}#{1,6}\s+(.+?)\s*#*\s*$", prose(text), flags=re.M)
    return [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in found]


def anchors(text):
    """Return {anchor: heading} of a Markdown text, with the anchors that both GitHub and GitLab give to it.

    GitLab joins hyphens that follow each other, and GitHub does not. A heading that has two anchors, and one that stands
    there twice, has none that a link can rely on.
    """
    found, unsafe = {}, set()
    for heading in headings(text):
        github = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        gitlab = re.sub(r"-+", "-", github)
        if github in found or github != gitlab or github.isdigit():
            unsafe.add(github)
        found[github] = heading
    return {anchor: heading for anchor, heading in found.items() if anchor not in unsafe}


def fault_of_link(package, file, link):
    """Return why a link of a document leads nowhere on a forge, or None."""
    path, _, anchor = unquote(link).partition("#")
    if path.startswith("/"):
        return "an absolute path"
    target = file.parent / path if path else file
    if package.resolve() not in (target.resolve(), *target.resolve().parents):
        return "outside of the package"
    if not target.exists():
        return "no such file"
    if not anchor:
        return None
    if target.suffix != ".md":
        return "anchors are known in Markdown files only"
    if anchor not in anchors(target.read_text(encoding="utf-8")):
        return "no such heading, or not one that GitHub and GitLab name alike"
    return None


def broken_links(package):
    """Return a line for every link of a package's Markdown files, but for those of the web, that leads nowhere."""
    broken = []
    for file in documents(package):
        text = re.sub(r"`[^`\n]*`", "", prose(file.read_text(encoding="utf-8")))
        for link in LINK.findall(text) + HTML_LINK.findall(text):
            fault = None if re.match(r"[a-z]+:", link) else fault_of_link(package, file, link)
            if fault:
                broken.append("%s: %s: %s" % (file.relative_to(package), link, fault))
    return broken


def cells(row):
    """Return the number of cells of a row of a table; a bar in code separates cells, too, unless it is escaped."""
    return len(re.split(r"(?<!\\)\|", re.sub(r"^\||(?<!\\)\|$", "", row.strip())))


def broken_tables(text):
    """Return the number and the text of each line of a Markdown text that no forge shows as a row of its table."""
    broken, columns, lines = [], 0, prose(text).split("\n")
    for number, line in enumerate(lines, 1):
        if not re.match(r" {0,3}\|", line):
            columns = 0
        elif not columns:
            follows = lines[number] if number < len(lines) else ""
            columns = cells(line) if re.match(r"^ {0,3}\|( *:?-+:? *\|)+ *$", follows) else 0
            if not columns or cells(follows) != columns:
                broken.append((number, line))
        elif cells(line) != columns:
            broken.append((number, line))
    return broken


def broken_pages(package):
    """Return a line for everything in a package's Markdown files that forges do not show as it was meant."""
    broken = []
    for file in documents(package):
        text, name = file.read_text(encoding="utf-8"), file.relative_to(package)
        unclosed = fences(text)[1]
        if unclosed:
            broken.append("%s:%d: this fence is not closed" % (name, unclosed))
        for number, line in broken_tables(text):
            broken.append("%s:%d: no row of its table: %s" % (name, number, line))
        counts = collections.Counter(headings(text))
        broken += ["%s: the heading '%s' stands there twice" % (name, h) for h, n in counts.items() if n > 1]
        plain = re.sub(r"(`+).+?\1", "", re.sub(r"<!--.*?-->", "", prose(text), flags=re.S), flags=re.S)
        for tag in re.findall(r"</?[A-Za-z][^>\n]*>", plain):
            if not re.match(r"</?(br|sub|sup|a|img|https?:)\b|<https?:", tag):
                broken.append("%s: %s is taken for HTML, and not shown" % (name, tag))
        broken += ["%s: %s: a picture without a text" % (name, link) for link in NAMELESS.findall(plain)]
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

    def test_all_pages_look_as_they_were_meant(self):
        self.assertEqual([], broken_pages(PACKAGE))

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
        self.write("docs/a.md", "# One, two: `three`\n\n## Twice\n\n## Twice\n\n## Here & there\n\n## A-b\n")
        self.write("docs/a.png", "")
        self.write(
            "README.md",
            "[good](docs/a.md#one-two-three) [good](docs/a.md#a-b) [good](https://example.org) [good](docs)\n"
            "[bad](docs/b.md) [bad](docs/a.md#four) ![bad](docs/b.png) [bad](#nowhere)\n"
            '[bad](docs/a.md#twice) [bad](docs/a.md#twice-1) [bad](docs/a.md#here--there) <img src="docs/c.png">\n'
            "[![bad](docs/d.png)](docs/e.md) [bad](/docs/a.md) [bad](../beside.md) [bad](docs/a.png#x)\n"
            "`[code](x.md)`\n```\n[code](y.md)\n```\n",
        )
        name = "no such heading, or not one that GitHub and GitLab name alike"
        self.assertEqual(
            [
                "README.md: docs/b.md: no such file",
                "README.md: docs/a.md#four: " + name,
                "README.md: docs/b.png: no such file",
                "README.md: #nowhere: " + name,
                "README.md: docs/a.md#twice: " + name,
                "README.md: docs/a.md#twice-1: " + name,
                "README.md: docs/a.md#here--there: " + name,
                "README.md: docs/d.png: no such file",
                "README.md: docs/e.md: no such file",
                "README.md: /docs/a.md: an absolute path",
                "README.md: ../beside.md: outside of the package",
                "README.md: docs/a.png#x: anchors are known in Markdown files only",
                "README.md: docs/c.png: no such file",
            ],
            broken_links(self.package),
        )

    def test_tables(self):
        self.write(
            "a.md",
            "| a | b |\n|---|--:|\n| 1 | 2 |\n| 1 |\n| 1 | `x|y` |\n| 1 | `x\\|y` |\n\n"
            "| a | b |\n|---|\n\n| no table |\n\n```\n| code |\n```\n",
        )
        lines = [line.split(": ", 1)[0] for line in broken_pages(self.package)]
        self.assertEqual(lines, ["a.md:4", "a.md:5", "a.md:8", "a.md:9", "a.md:11"])

    def test_pages(self):
        self.write(
            "a.md",
            "# A\n\n## B\n\n## B\n\nUse FOLDER/<name> here, not `<name>`, <https://a.org> or <!-- <x> -->.\n",
        )
        self.write(
            "b.md", "![](a.png) ![ ](b.png) ![text](c.png)\n~~~\n```\n~~~\n\n```sh\n# Not closed\n~~~\n"
        )
        self.assertEqual(
            [
                "a.md: the heading 'B' stands there twice",
                "a.md: <name> is taken for HTML, and not shown",
                "b.md:6: this fence is not closed",
                "b.md: a.png: a picture without a text",
                "b.md: b.png: a picture without a text",
            ],
            broken_pages(self.package),
        )

    def test_file_names(self):
        self.write("docs/a.md", "`docs/a.md`, `docs/b.md`, `x/y`, `other.h`\n")
        self.assertEqual(["docs/a.md: `docs/b.md`: no such file"], broken_file_names(self.package))


if __name__ == "__main__":
    unittest.main()
