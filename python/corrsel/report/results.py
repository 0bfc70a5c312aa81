"""Means of every dataset, kind of features and preselection: table and curves."""
import numpy as np
from matplotlib.ticker import FuncFormatter

from .figures import draw_part, edge_of, line_figures, marked, new_axes, part_ending, selector_rows
from .markup import HIGHEST, LOWEST, Cell, article, compared_cell, contents, group_heading, joined, panels
from .markup import paragraph, row_class, selector_name, sources, table, with_headings
from .left_out import left_out_sentence
from .overview import findings_in_place, sentence
from .reading import REFERENCE_TAU
from .scopes import figure_name, other_groups
from .selectors import is_baseline
from .words import STATUSES, at_tau, fraction, group_text, interval, milliseconds, number, statuses_text
from .words import tenths


def curve_panel(run, figures, group, part, title, column, name):
    """Draw the mean of one measure against tau, one line per selector of a part."""
    figure, axes = new_axes(3.9, 3.1, 0.5, 0.12, 0.48, 0.34)
    taus = run.taus(group)

    def line_of(selector, named):
        rows = [(tau, run.mean(group, selector, tau)) for tau in taus]
        points = [(tau, row[column]) for tau, row in rows if row and row[column] is not None]
        return tuple(zip(*points))

    draw_part(axes, run, part, line_of)
    axes.set_title(title, loc="left")
    axes.set_xlabel("tolerance \u03c4 (px)")
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlim(taus[0] - 0.3, taus[-1] + 0.3)
    axes.set_xticks(taus if len(taus) <= 12 else taus[:: len(taus) // 10])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: "%g" % x))
    axes.grid(True)
    return figures(
        figure, "%s against tolerance for %s, one line per selector" % (title, group_text(group)), name
    )


def bar_panel(run, figures, group, title, column, name):
    """Draw one measure of a labelled dataset as bars, one per selector, with the interval of mean F."""
    selectors = run.selectors_of(group)
    figure, axes = new_axes(3.9, 0.75 + 0.27 * len(selectors), 1.05, 0.5, 0.38, 0.34)
    axes.grid(True, axis="x")
    for y, selector in enumerate(selectors):
        with marked(axes, selector):
            row, style = run.mean(group, selector, run.tau(group)), run.styles[selector]
            if row is None or row[column] is None:
                reason = "unsupported" if run.unsupported(group, selector) else "no result"
                axes.text(0.02, y, reason, va="center", style="italic", color="#555555", fontsize=8.5)
                continue
            value = row[column]
            hollow = style["hollow"] or is_baseline(selector)
            edge = edge_of(style)
            face, hatch = ("white", "////") if hollow else (style["colour"], None)
            axes.barh(y, value, height=0.62, color=face, edgecolor=edge, hatch=hatch, linewidth=0.9)
            end = value
            if column == "f_paper" and None not in (row["f_paper_lo"], row["f_paper_hi"]):
                low, high = row["f_paper_lo"], row["f_paper_hi"]
                axes.plot([low, high], [y, y], color="white", linewidth=3.4, solid_capstyle="butt")
                axes.plot([low, high], [y, y], color="#222222", linewidth=1.4, marker="|", markersize=6)
                end = max(value, high)
            axes.text(end + 0.025, y, fraction(value), va="center", fontsize=8.5)
    selector_rows(axes, selectors, 13)
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: "%g" % x))
    axes.set_title(title, loc="left")
    return figures(figure, "%s per selector for %s" % (title, group_text(group)), name)


COLUMNS = (
    ("Precision", "precision", fraction, max),
    ("Recall", "recall_paper", fraction, max),
    ("F", "f_paper", fraction, max),
    ("F interval", None, None, None),
    ("F, same \u03c4", "f_same_tau", fraction, max),
    ("Confidence", "confidence_median", tenths, None),
    ("Median (ms)", "select_s_median", milliseconds, min),
    ("p95 (ms)", "select_s_p95", milliseconds, min),
    ("Pairs", "pairs", number, None),
)


def best_texts(run, group):
    """Return column -> the text of its best value, among the selectors that compete."""
    rows, best = run.ranking(group), {}
    for _, column, show, choose in COLUMNS:
        values = [r[column] for r in rows if column and r[column] is not None]
        if choose and values and len(rows) > 1:
            best[column] = show(choose(values))
    return best


