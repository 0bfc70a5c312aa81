"""Experiment preselected: the survivors of NNSR as input (the paper's Fig. 6)."""
from . import paper, results
from .compared import Block, comparison_table, dataset_notes, group_label, interval_text, measured
from .compared import paper_dataset, paper_label, printed_f
from .figures import edge_of, line_style, marked, new_axes, plot_text, selector_rows
from .markup import joined, panels, paragraph, sources
from .reading import Group
from .scopes import groups_of
from .selectors import is_baseline
from .words import group_text, preselection_text


def without(run, group):
    """Return the same group without preselection; None where the run has none."""
    plain = Group(group.dataset, group.features, "none")
    return plain if plain in run.means else None


def arrow_panel(run, figures, group):
    """Draw each selector's F without (hollow) and with preselection (full), joined by a line; '' without both."""
    plain = without(run, group)
    before, after = (measured(run, plain) if plain else {}), measured(run, group)
    selectors = [s for s in run.selectors_of(group) if s in before and s in after]
    if not selectors:
        return ""
    figure, axes = new_axes(3.9, 0.95 + 0.27 * len(selectors), 1.05, 0.15, 0.48, 0.34)
    axes.grid(True, axis="x")
    for y, selector in enumerate(selectors):
        with marked(axes, selector):
            style, colour = line_style(run.styles[selector]), edge_of(run.styles[selector])
            style.update(linestyle="none", markersize=7)
            x0, x1 = before[selector][0], after[selector][0]
            axes.plot([x0, x1], [y, y], color=colour, linewidth=1.4)
            axes.plot([x0], [y], **dict(style, markerfacecolor="white", markeredgecolor=colour))
            axes.plot([x1], [y], **dict(style, markerfacecolor=style["color"]))
    selector_rows(axes, selectors, 13)
    axes.set_xlim(-0.03, 1.03)
    axes.set_xlabel("mean F: hollow without, full with preselection")
    axes.set_title(plot_text(group.dataset, 40), loc="left")
    label = "Mean F without and with preselection for %s" % group_text(group)
    return figures(figure, label, "preselected_%s_before_after" % group.dataset)


def change_text(run, group):
    """Return for how many selectors the preselection raises the mean F, and by how much at most."""
    plain = without(run, group)
    before, after = (measured(run, plain) if plain else {}), measured(run, group)
    changes = {s: after[s][0] - before[s][0] for s in after if s in before and not is_baseline(s)}
    if not changes:
        return ""
    up = sum(change > 0 for change in changes.values())
    most = max(changes, key=lambda s: abs(changes[s]))
    return (
        "%s: preselection raises the mean F of %d of %d selectors; it changes most for %s (%+.1f points)."
        % (group.dataset, up, len(changes), most, 100 * changes[most])
    )


def html(run, figures):
    """Return the body of the section."""
    groups = groups_of(run, "preselected")
    if not groups:
        return paragraph("The run has no means after preselection yet.")
    blocks = []
    for group in groups:
        plain, printed = without(run, group), printed_f(run, group)
        if plain:
            blocks.append(Block(group_label(group, "no preselection"), measured(run, plain), "", None))
        theirs, source = printed or (None, paper.PRESELECTED_SOURCE)
        label = paper_label(source, paper_dataset(group.dataset)) if printed else ""
        text = preselection_text(group.preselection)
        blocks.append(Block(group_label(group, text), measured(run, group), label, theirs))
    caption = "Mean F without and after preselection. %s" % interval_text()
    out = [comparison_table(caption, blocks), sources(run, "summary.csv", "pairs.csv")]
    out += [paragraph(note, "small") for note in dataset_notes(run, [g.dataset for g in groups])]
    out += [paragraph(text) for text in (change_text(run, g) for g in groups) if text]
    plots = [plot for plot in (arrow_panel(run, figures, g) for g in groups) if plot]
    if plots:
        text = "Mean F of each selector without and with preselection; recall is relative to the survivors."
        out.append(panels(plots, text))
    out.append(results.groups_html(run, figures, groups, "preselected"))
    return joined(out)
