#!/usr/bin/env python3
"""Turn the folder of a benchmark run into one self-contained HTML file.

Usage: report.py RUN_FOLDER [--output FILE]

Reads pairs.csv (needed) and, where present, summary.csv, summary.json, environment.json, config.yaml,
failures.csv and images/index.csv. Tables and curves show the numbers of summary.csv; pairs.csv gives the
per-pair distributions, the counts and the failures. The same folder always gives the same bytes.
Exit status: 0 written, 2 unusable input.
"""
import argparse
import base64
import csv
import html
import io
import json
import math
import os
import re
import sys
import tempfile
import warnings
from collections import Counter, OrderedDict, namedtuple
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np  # noqa: E402  (the backend is chosen first)
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator  # noqa: E402

PAIRS_HEADER = (
    "dataset,sequence,pair,features,preselection,selector,tau_px,n_left,n_right,n_putative,n_ground_truth,"
    "n_selected,n_correct,precision,recall_paper,recall_same_tau,f_paper,f_same_tau,status,seed,"
    "detect_s,describe_s,match_s,select_s"
).split(",")
SUMMARY_HEADER = (
    "dataset,features,preselection,selector,tau_px,pairs,precision,recall_paper,f_paper,f_paper_lo,"
    "f_paper_hi,recall_same_tau,f_same_tau,select_s_median,select_s_p95"
).split(",")
FAILURES_HEADER = "dataset,sequence,pair,features,stage,error".split(",")
IMAGES_HEADER = (
    "file,dataset,sequence,pair,features,preselection,selector,n_selected,n_correct,n_wrong,n_missed,tau_px"
).split(",")
TEXT_COLUMNS = {"dataset", "sequence", "pair", "features", "preselection", "selector", "status", "seed"}
TEXT_COLUMNS |= {"stage", "error", "file"}

STATUSES = OrderedDict(
    [
        ("ok", "a selection was made"),
        ("too_few", "fewer matches than the method needs; nothing selected"),
        ("degenerate", "the matches (all equal, or on one line) cannot decide the model"),
        ("no_model", "the search ended without a model"),
        ("unsupported_input", "the input lacks something the method needs, such as descriptor distances"),
        ("too_large", "more matches than the memory or time options allow"),
        ("time_limit", "stopped at its time budget; the best answer until then counts"),
        ("failed", "the method reported an internal error"),
    ]
)
BASELINE = "keep_all"
PHOTOGRAPHED = ("graf", "aloe")  # sequences of the dataset "sample" whose second image is a photograph too
SELECTOR_ORDER = ("nnsr", "ransac", "st", "gtm", "usac", "vfc", "gms", "lpm")
REFERENCE_TAU = 5.0
GROUND_TRUTH_PX = 10
MAX_ROWS = 200  # longest table of failures or left-out pairs; the rest stays in the CSV file
LARGE_BYTES = 8e6  # above this a remark goes to stderr

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

Group = namedtuple("Group", "dataset features preselection")


class ReportError(Exception):
    """Input that no report can be made of; the message says which, why and what to do."""


# ---------------------------------------------------------------------------------------------------- reading


def to_number(text):
    """Return the finite number in a cell, None for an empty or undefined one; else ValueError."""
    if not text.strip():
        return None
    value = float(text)
    return value if math.isfinite(value) else None


def describe_header_difference(found, expected):
    """Say in one sentence where a header departs from the expected one."""
    for i, name in enumerate(expected):
        if i >= len(found):
            return "it ends before column %d ('%s')" % (i + 1, name)
        if found[i] != name:
            return "column %d is '%s' instead of '%s'" % (i + 1, found[i], name)
    return "it has %d columns too many, the first is '%s'" % (
        len(found) - len(expected),
        found[len(expected)],
    )


def read_text(path):
    """Return a file's text with undecodable and control characters replaced, line ends kept."""
    text = path.read_bytes().decode("utf-8-sig", errors="replace")
    return re.sub("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]", "\ufffd", text)


def short_name(path):
    """Return a file's name as seen from the run folder."""
    return "images/" + path.name if path.parent.name == "images" else path.name


def read_table(path, header, notes):
    """Read a CSV file into dictionaries.

    A last line without line end and unreadable lines are left out and noted.
    Raises ReportError when the header is not the expected one.
    """
    text = read_text(path)
    if not text.strip():
        notes.append("%s is an empty file." % short_name(path))
        return []
    found = next(csv.reader(io.StringIO(text)))
    if found != header:
        raise ReportError(
            "%s: wrong header: %s. Found '%s', expected '%s'. Remedy: write the folder anew with the"
            " benchmark of this package version."
            % (path, describe_header_difference(found, header), ",".join(found), ",".join(header))
        )
    if not text.endswith("\n") and "\n" in text:
        text = text[: text.rindex("\n") + 1]
        notes.append(
            "%s: the last line is cut off and was left out (the run was interrupted)." % short_name(path)
        )
    rows, bad = [], []
    reader = csv.reader(io.StringIO(text, newline=""))
    next(reader)
    for cells in reader:
        if not cells:
            continue
        try:
            if len(cells) != len(header):
                raise ValueError("number of cells")
            rows.append({k: c if k in TEXT_COLUMNS else to_number(c) for k, c in zip(header, cells)})
        except ValueError:
            bad.append(reader.line_num)
    if bad:
        shown = ", ".join(str(n) for n in bad[:10]) + (", ..." if len(bad) > 10 else "")
        notes.append(
            "%s: %s could not be read and left out: line %s."
            % (short_name(path), plural(len(bad), "line"), shown)
        )
    return rows


def read_optional_table(path, header, notes, consequence):
    """As read_table, but an absent or unusable file is noted, with its consequence, and gives no rows."""
    if not path.is_file():
        notes.append("%s is missing: %s." % (short_name(path), consequence))
        return []
    try:
        return read_table(path, header, notes)
    except (ReportError, OSError, csv.Error) as error:
        notes.append("%s was not used (%s): %s." % (short_name(path), str(error).rstrip("."), consequence))
        return []


def read_optional_json(path, notes, consequence):
    """Return the dictionary in a JSON file; an absent or unusable file is noted and gives an empty one."""
    if not path.is_file():
        notes.append("%s is missing: %s." % (path.name, consequence))
        return {}
    try:
        content = json.loads(read_text(path))
    except ValueError as error:
        notes.append("%s is not valid JSON (%s): %s." % (path.name, error, consequence))
        return {}
    if not isinstance(content, dict):
        notes.append("%s does not hold a JSON object: %s." % (path.name, consequence))
        return {}
    return content


def read_run(folder):
    """Read everything a run left behind into a Run; raises ReportError without a usable pairs.csv."""
    if not folder.is_dir():
        raise ReportError("%s: no such folder. Remedy: give the output folder of a benchmark run." % folder)
    pairs_file = folder / "pairs.csv"
    if not pairs_file.is_file():
        raise ReportError(
            "%s: no such file. Remedy: give the output folder of a benchmark run; it holds pairs.csv as soon"
            " as the run has started." % pairs_file
        )
    notes = []
    try:
        pairs = read_table(pairs_file, PAIRS_HEADER, notes)
    except (OSError, csv.Error) as error:
        raise ReportError(
            "%s: cannot be read (%s). Remedy: check the file and its permissions." % (pairs_file, error)
        )
    run = Run(folder, pairs, notes)
    run.summary = read_optional_table(
        folder / "summary.csv",
        SUMMARY_HEADER,
        notes,
        "the tables and curves of means are left out; resume the run to its end to get them",
    )
    content = read_optional_json(folder / "summary.json", notes, "whether the run is complete is not known")
    run.state = content.get("state") if isinstance(content.get("state"), dict) else {}
    run.environment = read_optional_json(folder / "environment.json", notes, "the machine is not described")
    run.failures = read_optional_table(
        folder / "failures.csv", FAILURES_HEADER, notes, "pairs that failed before selection are not listed"
    )
    run.images = read_optional_table(
        folder / "images" / "index.csv", IMAGES_HEADER, notes, "no example pairs are shown"
    )
    config = folder / "config.yaml"
    run.config = read_text(config) if config.is_file() else None
    if run.config is None:
        notes.append("config.yaml is missing: the configuration is not shown.")
    run.index()
    return run


