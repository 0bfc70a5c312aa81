#!/usr/bin/env python3
"""Tests of the guide and of what it rests on: python3 test_guide.py"""
import contextlib
import csv
import io
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

PROJECT = Path(__file__).resolve().parents[2]
PAPER = PROJECT.parent / "shared" / "paper" / "comparative_evaluation_2d_correspondence_selection.tex"
sys.dont_write_bytecode = True
from corrsel.report import (
    __main__ as command,
    efficiency,
    guide,
    inference,
    paper,
    robustness,
    tables,
)  # noqa: E402
from corrsel.report.figures import FigureWriter, set_up_figures  # noqa: E402
from corrsel.report.groups import GROUPS  # noqa: E402
from corrsel.report.reading import SCALING_HEADER, read_run  # noqa: E402
from test_report import write_csv, write_pairs  # noqa: E402

EVIL = '<script>alert("x")</script>&\'$a$'
DEFAULT = paper.FEATURES_DEFAULT
SCENES = [case.scene for case in paper.ROBUSTNESS.values()]
WIGGLE = (0.02, -0.01, 0.03, -0.02, -0.02)  # from pair to pair, the same for all selectors


def pair_rows(
    dataset, sequence, levels, features=DEFAULT, preselection="none", pairs=5, tau=5, generated=None
):
    """Return rows of pairs.csv: selector -> F of its pairs, a number (plus WIGGLE), a list, or None = unsupported."""
    rows = []
    for selector, level in levels.items():
        for i in range(pairs):
            row = dict(dataset=dataset, sequence=sequence, pair="1-%d" % (i + 2), features=features)
            row.update(preselection=preselection, selector=selector, tau_px=tau, n_putative=1000, seed=0)
            row.update(n_ground_truth=400, n_selected=500, n_correct=300, status="ok", select_s=1e-3)
            if level is None:
                row.update(status="unsupported_input", n_selected="", n_correct="", select_s="")
            else:
                f = level[i] if isinstance(level, list) else level + WIGGLE[i % 5] if level else 0
                row.update(f_paper=f, recall_paper=f, precision=f if f else "", n_correct=300 if f else 0)
            rows.append(row)
    return rows