def result_row(run, group, selector, best):
    """Return one selector's row of a group's table."""
    row = run.mean(group, selector, run.tau(group))
    css = row_class(selector)
    name = selector_name(selector)
    if row is None:
        if run.unsupported(group, selector):
            reason = "unsupported: %s" % (
                run.unsupported_reason(group, selector) or STATUSES["unsupported_input"]
            )
        else:
            counts = run.statuses.get((group, selector))
            reason = "no result" + (": " + statuses_text(counts) if counts else "")
        return (css, [name, Cell(reason, "text none", span=len(COLUMNS))])
    cells = [name]
    for _, column, show, choose in COLUMNS:
        if column is None:
            cells.append(interval(row))
        else:
            highest = None if css or row[column] is None else best.get(column)
            cells.append(compared_cell(show(row[column]), highest, LOWEST if choose is min else HIGHEST))
    return (css, cells)


def group_notes(run, group):
    """Return remarks that keep a reader from comparing what cannot be compared."""
    out, tau = [], run.tau(group)
    if tau is not None and tau != REFERENCE_TAU:
        out.append(
            "The run has no tolerance of %g px here; the table is made at %g px." % (REFERENCE_TAU, tau)
        )
    counts = {r["selector"]: r["pairs"] for r in run.ranking(group) if r["pairs"] is not None}
    if len(set(counts.values())) > 1:
        out.append(
            "The selectors have results on different numbers of pairs (see the last column): their means are"
            " not strictly comparable."
        )
    out += filter(None, [left_out_sentence(run, group)])
    usable = {s: np.count_nonzero(np.isfinite(run.pair_values(group, s))) for s in counts}
    stale = [s for s in counts if usable[s] > counts[s]]
    if stale:
        out.append(
            "summary.csv counts fewer pairs than pairs.csv holds for %s: it is older than the last pairs."
            % ", ".join(stale)
        )
    return out


def group_html(run, figures, anchor, prefix, group):
    """Return table and curves of one dataset x features x preselection."""
    tau = run.tau(group)
    caption = "Means over the pairs of %s at %s." % (group_text(group), at_tau(tau))
    if tau is None:
        caption = "Means over the pairs of %s; labelled ground truth, no tolerance." % group_text(group)
    caption += " \u25b2 highest, \u25bc lowest of the column; the baseline is not marked."
    best = best_texts(run, group)
    selectors = run.selectors_of(group)
    rows = with_headings([(s, result_row(run, group, s, best)) for s in selectors])
    out = []
    if findings_in_place(run):
        out.append(paragraph(sentence(run, group, named=False)))
    out.append(table(caption, ["Selector"] + [c[0] for c in COLUMNS], rows, "results"))
    out.append(sources(run, "summary.csv", "pairs.csv"))
    out += [paragraph(note, "small") for note in group_notes(run, group)]
    if run.ranking(group):
        out.append(figure_html(run, figures, prefix, group))
    return article(group_heading(group), *out, identifier=anchor)


def figure_html(run, figures, prefix, group):
    """Return the figure of a group: curves over the tolerances, or bars where the truth is labels."""
    measures = (("Precision", "precision", "p"), ("Recall", "recall_paper", "r"), ("F", "f_paper", "f"))
    names = [(title, column, figure_name(run, prefix, group, key)) for title, column, key in measures]
    if run.tau(group) is None:
        text = "Precision, recall and F of each selector; the bars on F are 95 % intervals of the mean."
        return panels([bar_panel(run, figures, group, *each) for each in names], text)
    text = (
        "Precision, recall and F against the tolerance; recall as in the paper, relative to the inliers at %s px."
        % run.ground_truth_px()
    )

    def plots(part):
        for title, column, name in names:
            yield curve_panel(run, figures, group, part, title, column, name + part_ending(part))

    drawn = [s for s in run.selectors_of(group) if any(run.mean(group, s, t) for t in run.taus(group))]
    return line_figures(run, figures, drawn, plots, "panels", text)


def groups_html(run, figures, groups, prefix, link_text="Results"):
    """Return table and curves of several groups, single pairs last; `prefix` begins their anchors and figure files."""
    out, groups = [], sorted(groups, key=lambda group: run.pair_count(group) < 2)
    if len(groups) > 1:
        links = [("%s-%d" % (prefix, i), group_text(g)) for i, g in enumerate(groups, 1)]
        out.append(contents(link_text, links))
    out += [group_html(run, figures, "%s-%d" % (prefix, i), prefix, g) for i, g in enumerate(groups, 1)]
    return joined(out)


def html(run, figures):
    """Return the body of the section: every group that no experiment of a preset shows."""
    groups = other_groups(run)
    if not groups:
        return paragraph(
            "No means to show: %s." % ("summary.csv has no rows" if run.groups else "the run holds no pairs")
        )
    return groups_html(run, figures, groups, "results")
