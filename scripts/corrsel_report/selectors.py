"""The names of selectors: their order in the report, and one style for each in every figure."""
from collections import Counter

BASELINE = "keep_all"
SELECTOR_ORDER = ("nnsr", "ransac", "st", "gtm", "usac", "vfc", "gms", "lpm")
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


def selector_key(selector):
    """Sort key: the order of the paper, presets after their default, others by name, the baseline last."""
    base, _, preset = selector.partition(":")
    known = SELECTOR_ORDER.index(base) if base in SELECTOR_ORDER else len(SELECTOR_ORDER)
    return (is_baseline(selector), known, base, preset)


def selector_styles(selectors):
    """Return selector -> style; presets are hollow, in the colour of their default."""
    styles, others, presets = {}, {}, Counter()
    for name in selectors:
        base, _, preset = name.partition(":")
        if is_baseline(name):
            styles[name] = {"colour": GREY, "marker": "x", "line": (0, (1, 1.5)), "hollow": False}
            continue
        if base not in SELECTOR_STYLES and base not in others:
            i = len(others)
            lines = PRESET_LINES[i % len(PRESET_LINES)]
            others[base] = (
                OTHER_COLOURS[i % len(OTHER_COLOURS)],
                OTHER_MARKERS[i % len(OTHER_MARKERS)],
                lines,
            )
        colour, marker, line = SELECTOR_STYLES.get(base) or others[base]
        if preset:
            line = PRESET_LINES[presets[base] % len(PRESET_LINES)]
            marker = marker if presets[base] == 0 else OTHER_MARKERS[presets[base] % len(OTHER_MARKERS)]
            presets[base] += 1
        styles[name] = {"colour": colour, "marker": marker, "line": line, "hollow": bool(preset)}
    return styles
