"""The poses that selectors give themselves: whether their covariances hold, and what they say about the motion."""
from markupsafe import Markup

from .markup import DASH, article, group_heading, selector_name, table, with_headings
from .words import group_text

TRUE_MOTIONS = ("rest", "rotation", "general")
VERDICTS = ("none", "rest", "rotation", "general", "planar")
TRANSLATED = "nees"  # the columns of pose_summary.csv begin with one of these
TURNED = "nees_rotation"


def consistency_cells(row, columns):
    """Return number, mean, median and share inside of the normalised errors of a selector."""
    count = int(row[columns + "_poses"] or 0)
    cells = ["%d" % count]
    for name, show in (
        ("mean", "%.1f".__mod__),
        ("median", "%.1f".__mod__),
        ("inside_95", lambda v: "%.1f" % (100 * v)),
    ):
        value = row["%s_%s" % (columns, name)]
        cells.append(DASH if value is None else show(value))
    return cells


def covariance_table(group, rows, selectors):
    """Return the table of the normalised errors of a group."""
    head = ["Selector", "Poses", "Mean NEES", "Median", "Inside 95 %", "Rotations", "Mean NEES", "Median"]
    head += ["Inside 95 %", "Uncertain"]
    lines = []
    for selector in selectors:
        row = rows[selector]
        cells = consistency_cells(row, TRANSLATED) + consistency_cells(row, TURNED)
        cells.append("%d" % (row["uncertain"] or 0))
        lines.append((selector, ("", [selector_name(selector)] + cells)))
    caption = (
        "Covariance, %s. The normalised error squared (NEES) of poses with a translation has a mean of 5 and a median"
        " of 4.4 where the covariance is right, that of rotations 3 and 2.4; then 95 %% of the true poses lie inside"
        " the ellipsoid. Poses of planes with a second pose are left out. Uncertain: no covariance is given."
    ) % group_text(group)
    return table(caption, head, with_headings(lines), "results")


def verdict_counts(rows):
    """Return (true motion, verdict) -> number of selections with a verdict, of the Rows of a selector."""
    counts = {}
    for true_motion in TRUE_MOTIONS:
        moved = rows.has("true_motion", true_motion)
        for verdict in VERDICTS:
            counts[true_motion, verdict] = int((moved & rows.has("motion", verdict)).sum())
    return counts


def verdict_table(group, poses, selectors):
    """Return the table of the verdicts of a group."""
    lines = []
    for selector in selectors:
        counts = verdict_counts(poses.rows(group, selector))
        for true_motion in TRUE_MOTIONS:
            cells = [counts[true_motion, verdict] for verdict in VERDICTS]
            if sum(cells):
                lines.append(("", [selector, true_motion] + ["%d" % count for count in cells + [sum(cells)]]))
    head = ["Selector", "True motion"] + list(VERDICTS) + ["all"]
    caption = (
        "Verdicts, %s: how the camera moved, as the selector says, one count per pair and seed. General: translated;"
        " a plane is one of these where it is right."
    ) % group_text(group)
    return table(caption, head, lines, "results counts")


def consistency_article(group, rows, poses):
    """Return the article on covariances and verdicts of a group.

    rows: selector -> row of pose_summary.csv, in the order of the report; poses: poses.csv, or None.
    """
    title = Markup("Covariance and verdicts: %s") % group_heading(group)
    tables = [covariance_table(group, rows, list(rows))]
    if poses:
        tables.append(verdict_table(group, poses, list(rows)))
    return article(title, *tables)
