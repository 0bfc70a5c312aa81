"""What selections are good for: errors of the pose, and of the corners of the image under a homography."""
import csv
from collections import OrderedDict, namedtuple

import numpy as np
from markupsafe import Markup

from .figures import draw_part, line_figures, new_axes, part_ending, visible
from .markup import DASH, article, best_cell, group_heading, joined, paragraph, selector_name, sources, table
from .markup import with_headings
from .own_pose import consistency_article
from .reading import POSES_HEADER, RowTable, group_of
from .selectors import DARK, is_baseline, selector_key
from .tables import ReportError, read_columns
from .words import group_text

GROUND_TRUTH = "ground_truth"  # the row of all ground-truth inliers

# One of both tables. `columns` are (heading, column of pose_summary.csv, unit); `area` is marked and has an interval.
Measure = namedtuple("Measure", "key title pairs area area_text failed columns error axis longest caption")
POSE = Measure(
    "pose",
    "Relative pose",
    "poses",
    "auc_10",
    "pose AUC at 10 degrees",
    "no_pose",
    (
        ("AUC at 5\u00b0", "auc_5", "percent"),
        ("AUC at 10\u00b0 (95 %)", "auc_10", "percent"),
        ("AUC at 20\u00b0", "auc_20", "percent"),
        ("mAA", "maa_10", "percent"),
        ("Median rotation (\u00b0)", "rotation_deg_median", "angle"),
        ("Median translation (\u00b0)", "translation_deg_median", "angle"),
        ("Median pose (\u00b0)", "pose_deg_median", "angle"),
        ("Epipolar precision", "epipolar_precision", "percent"),
    ),
    "pose_deg",
    "pose error (degrees)",
    20.0,
    "AUC, mean average accuracy and epipolar precision in percent. The medians of rotation and translation are those of"
    " the poses found; a pair without a pose counts as 180 degrees.",
)
CORNERS = Measure(
    "corners",
    "Corner error",
    "homographies",
    "corner_auc_3",
    "corner AUC at 3 px",
    "no_homography",
    (
        ("AUC at 1 px", "corner_auc_1", "percent"),
        ("AUC at 3 px (95 %)", "corner_auc_3", "percent"),
        ("AUC at 5 px", "corner_auc_5", "percent"),
        ("Median (px)", "corner_px_median", "pixels"),
    ),
    "corner_px",
    "mean error of the four corners (px)",
    10.0,
    "AUC in percent. A pair without a homography has an infinite error.",
)
OWN = Measure(
    "own_pose",
    "The selector's own pose",
    "own_poses",
    "own_auc_10",
    "AUC at 10 degrees of its own pose",
    "own_no_pose",
    (
        ("AUC at 5\u00b0", "own_auc_5", "percent"),
        ("AUC at 10\u00b0 (95 %)", "own_auc_10", "percent"),
        ("AUC at 20\u00b0", "own_auc_20", "percent"),
        ("Common estimator at 5\u00b0", "auc_5", "percent"),
        ("at 10\u00b0", "auc_10", "percent"),
        ("at 20\u00b0", "auc_20", "percent"),
        ("Median rotation (\u00b0)", "own_rotation_deg_median", "angle"),
        ("Median translation (\u00b0)", "own_translation_deg_median", "angle"),
        ("Median pose (\u00b0)", "own_pose_deg_median", "angle"),
    ),
    "own_pose_deg",
    "pose error (degrees)",
    20.0,
    "AUC in percent. The common estimator is that of the table above, on the same matches. A verdict without a pose, and"
    " one without a translation where the camera has moved, count as 180 degrees.",
)
MEASURES = (POSE, OWN, CORNERS)
FORMATS = {
    "percent": lambda value: "%.1f" % (100 * value),
    "angle": lambda value: "%.2f" % value,
    "pixels": lambda value: "%.2f" % value,
}


def groups_of(run, measure):
    """Return group -> selector -> row of pose_summary.csv, of the groups in which the measure is known."""
    groups = {}
    for row in run.pose_summary:
        if row[measure.pairs]:
            groups.setdefault(group_of(row), {})[row["selector"]] = row
    return groups


def ordered(rows):
    """Return the selectors of a group in the report's order; the ground-truth inliers are the last."""
    return sorted(
        rows, key=lambda name: (name == GROUND_TRUTH, () if name == GROUND_TRUTH else selector_key(name))
    )


