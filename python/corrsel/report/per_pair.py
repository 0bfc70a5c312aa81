"""F of every selector on every pair: maps in the experiment per_pair (the paper's Fig. 4), dots elsewhere."""
from itertools import compress

import numpy as np

from .figures import marked, new_axes, plot_text, selector_rows, selector_ticks
from .markup import (
    BLOCKS,
    DASH,
    article,
    below,
    best_cell,
    group_heading,
    joined,
    panels,
    paragraph,
    row_class,
)
from .markup import sources, table, with_headings
from .scopes import figure_name, groups_of, makes_variants
from .selectors import YELLOW, are_many, is_baseline
from .words import at_tau, fraction, group_text

HIGH_F = 0.8  # a pair counts as solved from here on
PAIRS_IN_A_MAP = 60  # more pairs are drawn as several maps
MAX_PAIRS = 240  # more pairs are not drawn one by one: a map shows how many have an F in each range
RANGES = 10  # of F in that map
MAX_DOTS = 200  # of a selector; they lie at evenly spaced ranks of more values


def pair_name(pair):
    """Return sequence and pair as one name."""
    return " ".join(part for part in pair if part)


def values_of(run, group):
    """Return (pairs, selectors, F as pairs x selectors with NaN where there is none)."""
    names, pairs = run.selectors_of(group), run.pairs_of(group)
    f = np.array([run.pair_values(group, s) for s in names]).reshape(len(names), len(pairs)).T
    known = np.isfinite(f)
    shown, evaluated = known.any(axis=0), known.any(axis=1)
    return list(compress(pairs, evaluated)), list(compress(names, shown)), f[evaluated][:, shown]


def highest_of(selectors, f):
    """Return the highest F of each pair among the competing selectors, -1 where none has one."""
    competing = f[:, [i for i, s in enumerate(selectors) if not is_baseline(s)]]
    return np.max(np.where(np.isfinite(competing), competing, -1.0), axis=1, initial=-1.0)


def heat_map(figures, label, names, selectors, values, bold, name):
    """Draw values of 0 to 1 as one coloured cell per row and selector, each in percent written in its cell."""
    left = min(1.75, 0.25 + 0.075 * max(map(len, names)))
    width, height = left + 0.1 + 0.46 * len(selectors), 0.75 + 0.185 * len(names)
    figure, axes = new_axes(width, height, left, 0.1, 0.06, 0.69)
    axes.set_facecolor("#e6e6e6")
    for x, selector in enumerate(selectors):
        with marked(axes, selector):
            axes.pcolormesh(
                [x, x + 1],
                np.arange(len(names) + 1),
                np.ma.masked_invalid(values[:, [x]]),
                cmap="cividis",
                vmin=0,
                vmax=1,
                edgecolors="white",
                linewidth=0.6,
            )
            for y, value in enumerate(values[:, x]):
                known = np.isfinite(value)
                axes.text(
                    x + 0.5,
                    y + 0.52,
                    "%.0f" % (100 * value) if known else DASH,
                    ha="center",
                    va="center",
                    fontsize=8,
                    color="black" if not known or value > 0.5 else "white",
                    fontweight="bold" if bold[y, x] else "normal",
                )
    if is_baseline(selectors[-1]) and len(selectors) > 1:
        axes.axvline(len(selectors) - 1, color="white", linewidth=4)
    axes.set_xlim(0, len(selectors))
    axes.set_ylim(len(names), 0)
    axes.set_xticks(np.arange(len(selectors)) + 0.5)
    selector_ticks(axes.xaxis, selectors, 11, rotation=45, ha="left", rotation_mode="anchor")
    axes.set_yticks(np.arange(len(names)) + 0.5)
    axes.set_yticklabels([plot_text(name, 20) for name in names])
    axes.xaxis.tick_top()
    axes.tick_params(length=0, pad=3)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return figures(figure, label, name)


def pair_maps(run, figures, group, pairs, selectors, f):
    """Draw F of every pair, one row per pair, as one or several maps; bold where it reads like the highest."""
    label = "F of every pair of %s, selectors in columns" % group_text(group)
    whole = np.round(100 * f)
    bold = (whole > 0) & (whole == np.round(100 * highest_of(selectors, f))[:, None])
    bold[:, [is_baseline(s) for s in selectors]] = False
    names = list(map(pair_name, pairs))
    parts = [slice(i, i + PAIRS_IN_A_MAP) for i in range(0, len(pairs), PAIRS_IN_A_MAP)]
    name = figure_name(run, "per_pair", group)
    return [heat_map(figures, label, names[p], selectors, f[p], bold[p], name) for p in parts]


def range_map(run, figures, group, selectors, f):
    """Draw which share of a selector's pairs has an F in each range, the highest range first."""
    edges = np.arange(RANGES + 1) / RANGES
    names = ["%g to %g" % (100 * a, 100 * b) for a, b in zip(edges, edges[1:])]
    counts = np.array([np.histogram(column[np.isfinite(column)], edges)[0] for column in f.T]).T
    shares = counts / counts.sum(axis=0)
    label = "Share of the pairs of %s with an F in each range, selectors in columns" % group_text(group)
    name = figure_name(run, "per_pair", group)
    return heat_map(figures, label, names[::-1], selectors, shares[::-1], np.zeros(shares.shape, bool), name)


