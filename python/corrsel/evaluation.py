"""Precision, recall and F of selections against ground truth; errors of poses and homographies."""

from collections import namedtuple

import numpy as np

from . import _arrays, _core
from .selectors import Matches


class Evaluation:
    """How right a selection is. Matches whose truth is unknown take part in no count.

    n_putative       matches
    n_ground_truth   ground-truth inliers: matches with an error of at most ground_truth_tolerance
    n_selected       selected matches

    Numbers for one tolerance tau and for labels, arrays with one element per tolerance otherwise:

    tolerance        tau, px; NaN for labels
    n_correct        selected matches with an error of at most tau
    precision        n_correct / n_selected; NaN where nothing is selected
    recall_paper     n_correct / n_ground_truth, the paper's recall; NaN where there is no inlier
    recall_same_tau  n_correct / matches with an error of at most tau; NaN where there is none
    f_paper, f_same_tau   harmonic mean of precision and that recall: 0 where nothing correct is selected, NaN where
                     the recall is undefined
    """

    __slots__ = (
        "n_putative",
        "n_ground_truth",
        "n_selected",
        "tolerance",
        "n_correct",
        "precision",
        "recall_paper",
        "recall_same_tau",
        "f_paper",
        "f_same_tau",
    )

    def __init__(self, **values):
        for name in self.__slots__:
            setattr(self, name, values[name])

    def __repr__(self):
        columns = (self.tolerance, self.precision, self.recall_paper, self.f_paper)
        rows = "; ".join(
            "tolerance %g: P %.3f, R %.3f, F %.3f" % row for row in zip(*map(np.atleast_1d, columns))
        )
        return "<corrsel.Evaluation: %d of %d matches selected, %d inliers; %s>" % (
            self.n_selected,
            self.n_putative,
            self.n_ground_truth,
            rows,
        )


def ground_truth_errors(matches, *, homography=None, fundamental=None, labels=None, disparity=None):
    """Return the ground-truth error of every match: N, float64, px. Give exactly one kind of ground truth.

    matches       Matches
    homography    3 x 3, x' ~ H x: the error is the forward transfer distance. The sign of the matrix is chosen so that
                  the centre of the left image (of the matches, where left_size is None) lies before the camera; points
                  behind it have the error infinity
    fundamental   3 x 3, x'^T F x = 0: distance of the right point to its epipolar line
    labels        N integers, 0 = outlier: the error is 0, or infinity where the label is 0
    disparity     height x width of the left image, left x minus right x, px, NaN = unknown: distance to the predicted
                  point; NaN where the disparity is unknown

    Matches with a coordinate that is not finite have the error infinity.

    Raises TypeError or ValueError for arrays of another dtype or shape, naming the argument.
    """
    return _errors(matches, _truth(homography, fundamental, labels, disparity))


def evaluate(
    matches,
    mask,
    *,
    homography=None,
    fundamental=None,
    labels=None,
    disparity=None,
    tolerance=None,
    ground_truth_tolerance=None
):
    """Return the Evaluation of a selection: precision, recall and F. Give exactly one kind of ground truth.

    matches       Matches
    mask          the selected ones: N, bool or uint8, e.g. the mask of a Selection
    homography, fundamental, labels, disparity    see ground_truth_errors()
    tolerance     error up to which a selected match is correct, px, or a list of them; None = 1, 2, ..., 10; labels
                  need none
    ground_truth_tolerance   error up to which a match is a ground-truth inlier, px; None = 10

    Raises TypeError or ValueError for arrays of another dtype or shape, naming the argument.
    """
    truth = _truth(homography, fundamental, labels, disparity)
    errors = _errors(matches, truth)
    values = _core.evaluate(
        truth[0],
        errors,
        _arrays.mask("mask", mask, len(matches)),
        None if tolerance is None else _tolerances(tolerance),
        None if ground_truth_tolerance is None else float(ground_truth_tolerance),
    )
    if truth[0] == "labels" or np.ndim(tolerance) == 0 and tolerance is not None:
        values = {
            name: value.item() if isinstance(value, np.ndarray) else value for name, value in values.items()
        }
    return Evaluation(**values)


class PoseErrors(namedtuple("PoseErrors", "rotation translation pose")):
    """How far an estimated pose is from the true one, degrees.

    rotation      angle of the rotation between both, 0 to 180
    translation   angle between the directions of translation, 0 to 90; NaN where one of them is zero
    pose          the larger one; 180 where only the estimated translation is zero
    """

    __slots__ = ()


def pose_errors(rotation, translation, true_rotation, true_translation):
    """Return the PoseErrors of an estimated pose, as SuperGlue's evaluation defines them.

    A point X of the left camera is R X + t in the frame of the right one.

    rotation, true_rotation         3 x 3, R
    translation, true_translation   3 numbers, t, of any length; its sign is not compared. Where the true translation is
                                    zero, the pose error is the rotation error

    Raises TypeError or ValueError for arrays of another dtype or shape, and for a matrix that is no rotation.
    """
    return PoseErrors(
        *_core.pose_errors(
            _arrays.matrix("rotation", rotation),
            _translation("translation", translation),
            _arrays.matrix("true_rotation", true_rotation),
            _translation("true_translation", true_translation),
        )
    )


