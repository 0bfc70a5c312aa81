"""The matches that a benchmark run has saved (save_matches), and their conversion to NPZ files and databases."""
import csv
import dataclasses
import functools

import numpy as np

from .colmap import replace_matches, write_database
from .csv_list import INDICES, matched_pair, read_columns
from .pairs import InputError, distinct_rows

INDEX = "index.csv"
NO_NUMBER = -1  # of a keypoint whose matches have no feature numbers


@dataclasses.dataclass(frozen=True)
class Saved:  # pylint: disable=too-many-instance-attributes  # the columns of a file
    """A row of matches/index.csv."""

    file: str
    putative: str
    dataset: str
    sequence: str
    pair: str
    features: str
    preselection: str
    selector: str
    seed: str
    status: str
    n_putative: int
    n_selected: int
    model_kind: str
    model: str
    left_image: str
    right_image: str
    left_size: tuple
    right_size: tuple


class Run:
    """The folder matches/ of a run."""

    def __init__(self, folder):
        """Read the list of selections. Raises InputError where the run has none or the list is damaged."""
        self.folder = folder / "matches"
        path = self.folder / INDEX
        if not path.is_file():
            raise InputError(
                "%s is missing: %s holds no saved matches; run the benchmark with save_matches:=csv"
                % (path, folder)
            )
        try:
            with open(str(path), encoding="utf-8", newline="") as file:
                rows = list(csv.DictReader(file))
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise InputError("%s cannot be read as CSV: %s" % (path, error)) from error
        self.selections = []
        names = {}
        for number, row in enumerate(rows, 2):
            try:
                self.selections.append(_saved(row, names))
            except (AttributeError, KeyError, TypeError, ValueError) as error:
                raise InputError(
                    "%s, line %d is damaged (%r); resume the run, which writes it again"
                    % (path, number, error)
                ) from error
        if not self.selections:
            raise InputError("%s lists no selection: the run has no finished pair" % path)

    def putative(self, saved):
        """Return the MatchedPair of the putative matches of a selection."""
        pair = self._putative(saved.putative)
        if len(pair.left) != saved.n_putative:
            raise InputError(
                "%s holds %d matches, but %s states %d; the run was cut off: resume it"
                % (pair.source, len(pair.left), INDEX, saved.n_putative)
            )
        return pair

    @functools.lru_cache(maxsize=4)  # the selections of a pair follow each other
    def _putative(self, name):
        return matched_pair(self._columns(name), str(self.folder / name), "")

    def selected(self, saved):
        """Return the columns of a selection, and its rows among the putative matches."""
        columns = self._columns(saved.file)
        if "row" not in columns:
            raise InputError("%s has no column row" % (self.folder / saved.file))
        rows = columns["row"].astype(np.int64)
        if len(rows) != saved.n_selected or (rows >= saved.n_putative).any():
            raise InputError(
                "%s holds %d matches of %d, but %s states %d selected ones; the run was cut off: resume it"
                % (self.folder / saved.file, len(rows), saved.n_putative, INDEX, saved.n_selected)
            )
        return columns, rows

    def _columns(self, name):
        return read_columns(self.folder / name)


def _saved(row, names):
    def size(side):
        return int(row[side + "_width"]), int(row[side + "_height"])

    def image(side):
        """Images without a name are called like the first pair in which they occur."""
        name = row[side + "_image"]
        fallback = "/".join((row["dataset"], row["sequence"], row["pair"], side))
        return names.setdefault(name, fallback) if name.startswith("#") else name or fallback

    values = {field.name: row.get(field.name) for field in dataclasses.fields(Saved)}
    values.update(left_image=image("left"), right_image=image("right"))
    values.update(n_putative=int(row["n_putative"]), n_selected=int(row["n_selected"]))
    values.update(left_size=size("left"), right_size=size("right"))
    if None in values.values():
        raise KeyError([name for name, value in values.items() if value is None][0])
    if values["file"].count("/") != 6:
        raise ValueError("file is '%s', expected csv/ and six names" % values["file"])
    if len(values["model"].split()) not in (0, 9):
        raise ValueError("model is '%s', expected nine numbers or none" % values["model"])
    return Saved(**values)


