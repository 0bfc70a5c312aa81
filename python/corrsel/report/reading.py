"""Reads the folder of a run (tables, state, configuration) into a `Run`, which the sections of the report query.

pairs.csv may have millions of rows. A section therefore asks for arrays, and never loops over rows:

    for group in run.groups:                              # dataset x features x preselection
        for selector in run.selectors_of(group):
            f = run.pair_values(group, selector)          # F at run.tau(group), entry i is of run.pairs_of(group)[i]
            f = f[np.isfinite(f)]                         # NaN: no ground truth, unsupported, no row
            rows = run.rows(group, selector)              # all rows: every tolerance and repetition
            times = rows["select_s"][rows["tau_px"] == run.tau(group)]

`run.datasets`, `run.features` and `run.seeds` state what the rows hold, `run.statuses` how the selections ended,
`run.scenes` which scenes they found, and `run.mean` gives a row of summary.csv. `run.stages` has columns, too. The other
tables are lists of dictionaries.
A further large table of the same kind is read with `tables.read_columns` into a `RowTable`.
"""
import csv
import json
import re
from collections import Counter, OrderedDict, namedtuple

import numpy as np
import yaml

from .left_out import LeftOut, cause
from .selectors import SHARED_NAMES, is_baseline, selector_key, selector_styles
from .tables import (
    Columns,
    ReportError,
    open_text,
    read_columns,
    read_optional_columns,
    read_optional_table,
    read_text,
)
from .words import is_unrelated