class Run:
    """What a run left behind, and the questions the report asks of it."""

    def __init__(self, folder, pairs, notes):
        """Hold the rows of pairs.csv; the optional files are filled in by read_run."""
        self.folder = folder
        self.name = folder.resolve().name
        self.pairs = pairs
        self.notes = notes
        self.summary, self.failures, self.images = [], [], []
        self.state, self.environment, self.config = {}, {}, None

    def index(self):
        """Build the look-ups; call once all files are read."""
        self.means = OrderedDict()  # group -> selector -> tau -> row of summary.csv
        for row in self.summary:
            selectors = self.means.setdefault(group_of(row), {})
            selectors.setdefault(row["selector"], {})[row["tau_px"]] = row
        self.rows = OrderedDict()  # group -> selector -> rows of pairs.csv
        self.tasks = OrderedDict()  # one status per pair x features x preselection x selector x seed
        self.left_out = OrderedDict()  # pairs without ground-truth inlier
        for row in self.pairs:
            group = group_of(row)
            self.rows.setdefault(group, OrderedDict()).setdefault(row["selector"], []).append(row)
            task = (group, row["sequence"], row["pair"], row["selector"], row["seed"])
            if self.tasks.get(task, "ok") == "ok":
                self.tasks[task] = row["status"] or "ok"
            if row["n_ground_truth"] == 0 and row["status"] != "unsupported_input":
                self.left_out[(group, row["sequence"], row["pair"])] = row["n_putative"]
        self.groups = list(OrderedDict.fromkeys(list(self.rows) + list(self.means)))
        names = {row["selector"] for row in self.pairs} | {row["selector"] for row in self.summary}
        self.selectors = sorted(names, key=selector_key)
        self.statuses = {}  # (group, selector) -> Counter of statuses
        for (group, _, _, selector, _), status in self.tasks.items():
            self.statuses.setdefault((group, selector), Counter())[status] += 1
        self.styles = selector_styles(self.selectors)

    def selectors_of(self, group):
        """Return the selectors of a group in the report's order, the baseline last."""
        names = set(self.rows.get(group, {})) | set(self.means.get(group, {}))
        return sorted(names, key=selector_key)

    def taus(self, group):
        """Return the tolerances of a group, ascending; [None] for labelled ground truth."""
        taus = {tau for rows in self.means.get(group, {}).values() for tau in rows}
        taus |= {row["tau_px"] for rows in self.rows.get(group, {}).values() for row in rows}
        return sorted(taus - {None}) or [None]

    def tau(self, group):
        """Return the tolerance at which a group is tabulated: 5 px, or the nearest one there is."""
        taus = self.taus(group)
        return None if taus == [None] else min(taus, key=lambda t: (abs(t - REFERENCE_TAU), t))

    def unsupported(self, group, selector):
        """Tell whether a selector could run on no pair of a group for lack of input."""
        return set(self.statuses.get((group, selector), ())) == {"unsupported_input"}

    def mean(self, group, selector, tau):
        """Return the row of summary.csv; None if missing, undefined or the selector unsupported."""
        row = self.means.get(group, {}).get(selector, {}).get(tau)
        if row is None or row["f_paper"] is None or self.unsupported(group, selector):
            return None
        return row

    def ranking(self, group):
        """Return the competing rows of summary.csv at the tabulated tolerance, by falling F."""
        tau = self.tau(group)
        rows = [self.mean(group, s, tau) for s in self.selectors_of(group) if not is_baseline(s)]
        return sorted((r for r in rows if r), key=lambda r: (-r["f_paper"], selector_key(r["selector"])))

    def pair_values(self, group, selector, column="f_paper"):
        """Return usable pair -> value at the tabulated tolerance, repetitions averaged."""
        tau, values = self.tau(group), OrderedDict()
        for row in self.rows.get(group, {}).get(selector, ()):
            usable = row["status"] != "unsupported_input" and row["n_ground_truth"] != 0
            if usable and row["tau_px"] == tau and row[column] is not None:
                values.setdefault((row["sequence"], row["pair"]), []).append(row[column])
        return OrderedDict((pair, float(np.mean(v))) for pair, v in values.items())

    def head_to_head(self, group, first, second):
        """Return the number of pairs on which the first has the higher F, of ties, and of all."""
        a, b = self.pair_values(group, first), self.pair_values(group, second)
        common = [(a[pair], b[pair]) for pair in a if pair in b]
        return sum(x > y for x, y in common), sum(x == y for x, y in common), len(common)


def group_of(row):
    """Return the dataset x features x preselection a row belongs to."""
    return Group(row["dataset"], row["features"], row["preselection"])


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


# ------------------------------------------------------------------------------------------------------- text


def esc(value):
    """Escape a value for HTML text and attributes."""
    return html.escape(str(value), quote=True)


def plural(count, noun, many=None):
    """Return '1 pair', '2 pairs'."""
    return "%d %s" % (count, noun if count == 1 else many or noun + "s")


def be(count):
    """Return the verb that goes with a count."""
    return "is" if count == 1 else "are"


def number(value, missing="\u2013"):
    """Return a count or a plain number as text."""
    return missing if value is None else "%g" % value if abs(value) < 1e6 else "%d" % value


def fraction(value, missing="\u2013"):
    """Return a fraction with three decimals."""
    return missing if value is None else "%.3f" % value


def milliseconds(seconds, missing="\u2013"):
    """Return a duration given in seconds as milliseconds with about three digits."""
    if seconds is None:
        return missing
    ms = 1e3 * seconds
    if 0 < ms < 0.001:
        return "<0.001"
    return "%.*f" % (0 if ms >= 1000 else 1 if ms >= 10 else 2 if ms >= 1 else 3, ms)


def interval(row):
    """Return the bootstrap interval of the mean F of a row of summary.csv as text."""
    if row["f_paper_lo"] is None or row["f_paper_hi"] is None:
        return "\u2013"
    return "%.3f\u2013%.3f" % (row["f_paper_lo"], row["f_paper_hi"])


def bracket(row):
    """Return the interval in brackets, as HTML that does not break across lines."""
    return '<span class="nb">(%s)</span>' % interval(row)


def overlap(first, second):
    """Tell whether two intervals overlap; None where one of them is undefined."""
    bounds = [row[k] for row in (first, second) for k in ("f_paper_lo", "f_paper_hi")]
    if None in bounds:
        return None
    return bounds[0] <= bounds[3] and bounds[2] <= bounds[1]


def at_tau(tau):
    """Return the tolerance as words."""
    return "labelled ground truth" if tau is None else "\u03c4 = %g px" % tau


def preselection_text(name):
    """Return the preselection as words."""
    return "no preselection" if name in ("", "none") else "after preselection by %s" % name


def group_text(group):
    """Return the name of a group as words."""
    return "%s, %s, %s" % (
        group.dataset,
        features_text(group.features),
        preselection_text(group.preselection),
    )


def features_text(name):
    """Return the features as words."""
    return "given matches" if name == "given" else name


def statuses_text(counts):
    """Return the statuses of a selector as words, most frequent first."""
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return ", ".join("%s (%d)" % (name.replace("_", " "), count) for name, count in ordered)


# ---------------------------------------------------------------------------------------------------- figures


def set_up_figures():
    """Make figures the same whatever the user's matplotlib settings are."""
    matplotlib.rcdefaults()
    matplotlib.rcParams.update(
        {
            "svg.fonttype": "none",
            "svg.hashsalt": "corrsel",
            "font.family": "sans-serif",
            "font.sans-serif": ["DejaVu Sans"],
            "font.size": 9,
            "axes.labelsize": 9,
            "axes.titlesize": 10,
            "axes.titleweight": "bold",
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": "#8a8a8a",
            "axes.linewidth": 0.8,
            "axes.axisbelow": True,
            "axes.unicode_minus": False,
            "xtick.color": "#444444",
            "ytick.color": "#444444",
            "xtick.labelsize": 8.5,
            "ytick.labelsize": 8.5,
            "grid.color": "#e2e2e2",
            "grid.linewidth": 0.7,
            "lines.linewidth": 1.5,
            "lines.markersize": 4.5,
            "hatch.linewidth": 0.6,
        }
    )
    warnings.filterwarnings("ignore", message=".*[Gg]lyph.*missing.*")


def plot_text(text, longest=22):
    """Return a name for a figure: not too long, and never taken for a formula."""
    text = text if len(text) <= longest else text[: longest - 1] + "\u2026"
    return text.replace("$", r"\$")


def new_axes(width, height, left, right, bottom, top):
    """Return a figure and its axes; sizes and margins in inches."""
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    box = [left / width, bottom / height, (width - left - right) / width, (height - bottom - top) / height]
    return figure, figure.add_axes(box)