def pair_table(run, group, pairs, selectors, f):
    """Return one row per selector: on how many pairs it is best, mean, median and lowest F."""
    top = highest_of(selectors, f)
    columns = []
    for i, selector in enumerate(selectors):
        known = np.isfinite(f[:, i])
        values = f[known, i]
        wins = 0 if is_baseline(selector) else int(np.sum((values >= top[known]) & (values > 0)))
        worst = pairs[int(np.nanargmin(f[:, i]))]
        numbers = (wins, values.mean(), float(np.median(values)), int(np.sum(values >= HIGH_F)), values.min())
        columns.append((selector, numbers, worst, len(values)))
    competing = [numbers for selector, numbers, _, _ in columns if not is_baseline(selector)]
    best = [max(values) if len(values) > 1 and max(values) > 0 else None for values in zip(*competing)]
    rows = []
    for selector, numbers, worst, count in columns:
        base = is_baseline(selector)
        cells = []
        for value, highest, show in zip(numbers, best, (str, fraction, fraction, str, fraction)):
            rest = below(pair_name(worst)) if len(cells) == 4 else ""
            wins = not base and highest == value
            cells.append(best_cell(show(value), rest, "column") if wins else show(value) + rest)
        cells[0] = DASH if base else cells[0]
        rows.append((selector, (row_class(selector), [selector] + cells + [str(count)])))
    head = [
        "Selector",
        "Best on",
        "Mean F",
        "Median F",
        "F \u2265 %g" % HIGH_F,
        "Lowest F",
        "Pairs",
    ]
    caption = (
        "F pair by pair on %s: on how many pairs each selector has the highest F (ties count for all, an F of 0 for"
        " none), mean, median, pairs with F of at least %g, lowest F. \u25b2 best of the column."
        % (group_text(group), HIGH_F)
    )
    return table(caption, head, with_headings(rows), "results")


def distribution_panel(run, figures, group):
    """Draw F of every pair, one row of dots per selector with median and quartiles. '' without values."""
    selectors = [s for s in run.selectors_of(group) if np.isfinite(run.pair_values(group, s)).any()]
    if not selectors:
        return ""
    figure, axes = new_axes(5.0, max(3.6, 0.85 + 0.3 * len(selectors)), 1.15, 0.15, 0.5, 0.34)
    axes.grid(True, axis="x")
    for y, selector in enumerate(selectors):
        with marked(axes, selector):
            values = run.pair_values(group, selector)
            values = values[np.isfinite(values)]
            dots = values
            if len(values) > MAX_DOTS:
                dots = np.sort(values)[np.linspace(0, len(values) - 1, MAX_DOTS).round().astype(int)]
            jitter = 0.26 * (2 * ((np.arange(len(dots)) * 0.618034) % 1) - 1)
            colour = run.styles[selector]["colour"]
            edge = "#8a8420" if colour == YELLOW else colour
            axes.plot(
                dots,
                y + jitter,
                ".",
                color=colour,
                markeredgecolor=edge,
                markeredgewidth=0.4,
                markersize=4.2,
                alpha=0.6,
            )
            low, middle, high = np.percentile(values, [25, 50, 75])
            axes.plot([low, high], [y, y], color="#222222", linewidth=1.2, solid_capstyle="butt")
            axes.plot([middle], [y], "|", color="#222222", markersize=13, markeredgewidth=2.2)
    selector_rows(axes, selectors, 14, pad=0.4)
    axes.set_xlim(-0.02, 1.02)
    axes.set_xlabel("F of a pair")
    axes.set_title("F pair by pair", loc="left")
    label = "Distribution of F over the pairs of %s, one row per selector" % group_text(group)
    return figures(figure, label, figure_name(run, "pairs", group))


def distribution_text(run, group):
    """Return what the dots of the distribution show."""
    dots = "one dot per pair"
    if run.pair_count(group) > MAX_DOTS:
        dots = "%d dots for the %d pairs, at evenly spaced ranks of F" % (MAX_DOTS, run.pair_count(group))
    text = "F pair by pair: %s; the thick stroke is the median, the line spans the quartiles." % dots
    tau = run.tau(group)
    return "%s %s" % (text, "Labelled ground truth." if tau is None else "At %s." % at_tau(tau))


def distributions_html(run, figures):
    """Return the distributions of F of the groups that have no map."""
    mapped = groups_of(run, "per_pair") if "per_pair" in run.sections else []
    out = []
    for group in () if makes_variants(run) else run.groups:
        plot = "" if group in mapped else distribution_panel(run, figures, group)
        if plot:
            figure = panels([plot], distribution_text(run, group), "panels two")
            out.append(article(group_heading(group), figure))
    return joined(out)


def html(run, figures):
    """Return the body of the section."""
    out = []
    for group in groups_of(run, "per_pair") if "per_pair" in run.sections else ():
        pairs, selectors, f = values_of(run, group)
        if not pairs:
            continue
        tau = at_tau(run.tau(group))
        if len(pairs) <= MAX_PAIRS:
            maps = pair_maps(run, figures, group, pairs, selectors, f)
            text = "F in percent, one row per pair, %s; bold: highest of the row; grey: no ground truth or no result."
            text %= tau
        else:
            maps = [range_map(run, figures, group, selectors, f)]
            text = (
                "The share of each selector's pairs, in percent, whose F in percent lies in the range of the row, %s."
                " The %d pairs are too many for a row each; pairs.csv has them all." % (tau, len(pairs))
            )
        figure = BLOCKS.maps(maps, text, are_many(selectors))
        tables = pair_table(run, group, pairs, selectors, f), sources(run, "pairs.csv", "summary.csv")
        out.append(article(group_heading(group), figure, *tables))
    out.append(distributions_html(run, figures))
    return joined(out) or paragraph("The run has no pairs with an F yet.")
