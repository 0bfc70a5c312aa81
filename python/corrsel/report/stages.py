"""Where the time of the whole run went, by stage and dataset; memory."""
import numpy as np

from .figures import name_rows, new_axes, plot_text
from .markup import DASH, Cell, bold, dataset_html, joined, panels, paragraph, sources, table

# Of a dataset; others are of the whole run.
STAGES = ("read", "features", "match", "select", "evaluate", "pose")
# Okabe-Ito colours and hatches, distinguishable in grey as well.
STYLES = (
    ("#56B4E9", ""),
    ("#0072B2", ""),
    ("#009E73", "///"),
    ("#E69F00", ""),
    ("#CC79A7", "\\\\\\"),
    ("#F0E442", ""),
)


def duration(seconds):
    """Return a duration as text, in s, min or h."""
    if seconds < 0.0005:
        return "0 s" if seconds == 0 else "<1 ms"
    if seconds < 100:
        return "%.*f s" % (3 if seconds < 1 else 1, seconds)
    if seconds < 6000:
        return "%d min %02d s" % divmod(round(seconds), 60)
    return "%d h %02d min" % divmod(round(seconds / 60), 60)


def duration_cell(seconds):
    """Return the cell of a duration, whose text alone could not be sorted."""
    return Cell(duration(seconds), value="%.6f" % seconds)


def sums(run):
    """Return (dataset -> stage -> s, dataset -> number of pairs, stage -> s of the stages of no dataset)."""
    datasets, pairs, whole = {}, {}, {}
    rows = run.stages
    known = np.isfinite(rows["seconds"])
    cells, first = rows.numbering("dataset", "stage")
    totals = np.bincount(cells[known], weights=rows["seconds"][known], minlength=len(first))
    counts = np.bincount(cells[known], minlength=len(first))
    for i in np.flatnonzero(counts):
        dataset, stage = (rows.texts[name][rows[name][first[i]]] for name in ("dataset", "stage"))
        (datasets.setdefault(dataset, {}) if dataset else whole)[stage] = float(totals[i])
    for dataset in datasets:
        of_dataset = known & (rows["dataset"] == rows.code("dataset", dataset)) & np.isfinite(rows["number"])
        pairs[dataset] = len(np.unique(rows["number"][of_dataset]))
    return datasets, pairs, whole


def stages_of(datasets):
    """Return the names of the stages there are, the known ones first."""
    found = dict.fromkeys(stage for stages in datasets.values() for stage in stages)
    return [s for s in STAGES if s in found] + sorted(s for s in found if s not in STAGES)


def stage_panel(figures, datasets):
    """Draw the time of each dataset as one bar made of its stages."""
    names = stages_of(datasets)
    figure, axes = new_axes(5.2, 1.25 + 0.34 * len(datasets), 1.85, 0.15, 0.48, 0.66)
    longest = max(sum(stages.values()) for stages in datasets.values())
    scale, unit = (1, "s") if longest < 300 else (60, "min") if longest < 18000 else (3600, "h")
    for i, name in enumerate(names):
        colour, hatch = STYLES[i % len(STYLES)]
        left = [sum(stages.get(other, 0) for other in names[:i]) / scale for stages in datasets.values()]
        width = [stages.get(name, 0) / scale for stages in datasets.values()]
        axes.barh(
            range(len(datasets)),
            width,
            left=left,
            height=0.62,
            color=colour,
            hatch=hatch,
            label=plot_text(name),
            edgecolor="white",
            linewidth=0.5,
        )
    name_rows(axes, [plot_text(dataset, 26) for dataset in datasets])
    axes.set_xlabel("time (%s)" % unit)
    axes.grid(True, axis="x")
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(-0.05, 1.0),
        ncol=3,
        frameon=False,
        fontsize=8,
        borderaxespad=0.2,
        handlelength=1.2,
        columnspacing=1.0,
        handletextpad=0.4,
    )
    return figures(figure, "Time of the run by dataset and stage", "stages")


def html(run, figures):
    """Return the body of the section."""
    datasets, pairs, whole = sums(run)
    out = []
    if datasets or whole:
        names = stages_of(datasets)
        rows, totals = [], {n: 0.0 for n in names}
        for dataset, stages in datasets.items():
            cells = [dataset_html(dataset), str(pairs[dataset])]
            for name in names:
                totals[name] += stages.get(name, 0.0)
                cells.append(duration_cell(stages[name]) if name in stages else DASH)
            rows.append(("", cells + [duration_cell(sum(stages.values()))]))
        rows += [("", [stage] + [DASH] * (len(names) + 1) + [duration_cell(s)]) for stage, s in whole.items()]
        everything = sum(totals.values()) + sum(whole.values())
        cells = [bold("all"), str(sum(pairs.values()))] + [duration(s) for s in totals.values()]
        rows.append(("total", cells + [bold(duration(everything))]))
        head = ["Dataset or stage", "Pairs"] + [name for name in names] + ["all"]
        caption = (
            "Wall time by stage, summed over the pairs. Rows below the datasets are stages of the whole run."
        )
        out += [table(caption, head, rows, "results times"), sources(run, "stages.csv")]
        if any(sum(stages.values()) > 0 for stages in datasets.values()):
            out.append(panels([stage_panel(figures, datasets)], css="single"))
    else:
        out.append(paragraph("The run recorded no times by stage."))
    memory = run.state.get("peak_memory_mib")
    if isinstance(memory, (int, float)):
        out.append(paragraph("Peak memory of the run: %.0f MiB." % memory))
    return joined(out)