class SvgWriter:
    """Turns figures into inline SVG, each with its own identifiers."""

    def __init__(self):
        """Start counting figures."""
        self.count = 0

    def __call__(self, figure, label, css="plot"):
        """Return a figure as an inline SVG element with an accessible label."""
        self.count += 1
        stream = io.StringIO()
        figure.savefig(stream, format="svg", transparent=True, metadata={"Date": None})
        text = stream.getvalue()
        text = text[text.index("<svg") :]
        text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
        text = re.sub(r"<(metadata|style)\b.*?</\1>", "", text, flags=re.S)
        text = self.shorten(text)
        view_box = re.search(r'viewBox="([^"]*)"', text).group(1)
        opening = '<svg class="%s" role="img" aria-label="%s" viewBox="%s">' % (css, esc(label), view_box)
        return opening + text[text.index(">") + 1 :].strip()

    def shorten(self, text):
        """Give the identifiers of one figure short names of its own and round its coordinates."""
        names = {}
        for name in re.findall(r'\bid="([^"]+)"', text):
            names.setdefault(name, "f%d-%d" % (self.count, len(names)))
        used = set(re.findall(r'href="#([^"]+)"', text)) | set(re.findall(r"url\(#([^)]+)\)", text))
        text = re.sub(r' id="([^"]+)"', lambda m: ' id="%s"' % names[m[1]] if m[1] in used else "", text)
        text = re.sub(r'href="#([^"]+)"', lambda m: 'href="#%s"' % names.get(m[1], m[1]), text)
        text = re.sub(r"url\(#([^)]+)\)", lambda m: "url(#%s)" % names.get(m[1], m[1]), text)
        text = re.sub(
            r"<[^>]*>", lambda tag: re.sub(r"(?<=\d)(\.\d\d)\d+", lambda m: m[1].rstrip("0."), tag[0]), text
        )
        return re.sub(r"\n\s*", "\n", text)


def line_style(style):
    """Return the matplotlib options of a selector's line and markers."""
    colour = style["colour"]
    return {
        "color": colour,
        "marker": style["marker"],
        "linestyle": style["line"],
        "markerfacecolor": "white" if style["hollow"] else colour,
        "markeredgecolor": DARK if colour == YELLOW else colour,
        "markeredgewidth": 1.0,
    }


def draw_line(axes, x, y, style, **options):
    """Draw a selector's line with markers; yellow, too pale on white, gets a dark rim."""
    if style["colour"] == YELLOW:
        axes.plot(x, y, color=DARK, linewidth=2.6, linestyle=style["line"])
    axes.plot(x, y, **line_style(style), **options)


def swatch(run, svg, selector):
    """Return a selector's line and marker as a small picture for a legend."""
    figure, axes = new_axes(0.5, 0.2, 0, 0, 0, 0)
    draw_line(axes, [0, 1, 2], [0, 0, 0], run.styles[selector], markevery=[1])
    axes.set_xlim(0, 2)
    axes.set_ylim(-1, 1)
    axes.axis("off")
    return svg(figure, "", "swatch").replace('role="img" aria-label=""', 'aria-hidden="true"')


def curve_panel(run, svg, group, title, column):
    """Draw the mean of one measure against tau, one line per selector."""
    figure, axes = new_axes(3.9, 3.1, 0.5, 0.12, 0.48, 0.34)
    taus = run.taus(group)
    for selector in reversed(run.selectors_of(group)):
        rows = [(tau, run.mean(group, selector, tau)) for tau in taus]
        points = [(tau, row[column]) for tau, row in rows if row and row[column] is not None]
        if points:
            draw_line(axes, [p[0] for p in points], [p[1] for p in points], run.styles[selector])
    axes.set_title(title, loc="left")
    axes.set_xlabel("tolerance \u03c4 (px)")
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlim(taus[0] - 0.3, taus[-1] + 0.3)
    axes.set_xticks(taus if len(taus) <= 12 else taus[:: len(taus) // 10])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: "%g" % x))
    axes.grid(True)
    return svg(figure, "%s against tolerance for %s, one line per selector" % (title, group_text(group)))


def bar_panel(run, svg, group, title, column):
    """Draw one measure of a labelled dataset as bars, one per selector, with the interval of mean F."""
    selectors = run.selectors_of(group)
    figure, axes = new_axes(3.9, 0.75 + 0.27 * len(selectors), 1.05, 0.5, 0.38, 0.34)
    axes.grid(True, axis="x")
    for y, selector in enumerate(selectors):
        row, style = run.mean(group, selector, run.tau(group)), run.styles[selector]
        if row is None or row[column] is None:
            reason = "unsupported" if run.unsupported(group, selector) else "no result"
            axes.text(0.02, y, reason, va="center", style="italic", color="#555555", fontsize=8.5)
            continue
        value = row[column]
        hollow = style["hollow"] or is_baseline(selector)
        edge = DARK if style["colour"] == YELLOW else style["colour"]
        face, hatch = ("white", "////") if hollow else (style["colour"], None)
        axes.barh(y, value, height=0.62, color=face, edgecolor=edge, hatch=hatch, linewidth=0.9)
        end = value
        if column == "f_paper" and None not in (row["f_paper_lo"], row["f_paper_hi"]):
            low, high = row["f_paper_lo"], row["f_paper_hi"]
            axes.plot([low, high], [y, y], color="white", linewidth=3.4, solid_capstyle="butt")
            axes.plot([low, high], [y, y], color="#222222", linewidth=1.4, marker="|", markersize=6)
            end = max(value, high)
        axes.text(end + 0.025, y, fraction(value), va="center", fontsize=8.5)
    axes.set_yticks(range(len(selectors)))
    axes.set_yticklabels([plot_text(s, 13) for s in selectors])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(selectors) - 0.5, -0.5)
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: "%g" % x))
    axes.set_title(title, loc="left")
    return svg(figure, "%s per selector for %s" % (title, group_text(group)))


def pixel_boxes(axes, points, obstacles):
    """Return the boxes (x0, y0, x1, y1), in pixels, of markers and of obstacles (corner, corner)."""
    scale = axes.figure.dpi / 72.0
    boxes = [
        (x - 4 * scale, y - 4 * scale, x + 4 * scale, y + 4 * scale)
        for x, y in axes.transData.transform(points)
    ]
    for corners in obstacles:
        (x0, y0), (x1, y1) = axes.transData.transform(corners)
        boxes.append((x0 - scale, y0 - scale, x1 + scale, y1 + scale))
    return boxes


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


def place_labels(axes, points, labels, obstacles):
    """Write a label beside each point, clear of labels, points and obstacles as far as there is room."""
    scale, frame = axes.figure.dpi / 72.0, axes.get_window_extent()
    centres = axes.transData.transform(points)
    boxes = pixel_boxes(axes, points, obstacles)
    for i in sorted(range(len(labels)), key=lambda k: -centres[k][1]):
        width, height = (5.3 * len(plot_text(labels[i])) + 2) * scale, 9.5 * scale
        best = None
        for rank, (dx, dy) in enumerate(label_offsets()):
            x = centres[i][0] + dx * scale - (width if dx < 0 else width / 2 if dx == 0 else 0)
            y = centres[i][1] + dy * scale - height / 2
            box = (x, y, x + width, y + height)
            inside = overlap_area(box, (frame.x0, frame.y0, frame.x1, frame.y1))
            covered = [overlap_area(box, other) for other in boxes]
            cost = 50 * (width * height - inside) + rank * scale
            cost += sum(40 * scale + area for area in covered if area > 0)
            if best is None or cost < best[0]:
                best = (cost, box, dx, dy)
        _, box, dx, dy = best
        boxes.append(box)
        arrow = (
            {"arrowstyle": "-", "color": "#999999", "linewidth": 0.6} if max(abs(dx), abs(dy)) > 14 else None
        )
        axes.annotate(
            plot_text(labels[i]),
            points[i],
            xytext=(dx, dy),
            textcoords="offset points",
            ha="right" if dx < 0 else "center" if dx == 0 else "left",
            va="center",
            fontsize=8.5,
            arrowprops=arrow,
        )


def label_offsets():
    """Return the places tried for a label, nearest first, in points from its point."""
    near = [(7, 0), (-7, 0), (6, 8), (6, -8), (-6, 8), (-6, -8), (0, 11), (0, -11)]
    far = [(dx, dy) for dy in (18, -18, 28, -28, 38, -38) for dx in (12, -12)]
    return near + far


def overlap_area(a, b):
    """Return the area two boxes (x0, y0, x1, y1) share."""
    return max(0, min(a[2], b[2]) - max(a[0], b[0])) * max(0, min(a[3], b[3]) - max(a[1], b[1]))


def limits_of_f(rows):
    """Return axis limits that hold the F values of rows with their intervals, at least 0.2 apart."""
    values = [r[k] for r in rows for k in ("f_paper", "f_paper_lo", "f_paper_hi") if r[k] is not None]
    low, high = min(values), max(values)
    pad = max(0.1 * (high - low), (0.2 - (high - low)) / 2, 0.02)
    return low - pad, high + pad