def error_auc(errors, thresholds=None):
    """Return the area under the curve of recall against error up to each threshold, divided by it: float64, 0 to 1.

    The curve connects the points (i-th smallest error, i / N), as SuperGlue's pose_auc does.

    errors       errors of all pairs, in degrees or px; a failed pair is 180 degrees, infinity, or NaN, which counts as
                 infinity
    thresholds   None = 5, 10 and 20 degrees

    NaN without errors. Raises ValueError for negative errors and for thresholds that are not above 0.
    """
    values = _errors_of_pairs(errors)
    values = np.where(np.isnan(values), np.inf, values)
    return np.array(
        [_core.error_auc(values, t) for t in _thresholds(thresholds, _core.POSE_THRESHOLDS)], dtype=np.float64
    )


def mean_interval(values):
    """Return the mean of N >= 1 finite values and the bounds of its 95 % percentile bootstrap interval.

    2000 resamples with a fixed seed (B. Efron, Annals of Statistics 1979): the same values in the same order give the
    same interval. With one value the bounds are that value. Raises ValueError for other input. O(2000 N).
    """
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1 or len(array) == 0 or not np.isfinite(array).all():
        raise ValueError(
            "values has shape %s; needed: a list of finite numbers, at least one" % (array.shape,)
        )
    return _core.mean_interval(array)


def mean_average_accuracy(errors, thresholds=None):
    """Return the mean over the thresholds of the share of errors below them: 0 to 1, NaN without errors.

    With the default, 1, 2, ..., 10 degrees, it is the mAA of the Image Matching Benchmark.

    errors       as for error_auc()
    thresholds   None = 1, 2, ..., 10
    """
    limits = _thresholds(thresholds, _core.ACCURACY_THRESHOLDS)
    values = [_core.threshold_accuracy(error, limits) for error in _errors_of_pairs(errors)]
    return float(np.mean(values)) if values else float("nan")


def epipolar_errors(matches, rotation, translation, left_camera, right_camera):
    """Return the squared symmetric epipolar distance of every match in normalised coordinates: N, float64.

    The share of the selected matches below 1e-4 is the epipolar precision:
    (corrsel.epipolar_errors(matches[mask], R, t, K, K) < 1e-4).mean()

    matches                     Matches
    rotation, translation       the true pose, see pose_errors(); a translation of zero has no epipolar lines
    left_camera, right_camera   3 x 3 camera matrices [fx s cx; 0 fy cy; 0 0 1], px

    Raises TypeError or ValueError naming the argument.
    """
    return _core.epipolar_errors(
        _require_matches(matches),
        _arrays.matrix("rotation", rotation),
        _translation("translation", translation),
        _arrays.matrix("left_camera", left_camera),
        _arrays.matrix("right_camera", right_camera),
    )


def corner_error(homography, true_homography, left_size):
    """Return the mean distance, px, of the corners of the left image under both homographies: HPatches' measure.

    homography, true_homography   3 x 3, x' ~ H x, of any scale
    left_size                     (width, height), px

    It is infinite where the estimate puts a corner behind the camera. Raises TypeError or ValueError naming the
    argument.
    """
    return _core.corner_error(
        _arrays.matrix("homography", homography),
        _arrays.matrix("true_homography", true_homography),
        _arrays.size("left_size", left_size),
    )


def _translation(name, values):
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise TypeError("%s has dtype %s; needed: real numbers" % (name, array.dtype))
    if array.size != 3:
        raise ValueError("%s has shape %s; needed: three numbers" % (name, array.shape))
    array = array.astype(np.float64).ravel()
    if not np.isfinite(array).all():
        raise ValueError("%s holds a number that is not finite" % name)
    return array


def _errors_of_pairs(values):
    array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if array.ndim != 1 or (array < 0).any():
        raise ValueError("errors is %r; needed: a list of numbers from 0" % (values,))
    return array


def _thresholds(values, default):
    array = np.atleast_1d(np.asarray(default if values is None else values, dtype=np.float64))
    if array.ndim != 1 or not (array > 0).all():
        raise ValueError("thresholds is %r; needed: a number or a list of numbers above 0" % (values,))
    return array


def _truth(homography, fundamental, labels, disparity):
    """Return the kind and the value of what is given."""
    values = {
        "homography": homography,
        "fundamental": fundamental,
        "labels": labels,
        "disparity": disparity,
    }
    given = [kind for kind, value in values.items() if value is not None]
    if len(given) != 1:
        raise TypeError(
            "needed: exactly one of homography, fundamental, labels and disparity; given: %s"
            % (", ".join(given) or "none")
        )
    return given[0], values[given[0]]


def _require_matches(matches):
    if not isinstance(matches, Matches):
        raise TypeError(
            "matches is %s; needed: corrsel.Matches, e.g. corrsel.Matches(left, right)"
            % type(matches).__name__
        )
    return matches


def _errors(matches, truth):
    _require_matches(matches)
    kind, value = truth
    if kind == "labels":
        value = _arrays.numbers(kind, value, "one label per match", len(matches))
    elif kind == "disparity":
        value = _arrays.floats(kind, value, (None, None), "height and width of the left image")
    else:
        value = _arrays.matrix(kind, value)
    return _core.ground_truth_errors(matches, kind, value)


def _tolerances(values):
    array = np.atleast_1d(values)
    if array.dtype.kind not in "fiu":
        raise TypeError("tolerance has dtype %s; needed: real numbers" % array.dtype)
    if array.ndim != 1 or not (array >= 0).all():
        raise ValueError("tolerance is %r; needed: a number or a list of numbers from 0, px" % (values,))
    return array.astype(np.float64)
