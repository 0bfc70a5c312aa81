"""Experiment curves: precision against recall of each selector over its main parameter, and where its default lies."""
from collections import namedtuple

import numpy as np
from markupsafe import Markup

from .figures import draw_part, line_figures, line_style, new_axes, part_ending, plot_text
from .groups import MAIN_PARAMETERS
from .inference import mean_interval
from .markup import DASH, article, best_cell, bold, findings, group_heading, heading, joined, paragraph
from .markup import sources, table, text_cell, with_headings
from .reading import Group
from .scopes import figure_name
from .selectors import curve_name, is_baseline, selector_key, take_apart
from .words import GIVEN, at_tau, features_text, fraction, group_text, plural, span

FAR = 0.02  # mean F by which a default must be below the best of its curve to be named

# One variant of a selector: `value` of its main parameter as text, None where the data choose it; `default` tells
# whether it is the selector itself; `f`, `precision` and `recall` are means over pairs.
Point = namedtuple("Point", "selector value default precision recall f")


def variants_of(names):
    """Return curve name -> selector names, by rising values of the main parameter, of those with several variants."""
    curves = {}
    for name in sorted(names, key=selector_key):
        curves.setdefault(curve_name(name), []).append(name)
    return {name: variants for name, variants in curves.items() if len(variants) > 1}


def value_of(selector, variants):
    """Return the value of a variant's main parameter as text; None where the selector itself has none of the values.

    The selector itself takes the place of the variant that is missing in the row of its variants.
    """
    base = take_apart(selector).base
    if base not in MAIN_PARAMETERS:
        return None  # the baseline
    option, values = next(iter(MAIN_PARAMETERS[base].items()))
    given = take_apart(selector).options.get(option)
    if given is not None:
        return given
    others = {float(take_apart(name).options[option]) for name in variants if name != selector}
    missing = [value for value in values if value not in others]
    return "%g" % missing[0] if len(missing) == 1 else None


def curve(run, group, variants):
    """Return the Points of a curve that have means in a group, by rising values, one without a value first."""
    tau, out = run.tau(group), []
    for name in variants:
        row = run.mean(group, name, tau)
        if row:
            numbers = (row["precision"], row["recall_paper"], row["f_paper"])
            out.append(Point(name, value_of(name, variants), name == curve_name(name), *numbers))
    return sorted(out, key=lambda p: (p.value is not None, float(p.value or 0)))


def area(points):
    """Return the area under a curve, 0..1; None without a point that has a precision.

    The precision at a recall R is the highest one of the points with a recall of at least R. So the curve is extended
    horizontally from its point with the least recall to recall 0, and beyond its largest recall the precision is 0.
    """
    known = sorted((p.recall, p.precision) for p in points if p.precision is not None)
    if not known:
        return None
    recall = np.array([r for r, _ in known])
    precision = np.maximum.accumulate([p for _, p in known[::-1]])[::-1]
    return float(np.sum(np.diff(np.concatenate([[0.0], recall])) * precision))


def best_of(points):
    """Return the point with the highest mean F; of several, the default or else the first."""
    return max(points, key=lambda p: (p.f, p.default))


def default_of(points):
    """Return the point of the selector itself; None where it has no means."""
    return next((p for p in points if p.default), None)


def parameter_text(selector):
    """Return the options of a selector's main parameter as words."""
    parameter = MAIN_PARAMETERS[take_apart(selector).base]
    same = len(set(map(tuple, parameter.values()))) == 1
    return (" = " if same else ", ").join(parameter)


def value_text(point):
    """Return the value of a point as words."""
    return "from the data" if point.value is None else point.value


# ---------------------------------------------------------------------------------------------- all datasets

# How a default stands on all datasets together: `groups` in which all its variants have means, the names of default
# and best, the means over the groups of their mean F, and the Estimate of the difference best - default.
Verdict = namedtuple("Verdict", "groups default best f best_f difference")


