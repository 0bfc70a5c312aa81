"""Experiment unrelated: what the selectors select where all matches are outliers, and whether they know it."""
from collections import namedtuple

import numpy as np
from markupsafe import Markup

from .figures import draw_part, line_figures, new_axes, part_ending, plot_text, visible
from .markup import DASH, article, best_cell, bold, dataset_html, joined, paragraph, row_class, selector_name
from .markup import sources, table, text_cell, with_headings
from .selectors import is_baseline, selector_key
from .words import UNRELATED, features_text, is_unrelated, plural, preselection_text

MORE_THAN = 8  # selected matches, with status ok: the pair is accepted
SMALLEST_SHARE = 1e-3  # left end of the logarithmic axis

# Selections, as arrays: whether the status is ok, how many matches are selected, and the confidence (NaN = none).
Selections = namedtuple("Selections", "ok selected confidence")
NOTHING = Selections(np.empty(0, bool), np.empty(0), np.empty(0))


def selections_of(rows):
    """Return the Selections of a selector's Rows, one entry per pair and seed; None without any."""
    usable = np.isfinite(rows["n_selected"]) & ~rows.has("status", "unsupported_input", "failed")
    first = rows.selections()
    first = first[usable[first]]
    if len(first) == 0:
        return None
    return Selections(
        rows.has("status", "", "ok")[first], rows["n_selected"][first], rows["confidence"][first]
    )


def cells_of(run):
    """Return (features, preselection) -> dataset -> selector -> Selections, of the cells with unrelated pairs."""
    cells = {}
    for group in run.pairs.groups:
        datasets = cells.setdefault((group.features, group.preselection), {})
        found = {s: selections_of(run.rows(group, s)) for s in run.pairs.selectors_of(group)}
        found = {s: e for s, e in found.items() if e is not None}
        if found:
            datasets[group.dataset] = found
    return {key: cell for key, cell in cells.items() if any(is_unrelated(d) for d in cell)}


def unrelated_of(cell, selector):
    """Return a selector's selections on all unrelated pairs of a cell."""
    found = [by[selector] for dataset, by in cell.items() if is_unrelated(dataset) and selector in by]
    return Selections(*map(np.concatenate, zip(*found))) if found else NOTHING


def count_of(selections):
    """Return the number of selections."""
    return len(selections.ok)


def related_datasets(cell):
    """Return the datasets of a cell whose pairs show one scene, where the cell has unrelated ones of them too."""
    return [d for d in cell if not is_unrelated(d) and UNRELATED + d in cell]


def accepted(selections):
    """Return the number of selections with the status ok and more than MORE_THAN matches."""
    return int(np.sum(selections.ok & (selections.selected > MORE_THAN)))


def has_confidence(cell, selector):
    """Tell whether a selector has a confidence on any pair."""
    return any((by[selector].confidence > 0).any() for by in cell.values() if selector in by)


def scores(cell, selector, selections):
    """Return what is compared with a threshold: the confidence, or else the number selected with the status ok."""
    if has_confidence(cell, selector):
        return np.nan_to_num(selections.confidence)
    return np.where(selections.ok, selections.selected, 0.0)


def roc(related, unrelated):
    """Return the shares of unrelated and of related pairs at or above each threshold, from (0, 0) to (1, 1)."""
    thresholds = np.unique(np.concatenate([related, unrelated]))[::-1]
    x, y = (
        (len(values) - np.searchsorted(np.sort(values), thresholds)) / len(values)
        for values in (unrelated, related)
    )
    return np.concatenate([[0.0], x]), np.concatenate([[0.0], y])


def area(related, unrelated):
    """Return the area under the ROC; None without pairs of both kinds.

    It is the probability that a related pair has the higher score than an unrelated one; ties count one half.
    """
    if len(related) == 0 or len(unrelated) == 0:
        return None
    x, y = roc(related, unrelated)
    return float(np.sum(np.diff(x) * (y[1:] + y[:-1])) / 2)


def share_text(count, total):
    """Return a count with its share in percent."""
    return DASH if not total else "%.1f %%" % (100.0 * count / total)


def selectors_of(cell):
    """Return the selectors of a cell in the report's order."""
    return sorted({s for by in cell.values() for s in by}, key=selector_key)


def areas_of(cell, selector):
    """Return dataset -> area under the ROC of its pairs against all unrelated pairs of the cell."""
    unrelated = scores(cell, selector, unrelated_of(cell, selector))
    return {
        dataset: area(scores(cell, selector, cell[dataset].get(selector, NOTHING)), unrelated)
        for dataset in related_datasets(cell)
    }