def keypoints_of(sides):
    """Return the keypoints of an image, and for each of its sides the rows of keypoints of the matches.

    sides: [(positions, numbers or None, shapes or None)]: what the pairs of the image hold of it
    Keypoints with equal number and equal position are one keypoint; they are sorted by number and then by position.
    Returns positions (K, 2), numbers (K,), shapes (K, 4) or None, [rows (N,) of each side].
    """
    tables = []
    for positions, numbers, _ in sides:
        number = (
            np.full(len(positions), NO_NUMBER, np.float64) if numbers is None else numbers.astype(np.float64)
        )
        tables.append(np.column_stack([number, positions.astype(np.float64)]))
    unique, first, inverse = distinct_rows(np.concatenate(tables))
    shapes = None
    if all(shape is not None for _, _, shape in sides):
        shapes = np.concatenate([shape for _, _, shape in sides])[first]
    ends = np.cumsum([len(table) for table in tables])[:-1]
    return unique[:, 1:].astype(np.float32), unique[:, 0].astype(np.int64), shapes, np.split(inverse, ends)


def selection_arrays(putative, columns, rows, **described):
    """Return the arrays of an NPZ file by their keys (docs/matches.md), but for the sizes of the images.

    putative    positions and, where they are known, feature numbers: left, right, left_index, right_index
    columns     of the kept matches, by the names of a selector's CSV file
    rows        the kept matches among the putative ones
    described   values of further keys
    """
    left = keypoints_of([(putative.left, putative.left_index, None)])
    right = keypoints_of([(putative.right, putative.right_index, None)])
    matches = np.column_stack([left[3][0], right[3][0]]).astype(np.int32)
    mask = np.zeros(len(matches), np.uint8)
    mask[rows] = 1
    arrays = {
        "keypoints0": left[0],
        "keypoints1": right[0],
        "matches": matches[rows],
        "putative_matches": matches,
        "mask": mask,
        "score": columns.get("score", np.full(len(rows), np.nan)).astype(np.float32),
        "group": columns.get("group", np.full(len(rows), -1)).astype(np.int32),
    }
    if INDICES[0] in columns:
        arrays.update(index0=left[1].astype(np.uint32), index1=right[1].astype(np.uint32))
    for name in ("distance", "match_probability"):
        if name in columns:
            arrays[name] = columns[name].astype(np.float32)
    return dict(arrays, **described)


def write_npz(run, output):
    """Write one NPZ file for each selection, beside which it has the same path. Return the number of files."""
    for saved in run.selections:
        putative = run.putative(saved)
        columns, rows = run.selected(saved)
        arrays = selection_arrays(
            putative,
            columns,
            rows,
            model=np.array(saved.model.split() or [np.nan] * 9, np.float64).reshape(3, 3),
            model_kind=saved.model_kind,
            status=saved.status,
            image0=saved.left_image,
            image1=saved.right_image,
        )
        for name, size in (("image_size0", saved.left_size), ("image_size1", saved.right_size)):
            if size != (0, 0):
                arrays[name] = np.array(size, np.int32)
        path = (output / _place(saved)).with_suffix(".npz")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            np.savez_compressed(str(path), **arrays)
        except OSError as error:
            raise InputError("cannot write %s: %s" % (path, error)) from error
    return len(run.selections)