def time_panel(run, svg, group):
    """Draw mean F against the median selection time, the baseline as a line; '' without times."""
    rows = [r for r in run.ranking(group) if (r["select_s_median"] or 0) > 0]
    if not rows:
        return ""
    tau = run.tau(group)
    base = [run.mean(group, s, tau) for s in run.selectors_of(group) if is_baseline(s)]
    base = [row for row in base if row]
    figure, axes = new_axes(5.0, 3.6, 0.55, 0.15, 0.5, 0.34)
    times = [1e3 * r["select_s_median"] for r in rows]
    axes.set_xscale("log")
    axes.set_xlim(min(times) / 2, max(times) * 3)
    axes.set_ylim(*limits_of_f(rows + base))
    format_time_axis(axes, min(times) / 2, max(times) * 3)
    obstacles = []
    for time, row in zip(times, rows):
        options = line_style(run.styles[row["selector"]])
        options.update(linestyle="none", markersize=7)
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
        obstacles += draw_baseline(axes, row, points, obstacles)
    place_labels(axes, points, [r["selector"] for r in rows], obstacles)
    axes.grid(True)
    axes.set_xlabel("median selection time (ms, logarithmic)")
    axes.set_title("Mean F with 95 % interval", loc="left")
    return svg(
        figure, "Mean F against median selection time for %s, one point per selector" % group_text(group)
    )


def format_time_axis(axes, low, high):
    """Put plain numbers on a logarithmic axis, with steps between the decades where the range is short."""
    subs = (1.0,) if high / low > 300 else (1.0, 3.0) if high / low > 30 else (1.0, 2.0, 5.0)
    axes.xaxis.set_major_locator(LogLocator(base=10, subs=subs))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: "%g" % x))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())


def distribution_panel(run, svg, group):
    """Draw F of every pair, one row of dots per selector with median and quartiles. '' without values."""
    selectors = [s for s in run.selectors_of(group) if run.pair_values(group, s)]
    if not selectors:
        return ""
    figure, axes = new_axes(5.0, max(3.6, 0.85 + 0.3 * len(selectors)), 1.15, 0.15, 0.5, 0.34)
    axes.grid(True, axis="x")
    for y, selector in enumerate(selectors):
        values = np.array(list(run.pair_values(group, selector).values()))
        jitter = 0.26 * (2 * ((np.arange(len(values)) * 0.618034) % 1) - 1)
        colour = run.styles[selector]["colour"]
        edge = "#8a8420" if colour == YELLOW else colour
        axes.plot(
            values,
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
    axes.set_yticks(range(len(selectors)))
    axes.set_yticklabels([plot_text(s, 14) for s in selectors])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(selectors) - 0.4, -0.6)
    axes.set_xlim(-0.02, 1.02)
    axes.set_xlabel("F of a pair")
    axes.set_title("F pair by pair", loc="left")
    return svg(figure, "Distribution of F over the pairs of %s, one row per selector" % group_text(group))


# ---------------------------------------------------------------------------------------------- HTML building


def table(caption, head, rows, css="", long=False):
    """Return a table in a container of its own that scrolls; head cells and rows are HTML.

    Rows are (class, [cells]); the first cell becomes the row's header. Cells may be (attributes, HTML).
    """
    out = [
        '<div class="scroll" role="region" aria-label="%s" tabindex="0">'
        % esc(re.sub("<[^>]*>", "", caption))
    ]
    out.append(
        '<table class="%s"><caption>%s</caption>'
        % (" ".join(filter(None, [css, "long" if long else ""])), caption)
    )
    out.append(
        "<thead><tr>%s</tr></thead><tbody>" % "".join('<th scope="col">%s</th>' % cell for cell in head)
    )
    for row_css, cells in rows:
        parts = ['<th scope="row">%s</th>' % cells[0]]
        for cell in cells[1:]:
            attributes, content = cell if isinstance(cell, tuple) else ("", cell)
            parts.append("<td%s>%s</td>" % (" " + attributes if attributes else "", content))
        out.append("<tr%s>%s</tr>" % (' class="%s"' % row_css if row_css else "", "".join(parts)))
    out.append("</tbody></table></div>")
    return "\n".join(out)


def section(number_, identifier, title, body):
    """Return a numbered section."""
    return '<section id="%s"><h2><span class="no">%d</span> %s</h2>\n%s\n</section>' % (
        identifier,
        number_,
        esc(title),
        body,
    )


def paragraph(text, css=""):
    """Return a paragraph of HTML."""
    return "<p%s>%s</p>" % (' class="%s"' % css if css else "", text)


def group_heading(group):
    """Return a group's name as the HTML of a heading."""
    details = "%s, %s" % (features_text(group.features), preselection_text(group.preselection))
    return '%s <span class="sub">%s</span>' % (esc(group.dataset), esc(details))


def state_html(run):
    """Return the one-line state of the run, a banner where it is not complete."""
    done, total = run.state.get("pairs_done"), run.state.get("pairs_total")
    counted = "%s of %s pairs" % (done, total) if done is not None and total is not None else "not all pairs"
    short = isinstance(done, (int, float)) and isinstance(total, (int, float)) and done < total
    if run.state.get("complete") is True and not short:
        tail = ": %s" % counted if done is not None and total is not None else ""
        return paragraph("<strong>Complete</strong>%s." % esc(tail), "state done")
    if not run.state:
        return paragraph(
            "<strong>State unknown</strong>: summary.json does not tell whether the run is complete.",
            "state banner",
        )
    text = "<strong>INCOMPLETE</strong>: %s. The numbers below describe only the pairs done." % esc(counted)
    return paragraph(text, "state banner")


def notes_html(run):
    """Return the remarks on missing and damaged input files."""
    if not run.notes:
        return ""
    items = "".join("<li>%s</li>" % esc(note) for note in run.notes)
    return (
        '<aside class="notes" aria-label="Remarks on the input"><p>Remarks on the input'
        " files</p><ul>%s</ul></aside>" % items
    )


def lead_html(run):
    """Return the sentence that says what was compared."""
    datasets = OrderedDict()
    for row in run.pairs:
        datasets.setdefault(row["dataset"], set()).add((row["sequence"], row["pair"]))
    if not datasets:
        return paragraph("This run holds no pairs.", "lead")
    competing = [s for s in run.selectors if not is_baseline(s)]
    counts = ", ".join(
        "%s (%s)" % (esc(name), plural(len(pairs), "pair")) for name, pairs in datasets.items()
    )
    features = ", ".join(
        esc(features_text(f)) for f in OrderedDict.fromkeys(row["features"] for row in run.pairs)
    )
    text = "%s on %s, with %s: %s." % (
        plural(len(competing), "selector").capitalize(),
        counts,
        features,
        ", ".join("<b>%s</b>" % esc(s) for s in competing) or "none",
    )
    return paragraph(text, "lead")


def sentence(run, group):
    """Return what a group's numbers say, in words."""
    ranking, tau = run.ranking(group), run.tau(group)
    name = "<b>%s</b> (%s)" % (esc(group_text(group)), esc(at_tau(tau)))
    if not ranking:
        return "%s: no selector has a mean F." % name
    first = ranking[0]
    text = "%s: <b>%s</b> has the highest mean F, %s %s" % (
        name,
        esc(first["selector"]),
        fraction(first["f_paper"]),
        bracket(first),
    )
    text += versus(run, group, ranking) + "."
    timed = [r for r in ranking if r["select_s_median"] is not None]
    if timed:
        fastest = min(timed, key=lambda r: r["select_s_median"])
        same = " as well" if fastest is first else ", with F %s" % fraction(fastest["f_paper"])
        text += " Fastest is <b>%s</b> (%s ms)%s." % (
            esc(fastest["selector"]),
            milliseconds(fastest["select_s_median"]),
            same,
        )
    return text + baseline_sentence(run, group, ranking)


def versus(run, group, ranking):
    """Return how the winner stands to the runner-up, as the rest of a sentence."""
    if len(ranking) == 1:
        return ", the only selector with a result"
    first, second = ranking[:2]
    wins, ties, count = run.head_to_head(group, first["selector"], second["selector"])
    relation = "level with" if first["f_paper"] == second["f_paper"] else "ahead of"
    text = ", %s <b>%s</b> with %s %s" % (
        relation,
        esc(second["selector"]),
        fraction(second["f_paper"]),
        bracket(second),
    )
    common = overlap(first, second)
    if common is not None:
        text += "; the intervals %s" % ("overlap" if common else "do not overlap")
    if count:
        text += "; pair by pair <b>%s</b> is better on %d of %d" % (esc(first["selector"]), wins, count)
        text += " (%s)" % plural(ties, "tie") if ties else ""
    return text


def baseline_sentence(run, group, ranking):
    """Return how keeping everything compares."""
    rows = [run.mean(group, s, run.tau(group)) for s in run.selectors_of(group) if is_baseline(s)]
    rows = [r for r in rows if r]
    if not rows:
        return ""
    value = rows[0]["f_paper"]
    below = [r["selector"] for r in ranking if r["f_paper"] <= value]
    text = " Keeping everything gives F %s" % fraction(value)
    if not below:
        return text + "."
    if len(below) == len(ranking):
        return text + ": no selector does better."
    names = ["<b>%s</b>" % esc(s) for s in below]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    return text + "; %s %s no better." % (listed, "does" if len(below) == 1 else "do")


