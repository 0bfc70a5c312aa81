#!/usr/bin/env python3
"""Tests of the report's sections on variants of selectors, budget and curves: python3 test_report_variants.py"""
import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
from corrsel.report import __main__ as report, budget, curves, reading, selectors  # noqa: E402
from corrsel.report.figures import FigureWriter  # noqa: E402
from corrsel.report.groups import GROUPS, MAIN_PARAMETERS  # noqa: E402
from corrsel.report.reading import Group  # noqa: E402
from test_report import Page, figure_files, pair_row, summary_row, write_csv, write_pairs  # noqa: E402

VGG, LABELLED = Group("vgg", "sift+sift", "none"), Group("adelaidermf", "given", "none")
PAIRS = 12


def gms(alpha):
    """Return the name of a variant of gms."""
    return "gms" if alpha == 4 else "gms[alpha=%g]" % alpha


# Precision, recall and F of the points of an operating curve; alpha = 1.5 is far better than the default.
GMS = {
    1: (0.5, 0.9, 0.64),
    1.5: (0.8, 0.8, 0.80),
    2: (0.8, 0.7, 0.75),
    3: (0.85, 0.6, 0.70),
    4: (0.9, 0.5, 0.64),
    6: (0.9, 0.4, 0.55),
    8: (0.95, 0.3, 0.46),
    11: (0.95, 0.2, 0.33),
    16: (1.0, 0.1, 0.18),
}
# The default of lpm is 1.5 points below the best of its curve, which is near.
LPM = {"lpm[lambda_first=%d;lambda_second=%d]" % (k, k): (0.7, 0.7, 0.70 + k / 400) for k in (0, 2, 4, 8)}
LPM["lpm"] = (0.7, 0.7, 0.705)
# Limit in ms -> F and median time in ms of usac; p95 is twice the median.
USAC = {1: (0.4, 3.0), 3: (0.5, 4.0), 10: (0.7, 9.0), 30: (0.8, 20.0), 100: (0.9, 60.0), 300: (0.9, 60.0)}


def usual_f(group, name, k, f):
    """Return the F of a pair: its selector's."""
    return f


def write_run(folder, section, scores, limited=(), f=usual_f):
    """Write a run of one experiment on two datasets. F differs a little from pair to pair.

    f(group, name, k, F) returns the F of the k-th pair, None where the pair is not there.
    """
    pairs, means = [], []
    for group, tau in ((VGG, 5), (LABELLED, "")):
        for name, values in scores.items():
            time = values[3] if len(values) > 3 else 1e-3
            means.append(
                summary_row(group.dataset, group.features, name, tau, values[:3] + (values[2], time))
            )
            for k in range(PAIRS):
                shift = 0.001 * (k - (PAIRS - 1) / 2)
                value = f(group, name, k, values[2] + shift)
                if value is None:
                    continue
                row = pair_row(
                    group.dataset, "s", group.features, name, tau, values[:2] + (value, value, time)
                )
                row.update(pair=str(k), status="time_limit" if name in limited and k < 3 else "ok")
                pairs.append(row)
    write_pairs(folder / "pairs.csv", pairs)
    write_csv(folder / "summary.csv", reading.SUMMARY_HEADER, means)
    write_csv(folder / "failures.csv", reading.FAILURES_HEADER, [])
    write_csv(folder / "stages.csv", reading.STAGES_HEADER, [])
    write_csv(folder / "images" / "index.csv", reading.IMAGES_HEADER, [])
    (folder / "summary.json").write_text(json.dumps({"state": {"complete": True}}))
    (folder / "environment.json").write_text("{}")
    names = ", ".join('"%s"' % name for name in scores)
    text = "experiment: %s\nsections: [%s]\ncells: [sift+sift/none]\nselectors: [%s]\n"
    (folder / "config.yaml").write_text(text % (section, section, names))