def cell_table(name, cell):
    """Return the table of a cell: shares of accepted pairs, and areas under the ROC."""
    datasets = related_datasets(cell)
    head = ["Selector", "Unrelated pairs", "of them accepted", "Accepted"]
    head += ["%s: accepted" % d for d in datasets]
    head += ["Score of the ROC"] + ["%s: area" % d for d in datasets]
    values = {}
    for selector in selectors_of(cell):
        unrelated = unrelated_of(cell, selector)
        values[selector] = (unrelated, accepted(unrelated), areas_of(cell, selector))
    competing = [v for s, v in values.items() if not is_baseline(s) and count_of(v[0])]
    lowest = min((v[1] / count_of(v[0]) for v in competing), default=None)
    highest = {d: max((v[2][d] for v in competing if v[2][d] is not None), default=None) for d in datasets}
    rows = []
    for selector, (unrelated, count, areas) in values.items():
        base = is_baseline(selector)
        total = count_of(unrelated)
        share = share_text(count, total)
        best = not base and total and count / total == lowest
        cells = [selector_name(selector), str(total), str(count)]
        cells.append(best_cell(share, of="column", mark="") if best else share)
        for dataset in datasets:
            right = cell[dataset].get(selector, NOTHING)
            cells.append(share_text(accepted(right), count_of(right)))
        cells.append(text_cell("confidence" if has_confidence(cell, selector) else "number selected"))
        for dataset in datasets:
            value = areas[dataset]
            text = DASH if value is None else "%.3f" % value
            best = not base and value is not None and value == highest[dataset]
            cells.append(best_cell(text, of="column") if best else text)
        rows.append((selector, (row_class(selector), cells)))
    caption = (
        "Pairs of different scenes, %s. A pair is accepted if more than %d matches are selected with the status ok."
        " Area: area under the ROC of the score between the pairs of the dataset and all unrelated pairs; 1 means that"
        " a threshold separates them, 0.5 that the score tells nothing." % (name, MORE_THAN)
    )
    return table(caption, head, with_headings(rows), "results")


def roc_panel(run, figures, name, cell, dataset, part):
    """Draw the ROC of the selectors of a part between the pairs of a dataset and all unrelated pairs of the cell."""
    figure, axes = new_axes(4.6, 3.6, 0.55, 0.15, 0.5, 0.34)

    def line_of(selector, named):
        related = scores(cell, selector, cell[dataset].get(selector, NOTHING))
        unrelated = scores(cell, selector, unrelated_of(cell, selector))
        if len(related) == 0 or len(unrelated) == 0:
            return None
        x, y = roc(related, unrelated)
        x = np.maximum(x, SMALLEST_SHARE)
        shown = visible(np.log10(x), y)
        return np.repeat(x[shown], 2)[1:], np.repeat(y[shown], 2)[:-1]  # no interpolation between thresholds

    draw_part(axes, run, part, line_of, markevery=0.2)
    axes.set_xscale("log")
    axes.set_xlim(SMALLEST_SHARE, 1.1)
    axes.set_ylim(-0.02, 1.03)
    axes.set_xlabel("share of unrelated pairs above the threshold (logarithmic)")
    axes.set_title("%s: share of its pairs above the threshold" % plot_text(dataset), loc="left")
    axes.grid(True)
    label = "ROC between the pairs of %s and unrelated pairs, %s" % (dataset, name)
    return figures(figure, label, "unrelated_%s_%s%s" % (dataset, name, part_ending(part)))


def statement(cell):
    """Return who accepts the fewest unrelated pairs, as a sentence; '' without competing selectors."""
    counts = {}
    for selector in selectors_of(cell):
        unrelated = unrelated_of(cell, selector)
        if count_of(unrelated) and not is_baseline(selector):
            counts[selector] = (accepted(unrelated), count_of(unrelated))
    if not counts:
        return ""
    lowest = min(count / total for count, total in counts.values())
    names = [s for s, (count, total) in counts.items() if count / total == lowest]
    count, total = counts[names[0]]
    return Markup("%s accept%s the fewest: %d of %d unrelated pairs (%s).") % (
        joined(map(bold, names), " and "),
        "" if len(names) > 1 else "s",
        count,
        total,
        share_text(count, total),
    )


def cell_html(run, figures, key, cell):
    """Return table and figure of one cell."""
    features, preselection = key
    name = features_text(features)
    if preselection not in ("", "none"):
        name += ", " + preselection_text(preselection)
    blocks = [paragraph(statement(cell)), cell_table(name, cell)]
    if related_datasets(cell):

        def plots(part):
            return (roc_panel(run, figures, name, cell, d, part) for d in related_datasets(cell))

        caption = (
            "Share of a dataset's pairs against the share of unrelated pairs whose score reaches a threshold, for all"
            " thresholds."
        )
        blocks.append(line_figures(run, figures, selectors_of(cell), plots, "panels", caption))
    return article(name, *blocks)


def html(run, figures):
    """Return the body of the section."""
    cells = cells_of(run)
    if not cells:
        return paragraph("The run has no unrelated pairs yet.")
    datasets = list(dict.fromkeys(d for cell in cells.values() for d in cell if is_unrelated(d)))
    counts = (Markup("%s (%s)") % (dataset_html(d), plural(run.datasets[d], "pair")) for d in datasets)
    intro = Markup(
        "Each of these pairs consists of two images of different scenes, so that every match is an outlier: %s."
    ) % joined(counts, "; ")
    out = [paragraph(intro), sources(run, "pairs.csv")]
    out += [cell_html(run, figures, key, cell) for key, cell in cells.items()]
    return joined(out)