def groups_together(run):
    """Return features -> groups that are compared together: those of the features, and those of given matches."""
    groups = [g for g in run.groups if g in run.means]
    given = [g for g in groups if g.features == GIVEN]
    features = dict.fromkeys((g.features, g.preselection) for g in groups if g.features != GIVEN)
    if not features:
        return dict([(Group("", GIVEN, "none"), given)] if given else [])
    return {
        Group("", name, before): [g for g in groups if (g.features, g.preselection) == (name, before)] + given
        for name, before in features
    }


def difference(run, groups, first, second):
    """Return the Estimate of the mean over the groups of the mean difference in F of their pairs.

    Each difference is weighted so that every group counts the same; the pairs of all groups are resampled together.
    """
    lists = [run.differences(group, first, second) for group in groups]
    lists = [values for values in lists if len(values) > 0]
    total = sum(map(len, lists))
    return mean_interval(np.concatenate([v * (total / (len(lists) * len(v))) for v in lists]))


def verdict(run, groups, variants):
    """Return the Verdict on a curve; None where no group has all of its points."""
    rows = [(g, curve(run, g, variants)) for g in groups]
    rows = [(g, points) for g, points in rows if len(points) == len(variants)]
    if not rows:
        return None
    groups = [g for g, _ in rows]
    together = [
        Point(p[0].selector, p[0].value, p[0].default, None, None, float(np.mean([q.f for q in p])))
        for p in zip(*(points for _, points in rows))
    ]
    default, best = default_of(together), best_of(together)
    if default is None:
        return None
    return Verdict(
        groups, default, best, default.f, best.f, difference(run, groups, best.selector, default.selector)
    )


def is_far(v):
    """Tell whether a default is named: its F is more than FAR below, and the difference is no noise."""
    return v.best_f - v.f > FAR and v.difference.low > 0


def verdict_sentence(name, v):
    """Return the sentence on a default that is far from the best of its curve."""
    return Markup(
        "<b>%s</b>: the default has a mean F of %s, and <code>%s</code> has %s, %s more (%s to %s), on %s."
    ) % (
        name,
        fraction(v.f),
        v.best.selector,
        fraction(v.best_f),
        fraction(v.best_f - v.f),
        fraction(v.difference.low),
        fraction(v.difference.high),
        ", ".join(g.dataset for g in v.groups),
    )


def together_html(run, groups, curves):
    """Return the table of the defaults on all datasets together, and the sentences on those that are far."""
    verdicts = {name: verdict(run, groups, variants) for name, variants in curves.items()}
    verdicts = {name: v for name, v in verdicts.items() if v}
    if not verdicts:
        return paragraph("No curve is complete on any dataset yet.")
    far = [name for name, v in verdicts.items() if is_far(v)]
    rows = []
    for name, v in verdicts.items():
        cells = [
            name,
            text_cell(parameter_text(name)),
            value_text(v.default),
            fraction(v.f),
            value_text(v.best),
            fraction(v.best_f),
            fraction(v.best_f - v.f),
            span(v.difference.low, v.difference.high),
            bold("yes") if is_far(v) else "no",
            text_cell(", ".join(g.dataset for g in v.groups)),
        ]
        rows.append((name, ("", cells)))
    head = ["Selector", "Main parameter", "Default", "F", "Best value", "F", "Difference", "95 % interval"]
    caption = (
        "The default and the best value of each main parameter on all datasets together: F is the mean over the datasets"
        " of their mean F. The interval is that of the paired difference, with every dataset counting the same. A"
        " default is far if it is more than %g points below the best and the interval does not contain 0. The best of"
        " several values is a little too good, because it was chosen on the same pairs." % (100 * FAR)
    )
    out = [table(caption, head + ["Far", "Datasets"], with_headings(rows), "results")]
    if far:
        out.append(paragraph("Defaults that are far from the best of their curve:"))
        out.append(findings([verdict_sentence(name, verdicts[name]) for name in far]))
    else:
        out.append(paragraph("No default is far from the best of its curve."))
    return joined(out)


# ------------------------------------------------------------------------------------------------ one dataset


