"""The guide: superior and inferior selectors of each scenario, derived from a run, beside the paper's Table V."""
import re
import textwrap
from collections import namedtuple

import numpy as np
from markupsafe import Markup

from . import paper
from .efficiency import NOT_TIMED, scaling_times, threads_text
from .inference import is_above, mean_interval, paired_difference
from .markup import DASH, LOWEST, Cell, below, best_cell, bold, details, findings, joined, lines, paragraph
from .markup import small, table, text_cell, transposed, with_headings
from .reading import Group, at_tolerance
from .robustness import SAMPLE_SEQUENCES
from .scopes import unselected_group
from .selectors import BASELINE, are_many, is_baseline, selector_key
from .words import fraction, group_text, milliseconds, plural, span

MIN_PAIRS = 5  # as many as one of VGG's scenes has; fewer decide nothing
MAGNITUDE = 1.0  # decades of time within which a selector still counts as fast, or as slow
SCALING_N = 5000
GUIDE_HEADER = "scenario,group,superior,inferior,paper_superior,paper_inferior,agreement,pairs".split(",")

# values: selector -> array, higher is better, entry i of every selector from the same pair (or round).
# allowance: how far from the best, or the worst, still counts as equal to it. notes: how it was measured, plain text.
Measured = namedtuple("Measured", "values baseline count unit generated allowance notes")
Verdict = namedtuple("Verdict", "superior inferior open")
Row = namedtuple("Row", "key advice measured verdict agreement remarks")
Agreement = namedtuple("Agreement", "superior inferior also_superior also_inferior")

# What became of an entry of the paper's table, with its sign in the plain text.
CONFIRMED, CONTRADICTED, UNCONFIRMED = "confirmed", "contradicted", "not confirmed"
OPEN, UNMEASURED = "not separable", "not measured"
SIGNS = {CONFIRMED: "+", CONTRADICTED: "-", UNCONFIRMED: "~", OPEN: "?", UNMEASURED: "."}
MEANINGS = {
    CONFIRMED: "the measured set has it too",
    CONTRADICTED: "it is in the opposite set",
    UNCONFIRMED: "it is in neither set",
    OPEN: "these pairs separate it neither from the best nor from the worst",
    UNMEASURED: "the run has no result of it",
}
RULE = (
    "The measure is F at 5 px, and F itself for labelled data. A selector is superior if its F is not significantly below"
    " that of the selector with the highest mean F. It is inferior if its F is not significantly above that of the"
    " selector with the lowest mean F. A difference is significant if the 95 % bootstrap interval (2000 resamples, fixed"
    " seed) of its mean over the pairs does not contain 0. A selector that meets both conditions belongs to neither set,"
    " because the pairs cannot separate it from either end. Each set is in order of mean F and may have any number of"
    " selectors. Nothing is decided with fewer than {pairs} pairs. With as few as that, an interval is rough: it does not"
    " contain 0 as soon as one selector is ahead on every pair. Comparisons are not corrected for their number.",
    "Efficiency is tested in the same way on times, where an order of magnitude is allowed for. Superior selectors are not"
    " significantly slower than ten times the fastest one, and inferior selectors are not significantly faster than a"
    " tenth of the slowest one (geometric means over the rounds).",
    "keep_all is not rated. A name with a preset (lpm:v2) is rated under its own name. Only bare names are compared with"
    " the paper, as in the paper.",
)


def rule():
    """Return the paragraphs of the rule as plain text."""
    return [text.replace("{pairs}", str(MIN_PAIRS)) for text in RULE]


# ------------------------------------------------------------------------------------------------ scenarios


def scenes_of(*cases):
    """Return (VGG's scenes, the sample's sequences) of cases."""
    return [paper.ROBUSTNESS[c].scene for c in cases], [SAMPLE_SEQUENCES[c] for c in cases]


Candidate = namedtuple("Candidate", "group sequences generated")


