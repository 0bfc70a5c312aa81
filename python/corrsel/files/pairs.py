"""Putative matches between two images, as every reader of this package returns them."""
import dataclasses
import re
import typing

import numpy as np

#: What the scores of a matcher are.
SCORES = ("confidence", "distance", "none")
LARGEST_FLOAT = float(np.finfo(np.float32).max)  # larger ones would become infinite


class InputError(Exception):
    """Input that cannot be used; the message names the file, the place, the value and the remedy."""


@dataclasses.dataclass
class Truth:
    """Ground truth of a pair: the members that are known, None otherwise."""

    kind: str = "none"  # none, homography, fundamental or labels
    matrix: typing.Optional[np.ndarray] = None  # 3 x 3, px
    labels: typing.Optional[np.ndarray] = None  # (N,) uint32: 0 = outlier, k = member of structure k
    #: K, K', R, t of a point X in the left camera's frame: R X + t in the right one's
    pose: typing.Optional[typing.Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = None


@dataclasses.dataclass
class MatchedPair:  # pylint: disable=too-many-instance-attributes  # the columns of matches
    """Matches between two images. Positions are in px; the centre of the first pixel is (0, 0)."""

    source: str  # file and place, for messages
    key: str  # path of the pair below its dataset, e.g. "scene/1-2"
    left: np.ndarray  # (N, 2) float32
    right: np.ndarray  # (N, 2) float32
    left_name: str = ""  # file of the image below the folder of images; empty: unknown
    right_name: str = ""
    distance: typing.Optional[np.ndarray] = None  # (N,) float32, lower is better
    second_distance: typing.Optional[np.ndarray] = None  # (N,) float32, NaN = none
    probability: typing.Optional[np.ndarray] = None  # (N,) float32, that the match is right, NaN = not known
    left_shape: typing.Optional[
        np.ndarray
    ] = None  # (N, 4) float32: a11 a12 a21 a22 of the local affine frame
    right_shape: typing.Optional[np.ndarray] = None
    left_index: typing.Optional[np.ndarray] = None  # (N,) uint32, numbers of the keypoints
    right_index: typing.Optional[np.ndarray] = None
    left_count: int = 0  # number of keypoints, 0 = unknown
    right_count: int = 0
    left_size: typing.Tuple[int, int] = (0, 0)  # width, height, px; (0, 0) = unknown
    right_size: typing.Tuple[int, int] = (0, 0)
    truth: Truth = dataclasses.field(default_factory=Truth)

    def exchanged(self):
        """Return the pair with left and right exchanged. Ground truth is inverted with it."""
        values = {}
        for field in dataclasses.fields(self):
            for side, other in (("left", "right"), ("right", "left")):
                if field.name.startswith(side):
                    values[field.name] = getattr(self, other + field.name[len(side) :])
        truth = dataclasses.replace(self.truth)
        if truth.kind == "homography":
            truth.matrix = np.linalg.inv(truth.matrix)
        elif truth.kind == "fundamental":
            truth.matrix = truth.matrix.T
        if truth.pose is not None:
            left_camera, right_camera, rotation, translation = truth.pose
            truth.pose = right_camera, left_camera, rotation.T, -rotation.T @ translation
        return dataclasses.replace(self, truth=truth, **values)


def points(values, source, what):
    """Return positions as float32 of shape (N, 2). Raises InputError for other shapes and for NaN."""
    array = np.asarray(values)
    if array.ndim == 3 and array.shape[0] == 1:  # one batch of a network
        array = array[0]
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "fiu":
        raise InputError(
            "%s: %s has the shape %s and the type %s, expected N x 2 numbers: x and y of every keypoint, px"
            % (source, what, "x".join(map(str, array.shape)) or "of one value", array.dtype)
        )
    with np.errstate(over="ignore"):
        positions = array.astype(np.float32)
    wrong = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(wrong):
        raise InputError(
            "%s: %s, row %d is (%s, %s), which is no position; remove it"
            % (source, what, wrong[0], array[wrong[0], 0], array[wrong[0], 1])
        )
    return positions


def vector(values, source, what, length):
    """Return numbers as a vector of this length. Raises InputError otherwise."""
    array = np.asarray(values)
    if array.ndim == 2 and array.shape[0] == 1:
        array = array[0]
    if array.shape != (length,) or array.dtype.kind not in "fiub":
        raise InputError(
            "%s: %s has the shape %s and the type %s, expected %d numbers, one for each match"
            % (source, what, "x".join(map(str, array.shape)) or "of one value", array.dtype, length)
        )
    return array


def matched_rows(indices, counts, source, what):
    """Return the matches of an array of one of two forms: rows of left keypoints, rows of right ones, which row of
    the array each match is, and how many rows the array has.

    indices: (N,), for every left keypoint the number of the right one, -1 = none; or (S, 2), pairs of numbers.
    counts:  number of left and of right keypoints
    """
    array = np.asarray(indices)
    if array.ndim >= 2 and array.shape[0] == 1 and array.shape != (1, 2):
        array = array[0]
    if array.dtype.kind == "f" and (np.isfinite(array) & (array == np.round(array))).all():
        array = array.astype(np.int64)
    if array.dtype.kind not in "iu" or not (array.shape == (counts[0],) or array.shape[1:] == (2,)):
        raise InputError(
            "%s: %s has the shape %s and the type %s, expected %d whole numbers (for every left keypoint the number "
            "of the right one, -1 = none) or N x 2 (pairs of numbers)"
            % (source, what, "x".join(map(str, array.shape)) or "of one value", array.dtype, counts[0])
        )
    array = array.astype(np.int64)
    if array.ndim == 1:
        rows = np.flatnonzero(array != -1)
        pairs = np.stack([rows, array[rows]], axis=1)
    else:
        rows, pairs = np.arange(len(array)), array
    for column, count, side in ((0, counts[0], "left"), (1, counts[1], "right")):
        wrong = np.flatnonzero((pairs[:, column] < 0) | (pairs[:, column] >= count))
        if len(wrong):
            raise InputError(
                "%s: %s, row %d names the %s keypoint %d, but there are %d (numbers 0 to %d); do the matches "
                "belong to these keypoints?"
                % (source, what, rows[wrong[0]], side, pairs[wrong[0], column], count, count - 1)
            )
    return pairs[:, 0], pairs[:, 1], rows, len(array)


def set_scores(pair, values, what, meaning, may_be_nan=False):
    """Keep scores of the matches of a pair, float32, as `meaning` (one of SCORES) says: confidences are probabilities.

    may_be_nan: whether NaN is allowed, which means that a score is not known
    Raises InputError that names the row and the value."""
    if meaning == "none":
        return
    scores = np.asarray(values, np.float64)
    low, high = (0, 1) if meaning == "confidence" else (0, LARGEST_FLOAT)
    good = (scores >= low) & (scores <= high + 1e-3)  # scores of 16 bits are rounded
    wrong = np.flatnonzero(~(good | np.isnan(scores)) if may_be_nan else ~good)
    if len(wrong):
        raise InputError(
            "%s: %s, row %d is %g, expected a %s; --scores distance takes descriptor distances, --scores none "
            "leaves them out"
            % (
                pair.source,
                what,
                wrong[0],
                scores[wrong[0]],
                "confidence from 0 to 1" if meaning == "confidence" else "finite distance from 0",
            )
        )
    if meaning == "confidence":
        pair.probability = np.minimum(scores, 1).astype(np.float32)
    else:
        pair.distance = scores.astype(np.float32)


def image_size(values, source, what):
    """Return width and height, px."""
    array = np.asarray(values).reshape(-1)
    whole = array.shape == (2,) and array.dtype.kind in "fiu"
    if not whole or not all(1 <= side <= 2**20 and side == int(side) for side in array.tolist()):
        raise InputError("%s: %s is %s, expected width and height, px" % (source, what, array.tolist()))
    return int(array[0]), int(array[1])


def distinct_rows(array):
    """Return what numpy.unique(array, axis=0) returns with the first rows and the numbers of the distinct rows."""
    if len(array) == 0:  # numpy before 1.19 refuses it
        return array, np.empty(0, np.intp), np.empty(0, np.intp)
    rows, first, inverse = np.unique(array, axis=0, return_index=True, return_inverse=True)
    return rows, first, inverse.reshape(-1)  # numpy 2.0 returns a column


def parse_size(text):
    """Return width and height of a text such as 640x480."""
    match = re.fullmatch(r"([1-9][0-9]{0,6})x([1-9][0-9]{0,6})", text)
    if match is None:
        raise InputError("size '%s' does not read as WIDTHxHEIGHT in px, e.g. 640x480" % text)
    return int(match.group(1)), int(match.group(2))
