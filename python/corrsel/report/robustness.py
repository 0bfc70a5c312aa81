"""Section on robustness: the eight cases of the paper's Table IV, measured beside printed."""
from collections import namedtuple

import numpy as np
from markupsafe import Markup

from . import paper
from .figures import edge_of, marked, new_axes, plot_text, selector_rows
from .inference import average_ranks, is_separate, mean_interval, paired_difference, spearman
from .markup import DASH, Cell, article, below, bold, compared_cell, findings, group_heading, heading, joined
from .markup import lines, panels, paragraph, row_class, selector_name, table, with_headings
from .reading import Group, average_by_pair
from .scopes import unselected_group
from .selectors import is_baseline
from .words import at_tau, features_text, fraction, group_text, plural, span

SAMPLE_SEQUENCES = dict(
    zip(
        paper.ROBUSTNESS,
        "zoom_rotation_1 blur_1 zoom_rotation_2 viewpoint_1 light blur_2 jpeg viewpoint_2".split(),
    )
)
VGG_SEQUENCES = {name: case.scene for name, case in paper.ROBUSTNESS.items()}
SEQUENCES = {"vgg": VGG_SEQUENCES, "sample": SAMPLE_SEQUENCES}

InlierRatio = namedtuple("InlierRatio", "pairs within_10 within_5")
Score = namedtuple("Score", "precision recall f values empty")  # f: Estimate; values: F of each pair
Result = namedtuple("Result", "case sequence scores ratio putative printed")


def mean_inlier_ratio(run, dataset, features, sequence=None):
    """Return the mean over pairs of the share of putative matches near the truth, None without pairs.

    Before any preselection. within_10 counts the ground-truth inliers (10 px); within_5 what keep_all has correct at
    5 px, None where the run lacks keep_all or that tolerance. Pairs without any inlier count as 0.
    """
    group = Group(dataset, features, "none")
    putative, inliers = (run.pair_constants(group, name) for name in ("n_putative", "n_ground_truth"))
    counted = (
        np.isfinite(inliers)
        & (putative > 0)
        & run.in_sequences(group, None if sequence is None else [sequence])
    )
    if not counted.any():
        return None
    correct = np.full(len(putative), np.nan)
    for selector in filter(is_baseline, run.selectors_of(group)):
        rows = run.rows(group, selector)
        correct = average_by_pair(rows, "n_correct", rows["tau_px"] == paper.TAU_PX)
    within_10, within_5 = inliers[counted] / putative[counted], correct[counted] / putative[counted]
    return InlierRatio(
        len(within_10),
        float(within_10.mean()),
        float(within_5.mean()) if np.isfinite(within_5).all() else None,
    )


def percent(share):
    """Return a share as text in percent."""
    return DASH if share is None else "%.1f %%" % (100 * share)


def inlier_ratio_html(run):
    """Return the sentence on SymBench's inlier ratio beside the paper's; '' without that dataset."""
    group = unselected_group(run, "symbench")
    ratio = mean_inlier_ratio(run, group.dataset, group.features) if group else None
    if ratio is None:
        return ""
    values = (features_text(group.features), plural(ratio.pairs, "pair"), percent(ratio.within_10))
    text = (
        "SymBench, %s: over %s, %s of the putative matches lie within 10 px of the truth on average" % values
    )
    if ratio.within_5 is not None:
        text += ", %s within 5 px" % percent(ratio.within_5)
    bound = paper.SYMBENCH_INLIER_RATIO_BELOW / 100
    text += ". The paper writes < %g %% (%s; no tolerance named)" % (
        paper.SYMBENCH_INLIER_RATIO_BELOW,
        paper.SYMBENCH_INLIER_RATIO_SOURCE,
    )
    values = [v for v in (ratio.within_10, ratio.within_5) if v is not None]
    if all(v < bound for v in values):
        return text + "; the measured ratio is below that too."
    if all(v >= bound for v in values):
        return text + "; the measured ratio is above that: this run starts from better matches."
    return text + "; the measured ratio is below that at 5 px only."


def score(run, group, sequence, selector):
    """Return a selector's means over the pairs of a sequence; None without a usable pair."""
    inside = run.in_sequences(group, [sequence])
    values = [run.pair_values(group, selector, c)[inside] for c in ("precision", "recall_paper", "f_paper")]
    precision, recall, f = (column[np.isfinite(column)] for column in values)
    if len(f) == 0:
        return None
    return Score(
        float(precision.mean()) if len(precision) else None,
        float(recall.mean()),
        mean_interval(f),
        values[2],
        int(np.sum(f == 0)),
    )


