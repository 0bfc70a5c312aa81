#!/usr/bin/env python3
"""Tests of corrsel.report: python3 test_report.py"""
import base64
import contextlib
import csv
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path
from unittest import mock

from markupsafe import escape

sys.dont_write_bytecode = True
from corrsel.report import __main__ as report, reading  # noqa: E402  (without byte code)
from corrsel.report.figures import FigureWriter  # noqa: E402
from corrsel.report.markup import FOLDER  # noqa: E402
from corrsel.report.words import SCENES  # noqa: E402

EVIL = '<script>alert("x")</script>&\'$a$'
JPEG = b"\xff\xd8\xff\xe0 stands for a picture \xff\xd9"
# selector -> precision, recall, F, F of the same tau, median time in s
SCORES = {
    "nnsr": (0.70, 0.60, 0.646, 0.650, 2e-5),
    "ransac": (0.95, 0.80, 0.869, 0.870, 5e-3),
    "lpm:v2": (0.90, 0.92, 0.910, 0.905, 1e-3),
    "keep_all": (0.50, 0.92, 0.999, 0.999, 1e-9),
}


class Page(HTMLParser):
    """Collects the tables, ids, links and tags of a page."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.tags, self.ids, self.links, self.sources = [], [], [], [], []
        self.cell = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.tags.append((tag, attrs))
        self.ids += [attrs["id"]] if "id" in attrs else []
        self.links += [v for k, v in attrs.items() if k in ("href", "xlink:href")]
        self.sources += [v for k, v in attrs.items() if k in ("src", "srcset", "data", "action")]
        if tag == "table":
            self.tables.append({"caption": "", "rows": []})
        elif tag == "tr":
            self.tables[-1]["rows"].append([])
        elif tag in ("th", "td"):
            self.cell = {"tag": tag, "class": attrs.get("class", ""), "scope": attrs.get("scope"), "text": ""}
            self.tables[-1]["rows"][-1].append(self.cell)
        elif tag == "caption":
            self.cell = {"text": ""}

    def handle_endtag(self, tag):
        if tag in ("th", "td", "caption"):
            if tag == "caption":
                self.tables[-1]["caption"] = self.cell["text"]
            self.cell = None

    def handle_data(self, data):
        if self.cell is not None:
            self.cell["text"] += data

    def table(self, caption):
        """Return the rows of the first table whose caption starts so."""
        return next(t["rows"] for t in self.tables if t["caption"].startswith(caption))


def counts_of(row):
    """Return selected, correct and all inliers that give a row its F; where F has no such counts, they are fractions."""
    selected, inliers, f = (row.get(k) for k in ("n_selected", "n_ground_truth", "f_paper"))
    if selected in ("", None):
        return "", "", inliers
    if f in ("", None):
        return selected, 0, inliers
    correct = float(f) * (float(selected) + float(inliers)) / 2
    if abs(correct - float(row["n_correct"])) < 1e-9:
        correct = row["n_correct"]
    same = float(row.get("f_same_tau") or f)
    return selected, correct, 2 * correct / same - float(selected) if same else inliers


def write_pairs(path, rows):
    """Write a pairs.csv with rows by tolerance, see reading.ROW_HEADER; labelled ones have no tau_px."""
    taus = ["%g" % t for t in sorted({float(r["tau_px"]) for r in rows if r.get("tau_px") not in ("", None)})]
    header, selections = reading.pairs_header(taus or ["5"]), {}
    for row in rows:
        labelled = row.get("tau_px") in ("", None)
        key = tuple(str(row.get(k)) for k in header[:6] + ["seed"])
        cells = selections.setdefault(key, {k: v for k, v in row.items() if k in header and v is not None})
        cells.setdefault("truth", "labels" if labelled else "homography")
        cells["n_selected"], correct, inliers = counts_of(row)
        if labelled:
            cells["n_correct_labels"] = correct
        elif cells["truth"] != "none":
            tau = "%g" % float(row["tau_px"])
            cells[reading.CORRECT % tau], cells[reading.INLIERS % tau] = correct, inliers
    with path.open("w", newline="") as stream:
        stream.write("%s%d\n" % (reading.PAIRS_FORMAT, reading.PAIRS_VERSION))
        writer = csv.DictWriter(stream, header, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(selections.values())


def write_csv(path, header, rows):
    """Write rows of dictionaries; missing keys give empty cells."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, header, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read_pairs(path):
    """Return the rows by tolerance of a pairs.csv as dictionaries, see reading.ROW_HEADER."""
    columns = reading.read_pairs(path, [])
    return [columns.row(i) for i in range(len(columns))]


