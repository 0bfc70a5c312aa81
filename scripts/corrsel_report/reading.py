"""Reads the folder of a run (tables, state, configuration) into a `Run`, which the report queries."""
import csv
import io
import json
import math
import re
from collections import Counter, OrderedDict, namedtuple

import numpy as np

from .left_out import LeftOut, cause
from .selectors import is_baseline, selector_key, selector_styles
from .words import is_unrelated, plural

PAIRS_HEADER = (
    "dataset,sequence,pair,features,preselection,selector,tau_px,n_left,n_right,n_putative,n_ground_truth,"
    "n_selected,n_correct,precision,recall_paper,recall_same_tau,f_paper,f_same_tau,status,"
    "confidence,seed,detect_s,describe_s,match_s,select_s"
).split(",")
SUMMARY_HEADER = (
    "dataset,features,preselection,selector,tau_px,pairs,precision,recall_paper,f_paper,f_paper_lo,"
    "f_paper_hi,recall_same_tau,f_same_tau,confidence_median,select_s_median,select_s_p95"
).split(",")
FAILURES_HEADER = "dataset,sequence,pair,features,stage,error".split(",")
IMAGES_HEADER = (
    "file,dataset,sequence,pair,features,preselection,selector,n_selected,n_correct,n_wrong,n_missed,tau_px"
).split(",")
STAGES_HEADER = "number,dataset,sequence,pair,stage,seconds".split(",")
SCALING_HEADER = "selector,threads,n,round,n_selected,status,select_s".split(",")
REMARKS_HEADER = "dataset,sequence,selector,remark".split(",")
TEXT_COLUMNS = {"dataset", "sequence", "pair", "features", "preselection", "selector", "status", "seed"}
TEXT_COLUMNS |= {"stage", "error", "file", "threads", "remark"}
REFERENCE_TAU = 5.0
Group = namedtuple("Group", "dataset features preselection")


class ReportError(Exception):
    """Input from which no report can be made; the message names the input, the reason and the remedy."""


def to_number(text):
    """Return the finite number in a cell, None for an empty or undefined one; else ValueError."""
    if not text.strip():
        return None
    value = float(text)
    return value if math.isfinite(value) else None


def describe_header_difference(found, expected):
    """Return one sentence on where a header differs from the expected one."""
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
            "%s: wrong header: %s. Found '%s', expected '%s'. Remedy: write the folder again with the"
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


def config_values(text):
    """Return key -> text or list of texts of the top-level lines of a config.yaml.

    Reads what the benchmark writes there: plain and quoted words, and lists in brackets. Nested maps, and
    whatever else YAML allows, are left out.
    """
    values = OrderedDict()
    for match in re.finditer(r"^([A-Za-z_]\w*):[ \t]*(\[.*\]|\[[^\]]*\]|.*?)[ \t]*$", text, re.M):
        key, value = match.groups()
        if value.startswith("[") and value.endswith("]"):
            values[key] = [word for word in map(unquote, split_list(value[1:-1])) if word]
        elif value:
            values[key] = unquote(value)
    return values


def split_list(text):
    """Return the parts between the commas that stand outside of quotes."""
    return [match[0] for match in re.finditer(r"""(?:"(?:\\.|[^"\\])*"|'(?:''|[^'])*'|[^,"'])+""", text)]


def unquote(text):
    """Return a YAML word without its quotes."""
    text = text.strip()
    if len(text) >= 2 and text[0] == text[-1] == '"':
        return re.sub(r"\\(.)", r"\1", text[1:-1])
    if len(text) >= 2 and text[0] == text[-1] == "'":
        return text[1:-1].replace("''", "'")
    return text


def read_run(folder):
    """Read the folder of a run into a Run; raises ReportError without a usable pairs.csv."""
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
    warnings = content.get("truth_warnings")
    run.truth_warnings = warnings if isinstance(warnings, list) else []
    run.environment = read_optional_json(folder / "environment.json", notes, "the machine is not described")
    run.failures = read_optional_table(
        folder / "failures.csv", FAILURES_HEADER, notes, "pairs that failed before selection are not listed"
    )
    if (folder / "remarks.csv").is_file():
        run.remarks = read_optional_table(
            folder / "remarks.csv", REMARKS_HEADER, notes, "remarks on the images are not shown"
        )
    run.images = read_optional_table(
        folder / "images" / "index.csv", IMAGES_HEADER, notes, "no example pairs are shown"
    )
    config = folder / "config.yaml"
    run.config = read_text(config) if config.is_file() else None
    if run.config is None:
        notes.append("config.yaml is missing: the configuration is not shown.")
    run.settings = config_values(run.config or "")
    run.sections = run.list_setting("sections")
    run.stages = read_optional_table(
        folder / "stages.csv", STAGES_HEADER, notes, "the time by stage is not shown"
    )
    if "efficiency" in run.sections or (folder / "scaling.csv").is_file():
        run.scaling = read_optional_table(
            folder / "scaling.csv", SCALING_HEADER, notes, "time against the number of matches is not shown"
        )
    run.index()
    return run


