#!/usr/bin/env python3
"""Tests of the report of a run with a preset: python3 test_report_experiments.py"""
import contextlib
import io
import json
import re
import shutil
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
from corrsel.report import __main__ as report  # noqa: E402
import numpy as np  # noqa: E402
from corrsel.report import (  # noqa: E402
    compared,
    paper,
    per_pair,
    pose,
    reading,
    selectors,
    stages,
    unrelated,
    visual,
    words,
)
from corrsel.report.figures import safe_name  # noqa: E402
from corrsel.report.words import data_kind  # noqa: E402
from test_report import JPEG, Page, figure_files, pair_row, read_csv, read_pairs, summary_row  # noqa: E402
from test_report import write_csv, write_pairs  # noqa: E402

SECTIONS = "overall per_pair preselected features robustness efficiency visual guide".split()  # of paper
CELLS = ("hessian_affine+sift/none", "hessian_affine+sift/nnsr", "orb+orb/none")
SELECTORS = {"nnsr": 0.5, "usac": 0.9, "gms": 0.7, "keep_all": 0.2}
EVIL = "../../e<b>vil</b>, \"x\"/'y'"


def values(f):
    """Return precision, recall, F, F of the same tau, and a time."""
    return (f, f, f, f, 1e-3)


def f_of(selector, dataset, sequence, cell):
    """Return the F of a pair; gms fails on boat."""
    if (selector, sequence) == ("gms", "boat"):
        return 0.036
    return SELECTORS[selector] + (0.05 if cell.endswith("nnsr") else 0.0)


def write_run(folder, vgg="vgg", boat="boat"):
    """Write a run of the preset paper: VGG, a stand-in of Heinly's and labelled pairs."""
    pairs, means, images = [], [], []
    scenes = {vgg: ("bark", boat), "heinly_generated": ("zoom",), "adelaidermf": ("cube",)}
    for dataset, sequences in scenes.items():
        for cell in CELLS if dataset != "adelaidermf" else ("given/none",):
            features, preselection = cell.split("/")
            for selector in SELECTORS:
                if selector == "nnsr" and (preselection == "nnsr" or features == "given"):
                    continue
                for tau in ("",) if features == "given" else (1, 5):
                    fs = []
                    for sequence in sequences:
                        fs.append(f_of(selector, dataset, "boat" if sequence == boat else sequence, cell))
                        row = pair_row(dataset, sequence, features, selector, tau, values(fs[-1]))
                        pairs.append(dict(row, preselection=preselection))
                    mean = summary_row(dataset, features, selector, tau, values(sum(fs) / len(fs)))
                    means.append(dict(mean, preselection=preselection, pairs=len(fs)))
    for sequence in ("bark", boat):
        for selector in SELECTORS:
            f = f_of(selector, vgg, "boat" if sequence == boat else sequence, CELLS[0])
            row = dict(dataset=vgg, sequence=sequence, pair="1-2", features="hessian_affine+sift")
            row.update(
                preselection="none", selector=selector, tau_px=5, n_selected=700, n_correct=int(640 * f)
            )
            row.update(n_wrong=700 - int(640 * f), n_missed=640 - int(640 * f), file="%d.jpg" % len(images))
            images.append(row)
    write_pairs(folder / "pairs.csv", pairs)
    write_csv(folder / "summary.csv", reading.SUMMARY_HEADER, means)
    write_csv(folder / "images" / "index.csv", reading.IMAGES_HEADER, images)
    for row in images:
        (folder / "images" / row["file"]).write_bytes(JPEG)
    write_csv(folder / "failures.csv", reading.FAILURES_HEADER, [])
    times = [
        dict(number=i, dataset=d, sequence=s, pair="1-2", stage=stage, seconds=1.5)
        for i, (d, s) in enumerate((d, s) for d in scenes for s in scenes[d])
        for stage in ("read", "features", "match", "select", "evaluate")
    ]
    times += [dict(stage="scaling", seconds=7), dict(stage="bag", dataset=vgg, seconds=2)]
    write_csv(folder / "stages.csv", reading.STAGES_HEADER, times)
    scaling = [
        dict(selector=s, threads=1, n=n, round=r, n_selected=n / 2, status="ok", select_s=1e-6 * n)
        for s in SELECTORS
        for n in (1000, 2000)
        for r in range(2)
    ]
    write_csv(folder / "scaling.csv", reading.SCALING_HEADER, scaling)
    left = [{"dataset": "heinly", "reason": "no folder <heinly>"}]
    state = {"complete": True, "pairs_done": 4, "pairs_total": 4, "peak_memory_mib": 321.4, "shard": ""}
    (folder / "summary.json").write_text(json.dumps({"state": dict(state, left_out_datasets=left)}))
    (folder / "environment.json").write_text("{}")
    write_config(folder, SECTIONS)