def f_cell(row):
    """Return the name of a selector with F and interval below it."""
    if row is None:
        return "\u2013"
    return '<b>%s</b><br><span class="small">%s (%s)</span>' % (
        esc(row["selector"]),
        fraction(row["f_paper"]),
        interval(row),
    )


def summary_row(run, group):
    """Return one row of the summary table."""
    ranking = run.ranking(group)
    head = '%s<br><span class="small">%s<br>%s</span>' % (
        esc(group.dataset),
        esc(features_text(group.features)),
        esc(preselection_text(group.preselection)),
    )
    tau = run.tau(group)
    cells = [head, "label" if tau is None else "%g" % tau]
    if not ranking:
        return ("", cells + [('colspan="7" class="text"', "no selector has a mean F")])
    second = ranking[1] if len(ranking) > 1 else None
    common = overlap(ranking[0], second) if second else None
    versus_text = "\u2013"
    if second:
        wins, ties, count = run.head_to_head(group, ranking[0]["selector"], second["selector"])
        versus_text = "%d of %d" % (wins, count) if count else "\u2013"
        versus_text += '<br><span class="small">%s</span>' % plural(ties, "tie") if ties else ""
    timed = [r for r in ranking if r["select_s_median"] is not None]
    fastest = min(timed, key=lambda r: r["select_s_median"]) if timed else None
    base = [run.mean(group, s, tau) for s in run.selectors_of(group) if is_baseline(s)]
    base = [r for r in base if r]
    quickest = "\u2013"
    if fastest:
        time = milliseconds(fastest["select_s_median"])
        quickest = '<b>%s</b><br><span class="small">%s ms</span>' % (esc(fastest["selector"]), time)
    text = 'class="text"'
    cells += [
        number(ranking[0]["pairs"]),
        (text, f_cell(ranking[0])),
        (text, f_cell(second)),
        (text, "\u2013" if common is None else "overlap" if common else "separate"),
        versus_text,
        (text, quickest),
        ('class="base"', fraction(base[0]["f_paper"])) if base else "\u2013",
    ]
    return ("", cells)


def overview_html(run):
    """Return the body of section 1: what won where."""
    groups = [g for g in run.groups if g in run.means]
    if not run.groups:
        return paragraph("There are no pairs in this run, so there is nothing to compare.")
    if not groups:
        return paragraph("There is no summary.csv to take means from; see the counts per pair below.")
    caption = "Highest mean F for each dataset, kind of features and preselection."
    caption += " In brackets the 95 %% interval of the mean. %s does not compete." % BASELINE
    head = [
        "Dataset",
        "\u03c4 (px)",
        "Pairs",
        "Highest F",
        "Runner-up",
        "Intervals",
        "Winner better on",
        "Fastest",
        "F of %s" % BASELINE,
    ]
    out = [table(caption, head, [summary_row(run, g) for g in groups], "overview", long=len(groups) > 12)]
    out.append('<ul class="findings">%s</ul>' % "".join("<li>%s</li>" % sentence(run, g) for g in groups))
    return "\n".join(out)


COLUMNS = (
    ("Precision", "precision", fraction, max),
    ("Recall", "recall_paper", fraction, max),
    ("F", "f_paper", fraction, max),
    ("F interval", None, None, None),
    ("F, same \u03c4", "f_same_tau", fraction, max),
    ("Median (ms)", "select_s_median", milliseconds, min),
    ("p95 (ms)", "select_s_p95", milliseconds, min),
    ("Pairs", "pairs", number, None),
)


def best_texts(run, group):
    """Return column -> the text of its best value, among the selectors that compete."""
    rows, best = run.ranking(group), {}
    for _, column, show, choose in COLUMNS:
        values = [r[column] for r in rows if column and r[column] is not None]
        if choose and values and len(rows) > 1:
            best[column] = show(choose(values))
    return best


def result_row(run, group, selector, best):
    """Return one selector's row of a group's table."""
    row = run.mean(group, selector, run.tau(group))
    css = "baseline" if is_baseline(selector) else ""
    name = esc(selector) + (' <span class="small">baseline</span>' if css else "")
    if row is None:
        if run.unsupported(group, selector):
            reason = "unsupported: %s" % STATUSES["unsupported_input"]
        else:
            counts = run.statuses.get((group, selector))
            reason = "no result" + (": " + statuses_text(counts) if counts else "")
        return (css, [name, ('colspan="%d" class="text none"' % len(COLUMNS), esc(reason))])
    cells = [name]
    for _, column, show, choose in COLUMNS:
        if column is None:
            cells.append(esc(interval(row)))
        elif not css and row[column] is not None and show(row[column]) == best.get(column):
            mark = "\u25b2" if choose is max else "\u25bc"
            content = '<strong>%s</strong><span class="mark" title="best of the column">%s</span>' % (
                esc(show(row[column])),
                mark,
            )
            cells.append(('class="best"', content))
        else:
            cells.append(esc(show(row[column])))
    return (css, cells)


def group_notes(run, group):
    """Return remarks that keep a reader from comparing what cannot be compared."""
    out, tau = [], run.tau(group)
    if tau is not None and tau != REFERENCE_TAU:
        out.append(
            "The run has no tolerance of %g px here; the table is made at %g px." % (REFERENCE_TAU, tau)
        )
    counts = OrderedDict((r["selector"], r["pairs"]) for r in run.ranking(group) if r["pairs"] is not None)
    if len(set(counts.values())) > 1:
        out.append(
            "The selectors have results on different numbers of pairs (see the last column): their means are"
            " not strictly comparable."
        )
    left = sum(1 for (g, _, _) in run.left_out if g == group)
    if left:
        out.append(
            "%s without any ground-truth inlier %s left out of the means." % (plural(left, "pair"), be(left))
        )
    usable = {s: len(run.pair_values(group, s)) for s in counts}
    stale = [s for s in counts if usable[s] > counts[s]]
    if stale:
        out.append(
            "summary.csv counts fewer pairs than pairs.csv holds for %s: it is older than the last pairs."
            % ", ".join(stale)
        )
    return [esc(text) for text in out]


def group_html(run, svg, swatches, index, group):
    """Return table and curves of one dataset x features x preselection."""
    tau = run.tau(group)
    caption = "Means over the pairs of %s at %s." % (esc(group_text(group)), esc(at_tau(tau)))
    if tau is None:
        caption = "Means over the pairs of %s; labelled ground truth, no tolerance." % esc(group_text(group))
    caption += " \u25b2 highest, \u25bc lowest of the column; the baseline is not marked."
    best = best_texts(run, group)
    selectors = run.selectors_of(group)
    rows = [result_row(run, group, s, best) for s in selectors]
    out = ['<article class="group" id="group-%d"><h3>%s</h3>' % (index, group_heading(group))]
    out.append(table(caption, ["Selector"] + [c[0] for c in COLUMNS], rows, "results"))
    out += [paragraph(note, "small") for note in group_notes(run, group)]
    measures = (("Precision", "precision"), ("Recall", "recall_paper"), ("F", "f_paper"))
    if run.ranking(group):
        panel = bar_panel if tau is None else curve_panel
        plots = "".join("<div>%s</div>" % panel(run, svg, group, title, column) for title, column in measures)
        text = "Precision, recall and F of each selector; the bars on F are 95 % intervals of the mean."
        legend = ""
        if tau is not None:
            text = (
                "Precision, recall and F against the tolerance; recall as in the paper, relative to the"
                " inliers at %d px." % GROUND_TRUTH_PX
            )
            drawn = [s for s in selectors if any(run.mean(group, s, t) for t in run.taus(group))]
            legend = '<ul class="legend">%s</ul>' % "".join(
                "<li>%s%s</li>" % (swatches[s], esc(s)) for s in drawn
            )
        out.append(
            '<figure class="figure">%s<div class="panels">%s</div><figcaption>%s</figcaption></figure>'
            % (legend, plots, text)
        )
    out.append("</article>")
    return "\n".join(out)


def results_html(run, svg):
    """Return the body of section 2."""
    groups = [g for g in run.groups if g in run.means]
    if not groups:
        return paragraph(
            "No means to show: %s." % ("summary.csv has no rows" if run.groups else "the run holds no pairs")
        )
    swatches = {s: swatch(run, svg, s) for s in run.selectors}
    out = []
    if len(groups) > 1:
        links = (
            '<li><a href="#group-%d">%s</a></li>' % (i, esc(group_text(g))) for i, g in enumerate(groups, 1)
        )
        out.append('<nav aria-label="Results"><ul class="toc">%s</ul></nav>' % "".join(links))
    out += [group_html(run, svg, swatches, i, g) for i, g in enumerate(groups, 1)]
    return "\n".join(out)


