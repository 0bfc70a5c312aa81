"""What failed, what was left out, and how the selections ended."""
from collections import Counter

from markupsafe import Markup

from .markup import Cell, cut_rows, joined, paragraph, row_class, table, text_cell
from .reading import FAILURES_HEADER
from .words import STATUSES, features_text, number, plural, preselection_text


def status_table(run):
    """Return the table of statuses per selector."""
    counts = {s: Counter() for s in run.selectors}
    for (_, selector), statuses in run.statuses.items():
        counts[selector].update(statuses)
    names = list(STATUSES) + sorted({n for c in counts.values() for n in c} - set(STATUSES))
    rows = []
    for selector, counter in counts.items():
        cells = [Cell("0", "zero") if counter[n] == 0 else str(counter[n]) for n in names]
        rows.append((row_class(selector), [selector] + cells + [str(sum(counter.values()))]))
    shown = [name.replace("_", " ").replace("unsupported input", "unsupported") for name in names]
    head = ["Selector"] + shown + ["all"]
    caption = "How the selections ended: one count per pair, kind of features, preselection and seed, not per tolerance."
    return table(caption, head, rows, "results counts")


def html(run, figures):
    """Return the body of the section."""
    out = []
    if run.failures:
        stages = Counter(row["stage"] for row in run.failures)
        text = ", ".join("%d at stage %s" % (n, s or "(not named)") for s, n in sorted(stages.items()))
        out.append(
            paragraph(Markup("<b>%s</b> recorded: %s.") % (plural(len(run.failures), "failure"), text))
        )
        shown, rest = cut_rows(run.failures, "failures.csv")
        rows = [("", [r["dataset"]] + [text_cell(r[k]) for k in FAILURES_HEADER[1:]]) for r in shown]
        head = [name.capitalize() for name in FAILURES_HEADER]
        out += [table("Pairs on which a stage failed.", head, rows, "texts", long=len(rows) > 15), rest]
    else:
        out.append(paragraph("No failures are recorded."))
    if run.left_out:
        count = len({(g.dataset, s, p) for g, s, p in run.left_out})
        text = Markup(
            "<b>%s</b> %s no ground-truth inlier among the putative matches in at least one setting, so recall and F are"
            " undefined there; the pair is left out of the means of that setting."
        )
        out.append(paragraph(text % (plural(count, "pair"), "has" if count == 1 else "have")))
        shown, rest = cut_rows(list(run.left_out.items()), "pairs.csv")
        rows = []
        for (group, sequence, pair), left in shown:
            words = [sequence, pair, features_text(group.features), preselection_text(group.preselection)]
            words.append(left.cause)
            cells = [text_cell(w) for w in words]
            rows.append(("", [group.dataset] + cells + [number(left.putative)]))
        head = ["Dataset", "Sequence", "Pair", "Features", "Preselection", "It has", "Matches"]
        out += [table("Pairs left out of the means.", head, rows, "texts", long=len(rows) > 15), rest]
    elif run.pairs:
        out.append(paragraph("Every pair has ground-truth inliers; none is left out of the means."))
    if run.statuses:
        out.append(status_table(run))
    return joined(out)