def results(run, group):
    """Return the Result of each of the eight cases that has pairs; the paper's numbers only beside its own input."""
    comparable = group.dataset == "vgg" and group.features == paper.FEATURES_DEFAULT and run.tau(group) == 5
    out = []
    for name, case in paper.ROBUSTNESS.items():
        sequence = SEQUENCES[group.dataset][name]
        scores = {s: score(run, group, sequence, s) for s in run.selectors_of(group)}
        scores = {s: v for s, v in scores.items() if v is not None}
        if not any(not is_baseline(s) for s in scores):
            continue
        putative = run.pair_constants(group, "n_putative")[run.in_sequences(group, [sequence])]
        putative = putative[np.isfinite(putative)]
        out.append(
            Result(
                case,
                sequence,
                scores,
                mean_inlier_ratio(run, group.dataset, group.features, sequence),
                float(np.median(putative)) if len(putative) else None,
                case if comparable else None,
            )
        )
    return out


def competing(result):
    """Return the selectors of a result that compete, by falling F."""
    names = [s for s in result.scores if not is_baseline(s)]
    return sorted(names, key=lambda s: -result.scores[s].f.mean)


def printed_winner(case):
    """Return the selector with the highest printed F."""
    return max(case.f, key=case.f.get)


def correlation(result):
    """Return Spearman's rho between measured and printed F over the selectors in both; None if undefined."""
    names = [s for s in result.printed.f if s in result.scores]
    return spearman([result.scores[s].f.mean for s in names], [result.printed.f[s] for s in names])


def ranks(values):
    """Return selector -> rank, 1 the highest, of selector -> value."""
    numbers = average_ranks([-v for v in values.values()]) if values else []
    return dict(zip(values, numbers))


# ------------------------------------------------------------------------------------------------ sentences


def printed(value):
    """Return a printed percentage as a fraction."""
    return value / 100


def change_text(result, selector):
    """Return how a selector's F differs from the printed one and by what, as words."""
    measured, case = result.scores[selector], result.printed
    parts = [("recall", measured.recall, printed(case.recall[selector]))]
    if measured.precision is not None:
        parts.insert(0, ("precision", measured.precision, printed(case.precision[selector])))
    rise = measured.f.mean - printed(case.f[selector])
    sign = 1 if rise > 0 else -1
    name, here, there = max(parts, key=lambda p: sign * (p[1] - p[2]))
    values = (selector, fraction(measured.f.mean), fraction(printed(case.f[selector])))
    text = Markup("<b>%s</b> is further from its printed F, %s here and %s there") % values
    if sign * (here - there) > 0:
        text += ", most of all in %s (%s against %s)" % (name, fraction(here), fraction(there))
    return text + whole_pairs_text(case.recall[selector], measured.f.count)


def whole_pairs_text(recall, count):
    """Return a remark on a printed recall, in percent, that is a whole number of `count` pairs; else ''.

    Recall 1 on some pairs and 0 on the others gives such a number; other recalls can, but seldom do.
    """
    whole = recall * count / 100
    if not 0 < whole < count or whole != round(whole):
        return ""
    return "; its printed recall, %.2f %%, is what recall 1 on %d of %d pairs and 0 on the others gives" % (
        recall,
        whole,
        count,
    )


def difference_text(first, second, difference):
    """Return a paired difference and whether it separates, as words."""
    text = Markup("pair by pair <b>%s</b> is ahead of <b>%s</b> by %s (%s to %s)") % (
        first,
        second,
        fraction(difference.mean),
        fraction(difference.low),
        fraction(difference.high),
    )
    if is_separate(difference):
        return text
    return text + ", which does not separate them with %s" % plural(difference.count, "pair")


def difference_of(result, first, second):
    """Return the paired difference in F of two selectors over their common pairs; None without any."""
    a, b = result.scores[first].values, result.scores[second].values
    common = np.isfinite(a) & np.isfinite(b)
    return paired_difference(a[common], b[common]) if common.any() else None


def why_html(result):
    """Return one sentence on a case whose winner is not the paper's, made of its numbers; '' where it is.

    Of the two winners it names the one whose F differs more from the printed F, and precision or recall, whichever
    changed more in that direction.
    """
    ours, theirs = competing(result)[0], printed_winner(result.printed)
    if ours == theirs:
        return ""
    text = Markup("%s: <b>%s</b> has the highest F here, <b>%s</b> in the paper; ") % (
        case_name(result),
        ours,
        theirs,
    )
    if theirs not in result.scores:
        return text + "%s has no result in this run." % theirs
    changes = {}
    for selector in (ours, theirs):
        if selector in result.printed.f:
            changes[selector] = result.scores[selector].f.mean - printed(result.printed.f[selector])
    moved = max(changes, key=lambda s: abs(changes[s]))
    text += Markup("of the two, %s") % change_text(result, moved)
    if theirs != moved:
        text += Markup("; <b>%s</b> has %s against %s") % (
            theirs,
            fraction(result.scores[theirs].f.mean),
            fraction(printed(result.printed.f[theirs])),
        )
    empty, count = result.scores[theirs].empty, result.scores[theirs].f.count
    if empty:
        text += Markup("; <b>%s</b> has nothing correct on %d of %s") % (theirs, empty, plural(count, "pair"))
    difference = difference_of(result, ours, theirs)
    if difference:
        text += "; " + difference_text(ours, theirs, difference)
    if result.ratio:
        text += "; %s of the putative matches lie within 10 px" % percent(result.ratio.within_10)
    return text + "."


