#!/usr/bin/env python3
"""Tests of the script in the report's page, in headless Chromium: python3 test_report_script.py"""
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
from corrsel.report import reading  # noqa: E402
from corrsel.report.page import build  # noqa: E402
from test_report import Page, write_run  # noqa: E402
from test_report_variants import GMS, LPM, gms, write_run as write_variants  # noqa: E402

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
TABLE = '[...document.querySelectorAll("table")].find(t => t.caption.textContent.startsWith("Means over the pairs of sample"))'
HEAD = "const head = column => %s.tHead.rows[0].cells[column];" % TABLE


@unittest.skipUnless(CHROMIUM, "needs Chromium (package chromium)")
class ScriptTest(unittest.TestCase):
    """One page is made; each test runs a script of its own behind the page's, and reads what the browser holds then."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        write_run(cls.folder)
        cls.text = build(reading.read_run(cls.folder))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def browse(self, action, head="", text=None):
        """Return a page as the browser holds it after an action in JavaScript, with more in its head."""
        path = self.folder / "page.html"
        text = text or self.text
        end = text.rindex("</body>")
        page = "%s<script>%s</script>%s" % (text[:end], action, text[end:])
        path.write_text(page.replace("<head>", "<head>" + head, 1), encoding="utf-8")
        command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
        command += ["--user-data-dir=%s" % (self.folder / "profile"), "--dump-dom", path.as_uri()]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=600)
        text = done.stdout.decode("utf-8")
        self.assertIn("</html>", text, done.stderr.decode("utf-8", "replace"))
        return text

    def rows(self, text):
        """Return the first cells of the rows of the table of means, as they follow each other."""
        table = Page(text).table("Means over the pairs of sample")
        return [row[0]["text"].replace(" baseline", "") for row in table[1:]]

    def test_a_click_sorts_by_numbers_and_the_third_restores(self):
        found = []
        for clicks in range(4):
            text = self.browse(HEAD + "head(3).firstChild.click();" * clicks)
            found.append((self.rows(text), text.count('aria-sort="')))
        start = ["nnsr", "ransac", "lpm:v2", "keep_all"]
        self.assertEqual(found[0], (start, 0))
        self.assertEqual(found[1], (start, 1))  # F: 0.646, 0.869, 0.910, 0.999
        self.assertEqual(found[2], (start[::-1], 1))
        self.assertEqual(found[3], (start, 0))

    def test_directions_and_other_columns(self):
        text = self.browse(HEAD + "head(3).firstChild.click(); head(7).firstChild.click();")
        self.assertEqual(text.count('aria-sort="ascending"'), 1)
        # Median times: 1e-6, 0.020, 1.00, 5.00 ms. Numbers are compared, not their texts.
        self.assertEqual(self.rows(text), ["keep_all", "nnsr", "lpm:v2", "ransac"])
        text = self.browse(HEAD + "head(0).firstChild.click(); head(0).firstChild.click();")
        self.assertEqual(self.rows(text), ["ransac", "nnsr", "lpm:v2", "keep_all"])

    def test_empty_cells_are_last_in_both_directions(self):
        table = TABLE.replace("sample", "adelaidermf")  # nnsr is unsupported there
        for clicks in (1, 2):
            action = "%s.tHead.rows[0].cells[1].firstChild.click();" % table * clicks
            rows = Page(self.browse(action)).table("Means over the pairs of adelaidermf")
            self.assertEqual(rows[-1][0]["text"], "nnsr", clicks)

    def test_headers_can_be_reached_by_the_keyboard(self):
        action = (
            HEAD + "head(1).firstChild.focus(); document.body.dataset.focus = document.activeElement.type;"
        )
        self.assertIn('data-focus="button"', self.browse(action))

    def test_a_selector_is_switched_off_in_tables_legends_and_figures(self):
        count = 'const off = s => [...document.querySelectorAll(s)].filter(e => getComputedStyle(e).display === "none").length;'
        count += 'document.body.dataset.off = ["tr", "svg [data-selector]", ".legend li", ".cell"].map(off).join(" ");'
        switch = 'document.querySelector(".boxes input[value=\\"ransac\\"]").click();'
        self.assertIn('data-off="0 0 0 0"', self.browse(count))
        text = self.browse(switch + count)
        rows, artists, legends, examples = map(int, text.split('data-off="')[1].split('"')[0].split())
        self.assertGreaterEqual(rows, 3)  # two tables of means, and the one of statuses
        self.assertGreaterEqual(artists, 3)
        self.assertEqual((legends, examples), (1, 1))
        self.assertIn("Selectors shown: 3 of 4", text)
        self.assertIn('data-off="0 0 0 0"', self.browse(switch + switch + count))

    def test_variants_that_one_line_joins_share_a_switch(self):
        runs = {
            "curves": dict({gms(alpha): values for alpha, values in GMS.items()}, **LPM),
            "budget": {"gms[max_seconds=%g]" % s: (0.5, 0.5, 0.5, s) for s in (0.001, 0.01)},
        }
        runs["budget"]["lpm"] = (0.6, 0.6, 0.6, 0.002)
        count = "document.body.dataset.off = [...document.querySelectorAll('%s')].filter("
        count += 'e => getComputedStyle(e).display === "none").length;'
        switch = 'document.querySelector(".boxes input[value=gms]").click();'
        for section, scores in runs.items():
            with tempfile.TemporaryDirectory() as folder:
                write_variants(Path(folder), section, dict(scores, keep_all=(0.4, 1.0, 0.57)))
                page = build(reading.read_run(Path(folder)))
            text = self.browse(switch, text=page)
            self.assertIn("Selectors shown: 2 of 3", text, section)
            for hidden in ("svg [data-selector]", ".legend li", "#%s tbody tr" % section):
                off = self.browse(switch + count % hidden, text=page).split('data-off="')[1].split('"')[0]
                self.assertGreaterEqual(int(off), 2, (section, hidden))  # one for each of the two datasets

    def test_without_the_script_there_are_no_controls(self):
        refused = "<meta http-equiv=Content-Security-Policy content=\"script-src 'none'\">"
        text = self.browse("", refused)
        self.assertEqual({tag for tag, _ in Page(text).tags} & {"button", "input"}, set())
        self.assertEqual(self.rows(text), ["nnsr", "ransac", "lpm:v2", "keep_all"])
        self.assertIn("button", {tag for tag, _ in Page(self.browse("")).tags})


if __name__ == "__main__":
    unittest.main()
