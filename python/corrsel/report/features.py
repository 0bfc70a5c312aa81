"""Experiment features: other detectors and descriptors (the paper's Fig. 8 and Table III)."""
from . import paper, results
from .compared import Block, comparison_table, dataset_notes, group_label, interval_text, measured
from .compared import paper_dataset, paper_label, printed_f
from .markup import joined, paragraph, sources
from .scopes import groups_of, is_main
from .words import GIVEN


def html(run, figures):
    """Return the body of the section."""
    groups = groups_of(run, "features")
    if not groups:
        return paragraph("The run has no means of other features yet.")
    datasets = {group.dataset for group in groups}
    shown = [
        g
        for g in run.groups
        if g in run.means and is_main(run, g) and g.features != GIVEN and g.dataset in datasets
    ]
    blocks = []
    order = list(dict.fromkeys(group.dataset for group in shown + groups))
    for group in sorted(shown + groups, key=lambda g: order.index(g.dataset)):
        theirs, source = printed_f(run, group) or (None, paper.FEATURES_SOURCE)
        label = paper_label(source, paper_dataset(group.dataset)) if theirs else ""
        blocks.append(Block(group_label(group, group.features), measured(run, group), label, theirs))
    caption = "Mean F by detector and descriptor. %s" % interval_text()
    out = [comparison_table(caption, blocks), sources(run, "summary.csv", "pairs.csv")]
    out += [paragraph(note, "small") for note in dataset_notes(run, [g.dataset for g in groups])]
    out.append(results.groups_html(run, figures, groups, "features"))
    return joined(out)
