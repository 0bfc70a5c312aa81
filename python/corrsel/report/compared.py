"""The paper's numbers beside those of the run, in percent as the paper prints them."""
from collections import namedtuple

from . import paper
from .markup import DASH, Cell, below, best_cell, breakable, lines, row_class, table, transposed, with_badge
from .markup import with_headings
from .scopes import is_main
from .selectors import are_many, is_baseline, selector_key
from .words import GIVEN, data_kind, plural, span

STAND_INS = {"heinly_generated": "heinly"}  # generated dataset -> the paper's dataset it stands in for

# One measure of the run, and the paper's where there is one. `ours`: selector -> (value, low, high), fractions,
# bounds None where there is no interval. `theirs`: selector -> percent.
Block = namedtuple("Block", "label ours paper_label theirs")


def paper_dataset(dataset):
    """Return the paper's dataset that a dataset is, or that it replaces; None without one."""
    name = STAND_INS.get(dataset, dataset)
    return name if name in paper.DATASET_PAIRS else None


def dataset_notes(run, datasets):
    """Return sentences on where the datasets of the run are not those of the paper."""
    notes = []
    for dataset in dict.fromkeys(datasets):
        theirs, count = paper_dataset(dataset), run.datasets.get(dataset, 0)
        if dataset in STAND_INS:
            notes.append(
                "%s stands in for the paper's %s (%d pairs, not available here): its %s generated, so the numbers"
                " side by side are of different images."
                % (dataset, theirs, paper.DATASET_PAIRS[theirs], plural(count, "pair is", "pairs are"))
            )
        elif dataset.endswith("_reconstructed"):
            notes.append(
                "%s holds %s rebuilt from published points and images; it is kept apart and has no numbers of the"
                " paper beside it." % (dataset, plural(count, "pair"))
            )
        elif theirs and count != paper.DATASET_PAIRS[theirs]:
            notes.append(
                "%s has %s here and %d in the paper."
                % (dataset, plural(count, "pair"), paper.DATASET_PAIRS[theirs])
            )
    return notes


def measured(run, group, column="f_paper"):
    """Return selector -> (value, low, high) of one column of summary.csv at the tabulated tolerance."""
    out, tau = {}, run.tau(group)
    for selector in run.selectors_of(group):
        row = run.mean(group, selector, tau)
        if row is not None and row[column] is not None:
            bounds = (row["f_paper_lo"], row["f_paper_hi"]) if column == "f_paper" else (None, None)
            out[selector] = (row[column],) + bounds
    return out


def printed_f(run, group):
    """Return (selector -> percent, source) the paper printed as F for a group's setting; None without one."""
    dataset = paper_dataset(group.dataset)
    if group.preselection == "nnsr" and group.features == paper.FEATURES_DEFAULT:
        return (
            (paper.PRESELECTED[dataset], paper.PRESELECTED_SOURCE) if dataset in paper.PRESELECTED else None
        )
    if group.preselection not in ("", "none"):
        return None
    if group.dataset == "adelaidermf" and group.features == GIVEN:
        return paper.ADELAIDE["f"], paper.ADELAIDE_SOURCE
    key = (group.features, dataset)
    return (paper.FEATURES[key], paper.FEATURES_SOURCE) if key in paper.FEATURES else None


def paper_winner(run, group):
    """Return (selectors, source) the paper puts first in a group's setting; None where it names none."""
    printed = printed_f(run, group)
    if printed:
        values, source = printed
        return [max(values, key=values.get)], source
    dataset, key = paper_dataset(group.dataset), None
    if dataset and group.preselection == "nnsr" and group.features == paper.FEATURES_DEFAULT:
        key = "nnsr_" + dataset
    elif dataset and is_main(run, group) and group.features in (GIVEN, paper.FEATURES_DEFAULT):
        key = dataset
    elif dataset == "vgg" and group.preselection in ("", "none"):
        key = group.features
    advice = paper.GUIDE.get(key)
    return (list(advice.superior), paper.GUIDE_SOURCE) if advice else None


def percent(value):
    """Return a fraction in percent with one decimal."""
    return "%.1f" % (100 * value)


def best_selectors(values, show):
    """Return the competing selectors whose value reads like the highest one; none if fewer than two compete."""
    competing = {s: v for s, v in values.items() if not is_baseline(s)}
    if len(competing) < 2:
        return set()
    best = show(max(competing.values()))
    return {s for s, v in competing.items() if show(v) == best}


def comparison_table(caption, blocks):
    """Return a table with one row per block and selectors in columns, the paper's row below where there is one.

    Many selectors are rows, under the names of their groups, and the blocks columns.
    """
    names = {s for block in blocks for s in list(block.ours) + list(block.theirs or ())}
    selectors = sorted(names, key=selector_key)
    many = are_many(selectors)
    line = "column" if many else "row"
    rows = []
    for block in blocks:
        best = best_selectors({s: v[0] for s, v in block.ours.items()}, percent)
        cells = [block.label]
        for s in selectors:
            if s not in block.ours:
                cells.append(DASH)
                continue
            value, low, high = block.ours[s]
            rest = "" if None in (low, high) else below(span(low, high, percent))
            if s in best:
                cells.append(best_cell(percent(value), rest, line))
            else:
                cells.append(Cell(percent(value) + rest, "base" if is_baseline(s) else ""))
        rows.append(("", cells))
        if block.theirs:
            best = best_selectors(block.theirs, "{:.2f}".format)
            cells = [block.paper_label]
            for s in selectors:
                text = "%.2f" % block.theirs[s] if s in block.theirs else DASH
                cells.append(best_cell(text, of=line) if s in best else text)
            rows.append(("paper", cells))
    head = [""] + selectors
    if many:
        head, columns = transposed(head, rows)
        rows = with_headings([(s, (row_class(s), c)) for s, c in zip(selectors, columns)])
        return table(caption, head, rows, "results", long=True)
    return table(caption, head, rows, "results compared", long=len(rows) > 20)


def group_label(group, *words):
    """Return the label of a row of the run."""
    kind, name = data_kind(group.dataset), breakable(group.dataset)
    words = [word for word in words if word]
    return (name if kind == "real" else with_badge(name, kind)) + (below(lines(words)) if words else "")


def paper_label(source, dataset=None):
    """Return the label of a row of the paper: where it is printed, and on what."""
    pairs = "%s, %d pairs; " % (dataset, paper.DATASET_PAIRS[dataset]) if dataset else ""
    return "paper" + below(pairs + source.split(", ", 1)[-1])


def interval_text():
    """Return what the numbers of a comparison are."""
    return (
        "In percent. Below each value of this run its 95 % interval; \u25b2 highest of the selectors (the baseline does"
        " not compete). Beside it what the paper printed, without interval."
    )