PAIRS_FORMAT = "# corrsel pairs "  # begins pairs.csv; the number of the format follows
PAIRS_VERSION = 2
# The columns of each tolerance stand before n_selected and before status, see pairs_header.
PAIRS_HEADER = (
    "dataset,sequence,pair,features,preselection,selector,truth,n_left,n_right,n_putative,n_ground_truth,"
    "n_selected,n_correct_labels,status,scene,confidence,seed,detect_s,describe_s,match_s,select_s"
).split(",")
INLIERS, CORRECT = "n_inliers_%spx", "n_correct_%spx"
MEASURES = ["tau_px", "n_correct", "precision", "recall_paper", "recall_same_tau", "f_paper", "f_same_tau"]
# The columns that the sections see: a row for each selection and tolerance, tau_px is NaN with labelled truth.
ROW_HEADER = [name for name in PAIRS_HEADER if name != "n_correct_labels"] + MEASURES
POSES_HEADER = (
    "dataset,sequence,pair,features,preselection,selector,seed,status,n_selected,model,n_inliers,rotation_deg,"
    "translation_deg,pose_deg,epipolar_precision,corner_px,estimate_s,motion,true_motion,own_rotation_deg,"
    "own_translation_deg,own_pose_deg,second_pose_deg,nees,nees_degrees,uncertain"
).split(",")
POSE_SUMMARY_HEADER = (
    "dataset,features,preselection,selector,poses,no_pose,auc_5,auc_10,auc_10_lo,auc_10_hi,auc_20,maa_10,"
    "rotation_deg_median,translation_deg_median,pose_deg_median,epipolar_precision,homographies,no_homography,"
    "corner_auc_1,corner_auc_3,corner_auc_3_lo,corner_auc_3_hi,corner_auc_5,corner_px_median,estimate_s_median,"
    "own_poses,own_no_pose,own_auc_5,own_auc_10,own_auc_10_lo,own_auc_10_hi,own_auc_20,own_rotation_deg_median,"
    "own_translation_deg_median,own_pose_deg_median,uncertain,nees_poses,nees_mean,nees_median,nees_inside_95,"
    "nees_rotation_poses,nees_rotation_mean,nees_rotation_median,nees_rotation_inside_95"
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
REFERENCE_TAU = 5.0
GROUND_TRUTH_PX = 10.0  # default of ground_truth_tolerance
Group = namedtuple("Group", "dataset features preselection")


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
    """Return key -> text or list of texts of the top level of a config.yaml; ReportError where it is no YAML.

    All values are texts as they are written, so that the number of a selector's option stays as the user wrote it.
    Nested maps are left out.
    """
    try:
        # BaseLoader makes nothing but texts, lists and dictionaries, so that any file is safe to read.
        content = yaml.load(text, Loader=yaml.BaseLoader)
    except yaml.YAMLError as error:
        raise ReportError("it is not valid YAML (%s)" % " ".join(str(error).split())) from error
    items = content.items() if isinstance(content, dict) else ()
    return OrderedDict((key, value) for key, value in items if isinstance(value, (str, list)))


def read_config(run):
    """Read config.yaml, the text of which the page shows, into a Run; note where that fails."""
    path = run.folder / "config.yaml"
    if not path.is_file():
        run.notes.append("config.yaml is missing: the configuration is not shown.")
        return
    run.config = read_text(path)
    try:
        run.settings = config_values(run.config)
    except ReportError as error:
        run.notes.append("config.yaml was not used, because %s." % error)
    run.sections = run.list_setting("sections")


def pairs_header(taus):
    """Return the header of a pairs.csv with these tolerances, given as texts, px."""
    at, end = PAIRS_HEADER.index("n_selected"), PAIRS_HEADER.index("status")
    inliers, correct = [INLIERS % tau for tau in taus], [CORRECT % tau for tau in taus]
    return PAIRS_HEADER[:at] + inliers + PAIRS_HEADER[at:end] + correct + PAIRS_HEADER[end:]


def check_format(path, line):
    """Raise ReportError where the first line of a pairs.csv is not that of this version."""
    expected = "%s%d" % (PAIRS_FORMAT, PAIRS_VERSION)
    if not line or line == expected:
        return
    if line.startswith(PAIRS_FORMAT):
        found = "it has format %s" % line[len(PAIRS_FORMAT) :]
    elif line.startswith("dataset,"):
        found = "it has format 1 (no line with a version), which corrsel wrote up to version 0.1.0"
    else:
        raise ReportError(
            "%s: the first line is not '%s'. Remedy: give the output folder of a run." % (path, expected)
        )
    raise ReportError(
        "%s: %s; this version reads format %d. Remedy: run the benchmark again with the settings in the folder's"
        " config.yaml and another output folder, or make the report with the version that wrote the folder, which its"
        " environment.json names." % (path, found, PAIRS_VERSION)
    )


def ratio(part, whole):
    """Return part / whole, NaN where the whole is 0."""
    return np.divide(part, whole, out=np.full(len(part), np.nan), where=whole != 0)


def harmonic_mean(precision, recall):
    """Return F; 0 where nothing was selected, NaN where the recall is undefined."""
    both = precision + recall
    usable = both > 0
    f = np.divide(2 * precision * recall, both, out=np.zeros(len(both)), where=usable)
    f[np.isnan(recall)] = np.nan
    return f


def by_tolerance(table, taus):
    """Return Columns with ROW_HEADER of the Columns of a pairs.csv: one row per selection and tolerance."""
    labelled = table["truth"] == table.code("truth", "labels")
    counts = np.where(labelled, 1, len(taus))
    source = np.repeat(np.arange(len(table)), counts)
    which = np.arange(len(source)) - np.repeat(np.cumsum(counts) - counts, counts)  # number of the tolerance
    labelled = labelled[source]

    def chosen(pattern, of_labels):
        values = np.stack([table[pattern % tau] for tau in taus])[which, source]
        return np.where(labelled, table[of_labels][source], values)

    rows = Columns(ROW_HEADER)
    for name in ROW_HEADER:
        if name not in MEASURES:
            rows.arrays[name] = table[name][source]
    rows.texts = {name: table.texts[name] for name in rows.texts}
    correct, inliers = chosen(CORRECT, "n_correct_labels"), chosen(INLIERS, "n_ground_truth")
    rows.arrays["tau_px"] = np.where(labelled, np.nan, np.array([float(tau) for tau in taus])[which])
    rows.arrays["n_correct"] = correct
    rows.arrays["precision"] = ratio(correct, rows["n_selected"])
    for name, whole in (("paper", rows["n_ground_truth"]), ("same_tau", inliers)):
        rows.arrays["recall_" + name] = ratio(correct, whole)
        rows.arrays["f_" + name] = harmonic_mean(rows["precision"], rows["recall_" + name])
    return rows


def read_pairs(path, notes):
    """Read a pairs.csv into Columns with ROW_HEADER; for what cannot be read, see tables.read_table."""
    with open_text(path) as stream:
        first, names = (stream.readline().rstrip("\r\n") for _ in range(2))
    check_format(path, first)
    taus = re.findall("(?<=,)" + INLIERS % "([^,]+)" + "(?=,)", names)
    table = read_columns(path, pairs_header(taus), notes, 1)
    return by_tolerance(table, taus) if taus else Columns(ROW_HEADER)


def drop_intervals_of_single_pairs(rows, count, mean):
    """Make the interval of a mean undefined in rows whose column `count` is 1: one pair says nothing about others."""
    for row in rows:
        if row[count] is not None and row[count] < 2:
            row[mean + "_lo"] = row[mean + "_hi"] = None


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
        table = read_pairs(pairs_file, notes)
    except (OSError, csv.Error) as error:
        raise ReportError(
            "%s: cannot be read (%s). Remedy: check the file and its permissions." % (pairs_file, error)
        )
    run = Run(folder, RowTable(table), notes)
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
    if (folder / "pose_summary.csv").is_file():
        run.pose_summary = read_optional_table(
            folder / "pose_summary.csv", POSE_SUMMARY_HEADER, notes, "poses and corners are not shown"
        )
    if (folder / "remarks.csv").is_file():
        run.remarks = read_optional_table(
            folder / "remarks.csv", REMARKS_HEADER, notes, "remarks on the images are not shown"
        )
    run.images = read_optional_table(
        folder / "images" / "index.csv", IMAGES_HEADER, notes, "no example pairs are shown"
    )
    drop_intervals_of_single_pairs(run.summary, "pairs", "f_paper")
    for count, area in (("poses", "auc_10"), ("homographies", "corner_auc_3"), ("own_poses", "own_auc_10")):
        drop_intervals_of_single_pairs(run.pose_summary, count, area)
    read_config(run)
    run.stages = read_optional_columns(
        folder / "stages.csv", STAGES_HEADER, notes, "the time by stage is not shown"
    )
    if "efficiency" in run.sections or (folder / "scaling.csv").is_file():
        run.scaling = read_optional_table(
            folder / "scaling.csv", SCALING_HEADER, notes, "time against the number of matches is not shown"
        )
    run.index()
    return run


class Rows:
    """The rows of one group and selector, in the order of the file: rows["f_paper"] is an array."""

    def __init__(self, columns, begin, end, places):
        """Show the rows from begin to end of some Columns; `places` are those of the group's pairs, ascending."""
        self.columns, self.slice, self.places = columns, slice(begin, end), places

    def __len__(self):
        """Return the number of rows."""
        return self.slice.stop - self.slice.start

    def __getitem__(self, name):
        """Return a column: numbers with NaN for empty cells, or codes of texts (see tables.Columns)."""
        return self.columns[name][self.slice]

    def pairs(self):
        """Return for each row the index of its pair in pairs_of(group)."""
        return np.searchsorted(self.places, self["place"])

    def has(self, name, *texts):
        """Return for each row whether its cell in a column of texts is one of these."""
        return np.isin(self[name], [self.columns.code(name, text) for text in texts])

    def selections(self):
        """Return the first row of each selection, of a pair with a seed; the rows of further tolerances repeat it."""
        numbers = self["place"] * np.int64(self["seed"].max(initial=0) + 1) + self["seed"]
        return np.sort(np.unique(numbers, return_index=True)[1])

    def counts(self, *names):
        """Return, for columns of texts that no tolerance changes, text -> number of selections."""
        first, out = self.selections(), []
        for name in names:
            codes, counts = np.unique(self[name][first], return_counts=True)
            out.append(
                Counter(dict(zip((self.columns.texts[name][code] for code in codes), counts.tolist())))
            )
        return out


class RowTable:
    """The rows of pairs.csv, or of a table with the same first columns, by group and selector."""

    def __init__(self, columns):
        """Sort Columns by group and selector; within these the order of the file remains."""
        self.columns = columns
        # A place is a pair of a dataset. The numbers of places follow the order in which they appear.
        columns.arrays["place"], first = columns.numbering("dataset", "sequence", "pair")
        self.place_codes = {name: columns[name][first] for name in ("dataset", "sequence", "pair")}
        counts = np.bincount(self.place_codes["dataset"], minlength=len(columns.texts["dataset"]))
        self.datasets = OrderedDict(zip(columns.texts["dataset"], counts.tolist()))  # -> number of pairs
        self.features, self.seeds = columns.texts["features"], columns.texts.get("seed", [])
        self.selectors = columns.texts["selector"]
        groups, first = columns.numbering("dataset", "features", "preselection")
        self.groups = [Group(*self.texts(i, *Group._fields)) for i in first]
        columns.arrays["row"] = np.arange(len(columns), dtype=np.int32)  # as in the file
        key = groups * np.int64(len(self.selectors)) + columns["selector"]
        order = np.argsort(key, kind="stable")
        columns.reorder(order)
        key = key[order]
        begins = np.flatnonzero(np.diff(key, prepend=-1))
        self.slices = OrderedDict((group, OrderedDict()) for group in self.groups)
        for begin, end in zip(begins, list(begins[1:]) + [len(key)]):
            group, selector = divmod(int(key[begin]), len(self.selectors))
            self.slices[self.groups[group]][self.selectors[selector]] = (int(begin), int(end))
        self.places_of = OrderedDict(
            (group, np.unique(np.concatenate([columns["place"][b:e] for b, e in slices.values()])))
            for group, slices in self.slices.items()
        )

    def __len__(self):
        """Return the number of rows."""
        return len(self.columns)

    def texts(self, i, *names):
        """Return the texts of some columns of a row."""
        return tuple(self.columns.texts[name][self.columns[name][i]] for name in names)

    def selectors_of(self, group):
        """Return the selectors that have rows of a group, by first appearance."""
        return list(self.slices.get(group, ()))

    def pair(self, place):
        """Return the (sequence, pair) of a place."""
        return tuple(self.columns.texts[name][self.place_codes[name][place]] for name in ("sequence", "pair"))

    def place(self, dataset, sequence, pair):
        """Return the number of a place; -1, which no row has, where there is none."""
        texts = {"dataset": dataset, "sequence": sequence, "pair": pair}
        found = [self.place_codes[name] == self.columns.code(name, text) for name, text in texts.items()]
        places = np.flatnonzero(np.all(found, axis=0))
        return int(places[0]) if len(places) else -1

    def places(self, group):
        """Return the places of the pairs of a group, ascending, which is the order of their appearance."""
        return self.places_of.get(group, np.empty(0, np.int32))

    def rows(self, group, selector):
        """Return the Rows of a selector on a group; none where it has none."""
        begin, end = self.slices.get(group, {}).get(selector, (0, 0))
        return Rows(self.columns, begin, end, self.places(group))


class Run:
    """The contents of a run's folder, with the queries that the report needs."""

    def __init__(self, folder, pairs, notes):
        """Hold the RowTable of pairs.csv; the optional files are filled in by read_run."""
        self.folder = folder
        self.name = folder.resolve().name
        self.pairs = pairs
        self.notes = notes
        self.summary, self.failures, self.images, self.scaling = [], [], [], []
        self.remarks, self.pose_summary = [], []
        self.stages = Columns(STAGES_HEADER)
        self.state, self.environment, self.config = {}, {}, None
        self.truth_warnings = []  # sequences whose ground truth another reading explains far better
        self.settings = {}  # top-level keys of config.yaml
        self.sections = []  # experiments of the preset the run was started with; empty without preset
        self.link = ""  # leads from the page to the run's folder: "" or ends in "/"
        self.datasets, self.features, self.seeds = pairs.datasets, pairs.features, pairs.seeds
        self.values = {}  # what pair_values has computed

    def index(self):
        """Build the look-ups; call once all files are read."""
        self.means = OrderedDict()  # group -> selector -> tau -> row of summary.csv
        for row in self.summary:
            selectors = self.means.setdefault(group_of(row), {})
            selectors.setdefault(row["selector"], {})[row["tau_px"]] = row
        self.all_groups = list(OrderedDict.fromkeys(self.pairs.groups + list(self.means)))
        # Pairs of different scenes have no F; a section of their own shows them.
        self.groups = [group for group in self.all_groups if not is_unrelated(group.dataset)]
        names = set(self.pairs.selectors) | {row["selector"] for row in self.summary}
        self.selectors = sorted(names, key=selector_key)
        self.styles = selector_styles(self.selectors)
        # Variants that one line joins are shown under the name that they share.
        for shared in SHARED_NAMES.values():
            names = {shared(s) for s in self.selectors}
            if len(names) < len(self.selectors):
                self.styles.update(selector_styles(names))
        self.left_out = self.find_left_out()  # (group, sequence, pair) without ground-truth inlier -> LeftOut
        self.statuses, self.scenes = {}, {}  # (group, selector) -> Counter, one count per pair and seed
        self.group_taus = {}
        for group, slices in self.pairs.slices.items():
            for selector in slices:
                rows = self.rows(group, selector)
                key = (group, selector)
                self.statuses[key], self.scenes[key] = rows.counts("status", "scene")
                taus = rows["tau_px"]
                self.group_taus.setdefault(group, set()).update(np.unique(taus[np.isfinite(taus)]).tolist())

    def find_left_out(self):
        """Return (group, sequence, pair) -> LeftOut of the pairs without ground-truth inlier, as in the file."""
        columns, out = self.pairs.columns, []
        for group in self.pairs.groups:
            if is_unrelated(group.dataset):
                continue
            found = []
            for begin, end in self.pairs.slices[group].values():
                rows = Rows(columns, begin, end, self.pairs.places_of[group])
                none = (rows["n_ground_truth"] == 0) & ~rows.has("status", "unsupported_input")
                found.append(begin + np.flatnonzero(none))
            found = np.concatenate(found)
            found = found[np.argsort(columns["row"][found])]
            places, first = np.unique(columns["place"][found], return_index=True)
            last = dict(zip(places.tolist(), found[first].tolist()))
            firsts = columns["row"][found[first]].tolist()
            # Only a selection of matches shows whether there is a truth to compare it with.
            selected = found[columns["n_selected"][found] > 0][::-1]
            chosen, latest = np.unique(columns["place"][selected], return_index=True)
            last.update(zip(chosen.tolist(), selected[latest].tolist()))
            for place, appeared in zip(places.tolist(), firsts):
                row = columns.row(last[place])
                out.append((appeared, (group,) + self.pairs.pair(place), row))
        out.sort(key=lambda item: item[0])
        return OrderedDict((place, LeftOut(cause(row), row["n_putative"])) for _, place, row in out)

    def list_setting(self, key):
        """Return a list of config.yaml; empty where there is none."""
        value = self.settings.get(key, [])
        return [item for item in value if isinstance(item, str)] if isinstance(value, list) else []

    def ground_truth_px(self):
        """Return the tolerance of ground-truth inliers, px, as text."""
        try:
            return "%g" % float(self.settings.get("ground_truth_tolerance", GROUND_TRUTH_PX))
        except (TypeError, ValueError):
            return "%g" % GROUND_TRUTH_PX

    def selectors_of(self, group):
        """Return the selectors of a group in the report's order, the baseline last."""
        names = set(self.pairs.selectors_of(group)) | set(self.means.get(group, {}))
        return sorted(names, key=selector_key)

    def taus(self, group):
        """Return the tolerances of a group, ascending; [None] for labelled ground truth."""
        taus = {tau for rows in self.means.get(group, {}).values() for tau in rows}
        return sorted((taus | self.group_taus.get(group, set())) - {None}) or [None]

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

    def rows(self, group, selector):
        """Return the Rows of pairs.csv of a selector on a group."""
        return self.pairs.rows(group, selector)

    def pair_count(self, group):
        """Return the number of pairs of a group that reached the selectors."""
        return len(self.pairs.places(group))

    def pairs_of(self, group):
        """Return the pairs of a group, as (sequence, pair), that reached the selectors, by first appearance."""
        return [self.pairs.pair(place) for place in self.pairs.places(group)]

    def in_sequences(self, group, sequences):
        """Return for each pair of a group whether its sequence is one of these; None stands for all."""
        places = self.pairs.places(group)
        if sequences is None:
            return np.ones(len(places), bool)
        codes = [self.pairs.columns.code("sequence", name) for name in sequences]
        return np.isin(self.pairs.place_codes["sequence"][places], codes)

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
        """Return the values of a column at the tabulated tolerance, repetitions averaged.

        Entry i belongs to pairs_of(group)[i]. It is NaN where the pair has no usable ground truth, the selector is
        unsupported, or there is no value.
        """
        key = (group, selector, column)
        if key not in self.values:
            rows = self.rows(group, selector)
            usable = (rows["n_ground_truth"] != 0) & ~rows.has("status", "unsupported_input")
            self.values[key] = average_by_pair(rows, column, usable & at_tolerance(rows, self.tau(group)))
        return self.values[key]

    def pair_constants(self, group, column):
        """Return a number that is the same in all rows of a pair, such as n_putative; NaN where it is missing."""
        key = (group, None, column)
        if key not in self.values:
            values = np.full(self.pair_count(group), np.nan)
            for selector in self.pairs.selectors_of(group):
                rows = self.rows(group, selector)
                known = np.isfinite(rows[column])
                values[rows.pairs()[known]] = rows[column][known]
            self.values[key] = values
        return self.values[key]

    def first_rows(self, dataset, features):
        """Return the numbers, in `pairs.columns`, of the first row of each pair with these features."""
        seen, out = np.zeros(len(self.pairs.place_codes["pair"]), bool), []
        for group, slices in self.pairs.slices.items():
            if (group.dataset, group.features) != (dataset, features):
                continue
            for begin, end in slices.values():
                places, first = np.unique(self.pairs.columns["place"][begin:end], return_index=True)
                out.append(begin + first[~seen[places]])
                seen[places] = True
        return np.concatenate(out) if out else np.empty(0, int)

    def differences(self, group, first, second):
        """Return the differences in F, first - second, of the pairs of a group that both have."""
        difference = self.pair_values(group, first) - self.pair_values(group, second)
        return difference[np.isfinite(difference)]

    def head_to_head(self, group, first, second):
        """Return the number of pairs on which the first has the higher F, of ties, and of all."""
        a, b = self.pair_values(group, first), self.pair_values(group, second)
        common = np.isfinite(a) & np.isfinite(b)
        return int(np.sum(a[common] > b[common])), int(np.sum(a[common] == b[common])), int(np.sum(common))


def at_tolerance(rows, tau):
    """Return which Rows have a tolerance; None stands for labelled ground truth, which has none."""
    return np.isnan(rows["tau_px"]) if tau is None else rows["tau_px"] == tau


def average_by_pair(rows, column, chosen):
    """Return the mean of a column over the chosen Rows of each pair of their group, NaN without any."""
    chosen = chosen & np.isfinite(rows[column])
    where, count = rows.pairs()[chosen], len(rows.places)
    sums = np.bincount(where, weights=rows[column][chosen], minlength=count)
    counts = np.bincount(where, minlength=count)
    return np.divide(sums, counts, out=np.full(count, np.nan), where=counts > 0)


def group_of(row):
    """Return the dataset x features x preselection a row belongs to."""
    return Group(row["dataset"], row["features"], row["preselection"])