def read_csv(path):
    """Return the rows of a CSV file as dictionaries."""
    with path.open(newline="") as stream:
        return [dict(row) for row in csv.DictReader(stream)]


def pair_row(dataset, sequence, features, selector, tau, scores):
    """Return one row of pairs.csv."""
    row = dict(dataset=dataset, sequence=sequence, pair="1-2", features=features, preselection="none", seed=7)
    row.update(selector=selector, tau_px=tau, n_left=900, n_right=800, n_putative=900, n_ground_truth=400)
    if scores is None:
        row.update(status="unsupported_input")
    else:
        row.update(zip(("precision", "recall_paper", "f_paper", "f_same_tau"), scores))
        row.update(n_selected=300, n_correct=200, status="ok", recall_same_tau=scores[1], select_s=scores[4])
        row.update(detect_s=0.1, describe_s=0.2, match_s=0.3)
    return row


def summary_row(dataset, features, selector, tau, scores):
    """Return one row of summary.csv."""
    row = dict(
        dataset=dataset, features=features, preselection="none", selector=selector, tau_px=tau, pairs=3
    )
    row.update(zip(("precision", "recall_paper", "f_paper", "f_same_tau", "select_s_median"), scores))
    row.update(f_paper_lo=scores[2] - 0.01, f_paper_hi=scores[2] + 0.01)
    row.update(recall_same_tau=scores[1], select_s_p95=2 * scores[4])
    return row


def write_run(folder, name="sample"):
    """Write a complete run: a dataset with tolerances, whose first sequence is graf, and a labelled one."""
    pairs, means = [], []
    for selector, scores in SCORES.items():
        for tau in (1, 5, 10):
            pairs += [pair_row(name, s, "sift+sift", selector, tau, scores) for s in ("graf", "zoom", "blur")]
            means.append(summary_row(name, "sift+sift", selector, tau, scores))
        labelled = None if selector == "nnsr" else scores
        pairs += [pair_row("adelaidermf", s, "given", selector, "", labelled) for s in ("cube", "game")]
        if labelled:
            means.append(summary_row("adelaidermf", "given", selector, "", scores))
    nothing = pair_row(name, "empty", "sift+sift", "ransac", 5, SCORES["ransac"])
    nothing.update(n_ground_truth=0, recall_paper="", recall_same_tau="", f_paper="", f_same_tau="")
    pairs.append(nothing)
    write_pairs(folder / "pairs.csv", pairs)
    write_csv(folder / "summary.csv", reading.SUMMARY_HEADER, means)
    state = {"complete": True, "pairs_done": 6, "pairs_total": 6}
    (folder / "summary.json").write_text(json.dumps({"state": state}))
    (folder / "environment.json").write_text(json.dumps({"cpu": "Example <CPU>", "cores": 8}))
    (folder / "config.yaml").write_text("seed: 7\nhomepage: http://example.org/<x>\n")
    failure = dict(
        dataset=name, sequence="zoom", pair="1-9", features="orb+orb", stage="detect", error="blank & dark"
    )
    write_csv(folder / "failures.csv", reading.FAILURES_HEADER, [failure])
    image = dict(
        file="a.jpg", dataset=name, sequence="graf", pair="1-2", features="sift+sift", preselection="none"
    )
    image.update(selector="ransac", n_selected=200, n_correct=150, n_wrong=50, n_missed=12, tau_px=5)
    lost = dict(image, file="../../secret.jpg", selector="nnsr")
    write_csv(folder / "images" / "index.csv", reading.IMAGES_HEADER, [image, lost])
    (folder / "images" / "a.jpg").write_bytes(JPEG)