def scaling_rows(seconds, threads="1", rounds=10, status="ok"):
    """Return rows of scaling.csv: selector -> (time at N = 1000, exponent)."""
    rows = []
    for selector, (start, exponent) in seconds.items():
        for n in (1000, 2000, 5000):
            for i in range(rounds):
                time = start * (n / 1000.0) ** exponent * (1 + 0.01 * (i % 3))
                rows.append(dict(zip(SCALING_HEADER, (selector, threads, n, i, n // 2, status, time))))
    return rows


def table_rows(text, label, before=False):
    """Return the lines of numbers of the paper's table with a label, bold face removed."""
    at = text.index(r"\label{%s}" % label)
    start = text.rindex(r"\begin{tabular}", 0, at) if before else at
    body = text[start : text.index(r"\end{tabular}", start)]
    body = re.sub(r"\\textbf\{([^}]*)\}", r"\1", body)
    rows = []
    for line in body.split(r"\\"):
        numbers = [float(cell) for cell in line.split("&") if re.fullmatch(r"\s*\d+(\.\d+)?\s*", cell)]
        if len(numbers) > 1:
            rows.append(tuple(numbers))
    return rows


class InferenceTest(unittest.TestCase):
    """Against values made by hand."""

    def test_ranks_share_their_mean_where_values_are_equal(self):
        self.assertEqual(list(inference.average_ranks([10, 20, 20, 5])), [2, 3.5, 3.5, 1])
        self.assertEqual(list(inference.average_ranks([7, 7, 7])), [2, 2, 2])

    def test_rank_correlation(self):
        # Ranks 1..5 against 1 2 3.5 5 3.5: 8 / sqrt(10 * 9.5).
        self.assertAlmostEqual(inference.spearman([1, 2, 3, 4, 5], [5, 6, 7, 8, 7]), 8 / math.sqrt(95), 12)
        self.assertAlmostEqual(inference.spearman([1, 2, 3], [30, 20, 10]), -1, 12)
        self.assertAlmostEqual(inference.spearman([1, 2, 3, 4], [2, 1, 4, 3]), 1 - 6 * 4 / (4 * 15), 12)

    def test_rank_correlation_that_is_undefined(self):
        for first, second in (([], []), ([1], [2]), ([1, 2], [3, 3])):
            self.assertIsNone(inference.spearman(first, second))
        with self.assertRaises(ValueError):
            inference.spearman([1, 2], [1])

    def test_interval_of_values_that_leave_no_choice(self):
        self.assertEqual(inference.mean_interval([0.25]), (0.25, 0.25, 0.25, 1))
        self.assertEqual(inference.mean_interval([0.5] * 7), (0.5, 0.5, 0.5, 7))

    def test_interval_of_two_values(self):
        # Means 0, 1/2 and 1 come with probabilities 1/4, 1/2 and 1/4: more than 2.5 % at either end.
        self.assertEqual(inference.mean_interval([0, 1]), (0.5, 0, 1, 2))

    def test_interval_against_the_normal_one(self):
        values = np.arange(100) / 100.0
        estimate = inference.mean_interval(values)
        half = 1.96 * values.std() / 10
        self.assertAlmostEqual(estimate.low, values.mean() - half, delta=0.1 * half)
        self.assertAlmostEqual(estimate.high, values.mean() + half, delta=0.1 * half)

    def test_interval_repeats_itself(self):
        values = [0.1, 0.4, 0.35, 0.8, 0.9]
        first = inference.mean_interval(values)
        inference.mean_interval([3, 1, 2])
        self.assertEqual(first, inference.mean_interval(values))
        self.assertTrue(first.low < first.mean < first.high)

    def test_missing_binding_is_named(self):
        with mock.patch.dict(sys.modules, {"corrsel.evaluation": None}):
            with self.assertRaisesRegex(tables.ReportError, "corrsel._core.*Remedy.*pybind11-dev"):
                inference.mean_interval([1.0, 2.0])

    def test_pairs_are_compared_pair_by_pair(self):
        spread = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
        difference = inference.paired_difference(spread + 0.01, spread)
        self.assertTrue(inference.is_above(difference) and inference.is_separate(difference))
        reverse = inference.paired_difference(spread, spread + 0.01)
        self.assertTrue(inference.is_separate(reverse) and not inference.is_above(reverse))
        self.assertFalse(inference.is_separate(inference.paired_difference(spread, spread)))
        self.assertFalse(inference.is_separate(inference.paired_difference(spread, spread[::-1])))

    def test_wrong_sizes_are_refused(self):
        with self.assertRaises(ValueError):
            inference.mean_interval([])
        with self.assertRaises(ValueError):
            inference.paired_difference([1, 2], [1])


class PaperTest(unittest.TestCase):
    """The paper's numbers: complete, and equal to its source where that is at hand."""

    def test_is_complete(self):
        self.assertEqual(list(paper.DATASET_PAIRS.values()), [40, 46, 29, 38])
        self.assertEqual([len(v) for v in paper.ADELAIDE.values()], [6, 6, 6])
        self.assertEqual([len(v) for v in paper.PRESELECTED.values()], [7, 7])
        self.assertEqual([len(v) for v in paper.FEATURES.values()], [7] * 8)
        self.assertEqual(len(paper.ROBUSTNESS), 8)
        for case in paper.ROBUSTNESS.values():
            self.assertEqual(
                [list(v) for v in (case.precision, case.recall, case.f)], [list(paper.SELECTORS)] * 3
            )
        self.assertEqual(len(paper.GUIDE), 17)
        names = {s for a in paper.GUIDE.values() for s in a.superior + a.inferior}
        self.assertLessEqual(names, set(paper.SELECTORS))

    def test_some_entries(self):
        self.assertEqual(paper.ADELAIDE["f"]["vfc"], 91.63)
        self.assertEqual(paper.PRESELECTED["heinly"]["lpm"], 97.27)
        self.assertEqual(paper.FEATURES[("blob+freak", "symbench")]["gms"], 0.50)
        self.assertEqual(paper.ROBUSTNESS["case6"].f["gms"], 50.80)
        self.assertEqual(paper.ROBUSTNESS["case5"].recall["usac"], 100)
        self.assertEqual(paper.GUIDE["blur"].superior, ("nnsr", "gms"))
        self.assertEqual(paper.SYMBENCH_INLIER_RATIO_BELOW, 10)

    def test_scenes_are_in_alphabetical_order(self):
        self.assertEqual(SCENES, sorted(SCENES))

    @unittest.skipUnless(PAPER.is_file(), "the paper's source is not here: %s" % PAPER)
    def test_equals_the_source(self):
        source = PAPER.read_text(encoding="utf-8", errors="replace")
        same = self.assertEqual
        same(table_rows(source, "tab:ade", True), [tuple(v.values()) for v in paper.ADELAIDE.values()])
        same(table_rows(source, "tab:select", True), [tuple(v.values()) for v in paper.PRESELECTED.values()])
        same(table_rows(source, "tab:fea"), [tuple(v.values()) for v in paper.FEATURES.values()])
        expected = [
            tuple(column.values())
            for case in paper.ROBUSTNESS.values()
            for column in (case.precision, case.recall, case.f)
        ]
        same(table_rows(source, "tab:rob"), expected)
        nuisances = re.findall(r"Case\d & .*?\((.*?)\) &", source, flags=re.S)
        same(nuisances, [case.nuisance for case in paper.ROBUSTNESS.values()])
        at = source.index(r"\label{tab:sum}")
        body = source[at : source.index(r"\end{tabular}", at)]
        found = []
        for line in body.split(r"\\")[1:]:
            cells = [c.strip() for c in line.split("&")]
            if len(cells) >= 3:
                found.append(tuple(tuple(c.replace(" ", "").lower().split(",")) for c in cells[-2:]))
        same(found, [(a.superior, a.inferior) for a in paper.GUIDE.values()])


class RunTest(unittest.TestCase):
    """Each test has a separate run folder."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name) / "run"
        self.folder.mkdir()

    def run_of(self, rows, scaling=None):
        """Write the files of a run and read it."""
        write_pairs(self.folder / "pairs.csv", rows)
        if scaling is not None:
            write_csv(self.folder / "scaling.csv", SCALING_HEADER, scaling)
        return read_run(self.folder)

    def guide_of(self, rows, scaling=None):
        """Return scenario -> Row of the guide of a run."""
        return {row.key: row for row in guide.derive(self.run_of(rows, scaling))}

    def section(self, module, rows, scaling=None):
        """Return the HTML of a section of the report."""
        set_up_figures()
        return module.html(self.run_of(rows, scaling), FigureWriter())

    def call(self, *arguments):
        """Run the command in this process; return exit status, standard output and error output."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = command.main(["--guide", "--no-page", *map(str, arguments or (self.folder,))])
        return status, out.getvalue(), err.getvalue()

    def csv_of(self):
        """Return scenario -> row of guide.csv."""
        with (self.folder / "guide.csv").open(newline="") as stream:
            return {row["scenario"]: row for row in csv.DictReader(stream)}


SYMBENCH = {
    "gms": 0.8,
    "usac": [0.9, 0.7, 0.9, 0.7, 0.8],  # the same mean as gms, now above, now below
    "vfc": 0.6,
    "ransac": 0.3,
    "lpm": [0.2, 0.4, 0.2, 0.4, 0.3],
    "keep_all": 0.3,
}


class GuideTest(RunTest):
    """Verdicts known by construction."""

    def test_verdict_of_a_dataset(self):
        row = self.guide_of(pair_rows("symbench", "a", SYMBENCH))["symbench"]
        self.assertEqual(set(row.verdict.superior), {"gms", "usac"})
        self.assertEqual(set(row.verdict.inferior), {"ransac", "lpm"})
        self.assertEqual(row.verdict.open, [])
        self.assertEqual(row.measured.count, 5)

    def test_agreement_with_the_paper(self):
        # The paper: superior gms; inferior st, usac.
        row = self.guide_of(pair_rows("symbench", "a", SYMBENCH))["symbench"]
        self.assertEqual(row.agreement.superior, {"gms": guide.CONFIRMED})
        self.assertEqual(row.agreement.inferior, {"st": guide.UNMEASURED, "usac": guide.CONTRADICTED})
        self.assertEqual(row.agreement.also_superior, ["usac"])
        self.assertEqual(set(row.agreement.also_inferior), {"ransac", "lpm"})
        levels = dict(SYMBENCH, gms=0.6, usac=0.6)
        row = self.guide_of(pair_rows("symbench", "a", dict(levels, vfc=0.8)))["symbench"]
        self.assertEqual(row.agreement.superior, {"gms": guide.UNCONFIRMED})

    def test_sets_that_cannot_be_told_apart(self):
        noise = {
            "gms": [0.1, 0.9, 0.2, 0.8, 0.5],
            "usac": [0.9, 0.1, 0.8, 0.2, 0.5],
            "st": [0.5, 0.4, 0.6, 0.5, 0.5],
        }
        row = self.guide_of(pair_rows("symbench", "a", noise))["symbench"]
        self.assertEqual((row.verdict.superior, row.verdict.inferior), ([], []))
        self.assertEqual(set(row.verdict.open), {"gms", "usac", "st"})
        self.assertEqual(set(row.agreement.inferior.values()), {guide.OPEN})

    def test_a_selector_between_best_and_worst_that_no_pair_places(self):
        levels = {
            "gms": [0.7, 0.7, 0.7, 0.7, 0.7],
            "vfc": [0.9, 0.1, 0.9, 0.1, 0.5],
            "st": [0.3, 0.3, 0.3, 0.3, 0.3],
        }
        row = self.guide_of(pair_rows("symbench", "a", levels))["symbench"]
        self.assertEqual(row.verdict, (["gms"], ["st"], ["vfc"]))

    def choice_of(self, rows, seconds):
        """Return the only choice of a run whose selectors take the given times, s."""
        (choice,) = guide.choices(self.run_of([dict(row, select_s=seconds[row["selector"]]) for row in rows]))
        return choice

    def test_choice_among_all_selectors(self):
        """Best, those that tie with it, the fastest of these, and faster ones that are worth their time."""
        levels = dict(SYMBENCH, nnsr=0.5, st=0.4, gms=0.801)  # barely the best
        seconds = dict(gms=4e-3, usac=2e-3, vfc=1e-3, nnsr=1e-4, st=5e-4, ransac=1e-5, lpm=1e-5, keep_all=0)
        choice = self.choice_of(pair_rows("symbench", "a", levels), seconds)
        self.assertEqual((choice.superior, choice.fastest, choice.count), (["gms", "usac"], "usac", 5))
        # st is slower than nnsr and worse; ransac and lpm are no better than keep_all.
        self.assertEqual(choice.front, ["vfc", "nnsr"])
        self.assertTrue(choice.best.low <= choice.means["gms"] <= choice.best.high)
        cells = guide.choice_cells(choice)
        self.assertEqual(
            cells[3:], ["usac 0.800", "usac 0.800 (2.00 ms)", "vfc 0.600 (1.00 ms), nnsr 0.500 (0.100 ms)"]
        )

    def test_choice_as_markdown(self):
        self.run_of(pair_rows("symbench", "a", dict(SYMBENCH, **{"lpm:v2": 0.82})))
        before = sorted(os.listdir(str(self.folder)))
        status, text, _ = self.call("--choices", self.folder)
        lines = text.splitlines()
        self.assertEqual((status, len(lines)), (0, 3))
        self.assertIn("| `lpm:v2` 0.820 (", lines[2])
        self.assertEqual({line.count("|") for line in lines}, {7})
        self.assertEqual(sorted(os.listdir(str(self.folder))), before)

    def test_a_selector_with_few_results_does_not_decide_on_the_pairs(self):
        """One with results on most pairs does; both are named."""
        rows = pair_rows("symbench", "a", {"gms": 0.8, "st": 0.2, "vfc": 0.5, "lpm": 0.4}, pairs=12)
        few = [row for row in rows if row["selector"] == "vfc"][2:]
        some = [row for row in rows if row["selector"] == "lpm"][:2]
        for row in few[3:] + some:
            row.update(status="unsupported_input")
        row = self.guide_of(rows)["symbench"]
        self.assertEqual((row.measured.count, list(row.measured.values)), (10, ["st", "gms", "lpm"]))
        self.assertIn("vfc is left out: it has results on 5 of 12 pairs", row.remarks)
        self.assertIn("compared on 10 of 12 pairs, because lpm has no result on the others", row.remarks)

    def test_all_selectors_are_recommended_alike(self):
        """Selectors outside the paper can be superior and inferior, and ties are kept with many of them."""
        names = [name for names in GROUPS.values() for name in names if name != "keep_all"]
        levels = {name: 0.3 for name in names}
        levels.update({name: SYMBENCH["usac"] for name in ("planes", "significant")}, adalam=0.8, icf=0.1)
        row = self.guide_of(pair_rows("symbench", "a", levels))["symbench"]
        self.assertEqual(set(row.verdict.superior), {"planes", "significant", "adalam"})
        self.assertEqual(row.verdict.inferior, ["icf"])
        (choice,) = guide.choices(self.run_of(pair_rows("symbench", "a", levels)))
        self.assertEqual(set(choice.superior), set(row.verdict.superior))

    def test_too_few_pairs_decide_nothing(self):
        row = self.guide_of(pair_rows("symbench", "a", {"gms": 0.9, "st": 0.1}, pairs=4))["symbench"]
        self.assertEqual((row.verdict.superior, row.verdict.inferior), ([], []))
        self.assertIn("4 pairs: too few to decide", row.remarks)

    def test_one_selector_is_not_compared(self):
        row = self.guide_of(pair_rows("symbench", "a", {"gms": 0.9}))["symbench"]
        self.assertEqual(row.verdict, ([], [], ["gms"]))

    def test_presets_take_part_but_are_not_compared_with_the_paper(self):
        levels = dict(SYMBENCH, **{"lpm:v2": 0.95})
        row = self.guide_of(pair_rows("symbench", "a", levels))["symbench"]
        self.assertEqual(row.verdict.superior, ["lpm:v2"])
        self.assertEqual(row.agreement.superior, {"gms": guide.CONFIRMED})

    def test_baseline_takes_no_part(self):
        row = self.guide_of(pair_rows("symbench", "a", dict(SYMBENCH, keep_all=0.99)))["symbench"]
        self.assertNotIn("keep_all", row.verdict.superior + row.verdict.inferior + row.verdict.open)
        self.assertIn("not better than keeping everything: ", row.remarks[-1])
        self.assertEqual(set(row.remarks[-1].split(": ")[1].split()), set(SYMBENCH) - {"keep_all"})
        row = self.guide_of(pair_rows("symbench", "a", SYMBENCH))["symbench"]
        self.assertEqual(set(row.remarks[-1].split(": ")[1].split()), {"ransac", "lpm"})

    def test_unsupported_selectors_are_not_measured(self):
        levels = {"vfc": 0.9, "lpm": 0.9, "st": 0.2, "nnsr": None, "ransac": None}
        row = self.guide_of(pair_rows("adelaidermf", "a", levels, "given", tau=""))["adelaidermf"]
        self.assertEqual(row.agreement.superior, {"vfc": guide.CONFIRMED, "lpm": guide.CONFIRMED})
        self.assertEqual(row.agreement.inferior, {"st": guide.CONFIRMED, "ransac": guide.UNMEASURED})
        self.assertIn("5 pairs here, 38 in the paper", row.remarks)

    def test_reconstructed_data_do_not_stand_in(self):
        rows = pair_rows("adelaidermf_reconstructed", "a", {"vfc": 0.9, "st": 0.2}, "given", tau="")
        self.assertIsNone(self.guide_of(rows)["adelaidermf"].measured)

    def test_robustness_joins_the_cases_of_a_nuisance(self):
        rows = []
        for scene in SCENES:
            best = "usac" if scene in ("bark", "boat") else "vfc"
            rows += pair_rows("vgg", scene, {"usac": 0.5, "vfc": 0.5, "st": 0.1, best: 0.9})
        found = self.guide_of(rows)
        self.assertEqual(found["zoom_and_rotation"].verdict.superior, ["usac"])
        self.assertEqual(found["zoom_and_rotation"].measured.count, 10)
        self.assertEqual(found["blur"].verdict.superior, ["vfc"])
        self.assertEqual(found["light_change"].measured.count, 5)
        self.assertEqual(found["vgg"].measured.count, 40)
        self.assertEqual(found["vgg"].verdict.inferior, ["st"])

    def test_generated_data_are_marked_and_counted_apart(self):
        rows = pair_rows("symbench", "a", SYMBENCH)
        rows += pair_rows("heinly_generated", "a", {"ransac": 0.9, "st": 0.1})
        rows += pair_rows("sample", "blur_1", {"nnsr": 0.9, "st": 0.1})
        found = self.guide_of(rows)
        self.assertTrue(found["heinly"].measured.generated and found["blur"].measured.generated)
        self.assertIn("generated data", found["heinly"].remarks[0])
        rows = list(found.values())
        self.assertEqual(guide.counts(rows, "superior", True)[guide.CONFIRMED], 2)
        self.assertEqual(guide.counts(rows, "superior", False)[guide.CONFIRMED], 1 + 0)
        rows = pair_rows("heinly", "a", {"ransac": 0.9, "st": 0.1})
        rows += pair_rows("heinly_generated", "a", {"ransac": 0.1, "st": 0.9})
        row = self.guide_of(rows)["heinly"]
        self.assertFalse(row.measured.generated)
        self.assertEqual(row.verdict.superior, ["ransac"])

    def test_preselected_and_other_features_are_scenarios_of_their_own(self):
        rows = pair_rows("vgg", "a", {"usac": 0.9, "st": 0.1}, preselection="nnsr")
        rows += pair_rows("vgg", "a", {"lpm": 0.9, "vfc": 0.1}, "orb+orb")
        found = self.guide_of(rows)
        self.assertIsNone(found["vgg"].measured)
        self.assertEqual(found["nnsr_vgg"].verdict.superior, ["usac"])
        self.assertEqual(found["orb+orb"].agreement.superior["lpm"], guide.CONFIRMED)
        self.assertIn("measured on vgg", found["orb+orb"].remarks[0])

    def test_pairs_that_a_selector_lacks_are_left_out_for_all(self):
        rows = pair_rows("symbench", "a", {"gms": 0.9}, pairs=7) + pair_rows(
            "symbench", "a", {"st": 0.1}, pairs=6
        )
        self.assertEqual(self.guide_of(rows)["symbench"].measured.count, 6)

    def test_another_tolerance_is_named(self):
        row = self.guide_of(pair_rows("symbench", "a", SYMBENCH, tau=3))["symbench"]
        self.assertIn("at 3 px, the run has no tolerance of 5 px", row.remarks)

    def test_efficiency_from_scaling(self):
        seconds = {"gms": (2e-4, 1), "nnsr": (1e-4, 1), "lpm": (5e-3, 1), "st": (0.1, 2), "gtm": (0.05, 2)}
        seconds["keep_all"] = (1e-9, 1)
        row = self.guide_of(pair_rows("vgg", "bark", {"st": 0.1, "gms": 0.2}), scaling_rows(seconds))[
            "efficiency"
        ]
        self.assertEqual(row.verdict, (["nnsr", "gms"], ["st", "gtm"], []))
        self.assertEqual(
            set(row.agreement.superior.values()) | set(row.agreement.inferior.values()), {guide.CONFIRMED}
        )
        self.assertEqual(row.remarks, ["N = 5000, 1 thread, 10 rounds"])

    def test_efficiency_leaves_out_calls_that_did_no_work(self):
        rows = scaling_rows({"gms": (2e-4, 1), "gtm": (0.05, 2)}) + scaling_rows(
            {"st": (1e-7, 0)}, status="too_large"
        )
        row = self.guide_of([], rows)["efficiency"]
        self.assertEqual(row.verdict, (["gms"], ["gtm"], []))
        self.assertEqual(row.agreement.inferior["st"], guide.UNMEASURED)

    def test_efficiency_from_pairs(self):
        rows = pair_rows("vgg", "bark", {"gms": 0.5, "lpm": 0.5, "st": 0.5})
        for row in rows:
            row["select_s"] = {"gms": 1e-4, "lpm": 5e-3, "st": 1.0}[row["selector"]]
        row = self.guide_of(rows)["efficiency"]
        self.assertEqual(row.verdict, (["gms"], ["st"], []))
        self.assertIn("no scaling.csv", row.remarks[0])

    def test_the_command(self):
        scaling = scaling_rows({"gms": (2e-4, 1), "nnsr": (1e-4, 1), "st": (0.1, 2), "gtm": (0.05, 2)})
        self.run_of(pair_rows("symbench", "a", dict(SYMBENCH, st=0.3)), scaling)
        status, out, err = self.call()
        self.assertEqual((status, err), (0, ""))
        self.assertLessEqual(max(len(line) for line in out.splitlines()), 110)
        self.assertRegex(out, r"Symbench +5 \[1\] +(gms usac|usac gms) ")
        self.assertIn("+gms", out)
        self.assertIn("-usac", out)
        self.assertIn("+gms +nnsr", out)
        self.assertEqual(out.count(" not measured  "), 15)
        self.assertIn("of its 3 superior entries 3 confirmed", out)
        rows = self.csv_of()
        self.assertEqual(list(rows), list(paper.GUIDE))
        self.assertEqual(list(rows["vgg"]), guide.GUIDE_HEADER)
        self.assertEqual(rows["vgg"]["agreement"], "not measured")
        self.assertEqual((rows["vgg"]["pairs"], rows["vgg"]["paper_superior"]), ("0", "usac ransac vfc"))
        self.assertEqual(rows["efficiency"]["superior"], "nnsr gms")
        self.assertIn("inferior contradicted: usac", rows["symbench"]["agreement"])
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"pairs.csv", "scaling.csv", "guide.csv"})

    def test_same_folder_same_bytes(self):
        self.run_of(pair_rows("symbench", "a", SYMBENCH))
        first = self.call()[1]
        written = (self.folder / "guide.csv").read_bytes()
        environment = dict(os.environ, PYTHONHASHSEED="12345", LC_ALL="C")
        arguments = [sys.executable, "-B", "-m", "corrsel.report", "--guide", "--no-page", str(self.folder)]
        done = subprocess.run(arguments, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        self.assertEqual(done.stdout.decode(), first)
        self.assertEqual((self.folder / "guide.csv").read_bytes(), written)

    def test_unusable_input(self):
        for folder in (self.folder, self.folder / "nowhere"):
            status, out, err = self.call(folder)
            self.assertEqual((status, out), (2, ""))
            self.assertIn(str(folder), err)
            self.assertIn("Remedy", err)
        (self.folder / "pairs.csv").write_text("a,b\n1,2\n")
        status, _, err = self.call()
        self.assertEqual(status, 2)
        self.assertIn("the first line is not '# corrsel pairs 2'", err)

    def test_guide_that_cannot_be_written(self):
        self.run_of(pair_rows("symbench", "a", SYMBENCH))
        (self.folder / "guide.csv").mkdir()
        status, _, err = self.call()
        self.assertEqual(status, 2)
        self.assertIn("guide.csv", err)
        self.assertEqual([p for p in self.folder.iterdir() if p.name.endswith(".tmp")], [])

    def test_no_pairs(self):
        self.run_of([])
        status, out, _ = self.call()
        self.assertEqual(status, 0)
        self.assertEqual(set(row["agreement"] for row in self.csv_of().values()), {"not measured"})
        self.assertIn("Not measured in this run: Datasets, VGG", out)
        self.assertIn("not measured", self.section(guide, []))

    def test_section(self):
        rows = pair_rows("symbench", "a", SYMBENCH) + pair_rows(
            "heinly_generated", "a", {"lpm": 0.9, "st": 0.1}
        )
        text = self.section(guide, rows)
        for part in (
            "How to read",
            "Table V",
            "contradicted",
            "generated data",
            "<summary>Rule</summary>",
            "keep_all is not rated",
        ):
            self.assertIn(part, text)
        self.assertIn("<b>", text)

    def test_names_are_escaped(self):
        levels = {EVIL: 0.9, "gms": 0.9, "st": 0.1, "keep_all": 0.95}
        rows = pair_rows("symbench", EVIL, levels)
        for scene in SCENES:
            rows += pair_rows("vgg", scene, levels)
        scaling = scaling_rows({EVIL: (1e-3, 1), "gms": (1e-4, 1)}) + scaling_rows({EVIL: (1e-3, 1)}, EVIL)
        scaling += scaling_rows({EVIL: (1e-3, 1)}, status="too_large")
        for module in (guide, robustness, efficiency):
            text = self.section(module, rows, scaling)
            self.assertNotIn("<script", text)
            self.assertIn("&lt;script&gt;", text)
        status, out, _ = self.call()
        self.assertEqual(status, 0)
        self.assertIn(EVIL, self.csv_of()["symbench"]["superior"])


class RobustnessTest(RunTest):
    """The eight cases."""

    def rows(self, levels, dataset="vgg", sequences=SCENES, **options):
        """Return the rows of a run in which every case has the same values."""
        return [row for s in sequences for row in pair_rows(dataset, s, levels, **options)]

    def test_every_case_has_a_table_with_the_papers_numbers(self):
        text = self.section(robustness, self.rows({"usac": 0.8, "st": 0.1, "keep_all": 0.3}))
        for name, case in paper.ROBUSTNESS.items():
            self.assertIn("%s, %s: means over 5 pairs" % (name, case.scene), text)
        self.assertIn("0.845", text)  # the paper's F of usac in case 1
        self.assertEqual(text.count("<svg"), 8)
        self.assertIn("in 4 of 8 cases", text)  # usac leads here in all, there in cases 1, 5, 7 and 8

    def test_reason_names_what_changed(self):
        levels = {"usac": 0.8, "nnsr": [0.71, 0.72, 0, 0.72, 0.73], "st": 0.1, "keep_all": 0.3}
        run = self.run_of(self.rows(levels))
        cases = {r.case.name: r for r in robustness.results(run, robustness.unselected_group(run, "vgg"))}
        self.assertEqual(robustness.why_html(cases["case1"]), "")
        text = re.sub("<[^>]*>", "", robustness.why_html(cases["case2"]))
        self.assertIn("case2 (bikes, blur): usac has the highest F here, nnsr in the paper", text)
        self.assertIn("usac is further from its printed F, 0.800 here and 0.543 there", text)
        self.assertIn("in recall (0.900 against 0.600)", text)
        self.assertIn("its printed recall, 60.00 %, is what recall 1 on 3 of 5 pairs", text)
        self.assertIn("nnsr has 0.576 against 0.719; nnsr has nothing correct on 1 of 5 pairs", text)
        self.assertIn("40.0 % of the putative matches lie within 10 px", text)
        text = re.sub("<[^>]*>", "", robustness.why_html(cases["case3"]))
        self.assertIn("ransac has no result in this run", text)

    def test_reason_says_when_pairs_do_not_separate(self):
        levels = {"usac": [0.9, 0.5, 0.9, 0.5, 0.8], "nnsr": [0.6, 0.8, 0.6, 0.8, 0.7]}
        run = self.run_of(self.rows(levels))
        cases = robustness.results(run, robustness.unselected_group(run, "vgg"))
        self.assertIn("does not separate them with 5 pairs", robustness.why_html(cases[1]))

    def test_recall_of_whole_pairs(self):
        self.assertIn("2 of 5 pairs", robustness.whole_pairs_text(40.0, 5))
        for recall in (100.0, 0.0, 41.85):
            self.assertEqual(robustness.whole_pairs_text(recall, 5), "")

    def test_correlation_with_the_papers_ranking(self):
        case = paper.ROBUSTNESS["case1"]
        levels = {s: [f / 100] * 5 for s, f in case.f.items()}
        run = self.run_of(pair_rows("vgg", "bark", levels))
        (result,) = robustness.results(run, robustness.unselected_group(run, "vgg"))
        self.assertAlmostEqual(robustness.correlation(result), 1, 12)
        self.assertEqual(robustness.why_html(result), "")

    def test_generated_cases_have_no_printed_numbers(self):
        sequences = list(robustness.SAMPLE_SEQUENCES.values())
        text = self.section(robustness, self.rows({"usac": 0.8, "st": 0.1}, "sample", sequences))
        self.assertIn("Generated data.", text)
        self.assertNotIn("Paper: precision", text)
        self.assertNotIn("0.845", text)

    def test_other_features_have_no_printed_numbers(self):
        text = self.section(robustness, self.rows({"usac": 0.8, "st": 0.1}, features="orb+orb"))
        self.assertNotIn("Paper: precision", text)
        self.assertIn("so they are not shown here", text)

    def test_a_run_without_cases(self):
        self.assertIn(
            "Robustness was not measured", self.section(robustness, pair_rows("kitti", "a", {"lpm": 0.5}))
        )
        self.assertIn(
            "Robustness was not measured", self.section(robustness, pair_rows("vgg", "a", {"lpm": 0.5}))
        )

    def test_inlier_ratio(self):
        rows = pair_rows("symbench", "a", {"gms": 0.5, "keep_all": 0.2}, pairs=2)
        for row in rows:
            first = row["pair"] == "1-2"
            row.update(n_putative=1000, n_selected=1000, n_ground_truth=80 if first else 0)
            row.update(n_correct=50 if first else 0, f_paper=2 * 50 / (1000 + 80) if first else 0)
        run = self.run_of(rows)
        ratio = robustness.mean_inlier_ratio(run, "symbench", DEFAULT)
        self.assertEqual(ratio.pairs, 2)
        self.assertAlmostEqual(ratio.within_10, 0.04, 12)
        self.assertAlmostEqual(ratio.within_5, 0.025, 12)
        self.assertIsNone(robustness.mean_inlier_ratio(run, "vgg", DEFAULT))
        text = robustness.inlier_ratio_html(run)
        self.assertIn("4.0 % of the putative matches", text)
        self.assertIn("the measured ratio is below that too", text)
        run = self.run_of(pair_rows("symbench", "a", {"gms": 0.5}))
        ratio = robustness.mean_inlier_ratio(run, "symbench", DEFAULT)
        self.assertEqual((ratio.within_10, ratio.within_5), (0.4, None))
        self.assertIn("the measured ratio is above that", robustness.inlier_ratio_html(run))


class EfficiencyTest(RunTest):
    """Time against the number of matches."""

    SECONDS = {"gms": (1e-4, 1), "lpm": (1e-3, 1.5), "st": (0.02, 2), "gtm": (0.01, 2), "keep_all": (1e-9, 0)}

    def test_growth_exponent(self):
        self.assertAlmostEqual(efficiency.growth_exponent({1000: [1, 9, 1], 2000: [4], 4000: [16]}), 2, 12)
        self.assertIsNone(efficiency.growth_exponent({1000: [1.0]}))
        self.assertIsNone(efficiency.growth_exponent({1000: [0.0], 2000: [1.0]}))

    def test_section(self):
        rows = scaling_rows(self.SECONDS) + scaling_rows({"gms": (5e-5, 1), "st": (0.01, 2)}, "2")
        text = re.sub("<[^>]*>", "", self.section(efficiency, [], rows))
        self.assertIn("shows its times as curves only", text)
        self.assertIn("1 thread, N = 5000: gms is fastest", text)
        self.assertIn("slowest are st", text)
        self.assertNotIn("2 threads, N = 5000", text)
        gains = text[text.index("Selection time in ms with 2 threads") :]
        gains = gains[: gains.index("Time against F")] if "Time against F" in gains else gains
        self.assertIn("(2.00)", gains)
        self.assertIn("st", gains)
        self.assertNotIn("lpm", gains)
        self.assertIn("Selection time in ms, 1 thread: median of 10 rounds", text)
        run = read_run(self.folder)
        self.assertEqual(list(efficiency.scaling_times(run)), ["1", "2"])
        self.assertAlmostEqual(efficiency.growth_exponent(efficiency.scaling_times(run)["1"]["lpm"]), 1.5, 9)

    def test_calls_without_work_are_left_out_and_named(self):
        rows = scaling_rows({"gms": (1e-4, 1), "lpm": (1e-3, 1)}) + scaling_rows(
            {"st": (1e-7, 0)}, status="too_large"
        )
        text = re.sub("<[^>]*>", "", self.section(efficiency, [], rows))
        self.assertIn("left out: st (too large: 30)", text)
        self.assertNotIn("st is fastest", text)

    def test_missing_file(self):
        text = self.section(efficiency, pair_rows("vgg", "bark", {"gms": 0.5}))
        self.assertIn("was not measured", text)


if __name__ == "__main__":
    unittest.main()
