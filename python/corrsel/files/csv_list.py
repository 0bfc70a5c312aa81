"""Lists of matches as CSV: matches.csv of a pair's folder, and the files of a run's folder matches/."""
import csv
import math

import numpy as np

from .pairs import LARGEST_FLOAT, InputError, MatchedPair
from .truth import label_truth

COORDINATES = ("x_left", "y_left", "x_right", "y_right")
SHAPES = tuple(
    "%s_%s" % (entry, side) for side in ("left", "right") for entry in ("a11", "a12", "a21", "a22")
)
KEYPOINTS = ("size_left", "angle_left", "size_right", "angle_right")
INDICES = ("index_left", "index_right")
#: What a selection adds; these columns are no input of a selector.
OF_SELECTION = ("row", "score", "group", "probability")
COLUMNS = COORDINATES + ("distance", "second_distance", "ratio", "match_probability") + KEYPOINTS + INDICES
COLUMNS += ("label",) + SHAPES + OF_SELECTION
FROM_0 = ("distance", "second_distance", "ratio", "match_probability")
#: A selector leaves out matches without a position.
NAN_COLUMNS = ("second_distance", "match_probability", "score") + COORDINATES


def read_columns(path):
    """Return the columns of a list of matches as {name: float64 array}. Raises InputError that names the file, the
    line, the column and the value."""
    try:
        with open(str(path), encoding="utf-8-sig", newline="") as file:
            lines = [
                (number, row) for number, row in enumerate(csv.reader(file), 1) if any(map(str.strip, row))
            ]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError("%s cannot be read as CSV: %s" % (path, error)) from error
    if not lines:
        raise InputError(
            "%s is empty; its first line must name the columns, e.g. %s" % (path, ",".join(COORDINATES))
        )
    names = [name.strip().lstrip("# ") for name in lines[0][1]]
    _check_names(path, lines[0][0], names)
    for number, row in lines[1:]:
        if len(row) != len(names):
            raise InputError(
                "%s, line %d has %d values, the first line names %d columns; separate the values by commas"
                % (path, number, len(row), len(names))
            )
    numbers = [number for number, _ in lines[1:]]
    columns = list(zip(*(row for _, row in lines[1:]))) or [()] * len(names)
    return {name: _column(path, name, numbers, texts) for name, texts in zip(names, columns)}


def read_csv(path, key):
    """Return the MatchedPair of a list of matches."""
    columns = read_columns(path)
    pair = matched_pair(columns, str(path), key)
    if "label" in columns:
        pair.truth = label_truth(columns["label"], "%s: column label" % path)
    return pair


def matched_pair(columns, source, key):
    """Return the MatchedPair of columns that read_columns() has returned."""

    def floats(*names):
        with np.errstate(over="ignore"):  # infinite positions are refused later
            return np.stack([columns[name] for name in names], axis=-1).astype(np.float32)

    pair = MatchedPair(source, key, floats("x_left", "y_left"), floats("x_right", "y_right"))
    if "distance" in columns:
        pair.distance = columns["distance"].astype(np.float32)
    if "second_distance" in columns:
        pair.second_distance = columns["second_distance"].astype(np.float32)
    if "ratio" in columns:
        ratio = columns["ratio"]
        if pair.distance is None:
            pair.distance, pair.second_distance = ratio.astype(np.float32), np.ones(len(ratio), np.float32)
        else:
            safe = np.where(ratio > 0, ratio, 1)
            pair.second_distance = np.where(ratio > 0, columns["distance"] / safe, 1).astype(np.float32)
    if "match_probability" in columns:
        pair.probability = columns["match_probability"].astype(np.float32)
    if INDICES[0] in columns:
        pair.left_index, pair.right_index = (columns[name].astype(np.uint32) for name in INDICES)
    if SHAPES[0] in columns:
        pair.left_shape, pair.right_shape = floats(*SHAPES[:4]), floats(*SHAPES[4:])
    elif KEYPOINTS[0] in columns:
        pair.left_shape, pair.right_shape = (
            similarity_shapes(columns["size_" + side] / 2, np.radians(columns["angle_" + side]))
            for side in ("left", "right")
        )
    return pair


def similarity_shapes(radius, angle):
    """Return a11 a12 a21 a22 of frames that are a rotation by `angle`, radians, times `radius`, px: (N, 4)."""
    sine, cosine = radius * np.sin(angle), radius * np.cos(angle)
    return np.stack([cosine, -sine, sine, cosine], axis=-1).astype(np.float32)


def _check_names(path, line, names):
    for name in names:
        if name not in COLUMNS:
            raise InputError(
                "%s, line %d: '%s' is not a column of a list of matches; known columns: %s"
                % (path, line, name, ", ".join(COLUMNS))
            )
        if names.count(name) > 1:
            raise InputError(
                "%s, line %d: the column '%s' stands there twice; remove one" % (path, line, name)
            )
    for group, optional in ((COORDINATES, False), (KEYPOINTS, True), (INDICES, True), (SHAPES, True)):
        missing = [name for name in group if name not in names]
        if missing and not (optional and len(missing) == len(group)):
            raise InputError(
                "%s, line %d: the columns %s are used together, but %s is missing"
                % (path, line, ", ".join(group), ", ".join(missing))
            )
    if "ratio" in names and "second_distance" in names:
        raise InputError(
            "%s, line %d: 'ratio' and 'second_distance' state the same; remove one" % (path, line)
        )
    if "second_distance" in names and "distance" not in names:
        raise InputError("%s, line %d: 'second_distance' needs the column 'distance'" % (path, line))


def _column(path, name, lines, texts):
    """Return the numbers of a column; lines are those of the file that the texts stand in."""
    try:
        values = np.fromiter(map(float, texts), np.float64, len(texts))
    except ValueError:
        for line, text in zip(lines, texts):
            try:
                float(text)
            except ValueError as error:
                raise InputError(
                    "%s, line %d, column '%s': '%s' is not a number" % (path, line, name, text.strip())
                ) from error
        raise
    whole = name in INDICES or name in ("label", "row")
    from_0 = whole or name in FROM_0 or name.startswith("size")
    good = values >= (0 if from_0 else -math.inf)
    if from_0 and not whole:
        good &= values <= (1 if name == "match_probability" else LARGEST_FLOAT)
    if whole:
        good &= (values == np.floor(values)) & (values < 2**32)
    if name in NAN_COLUMNS:
        good |= np.isnan(values)
    wrong = np.flatnonzero(~good)
    if len(wrong):
        expected = "a whole number from 0" if whole else "a finite number from 0" if from_0 else "a number"
        expected = "a number from 0 to 1" if name == "match_probability" else expected
        raise InputError(
            "%s, line %d, column '%s': '%s' is not %s"
            % (path, lines[wrong[0]], name, texts[wrong[0]].strip(), expected)
        )
    return values
