"""Experiment budget: what every selector reaches in a limited time, and which one to use with how many milliseconds."""
from collections import namedtuple

from .figures import draw_part, edge_of, format_time_axis, line_figures, marked, new_axes, part_ending
from .figures import plot_text
from .inference import is_separate, mean_interval
from .markup import DASH, article, bold, group_heading, joined, paragraph, sources, table, text_cell
from .markup import with_headings
from .reading import group_of
from .scopes import figure_name
from .selectors import TIME_LIMIT, budget_name, is_baseline, selector_key, take_apart
from .words import at_tau, group_text, milliseconds, with_interval

BUDGETS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)  # s, the limits that the experiment sets

# One selector with one limit (None: it has none) in a group: mean F with its row of summary.csv, median and 95th
# percentile of the time that it took, s, and the shares of its selections that the limit stopped with and without a
# result.
Taken = namedtuple("Taken", "selector limit row median p95 stopped without")


def limit_of(selector):
    """Return the time limit in a selector's name, s; None without one."""
    text = take_apart(selector).options.get(TIME_LIMIT)
    return float(text) if text else None


def taken(run, group, selector):
    """Return what a selector with its limit reached in a group; None without means or times."""
    row = run.mean(group, selector, run.tau(group))
    if not row or row["select_s_median"] is None or row["select_s_p95"] is None:
        return None
    counts = run.statuses.get((group, selector), {})
    shares = [counts.get(status, 0) / max(1, sum(counts.values())) for status in ("time_limit", "too_large")]
    return Taken(selector, limit_of(selector), row, row["select_s_median"], row["select_s_p95"], *shares)


# What pose_summary.csv tells about a dataset: the column with the number of pairs, the measure, and its name.
POSES = (
    ("poses", "auc_10", "Pose AUC at 10 degrees"),
    ("homographies", "corner_auc_3", "Corner AUC at 3 px"),
)


def pose_measures(run, group):
    """Return (name, selector -> value) of each measure of poses or corners that a group has."""
    out = []
    for count, column, name in POSES:
        values = {
            row["selector"]: row[column]
            for row in run.pose_summary
            if group_of(row) == group and row[count] and row[column] is not None
        }
        if values:
            out.append((name, values))
    return out


def lines_of(run, group):
    """Return name without limit -> its Taken by rising limits, of the competing selectors with means."""
    lines = {}
    for selector in sorted(run.selectors_of(group), key=selector_key):
        found = None if is_baseline(selector) else taken(run, group, selector)
        if found:
            lines.setdefault(budget_name(selector), []).append(found)
    return lines


def best_within(lines, seconds, time):
    """Return the Taken with the highest mean F whose time ("median" or "p95") is at most `seconds`; None without."""
    fitting = [t for line in lines.values() for t in line if getattr(t, time) <= seconds]
    return max(fitting, key=lambda t: (t.row["f_paper"], -t.median)) if fitting else None


def not_separated(run, group, lines, seconds, time, best):
    """Return the names, without limits, of other selectors within the time that the pairs cannot tell from the best."""
    names = []
    for name, line in lines.items():
        own = best_within({name: line}, seconds, time) if name != budget_name(best.selector) else None
        differences = run.differences(group, best.selector, own.selector) if own else []
        if len(differences) > 0 and not is_separate(mean_interval(differences)):
            names.append(name)
    return names


def best_cells(run, group, lines, seconds, time):
    """Return the cells on the best selector within a time."""
    best = best_within(lines, seconds, time)
    if not best:
        return [DASH, DASH, DASH, DASH]
    row = best.row
    level = not_separated(run, group, lines, seconds, time, best)
    return [
        text_cell(bold(best.selector)),
        with_interval(row),
        "%s / %s" % (milliseconds(best.median), milliseconds(best.p95)),
        text_cell(", ".join(level) or DASH),
    ]


def choice_table(run, group, lines):
    """Return the table on which selector to use with how many milliseconds."""
    rows = []
    for seconds in BUDGETS:
        cells = ["%g ms" % (1e3 * seconds)]
        for time in ("median", "p95"):
            cells += best_cells(run, group, lines, seconds, time)
        rows.append(("", cells))
    part = ["F with interval", "Median / p95, ms", "Not separated from it"]
    head = ["Time", "Best whose median fits"] + part + ["Best whose p95 fits"] + part
    caption = (
        "Which selector when there are so many milliseconds: %s, %s. The time counts that was really taken, whatever the"
        " limit. On the left the median of the pairs must fit, on the right the 95th percentile. Not separated: other"
        " selectors, with the limit that suits the time best, whose paired difference in F has an interval that contains 0."
        % (group_text(group), at_tau(run.tau(group)))
    )
    return table(caption, head, rows, "results")


