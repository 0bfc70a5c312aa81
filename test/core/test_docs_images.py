#!/usr/bin/env python3
"""Tests of scripts/docs_images.py: python3 test_docs_images.py"""
import contextlib
import io
import os
import re
import sys
import tempfile
import unittest
from pathlib import Path

from test_report import SCORES, pair_row, summary_row, write_csv, write_pairs

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import docs_images  # noqa: E402  (found through the path above)
from corrsel.report import reading  # noqa: E402

CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


class DocsImagesTest(unittest.TestCase):
    """Each test has a separate folder."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def call(self, *arguments):
        """Run the script in this process; return exit status, standard output and error output."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = docs_images.main([str(a) for a in arguments] + ["--output", str(self.folder / "images")])
        return status, out.getvalue(), err.getvalue()

    def write_run(self, dataset="vgg"):
        """Write the tables of a run with the rows that the plots show and others that they leave out."""
        pairs, means = [], []
        for selector, scores in SCORES.items():
            for features in ("sift+sift", "hessian_affine+sift"):
                for tau in (1, 5, 10):
                    pairs.append(pair_row(dataset, "graf", features, selector, tau, scores))
                    means.append(summary_row(dataset, features, selector, tau, scores))
        write_pairs(self.folder / "pairs.csv", pairs)
        write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, means)

    def test_diagram_is_the_one_in_the_documentation(self):
        status, out, err = self.call("diagram")
        self.assertEqual((status, err), (0, ""))
        made = Path(out.strip()).read_text(encoding="utf-8")
        kept = docs_images.package / "docs" / "images" / "live.svg"
        self.assertEqual(made, kept.read_text(encoding="utf-8"))

    def test_plots_show_the_selectors_without_presets(self):
        self.write_run()
        status, out, err = self.call("plots", self.folder)
        self.assertEqual((status, err), (0, ""))
        self.assertEqual([Path(line).name for line in out.split()], ["vgg_f.svg", "vgg_time.svg"])
        texts = [Path(line).read_text(encoding="utf-8") for line in out.split()]
        for text in texts:
            self.assertRegex(text, r"vgg, hessian_affine\+sift, no")
            for selector in ("nnsr", "ransac"):
                self.assertIn(">%s<" % selector, text)
            self.assertNotIn("lpm", text)
        self.call("plots", self.folder)
        self.assertEqual(texts, [Path(line).read_text(encoding="utf-8") for line in out.split()])

    def test_a_run_without_the_rows_is_refused_with_a_remedy(self):
        self.write_run("symbench")
        status, _, err = self.call("plots", self.folder)
        self.assertEqual(status, 2)
        self.assertRegex(
            err, r"pairs\.csv: no rows of vgg with hessian_affine\+sift\. Remedy: .*--dataset vgg"
        )
        self.assertFalse(list((self.folder / "images").iterdir()))

    def test_a_folder_that_is_no_run_is_refused(self):
        status, _, err = self.call("plots", self.folder / "nowhere")
        self.assertEqual(status, 2)
        self.assertIn("nowhere", err)
        self.assertIn("Remedy", err)

    def test_matches_are_those_of_the_readme(self):
        try:
            from corrsel import match  # noqa: F401  (built as a module in C++)
        except ImportError as error:
            self.skipTest("the Python module of corrsel is not built: %s" % error)
        samples = CACHE / "corrsel" / "sample"
        if not (samples / "graf1.png").is_file():
            self.skipTest("no sample photographs in %s: run scripts/fetch_samples.sh" % samples)
        status, out, err = self.call("matches", samples)
        self.assertEqual((status, err), (0, ""))
        made = re.findall(r"(\d+) .*: (\d+) % correct", out)
        readme = (docs_images.package / "README.md").read_text(encoding="utf-8").replace("\n", " ")
        caption = re.search(
            r"Of the (\d+) ORB matches, (\d+) % .*? Of the (\d+) matches .*? keeps, (\d+) % are", readme
        )
        self.assertEqual([number for pair in made for number in pair], list(caption.groups()))
        self.assertTrue(Path(out.split()[-1]).read_bytes().startswith(b"\x89PNG"))

    def test_the_selection_is_that_of_the_documentation(self):
        try:
            from corrsel import draw  # noqa: F401  (built as a module in C++)
        except ImportError as error:
            self.skipTest("the Python module of corrsel is not built: %s" % error)
        samples = CACHE / "corrsel" / "sample"
        if not (samples / "graf1.png").is_file():
            self.skipTest("no sample photographs in %s: run scripts/fetch_samples.sh" % samples)
        status, out, err = self.call("selection", samples)
        self.assertEqual((status, err), (0, ""))
        made, kept = Path(out.strip()), docs_images.package / "docs" / "images" / "selection.png"
        self.assertEqual(made.name, kept.name)
        sizes = [path.read_bytes()[16:24] for path in (made, kept)]  # width and height of a PNG
        self.assertEqual(sizes[0], sizes[1])

    def test_missing_samples_are_named_with_a_remedy(self):
        try:
            from corrsel import match  # noqa: F401  (built as a module in C++)
        except ImportError as error:
            self.skipTest("the Python module of corrsel is not built: %s" % error)
        status, _, err = self.call("matches", self.folder)
        self.assertEqual(status, 2)
        self.assertRegex(err, r"graf1\.png, .* cannot be read\. Remedy: run scripts/fetch_samples\.sh")


if __name__ == "__main__":
    unittest.main()