class Run:
    """The contents of a run's folder, with the queries that the report needs."""

    def __init__(self, folder, pairs, notes):
        """Hold the rows of pairs.csv; the optional files are filled in by read_run."""
        self.folder = folder
        self.name = folder.resolve().name
        self.pairs = pairs
        self.notes = notes
        self.summary, self.failures, self.images, self.stages, self.scaling = [], [], [], [], []
        self.remarks = []
        self.state, self.environment, self.config = {}, {}, None
        self.truth_warnings = []  # sequences whose ground truth another reading explains far better
        self.settings = {}  # top-level keys of config.yaml
        self.sections = []  # experiments of the preset the run was started with; empty without preset
        self.link = ""  # leads from the page to the run's folder: "" or ends in "/"

    def index(self):
        """Build the look-ups; call once all files are read."""
        self.means = OrderedDict()  # group -> selector -> tau -> row of summary.csv
        for row in self.summary:
            selectors = self.means.setdefault(group_of(row), {})
            selectors.setdefault(row["selector"], {})[row["tau_px"]] = row
        self.rows = OrderedDict()  # group -> selector -> rows of pairs.csv
        self.tasks = OrderedDict()  # one status per pair x features x preselection x selector x seed
        self.left_out = OrderedDict()  # (group, sequence, pair) without ground-truth inlier -> LeftOut
        for row in self.pairs:
            group = group_of(row)
            self.rows.setdefault(group, OrderedDict()).setdefault(row["selector"], []).append(row)
            task = (group, row["sequence"], row["pair"], row["selector"], row["seed"])
            if self.tasks.get(task, "ok") == "ok":
                self.tasks[task] = row["status"] or "ok"
            if is_unrelated(row["dataset"]):
                continue
            if row["n_ground_truth"] == 0 and row["status"] != "unsupported_input":
                place = (group, row["sequence"], row["pair"])
                known = self.left_out.get(place)
                # Only a selection of matches shows whether there is a truth that could judge it.
                if known is None or row["n_selected"]:
                    self.left_out[place] = LeftOut(cause(row), row["n_putative"])
        groups = OrderedDict.fromkeys(list(self.rows) + list(self.means))
        # Pairs of different scenes have no F; a section of their own shows them.
        self.groups = [group for group in groups if not is_unrelated(group.dataset)]
        names = {row["selector"] for row in self.pairs} | {row["selector"] for row in self.summary}
        self.selectors = sorted(names, key=selector_key)
        self.statuses = {}  # (group, selector) -> Counter of statuses
        for (group, _, _, selector, _), status in self.tasks.items():
            self.statuses.setdefault((group, selector), Counter())[status] += 1
        self.styles = selector_styles(self.selectors)

    def list_setting(self, key):
        """Return a list of config.yaml; empty where there is none."""
        value = self.settings.get(key, [])
        return value if isinstance(value, list) else []

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

    def unsupported_reason(self, group, selector):
        """Return why a selector could not run on a group; None where the run did not record it."""
        names = (selector, "preselection by %s" % group.preselection)
        found = (r for r in self.remarks if r["selector"] in names and r["dataset"] == group.dataset)
        return next((row["remark"] for row in found), None)

    def pair_names(self, group):
        """Return the pairs of a group, as (sequence, pair), that reached the selectors."""
        rows = (row for selected in self.rows.get(group, {}).values() for row in selected)
        return OrderedDict.fromkeys((row["sequence"], row["pair"]) for row in rows)

    def failed_pairs(self, dataset):
        """Return the number of pairs of a dataset that could not be read or run."""
        return sum(row["dataset"] == dataset and row["stage"] in ("read", "run") for row in self.failures)

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
