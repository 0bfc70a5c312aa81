"""The names of selectors: their groups and order in the report, and one style for each in every figure."""
from collections import Counter, OrderedDict, namedtuple

from .groups import GROUPS

BASELINE = "keep_all"
OTHER_PACKAGES = "other packages"  # the group of selectors that this package does not know
FEW = 14  # as many selectors need no headings of groups and fit into one figure of lines
PART = 8  # selectors whose lines one of several figures shows
# Okabe-Ito colours; one colour, marker and line per selector in every figure of every run.
SELECTOR_STYLES = {
    "nnsr": ("#0072B2", "o", "-"),
    "ransac": ("#D55E00", "s", "-"),
    "st": ("#CC79A7", "^", (0, (6, 1.5))),
    "gtm": ("#E69F00", "D", (0, (4, 1.5, 1, 1.5))),
    "usac": ("#56B4E9", "v", (0, (6, 1.5))),
    "vfc": ("#F0E442", "P", "-"),
    "gms": ("#009E73", "X", (0, (4, 1.5, 1, 1.5))),
    "lpm": ("#000000", "p", "-"),
}
OTHER_COLOURS = ("#CC79A7", "#56B4E9", "#E69F00", "#009E73", "#0072B2", "#D55E00")
OTHER_MARKERS = ("h", "<", ">", "d", "H", "8")
PRESET_LINES = ((0, (3, 1.5)), (0, (1, 1.5)), (0, (5, 1, 1, 1, 1, 1)))
GREY, DARK, YELLOW = "#767676", "#555555", "#F0E442"


def is_baseline(selector):
    """Tell whether a selector is the keep-everything baseline."""
    return selector.split(":")[0] == BASELINE


def group_of_selector(selector):
    """Return the name of a selector's group, "other packages" where this package does not know it."""
    base = selector.partition(":")[0]
    return next((group for group, names in GROUPS.items() if base in names), OTHER_PACKAGES)


def selector_key(selector):
    """Sort key: the groups in the order of listings, presets after their default, the baseline last."""
    base, _, preset = selector.partition(":")
    group = group_of_selector(selector)
    if group == OTHER_PACKAGES:
        return (False, len(GROUPS), 0, base, preset)
    return (is_baseline(selector), list(GROUPS).index(group), GROUPS[group].index(base), base, preset)


def are_many(selectors):
    """Tell whether so many selectors are shown that they are grouped."""
    return len(selectors) > FEW


# Selectors whose lines one figure shows, the baseline among them; the others give it a grey background.
Part = namedtuple("Part", "title names others")


def parts(selectors):
    """Return the selectors, in the report's order, as Parts: one without a title, or several if they are many.

    Neighbouring groups share a part as long as it has at most PART selectors; presets count.
    """
    if not are_many(selectors):
        return [Part("", list(selectors), [])]
    groups = OrderedDict()
    for selector in selectors:
        if not is_baseline(selector):
            groups.setdefault(group_of_selector(selector), []).append(selector)
    joined = []
    for group, names in groups.items():
        if joined and len(joined[-1][1]) + len(names) <= PART:
            joined[-1] = (joined[-1][0] + ", " + group, joined[-1][1] + names)
        else:
            joined.append((group, names))
    base = [s for s in selectors if is_baseline(s)]
    competing = [s for s in selectors if s not in base]
    return [Part(title, names + base, [s for s in competing if s not in names]) for title, names in joined]


def selector_styles(selectors):
    """Return selector -> style; presets are hollow, in the colour of their default.

    Each figure of lines tells its selectors apart; selectors in different figures may share a style.
    """
    styles = {}
    many = are_many(selectors)
    for part in parts(sorted(selectors, key=selector_key)):
        styles.update(styles_of_part(part.names, many))
    return styles


def styles_of_part(selectors, many):
    """Return selector -> style within one figure; with many selectors, the paper's styles are used again."""
    styles, others, presets = {}, {}, Counter()
    for name in selectors:
        base, _, preset = name.partition(":")
        if is_baseline(name):
            styles[name] = {"colour": GREY, "marker": "x", "line": (0, (1, 1.5)), "hollow": False}
            continue
        if base not in SELECTOR_STYLES and base not in others:
            i = len(others)
            if many:
                others[base] = list(SELECTOR_STYLES.values())[i % len(SELECTOR_STYLES)]
            else:
                others[base] = (
                    OTHER_COLOURS[i % len(OTHER_COLOURS)],
                    OTHER_MARKERS[i % len(OTHER_MARKERS)],
                    PRESET_LINES[i % len(PRESET_LINES)],
                )
        colour, marker, line = SELECTOR_STYLES.get(base) or others[base]
        if preset:
            line = PRESET_LINES[presets[base] % len(PRESET_LINES)]
            marker = marker if presets[base] == 0 else OTHER_MARKERS[presets[base] % len(OTHER_MARKERS)]
            presets[base] += 1
        styles[name] = {"colour": colour, "marker": marker, "line": line, "hollow": bool(preset)}
    return styles