def figure_files(wanted):
    """Return a context in which reports write figures as files, which takes more than half of their time, or not."""
    if wanted:
        return contextlib.nullcontext()
    return mock.patch.object(FigureWriter, "write", lambda *_: "")


class ReportTest(unittest.TestCase):
    """Each test has a separate run folder."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name) / "run"
        self.folder.mkdir()
        write_run(self.folder)

    def call(self, *arguments):
        """Run the script in this process; return exit status, standard output and error output."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = report.main([str(a) for a in arguments or (self.folder,)])
        return status, out.getvalue(), err.getvalue()

    def make(self, files=False):
        """Write the report of the run folder and return its text."""
        with figure_files(files):
            status, out, err = self.call()
        self.assertEqual((status, err), (0, ""))
        self.assertEqual(out.splitlines()[-1], str(self.folder / "report.html"))
        return (self.folder / "report.html").read_text(encoding="utf-8")

    def test_writes_the_file_and_nothing_else(self):
        before = {p.name for p in self.folder.iterdir()}
        text = self.make(files=True)
        self.assertEqual({p.name for p in self.folder.iterdir()} - before, {"report.html", "figures"})
        self.assertTrue(text.startswith("<!DOCTYPE html>"))
        self.assertIn('<html lang="en">', text)
        self.assertIn('name="viewport"', text)
        self.assertEqual(text.count("<section "), 8)

    def test_output_option(self):
        target = Path(self.temporary.name) / "other.html"
        status, out, _ = self.call(self.folder, "--output", target)
        self.assertEqual((status, out.splitlines()[-1]), (0, str(target)))
        self.assertTrue(target.is_file())
        self.assertFalse((self.folder / "report.html").exists())
        links = {v for v in Page(target.read_text(encoding="utf-8")).links if not v.startswith("#")}
        self.assertIn("run/summary.csv", links)
        self.assertEqual([v for v in links if not (target.parent / v).is_file()], [])

    def test_output_that_cannot_be_written(self):
        status, _, err = self.call(self.folder, "--output", self.folder / "no" / "such" / "file.html")
        self.assertEqual(status, 2)
        self.assertIn("file.html", err)
        self.assertIn("Remedy", err)

    def test_is_self_contained(self):
        text = self.make(files=True)
        page = Page(text)
        self.assertEqual([attributes for tag, attributes in page.tags if tag == "script"], [{}])
        self.assertNotIn("link", {tag for tag, _ in page.tags})
        links = [v for v in page.links if not v.startswith("#")]
        self.assertEqual([v for v in links if ":" in v or v.startswith("/") or ".." in v], [])
        self.assertEqual([v for v in links if not (self.folder / v).is_file()], [])
        self.assertEqual([v for v in page.sources if not v.startswith("data:image/")], [])
        self.assertEqual([a for _, a in page.tags for v in a.values() if v and re.search("https?://", v)], [])
        self.assertNotIn("url(http", text)
        self.assertNotIn("@import", text)

    def test_identifiers_are_unique_and_links_lead_somewhere(self):
        page = Page(self.make())
        self.assertEqual(len(page.ids), len(set(page.ids)))
        self.assertEqual({v[1:] for v in page.links if v.startswith("#")} - set(page.ids), set())

    def test_tables_and_images_are_accessible(self):
        page = Page(self.make())
        heads = [cell for t in page.tables for row in t["rows"] for cell in row if cell["tag"] == "th"]
        self.assertTrue(heads and all(cell["scope"] in ("col", "row") for cell in heads))
        self.assertTrue(all(t["caption"] for t in page.tables))
        images = [a for tag, a in page.tags if tag == "img"]
        self.assertTrue(images and all(a.get("alt") for a in images))
        self.assertTrue(
            [1 for tag, a in page.tags if tag == "svg" and a.get("role") == "img" and a["aria-label"]]
        )

    def test_best_values_are_marked_in_their_cells(self):
        rows = Page(self.make()).table("Means over the pairs of sample")
        head = [cell["text"] for cell in rows[0]]
        marked = {
            (row[0]["text"], head[i]) for row in rows[1:] for i, c in enumerate(row) if c["class"] == "best"
        }
        self.assertEqual(
            marked,
            {
                ("ransac", "Precision"),
                ("lpm:v2", "Recall"),
                ("lpm:v2", "F"),
                ("lpm:v2", "F, same \u03c4"),
                ("nnsr", "Median (ms)"),
                ("nnsr", "p95 (ms)"),
            },
        )
        best = next(c for c in rows[3] if c["class"] == "best")
        self.assertEqual(best["text"], "0.920\u25b2")
        self.assertEqual(
            [row[0]["text"] for row in rows[1:]], ["nnsr", "ransac", "lpm:v2", "keep_all baseline"]
        )

    def test_summary_names_winner_runner_up_and_baseline(self):
        text = self.make()
        row = Page(text).table("Highest mean F")[1]
        self.assertIn("\u03c4 = 5 px", row[0]["text"])
        self.assertIn("lpm:v20.910 (0.900\u20130.920)", row[2]["text"])
        self.assertIn("ransac0.869", row[4]["text"])
        self.assertIn("intervals separate", row[4]["text"])
        self.assertEqual([row[i]["text"] for i in (1, 5, 7)], ["3", "3 of 3", "0.999"])
        self.assertIn("nnsr0.020 ms", row[6]["text"])
        self.assertIn("the intervals do not overlap", text)
        self.assertIn("Keeping everything gives F 0.999: no selector does better", text)

    def draw(self, *selectors):
        """Write drawn pairs of the selectors, on graf and, with another number of outliers, on zoom."""
        rows = []
        for sequence, wrong in (("zoom", 40), ("graf", 50)):
            for selector in selectors:
                row = dict(
                    dataset="sample", sequence=sequence, pair="1-2", features="sift+sift", preselection="none"
                )
                row.update(
                    selector=selector, n_selected=200, n_correct=200 - wrong, n_wrong=wrong, n_missed=12
                )
                rows.append(dict(row, tau_px=5, file="a.jpg"))
        write_csv(self.folder / "images" / "index.csv", reading.IMAGES_HEADER, rows)

    def assert_order(self, text, *parts):
        """Fail where the parts do not follow one another in a page."""
        places = [text.find(part) for part in parts]
        self.assertEqual(places, sorted(places), parts)
        self.assertNotIn(-1, places)

    def test_opens_with_the_picture_then_the_winner_then_the_tables(self):
        self.draw("ransac", "lpm:v2", "keep_all")
        text = self.make()
        winner = "<b>lpm:v2</b> has the highest mean F on sample"
        self.assert_order(
            text,
            'aria-label="Mean F against median selection time for sample',
            "<b>Before selection</b>",
            "<b>After selection by lpm:v2</b>",
            winner,
            "<section ",
            "<table",
        )
        self.assertIn(
            "200 selected: 150 inliers (75.0 %), 50 outliers", text[: text.index(winner)]
        )  # the photograph
        sentence = re.sub("<[^>]*>", "", text[text.index(winner) :][:700])
        self.assertIn("0.910 (95 % interval 0.900\u20130.920), ahead of ransac with 0.869 (95 %", sentence)

    def test_without_a_picture_of_all_matches_the_pair_is_shown_after_selection_only(self):
        self.draw("lpm:v2")
        text = self.make()
        self.assertNotIn("<b>Before selection</b>", text)
        self.assertIn("<b>After selection by lpm:v2</b>", text)

    def test_a_run_that_is_not_complete_says_so_before_the_picture(self):
        self.assert_order(self.make(), 'aria-label="Mean F against', "<strong>Complete</strong>")
        (self.folder / "summary.json").write_text(json.dumps({"state": {"complete": False}}))
        self.assert_order(self.make(), "<strong>INCOMPLETE</strong>", 'aria-label="Mean F against')

    def test_sections_about_single_pairs_stand_last_and_have_no_intervals(self):
        self.draw("lpm:v2", "keep_all")
        text = self.make()
        self.assertEqual(re.findall(r'<section id="([^"]*)"', text)[-2:], ["per_pair", "visual"])
        self.assertNotIn("nterval", text[text.index('<section id="per_pair"') : text.index("<footer>")])

    def test_one_pair_has_no_interval(self):
        rows = [dict(row, pairs="1") for row in read_csv(self.folder / "summary.csv")]
        write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, rows)
        text = self.make()
        page = Page(text)
        self.assertEqual(
            {row[4]["text"] for row in page.table("Means over the pairs of sample")[1:]}, {"\u2013"}
        )
        self.assertEqual(page.table("Highest mean F")[1][2]["text"], "lpm:v20.910")
        results = text[: text.index('<section id="definitions"')]
        self.assertTrue(re.search(r"0\.900.0\.920|intervals (overlap|separate|do not)", results) is None)

    def test_tables_take_the_numbers_of_the_summary(self):
        rows = read_csv(self.folder / "summary.csv")
        for row in rows:
            row["precision"] = "0.123456"
        write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, rows)
        table = Page(self.make()).table("Means over the pairs of sample")
        self.assertEqual({row[1]["text"].rstrip("\u25b2") for row in table[1:]}, {"0.123"})

    def test_unsupported_is_text(self):
        text = self.make()
        row = next(
            r for r in Page(text).table("Means over the pairs of adelaidermf") if r[0]["text"] == "nnsr"
        )
        self.assertEqual(len(row), 2)
        self.assertTrue(row[1]["text"].startswith("unsupported"))
        self.assertNotRegex(row[1]["text"], r"\d")
        self.assertIn(">unsupported</text>", text)

    def test_remarks_are_shown_and_give_the_reason_of_what_is_unsupported(self):
        rows = [("adelaidermf", "", "nnsr", "nnsr needs the column distance"), ("sample", "", "", "is <odd>")]
        rows = [dict(zip(reading.REMARKS_HEADER, row)) for row in rows]
        write_csv(self.folder / "remarks.csv", reading.REMARKS_HEADER, rows)
        text = self.make()
        self.assertIn("<li>nnsr does not run on adelaidermf: nnsr needs the column distance.</li>", text)
        self.assertIn("<li>sample: is &lt;odd&gt;.</li>", text)
        self.assertIn("unsupported: nnsr needs the column distance", text)

    def test_unsupported_is_text_even_where_the_summary_has_numbers(self):
        with (self.folder / "summary.csv").open("a", newline="") as stream:
            row = summary_row("adelaidermf", "given", "nnsr", "", (0.99, 0.99, 0.99, 0.99, 1e-9))
            csv.DictWriter(stream, reading.SUMMARY_HEADER, lineterminator="\n").writerow(row)
        page = Page(self.make())
        row = next(r for r in page.table("Means over the pairs of adelaidermf") if r[0]["text"] == "nnsr")
        self.assertNotRegex(row[1]["text"], r"\d")
        self.assertNotIn("nnsr", "".join(c["text"] for c in page.table("Highest mean F")[2]))

    def test_labelled_ground_truth_has_bars_and_no_curves(self):
        text = self.make()
        self.assertIn("Precision per selector for adelaidermf", text)
        self.assertNotIn("against tolerance for adelaidermf", text)
        self.assertIn("Precision against tolerance for sample", text)

    def test_names_are_escaped(self):
        write_run(self.folder, EVIL)
        for name in ("failures.csv", "images/index.csv", "pairs.csv", "summary.csv"):
            path = self.folder / name
            rows = read_pairs(path) if name == "pairs.csv" else read_csv(path)
            for row in rows:
                row.update({k: EVIL for k in ("error", "sequence") if k in row and row[k] != "empty"})
                if row.get("selector") == "ransac":
                    row["selector"] = EVIL
            write_pairs(path, rows) if name == "pairs.csv" else write_csv(path, rows[0].keys(), rows)
        (self.folder / "config.yaml").write_text("a: </pre>%s\n" % EVIL)
        (self.folder / "environment.json").write_text(json.dumps({EVIL: EVIL}))
        (self.folder / "summary.json").write_text(
            json.dumps({"state": {"complete": False, "pairs_done": EVIL, "pairs_total": EVIL}})
        )
        text = self.make()
        self.assertEqual(text.count("<script"), 1)
        self.assertIn("<script>%s</script>" % (FOLDER / "script.js").read_text(encoding="utf-8"), text)
        self.assertNotIn("</pre>&lt;", text.replace("&lt;/pre&gt;", ""))
        page = Page(text)
        self.assertEqual([tag for tag, _ in page.tags].count("script"), 1)
        self.assertIn(EVIL, json.loads(next(a["data-switches"] for tag, a in page.tags if tag == "main")))
        self.assertTrue(str(escape(EVIL)) in text)
        self.assertTrue(any(EVIL in a.get("alt", "") for tag, a in page.tags if tag == "img"))

    def test_the_tolerance_of_ground_truth_inliers_is_that_of_the_run(self):
        self.assertEqual(self.make().count("inliers at 10 px."), 1)
        config = self.folder / "config.yaml"
        config.write_text("ground_truth_tolerance: 2.5\n")
        text = self.make()
        self.assertEqual(text.count("inliers at 2.5 px."), 1)
        self.assertEqual(text.count("t<sub>gt</sub> = 2.5 px"), 2)
        config.write_text("ground_truth_tolerance: [2]\n")
        self.assertIn("t<sub>gt</sub> = 10 px", self.make())

    def test_complete_run_has_no_banner(self):
        text = self.make()
        self.assertNotIn("INCOMPLETE", text)
        self.assertIn("<strong>Complete</strong>: 6 of 6 pairs.", text)

    def test_incomplete_run_has_a_banner(self):
        state = {"complete": False, "pairs_done": 2, "pairs_total": 6}
        (self.folder / "summary.json").write_text(json.dumps({"state": state}))
        text = self.make()
        self.assertIn('class="state banner"', text)
        self.assertIn("<strong>INCOMPLETE</strong>: 2 of 6 pairs.", text)

    def test_doubtful_ground_truth_is_shown_at_the_top(self):
        self.assertNotIn("Doubtful ground truth", self.make())
        warning = "own/<desk>: 12 of 800 putative matches agree with the homography within 5 px, 640 with the inverse"
        state = {"complete": True, "pairs_done": 6, "pairs_total": 6}
        many = [{"text": warning}] + [{"text": "own/%d: wrong" % k} for k in range(20)]
        content = {"state": state, "truth_warnings": many}
        (self.folder / "summary.json").write_text(json.dumps(content))
        (self.folder / "truth_check.csv").write_text("dataset\n")
        text = self.make()
        self.assertIn("<strong>Doubtful ground truth</strong>", text)
        self.assertIn("<li>%s</li>" % warning.replace("<desk>", "&lt;desk&gt;"), text)
        self.assertLess(text.index("&lt;desk&gt;"), text.index('class="toc"'))
        self.assertIn("<li>9 more in summary.json</li>", text)
        self.assertTrue(any(link.endswith("truth_check.csv") for link in Page(text).links))
        for damaged in ("text", [3, {"text": ""}], {"text": warning}):
            content["truth_warnings"] = damaged
            (self.folder / "summary.json").write_text(json.dumps(content))
            self.assertNotIn("Doubtful ground truth", self.make())

    def test_last_line_cut_off_is_left_out(self):
        whole = self.make()
        data = (self.folder / "pairs.csv").read_bytes()
        line = data.splitlines()[1].replace(b"graf", b"half")
        for cut in (len(line), len(line) - 2, 20, 1):
            (self.folder / "pairs.csv").write_bytes(data + line[:cut])
            text = self.make()
            self.assertIn("pairs.csv: the last line is cut off", text)
            self.assertNotIn("half", text)
            self.assertEqual(Page(text).table("Pairs left out"), Page(whole).table("Pairs left out"))

    def test_unreadable_lines_are_counted(self):
        with (self.folder / "pairs.csv").open("a") as stream:
            stream.write("too,short\n" + ",".join(["word"] * len(reading.pairs_header("123"))) + "\n")
        self.assertIn("pairs.csv: 2 lines could not be read and left out", self.make())

    def test_wrong_header(self):
        path = self.folder / "pairs.csv"
        path.write_text(path.read_text().replace("dataset,sequence,pair", "dataset,sequenz,pair", 1))
        (self.folder / "report.html").write_text("old")
        status, out, err = self.call()
        self.assertEqual((status, out), (2, ""))
        self.assertIn("pairs.csv: wrong header: column 2 is 'sequenz' instead of 'sequence'", err)
        self.assertIn("Remedy", err)
        self.assertEqual((self.folder / "report.html").read_text(), "old")

    def test_header_too_short_and_too_long(self):
        for header, words in (
            (reading.pairs_header("5")[:-1], "ends before column 23"),
            (reading.pairs_header("5") + ["x"], "'x'"),
        ):
            self.write_text("# corrsel pairs 2\n" + ",".join(header) + "\n")
            status, _, err = self.call()
            self.assertEqual(status, 2)
            self.assertIn(words, err)

    def test_formats_of_other_versions_are_refused_with_a_remedy(self):
        for line, found in (
            ("dataset,sequence,pair,features,preselection,selector,tau_px,n_left", "format 1"),
            ("# corrsel pairs 3", "format 3"),
        ):
            self.write_text(line + "\n")
            status, _, err = self.call()
            self.assertEqual(status, 2)
            for part in (found, "reads format 2", "config.yaml", "environment.json"):
                self.assertIn(part, err)
        self.write_text("a,b\n")
        self.assertIn("the first line is not '# corrsel pairs 2'", self.call()[2])

    def write_text(self, text):
        """Replace pairs.csv by this text."""
        (self.folder / "pairs.csv").write_text(text)

    def test_missing_folder_and_missing_pairs(self):
        (self.folder / "pairs.csv").unlink()
        for folder in (self.folder, self.folder / "nowhere"):
            status, out, err = self.call(folder)
            self.assertEqual((status, out), (2, ""))
            self.assertIn(str(folder), err)
            self.assertIn("Remedy", err)

    def test_missing_optional_files_are_named(self):
        self.assertIn("stages.csv is missing: the time by stage is not shown", self.make())
        names = [
            "summary.csv",
            "summary.json",
            "environment.json",
            "config.yaml",
            "failures.csv",
            "images/index.csv",
        ]
        for name in names:
            (self.folder / name).unlink()
        text = self.make()
        for name in names:
            self.assertIn("%s is missing" % name, text)
        self.assertIn("State unknown", text)
        self.assertIn("How the selections ended", text)

    def test_damaged_optional_files_are_named(self):
        (self.folder / "summary.csv").write_text("a,b\n1,2\n")
        (self.folder / "summary.json").write_text('{"state": {"comp')
        (self.folder / "environment.json").write_text("[1]")
        (self.folder / "failures.csv").write_text("")
        text = self.make()
        self.assertIn("summary.csv was not used", text)
        self.assertIn("summary.json is not valid JSON", text)
        self.assertIn("environment.json does not hold a JSON object", text)
        self.assertIn("failures.csv is an empty file", text)

    def test_no_pairs(self):
        for content in ("# corrsel pairs 2\n%s\n" % ",".join(reading.pairs_header("5")), ""):
            self.write_text(content)
            write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, [])
            self.assertIn("This run holds no pairs.", self.make())

    def test_pairs_without_ground_truth_are_listed(self):
        text = self.make()
        row = Page(text).table("Pairs left out of the means")[1]
        self.assertEqual([c["text"] for c in row][:3], ["sample", "empty", "1-2"])
        self.assertEqual(row[5]["text"], "no correct putative match")
        self.assertIn("1 of 4 pairs is not in the means: 1 has no correct putative match.", text)

    def test_scenes_are_counted_once_per_pair_and_seed(self):
        found = {"vgg": ["rigid"] * 3 + ["nothing"], "other": ["unknown", "at_rest"]}
        rows = []
        for dataset, scenes in found.items():
            for i, scene in enumerate(scenes):
                for seed in (7, 8):
                    for tau in (1, 5):
                        row = pair_row(dataset, "s%d" % i, "orb+orb", "auto", tau, [0.5] * 5)
                        rows.append(dict(row, scene=scene, seed=seed))
                        rows.append(dict(row, scene="unknown", seed=seed, selector="gms"))
            rows.append(pair_row(dataset, "s9", "orb+orb", "auto", 5, None))
        write_pairs(self.folder / "pairs.csv", rows)
        head, *found = [[cell["text"] for cell in row] for row in Page(self.make()).table("The scene that")]
        self.assertEqual(head[4:], [*(name.replace("_", " ") for name in SCENES), "all"])
        counts = {tuple(row[:4]): dict(zip(head[4:], row[4:])) for row in found}
        setting = ("orb+orb", "no preselection")
        self.assertEqual(set(counts), {("auto", "vgg") + setting, ("auto", "other") + setting})
        none = dict.fromkeys(head[4:], "0")
        expected = dict(none, rigid="6\u25b2", nothing="2", all="8")
        self.assertEqual(counts[("auto", "vgg") + setting], expected)
        expected = {**none, "unknown": "2\u25b2", "at rest": "2\u25b2", "all": "4"}
        self.assertEqual(counts[("auto", "other") + setting], expected)

    def test_a_run_without_scenes_has_no_section_on_them(self):
        self.assertNotIn("scenes", Page(self.make()).ids)

    def test_status_counts_do_not_multiply_by_tolerance(self):
        rows = Page(self.make()).table("How the selections ended")
        counts = {row[0]["text"]: [c["text"] for c in row[1:]] for row in rows[1:]}
        self.assertEqual(counts["nnsr"], ["3", "0", "0", "0", "2", "0", "0", "0", "0", "5"])
        self.assertEqual(counts["ransac"][0], "6")

    def test_images(self):
        text = self.make()
        self.assertIn("data:image/jpeg;base64," + base64.b64encode(JPEG).decode(), text)
        self.assertIn("200 selected: 150 inliers (75.0 %), 50 outliers; 12 inliers missed", text)
        self.assertIn("image ../../secret.jpg is missing", text)

    def test_images_outside_the_run_are_not_read(self):
        (self.folder.parent / "secret.jpg").write_bytes(b"secret")
        index = self.folder / "images" / "index.csv"
        text = index.read_text()
        for name in ("../../secret.jpg", str(self.folder.parent / "secret.jpg")):
            index.write_text(text.replace("../../secret.jpg", name))
            self.assertIn("secret.jpg is missing", self.make())

    def test_generated_pairs_are_declared(self):
        text = self.make()
        self.assertIn("all sequences but graf, aloe, rig, box and page are generated", text)
        rows = Page(text).table("Highest mean F")
        self.assertIn("generated but for graf, aloe, rig, box and page", rows[1][0]["text"])
        self.assertIn("real data", rows[2][0]["text"])

    def test_other_tolerances(self):
        rows = read_pairs(self.folder / "pairs.csv")
        write_pairs(self.folder / "pairs.csv", [row for row in rows if row["tau_px"] in (1, 10)])
        means = [row for row in read_csv(self.folder / "summary.csv") if row["tau_px"] in ("1", "10")]
        write_csv(self.folder / "summary.csv", reading.SUMMARY_HEADER, means)
        self.assertIn("The run has no tolerance of 5 px here; the table is made at 1 px.", self.make())

    def test_figures_that_cannot_be_written_are_noted(self):
        (self.folder / "figures").write_text("in the way")
        text = self.make(files=True)
        self.assertIn("The figures were not written as files", text)
        self.assertNotIn("figures/", text)

    def test_same_folder_same_bytes(self):
        first = self.make(files=True)
        files = {p.name: p.read_bytes() for p in (self.folder / "figures").iterdir()}
        environment = dict(os.environ, PYTHONHASHSEED="12345", LC_ALL="C", SOURCE_DATE_EPOCH="1")
        command = [sys.executable, "-B", "-m", "corrsel.report", str(self.folder)]
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(first, (self.folder / "report.html").read_text(encoding="utf-8"))
        self.assertIn("results_sample_f.png", files)
        self.assertIn("results_sample_f.svg", files)
        self.assertEqual(files, {p.name: p.read_bytes() for p in (self.folder / "figures").iterdir()})


if __name__ == "__main__":
    unittest.main()
