"""What won where: the state of the run and the table of the winners."""
from .compared import dataset_notes, paper_dataset, paper_winner
from .markup import breakable, dataset_html, paragraph, sources, table
from .paper import SOURCE
from .scopes import is_main
from .remarks import remark_sentences
from .selectors import BASELINE, is_baseline
from .standings import standing
from .words import (
    kind_text,
    at_tau,
    bracket,
    esc,
    features_text,
    fraction,
    group_text,
    interval,
    milliseconds,
    number,
    plural,
    preselection_text,
)


MAX_FINDINGS = 8  # further sentences on single groups are shown with the groups, not in the overview


def state_html(run):
    """Return the one-line state of the run, a banner where it is not complete."""
    done, total = run.state.get("pairs_done"), run.state.get("pairs_total")
    counted = "%s of %s pairs" % (done, total) if done is not None and total is not None else "not all pairs"
    short = isinstance(done, (int, float)) and isinstance(total, (int, float)) and done < total
    if run.state.get("complete") is True and not short:
        tail = ": %s" % counted if done is not None and total is not None else ""
        return paragraph("<strong>Complete</strong>%s." % esc(tail), "state done")
    if not run.state:
        return paragraph(
            "<strong>State unknown</strong>: summary.json does not state whether the run is complete.",
            "state banner",
        )
    text = "<strong>INCOMPLETE</strong>: %s. The numbers below describe only the pairs done." % esc(counted)
    return paragraph(text, "state banner")


def scope_html(run):
    """Return what the run leaves out by its configuration: datasets that were not there, other shards."""
    out, shard, left = [], run.state.get("shard"), run.state.get("left_out_datasets")
    experiment = run.settings.get("experiment")
    if run.sections and isinstance(experiment, str) and experiment:
        out.append(paragraph("Experiment <b>%s</b>: %s." % (esc(experiment), esc(", ".join(run.sections)))))
    if isinstance(shard, str) and shard:
        text = (
            "<strong>Shard %s</strong>: this run holds only its share of the pairs; merge all shards for the"
        )
        out.append(paragraph(text % esc(shard) + " results of the whole.", "state banner"))
    items = [item for item in left if isinstance(item, dict)] if isinstance(left, list) else []
    if items:
        text = "; ".join(
            "<b>%s</b> (%s)" % (esc(i.get("dataset")), esc(i.get("reason", "no reason given"))) for i in items
        )
        out.append(paragraph("<strong>Left out</strong>: %s." % text, "state banner"))
    return "\n".join(out)


def notes_html(run):
    """Return the remarks on missing and damaged input files."""
    if not run.notes:
        return ""
    items = "".join("<li>%s</li>" % esc(note) for note in run.notes)
    return (
        '<aside class="notes" aria-label="Remarks on the input"><p>Remarks on the input'
        " files</p><ul>%s</ul></aside>" % items
    )


def lead_html(run):
    """Return the sentence that states what was compared."""
    if not run.datasets:
        return paragraph("This run holds no pairs.", "lead")
    competing = [s for s in run.selectors if not is_baseline(s)]
    counts = ", ".join(
        "%s (%s)" % (dataset_html(name), plural(count, "pair")) for name, count in run.datasets.items()
    )
    features = ", ".join(esc(features_text(f)) for f in run.features)
    text = "%s on %s, with %s: %s." % (
        plural(len(competing), "selector").capitalize(),
        counts,
        features,
        ", ".join("<b>%s</b>" % esc(s) for s in competing) or "none",
    )
    return paragraph(text, "lead")


def sentence(run, group, named=True):
    """Return a group's result in words; without its name if a heading gives it."""
    result, tau = standing(run, group), run.tau(group)
    name = "Labelled ground truth" if tau is None else "At %s" % at_tau(tau)
    if named:
        name = "<b>%s</b> (%s)" % (esc(group_text(group)), esc(at_tau(tau)))
    first, fastest = result.first, result.fastest
    if not first:
        return "%s: no selector has a mean F." % name
    text = "%s: <b>%s</b> has the highest mean F, %s %s" % (
        name,
        esc(first["selector"]),
        fraction(first["f_paper"]),
        bracket(first),
    )
    text += versus(result) + "."
    if fastest:
        same = " as well" if fastest is first else ", with F %s" % fraction(fastest["f_paper"])
        text += " Fastest is <b>%s</b> (%s ms)%s." % (
            esc(fastest["selector"]),
            milliseconds(fastest["select_s_median"]),
            same,
        )
    return text + baseline_sentence(run.ranking(group), result.baseline)


def versus(result):
    """Return how the winner compares with the runner-up, as the rest of a sentence."""
    first, second = result.first, result.second
    if not second:
        return ", the only selector with a result"
    relation = "level with" if first["f_paper"] == second["f_paper"] else "ahead of"
    text = ", %s <b>%s</b> with %s %s" % (
        relation,
        esc(second["selector"]),
        fraction(second["f_paper"]),
        bracket(second),
    )
    if result.common is not None:
        text += "; the intervals %s" % ("overlap" if result.common else "do not overlap")
    if result.count:
        text += "; pair by pair <b>%s</b> is better on %d of %d" % (
            esc(first["selector"]),
            result.wins,
            result.count,
        )
        text += " (%s)" % plural(result.ties, "tie") if result.ties else ""
    return text


