"""The results of a run as plain text, for a terminal."""
from .compared import percent
from .left_out import left_out_sentence
from .pose import CORNERS, GROUND_TRUTH, MEASURES, OWN, POSE, groups_of, interval_of, ranking
from .selectors import BASELINE
from .remarks import remark_sentences
from .standings import standing
from .words import features_text, is_unrelated, milliseconds, plural, preselection_text

GAP = "  "
AREA_HEADS = {POSE: "pose AUC 10 deg %", OWN: "own pose %", CORNERS: "corner AUC 3 px %"}
WINNERS_TEXTS = {0, 2, 3, 4, 5, 6}  # columns of words


def columns(head, rows, texts):
    """Return lines of columns as wide as they need; those whose numbers are in `texts` are aligned to the left."""
    lines = [head] + rows
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    return [
        (
            GAP
            + GAP.join(c.ljust(w) if i in texts else c.rjust(w) for i, (c, w) in enumerate(zip(line, widths)))
        ).rstrip()
        for line in lines
    ]


def tolerance(tau):
    """Return the tolerance as words of ASCII, which every terminal can show."""
    return "labelled truth" if tau is None else "tau = %g px" % tau


def name_of(group):
    """Return the name of a group."""
    name = "%s, %s" % (group.dataset, features_text(group.features))
    return name if group.preselection in ("", "none") else "%s, after %s" % (name, group.preselection)


def bounds(row):
    """Return the interval of a mean F in percent; "" where it is undefined, as that of one pair."""
    if row["f_paper_lo"] is None or row["f_paper_hi"] is None:
        return ""
    return "%s..%s" % (percent(row["f_paper_lo"]), percent(row["f_paper_hi"]))


def with_bounds(text, limits):
    """Return a value with its interval in brackets where it has one."""
    return "%s (%s)" % (text, limits) if limits else text


def named_f(row):
    """Return a selector with its mean F and the interval."""
    return with_bounds("%s %s" % (row["selector"], percent(row["f_paper"])), bounds(row)) if row else "-"


def wins_text(result):
    """Return on how many of the common pairs the winner has the higher F."""
    if not result.count:
        return "-"
    ties = " (%s)" % plural(result.ties, "tie") if result.ties else ""
    return "%d of %d%s" % (result.wins, result.count, ties)


def winners_row(run, group):
    """Return the cells of a group in the table of the winners."""
    result = standing(run, group)
    if not result.first:
        return [name_of(group), "-", "no mean F", "-", "-", "-", "-", "-"]
    fastest = result.fastest
    return [
        name_of(group),
        "%d" % result.first["pairs"],
        named_f(result.first),
        named_f(result.second),
        {None: "-", True: "overlap", False: "separate"}[result.common],
        wins_text(result),
        "%s %s ms" % (fastest["selector"], milliseconds(fastest["select_s_median"])) if fastest else "-",
        percent(result.baseline["f_paper"]) if result.baseline else "-",
    ]


def ran(run, group):
    """Tell whether any selector could run on a group."""
    return not all(run.unsupported(group, selector) for selector in run.selectors_of(group))


def winners_lines(run):
    """Return the table of the winners, one line per dataset, features and preselection."""
    groups = [group for group in run.groups if group in run.means and ran(run, group)]
    if not groups:
        return ["No pair with ground truth was evaluated."]
    taus = dict.fromkeys(map(run.tau, groups))
    head = ["", "pairs", "highest F", "runner-up", "intervals", "better on", "fastest", "keep_all"]
    title = "Highest mean F in percent (%s), with its 95 %% interval:" % ", ".join(map(tolerance, taus))
    return [title] + columns(head, [winners_row(run, group) for group in groups], WINNERS_TEXTS)


def area_of(row, measure):
    """Return an area of pose_summary.csv in percent, "-" where there is none."""
    return "-" if row is None or row[measure.area] is None else percent(row[measure.area])


def named_area(row, measure):
    """Return a selector with its area and the interval."""
    if row is None:
        return "-"
    return with_bounds("%s %s" % (row["selector"], area_of(row, measure)), interval_of(row, measure))


def measure_lines(run, measure):
    """Return the table of the highest areas of pose or corner errors; nothing where none is known."""
    groups, rows = groups_of(run, measure), []
    for group, by_selector in groups.items():
        first, second = (ranking(by_selector, measure) + [None, None])[:2]
        rows.append(
            [name_of(group), "%d" % first[measure.pairs] if first else "-"]
            + [named_area(first, measure), named_area(second, measure)]
            + [area_of(by_selector.get(name), measure) for name in (BASELINE, GROUND_TRUTH)]
        )
    if not rows:
        return []
    head = ["", "pairs", "highest", "runner-up", "keep_all", "ground-truth inliers"]
    title = "Highest %s in percent, with its 95 %% interval:" % measure.area_text
    return [title] + columns(head, rows, {0, 2, 3})


def remark_lines(run):
    """Return what limits the comparison: pairs that are not in the means, selectors that did not run, images."""
    out = {}  # sentence -> groups
    for group in run.groups:
        text = left_out_sentence(run, group)
        if text:
            out.setdefault(text, []).append(name_of(group))
    lines = ["%s: %s" % ("; ".join(names), text) for text, names in out.items()]
    for dataset in filter(is_unrelated, run.datasets):
        lines.append("%s: pairs of different scenes have no F; report.html shows them." % dataset)
    return lines + remark_sentences(run)


def cell(value, show):
    """Return a value as text, "-" where it is undefined."""
    return "-" if value is None else show(value)


def known_measures(run, group):
    """Return the measures of pose and corners that are known in a group."""
    return [measure for measure in MEASURES if group in groups_of(run, measure)]


def selector_row(run, group, selector):
    """Return the cells of a selector in the table of its group; None where it did not run there."""
    row = run.means.get(group, {}).get(selector, {}).get(run.tau(group))
    if row is None or run.unsupported(group, selector):
        return None
    texts = [cell(row[name], percent) for name in ("precision", "recall_paper", "f_paper")]
    areas = [
        area_of(groups_of(run, measure)[group].get(selector), measure)
        for measure in known_measures(run, group)
    ]
    times = [cell(row[name], milliseconds) for name in ("select_s_median", "select_s_p95")]
    return [selector, cell(row["pairs"], "{:.0f}".format)] + texts + [bounds(row) or "-"] + areas + times


def group_lines(run, group):
    """Return the table of all selectors of a group."""
    title = "%s, %s, %s" % (
        "%s, %s" % (group.dataset, features_text(group.features)),
        preselection_text(group.preselection),
        tolerance(run.tau(group)),
    )
    head = ["selector", "pairs", "P %", "R %", "F %", "95 % of F"]
    head += [AREA_HEADS[measure] for measure in known_measures(run, group)] + ["median ms", "p95 ms"]
    selectors = run.selectors_of(group)
    rows = [row for row in (selector_row(run, group, s) for s in selectors) if row]
    missing = [s for s in selectors if run.unsupported(group, s)]
    lines = ["", title] + columns(head, rows, {0})
    return lines + ([GAP + "did not run: %s" % ", ".join(missing)] if missing else [])


def text(run, everything):
    """Return the winners and what limits the comparison; with everything, the tables of all selectors too."""
    lines = winners_lines(run)
    for measure in MEASURES:
        lines += measure_lines(run, measure)
    lines += remark_lines(run)
    if everything:
        for group in run.all_groups:
            lines += group_lines(run, group) if ran(run, group) else []
    return "\n".join(lines)
