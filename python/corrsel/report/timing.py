"""Mean F against selection time, and the time before selection."""
import numpy as np

from .figures import format_time_axis, line_style, marked, new_axes, overlap_area, pixel_boxes, place_labels
from .figures import plot_text
from .markup import DASH, article, group_heading, joined, panels, paragraph, sources, table, text_cell
from .scopes import figure_name, is_main, makes_variants, opening_groups, switches_of
from .selectors import DARK, GREY, are_many, is_baseline
from .words import at_tau, features_text, group_text, milliseconds


def draw_baseline(axes, row, points, obstacles):
    """Draw the baseline's mean F as a line, its name where it covers least; return both as obstacles."""
    scale, frame = axes.figure.dpi / 72.0, axes.get_window_extent()
    value, text = row["f_paper"], "%s, F %.3f" % (plot_text(row["selector"]), row["f_paper"])
    width, height = 4.9 * len(text) * scale, 10 * scale
    y = axes.transData.transform((points[0][0], value))[1]
    taken, best = pixel_boxes(axes, points, obstacles), None
    for place in (0.995, 0.005, 0.75, 0.25, 0.5):
        x = frame.x0 + place * frame.width - place * width
        for side in (1, -1):
            box = (x, y, x + width, y + height) if side > 0 else (x, y - height, x + width, y)
            cost = sum(overlap_area(box, other) for other in taken)
            if best is None or cost < best[0]:
                best = (cost, box, side)
    _, box, side = best
    axes.axhline(value, color=GREY, linestyle=(0, (1, 1.5)), linewidth=1.2)
    at = axes.transData.inverted().transform([box[:2], box[2:]])
    axes.annotate(
        text,
        (at[0][0], value),
        xytext=(0, 2 * side),
        textcoords="offset points",
        color=DARK,
        fontsize=8,
        va="bottom" if side > 0 else "top",
    )
    left, right = axes.get_xlim()
    return [((left, value), (right, value)), (tuple(at[0]), tuple(at[1]))]


def limits_of_f(rows):
    """Return axis limits that hold the F values of rows with their intervals, at least 0.2 apart."""
    values = [r[k] for r in rows for k in ("f_paper", "f_paper_lo", "f_paper_hi") if r[k] is not None]
    low, high = min(values), max(values)
    pad = max(0.1 * (high - low), (0.2 - (high - low)) / 2, 0.02)
    return low - pad, high + pad


def lines_of(run, rows):
    """Return name -> rows: of the variants of a selector that a preset joins, or one row for each selector."""
    if not makes_variants(run):
        return {row["selector"]: [row] for row in rows}
    names = {selector: name for name, variants in switches_of(run).items() for selector in variants}
    lines = {}
    for row in rows:
        lines.setdefault(names[row["selector"]], []).append(row)
    return lines


def unbeaten(rows):
    """Return the rows that no other one beats in both time and F."""
    out = []
    for row in sorted(rows, key=lambda row: (row["select_s_median"], -row["f_paper"])):
        if not out or row["f_paper"] > out[-1]["f_paper"]:
            out.append(row)
    return out


def draw_selectors(axes, run, lines, named):
    """Draw a point for each row of the lines, in colour where the best one is named; return obstacles.

    Points that stand alone have their intervals. The best of several points is larger than the others.
    """
    obstacles = []
    for rows in lines.values():
        best = highest(rows)
        for row in rows:
            time, f, low, high = 1e3 * row["select_s_median"], *(
                row[k] for k in ("f_paper", "f_paper_lo", "f_paper_hi")
            )
            style = dict(run.styles[row["selector"]], marker=run.styles[best["selector"]]["marker"])
            options = dict(line_style(style), linestyle="none", markersize=7 if row is best else 4)
            if best not in named:
                options.update(marker="o", markersize=4, markerfacecolor="#c4c4c4", markeredgecolor="#9a9a9a")
            with marked(axes, row["selector"]):
                if best in named and len(rows) == 1 and None not in (low, high):
                    colour = options["markeredgecolor"]
                    axes.plot([time] * 2, [low, high], color=colour, linewidth=1.2, marker="_", markersize=6)
                    obstacles.append(((time, low), (time, high)))
                axes.plot([time], [f], **options)
    return obstacles


def highest(rows):
    """Return the row with the highest mean F."""
    return max(rows, key=lambda row: row["f_paper"])