def competes(selector):
    """Tell whether a row of the tables is that of a competing selector."""
    return selector != GROUND_TRUTH and not is_baseline(selector)


def ranking(rows, measure):
    """Return the rows of the competing selectors, the largest area first."""
    found = [r for name, r in rows.items() if competes(name) and r[measure.area] is not None]
    return sorted(found, key=lambda row: (-row[measure.area], selector_key(row["selector"])))


def interval_of(row, measure):
    """Return the interval of the area as text in percent; "" where it is undefined."""
    bounds = [row[measure.area + end] for end in ("_lo", "_hi")]
    return "" if None in bounds else "%s..%s" % tuple(map(FORMATS["percent"], bounds))


def label_html(selector):
    """Return the name of a row as HTML."""
    if selector == GROUND_TRUTH:
        return Markup('ground-truth inliers <span class="small">errors up to t<sub>gt</sub></span>')
    return selector_name(selector)


def is_single(rows, measure):
    """Tell whether rows of a group are about one pair, of which an area or an interval tells nothing."""
    return all(row[measure.pairs] < 2 for row in rows.values())


def only_single_pairs(run):
    """Tell whether no measure of the run has more than one pair in a group."""
    shown = [(rows, measure) for measure in MEASURES for rows in groups_of(run, measure).values()]
    return bool(shown) and all(is_single(*each) for each in shown)


def single_table(group, rows, measure):
    """Return the table of a group of one pair: the errors themselves."""
    columns = [each for each in measure.columns if "auc" not in each[1] and "maa" not in each[1]]
    head = ["Selector"] + [
        title.replace("Median ", "Error of ").replace(" pose", " the pose") for title, _, _ in columns
    ]
    lines = []
    for selector in ordered(rows):
        values = [(rows[selector][column], FORMATS[unit]) for _, column, unit in columns]
        cells = [DASH if value is None else show(value) for value, show in values]
        lines.append(("" if competes(selector) else "baseline", [label_html(selector)] + cells))
    caption = "%s of the one pair of %s." % (measure.title, group_text(group))
    if measure is POSE:
        caption += " Epipolar precision in percent."
    return table(caption, head, lines, "results")


def measure_table(group, rows, measure):
    """Return the table of a group."""
    head = ["Selector", "Pairs"] + [title for title, _, _ in measure.columns] + ["Without result"]
    best = max((row[measure.area] for row in ranking(rows, measure)), default=None)
    lines = []
    for selector in ordered(rows):
        row = rows[selector]
        cells = [label_html(selector), "%d" % row[measure.pairs]]
        for _, column, unit in measure.columns:
            text = DASH if row[column] is None else FORMATS[unit](row[column])
            if column != measure.area:
                cells.append(text)
                continue
            bounds = interval_of(row, measure)
            rest = Markup(' <span class="nb">(%s)</span>') % bounds.replace("..", DASH) if bounds else ""
            wins = competes(selector) and row[column] is not None and row[column] == best
            cells.append(best_cell(text, rest, of="column") if wins else text + rest)
        cells.append("%d" % (row[measure.failed] or 0))
        lines.append((selector, ("" if competes(selector) else "baseline", cells)))
    caption = "%s, %s. %s" % (measure.title, group_text(group), measure.caption)
    selectors = [line for line in lines if line[0] != GROUND_TRUTH]
    return table(
        caption,
        head,
        with_headings(selectors) + [row for name, row in lines if name == GROUND_TRUTH],
        "results",
    )


def read_poses(run):
    """Return poses.csv as a RowTable; None, with a note, where it cannot be used."""
    path = run.folder / "poses.csv"
    try:
        return RowTable(read_columns(path, POSES_HEADER, run.notes))
    except (ReportError, OSError, csv.Error) as error:
        run.notes.append(
            "poses.csv was not used (%s): the curves of errors are left out." % str(error).rstrip(".")
        )
    return None


def recall(errors, total, longest):
    """Return the shares of `total` up to each error, as a curve of steps that ends at `longest`."""
    below = np.sort(errors[errors < longest])
    x = np.concatenate([[0.0], np.repeat(below, 2), [longest]])
    y = np.repeat(np.arange(len(below) + 1) / max(total, 1), 2)
    shown = visible(x, y)
    return x[shown], y[shown]