def write_config(folder, sections):
    """Write the keys of config.yaml that the report reads."""
    text = "experiment: paper\nsections: [%s]\ncells: [%s]\n" % (", ".join(sections), ", ".join(CELLS))
    (folder / "config.yaml").write_text(text)


def sections_of(text):
    """Return the anchors of the report's sections."""
    return re.findall(r'<section id="([^"]*)"', text)


class ExperimentsTest(unittest.TestCase):
    """One run is written and reported once; tests that change it use a copy."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name) / "run"
        cls.folder.mkdir()
        write_run(cls.folder)
        cls.text = cls.make(cls.folder, files=True)
        cls.page = Page(cls.text)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @staticmethod
    def make(folder, files=False):
        """Write the report of a folder and return its text."""
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as errors:
            with figure_files(files):
                status = report.main([str(folder)])
        assert status == 0, errors.getvalue()
        return (folder / "report.html").read_text(encoding="utf-8")

    def assert_text(self, text, part):
        """Fail where a page lacks a part, without showing the whole page."""
        self.assertTrue(part in text, "the page lacks: " + part)

    def copy(self):
        """Return a copy of the run without its report."""
        folder = Path(tempfile.mkdtemp(dir=self.temporary.name)) / "run"
        shutil.copytree(str(self.folder), str(folder), ignore=shutil.ignore_patterns("figures", "*.html"))
        return folder

    def cells(self, caption, first):
        """Return head text -> cell text of the row of a table that begins so."""
        rows = self.page.table(caption)
        row = next(r for r in rows[1:] if r[0]["text"].startswith(first))
        return {h["text"]: c["text"] for h, c in zip(rows[0], row)}

    def test_sections_follow_the_preset(self):
        found = sections_of(self.text)
        last = ["per_pair", "visual"]
        self.assertEqual(found[-2:], last)
        self.assertEqual([s for s in found if s in SECTIONS], [s for s in SECTIONS if s not in last] + last)
        self.assertEqual(found[0], "overview")
        self.assertNotIn("results", found)
        self.assertIn("stages", found)

    def test_other_presets_and_results_that_no_experiment_shows(self):
        folder = self.copy()
        write_config(folder, ["overall", "nonsense"])
        text = self.make(folder)
        found = sections_of(text)
        self.assertIn("overall", found)
        self.assertFalse({"features", "guide", "nonsense"} & set(found))
        self.assertIn("results", found)
        self.assert_text(text, 'id="results-1"')

    def test_damaged_or_absent_configuration_means_no_preset(self):
        folder = self.copy()
        for content in ("", "sections: {a: b}\n", "sections: [\n", "sections\n", "\x00\xff"):
            (folder / "config.yaml").write_text(content, encoding="latin-1")
            self.assertEqual(reading.read_run(folder).sections, [], content)
        (folder / "config.yaml").unlink()
        self.assertEqual(sections_of(self.make(folder))[1], "results")

    def test_every_section_survives_a_run_without_rows(self):
        folder = self.copy()
        write_pairs(folder / "pairs.csv", [])
        write_csv(folder / "summary.csv", reading.SUMMARY_HEADER, [])
        for name in ("stages.csv", "scaling.csv", "images/index.csv"):
            (folder / name).unlink()
        text = self.make(folder)
        self.assert_text(text, "This run holds no pairs.")
        for name in ("stages.csv", "scaling.csv", "images/index.csv"):
            self.assert_text(text, "%s is missing" % name)
        self.assertTrue(set(SECTIONS) <= set(sections_of(text)))

    def test_interrupted_before_the_summary(self):
        folder = self.copy()
        for name in ("summary.csv", "summary.json", "scaling.csv"):
            (folder / name).unlink()
        data = (folder / "pairs.csv").read_text()
        (folder / "pairs.csv").write_text(data[: int(0.6 * len(data))])
        text = self.make(folder)
        self.assert_text(text, "State unknown")
        self.assert_text(text, "the last line is cut off")
        self.assertEqual(len(sections_of(text)), len(set(sections_of(text))))

    def test_shard_left_out_datasets_and_memory_are_told(self):
        self.assert_text(self.text, "<strong>Left out</strong>: <b>heinly</b> (no folder &lt;heinly&gt;).")
        self.assert_text(self.text, "Peak memory of the run: 321 MiB.")
        self.assertNotIn("Shard", self.text)
        folder = self.copy()
        state = {
            "complete": True,
            "shard": "1/3",
            "left_out_datasets": ["what", None],
            "peak_memory_mib": "x",
        }
        (folder / "summary.json").write_text(json.dumps({"state": state}))
        self.assert_text(self.make(folder), "<strong>Shard 1/3</strong>")

    def test_kinds_of_data_are_told_apart(self):
        self.assertEqual([data_kind(d) for d in ("vgg", "my_bag", "heinly")], ["real"] * 3)
        self.assertEqual(data_kind("adelaidermf_reconstructed"), "reconstructed")
        self.assertIn("generated data", self.cells("Highest mean F", "heinly_generated")["Dataset"])
        self.assertIn("real data", self.cells("Highest mean F", "vgg")["Dataset"])
        self.assert_text(self.text, "heinly_generated (generated)")
        self.assert_text(self.text, "stands in for the paper&#39;s heinly (29 pairs, not available here)")

    def test_paper_beside_the_run(self):
        self.assertEqual(self.cells("Highest mean F", "vgg")["Paper names"], "usac, ransac, vfcTable V")
        rows = self.page.table("AdelaideRMF, labelled ground truth: 1 pair here, 38 in the paper")
        head = [c["text"] for c in rows[0]]
        printed = dict(zip(head, (c["text"] for c in rows[6])))
        self.assertEqual(
            (printed["vfc"], printed["gms"], printed["keep_all"]), ("91.63\u25b2", "87.25", "\u2013")
        )
        ours = dict(zip(head, (c["text"] for c in rows[5])))
        self.assertEqual((ours["usac"], ours["vfc"]), ("90.0\u25b2", "\u2013"))
        rows = self.page.table("Mean F without and after preselection")
        self.assertIn("97.27\u25b2", [c["text"] for c in rows[-1]])
        rows = self.page.table("Mean F by detector and descriptor")
        self.assertEqual(rows[-1][0]["text"], "paperheinly, 29 pairs; Table III")
        self.assertIn("60.30\u25b2", [c["text"] for c in rows[-1]])

    def test_paper_is_compared_in_the_same_setting_only(self):
        run = reading.read_run(self.folder)
        group = reading.Group("heinly_generated", "hessian_affine+sift", "none")
        self.assertIsNone(compared.printed_f(run, group))
        self.assertEqual(compared.paper_winner(run, group)[0], ["ransac", "nnsr", "lpm"])
        self.assertIsNone(compared.paper_winner(run, reading.Group("my_bag", "orb+orb", "none")))
        self.assertIsNone(compared.printed_f(run, reading.Group("symbench", "orb+orb", "nnsr")))
        values, source = compared.printed_f(run, reading.Group("symbench", "orb+orb", "none"))
        self.assertEqual((values["gms"], source), (11.62, paper.FEATURES_SOURCE))

    def test_pair_by_pair(self):
        row = self.cells("F pair by pair on vgg", "usac")
        self.assertEqual((row["Best on"], row["Mean F"]), ("2\u25b2", "0.900\u25b2"))
        self.assertEqual(self.cells("F pair by pair on vgg", "keep_all")["Best on"], "\u2013")
        self.assertIn("0.036boat 1-2", self.cells("F pair by pair on vgg", "gms")["Lowest F"])
        self.assertNotIn("Interval", self.cells("F pair by pair on vgg", "gms"))
        self.assertTrue((self.folder / "figures" / "per_pair_vgg.svg").is_file())

    def test_where_nothing_is_right_no_selector_is_best(self):
        f = per_pair.np.array([[0.0, 0.0, 0.1], [0.5, per_pair.np.nan, 0.9]])
        self.assertEqual(list(per_pair.highest_of(["a", "b", "keep_all"], f)), [0.0, 0.5])
        self.assertEqual(list(per_pair.highest_of(["keep_all"], f[:, 2:])), [-1.0, -1.0])
        folder = self.copy()
        rows = read_pairs(folder / "pairs.csv")
        for row in rows:
            row["f_paper"] = 0
        write_pairs(folder / "pairs.csv", rows)
        row = Page(self.make(folder)).table("F pair by pair on vgg")[1]
        self.assertEqual([c["text"] for c in row[1:3]], ["0", "0.000"])

    def test_preselection_beside_its_absence(self):
        self.assert_text(
            self.text,
            "vgg: preselection raises the mean F of 2 of 2 selectors; it changes most for usac (+5.0 points)",
        )
        self.assertTrue((self.folder / "figures" / "preselected_vgg_before_after.png").is_file())

    def test_figure_files_stand_on_their_own(self):
        svg = (self.folder / "figures" / "overall_vgg_f.svg").read_text(encoding="utf-8")
        for selector in SELECTORS:
            self.assertIn(">%s<" % selector, svg)
        self.assertIn("F against tolerance for vgg", svg)

    def test_success_and_failure_sentences(self):
        row = self.cells("A success and a failure of each selector", "gms")
        self.assertIn(
            "gms on vgg/boat 1-2: failure: keeps 23 of 640 inliers and 677 outliers (F 0.036) while usac reaches F 0.900.",
            row["Failure"],
        )
        self.assertIn(
            "gms on vgg/bark 1-2: best drawn pair, yet below F 0.8: keeps 448 of 640 inliers", row["Success"]
        )
        self.assertEqual(row["Number"], "0 successes, 1 failure of 2")
        row = self.cells("A success and a failure of each selector", "usac")
        self.assertIn(
            "usac on vgg/bark 1-2: success: keeps 576 of 640 inliers and 124 outliers (F 0.900).",
            row["Success"],
        )
        self.assertIn("usac: no other selector is better on any drawn pair.", row["Failure"])
        captions = [r[0]["text"] for r in self.page.table("A success and a failure")]
        self.assertNotIn("keep_all", captions)
        links = re.findall(r'href="#(cell-\d+)">see it', self.text)
        self.assertTrue(links and set(links) <= set(self.page.ids))

    def test_shortfall_where_nothing_reaches_the_threshold(self):
        folder = self.copy()
        rows = read_pairs(folder / "pairs.csv")
        for row in rows:
            row["f_paper"] = {"usac": 0.4, "gms": 0.3}.get(row["selector"], 0.1)
        write_pairs(folder / "pairs.csv", rows)
        run = reading.read_run(folder)
        success, failure = visual.findings(visual.drawn_images(run))["gms"]
        self.assertIn("best drawn pair, yet below F 0.8", visual.success_sentence(success))
        self.assertIn(
            "largest shortfall, where no selector reaches F 0.5", visual.failure_sentence("gms", failure)
        )

    def test_too_many_images_are_linked(self):
        opening = 2  # one pair before and after selection stands at the top, too
        self.assertEqual(self.text.count("data:image/jpeg"), opening + 8)
        old = visual.MAX_EMBEDDED
        visual.MAX_EMBEDDED = 5
        self.addCleanup(setattr, visual, "MAX_EMBEDDED", old)
        text = self.make(self.copy())
        self.assertEqual(text.count("data:image/jpeg"), opening + 5)
        self.assertEqual(text.count("(not in this page)"), 3)
        self.assert_text(text, "5 of the 8 images are in this page")
        named = set(re.findall(r'href="#cell-(\d+)">see it', text))
        shown = set(re.findall(r'id="cell-(\d+)"><figure id="ex-\d+"><a class="open"', text))
        self.assertTrue(named <= shown)

    def test_pairs_of_different_scenes(self):
        folder = self.copy()
        rows = []

        def add(dataset, selector, selections):
            for i, (selected, confidence, status) in enumerate(selections):
                for tau in (1, 5):
                    row = pair_row(dataset, "s%d" % i, "orb+orb", selector, tau, values(0.5))
                    row.update(n_selected=selected, confidence=confidence, status=status)
                    if words.is_unrelated(dataset):
                        row.update(n_ground_truth=0, precision="", recall_paper="", f_paper="")
                    rows.append(row)

        # usac is surer of two right pairs than of any wrong one, and as sure of the third one as of a wrong one.
        add("vgg", "usac", [(50, 30, "ok"), (40, 20, "ok"), (9, 5, "uncertain")])
        add("unrelated_vgg", "usac", [(9, 5, "ok"), (8, 0, "ok")])
        add("unrelated_symbench", "usac", [(60, 1, "uncertain"), (0, 0, "no_model")])
        # gms has no confidence: the number selected counts, unless the status is another than ok.
        add("vgg", "gms", [(50, "", "ok"), (40, "", "ok"), (30, "", "time_limit")])
        add("unrelated_vgg", "gms", [(45, "", "ok"), (44, "", "ok")])
        add("unrelated_symbench", "gms", [(10, "", "ok"), (0, "", "ok")])
        add("vgg", "nnsr", [("", "", "unsupported_input")] * 3)
        write_pairs(folder / "pairs.csv", rows)
        write_config(folder, ["unrelated"])
        text = self.make(folder)
        self.assertIn("unrelated", sections_of(text))
        self.page = Page(text)
        usac = self.cells("Pairs of different scenes, orb+orb", "usac")
        self.assertEqual(
            (usac["Unrelated pairs"], usac["of them accepted"], usac["Accepted"]), ("4", "1", "25.0 %")
        )
        self.assertEqual(usac["vgg: accepted"], "66.7 %")
        self.assertEqual(usac["Score of the ROC"], "confidence")
        # 12 comparisons, one of them a tie, all others won.
        self.assertEqual(usac["vgg: area"], "%.3f\u25b2" % (11.5 / 12))
        gms = self.cells("Pairs of different scenes, orb+orb", "gms")
        self.assertEqual((gms["of them accepted"], gms["Accepted"]), ("3", "75.0 %"))
        self.assertEqual(gms["Score of the ROC"], "number selected")
        # 50 beats all four, 40 beats two, 0 ties with one.
        self.assertEqual(gms["vgg: area"], "%.3f" % (6.5 / 12))
        self.assert_text(text, "<b>usac</b> accepts the fewest: 1 of 4 unrelated pairs (25.0 %).")
        self.assert_text(text, "unrelated_vgg (2 pairs); unrelated_symbench (2 pairs)")
        self.assertNotIn("no ground-truth inlier among", text)
        self.assertNotIn("nnsr", [r[0]["text"] for r in self.page.table("Pairs of different scenes")])
        names = [r[0]["text"] for r in self.page.table("Highest mean F")]
        self.assertFalse([n for n in names if n.startswith("unrelated")])

    def add_poses(self, folder):
        """Write poses of three pairs of a rig and corners of three pairs of VGG; usac is best."""
        errors = {
            "usac": (0.5, 1, 30),
            "gms": (2, 4, None),
            "keep_all": (50, None, None),
            pose.GROUND_TRUTH: (0.1,) * 3,
        }
        rows, summary = [], []
        for dataset, measure in (("rig", pose.POSE), ("vgg", pose.CORNERS)):
            for selector, found in errors.items():
                name = dict(dataset=dataset, features="orb+orb", preselection="none", selector=selector)
                for i, error in enumerate(found):
                    row = dict(
                        name, sequence="a", pair="%d" % i, seed=0, status="ok", n_selected=9, estimate_s=0.01
                    )
                    if measure is pose.POSE:
                        row.update(model="none" if error is None else "essential", n_inliers=8)
                        row.update(rotation_deg=error, pose_deg=180 if error is None else error)
                    else:
                        row["corner_px"] = "inf" if error is None else error
                    rows.append(row)
                share = np.mean([0 if e is None else max(0, 1 - e / 10) for e in found])
                mean = dict(name)
                mean.update({measure.pairs: 3, measure.failed: found.count(None), measure.area: share})
                mean.update({measure.area + "_lo": share - 0.01, measure.area + "_hi": share + 0.01})
                mean.update({"pose_deg_median": 2.0, "poses": 3} if measure is pose.POSE else {"poses": 0})
                summary.append(mean)
        write_csv(folder / "poses.csv", reading.POSES_HEADER, rows)
        write_csv(folder / "pose_summary.csv", reading.POSE_SUMMARY_HEADER, summary)

    def test_poses_and_corners(self):
        folder = self.copy()
        self.add_poses(folder)
        text = self.make(folder, files=True)
        self.assertIn("pose", sections_of(text))
        self.page = Page(text)
        usac = self.cells("Relative pose, rig, orb+orb", "usac")
        self.assertEqual((usac["Pairs"], usac["Without result"]), ("3", "0"))
        area = 100 * (0.95 + 0.9) / 3
        self.assertEqual(
            usac["AUC at 10\u00b0 (95 %)"], "%.1f\u25b2 (%.1f\u2013%.1f)" % (area, area - 1, area + 1)
        )
        self.assertEqual((usac["Median pose (\u00b0)"], usac["mAA"]), ("2.00", "\u2013"))
        self.assertEqual(self.cells("Relative pose, rig", "gms")["Without result"], "1")
        perfect = self.page.table("Relative pose, rig")[-1]
        self.assertEqual(perfect[0]["text"], "ground-truth inliers errors up to tgt")
        self.assertNotIn("\u25b2", perfect[3]["text"])
        self.assertEqual(self.cells("Corner error, vgg, orb+orb", "keep_all")["Without result"], "2")
        self.assert_text(text, "<b>usac</b> has the highest pose AUC at 10 degrees, %.1f %%" % area)
        self.assertNotIn(
            "(95 % interval", re.sub("<[^>]*>", "", text[text.index('<section id="per_pair"') :])
        )
        self.assert_text(text, 'href="poses.csv"')
        figures = {f.name for f in (folder / "figures").iterdir()}
        self.assertTrue({"pose_rig_orb+orb_none.svg", "corners_vgg_orb+orb_none.svg"} <= figures, figures)

    def test_poses_of_one_pair_stand_last_without_areas_and_intervals(self):
        folder = self.copy()
        self.add_poses(folder)
        self.assertLess(
            sections_of(self.make(folder)).index("pose"), sections_of(self.text).index("environment")
        )
        rows = read_csv(folder / "pose_summary.csv")
        for row in rows:
            row.update({name: "1" for name in ("poses", "homographies") if row[name]})
        write_csv(folder / "pose_summary.csv", reading.POSE_SUMMARY_HEADER, rows)
        text = self.make(folder)
        self.assertEqual(sections_of(text)[-3:], ["pose", "per_pair", "visual"])
        section = text[text.index('<section id="pose"') : text.index('<section id="per_pair"')]
        self.assertNotRegex(section, "AUC|95 %|<svg")
        self.page = Page(text)
        self.assertEqual(
            self.cells("Relative pose of the one pair of rig", "usac")["Error of the pose (\u00b0)"], "2.00"
        )

    def add_own_poses(self, folder):
        """Write the poses that the selector pose gives itself on three pairs."""
        name = dict(dataset="rig", features="given", preselection="none", selector="pose")
        verdicts = (
            ("general", "general", 1, 4, 5),
            ("rotation", "rest", 2, 3, 3),
            ("none", "general", None, None, 0),
        )
        rows = []
        for i, (motion, true_motion, error, nees, degrees) in enumerate(verdicts):
            row = dict(name, sequence="a", pair="%d" % i, seed=0, status="ok", n_selected=9, estimate_s=0.01)
            row.update(model="essential", n_inliers=8, rotation_deg=3, pose_deg=3)
            row.update(motion=motion, true_motion=true_motion, own_rotation_deg=error, nees=nees)
            row.update(own_pose_deg=180 if error is None else error, nees_degrees=degrees, uncertain=0)
            rows.append(row)
        mean = dict(
            name, poses=3, no_pose=0, auc_5=0.4, auc_10=0.7, auc_10_lo=0.6, auc_10_hi=0.8, auc_20=0.85
        )
        mean.update(own_poses=3, own_no_pose=1, own_auc_10=0.55, own_auc_10_lo=0.5, own_auc_10_hi=0.6)
        mean.update(nees_poses=1, nees_mean=4, nees_median=4, nees_inside_95=1, nees_rotation_poses=1)
        mean.update(nees_rotation_mean=3, nees_rotation_median=3, nees_rotation_inside_95=0, uncertain=2)
        write_csv(folder / "poses.csv", reading.POSES_HEADER, rows)
        write_csv(folder / "pose_summary.csv", reading.POSE_SUMMARY_HEADER, [mean])

    def test_own_poses_covariances_and_verdicts(self):
        folder = self.copy()
        self.add_own_poses(folder)
        text = self.make(folder)
        self.page = Page(text)
        own = self.cells("The selector's own pose, rig", "pose")
        self.assertEqual((own["Pairs"], own["Without result"], own["at 10\u00b0"]), ("3", "1", "70.0"))
        self.assertTrue(own["AUC at 10\u00b0 (95 %)"].startswith("55.0"), own)
        row = [cell["text"] for cell in self.page.table("Covariance, rig")[-1]]
        self.assertEqual(row, ["pose", "1", "4.0", "4.0", "100.0", "1", "3.0", "3.0", "0.0", "2"])
        rows = [[cell["text"] for cell in line] for line in self.page.table("Verdicts, rig")]
        self.assertIn(["pose", "rest", "0", "0", "1", "0", "0", "1"], rows)
        self.assertIn(["pose", "general", "1", "0", "0", "1", "0", "2"], rows)
        (folder / "poses.csv").unlink()
        self.page = Page(self.make(folder))
        self.assertTrue(self.page.table("Covariance, rig"))

    def test_preset_pose_without_poses_yet(self):
        folder = self.copy()
        write_config(folder, ["pose"])
        self.assert_text(self.make(folder), "no pairs with a known pose or homography yet")

    def test_curves_of_the_pose_are_left_out_with_a_note(self):
        folder = self.copy()
        self.add_poses(folder)
        (folder / "poses.csv").unlink()
        text = self.make(folder)
        self.assert_text(text, "Relative pose")
        self.assert_text(text, "the curves of errors are left out.")

    def test_recall_counts_pairs(self):
        x, y = pose.recall(np.array([3.0, 180.0, 1.0]), 4, 20)
        self.assertEqual(list(x), [0, 1, 1, 3, 3, 20])
        self.assertEqual(list(y), [0, 0, 0.25, 0.25, 0.5, 0.5])

    def test_area_under_the_roc_is_the_share_of_comparisons_won(self):
        random = np.random.RandomState(1)
        for _ in range(20):
            right, wrong = random.randint(0, 6, 9), random.randint(0, 5, 7)
            won = np.mean([(r > w) + 0.5 * (r == w) for r in right for w in wrong])
            self.assertAlmostEqual(unrelated.area(right, wrong), won)
            x, y = unrelated.roc(right, wrong)
            self.assertEqual((x[0], y[0], x[-1], y[-1]), (0, 0, 1, 1))
            self.assertTrue(np.all(np.diff(x) >= 0) and np.all(np.diff(y) >= 0))
        self.assertIsNone(unrelated.area(np.array([]), np.array([1.0])))

    def test_images_without_numbers(self):
        folder = self.copy()
        rows = read_csv(folder / "images" / "index.csv")
        for row in rows:
            row.update(n_selected="", n_correct="", n_wrong="", n_missed="")
        write_csv(folder / "images" / "index.csv", reading.IMAGES_HEADER, rows)
        self.assert_text(self.make(folder), "gms on vgg/boat 1-2: failure: no counts (F 0.036) while usac")

    def test_time_by_stage(self):
        row = self.cells("Wall time by stage", "vgg")
        self.assertEqual(
            (row["Pairs"], row["bag"], row["read"], row["all"]), ("2", "2.0 s", "3.0 s", "17.0 s")
        )
        self.assertEqual(self.cells("Wall time by stage", "scaling")["all"], "7.0 s")
        self.assertEqual(self.cells("Wall time by stage", "all")["all"], "39.0 s")
        texts = [stages.duration(s) for s in (0, 1e-5, 0.25, 12, 119.6, 7200)]
        self.assertEqual(texts, ["0 s", "<1 ms", "0.250 s", "12.0 s", "2 min 00 s", "2 h 00 min"])

    def test_every_figure_is_written_and_every_link_leads_somewhere(self):
        links = [v for v in self.page.links if not v.startswith("#")]
        self.assertEqual([v for v in links if not (self.folder / v).is_file()], [])
        plots = sum(1 for tag, a in self.page.tags if tag == "svg" and a.get("class") == "plot")
        files = [p.name for p in (self.folder / "figures").iterdir()]
        self.assertEqual(
            sorted(f[:-3] for f in files if f.endswith("svg")),
            sorted(f[:-3] for f in files if f.endswith("png")),
        )
        self.assertEqual(len(files), 2 * plots)
        self.assertTrue(
            {"overall_vgg_f.svg", "preselected_vgg_f.png", "features_vgg_orb+orb_f.svg"} <= set(files)
        )
        for name in ("pairs.csv", "summary.csv", "scaling.csv", "stages.csv", "images/index.csv"):
            self.assertIn(name, links)

    def test_identifiers_are_unique(self):
        self.assertEqual(len(self.page.ids), len(set(self.page.ids)))
        self.assertEqual({v[1:] for v in self.page.links if v.startswith("#")} - set(self.page.ids), set())

    def test_evil_names_stay_text_and_inside_the_folder(self):
        folder = Path(tempfile.mkdtemp(dir=self.temporary.name)) / "run"
        folder.mkdir()
        write_run(folder, vgg=EVIL, boat="../" + EVIL)
        for name in ("summary.csv", "pairs.csv", "scaling.csv", "images/index.csv"):
            rows = read_pairs(folder / name) if name == "pairs.csv" else read_csv(folder / name)
            for row in rows:
                if row["selector"] == "gms":
                    row["selector"] = EVIL
            if name == "pairs.csv":
                write_pairs(folder / name, rows)
            else:
                write_csv(folder / name, rows[0].keys(), rows)
        stage_rows = read_csv(folder / "stages.csv") + [
            dict(stage=EVIL, seconds=1),
            dict(stage=EVIL, dataset=EVIL, seconds=1),
        ]
        write_csv(folder / "stages.csv", reading.STAGES_HEADER, stage_rows)
        state = {
            "shard": EVIL,
            "left_out_datasets": [{"dataset": EVIL, "reason": EVIL}],
            "peak_memory_mib": EVIL,
        }
        (folder / "summary.json").write_text(json.dumps({"state": state}))
        config = "experiment: '%s'\nsections: [%s, \"%s\"]\n" % (
            EVIL.replace("'", "''"),
            ", ".join(SECTIONS),
            EVIL.replace('"', '\\"'),
        )
        (folder / "config.yaml").write_text(config + "cells: [hessian_affine+sift/none]\n")
        text = self.make(folder, files=True)
        self.assertNotIn("<b>vil", text)
        self.assert_text(text, "&lt;b&gt;vil&lt;/b&gt;, &#34;x&#34;")
        names = [p.name for p in (folder / "figures").iterdir()]
        self.assertEqual([n for n in names if not re.fullmatch(r"[a-z0-9_+-]+\.(png|svg)", n)], [])
        self.assertEqual({p.name for p in folder.parent.iterdir()}, {"run"})
        links = [v for v in Page(text).links if not v.startswith("#")]
        self.assertEqual([v for v in links if ".." in v or not (folder / v).is_file()], [])

    def test_safe_names(self):
        self.assertEqual(safe_name("overall", "vgg", "f"), "overall_vgg_f")
        self.assertEqual(safe_name("../../etc/passwd"), "etc_passwd")
        self.assertEqual(safe_name("..", "/"), "figure")
        self.assertEqual(len(safe_name("x" * 500)), 100)

    def test_config_values(self):
        found = reading.config_values(
            'experiment: ""\nsections: [a, \'b, c\', "d\\"e"]\nempty: []\nmap:\n  nested: 1\nlines: [f,\n  g]\nseed: 7\n'
        )
        self.assertEqual(found["sections"], ["a", "b, c", 'd"e'])
        self.assertEqual((found["empty"], found["lines"], found["seed"]), ([], ["f", "g"], "7"))
        self.assertNotIn("nested", found)


class SelectorsTest(unittest.TestCase):
    """Order, groups and styles of selectors."""

    names = [name for group in selectors.GROUPS.values() for name in group]

    def test_order_is_that_of_the_groups(self):
        mixed = ["keep_all", "package/Class", "planes", "auto", "lpm", "lpm:v2", "adalam", "usac", "acransac"]
        self.assertEqual(
            sorted(mixed, key=selectors.selector_key),
            ["usac", "lpm", "lpm:v2", "acransac", "adalam", "planes", "auto", "package/Class", "keep_all"],
        )
        self.assertEqual(sorted(reversed(self.names), key=selectors.selector_key), self.names)

    def test_few_selectors_are_one_part_without_title(self):
        names = selectors.GROUPS["paper"] + ["auto", "keep_all"]
        self.assertEqual(selectors.parts(names), [("", names, [])])

    def test_many_selectors_are_parts_of_whole_groups(self):
        names = self.names[:-1] + ["package/Class", "keep_all"]
        found = selectors.parts(names)
        shown = [name for part in found for name in part.names[:-1]]
        self.assertEqual(shown, names[:-1])
        for part in found:
            competing = part.names[:-1]
            self.assertEqual(part.names[-1], "keep_all")
            groups = list(dict.fromkeys(map(selectors.group_of_selector, competing)))
            self.assertEqual(re.sub(r" \(\d of \d\)", "", part.title), ", ".join(groups))
            self.assertLessEqual(len(competing), selectors.PART, part.title)
            self.assertEqual(set(part.others), set(names[:-1]) - set(competing))
        self.assertEqual(selectors.group_of_selector("package/Class"), "other packages")

    def test_selectors_of_one_figure_differ_in_style(self):
        for names in (self.names, self.names[:8] + ["auto", "lpm:v2", "keep_all"]):
            styles = selectors.selector_styles(names)
            self.assertEqual(set(styles), set(names))
            for part in selectors.parts(names):
                shown = {tuple(sorted((k, str(v)) for k, v in styles[name].items())) for name in part.names}
                self.assertEqual(len(shown), len(part.names), part.title)


class ManySelectorsTest(unittest.TestCase):
    """The report of a run with all selectors: groups head rows, and no figure of lines shows too many."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.names = SelectorsTest.names
        folder = Path(cls.temporary.name) / "run"
        folder.mkdir()
        levels = {name: 0.2 + 0.7 * i / len(cls.names) for i, name in enumerate(cls.names)}
        with mock.patch.dict(SELECTORS, levels, clear=True):
            write_run(folder)
        cls.text = ExperimentsTest.make(folder)
        cls.page = Page(cls.text)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def first_cells(self, caption):
        """Return the texts of the first cells of a table's rows below its head."""
        return [row[0]["text"].replace(" baseline", "") for row in self.page.table(caption)[1:]]

    def listed(self, without=()):
        """Return names of groups and selectors as a table lists them."""
        out = []
        for group, names in selectors.GROUPS.items():
            out += [group] * (group != "baseline") + [name for name in names if name not in without]
        return out

    def test_rows_are_grouped(self):
        for caption in (
            "Means over the pairs of vgg",
            "F pair by pair on vgg",
            "Selection time in ms",
            "Mean F of every selector on every dataset",
            "Mean F behind the verdicts",
        ):
            self.assertEqual(self.first_cells(caption), self.listed(), caption)

    def test_selectors_are_rows_where_they_were_columns(self):
        rows = self.page.table("Mean F of every selector on every dataset")
        self.assertEqual([cell["text"][:3] for cell in rows[0]], ["", "vgg", "hei", "ade"])
        row = next(row for row in rows if row[0]["text"] == "gms")
        self.assertEqual(len(row), len(rows[0]))

    def test_no_figure_of_lines_shows_too_many(self):
        legends = re.findall(r'<ul class="legend">(.*?)</ul>', self.text, flags=re.S)
        counts = [len(re.findall("<li>", legend)) for legend in legends]
        self.assertTrue(counts and max(counts) <= selectors.PART + 1, counts)


if __name__ == "__main__":
    unittest.main()
