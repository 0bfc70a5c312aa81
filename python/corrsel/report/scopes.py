"""Which results belong to which experiment of a preset."""
from .paper import FEATURES_DEFAULT
from .selectors import SHARED_NAMES, selector_key
from .words import GIVEN

MAX_PANELS = 4  # datasets of the page's first picture; the sections have them all
# They run several variants of each selector, which only their own sections show.
VARYING = tuple(SHARED_NAMES)


def main_features(run):
    """Return the features of the run's first cell; those of its first pairs where no cells are recorded."""
    for cell in run.list_setting("cells"):
        return cell.split("/")[0]
    return next((group.features for group in run.groups if group.features != GIVEN), GIVEN)


def unselected_group(run, dataset=None):
    """Return the first group (of a dataset) without preselection, with the paper's features if it has them, or None."""
    groups = [g for g in run.pairs.groups if g.preselection == "none" and dataset in (None, g.dataset)]
    default = [g for g in groups if g.features == FEATURES_DEFAULT]
    return (default or groups or [None])[0]


def is_main(run, group):
    """Tell whether a group has the main features (or given matches), and no preselection."""
    return group.preselection in ("", "none") and group.features in (GIVEN, main_features(run))


def groups_of(run, experiment):
    """Return the groups with means that an experiment shows, in the run's order."""
    groups = [group for group in run.groups if group in run.means]
    if experiment in ("overall", "per_pair"):
        return [group for group in groups if is_main(run, group)]
    if experiment == "preselected":
        return [group for group in groups if group.preselection not in ("", "none")]
    if experiment == "features":
        return [g for g in groups if g.preselection in ("", "none") and not is_main(run, g)]
    return []


def opening_groups(run):
    """Return the groups of the page's first picture: one of each dataset, of the main features if it can be.

    At most MAX_PANELS; datasets of a single pair come last.
    """
    chosen = {}
    for group in sorted((g for g in run.groups if run.ranking(g)), key=lambda g: not is_main(run, g)):
        chosen.setdefault(group.dataset, group)
    order = list(run.datasets)
    found = [chosen[dataset] for dataset in order if dataset in chosen]
    return sorted(found, key=lambda group: run.pair_count(group) < 2)[:MAX_PANELS]


def figure_name(run, prefix, group, *rest):
    """Return the name of a group's figure; main features and absent preselections go without saying."""
    features = "" if group.features in (GIVEN, main_features(run)) else group.features
    preselection = "" if group.preselection == "none" or prefix == "preselected" else group.preselection
    return "_".join(part for part in (prefix, group.dataset, features, preselection) + rest if part)


def makes_variants(run):
    """Tell whether the run's preset runs several variants of each selector."""
    return any(name in run.sections for name in VARYING)


def switches_of(run):
    """Return the name of each switch of the page -> the selectors that it shows: one, or the variants of one line."""
    shared = [name_of for experiment, name_of in SHARED_NAMES.items() if experiment in run.sections]
    switches = {}
    for selector in sorted(run.styles, key=selector_key):
        name = selector
        for name_of in shared:
            name = name_of(name)
        switches.setdefault(name, []).append(selector)
    return switches


def other_groups(run):
    """Return the groups with means that no experiment of the run's preset shows."""
    if makes_variants(run):
        return []
    shown = dict.fromkeys(
        group
        for name in ("overall", "preselected", "features")
        if name in run.sections
        for group in groups_of(run, name)
    )
    return [group for group in run.groups if group in run.means and group not in shown]
