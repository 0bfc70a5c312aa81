"""Experiment per_pair: F of every selector on every pair (the paper's Fig. 4)."""
from itertools import compress

import numpy as np

from .figures import marked, new_axes, plot_text, selector_ticks
from .markup import best_cell, group_heading, paragraph, sources, table, with_headings
from .scopes import figure_name, groups_of
from .selectors import are_many, is_baseline
from .words import at_tau, esc, fraction, group_text, interval

HIGH_F = 0.8  # a pair counts as solved from here on
PAIRS_IN_A_MAP = 60  # more pairs are drawn as several maps
MAX_PAIRS = 240  # more pairs are not drawn one by one: a map shows how many have an F in each range
RANGES = 10  # of F in that map


def pair_name(pair):
    """Return sequence and pair as one name."""
    return " ".join(part for part in pair if part)


def values_of(run, group):
    """Return (pairs, selectors, F as pairs x selectors with NaN where there is none)."""
    names, pairs = run.selectors_of(group), run.pairs_of(group)
    f = np.array([run.pair_values(group, s) for s in names]).reshape(len(names), len(pairs)).T
    known = np.isfinite(f)
    shown, judged = known.any(axis=0), known.any(axis=1)
    return list(compress(pairs, judged)), list(compress(names, shown)), f[judged][:, shown]


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
                    "%.0f" % (100 * value) if known else "\u2013",
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
        wins = None if is_baseline(selector) else int(np.sum((values >= top[known]) & (values > 0)))
        worst = pairs[int(np.nanargmin(f[:, i]))]
        columns.append(
            (
                selector,
                wins,
                values.mean(),
                float(np.median(values)),
                int(np.sum(values >= HIGH_F)),
                values.min(),
                worst,
                len(values),
            )
        )
    best = {}
    for k in range(1, 6):
        values = [c[k] for c in columns if not is_baseline(c[0])]
        best[k] = max(values) if len(values) > 1 and max(values) > 0 else None
    rows = []
    for column in columns:
        base, row = is_baseline(column[0]), run.mean(group, column[0], run.tau(group))
        texts = [
            "\u2013" if base else str(column[1]),
            fraction(column[2]),
            fraction(column[3]),
            str(column[4]),
            fraction(column[5]),
        ]
        rests = ["", "", "", "", '<br><span class="small">%s</span>' % esc(pair_name(column[6]))]
        cells = [
            best_cell(text, rest, "column") if not base and best[k] == column[k] else text + rest
            for k, (text, rest) in enumerate(zip(texts, rests), 1)
        ]
        cells.insert(2, esc(interval(row)) if row else "\u2013")
        row = ("baseline" if base else "", [esc(column[0])] + cells + [str(column[7])])
        rows.append((column[0], row))
    head = [
        "Selector",
        "Best on",
        "Mean F",
        "Interval",
        "Median F",
        "F \u2265 %g" % HIGH_F,
        "Lowest F",
        "Pairs",
    ]
    caption = (
        "F pair by pair on %s: on how many pairs each selector has the highest F (ties count for all, an F of 0 for"
        " none), mean with 95 %% interval, median, pairs with F of at least %g, lowest F. \u25b2 best of the column."
        % (group_text(group), HIGH_F)
    )
    return table(esc(caption), head, with_headings(rows), "results")


def html(run, figures):
    """Return the body of the section."""
    out = []
    for group in groups_of(run, "per_pair"):
        pairs, selectors, f = values_of(run, group)
        if not pairs:
            continue
        out.append('<article class="group"><h3>%s</h3>' % group_heading(group))
        if len(pairs) <= MAX_PAIRS:
            maps = pair_maps(run, figures, group, pairs, selectors, f)
            text = (
                "F in percent, one row per pair, %s; bold: highest of the row; grey: no ground truth or no result."
                % at_tau(run.tau(group))
            )
        else:
            maps = [range_map(run, figures, group, selectors, f)]
            text = (
                "The share of each selector's pairs, in percent, whose F in percent lies in the range of the row, %s."
                " The %d pairs are too many for a row each; pairs.csv has them all."
                % (at_tau(run.tau(group)), len(pairs))
            )
        out.append(
            '<figure class="figure map%s"><div class="scroll" role="region" aria-label="F of every pair"'
            ' tabindex="0">%s</div><figcaption>%s</figcaption></figure>'
            % (" wide" if are_many(selectors) else "", "".join(maps), esc(text))
        )
        out += [
            pair_table(run, group, pairs, selectors, f),
            sources(run, "pairs.csv", "summary.csv"),
            "</article>",
        ]
    return "\n".join(out) or paragraph("The run has no pairs of this experiment yet.")