class Names(unittest.TestCase):
    """Names of selectors with options in brackets."""

    def test_are_taken_apart(self):
        self.assertEqual(selectors.take_apart("gms"), ("gms", "", {}))
        self.assertEqual(
            selectors.take_apart("usac:h[max_seconds=0.01; threshold=3]"),
            ("usac", "h", {"max_seconds": "0.01", "threshold": "3"}),
        )
        self.assertEqual(selectors.budget_name("usac:h[max_seconds=0.01;threshold=3]"), "usac:h[threshold=3]")
        self.assertEqual(selectors.budget_name("usac[max_seconds=0.01]"), "usac")
        self.assertEqual(selectors.curve_name("lpm[lambda_first=4;lambda_second=4]"), "lpm")
        self.assertEqual(selectors.curve_name("usac[max_seconds=0.01;threshold=3]"), "usac[max_seconds=0.01]")
        self.assertEqual(selectors.curve_name("a/B:c[size=3]"), "a/B:c[size=3]")
        self.assertEqual(selectors.curve_name("nnsr[max_threshold=0.9]"), "nnsr[max_threshold=0.9]")

    def test_belong_to_the_group_of_the_name_before_the_brackets(self):
        for name in ("gms", "gms:scale", "gms[alpha=6]", "gms:scale[alpha=6]"):
            self.assertEqual(selectors.group_of_selector(name), "paper", name)
        self.assertEqual(selectors.group_of_selector("a/B[gms=1]"), selectors.OTHER_PACKAGES)
        self.assertTrue(selectors.is_baseline("keep_all"))
        self.assertFalse(selectors.is_baseline("gms[alpha=6]"))

    def test_are_sorted_by_the_values_of_their_options(self):
        ordered = ["nnsr", "gms", "gms[alpha=2]", "gms[alpha=10]", "gms[alpha=wide]", "gms:scale"]
        ordered += ["gms:scale[alpha=3]", "lpm", "a/B", "a/B[k=9]", "a/B[k=10]", "keep_all"]
        self.assertEqual(sorted(reversed(ordered), key=selectors.selector_key), ordered)

    def test_have_styles_of_their_own(self):
        names = ["gms", "gms:scale", "gms[alpha=2]", "gms[alpha=10]", "lpm", "keep_all"]
        styles = selectors.selector_styles(names)
        self.assertEqual(len({json.dumps(style) for style in styles.values()}), len(names))
        self.assertEqual({styles[n]["colour"] for n in names[:4]}, {selectors.SELECTOR_STYLES["gms"][0]})
        self.assertTrue(styles["gms[alpha=2]"]["hollow"] and not styles["gms"]["hollow"])

    def test_main_parameters_are_named_by_all_their_options(self):
        self.assertEqual(curves.parameter_text("lpm:guided"), "lambda_first = lambda_second")
        self.assertEqual(curves.parameter_text("auto"), "threshold, fundamental_threshold")
        self.assertEqual(curves.parameter_text("gms"), "alpha")

    def test_main_parameters_are_those_of_known_selectors(self):
        known = {name for names in GROUPS.values() for name in names}
        self.assertEqual(known - set(MAIN_PARAMETERS), {"keep_all"})
        for name, options in MAIN_PARAMETERS.items():
            self.assertEqual(len({len(values) for values in options.values()}), 1, name)


class Area(unittest.TestCase):
    """The area under an operating curve."""

    @staticmethod
    def area(*points):
        """Return the area under points (recall, precision)."""
        return curves.area([curves.Point("", "", False, p, r, 0) for r, p in points])

    def test_is_that_under_the_highest_precision_at_each_recall(self):
        self.assertAlmostEqual(self.area((0.5, 0.8)), 0.4)
        self.assertAlmostEqual(self.area((1.0, 1.0)), 1.0)
        self.assertAlmostEqual(self.area((0.4, 0.9), (0.8, 0.5)), 0.4 * 0.9 + 0.4 * 0.5)

    def test_does_not_depend_on_the_order_and_ignores_points_below_others(self):
        expected = self.area((0.4, 0.9), (0.8, 0.5))
        self.assertAlmostEqual(self.area((0.8, 0.5), (0.4, 0.9)), expected)
        self.assertAlmostEqual(self.area((0.2, 0.1), (0.8, 0.5), (0.4, 0.9), (0.4, 0.3)), expected)

    def test_of_nothing(self):
        self.assertEqual(self.area((0.5, 0.0)), 0.0)
        self.assertIsNone(self.area())
        self.assertIsNone(self.area((0.0, None)))