def case_name(result):
    """Return a case's name as HTML."""
    return Markup("<b>%s</b> (%s, %s)") % (result.case.name, result.sequence, result.case.nuisance)


# --------------------------------------------------------------------------------------------------- tables


def highest(values):
    """Return the text of the highest of some fractions; None without any."""
    values = [v for v in values if v is not None]
    return fraction(max(values)) if values else None


def rank_text(rank):
    """Return a rank, which may be a half, as text."""
    return DASH if rank is None else "%g" % rank


def case_table(result, tau):
    """Return the table of one case: ours, and the paper's where there is one."""
    names = competing(result)
    scores = result.scores
    our_ranks = ranks({s: scores[s].f.mean for s in names})
    columns = [
        [scores[s].precision for s in names],
        [scores[s].recall for s in names],
        [scores[s].f.mean for s in names],
    ]
    best = [highest(values) for values in columns]
    case = result.printed
    printed_columns = [case.precision, case.recall, case.f] if case else []
    printed_best = [highest([printed(v) for v in column.values()]) for column in printed_columns]
    their_ranks = ranks(case.f) if case else {}
    shown = list(scores)
    if case:
        shown = [s for s in case.f if s not in scores] + shown
        shown.sort(key=lambda s: (is_baseline(s), list(case.f).index(s) if s in case.f else len(case.f)))
    rows = []
    for selector in shown:
        base = is_baseline(selector)
        cells = [selector_name(selector)]
        if selector in scores:
            value = scores[selector]
            numbers = (value.precision, value.recall, value.f.mean)
            cells += [compared_cell(fraction(v), None if base else b) for v, b in zip(numbers, best)]
            cells.append(span(value.f.low, value.f.high))
            cells.append(rank_text(our_ranks.get(selector)))
        else:
            cells.append(Cell("not measured", "text none", span=5))
        for column, mark in zip(printed_columns, printed_best):
            cells.append(
                compared_cell(fraction(printed(column[selector])), mark) if selector in column else DASH
            )
        if case:
            cells.append(rank_text(their_ranks.get(selector)))
        rows.append((selector, (row_class(selector), cells)))
    head = ["Selector", "Precision", "Recall", "F", "95 % interval of F", "Rank"]
    caption = "%s, %s: means over %s at %s" % (
        result.case.name,
        result.sequence,
        plural(max(s.f.count for s in scores.values()), "pair"),
        at_tau(tau),
    )
    if case:
        head += ["Paper: precision", "Recall", "F", "Rank"]
        caption += "; on the right what the paper printed (%s)" % paper.ROBUSTNESS_SOURCE
    return table(caption + ". \u25b2 highest of the column.", head, with_headings(rows), "results")


def name_cell(selector, f):
    """Return a selector with its F below it, as HTML."""
    return bold(selector) + below(fraction(f))


def overview_table(group, cases):
    """Return the table with one row for each case."""
    compared = any(r.printed for r in cases)
    rows = []
    for result in cases:
        names = competing(result)
        first = result.scores[names[0]]
        runner = names[1] if len(names) > 1 else None
        shares = (result.ratio.within_10, result.ratio.within_5) if result.ratio else (None, None)
        cells = [
            result.case.name + below("%s: %s" % (result.sequence, result.case.nuisance)),
            str(first.f.count),
            DASH if result.putative is None else "%.0f" % result.putative,
            lines(list(map(percent, shares))),
            name_cell(names[0], first.f.mean),
            name_cell(runner, result.scores[runner].f.mean) if runner else DASH,
        ]
        separate = DASH
        if runner:
            difference = difference_of(result, names[0], runner)
            separate = DASH if difference is None else "yes" if is_separate(difference) else "no"
        cells.append(separate)
        if result.printed:
            winner = printed_winner(result.printed)
            rho = correlation(result)
            cells.append(name_cell(winner, printed(result.printed.f[winner])))
            cells.append("yes" if winner == names[0] else "no")
            cells.append(DASH if rho is None else "%.2f" % rho)
        rows.append(("", cells))
    head = ["Case", "Pairs", "Matches", lines(["Within 10 px", "Within 5 px"])]
    head += ["Highest F", "Runner-up", "Separate"]
    caption = (
        "The cases of %s. Matches: median number of putative matches; within 10 and 5 px: mean share of them so near the"
        " truth. Separate: the 95 %% interval of the difference in F between the first two, pair by pair, does not contain"
        " 0; with five pairs that interval is rough." % group_text(group)
    )
    if compared:
        head += [lines(["Highest F", "in the paper"]), "Same", "\u03c1"]
        caption += " \u03c1: Spearman's rank correlation between the measured F and the paper's."
    return table(caption, head, rows)