def curve_table(run, group, curves):
    """Return the table of a group: area, default and best of each curve."""
    measured = {name: curve(run, group, variants) for name, variants in curves.items()}
    measured = {name: points for name, points in measured.items() if points}
    areas = {name: area(points) for name, points in measured.items()}
    largest = max((a for a in areas.values() if a is not None), default=None)
    rows = []
    for name, points in measured.items():
        best, default = best_of(points), default_of(points)
        text = DASH if areas[name] is None else fraction(areas[name])
        cells = [
            name,
            text_cell(parameter_text(name)),
            best_cell(text, of="column") if areas[name] is not None and areas[name] == largest else text,
        ]
        if default:
            cells += [value_text(default), fraction(default.precision), fraction(default.recall)]
            cells += [fraction(default.f)]
        else:
            cells += [DASH] * 4
        cells += [value_text(best), fraction(best.f)]
        if default and best is not default:
            d = mean_interval(run.differences(group, best.selector, default.selector))
            cells.append("%s (%s)" % (fraction(d.mean), span(d.low, d.high)))
        else:
            cells.append(DASH)
        rows.append((name, ("", cells)))
    head = ["Selector", "Main parameter", "Area", "Default", "Precision", "Recall", "F", "Best value"]
    caption = (
        "Operating curves of %s, %s. Area: that under precision over recall, where the precision at a recall is the"
        " highest one of all points with at least this recall. Best F: the highest mean F on the curve, and how much"
        " that is above the default, with the 95 %% interval of the paired difference."
        % (group_text(group), at_tau(run.tau(group)))
    )
    return table(caption, head + ["Best F", "Difference"], with_headings(rows), "results")


def shown_points(points):
    """Return the points of a curve that can be drawn: those with a precision."""
    return [p for p in points if p.precision is not None]


def curve_panel(run, figures, group, curves, part):
    """Draw the curves of a part of the selectors in a group; the large marker is the default."""
    figure, axes = new_axes(4.6, 4.1, 0.55, 0.15, 0.5, 0.34)

    def line_of(name, named):
        points = shown_points(curve(run, group, curves.get(name, [name])))
        line = [p for p in points if p.value is not None or len(points) == 1]
        default = default_of(points)
        if default and named:
            options = line_style(run.styles[name])
            options.update(markersize=10, linestyle="none", markeredgecolor="#222222", zorder=3)
            axes.plot([default.recall], [default.precision], **options)
        return ([p.recall for p in line], [p.precision for p in line]) if points else None

    draw_part(axes, run, part, line_of)
    axes.set_xlim(-0.02, 1.02)
    axes.set_ylim(-0.02, 1.02)
    axes.grid(True)
    axes.set_xlabel("mean recall")
    axes.set_title("%s: mean precision" % plot_text(group.dataset), loc="left")
    label = "Precision against recall over each selector's main parameter for %s" % group_text(group)
    return figures(figure, label, figure_name(run, "curves", group) + part_ending(part))


def group_html(run, figures, group, curves):
    """Return figure and table of one group."""
    names = [n for n in curves if shown_points(curve(run, group, curves[n]))]
    names += [s for s in run.selectors_of(group) if is_baseline(s) and run.mean(group, s, run.tau(group))]
    caption = (
        "Mean precision against mean recall at %s. One point for each value of a selector's main parameter, joined in the"
        " order of the values; the large marker is the default. The mean precision leaves out pairs of which nothing is"
        " selected." % at_tau(run.tau(group))
    )
    figure = line_figures(
        run, figures, names, lambda part: [curve_panel(run, figures, group, curves, part)], "panels", caption
    )
    return article(group_heading(group), figure, curve_table(run, group, curves))


def html(run, figures):
    """Return the body of the section."""
    curves = variants_of(run.selectors)
    groups = [g for g in run.groups if g in run.means]
    if not curves or not groups:
        return paragraph("No curve was measured: no selector of the run has variants with means.")
    out = [
        paragraph(
            "Each selector was run with several values of the parameter that trades its precision against its recall: %s."
            % plural(len(curves), "curve")
        ),
        sources(run, "summary.csv", "pairs.csv"),
    ]
    for setting, together in groups_together(run).items():
        datasets = ", ".join(group.dataset for group in together)
        out.append(heading("All datasets: %s, %s" % (datasets, features_text(setting.features))))
        out.append(together_html(run, together, curves))
    out += [group_html(run, figures, group, curves) for group in groups]
    return joined(out)