def candidates():
    """Return scenario -> groups that measure it, the first in a run counts; sequences None = all."""
    default = paper.FEATURES_DEFAULT
    out = {}
    for preselection, prefix in (("none", ""), ("nnsr", "nnsr_")):
        for dataset in ("vgg", "symbench"):
            out[prefix + dataset] = [Candidate(Group(dataset, default, preselection), None, False)]
        out[prefix + "heinly"] = [
            Candidate(Group("heinly", default, preselection), None, False),
            Candidate(Group("heinly_generated", default, preselection), None, True),
        ]
    out["adelaidermf"] = [Candidate(Group("adelaidermf", "given", "none"), None, False)]
    for features in ("sift+sift", "orb+orb", "asift+asift", "blob+freak"):
        out[features] = [Candidate(Group("vgg", features, "none"), None, False)]
    for key, cases in (
        ("zoom_and_rotation", ("case1", "case3")),
        ("blur", ("case2", "case6")),
        ("viewpoint_change", ("case4", "case8")),
        ("light_change", ("case5",)),
        ("jpeg_compression", ("case7",)),
    ):
        scenes, generated = scenes_of(*cases)
        out[key] = [
            Candidate(Group("vgg", default, "none"), scenes, False),
            Candidate(Group("sample", default, "none"), generated, True),
        ]
    return out


def known(column):
    """Return the number of values of a column."""
    return int(np.count_nonzero(np.isfinite(column)))


def aligned(columns):
    """Return selector -> array of the entries that all columns (selector -> array, NaN = none) have, and their number."""
    columns = {s: c for s, c in columns.items() if known(c)}
    if not columns:
        return {}, 0
    shared = np.all([np.isfinite(column) for column in columns.values()], axis=0)
    return {s: column[shared] for s, column in columns.items()}, int(shared.sum())


def with_enough_pairs(columns):
    """Return the columns with results on at least half of the pairs, and remarks on what is left out.

    Selectors are compared on the pairs that all of them share, so one with few results would leave few pairs.
    """
    pairs = int(np.any([np.isfinite(column) for column in columns.values()], axis=0).sum()) if columns else 0
    enough = {s: c for s, c in columns.items() if not known(c) or 2 * known(c) >= pairs}
    notes = [
        "%s is left out: it has results on %d of %s" % (s, known(c), plural(pairs, "pair"))
        for s, c in columns.items()
        if s not in enough
    ]
    shared = aligned(enough)[1]
    if shared < pairs:
        some = [s for s, c in enough.items() if 0 < known(c) < pairs]
        text = "compared on %d of %s, because %s has no result on the others"
        notes.append(text % (shared, plural(pairs, "pair"), ", ".join(some)))
    return enough, notes


def measure_f(run, candidate):
    """Return F of a group's pairs as Measured; None where the run has no usable pair of it."""
    chosen = run.in_sequences(candidate.group, candidate.sequences)
    columns = {s: run.pair_values(candidate.group, s)[chosen] for s in run.selectors_of(candidate.group)}
    columns, notes = with_enough_pairs(columns)
    values, count = aligned(columns)
    baseline = next((v for s, v in values.items() if is_baseline(s)), None)
    values = {s: v for s, v in values.items() if not is_baseline(s)}
    if not count or not values:
        return None
    tau = run.tau(candidate.group)
    if candidate.generated:
        where = candidate.group.dataset
        where += " " + ", ".join(candidate.sequences) if candidate.sequences else ""
        notes.append("generated data (%s), counted apart" % where)
    if tau is not None and tau != paper.TAU_PX:
        notes.append("at %g px, the run has no tolerance of %g px" % (tau, paper.TAU_PX))
    return Measured(values, baseline, count, "pair", candidate.generated, 0.0, notes)


def speed(columns, unit, note):
    """Return seconds (selector -> array) as Measured: -log10 of the time, so that higher is better."""
    values, count = aligned(columns)
    values = {s: -np.log10(np.maximum(v, 1e-9)) for s, v in values.items()}
    return Measured(values, None, count, unit, False, MAGNITUDE, [note]) if count else None


def measure_time(run):
    """Return the times of scaling.csv, with one thread at N = 5000 or what is nearest; else those of pairs.csv."""
    for threads, selectors in scaling_times(run).items():
        n = max(
            (n for s, rounds in selectors.items() if not is_baseline(s) for n in rounds if n <= SCALING_N),
            default=None,
        )
        seconds = {s: rounds[n] for s, rounds in selectors.items() if n in rounds and not is_baseline(s)}
        shared = min(map(len, seconds.values()), default=0)
        columns = {s: np.array(values[:shared]) for s, values in seconds.items()}
        if columns:
            rounds = aligned(columns)[1]
            return speed(
                columns, "round", "N = %d, %s, %s" % (n, threads_text(threads), plural(rounds, "round"))
            )
    group = unselected_group(run)
    if group is None:
        return None
    columns = {}
    for selector in run.selectors_of(group):
        if is_baseline(selector):
            continue
        rows = run.rows(group, selector)
        timed = at_tolerance(rows, run.tau(group)) & ~rows.has("status", *NOT_TIMED)
        columns[selector] = np.full((run.pair_count(group), len(run.seeds)), np.nan)
        columns[selector][rows.pairs()[timed], rows["seed"][timed]] = rows["select_s"][timed]
    note = "select_s of the pairs of %s, %s: no scaling.csv" % (group.dataset, group.features)
    return speed(columns, "pair", note)


