"""Mean F against selection time, F pair by pair, and the time before selection."""
import numpy as np

from .figures import format_time_axis, line_style, marked, new_axes, overlap_area, pixel_boxes, place_labels
from .figures import plot_text, selector_rows
from .markup import DASH, article, group_heading, joined, panels, paragraph, sources, table, text_cell
from .scopes import figure_name, is_main, makes_variants
from .selectors import DARK, GREY, YELLOW, is_baseline
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


def time_panel(run, figures, group):
    """Draw mean F against the median selection time, the baseline as a line; '' without times."""
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
    obstacles = []
    for time, row in zip(times, rows):
        options = line_style(run.styles[row["selector"]])
        options.update(linestyle="none", markersize=7)
        with marked(axes, row["selector"]):
            if None not in (row["f_paper_lo"], row["f_paper_hi"]):
                low, high = row["f_paper_lo"], row["f_paper_hi"]
                axes.plot(
                    [time, time],
                    [low, high],
                    color=options["markeredgecolor"],
                    linewidth=1.2,
                    marker="_",
                    markersize=6,
                )
                obstacles.append(((time, low), (time, high)))
            axes.plot([time], [row["f_paper"]], **options)
    points = [(t, r["f_paper"]) for t, r in zip(times, rows)]
    for row in base:
        with marked(axes, row["selector"]):
            obstacles += draw_baseline(axes, row, points, obstacles)
    place_labels(axes, points, [r["selector"] for r in rows], obstacles)
    axes.grid(True)
    axes.set_xlabel("median selection time (ms, logarithmic)")
    axes.set_title("Mean F with 95 % interval", loc="left")
    label = "Mean F against median selection time for %s, one point per selector" % group_text(group)
    return figures(figure, label, figure_name(run, "time", group))


def distribution_panel(run, figures, group):
    """Draw F of every pair, one row of dots per selector with median and quartiles. '' without values."""
    selectors = [s for s in run.selectors_of(group) if np.isfinite(run.pair_values(group, s)).any()]
    if not selectors:
        return ""
    figure, axes = new_axes(5.0, max(3.6, 0.85 + 0.3 * len(selectors)), 1.15, 0.15, 0.5, 0.34)
    axes.grid(True, axis="x")
    for y, selector in enumerate(selectors):
        with marked(axes, selector):
            values = run.pair_values(group, selector)
            values = values[np.isfinite(values)]
            dots = values
            if len(values) > MAX_DOTS:
                dots = np.sort(values)[np.linspace(0, len(values) - 1, MAX_DOTS).round().astype(int)]
            jitter = 0.26 * (2 * ((np.arange(len(dots)) * 0.618034) % 1) - 1)
            colour = run.styles[selector]["colour"]
            edge = "#8a8420" if colour == YELLOW else colour
            axes.plot(
                dots,
                y + jitter,
                ".",
                color=colour,
                markeredgecolor=edge,
                markeredgewidth=0.4,
                markersize=4.2,
                alpha=0.6,
            )
            low, middle, high = np.percentile(values, [25, 50, 75])
            axes.plot([low, high], [y, y], color="#222222", linewidth=1.2, solid_capstyle="butt")
            axes.plot([middle], [y], "|", color="#222222", markersize=13, markeredgewidth=2.2)
    selector_rows(axes, selectors, 14, pad=0.4)
    axes.set_xlim(-0.02, 1.02)
    axes.set_xlabel("F of a pair")
    axes.set_title("F pair by pair", loc="left")
    label = "Distribution of F over the pairs of %s, one row per selector" % group_text(group)
    return figures(figure, label, figure_name(run, "pairs", group))


def stage_table(run):
    """Return the table of the median time of each stage before selection, from pairs.csv."""
    rows = []
    for key in dict.fromkeys((g.dataset, g.features) for g in run.groups):
        first = run.first_rows(*key)
        cells = [key[0], text_cell(features_text(key[1])), str(len(first))]
        for columns, show in (
            (("n_left", "n_right", "n_putative"), "{:.0f}".format),
            (("detect_s", "describe_s", "match_s"), milliseconds),
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
        " and of the time of each stage. None of it is part of the selection time. \u2013 = not measured."
    )
    return table(caption, head, rows, "results stages times")


TIME_TEXT = "Mean F: each selector with its 95 % interval against the median selection time. "
TIME_TEXT += "Up and to the left is better; the F axis does not start at 0."
MAX_DOTS = 200  # of a selector; they lie at evenly spaced ranks of more values


def distribution_text(run, group):
    """Return what the dots of the distribution show."""
    dots = "one dot per pair"
    if run.pair_count(group) > MAX_DOTS:
        dots = "%d dots for the %d pairs, at evenly spaced ranks of F" % (MAX_DOTS, run.pair_count(group))
    return "F pair by pair: %s; the thick stroke is the median, the line spans the quartiles." % dots


def html(run, figures):
    """Return the body of the section: what the experiments efficiency and per_pair do not show."""
    out = [stage_table(run), sources(run, "summary.csv", "pairs.csv")] if run.pairs else []
    for group in () if makes_variants(run) else run.groups:
        main, plots = is_main(run, group), []
        if not (main and "efficiency" in run.sections):
            plots.append((time_panel(run, figures, group), TIME_TEXT))
        if not (main and "per_pair" in run.sections):
            plots.append((distribution_panel(run, figures, group), distribution_text(run, group)))
        plots = [(plot, text) for plot, text in plots if plot]
        if plots:
            tau = run.tau(group)
            texts = [text for _, text in plots]
            texts.append("Labelled ground truth." if tau is None else "At %s." % at_tau(tau))
            figure = panels([plot for plot, _ in plots], " ".join(texts), "panels two")
            out.append(article(group_heading(group), figure))
    return joined(out) or paragraph("The run holds no pairs.")