def stage_table(run):
    """Return the table of the median time of each stage before selection, from pairs.csv."""
    rows = []
    for key in OrderedDict.fromkeys((g.dataset, g.features) for g in run.groups):
        seen = OrderedDict()
        for row in run.pairs:
            if (row["dataset"], row["features"]) == key:
                seen.setdefault((row["sequence"], row["pair"]), row)
        cells = [esc(key[0]), ('class="text"', esc(features_text(key[1]))), str(len(seen))]
        for column in ("n_left", "n_right", "n_putative"):
            values = [r[column] for r in seen.values() if r[column] is not None]
            cells.append("%.0f" % np.median(values) if values else "\u2013")
        for column in ("detect_s", "describe_s", "match_s"):
            values = [r[column] for r in seen.values() if r[column] is not None]
            cells.append(milliseconds(float(np.median(values))) if values else "\u2013")
        rows.append(("", cells))
    head = [
        "Dataset",
        "Features",
        "Pairs",
        "Left",
        "Right",
        "Matches",
        "Detect (ms)",
        "Describe (ms)",
        "Match (ms)",
    ]
    caption = (
        "What comes before selection: medians over the pairs of the number of features and putative matches,"
        " and of the time of each stage. None of it is part of the selection time. \u2013 = not measured."
    )
    return table(caption, head, rows, "results stages")


TIME_TEXT = "Mean F: each selector with its 95 % interval against the median selection time. "
TIME_TEXT += "Up and to the left is better; the F axis does not start at 0."
DISTRIBUTION_TEXT = (
    "F pair by pair: one dot per pair; the thick stroke is the median, the line spans the quartiles."
)


def time_html(run, svg):
    """Return the body of section 3."""
    out = []
    for group in run.groups:
        panels = [
            (time_panel(run, svg, group), TIME_TEXT),
            (distribution_panel(run, svg, group), DISTRIBUTION_TEXT),
        ]
        panels = [(plot, text) for plot, text in panels if plot]
        if not panels:
            continue
        tau = run.tau(group)
        text = " ".join(
            [text for _, text in panels]
            + ["Labelled ground truth." if tau is None else "At %s." % at_tau(tau)]
        )
        plots = "".join("<div>%s</div>" % plot for plot, _ in panels)
        out.append('<article class="group"><h3>%s</h3><figure class="figure">' % group_heading(group))
        out.append(
            '<div class="panels two">%s</div><figcaption>%s</figcaption></figure></article>'
            % (plots, esc(text))
        )
    if run.pairs:
        out.append(stage_table(run))
    return "\n".join(out) or paragraph("The run holds no pairs.")


def image_data(run, name):
    """Return an image of the run as a data URI, None where it is missing, elsewhere or no picture."""
    root = run.folder.resolve()
    kinds = {".jpg": "jpeg", ".jpeg": "jpeg", ".png": "png"}
    for path in (run.folder / "images" / name, run.folder / name):
        try:
            path = path.resolve()
            if root in path.parents and path.suffix.lower() in kinds and path.is_file():
                code = base64.b64encode(path.read_bytes()).decode("ascii")
                return "data:image/%s;base64,%s" % (kinds[path.suffix.lower()], code)
        except (OSError, ValueError):
            pass
    return None


def image_caption(row):
    """Return the caption of an example as text, made of its numbers."""
    selected, correct, wrong, missed = (row[k] for k in ("n_selected", "n_correct", "n_wrong", "n_missed"))
    if selected is None:
        return "no counts"
    text = "%d selected" % selected
    if correct is not None:
        share = " (%.1f %%)" % (100 * correct / selected) if selected else ""
        text += ": %d correct%s" % (correct, share)
    text += ", %d wrong" % wrong if wrong is not None else ""
    text += "; %d correct ones missed" % missed if missed is not None else ""
    return text


def example_html(run, row, index):
    """Return one example image with its caption; a click opens it large, without any script."""
    title = "%s on %s %s %s" % (row["selector"], row["dataset"], row["sequence"], row["pair"])
    caption = image_caption(row)
    data = image_data(run, row["file"])
    if data is None:
        picture = '<p class="missing">image %s is missing</p>' % esc(row["file"])
    else:
        alt = "Matches selected by %s, drawn between the two images: %s" % (title, caption)
        picture = '<a class="open" href="#ex-%d" title="Enlarge"><img src="%s" alt="%s"></a>' % (
            index,
            data,
            esc(alt),
        )
    close = '<a class="close" href="#cell-%d">Close</a>' % index if data else ""
    return (
        '<div class="cell" id="cell-%d"><figure id="ex-%d">%s<figcaption><b>%s</b>'
        " %s</figcaption>%s</figure></div>"
        % (
            index,
            index,
            picture,
            esc(row["selector"]),
            esc(caption),
            close,
        )
    )


LEGEND = (
    ("#009E73", "correct", "selected and within \u03c4 of the truth"),
    ("#D55E00", "wrong", "selected, but further than \u03c4 from the truth"),
    ("#0072B2", "missed", "correct, but not selected"),
    ("#F0E442", "truth unknown", "selected where there is no ground truth"),
)


def examples_html(run):
    """Return the body of section 4."""
    if not run.images:
        return paragraph("The run drew no example pairs.")
    items = "".join(
        '<li><svg class="swatch" viewBox="0 0 36 14" aria-hidden="true"><path d="M2 7H34" stroke="#555"'
        ' stroke-width="6.4"/><path d="M2.7 7H33.3" stroke="%s" stroke-width="5"/></svg><span><b>%s</b>:'
        " %s</span></li>" % (colour, name, esc(meaning))
        for colour, name, meaning in LEGEND
    )
    out = [
        paragraph(
            "Each line joins a match in the left image to its partner in the right one. Click an image to"
            " enlarge it."
        )
    ]
    out.append('<ul class="legend colours">%s</ul>' % items)
    pairs = OrderedDict()
    for row in run.images:
        pairs.setdefault((group_of(row), row["sequence"], row["pair"]), []).append(row)
    index = 0
    for (group, sequence, pair), rows in pairs.items():
        tau = at_tau(rows[0]["tau_px"])
        if group.dataset == "sample":
            tau += ", photographed" if sequence in PHOTOGRAPHED else ", generated"
        sub = "%s, %s, %s" % (features_text(group.features), preselection_text(group.preselection), tau)
        name = " / ".join(OrderedDict.fromkeys(filter(None, [group.dataset, sequence, pair])))
        out.append('<h3>%s <span class="sub">%s</span></h3><div class="grid">' % (esc(name), esc(sub)))
        for row in sorted(rows, key=lambda r: selector_key(r["selector"])):
            index += 1
            out.append(example_html(run, row, index))
        out.append("</div>")
    return "\n".join(out)


def status_table(run):
    """Return the table of statuses per selector."""
    counts = OrderedDict((s, Counter()) for s in run.selectors)
    for (_, selector), statuses in run.statuses.items():
        counts[selector].update(statuses)
    names = list(STATUSES) + sorted({n for c in counts.values() for n in c} - set(STATUSES))
    rows = []
    for selector, counter in counts.items():
        cells = [('class="zero"', "0") if counter[n] == 0 else str(counter[n]) for n in names]
        rows.append(
            (
                "baseline" if is_baseline(selector) else "",
                [esc(selector)] + cells + [str(sum(counter.values()))],
            )
        )
    head = (
        ["Selector"]
        + [esc(n.replace("_", " ").replace("unsupported input", "unsupported")) for n in names]
        + ["all"]
    )
    caption = (
        "How the selections ended: one count per pair, kind of features, preselection and seed, not per"
        " tolerance."
    )
    return table(caption, head, rows, "results counts")


def cut_rows(rows, source):
    """Return the rows that are shown, and a remark on the others."""
    rest = len(rows) - MAX_ROWS
    return rows[:MAX_ROWS], paragraph("%d more in %s." % (rest, source), "small") if rest > 0 else ""


