"""Experiment overall: precision, recall and F on every dataset (the paper's Fig. 3)."""
from . import paper, results
from .compared import Block, comparison_table, dataset_notes, group_label, interval_text, measured
from .compared import paper_label
from .markup import below, joined, paragraph, sources
from .scopes import groups_of, main_features
from .words import GIVEN, at_tau, features_text, plural


def labelled_table(run, group):
    """Return precision, recall and F on AdelaideRMF, the paper's row below each."""
    measures = (
        ("Precision", "precision", "precision"),
        ("Recall", "recall_paper", "recall"),
        ("F", "f_paper", "f"),
    )
    blocks = [
        Block(
            title + below("this run"),
            measured(run, group, column),
            paper_label(paper.ADELAIDE_SOURCE),
            paper.ADELAIDE[key],
        )
        for title, column, key in measures
    ]
    rows = [r for r in run.ranking(group) if r["pairs"] is not None]
    count = plural(int(max(r["pairs"] for r in rows)), "pair") if rows else "no pairs"
    caption = "AdelaideRMF, labelled ground truth: %s here, %d in the paper. %s" % (
        count,
        paper.DATASET_PAIRS["adelaidermf"],
        interval_text(),
    )
    return comparison_table(caption, blocks)


def html(run, figures):
    """Return the body of the section."""
    groups = groups_of(run, "overall")
    if not groups:
        return paragraph("The run has no means without preselection for these features yet.")
    blocks = [Block(group_label(g, at_tau(run.tau(g))), measured(run, g), "", None) for g in groups]
    caption = "Mean F of every selector on every dataset, with %s. %s" % (
        features_text(main_features(run)),
        "In percent, with its 95 % interval below; \u25b2 highest of the selectors. The paper shows these as curves only.",
    )
    out = [comparison_table(caption, blocks), sources(run, "summary.csv", "pairs.csv")]
    labelled = [g for g in groups if g.dataset == "adelaidermf" and g.features == GIVEN and run.ranking(g)]
    out += [labelled_table(run, group) for group in labelled]
    out += [paragraph(note, "small") for note in dataset_notes(run, [g.dataset for g in groups])]
    out.append(results.groups_html(run, figures, groups, "overall"))
    return joined(out)