# ------------------------------------------------------------------------------------------------- verdicts


def rate(values, allowance=0.0):
    """Return the Verdict on selector -> array of paired values, higher is better; see RULE."""
    if not values or len(next(iter(values.values()))) < MIN_PAIRS or len(values) < 2:
        return Verdict([], [], list(values))
    order = sorted(values, key=lambda s: (-values[s].mean(), selector_key(s)))
    best, worst = values[order[0]], values[order[-1]]
    top = [s for s in order if not is_above(paired_difference(best - allowance, values[s]))]
    bottom = [s for s in reversed(order) if not is_above(paired_difference(values[s] - allowance, worst))]
    both = [s for s in order if s in top and s in bottom]
    return Verdict([s for s in top if s not in both], [s for s in bottom if s not in both], both)


def compare(advice, measured):
    """Return what became of the paper's entries: Agreement of selector -> word, and the sets' other bare names."""
    bare = {s: v for s, v in measured.values.items() if ":" not in s}
    verdict = rate(bare, measured.allowance)

    def outcome(selector, own, opposite):
        if selector not in bare:
            return UNMEASURED
        if selector in own:
            return CONFIRMED
        if selector in opposite:
            return CONTRADICTED
        return OPEN if selector in verdict.open else UNCONFIRMED

    return Agreement(
        {s: outcome(s, verdict.superior, verdict.inferior) for s in advice.superior},
        {s: outcome(s, verdict.inferior, verdict.superior) for s in advice.inferior},
        [s for s in verdict.superior if s not in advice.superior],
        [s for s in verdict.inferior if s not in advice.inferior],
    )


def no_better_than_baseline(measured):
    """Return the selectors not significantly above keep_all, by falling mean."""
    if measured.baseline is None or measured.count < MIN_PAIRS:
        return []
    names = [s for s, v in measured.values.items() if not is_above(paired_difference(v, measured.baseline))]
    return sorted(names, key=lambda s: (-measured.values[s].mean(), selector_key(s)))


def remarks_on(key, measured):
    """Return remarks on a scenario as plain texts."""
    out = list(measured.notes)
    if key in paper.FEATURES_VGG:
        out.append("measured on vgg, as in the paper's Fig. 8")
    if measured.count < MIN_PAIRS:
        out.append("%s: too few to decide" % plural(measured.count, measured.unit))
    expected = paper.DATASET_PAIRS.get(key)
    if expected is not None and not measured.generated and measured.count != expected:
        out.append("%s here, %d in the paper" % (plural(measured.count, "pair"), expected))
    weak = no_better_than_baseline(measured)
    if weak:
        out.append("not better than keeping everything: %s" % " ".join(weak))
    return out


def derive(run):
    """Return a Row for each scenario of the paper's Table V, in its order; unmeasured ones have no verdict."""
    groups = candidates()
    rows = []
    for key, advice in paper.GUIDE.items():
        if key == "efficiency":
            measured = measure_time(run)
        else:
            measured = next(filter(None, (measure_f(run, c) for c in groups[key])), None)
        if measured is None:
            rows.append(Row(key, advice, None, None, None, []))
            continue
        verdict = rate(measured.values, measured.allowance)
        rows.append(Row(key, advice, measured, verdict, compare(advice, measured), remarks_on(key, measured)))
    return rows


# The choice of a selector for one group of a run. best: Estimate of the highest mean F; superior: selectors by falling
# mean F; fastest: the superior one with the shortest median time; front: faster selectors by falling mean F, each
# with a higher F than all that are faster still, and with a higher F than keep_all. times: selector -> median, s.
Choice = namedtuple("Choice", "group count best means times superior fastest front")