class Sections(unittest.TestCase):
    """Runs of the two experiments."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="corrsel_variants_")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def page(self, files=False):
        """Write the report and return its Page."""
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as errors:
            with figure_files(files):
                status = report.main([str(self.folder)])
        self.assertEqual(status, 0, errors.getvalue())
        return Page((self.folder / "report.html").read_text(encoding="utf-8"))

    @staticmethod
    def rows(page, caption):
        """Return first cell -> texts of the cells of the rows of a table."""
        return {row[0]["text"]: [c["text"] for c in row] for row in page.table(caption)[1:]}

    def write_curves(self, **changes):
        scores = {gms(alpha): values for alpha, values in GMS.items()}
        scores.update(LPM, keep_all=(0.4, 1.0, 0.57), **changes)
        write_run(self.folder, "curves", scores)

    def test_curves_name_the_default_that_is_far_and_no_other(self):
        self.write_curves()
        page = self.page(files=True)
        rows = self.rows(page, "The default and the best value")
        self.assertEqual(
            rows["gms"][1:],
            ["alpha", "4", "0.640", "1.5", "0.800", "0.160", "0.160\u20130.160", "yes", "vgg, adelaidermf"],
        )
        self.assertEqual(rows["lpm"][2:7], ["6", "0.705", "8", "0.720", "0.015"])
        self.assertEqual(rows["lpm"][8], "no")
        self.assertNotIn("keep_all", rows)
        text = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("<b>gms</b>: the default has a mean F of 0.640, and <code>gms[alpha=1.5]</code>", text)
        self.assertNotIn("<b>lpm</b>: the default has", text)
        self.assertTrue((self.folder / "figures" / "curves_vgg.png").is_file())
        self.assertIn('id="curves"', text)
        self.assertNotIn('id="results"', text)
        self.assertNotIn('id="visual"', text)

    def test_curves_have_an_area_and_the_place_of_the_default(self):
        self.write_curves()
        rows = self.rows(self.page(), "Operating curves of vgg")
        area = 0.1 * 1 + 0.2 * 0.95 + 0.2 * 0.9 + 0.1 * 0.85 + 0.2 * 0.8 + 0.1 * 0.5
        self.assertEqual(
            rows["gms"][2:9], ["%.3f\u25b2" % area, "4", "0.900", "0.500", "0.640", "1.5", "0.800"]
        )
        self.assertTrue(rows["gms"][9].startswith("0.160 ("), rows["gms"])

    def test_a_default_that_the_data_choose_is_beside_the_curve(self):
        names = {"usac": (0.9, 0.9, 0.9)}
        names.update(
            ("usac[threshold=%g]" % v, (0.8, 0.8, 0.8)) for v in MAIN_PARAMETERS["usac"]["threshold"]
        )
        self.write_curves(**names)
        rows = self.rows(self.page(), "Operating curves of vgg")
        self.assertEqual(rows["usac"][3], "from the data")
        self.assertEqual(rows["usac"][7:], ["from the data", "0.900", "\u2013"])

    def test_a_curve_with_a_gap_on_one_dataset_is_evaluated_on_the_others(self):
        self.write_curves()
        path = self.folder / "summary.csv"
        kept = [
            line
            for line in path.read_text().splitlines()
            if "adelaidermf,given,none,gms[alpha=6]" not in line
        ]
        path.write_text("\n".join(kept) + "\n")
        rows = self.rows(self.page(), "The default and the best value")
        self.assertEqual(rows["gms"][9], "vgg")
        self.assertEqual(rows["lpm"][9], "vgg, adelaidermf")

    def test_noise_does_not_make_a_default_far(self):
        estimate = curves.difference
        self.addCleanup(setattr, curves, "difference", estimate)
        curves.difference = lambda *_: curves.mean_interval([-0.5, 0.5, 0.4])
        self.write_curves()
        self.assertEqual(self.rows(self.page(), "The default and the best value")["gms"][8], "no")

    def test_every_dataset_counts_the_same(self):
        def f(group, name, k, usual):
            if group == LABELLED and k >= 3:
                return None
            return (0.6 if group == VGG else 0.9) if name == "gms[alpha=6]" else 0.5 if group == VGG else 0.4

        write_run(self.folder, "curves", {gms(alpha): values for alpha, values in GMS.items()}, f=f)
        run = reading.read_run(self.folder)
        estimate = curves.difference(run, [VGG, LABELLED], "gms[alpha=6]", "gms[alpha=8]")
        self.assertEqual(estimate.count, PAIRS + 3)
        self.assertAlmostEqual(estimate.mean, (0.1 + 0.5) / 2)

    def write_budget(self, f=usual_f):
        scores = {
            "usac[max_seconds=%g]" % (ms / 1e3): (f, f, f, time / 1e3) for ms, (f, time) in USAC.items()
        }
        scores.update(
            gms=(0.6, 0.6, 0.6, 0.0008), lpm=(0.6005, 0.6, 0.6005, 0.002), keep_all=(0.3, 1, 0.46, 1e-5)
        )
        write_run(self.folder, "budget", scores, ["usac[max_seconds=0.01]"], f)

    def test_budget_chooses_by_the_time_that_was_really_taken(self):
        self.write_budget()
        page = self.page(files=True)
        rows = self.rows(page, "Which selector when there are so many milliseconds: vgg")
        self.assertEqual(list(rows), ["1 ms", "3 ms", "10 ms", "30 ms", "100 ms", "300 ms"])
        by_median = {name: row[1] for name, row in rows.items()}
        by_p95 = {name: row[5] for name, row in rows.items()}
        self.assertEqual(by_median["1 ms"], "gms")
        self.assertEqual(by_p95["1 ms"], "\u2013")  # 1.6 ms
        self.assertEqual(by_median["3 ms"], "lpm")
        self.assertEqual(by_p95["3 ms"], "gms")
        self.assertEqual(by_median["10 ms"], "usac[max_seconds=0.01]")
        self.assertEqual(by_p95["10 ms"], "lpm")  # usac: 8 ms with F 0.5, 18 ms with F 0.7
        self.assertEqual(by_median["100 ms"], "usac[max_seconds=0.1]")
        self.assertEqual(rows["100 ms"][2:4], ["0.900 (0.890\u20130.910)", "60.0 / 120.0"])
        text = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn('id="budget"', text)
        self.assertTrue((self.folder / "figures" / "budget_vgg.png").is_file())

    def test_budget_shows_overshoot_and_what_the_limit_ended(self):
        self.write_budget()
        rows = self.rows(self.page(), "Every limit: vgg")
        self.assertEqual(
            rows["usac[max_seconds=0.01]"][1:],
            ["10", "0.700 (0.690\u20130.710)", "9.00", "18.0", "+8.00", "25 %", "0 %"],
        )
        self.assertEqual(rows["usac[max_seconds=0.3]"][5:], ["0", "0 %", "0 %"])
        self.assertEqual(rows["gms"][1], "\u2013")
        self.assertNotIn("keep_all", rows)

    def test_budget_names_what_the_pairs_cannot_separate(self):
        for noise, expected in ((0.0, []), (0.1, ["gms"])):
            self.write_budget(lambda group, name, k, f: f + (-1) ** k * noise if name == "gms" else f)
            run = reading.read_run(self.folder)
            lines = budget.lines_of(run, VGG)
            best = budget.best_within(lines, 0.003, "median")
            self.assertEqual(best.selector, "lpm")
            self.assertEqual(budget.not_separated(run, VGG, lines, 0.003, "median", best), expected)

    def test_budget_has_a_panel_for_each_measure_of_poses(self):
        self.write_budget()
        run = reading.read_run(self.folder)
        self.assertEqual(budget.pose_measures(run, VGG), [])
        nothing = dict(poses=0, auc_10=None, homographies=0, corner_auc_3=None)
        run.pose_summary = [
            dict(VGG._asdict(), selector="gms", **dict(nothing, homographies=12, corner_auc_3=0.25)),
            dict(VGG._asdict(), selector="lpm", **nothing),
            dict(LABELLED._asdict(), selector="gms", **dict(nothing, poses=12, auc_10=0.5)),
        ]
        self.assertEqual(budget.pose_measures(run, VGG), [("Corner AUC at 3 px", {"gms": 0.25})])
        self.assertEqual(budget.pose_measures(run, LABELLED), [("Pose AUC at 10 degrees", {"gms": 0.5})])
        text = budget.html(run, FigureWriter())
        self.assertIn("Mean F at \u03c4 = 5 px and Corner AUC at 3 px against", text)
        self.assertEqual(text.count('<svg class="plot"'), 4)

    def test_the_terminal_shows_names_with_brackets(self):
        self.write_budget()
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            self.assertEqual(report.main(["--all", "--no-page", str(self.folder)]), 0)
        self.assertIn("usac[max_seconds=0.1] 90.0", out.getvalue())


if __name__ == "__main__":
    unittest.main()