def baseline_sentence(ranking, baseline):
    """Return how keeping everything compares."""
    if not baseline:
        return ""
    value = baseline["f_paper"]
    below = [r["selector"] for r in ranking if r["f_paper"] <= value]
    text = " Keeping everything gives F %s" % fraction(value)
    if not below:
        return text + "."
    if len(below) == len(ranking):
        return text + ": no selector does better."
    names = ["<b>%s</b>" % esc(s) for s in below]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    return text + "; %s %s no better." % (listed, "does" if len(below) == 1 else "do")


def findings_in_place(run):
    """Tell whether there are too many groups for the overview, so that their sentences are shown with the groups."""
    return sum(group in run.means for group in run.groups) > MAX_FINDINGS


def paper_cell(run, group):
    """Return the selectors the paper puts first in the group's setting, as HTML."""
    named = paper_winner(run, group)
    if not named:
        return "\u2013"
    names, source = named
    note = "" if paper_dataset(group.dataset) == group.dataset else " (%s)" % paper_dataset(group.dataset)
    return '%s<br><span class="small">%s</span>' % (
        ", ".join(esc(name) for name in names),
        esc(source.split(", ", 1)[-1] + note),
    )


OVERLAP = {
    True: '<br><span class="small">intervals overlap</span>',
    False: '<br><span class="small">intervals separate</span>',
}


def f_cell(row):
    """Return the name of a selector with F and interval below it."""
    if row is None:
        return "\u2013"
    return '<b>%s</b><br><span class="small">%s (%s)</span>' % (
        esc(row["selector"]),
        fraction(row["f_paper"]),
        interval(row),
    )


def summary_row(run, group):
    """Return one row of the summary table."""
    result, tau = standing(run, group), run.tau(group)
    lines = (
        "%s, %s" % (kind_text(group.dataset), "labelled" if tau is None else at_tau(tau)),
        features_text(group.features),
        preselection_text(group.preselection),
    )
    head = breakable(group.dataset) + '<br><span class="small">%s</span>' % "<br>".join(map(esc, lines))
    cells = [head]
    text = 'class="text"'
    if not result.first:
        nothing = (text, "no selector has a mean F")
        return ("", cells + ["\u2013", nothing, (text, paper_cell(run, group)), ('colspan="4"', "\u2013")])
    versus_text = "\u2013"
    if result.count:
        versus_text = "%d of %d" % (result.wins, result.count)
        versus_text += '<br><span class="small">%s</span>' % plural(result.ties, "tie") if result.ties else ""
    quickest = "\u2013"
    if result.fastest:
        time = milliseconds(result.fastest["select_s_median"])
        quickest = '<b>%s</b><br><span class="small">%s ms</span>' % (esc(result.fastest["selector"]), time)
    base = result.baseline
    cells += [
        number(result.first["pairs"]),
        (text, f_cell(result.first)),
        (text, paper_cell(run, group)),
        (text, f_cell(result.second) + ("" if result.common is None else OVERLAP[result.common])),
        versus_text,
        (text, quickest),
        ('class="base"', fraction(base["f_paper"])) if base else "\u2013",
    ]
    return ("", cells)


def html(run, figures):
    """Return the body of the section."""
    groups = sorted((g for g in run.groups if g in run.means), key=lambda g: not is_main(run, g))
    if not run.groups:
        return paragraph("There are no pairs in this run, so there is nothing to compare.")
    if not groups:
        return paragraph("There is no summary.csv to take means from; see the counts per pair below.")
    caption = "Highest mean F for each dataset, kind of features and preselection."
    caption += " In brackets the 95 %% interval of the mean. %s does not compete." % BASELINE
    caption += " Paper names: what the paper (%s) puts first in the same setting." % SOURCE
    head = [
        "Dataset",
        "Pairs",
        "Highest F",
        "Paper names",
        "Runner-up",
        "Winner better on",
        "Fastest",
        "F of %s" % BASELINE,
    ]
    out = [table(caption, head, [summary_row(run, g) for g in groups], "overview", long=len(groups) > 12)]
    out.append(sources(run, "summary.csv", "pairs.csv"))
    out += [paragraph(esc(note), "small") for note in dataset_notes(run, [g.dataset for g in groups])]
    if run.remarks:
        items = "".join("<li>%s</li>" % esc(text) for text in remark_sentences(run))
        out.append('%s<ul class="findings">%s</ul>' % (paragraph("Remarks on the input:", "small"), items))
        out.append(sources(run, "remarks.csv"))
    if findings_in_place(run):
        groups = [g for g in groups if is_main(run, g)][:MAX_FINDINGS]
    out.append('<ul class="findings">%s</ul>' % "".join("<li>%s</li>" % sentence(run, g) for g in groups))
    return "\n".join(out)