def choices(run):
    """Return a Choice for each dataset, kind of features and preselection whose pairs separate selectors."""
    out = []
    for group in run.groups:
        measured = measure_f(run, Candidate(group, None, False))
        superior = rate(measured.values).superior if measured else []
        if not superior:
            continue
        means = {s: v.mean() for s, v in measured.values.items()}
        seconds = ((s, run.pair_values(group, s, "select_s")) for s in means)
        times = {s: float(np.nanmedian(values)) for s, values in seconds if known(values)}
        timed = [s for s in superior if s in times]
        fastest = min(timed, key=times.get) if timed else None
        front, weak = [], no_better_than_baseline(measured)
        if fastest:
            faster = [s for s in times if times[s] < times[fastest] and s not in weak and s not in superior]
            for selector in sorted(faster, key=times.get):
                if not front or means[selector] > means[front[-1]]:
                    front.append(selector)
        best = mean_interval(measured.values[superior[0]])
        out.append(Choice(group, measured.count, best, means, times, superior, fastest, front[::-1]))
    return out


CHOICE_HEAD = ["Dataset", "Pairs", "Highest mean F", "Not separable from it", "Fastest of these"]
CHOICE_HEAD += ["Faster, with less F"]


def choice_cells(choice):
    """Return the cells of a Choice under CHOICE_HEAD as plain texts."""

    def with_f(selector):
        return "%s %s" % (selector, fraction(choice.means[selector]))

    def with_time(selector):
        return "%s (%s ms)" % (with_f(selector), milliseconds(choice.times[selector]))

    first, rest = choice.superior[0], choice.superior[1:]
    bounds = span(choice.best.low, choice.best.high)
    return [
        group_text(choice.group),
        str(choice.count),
        "%s (%s)" % (with_f(first), bounds),
        ", ".join(map(with_f, rest)) or DASH,
        with_time(choice.fastest) if choice.fastest else DASH,
        ", ".join(map(with_time, choice.front)) or DASH,
    ]


def choices_markdown(run):
    """Return the choices as a Markdown table, names of selectors as code."""
    names = re.compile(
        r"(?<![\w:/])(%s)(?= \d)" % "|".join(map(re.escape, sorted(run.selectors, reverse=True)))
    )
    lines = ["| %s |" % " | ".join(CHOICE_HEAD), "|---" * len(CHOICE_HEAD) + "|"]
    for choice in choices(run):
        cells = choice_cells(choice)
        marked = cells[:2] + [names.sub(r"`\1`", cell) for cell in cells[2:]]
        lines.append("| %s |" % " | ".join(cell.replace("|", "\\|") for cell in marked))
    return "\n".join(lines) + "\n"


def choice_table(run):
    """Return the choices as an HTML table; '' where no pairs separate selectors."""
    rows = [("", choice_cells(choice)) for choice in choices(run)]
    if not rows:
        return ""
    caption = (
        "The choice among all selectors of this run. Not separable: the paired 95 % interval of the difference to the"
        " highest mean F contains 0. Faster: each has a higher mean F than every selector that is faster still, and a"
        " significantly higher one than keep_all. Times are medians of one selection."
    )
    return table(caption, CHOICE_HEAD, rows, "texts", long=True)


def counts(rows, side, generated):
    """Return outcome -> number of the paper's entries of one side ("superior", "inferior") over measured rows."""
    out = {word: 0 for word in SIGNS}
    for row in rows:
        if row.measured and row.measured.generated == generated:
            for word in getattr(row.agreement, side).values():
                out[word] += 1
    return out


def counts_text(rows, generated):
    """Return the counts of both sides as one sentence; '' without any measured scenario of that kind."""
    chosen = [r for r in rows if r.measured and r.measured.generated == generated]
    if not chosen:
        return ""
    parts = []
    for side in ("superior", "inferior"):
        found = counts(rows, side, generated)
        listed = ", ".join("%d %s" % (n, word) for word, n in found.items() if n or word == CONFIRMED)
        parts.append("of its %d %s entries %s" % (sum(found.values()), side, listed))
    others = sum(len(r.agreement.also_superior) for r in chosen), sum(
        len(r.agreement.also_inferior) for r in chosen
    )
    kind = " on generated stand-ins" if generated else ""
    text = "Against the paper's table in %s%s: %s" % (plural(len(chosen), "scenario"), kind, "; ".join(parts))
    return text + ". Found besides: %d superior, %d inferior." % others