def time_panel(run, figures, group, name="time"):
    """Draw mean F against the median selection time, the baseline as a line; '' without times.

    Of many selectors those are named that no other one beats; variants that a preset joins have one name.
    """
    rows = [r for r in run.ranking(group) if (r["select_s_median"] or 0) > 0]
    if not rows:
        return ""
    tau = run.tau(group)
    base = [run.mean(group, s, tau) for s in run.selectors_of(group) if is_baseline(s)]
    base = [row for row in base if row]
    figure, axes = new_axes(5.0, 3.6, 0.55, 0.25, 0.5, 0.34)
    times = [1e3 * r["select_s_median"] for r in rows]
    axes.set_xscale("log")
    axes.set_xlim(min(times) / 2, max(times) * 3)
    axes.set_ylim(*limits_of_f(rows + base))
    format_time_axis(axes, min(times) / 2, max(times) * 3)
    lines = lines_of(run, rows)
    named = [highest(line) for line in lines.values()]
    if are_many(named):
        named = unbeaten(named)
    obstacles = draw_selectors(axes, run, lines, named)
    points = [(1e3 * row["select_s_median"], row["f_paper"]) for row in named]
    for row in base:
        with marked(axes, row["selector"]):
            obstacles += draw_baseline(axes, row, points, obstacles)
    names = [next(name for name, line in lines.items() if row in line) for row in named]
    place_labels(axes, points, [row["selector"] for row in named], obstacles, names)
    axes.grid(True)
    axes.set_xlabel("median selection time (ms, logarithmic)")
    axes.set_title("%s: mean F" % plot_text(group.dataset, 40), loc="left")
    label = "Mean F against median selection time for %s, one point per selector" % group_text(group)
    return figures(figure, label, figure_name(run, name, group))


def stage_table(run):
    """Return the table of the median time of each stage before selection, from pairs.csv."""
    rows = []
    for key in dict.fromkeys((g.dataset, g.features) for g in run.groups):
        first = run.first_rows(*key)
        cells = [key[0], text_cell(features_text(key[1])), str(len(first))]
        for columns, show in (
            (("n_left", "n_right", "n_putative"), "{:.0f}".format),
            # A time of 0 means that one pass detects and describes.
            (("detect_s", "describe_s", "match_s"), lambda value: milliseconds(value) if value else DASH),
        ):
            for column in columns:
                values = run.pairs.columns[column][first]
                values = values[np.isfinite(values)]
                cells.append(show(float(np.median(values))) if len(values) else DASH)
        rows.append(("", cells))
    head = ["Dataset", "Features", "Pairs", "Left", "Right", "Matches"]
    head += [stage + " (ms)" for stage in ("Detect", "Describe", "Match")]
    caption = (
        "What comes before selection: medians over the pairs of the number of features and putative matches,"
        " and of the time of each stage. None of it is part of the selection time. \u2013 = not measured, or part of the"
        " stage before."
    )
    return table(caption, head, rows, "results stages times")


def time_text(run, groups):
    """Return what the pictures of F against time of some groups show."""
    text = "Mean F of each selector against its median time for one pair of images, in ms. Up and to the left is better; the"
    text += " F axis does not start at 0."
    if makes_variants(run):
        return text + " The variants of a selector have its colour; the one with the highest F is named."
    if are_many(run.selectors):
        text += " Named in colour are the selectors that no other one beats in both F and time."
    single = all(run.pair_count(group) < 2 for group in groups)
    return text if single else text + " The bars are 95 % intervals of the mean."


def html(run, figures):
    """Return the body of the section: the time of the stages, and of settings that neither opening nor efficiency shows."""
    out = [stage_table(run), sources(run, "summary.csv", "pairs.csv")] if run.pairs else []
    shown = opening_groups(run)
    for group in () if makes_variants(run) else run.groups:
        if group in shown or (is_main(run, group) and "efficiency" in run.sections):
            continue
        plot = time_panel(run, figures, group)
        if plot:
            tau = run.tau(group)
            text = "%s %s" % (
                time_text(run, [group]),
                "Labelled ground truth." if tau is None else "At %s." % at_tau(tau),
            )
            out.append(article(group_heading(group), panels([plot], text, "panels two")))
    return joined(out) or paragraph("The run holds no pairs.")