def failures_html(run):
    """Return the body of section 5."""
    out = []
    if run.failures:
        stages = Counter(row["stage"] for row in run.failures)
        text = ", ".join("%d at stage %s" % (n, esc(s or "(not named)")) for s, n in sorted(stages.items()))
        out.append(paragraph("<b>%s</b> recorded: %s." % (plural(len(run.failures), "failure"), text)))
        shown, rest = cut_rows(run.failures, "failures.csv")
        rows = [
            ("", [esc(r["dataset"])] + [('class="text"', esc(r[k])) for k in FAILURES_HEADER[1:]])
            for r in shown
        ]
        head = [name.capitalize() for name in FAILURES_HEADER]
        out += [table("Pairs on which a stage failed.", head, rows, "texts", long=len(rows) > 15), rest]
    else:
        out.append(paragraph("No failures are recorded."))
    if run.left_out:
        count = len({(g.dataset, s, p) for g, s, p in run.left_out})
        text = (
            "<b>%s</b> %s no ground-truth inlier among the putative matches in at least one setting, so"
            " recall and F are undefined there;"
        )
        text += " the pair is left out of the means of that setting."
        out.append(paragraph(text % (plural(count, "pair"), "has" if count == 1 else "have")))
        shown, rest = cut_rows(list(run.left_out.items()), "pairs.csv")
        rows = []
        for (group, sequence, pair), putative in shown:
            words = [sequence, pair, features_text(group.features), preselection_text(group.preselection)]
            rows.append(
                ("", [esc(group.dataset)] + [('class="text"', esc(w)) for w in words] + [number(putative)])
            )
        head = ["Dataset", "Sequence", "Pair", "Features", "Preselection", "Matches"]
        out += [table("Pairs left out of the means.", head, rows, "texts", long=len(rows) > 15), rest]
    elif run.pairs:
        out.append(paragraph("Every pair has ground-truth inliers; none is left out of the means."))
    if run.tasks:
        out.append(status_table(run))
    return "\n".join(out)


def definitions(run):
    """Return (term, HTML) of every term the report uses."""
    out = [
        (
            "Putative matches",
            (
                "the nearest neighbour, by descriptor distance, of every left feature in the right image: no"
                " cross-check, no ratio test. <i>Given</i> features are matches that the dataset itself"
                " provides."
            ),
        ),
        (
            "Selector",
            (
                "a method that keeps some of the putative matches. A name such as <code>lpm:v2</code> is the"
                " method <code>lpm</code> with its preset <code>v2</code>; a bare name has the parameters of"
                " the paper."
            ),
        ),
        (
            "Baseline %s" % BASELINE,
            (
                "keeps every match. What it scores is what the matches are worth without selection; it does"
                " not compete for the marks."
            ),
        ),
        (
            "Tolerance \u03c4",
            (
                "the largest error in pixels at which a match counts as correct, 1 to 10 px. The error is the"
                " distance of the right point from where the ground truth sends the left point (forward only;"
                " for a fundamental matrix, from the epipolar line)."
            ),
        ),
        (
            "Ground-truth inliers, t<sub>gt</sub>",
            "the putative matches with an error of at most t<sub>gt</sub> = %d px, whatever \u03c4 is. For"
            " labelled data: the matches labelled as belonging to a structure; there is no \u03c4."
            % GROUND_TRUTH_PX,
        ),
        (
            "Precision",
            (
                "correct selected matches at \u03c4 / selected matches. Undefined, and left empty, where"
                " nothing is selected; recall and F are then 0."
            ),
        ),
        (
            "Recall (paper)",
            "correct selected matches at \u03c4 / ground-truth inliers at t<sub>gt</sub> = %d px. The"
            " denominator does not shrink with \u03c4, so even a perfect selection has a recall below 1 at"
            " small \u03c4." % GROUND_TRUTH_PX,
        ),
        (
            "Recall (same \u03c4)",
            "correct selected matches at \u03c4 / putative matches within the same \u03c4.",
        ),
        (
            "F",
            (
                "harmonic mean of precision and recall (paper) of a pair; <i>F, same \u03c4</i> takes recall"
                " (same \u03c4)."
            ),
        ),
        (
            "Mean F",
            (
                "mean over the pairs of their F, not the F of mean precision and mean recall. The same holds"
                " for precision and recall. Pairs without any ground-truth inlier are left out and listed."
            ),
        ),
        (
            "Interval",
            (
                "95 % bootstrap interval of the mean F: pairs are drawn anew with replacement. Two intervals"
                " that do not overlap separate two selectors; two that overlap leave it open, and since all"
                " selectors see the same pairs, <i>better on</i> (the pairs on which the winner has the"
                " higher F than the runner-up) may tell more."
            ),
        ),
        (
            "Selection time",
            (
                "wall time of the selector alone, from the putative matches to the mask, steady clock."
                " Detection, description and matching are not in it, nor is a preselection. Median and 95th"
                " percentile (p95) over the pairs. It depends on the machine described below."
            ),
        ),
        (
            "Preselection",
            (
                "with <code>nnsr</code>, the survivors of NNSR (nearest-neighbour similarity ratio) become"
                " the putative matches, and the ground-truth inliers are counted again among them: recall is"
                " relative to the survivors."
            ),
        ),
    ]
    if any(row["dataset"] == "sample" for row in run.pairs):
        out.append(
            (
                "Dataset sample",
                (
                    "all sequences but <i>graf</i> and <i>aloe</i> are generated: the right image is computed"
                    " from a photograph by a known homography. Results on generated pairs say how a method"
                    " copes with geometry, less how it copes with a real second photograph."
                ),
            )
        )
    statuses = "; ".join("<code>%s</code>: %s" % (name, esc(text)) for name, text in STATUSES.items())
    out.append(("Status", statuses + "."))
    return out


def definitions_html(run):
    """Return the body of section 6."""
    return "<dl>%s</dl>" % "".join("<dt>%s</dt><dd>%s</dd>" % item for item in definitions(run))


def seeds_text(run):
    """Return the seeds of the run as words."""
    seeds = sorted({row["seed"] for row in run.pairs if row["seed"]}, key=lambda s: (len(s), s))
    if not seeds:
        return "none recorded"
    if len(seeds) > 12:
        return "%d different seeds, %s to %s; each is in its row of pairs.csv" % (
            len(seeds),
            seeds[0],
            seeds[-1],
        )
    return ", ".join(seeds)


def environment_html(run):
    """Return the body of section 7."""
    out = [paragraph("Seeds: %s." % esc(seeds_text(run)))]
    if run.environment:
        rows = []
        for key, value in run.environment.items():
            text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
            rows.append(("", [esc(key), ('class="text"', esc(text))]))
        out.append(
            table(
                "The machine and the software of the run.",
                ["Item", "Value"],
                rows,
                "texts",
                long=len(rows) > 30,
            )
        )
    else:
        out.append(paragraph("The environment was not recorded."))
    if run.config is None:
        out.append(paragraph("The configuration was not recorded."))
    else:
        out.append("<h3>Configuration</h3>")
        out.append('<pre tabindex="0" aria-label="config.yaml">%s</pre>' % esc(run.config.strip("\n")))
    return "\n".join(out)


CSS = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body { margin: 0 auto; max-width: 70rem; padding: 2.5rem 1.5rem 4rem; background: #fff; color: #1b1b1b;
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans", Arial,
    sans-serif; }