def agreement_text(row):
    """Return what became of the paper's entries in a scenario as plain text."""
    if not row.measured:
        return UNMEASURED
    parts = ["generated data"] if row.measured.generated else []
    for side in ("superior", "inferior"):
        found = getattr(row.agreement, side)
        for word in SIGNS:
            names = [s for s, w in found.items() if w == word]
            if names:
                parts.append("%s %s: %s" % (side, word, " ".join(names)))
        also = getattr(row.agreement, "also_" + side)
        if also:
            parts.append("%s besides: %s" % (side, " ".join(also)))
    return "; ".join(parts)


# ------------------------------------------------------------------------------------------------- CSV, text


def csv_rows(rows):
    """Return the rows of guide.csv, as dictionaries with the keys of GUIDE_HEADER."""
    return [
        {
            "scenario": row.key,
            "group": row.advice.group,
            "superior": " ".join(row.verdict.superior) if row.verdict else "",
            "inferior": " ".join(row.verdict.inferior) if row.verdict else "",
            "paper_superior": " ".join(row.advice.superior),
            "paper_inferior": " ".join(row.advice.inferior),
            "agreement": agreement_text(row),
            "pairs": row.measured.count if row.measured else 0,
        }
        for row in rows
    ]


WIDTHS = (19, 7, 21, 18, 20, 15)


def text_line(cells):
    """Return a row of the plain table; long cells go over several lines."""
    columns = [
        textwrap.wrap(cell, width, break_on_hyphens=False) or [""] for cell, width in zip(cells, WIDTHS)
    ]
    out = []
    for i in range(max(len(c) for c in columns)):
        parts = ("%-*s" % (w, c[i] if i < len(c) else "") for c, w in zip(columns, WIDTHS))
        out.append("  ".join(parts).rstrip())
    return "\n".join(out)


def signed(outcomes):
    """Return selectors with the sign of their outcome."""
    return " ".join(SIGNS[word] + selector for selector, word in outcomes.items())


def set_text(names, verdict):
    """Return a measured set as text."""
    if names:
        return " ".join(names)
    return "(not separable)" if verdict.open else "(none)"


def scenario_name(advice):
    """Return a scenario's name."""
    return advice.name or advice.group


def text(run, rows):
    """Return the guide as plain text of at most 110 columns, in ASCII."""
    out = ["Guide: superior and inferior selectors, derived from %s" % run.name, ""]
    rule_line = "-" * (sum(WIDTHS) + 2 * (len(WIDTHS) - 1))
    out += [
        text_line(("Scenario", "Pairs", "Superior", "Inferior", "Paper: superior", "Paper: inferior")),
        rule_line,
    ]
    notes, group = [], None
    for row in rows:
        if row.advice.group != group:
            group = row.advice.group
            if row.advice.name:
                out.append(group)
        name = ("  " if row.advice.name else "") + scenario_name(row.advice)
        number = ""
        if row.remarks:
            notes.append("[%d] %s: %s." % (len(notes) + 1, row_title(row), "; ".join(row.remarks)))
            number = " [%d]" % len(notes)
        if not row.measured:
            cells = (name, "", UNMEASURED, "", *map(" ".join, (row.advice.superior, row.advice.inferior)))
        else:
            name += " (generated)" if row.measured.generated else ""
            cells = (name, "%d%s" % (row.measured.count, number), set_text(row.verdict.superior, row.verdict))
            cells += (set_text(row.verdict.inferior, row.verdict),)
            cells += (signed(row.agreement.superior), signed(row.agreement.inferior))
        out.append(text_line(cells))
    out += [rule_line, "Paper: %s. Its entries:" % paper.GUIDE_SOURCE]
    out += ["  %s %s: %s" % (sign, word, MEANINGS[word]) for word, sign in SIGNS.items()]
    out.append("")
    width = len(rule_line)
    out += [textwrap.fill(note, width, subsequent_indent="    ", break_on_hyphens=False) for note in notes]
    out.append("")
    for sentence in summary(rows):
        out.append(textwrap.fill(sentence, width, break_on_hyphens=False))
    out.append("")
    out += [
        textwrap.fill(part, width, break_on_hyphens=False) for part in ["Rule. " + rule()[0]] + rule()[1:]
    ]
    return "\n".join(out).encode("ascii", "replace").decode("ascii") + "\n"


def row_title(row):
    """Return a scenario's name with its group."""
    return "%s, %s" % (row.advice.group, row.advice.name) if row.advice.name else row.advice.group


