"""What won where: the state of the run, the picture of all settings, and their table."""
from markupsafe import Markup

from .compared import dataset_notes, paper_dataset, paper_winner
from .figures import line_style, mark, marked, name_rows, new_axes, plot_text
from .markup import DASH, Cell, below, bold, breakable, dataset_html, details, findings, joined, lines
from .markup import panels, paragraph, sources, table, text_cell
from .paper import SOURCE
from .scopes import is_main, switches_of
from .remarks import remark_sentences
from .selectors import BASELINE, DARK, are_many, is_baseline
from .standings import standing
from .words import at_tau, features_text, fraction, group_text, interval, kind_text, milliseconds, number
from .words import plural, preselection_text, with_interval

MAX_DRAWN = 24  # groups in the picture; the table has them all
MAX_FINDINGS = 8  # further sentences on single groups are shown with the groups, not in the overview


def is_complete(run):
    """Tell whether the run states that it is complete, and counts no pairs that are missing."""
    done, total = run.state.get("pairs_done"), run.state.get("pairs_total")
    short = isinstance(done, (int, float)) and isinstance(total, (int, float)) and done < total
    return run.state.get("complete") is True and not short


def state_html(run):
    """Return the one-line state of the run, a banner where it is not complete."""
    done, total = run.state.get("pairs_done"), run.state.get("pairs_total")
    counted = "%s of %s pairs" % (done, total) if done is not None and total is not None else "not all pairs"
    if is_complete(run):
        tail = ": %s" % counted if done is not None and total is not None else ""
        return paragraph(Markup("<strong>Complete</strong>%s.") % tail, "state done")
    if not run.state:
        return paragraph(
            Markup(
                "<strong>State unknown</strong>: summary.json does not state whether the run is complete."
            ),
            "state banner",
        )
    text = (
        Markup("<strong>INCOMPLETE</strong>: %s. The numbers below describe only the pairs done.") % counted
    )
    return paragraph(text, "state banner")


def scope_html(run):
    """Return what the run leaves out by its configuration: datasets that were not there, other shards."""
    out, shard, left = [], run.state.get("shard"), run.state.get("left_out_datasets")
    experiment = run.settings.get("experiment")
    if run.sections and isinstance(experiment, str) and experiment:
        parts = "" if run.sections == [experiment] else ": " + ", ".join(run.sections)
        out.append(paragraph(Markup("Experiment <b>%s</b>%s.") % (experiment, parts)))
    if isinstance(shard, str) and shard:
        text = Markup(
            "<strong>Shard %s</strong>: this run holds only its share of the pairs; merge all shards for the results of"
            " the whole."
        )
        out.append(paragraph(text % shard, "state banner"))
    items = [item for item in left if isinstance(item, dict)] if isinstance(left, list) else []
    items = [
        item for item in items if item.get("dataset") not in run.datasets
    ]  # sample may stand in for itself
    if items:
        reasons = ((i.get("dataset"), i.get("reason", "no reason given")) for i in items)
        text = joined((Markup("<b>%s</b> (%s)") % each for each in reasons), "; ")
        out.append(paragraph(Markup("<strong>Left out</strong>: %s.") % text, "state banner"))
    return joined(out)


def lead(run):
    """Return the sentence that states what was compared."""
    if not run.datasets:
        return "This run holds no pairs."
    competing = [s for s in run.selectors if not is_baseline(s)]
    names = [name for name in switches_of(run) if not is_baseline(name)]
    variants = "" if len(names) == len(competing) else " in %d variants" % len(competing)
    counts = (
        Markup("%s (%s)") % (dataset_html(name), plural(count, "pair"))
        for name, count in run.datasets.items()
    )
    return Markup("%s%s on %s, with %s: %s.") % (
        plural(len(names), "selector").capitalize(),
        variants,
        joined(counts, ", "),
        ", ".join(map(features_text, run.features)),
        joined(map(bold, names), ", ") or "none",
    )


def groups_with_means(run):
    """Return the groups that have means, those with the main features first and those of a single pair last."""
    groups = (group for group in run.groups if group in run.means)
    return sorted(groups, key=lambda group: (run.pair_count(group) < 2, not is_main(run, group)))


def settings_html(run, figures, groups):
    """Return the picture of the mean F of every selector in every group; "" for one group, which the opening shows."""
    groups = [group for group in groups if run.ranking(group)][:MAX_DRAWN]
    if len(groups) < 2:
        return ""
    caption = "Mean F of every selector, one row for each dataset, kind of features and preselection; the winner is named."
    return panels([winners_panel(run, figures, groups)], caption, "winners")