def write_colmap(run, output, size=(0, 0), source=None):
    """Write one database for each selector, dataset, kind of features, preselection and seed.

    size:   of images whose size is not known, px
    source: a database whose cameras, images and keypoints are kept
    Returns the number of databases, the number of selections that are left out because both images are the same, and
    the number of lines that the lists of pairs lack because a name has a space, at which COLMAP would split it.
    """
    groups, same, spaced = {}, 0, 0
    for saved in run.selections:
        cell = (saved.dataset, saved.features, saved.preselection)
        same += saved.left_image == saved.right_image
        if saved.left_image != saved.right_image:
            groups.setdefault(cell, {}).setdefault((saved.selector, saved.seed), []).append(saved)
    count = 0
    for selectors in groups.values():
        images = (
            {} if source is not None else _images(run, [s for part in selectors.values() for s in part], size)
        )
        for group in selectors.values():
            path = _database_path(output, group[0])
            names = sorted({(saved.left_image, saved.right_image) for saved in group})
            listed = [pair for pair in names if len(" ".join(pair).split()) == 2]
            spaced += len(names) - len(listed)
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.with_suffix(".pairs.txt").write_text(
                    "".join("%s %s\n" % pair for pair in listed), encoding="utf-8"
                )
            except OSError as error:
                raise InputError("cannot write %s: %s" % (path, error)) from error
            if source is not None:
                replace_matches(source, path, _numbered_matches(run, group))
            else:
                _write_own(run, group, images, path)
            count += 1
    return count, same, spaced


def _database_path(output, saved):
    """Return the path of a database: DATASET/FEATURES/PRESELECTION/SELECTOR.db."""
    dataset, _, _, features, preselection, name = _place(saved).split("/")
    return (output / dataset / features / preselection / name).with_suffix(".db")


def _place(saved):
    """Return the path of a selection's file below the folder of its form."""
    return saved.file.split("/", 1)[1]


def _images(run, selections, size):
    """Return {name: (number, size, positions, shapes, {(file, side): rows})} of the images of some selections."""
    sides, sizes, places = {}, {}, {}
    for saved in selections:
        for side in ("left", "right"):
            name = getattr(saved, side + "_image")
            own, before = getattr(saved, side + "_size"), sizes.get(name, (0, 0))
            if own != before and (0, 0) not in (own, before):
                raise InputError(
                    "%s: the image %s has %dx%d px, but %dx%d px in an earlier pair; give different images different "
                    "names" % ((saved.file, name) + own + before)
                )
            sizes[name] = max(own, before)
            if (saved.putative, side) not in places.setdefault(name, []):
                places[name].append((saved.putative, side))
                pair = run.putative(saved)
                shown = (getattr(pair, side), getattr(pair, side + "_index"), getattr(pair, side + "_shape"))
                sides.setdefault(name, []).append(shown)
    result = {}
    for number, name in enumerate(sides):
        known = size if sizes[name] == (0, 0) else sizes[name]
        if known == (0, 0):
            raise InputError("the size of the image %s is not known; give it by --size WIDTHxHEIGHT" % name)
        positions, _, shapes, rows = keypoints_of(sides[name])
        result[name] = (number, known, positions, shapes, dict(zip(places[name], rows)))
    shapes_known = all(image[3] is not None for image in result.values())
    return {
        name: (number, known, positions, shapes if shapes_known else None, rows)
        for name, (number, known, positions, shapes, rows) in result.items()
    }


def _write_own(run, group, images, path):
    matches = []
    for saved in group:
        _, rows = run.selected(saved)
        left, right = images[saved.left_image], images[saved.right_image]
        both = [image[4][(saved.putative, side)][rows] for image, side in ((left, "left"), (right, "right"))]
        matches.append((left[0], right[0], np.column_stack(both)))
    listed = [(name, known, positions, shapes) for name, (_, known, positions, shapes, _) in images.items()]
    write_database(path, listed, matches)


def _numbered_matches(run, group):
    matches = []
    for saved in group:
        columns, _ = run.selected(saved)
        if INDICES[0] not in columns:
            raise InputError(
                "%s has no numbers of keypoints, so that its matches cannot refer to those of another database"
                % (run.folder / saved.file)
            )
        matches.append(
            (saved.left_image, saved.right_image, np.column_stack([columns[name] for name in INDICES]))
        )
    return matches
