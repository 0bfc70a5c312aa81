"""What the page opens with: mean F against time, a pair before and after selection, and the sentence on who won."""
from collections import Counter

from markupsafe import Markup

from . import pose
from .markup import bold, dataset_html, joined, paragraph, render
from .overview import groups_with_means, result_text
from .reading import group_of
from .scopes import opening_groups
from .selectors import BASELINE, is_baseline
from .timing import time_panel, time_text
from .visual import drawn_images, image_caption, image_data, image_path, pair_of, place_text
from .words import PHOTOGRAPHED, at_tau, features_text, is_unrelated, plural, preselection_text

F_TEXT = (
    "F is the harmonic mean of precision (the share of the selected matches that are inliers) and recall (the share of the"
    " inliers that are selected), from 0 to 1. A match is an inlier if its error is at most \u03c4, or if it is labelled as"
    " one. %s selects all matches."
) % BASELINE


def example(run, groups):
    """Return the Drawn images (before, after) of one pair; None for the one, or for both, that cannot be shown.

    After is the selection of the group's winner, on the pair whose F is closest to its mean; photographs come first.
    """
    shown = [d for d in drawn_images(run) if image_path(run, d.row["file"])]
    before = {pair_of(d.row): d for d in shown if is_baseline(d.row["selector"])}
    for group in groups:
        winner = run.ranking(group)[0]
        own = [d for d in shown if group_of(d.row) == group and d.row["selector"] == winner["selector"]]
        own = [d for d in own if d.f is not None]
        if own:
            after = min(own, key=lambda d: (is_generated(d.row), abs(d.f - winner["f_paper"]), d.index))
            return before.get(pair_of(after.row)), after
    competing = [d for d in shown if not is_baseline(d.row["selector"])]
    return (before.get(pair_of(competing[-1].row)), competing[-1]) if competing else (None, None)


def is_generated(row):
    """Tell whether a drawn pair of the sample set was computed from one photograph."""
    return row["dataset"] == "sample" and row["sequence"] not in PHOTOGRAPHED


def example_html(run, groups):
    """Return the example pair before and after selection; "" where the run drew none."""
    before, after = example(run, groups)
    if after is None:
        return ""
    named = [("Before selection", before), ("After selection by %s" % after.row["selector"], after)]
    images = [
        {
            "title": title,
            "data": image_data(image_path(run, drawn.row["file"])),
            "caption": image_caption(drawn.row, drawn.f),
        }
        for title, drawn in named
        if drawn
    ]
    return render("example.html", images=images, pair=place_text(after.row))


def wins_sentence(run):
    """Return in how many settings each winner wins, where there are several settings."""
    groups = [group for group in groups_with_means(run) if run.ranking(group)]
    if len(groups) < 2:
        return ""
    winners = Counter(run.ranking(group)[0]["selector"] for group in groups)
    (first, wins), *others = winners.most_common()
    text = Markup(
        "Of all %d settings (dataset, features and preselection), <b>%s</b> has the highest mean F in %d"
    )
    text %= (len(groups), first, wins)
    return text + joined((Markup(", <b>%s</b> in %d") % other for other in others), "") + "."


def where_text(run, group):
    """Return in which setting a selector won, as a part of a sentence."""
    setting = ", ".join(
        [features_text(group.features), preselection_text(group.preselection), at_tau(run.tau(group))]
    )
    return Markup(' on %s <span class="small">(%s)</span>') % (dataset_html(group.dataset), setting)


def poses_sentences(run, groups):
    """Return who gives the best poses and homographies in the groups, where the run is about them."""
    if "pose" not in run.sections:
        return []
    measured = [(measure, pose.groups_of(run, measure)) for measure in (pose.POSE, pose.CORNERS)]
    found = [
        (group.dataset, pose.statement(rows[group], measure))
        for group in groups
        for measure, rows in measured
        if group in rows
    ]
    return [Markup("On <b>%s</b>, %s") % each for each in found if each[1]]


def without_results(run):
    """Return why there is no winner, as a sentence."""
    if not run.datasets:
        return ""
    if all(map(is_unrelated, run.datasets)):
        return "All pairs show different scenes, so there are no inliers and no F; see the section on them."
    if not run.summary:
        return ""
    return "No pair has a ground truth with inliers, so precision, recall and F are unknown and there is no winner."


def html(run, figures):
    """Return the picture, and below it the sentences that name the winners."""
    groups = opening_groups(run)
    plots = [plot for plot in (time_panel(run, figures, group, "opening") for group in groups) if plot]
    pair = example_html(run, groups)
    out = (
        [render("opening.html", plots=plots, text=time_text(run, groups), pair=pair)] if plots or pair else []
    )
    for text in [result_text(run, group, where_text(run, group)) for group in groups] + poses_sentences(
        run, groups
    ):
        out.append(paragraph(text, "answer"))
    if groups:
        out += [
            paragraph(text) for text in (wins_sentence(run), left_to_sections(run, groups), F_TEXT) if text
        ]
    else:
        out.append(paragraph(without_results(run), "answer"))
    return joined(out)


def left_to_sections(run, groups):
    """Return which datasets are not in the picture, as a sentence; "" where all are."""
    shown = {group.dataset for group in groups}
    missing = list(
        dict.fromkeys(g.dataset for g in groups_with_means(run) if g.dataset not in shown and run.ranking(g))
    )
    if not missing:
        return ""
    text = "The picture shows the first %s; %s: see below."
    return Markup(text) % (plural(len(shown), "dataset"), joined(map(bold, missing), ", "))