def winners_panel(run, figures, groups):
    """Draw the mean F of every selector, one row for each group, with the names of winner and baseline."""
    names = [plot_text(group_name(group), 52) for group in groups]
    winners = {run.ranking(group)[0]["selector"] for group in groups}
    left = 0.3 + 0.075 * max(map(len, names))
    figure, axes = new_axes(left + 6.5, 0.8 + 0.36 * len(groups), left, 1.9, 0.45, 0.12)
    for y, group in enumerate(groups):
        tau = run.tau(group)
        rows = [row for row in (run.mean(group, s, tau) for s in run.selectors_of(group)) if row]
        rows = [row for row in rows if row["f_paper"] is not None]
        for row in sorted(rows, key=lambda row: row["f_paper"]):
            name = row["selector"]
            known = name in winners or is_baseline(name)
            options = dict(line_style(run.styles[name]), linestyle="none", markersize=8)
            if not known:
                options.update(marker="o", markersize=5, markerfacecolor="#c4c4c4", markeredgecolor="#9a9a9a")
            with marked(axes, name):
                axes.plot([row["f_paper"]], [y], **options)
        first = run.ranking(group)[0]
        text = axes.annotate(
            "%s %s" % (plot_text(first["selector"]), fraction(first["f_paper"])),
            (1, y),
            xycoords=("axes fraction", "data"),
            xytext=(8, 0),
            textcoords="offset points",
            va="center",
            fontweight="bold",
        )
        mark(figure, first["selector"], [text])
    name_rows(axes, names)
    axes.set_xlim(-0.02, 1.02)
    axes.grid(True, axis="x")
    axes.set_xlabel("mean F (\u00d7 %s, grey: the other selectors)" % BASELINE, color=DARK)
    return figures(figure, "Mean F of every selector, one row for each setting, the winner named", "winners")


def group_name(group):
    """Return a short name of a group."""
    after = "" if group.preselection in ("", "none") else ", after " + group.preselection
    return "%s, %s%s" % (group.dataset, features_text(group.features), after)


def sentence(run, group, named=True):
    """Return a group's result in words; without its name if a heading gives it."""
    tau = run.tau(group)
    name = "Labelled ground truth" if tau is None else "At %s" % at_tau(tau)
    if named:
        name = Markup("<b>%s</b> (%s)") % (group_text(group), at_tau(tau))
    return Markup("%s: %s") % (name, result_text(run, group))


def result_text(run, group, where=""):
    """Return who won in a group, as a sentence that does not name the group, or does so by `where`."""
    result = standing(run, group)
    first, fastest = result.first, result.fastest
    if not first:
        return "no selector has a mean F%s." % where
    values = (first["selector"], where, fraction(first["f_paper"]), bracket(first))
    text = Markup("<b>%s</b> has the highest mean F%s, %s%s") % values
    text += versus(result) + "."
    if fastest:
        same = " as well" if fastest is first else ", with F %s" % fraction(fastest["f_paper"])
        time = milliseconds(fastest["select_s_median"])
        text += Markup(" Fastest is <b>%s</b> (%s ms)%s.") % (fastest["selector"], time, same)
    return text + baseline_sentence(run.ranking(group), result.baseline)


def bracket(row):
    """Return the interval in brackets, as HTML that does not break across lines; "" where it is undefined."""
    if None in (row["f_paper_lo"], row["f_paper_hi"]):
        return ""
    return Markup(' <span class="nb">(95 %% interval %s)</span>') % interval(row)


def versus(result):
    """Return how the winner compares with the runner-up, as the rest of a sentence."""
    first, second = result.first, result.second
    if not second:
        return ", the only selector with a result"
    relation = "level with" if first["f_paper"] == second["f_paper"] else "ahead of"
    values = (relation, second["selector"], fraction(second["f_paper"]), bracket(second))
    text = Markup(", %s <b>%s</b> with %s%s") % values
    if result.common is not None:
        text += "; the intervals %s" % ("overlap" if result.common else "do not overlap")
    if result.count:
        values = (first["selector"], result.wins, result.count)
        text += Markup("; pair by pair <b>%s</b> is better on %d of %d") % values
        text += " (%s)" % plural(result.ties, "tie") if result.ties else ""
    return text


