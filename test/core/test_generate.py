#!/usr/bin/env python3
"""Tests of scripts/generate.py: what the repository holds is what it writes, and it reports what is missing."""

import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import unittest

PACKAGE = pathlib.Path(__file__).resolve().parents[2]


def load():
    """Return the script as a module."""
    spec = importlib.util.spec_from_file_location("generate", PACKAGE / "scripts" / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def program():
    """Return the program option_catalogue of this build."""
    folders = [os.environ["CORRSEL_BINARY_DIR"], os.environ.get("CORRSEL_DEVEL_DIR")]
    for folder in filter(None, folders):
        found = load().program_in(folder)
        if found is not None:
            return found
    raise AssertionError("the program option_catalogue is not built")


class Generate(unittest.TestCase):
    """The script, with the catalogue of this build."""

    @classmethod
    def setUpClass(cls):
        cls.generate = load()
        cls.text = subprocess.run([str(program())], check=True, stdout=subprocess.PIPE).stdout.decode()
        cls.catalogue = json.loads(cls.text)

    def test_everything_generated_is_up_to_date(self):
        """If this fails, run scripts/generate.py and commit what it writes."""
        run = subprocess.run(
            [
                sys.executable,
                str(PACKAGE / "scripts" / "generate.py"),
                "--check",
                "--program",
                str(program()),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        self.assertEqual(run.returncode, 0, run.stdout.decode())

    def test_a_changed_option_is_noticed_everywhere(self):
        """The tables, the YAML file and the message that names the command."""
        before = self.generate.generated(self.catalogue)
        changed = json.loads(self.text.replace("Threshold factor; larger selects", "Factor; larger selects"))
        after = self.generate.generated(changed)
        self.assertEqual(
            [name for name in before if before[name] != after[name]],
            ["config/live.yaml", "docs/selectors.md"],
        )
        self.assertIn("scripts/generate.py", self.generate.COMMAND)

    def test_a_selector_without_a_section_is_an_error(self):
        """So is a marker without a selector."""
        parts = self.generate.tables(self.catalogue)["docs/selectors.md"]
        with self.assertRaisesRegex(
            self.generate.Problem, r"docs/selectors.md has no section for new: .*options: new"
        ):
            text = (PACKAGE / "docs" / "selectors.md").read_text(encoding="utf-8")
            self.generate.filled("docs/selectors.md", text, dict(parts, new="-"))
        with self.assertRaisesRegex(self.generate.Problem, "nothing to put at '<!-- options: old -->'"):
            self.generate.filled("x.md", "<!-- options: old -->\n<!-- end -->\n", {})

    def test_every_selector_has_a_row_of_special_cases(self):
        """The rows hold a status for each special input, and all columns suffice for every selector."""
        cases = self.catalogue["special_cases"]
        names = [selector["name"] for selector in self.catalogue["selectors"]]
        self.assertEqual([spec for spec in cases if ":" not in spec], names)
        for spec, results in cases.items():
            for title, text in results.items():
                if title != "min_matches":
                    self.assertRegex(text, r"^`[a-z_]+`(: (all|most|some|few|none))?$", (spec, title))
            self.assertNotIn("failed", str(results), spec)
            self.assertNotIn("unsupported", str(results), spec)

    def test_the_commands_of_the_results_name_selectors_that_exist(self):
        """So do the rows of the results, each of which the commands make."""
        results = json.loads((PACKAGE / "docs/data/results.json").read_text(encoding="utf-8"))
        every = {entry["name"] for entry in self.catalogue["selectors"]}
        known = every | {
            "%(name)s:" % e + preset for e in self.catalogue["selectors"] for preset in e["presets"]
        }
        lines = [line[len("selectors=") :] for line in results["command"] if line.startswith("selectors=")]
        named = set(",".join(lines).split(",")) - {"every", "$selectors"}
        self.assertEqual(named - known, set())
        self.assertEqual(set(results["f_percent"]) - every - named, set())

    def test_sections_lie_in_the_chapter_of_their_group(self):
        """The table of the selectors links to the sections whose headings begin with their names."""
        document = "## One\n### a: x\n## Two\n### b and c: y\n"
        selectors = [{"name": "a", "group": "first"}, {"name": "b", "group": "second"}]
        links = self.generate.section_links({"selectors": selectors}, document)
        self.assertEqual(links, {"a": "[`a`](#a-x)", "b": "[`b`](#b-and-c-y)", "c": "[`c`](#b-and-c-y)"})
        selectors[1]["group"] = "first"
        with self.assertRaisesRegex(
            self.generate.Problem, "b belongs to the group first, and its section to .*Two"
        ):
            self.generate.section_links({"selectors": selectors}, document)

    def test_options_of_several_selectors_are_listed_once(self):
        """A selector with the options of an earlier one shows how its own differ."""
        option = {"name": "size", "type": "integer", "default": 1, "min": 0, "max": 9, "description": "Size"}
        seed = dict(option, name="seed")
        first = {"name": "first", "options": [option, seed]}
        second = {"name": "second", "options": [dict(option, default=2), seed]}
        catalogue = {"selectors": [first, second]}
        table = (
            "| option | default | range | meaning |\n|---|---|---|---|\n| `size` | `1` | 0 to 9 | Size |\n"
        )
        self.assertEqual(self.generate.own_options(catalogue, first), table)
        self.assertEqual(
            self.generate.own_options(catalogue, second),
            "Its options are those of `first`, with other defaults: `size` = `2`.\n",
        )
        self.assertIn("| `seed` | `1`: `first`, `second` |", self.generate.shared_options(catalogue))

    def test_numbers_in_yaml_read_back_as_numbers(self):
        """YAML 1.1 takes 1e-05, which has no decimal point, for a text."""
        for value, text in ((1e-05, "1.0e-05"), (12.0, "12.0"), (0.25, "0.25")):
            self.assertEqual(self.generate.yaml_value({"type": "number", "default": value}), text)
        self.assertEqual(self.generate.yaml_value({"type": "flag", "default": True}), "true")
        self.assertEqual(self.generate.yaml_value({"type": "text", "default": ""}), '""')


if __name__ == "__main__":
    unittest.main()