h1, h2, h3 { line-height: 1.2; font-weight: 650; overflow-wrap: anywhere; }
h1 { font-size: 2rem; margin: 0 0 .3rem; letter-spacing: -.015em; }
h2 { font-size: 1.4rem; margin: 3.5rem 0 1rem; padding-top: .8rem; border-top: 2px solid #1b1b1b; }
h2 .no { color: #767676; font-weight: 400; margin-right: .35rem; }
h3 { font-size: 1.1rem; margin: 2.4rem 0 .7rem; }
h3 .sub { font-weight: 400; color: #555; margin-left: .3rem; }
p, ul, dl { margin: 0 0 1rem; }
p, li, dd { overflow-wrap: anywhere; }
a { color: #005a8d; }
a:focus-visible, .scroll:focus-visible, pre:focus-visible { outline: 2px solid #0072B2;
  outline-offset: 2px; }
code, pre { font-family: ui-monospace, "SFMono-Regular", Menlo, Consolas, "DejaVu Sans Mono", monospace;
  font-size: .86em; }
.run { color: #555; margin: 0 0 1.2rem; }
.lead { max-width: 50rem; font-size: 1.06rem; }
.small { font-size: .84em; color: #555; font-weight: 400; }
.state { margin: 0 0 1.2rem; padding: .55rem .9rem; border-left: 5px solid #009E73; background: #eef7f3; }
.state.banner { border-color: #D55E00; background: #fdf0e6; }
.notes { border: 1px solid #d5d5d5; padding: .7rem 1rem; margin: 0 0 1.2rem; font-size: .92rem; }
.notes p { margin: 0 0 .3rem; font-weight: 650; } .notes ul { margin: 0; padding-left: 1.1rem; }
.toc { list-style: none; padding: 0; display: flex; flex-wrap: wrap; gap: .25rem 1.4rem;
  font-size: .94rem; }
.scroll { overflow-x: auto; margin: 0 0 1.2rem; max-width: 100%; }
table { border-collapse: collapse; min-width: 100%; font-variant-numeric: tabular-nums;
  font-size: .92rem; line-height: 1.35; }
caption { text-align: left; color: #555; padding: 0 0 .5rem; font-size: .92rem; }
caption { position: sticky; left: 0; max-width: calc(100vw - 3rem); }
th, td { padding: .42rem .8rem; text-align: right; vertical-align: baseline; white-space: nowrap; }
th { font-weight: 650; }
thead th { border-bottom: 1.5px solid #1b1b1b; vertical-align: bottom; font-size: .88rem; }
tbody tr { border-bottom: 1px solid #e3e3e3; }
tbody tr:last-child { border-bottom: 1.5px solid #1b1b1b; }
th:first-child { text-align: left; padding-left: .2rem; position: sticky; left: 0; background: #fff;
  z-index: 1; }
.nb { white-space: nowrap; }
.text { text-align: left; }
.texts td, .texts thead th { text-align: left; }
.texts td { white-space: normal; overflow-wrap: anywhere; min-width: 6rem; }
.overview thead th:nth-child(n+4):not(:nth-child(7)):not(:nth-child(9)) { text-align: left; }
.results td, .results thead th { padding-right: 1.35rem; }
.stages { margin-top: 2.4rem; } .stages thead th:nth-child(2) { text-align: left; }
td.best { position: relative; }
.mark { position: absolute; right: .3rem; font-size: .8em; color: #005a8d; }
tr.baseline th, tr.baseline td, td.base { color: #5c5c5c; font-style: italic; }
tr.baseline { background: #f5f5f5; } tr.baseline th:first-child { background: #f5f5f5; }
.none { color: #5c5c5c; font-style: italic; }
.results td.none { text-align: left; }
.zero { color: #767676; }
.findings { padding-left: 1.1rem; } .findings li { margin-bottom: .6rem; max-width: 54rem; }
.figure { margin: 1rem 0 0; }
figcaption { color: #555; font-size: .9rem; }
.panels { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: .6rem 1.2rem; }
.panels.two { grid-template-columns: repeat(2, minmax(0, 1fr)); }
svg.plot { display: block; width: 100%; height: auto; }
svg text { font-family: inherit !important; }
svg.plot *, svg.swatch * { stroke-linecap: butt; stroke-linejoin: round; }
.legend { list-style: none; padding: 0; margin: 0 0 .5rem; display: flex; flex-wrap: wrap;
  gap: .2rem 1.3rem; font-size: .92rem; }
.legend li { display: flex; align-items: center; gap: .4rem; }
svg.swatch { width: 36px; height: 14px; flex: none; }
.colours { margin-bottom: 1rem; }
.grid { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 19rem), 1fr));
  gap: 1.2rem; }
.cell figure { margin: 0; }
.cell img { display: block; width: 100%; height: auto; border: 1px solid #d5d5d5; cursor: zoom-in; }
.cell figcaption { margin-top: .35rem; } .cell figcaption b { color: #1b1b1b; margin-right: .25rem; }
.close { display: none; }
.missing { border: 1px dashed #aaa; padding: 2rem 1rem; margin: 0; text-align: center; color: #555;
  font-size: .9rem; }
dt { font-weight: 650; margin-top: .9rem; } dd { margin: .1rem 0 0; max-width: 50rem; }
pre { background: #f5f5f5; padding: .9rem 1rem; overflow-x: auto; line-height: 1.45; }
footer { margin-top: 3rem; padding-top: .8rem; border-top: 1px solid #d5d5d5; color: #555;
  font-size: .88rem; }
@media screen {
  .cell figure:target { position: fixed; z-index: 9; top: 0; right: 0; bottom: 0; left: 0;
    background: #fff; padding: 1rem;
    display: flex; flex-direction: column; overflow: auto; }
  .cell figure:target .open { flex: 1 1 auto; min-height: 0; display: flex; align-items: center;
    justify-content: center; }
  .cell figure:target img { width: 100%; height: 100%; object-fit: contain; border: 0; cursor: default; }
  .cell figure:target .close { display: inline-block; order: -1; align-self: flex-end;
    padding: .4rem .8rem; margin-bottom: .4rem; }
}
@media screen and (max-width: 800px) {
  .panels, .panels.two { grid-template-columns: minmax(0, 1fr); }
}
@media screen and (max-width: 560px) {
  body { padding: 1.4rem 1rem 3rem; }
  h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2.6rem; }
  h3 .sub { display: block; margin: .15rem 0 0; font-size: .95rem; }
  table { font-size: .86rem; } th, td { padding: .4rem .6rem; }
  th:first-child { min-width: 5.6rem; max-width: 9.5rem; white-space: normal; overflow-wrap: break-word; }
}
@media print {
  @page { size: A4; margin: 13mm; }
  body { max-width: none; padding: 0; font-size: 9.5pt; }
  h2 { margin-top: 1.6rem; }
  h1, h2, h3, caption, .legend { page-break-after: avoid; break-after: avoid; }
  .scroll { overflow: visible; }
  table { font-size: 8pt; page-break-inside: avoid; break-inside: avoid; }
  table.long { page-break-inside: auto; break-inside: auto; } thead { display: table-header-group; }
  th, td { padding: .25rem .35rem; } .results td, .results thead th { padding-right: 1rem; }
  thead th { white-space: normal; }
  .text, .none { white-space: normal; } th:first-child, caption { position: static; }
  tr, .figure, .cell, dt { page-break-inside: avoid; break-inside: avoid; } dt { break-after: avoid; }
  .grid { grid-template-columns: repeat(2, 1fr); }
  pre { white-space: pre-wrap; overflow-wrap: anywhere; }
  nav { display: none; } a { color: inherit; text-decoration: none; }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
"""


def build(run):
    """Return the whole report as HTML."""
    set_up_figures()
    svg = SvgWriter()
    parts = [
        ("overview", "What won where", overview_html(run)),
        ("results", "Results", results_html(run, svg)),
        ("time", "Time against F, and F pair by pair", time_html(run, svg)),
        ("examples", "Example pairs", examples_html(run)),
        ("failures", "Failures and left-out pairs", failures_html(run)),
        ("definitions", "Definitions", definitions_html(run)),
        ("environment", "Environment, configuration, seeds", environment_html(run)),
    ]
    title = "Correspondence selection benchmark"
    toc = "".join(
        '<li><a href="#%s">%d %s</a></li>' % (key, i, esc(name)) for i, (key, name, _) in enumerate(parts, 1)
    )
    out = [
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        "<title>%s: %s</title>" % (title, esc(run.name)),
        "<style>%s</style>\n</head>\n<body>" % CSS,
        '<header><h1>%s</h1>\n<p class="run">Run <b>%s</b></p>' % (title, esc(run.name)),
        state_html(run),
        lead_html(run),
        notes_html(run),
        '<nav aria-label="Contents"><ul class="toc">%s</ul></nav></header>\n<main>' % toc,
    ]
    out += [section(i, key, name, body) for i, (key, name, body) in enumerate(parts, 1)]
    out.append(
        "</main>\n<footer>Made by report.py of corrsel from the files of the run. Means: summary.csv; pairs:"
        " pairs.csv.</footer>"
    )
    out.append("</body>\n</html>\n")
    return "\n".join(part for part in out if part)


# ----------------------------------------------------------------------------------------------- command line


def write_atomically(path, text):
    """Write a file so that readers see the old one or the whole new one."""
    mask = os.umask(0)
    os.umask(mask)
    try:
        handle, temporary = tempfile.mkstemp(prefix=".report-", suffix=".tmp", dir=str(path.parent))
    except OSError as error:
        raise ReportError(
            "%s: cannot be written (%s). Remedy: give another file with --output." % (path, error.strerror)
        )
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n", errors="replace") as stream:
            stream.write(text)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, str(path))
    except OSError as error:
        os.unlink(temporary)
        raise ReportError(
            "%s: cannot be written (%s). Remedy: give another file with --output." % (path, error.strerror)
        )
    except BaseException:
        os.unlink(temporary)
        raise


def main(arguments=None):
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        description="Turn the folder of a benchmark run into one self-contained HTML file."
    )
    parser.add_argument(
        "run_folder", metavar="RUN_FOLDER", help="output folder of a benchmark run; holds pairs.csv"
    )
    parser.add_argument("--output", metavar="FILE", help="file to write (default: RUN_FOLDER/report.html)")
    options = parser.parse_args(arguments)
    folder = Path(options.run_folder)
    try:
        run = read_run(folder)
        output = Path(options.output) if options.output else folder / "report.html"
        text = build(run)
        write_atomically(output, text)
    except ReportError as error:
        print("report.py: error: %s" % error, file=sys.stderr)
        return 2
    if len(text) > LARGE_BYTES:
        print(
            "report.py: note: %s has %.1f MB, mostly example images" % (output, len(text) / 1e6),
            file=sys.stderr,
        )
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