def baseline_sentence(ranking, baseline):
    """Return how keeping everything compares."""
    if not baseline:
        return ""
    value = baseline["f_paper"]
    lower = [r["selector"] for r in ranking if r["f_paper"] <= value]
    text = " Keeping everything gives F %s" % fraction(value)
    if not lower:
        return text + "."
    if len(lower) == len(ranking):
        return text + ": no selector does better."
    if are_many(ranking):
        return text + "; %d of %d do no better." % (len(lower), len(ranking))
    names = list(map(bold, lower))
    listed = joined([joined(names[:-1], ", "), names[-1]], " and ")
    return Markup("%s; %s %s no better.") % (text, listed, "does" if len(lower) == 1 else "do")


def findings_in_place(run):
    """Tell whether there are too many groups for the overview, so that their sentences are shown with the groups."""
    return sum(group in run.means for group in run.groups) > MAX_FINDINGS


def paper_cell(run, group):
    """Return the selectors the paper puts first in the group's setting, as HTML."""
    named = paper_winner(run, group)
    if not named:
        return DASH
    names, source = named
    note = "" if paper_dataset(group.dataset) == group.dataset else " (%s)" % paper_dataset(group.dataset)
    return ", ".join(names) + below(source.split(", ", 1)[-1] + note)


def f_cell(row):
    """Return the name of a selector with F and interval below it."""
    if row is None:
        return DASH
    return bold(row["selector"]) + below(with_interval(row))


def summary_row(run, group, with_papers):
    """Return one row of the summary table."""
    result, tau = standing(run, group), run.tau(group)
    words = (
        "%s, %s" % (kind_text(group.dataset), "labelled" if tau is None else at_tau(tau)),
        features_text(group.features),
        preselection_text(group.preselection),
    )
    head = breakable(group.dataset) + below(lines(words))
    papers = [text_cell(paper_cell(run, group))] if with_papers else []
    if not result.first:
        return ("", [head, DASH, text_cell("no selector has a mean F")] + papers + [Cell(DASH, span=4)])
    wins = DASH
    if result.count:
        wins = "%d of %d" % (result.wins, result.count) + (
            below(plural(result.ties, "tie")) if result.ties else ""
        )
    fastest, base = DASH, result.baseline
    if result.fastest:
        time = milliseconds(result.fastest["select_s_median"])
        fastest = bold(result.fastest["selector"]) + below("%s ms" % time)
    second = f_cell(result.second)
    if result.common is not None:
        second += below("intervals overlap" if result.common else "intervals separate")
    cells = [head, number(result.first["pairs"]), text_cell(f_cell(result.first))] + papers
    cells += [text_cell(second), wins, text_cell(fastest)]
    return ("", cells + [Cell(fraction(base["f_paper"]), "base") if base else DASH])


def html(run, figures):
    """Return the body of the section."""
    groups = groups_with_means(run)
    if not run.groups:
        return paragraph("There are no pairs in this run, so there is nothing to compare.")
    if not groups:
        return paragraph("There is no summary.csv to take means from; see the counts per pair below.")
    caption = (
        "Highest mean F (0 to 1) for each dataset, kind of features and preselection. In brackets the 95 %% interval of the"
        " mean. Winner better on: the pairs on which the winner has a higher F than the runner-up. %s does not compete."
        % BASELINE
    )
    papers = any(paper_winner(run, group) for group in groups)
    head = ["Dataset", "Pairs", "Highest F"] + ["Paper names"] * papers
    head += ["Runner-up", "Winner better on", "Fastest", "F of %s" % BASELINE]
    if papers:
        caption += " Paper names: what the paper (%s) puts first in the same setting." % SOURCE
    rows = [summary_row(run, group, papers) for group in groups]
    out = [settings_html(run, figures, groups)]
    out.append(table(caption, head, rows, "overview papers" if papers else "overview", long=len(groups) > 12))
    out.append(sources(run, "summary.csv", "pairs.csv"))
    out += [paragraph(note, "small") for note in dataset_notes(run, [g.dataset for g in groups])]
    if run.remarks:
        out += [paragraph("Remarks on the input:", "small"), findings(remark_sentences(run))]
        out.append(sources(run, "remarks.csv"))
    if findings_in_place(run):
        groups = [g for g in groups if is_main(run, g)][:MAX_FINDINGS]
    return joined(out + [details("The results in words", findings([sentence(run, g) for g in groups]))])
