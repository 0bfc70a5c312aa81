"""The names of selectors: their groups and order in the report, and one style for each in every figure."""
import functools
from collections import Counter, namedtuple

from .groups import GROUPS, MAIN_PARAMETERS

BASELINE = "keep_all"
TIME_LIMIT = "max_seconds"  # the option that the experiment budget varies, s
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


# A selector's name taken apart: usac:h[max_seconds=0.01] is "usac", "h" and {"max_seconds": "0.01"}.
Parts = namedtuple("Parts", "base preset options")


@functools.lru_cache(maxsize=None)
def take_apart(selector):
    """Return the Parts of a selector's name; preset and options may be empty."""
    beginning, _, inside = selector.partition("[")
    base, _, preset = beginning.partition(":")
    pairs = (piece.partition("=") for piece in inside.rstrip("]").split(";") if piece)
    return Parts(base, preset, {name.strip(): value.strip() for name, _, value in pairs})


def without_options(selector, names):
    """Return a selector's name without some of the options in its brackets."""
    base, preset, options = take_apart(selector)
    rest = ";".join("%s=%s" % item for item in options.items() if item[0] not in names)
    return base + (":" + preset if preset else "") + ("[%s]" % rest if rest else "")


def budget_name(selector):
    """Return the name that the variants of a selector with different time limits share."""
    return without_options(selector, (TIME_LIMIT,))


def curve_name(selector):
    """Return the name that the variants of a selector on its operating curve share.

    A variant that sets only some of the options that the curve varies together lies on no curve.
    """
    base, _, options = take_apart(selector)
    varied = MAIN_PARAMETERS.get(base, ())
    return without_options(selector, varied) if all(name in options for name in varied) else selector


# The experiments that join variants of a selector to one line -> the name of the line that a variant belongs to.
SHARED_NAMES = {"budget": budget_name, "curves": curve_name}


def is_baseline(selector):
    """Tell whether a selector is the keep-everything baseline."""
    return take_apart(selector).base == BASELINE


def group_of_selector(selector):
    """Return the name of a selector's group, "other packages" where this package does not know it."""
    base = take_apart(selector).base
    return next((group for group, names in GROUPS.items() if base in names), OTHER_PACKAGES)


def selector_key(selector):
    """Sort key: the groups in the order of listings, the baseline last.

    Presets come after their default, and options in brackets after the name without, by rising values.
    """
    base, preset, options = take_apart(selector)
    values = tuple((name, sortable(value)) for name, value in options.items())
    group = group_of_selector(selector)
    if group == OTHER_PACKAGES:
        return (False, len(GROUPS), 0, base, preset, values)
    return (is_baseline(selector), list(GROUPS).index(group), GROUPS[group].index(base), base, preset, values)


def sortable(value):
    """Return the value of an option as a sort key: numbers by their size, other texts after them."""
    try:
        return (float(value), "")
    except ValueError:
        return (float("inf"), value)


def are_many(selectors):
    """Tell whether so many selectors are shown that they are grouped."""
    return len(selectors) > FEW


# Selectors whose lines one figure shows, the baseline among them; the others give it a grey background.
Part = namedtuple("Part", "title names others")


def parts(selectors):
    """Return the selectors, in the report's order, as Parts: one without a title, or several if they are many.

    Neighbouring groups share a part as long as it has at most PART selectors; presets count. Larger groups are divided.
    """
    if not are_many(selectors):
        return [Part("", list(selectors), [])]
    groups = {}
    for selector in selectors:
        if not is_baseline(selector):
            groups.setdefault(group_of_selector(selector), []).append(selector)
    joined = []
    for group, names in (piece for item in groups.items() for piece in divided(*item)):
        if joined and len(joined[-1][1]) + len(names) <= PART:
            joined[-1] = (joined[-1][0] + ", " + group, joined[-1][1] + names)
        else:
            joined.append((group, names))
    base = [s for s in selectors if is_baseline(s)]
    competing = [s for s in selectors if s not in base]
    return [Part(title, names + base, [s for s in competing if s not in names]) for title, names in joined]


def divided(group, names):
    """Return the group as (title, names) pairs of at most PART selectors each."""
    count = -(-len(names) // PART)
    if count == 1:
        return [(group, names)]
    size = -(-len(names) // count)
    return [("%s (%d of %d)" % (group, i + 1, count), names[i * size : (i + 1) * size]) for i in range(count)]


def selector_styles(selectors):
    """Return selector -> style; presets and variants are hollow, in the colour of their default.

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
        base = take_apart(name).base
        varied = name != base  # by a preset or by options in brackets
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
        if varied:
            line = PRESET_LINES[presets[base] % len(PRESET_LINES)]
            marker = marker if presets[base] == 0 else OTHER_MARKERS[presets[base] % len(OTHER_MARKERS)]
            presets[base] += 1
        styles[name] = {"colour": colour, "marker": marker, "line": line, "hollow": varied}
    return styles