# --------------------------------------------------------------------------------------------------- figure


def dot_panel(run, figures, group, result):
    """Draw F of a case, one row for each selector: measured with its interval, and printed."""
    names = list(result.scores)
    figure, axes = new_axes(3.9, 0.78 + 0.22 * len(names), 1.05, 0.15, 0.38, 0.34)
    axes.grid(True, axis="x")
    for y, selector in enumerate(names):
        with marked(axes, selector):
            value, style = result.scores[selector], run.styles[selector]
            edge = edge_of(style)
            face = "white" if style["hollow"] else style["colour"]
            axes.plot([value.f.low, value.f.high], [y, y], color=edge, linewidth=1.4, solid_capstyle="butt")
            axes.plot([value.f.mean], [y], "o", color=face, markeredgecolor=edge, markersize=6)
            if result.printed and selector in result.printed.f:
                axes.plot(
                    [printed(result.printed.f[selector])],
                    [y],
                    "D",
                    color="none",
                    markeredgecolor="#222222",
                    markersize=5.5,
                )
    selector_rows(axes, names, 13)
    axes.set_xlim(-0.02, 1.02)
    axes.set_title("%s: %s" % (result.case.name, plot_text(result.sequence)), loc="left")
    label = "F of each selector in %s (%s, %s)" % (result.case.name, result.sequence, result.case.nuisance)
    if result.printed:
        label += ", measured and printed in the paper"
    return figures(figure, label, "robustness_%s_%s" % (group.dataset, result.case.name))


# -------------------------------------------------------------------------------------------------- section


def intro_html(group, cases):
    """Return an introduction to the tables of a group and to the numbers beside them."""
    if group.dataset == "sample":
        return paragraph(
            Markup(
                "<strong>Generated data.</strong> The eight sequences of the dataset sample take the place of the eight"
                " cases: their right images are computed from photographs. The paper's numbers are therefore not shown."
            )
        )
    if cases[0].printed:
        return paragraph(
            "The eight scenes of VGG are the paper's eight cases. Its numbers are from %s, where USAC is spelt"
            " \u201cUASC\u201d; here they are fractions too." % paper.ROBUSTNESS_SOURCE
        )
    return paragraph(
        "The paper's numbers are for %s at %g px, so they are not shown here."
        % (paper.FEATURES_DEFAULT, paper.TAU_PX)
    )


def reasons_html(cases):
    """Return the sentences on the cases with another winner than the paper's, and the number of the others."""
    compared = [r for r in cases if r.printed]
    if not compared:
        return ""
    sentences = [s for s in (why_html(r) for r in compared) if s]
    same = len(compared) - len(sentences)
    values = [v for v in (correlation(r) for r in compared) if v is not None]
    text = "The paper's winner wins here too in %d of %s" % (same, plural(len(compared), "case"))
    if values:
        text += "; \u03c1 is %.2f on average, from %.2f to %.2f" % (np.mean(values), min(values), max(values))
    out = [paragraph(text + ".")]
    if sentences:
        out.append(findings(sentences))
    return joined(out)


def group_html(run, figures, group):
    """Return the cases of one group; '' where it has none of them."""
    cases = results(run, group)
    if not cases:
        return ""
    plots = [dot_panel(run, figures, group, result) for result in cases]
    text = "F of each case: a dot with its 95 % interval is measured"
    text += "; a hollow diamond is the paper's." if any(result.printed for result in cases) else "."
    return article(
        group_heading(group),
        intro_html(group, cases),
        overview_table(group, cases),
        reasons_html(cases),
        panels(plots, text),
        Markup("<h4>Case by case</h4>"),
        *(case_table(result, run.tau(group)) for result in cases),
    )


def html(run, figures):
    """Return the body of the section on robustness."""
    groups = [g for g in (unselected_group(run, dataset) for dataset in SEQUENCES) if g]
    parts = [group_html(run, figures, g) for g in groups]
    ratio = inlier_ratio_html(run)
    if not any(parts):
        parts = [
            paragraph(
                "Robustness was not measured: the run has none of the eight cases (dataset vgg or sample)."
            )
        ]
    if ratio:
        parts.append(heading("Inlier ratio of SymBench"))
        parts.append(paragraph(ratio))
    return joined(parts)