def limit_table(run, group, lines):
    """Return the table of every selector and limit: F, the time taken and how far it goes beyond the limit."""
    rows = []
    for line in lines.values():
        for t in line:
            over = None if t.limit is None else t.p95 - t.limit
            cells = [
                t.selector,
                DASH if t.limit is None else "%g" % (1e3 * t.limit),
                with_interval(t.row),
                milliseconds(t.median),
                milliseconds(t.p95),
                DASH if over is None else "0" if over <= 0 else "+" + milliseconds(over),
            ]
            cells += [DASH if t.limit is None else "%.0f %%" % (100 * v) for v in (t.stopped, t.without)]
            rows.append((t.selector, ("", cells)))
    head = ["Selector", "Limit, ms", "F with interval", "Median, ms", "p95, ms", "Overshoot, ms"]
    head += ["Best until then", "No result"]
    caption = (
        "Every limit: %s, %s. Overshoot: the 95th percentile of the time less the limit; selectors look at the clock"
        " between steps, and what comes before and after the search is not limited. Best until then: share of the"
        " selections that the limit ended with the best result so far; no result: share of those that had none yet"
        " (status too large)." % (group_text(group), at_tau(run.tau(group)))
    )
    return table(caption, head, with_headings(rows), "results")


def time_panel(run, figures, group, lines, part, values, title, prefix):
    """Draw the values of selectors against the median time taken; whiskers reach to the 95th percentile."""
    figure, axes = new_axes(5.6, 4.1, 0.55, 0.15, 0.5, 0.34)
    times = [1e3 * max(t.median, 1e-6) for line in lines.values() for t in line]
    axes.set_xscale("log")
    axes.set_xlim(min(times) / 2, 1e3 * max(t.p95 for line in lines.values() for t in line) * 1.5)
    for seconds in BUDGETS:
        axes.axvline(1e3 * seconds, color="#e2e2e2", linewidth=0.7, zorder=0)

    def line_of(name, named):
        line = [t for t in lines.get(name, ()) if t.selector in values and not is_baseline(name)]
        x, y = [1e3 * max(t.median, 1e-6) for t in line], [values[t.selector] for t in line]
        whisker = dict(linewidth=0.7, alpha=0.6, zorder=0.9)
        for at, f, t in zip(x, y, line) if named else ():
            edge = edge_of(run.styles[name])
            axes.plot([at, max(at, 1e3 * t.p95)], [f, f], color=edge, **whisker)
        return (x, y) if line else None

    draw_part(axes, run, part, line_of)
    for name in part.names:
        base = run.mean(group, name, run.tau(group)) if is_baseline(name) and prefix == "budget" else None
        if base:
            with marked(axes, name):
                axes.axhline(base["f_paper"], label=plot_text(name), color="#767676", linestyle=(0, (1, 1.5)))
    low, high = axes.get_xlim()
    format_time_axis(axes, low, high)
    axes.grid(True, axis="y")
    axes.set_xlabel("median time really taken (ms, logarithmic)")
    axes.set_title("%s: %s" % (plot_text(group.dataset), title), loc="left")
    label = "%s against the time really taken for %s, one point for each time limit"
    label %= (title, group_text(group))
    return figures(figure, label, figure_name(run, prefix, group) + part_ending(part))


def group_html(run, figures, group, lines):
    """Return figure and tables of one group."""
    names = list(lines)
    names += [s for s in run.selectors_of(group) if is_baseline(s) and run.mean(group, s, run.tau(group))]

    measures = [("Mean F", {t.selector: t.row["f_paper"] for line in lines.values() for t in line})]
    measures += pose_measures(run, group)

    def plots(part):
        for i, (name, values) in enumerate(measures):
            yield time_panel(run, figures, group, lines, part, values, name, "budget_pose" if i else "budget")

    caption = (
        "Mean F at %s%s against the median of the time that was really taken. A line joins the time limits of a selector,"
        " %s ms; a selector without a limit is one point. The thin lines reach to the 95th percentile of the time."
        % (
            at_tau(run.tau(group)),
            "".join(" and %s" % name for name, _ in measures[1:]),
            ", ".join("%g" % (1e3 * s) for s in BUDGETS),
        )
    )
    return article(
        group_heading(group),
        line_figures(run, figures, names, plots, "panels two", caption),
        choice_table(run, group, lines),
        limit_table(run, group, lines),
    )


def html(run, figures):
    """Return the body of the section."""
    out = [
        paragraph(
            "Every selector that has a time limit was run with several limits. What a limited search finds depends on the"
            " speed and the load of the machine, so that these results are not the same from run to run."
        ),
        sources(run, "summary.csv", "pairs.csv"),
    ]
    shown = [(group, lines_of(run, group)) for group in run.groups if group in run.means]
    shown = [(group, lines) for group, lines in shown if lines]
    if not shown:
        return paragraph("No selector has a mean F and a time.")
    out += [group_html(run, figures, group, lines) for group, lines in shown]
    return joined(out)