def summary(rows):
    """Return the sentences on the whole table."""
    out = [t for t in (counts_text(rows, False), counts_text(rows, True)) if t]
    missing = [row_title(r) for r in rows if not r.measured]
    if missing:
        out.append("Not measured in this run: %s." % "; ".join(missing))
    return out


# ----------------------------------------------------------------------------------------------------- HTML


def names_html(names, verdict):
    """Return a measured set as a table cell."""
    if names:
        return text_cell(joined(map(bold, names), " "))
    return Cell(set_text(names, verdict).strip("()"), "text none")


def outcomes_html(outcomes):
    """Return the paper's entries of one side with what became of them, as a table cell."""
    by_word = {}
    for selector, word in outcomes.items():
        by_word.setdefault(word, []).append(selector)
    found = [joined([" ".join(by_word[word]), small(word)], " ") for word in SIGNS if word in by_word]
    return text_cell(lines(found))


def guide_table(rows):
    """Return the guide as a table."""
    body = []
    for row in rows:
        head = scenario_name(row.advice) + (below(row.advice.group) if row.advice.name else "")
        if row.measured and row.measured.generated:
            head += below("generated data")
        if row.measured:
            cells = [head, str(row.measured.count)]
            cells += [names_html(names, row.verdict) for names in row.verdict[:2]]
            cells += [outcomes_html(outcomes) for outcomes in row.agreement[:2]]
        else:
            cells = [head, DASH, Cell(UNMEASURED, "text none", span=2)]
            cells += [text_cell(" ".join(names)) for names in (row.advice.superior, row.advice.inferior)]
        body.append(("", cells))
    head = ["Scenario", "Pairs", "Superior", "Inferior", "Paper: superior", "Paper: inferior"]
    caption = "Superior and inferior selectors of each scenario, derived from this run, and the paper's (%s)."
    return table(caption % paper.GUIDE_SOURCE, head, body, "texts", long=True)


def evidence_table(rows):
    """Return the mean F behind the verdicts; '' without any."""
    rows = [r for r in rows if r.measured and r.key != "efficiency"]
    if not rows:
        return ""
    names = sorted({s for r in rows for s in r.measured.values}, key=selector_key)
    body = []
    for row in rows:
        cells = [row.advice.name + below(row.advice.group)]
        for selector in names:
            if selector not in row.measured.values:
                cells.append(DASH)
                continue
            value = fraction(row.measured.values[selector].mean())
            if selector in row.verdict.superior:
                cells.append(best_cell(value, title="superior"))
            elif selector in row.verdict.inferior:
                cells.append(best_cell(value, title="inferior", mark=LOWEST))
            else:
                cells.append(value)
        base = row.measured.baseline
        cells.append(Cell(fraction(base.mean()), "base") if base is not None else DASH)
        body.append(("", cells))
    head = ["Scenario"] + names + [BASELINE]
    caption = "Mean F behind the verdicts, over the pairs that all selectors share. \u25b2 superior, \u25bc inferior."
    if are_many(names):
        head, columns = transposed(head, body)
        selectors = names + [BASELINE]
        rows = with_headings([(s, ("", c)) for s, c in zip(selectors, columns)])
        return table(caption, head, rows, "results")
    return table(caption, head, body, "results", long=True)


def html(run, figures):
    """Return the body of the section on the guide; it has no figures."""
    rows = derive(run)
    meanings = joined((Markup("<i>%s</i>: %s") % item for item in MEANINGS.items()), "; ")
    out = [
        paragraph(
            Markup(
                "<strong>How to read.</strong> Each row is a scenario of the paper's summary. <i>Superior</i> selectors"
                " are the ones to try first there, <i>inferior</i> selectors are those to avoid. The others lie between"
                " them. Beside them are the selectors that the paper names, with their outcome in this run. %s."
            )
            % meanings
        )
    ]
    out += [paragraph(bold(s) if i == 0 else s) for i, s in enumerate(summary(rows))]
    out.append(guide_table(rows))
    remarks = [Markup("<b>%s</b>: %s.") % (row_title(r), "; ".join(r.remarks)) for r in rows if r.remarks]
    out.append(findings(remarks) if remarks else "")
    out.append(choice_table(run))
    out.append(details("Rule", joined(map(paragraph, rule()))))
    out.append(evidence_table(rows))
    return joined(out)