def curves_of(poses, group, rows, measure):
    """Return selector -> curve of recall against error, of the rows of a group in pose_summary.csv."""
    curves = {}
    for selector, row in rows.items():
        errors = poses.rows(group, selector)[measure.error]
        errors = errors[np.isfinite(errors)]
        # A homography that was not found has an infinite error, a pose that was not found one of 180 degrees.
        total = len(errors) + (int(row[measure.failed] or 0) if measure is CORNERS else 0)
        curves[selector] = recall(errors, total, measure.longest)
    return curves


def curve_panel(run, figures, group, measure, curves, part):
    """Draw the recall of the selectors of a part against the error."""
    figure, axes = new_axes(4.6, 3.4, 0.55, 0.15, 0.5, 0.34)
    if GROUND_TRUTH in curves:
        axes.plot(*curves[GROUND_TRUTH], color=DARK, linewidth=1.0, linestyle=":")
    draw_part(axes, run, part, lambda selector, named: curves[selector], markevery=0.2)
    axes.set_xlim(0, measure.longest)
    axes.set_ylim(-0.02, 1.03)
    axes.set_xlabel(measure.axis)
    axes.set_title("share of the pairs with a smaller error", loc="left")
    axes.grid(True)
    label = "%s of %s: share of the pairs with a smaller error" % (measure.title, group_text(group))
    name = "_".join((measure.key,) + group) + part_ending(part)
    return figures(figure, label, name)


def curves_html(run, figures, group, rows, measure, poses):
    """Return the figure of a group."""
    curves = curves_of(poses, group, rows, measure)

    def plots(part):
        return [curve_panel(run, figures, group, measure, curves, part)]

    caption = "Dotted: the ground-truth inliers. A curve that ends below 1 has pairs with larger errors."
    selectors = [name for name in ordered(rows) if name in run.styles]
    return line_figures(run, figures, selectors, plots, "panels", caption)


def area_with_interval(row, measure):
    """Return the area of a row in percent with its interval where it has one."""
    bounds = interval_of(row, measure).replace("..", DASH)
    area = "%s %%" % FORMATS["percent"](row[measure.area])
    return area + Markup(' <span class="nb">(95 %% interval %s)</span>') % bounds if bounds else area


def statement(rows, measure):
    """Return who has the largest area, as a sentence; "" without competing selectors or with a single pair."""
    best = ranking(rows, measure)
    if not best or is_single(rows, measure):
        return ""
    text = Markup("<b>%s</b> has the highest %s, %s") % (
        best[0]["selector"],
        measure.area_text,
        area_with_interval(best[0], measure),
    )
    if len(best) > 1:
        values = (best[1]["selector"], area_with_interval(best[1], measure))
        text += Markup(", ahead of <b>%s</b> with %s") % values
    perfect = rows.get(GROUND_TRUTH)
    if perfect and perfect[measure.area] is not None:
        text += "; the ground-truth inliers alone give %s %%" % FORMATS["percent"](perfect[measure.area])
    return text + "."


def html(run, figures):
    """Return the body of the section."""
    shown = [(measure, groups_of(run, measure)) for measure in MEASURES]
    if not any(groups for _, groups in shown):
        return paragraph("The run has no pairs with a known pose or homography yet.")
    out = [
        paragraph(
            "The pose, or the homography, that the selected matches give. The estimator is the same for all selectors,"
            " so that what differs is the selection; it knows nothing of a selector but its mask, and its model where"
            " that is a homography. docs/evaluation.md defines the measures."
        ),
        sources(run, "pose_summary.csv", "poses.csv"),
    ]
    poses = read_poses(run)
    articles = [(measure, group, rows) for measure, groups in shown for group, rows in groups.items()]
    for measure, group, rows in sorted(articles, key=lambda each: is_single(each[2], each[0])):
        title = Markup("%s: %s") % (measure.title, group_heading(group))
        if is_single(rows, measure):
            out.append(article(title, single_table(group, rows, measure)))
        else:
            curves = curves_html(run, figures, group, rows, measure, poses) if poses else ""
            result = paragraph(statement(rows, measure))
            out.append(article(title, result, measure_table(group, rows, measure), curves))
        if measure is OWN:
            named = OrderedDict((name, rows[name]) for name in ordered(rows))
            out.append(consistency_article(group, named, poses))
    return joined(out)
