"""Functions with the signatures of OpenCV's: a program that calls cv2 changes one line.

    from corrsel.opencv import findHomography

    homography, mask = findHomography(points_left, points_right, cv2.RANSAC, 3.0)

    findHomography, findFundamentalMat, findEssentialMat   a model and the mask of its inliers
    matchGMS                                               cv2.xfeatures2d.matchGMS

`method` is one of cv2's numbers or the name of a selector, optionally with a preset and options, e.g. "usac" or
"auto[max_seconds=0.01]". Among cv2's numbers, LMEDS calls "acransac", which needs no threshold either, and
RANSAC, RHO and USAC_* by "usac". A selector without a model of the wanted kind, e.g. "lpm", chooses among the
matches, and "usac" fits the model to those that it kept.

Unlike cv2, these functions never raise because of data: too few points, NaN or a degenerate configuration give None and
a mask of zeros. So does a selector that is not sure of its result; programs should check for None. Results are the
same bits in every run. OpenCV itself is not needed.
"""

import functools

import numpy as np

from . import _arrays, _core, _doors
from .camera import Camera
from .selectors import Matches, Selector

__all__ = ["findEssentialMat", "findFundamentalMat", "findHomography", "matchGMS"]

#: Selectors by the numbers of cv2: LMEDS; RANSAC, RHO, and USAC_DEFAULT to USAC_MAGSAC.
_METHODS = {4: "acransac", **dict.fromkeys((8, 16, *range(32, 39)), "usac")}
#: Methods of cv2 that reject nothing.
_ALL_POINTS = {0: "0", 1: "FM_7POINT", 2: "FM_8POINT"}
#: What the selectors' max_iterations = 0 stands for.
_HYPOTHESES = {"homography": 60000, "fundamental": 40000, "essential": 20000}
#: Least confidence of a result for a method of cv2. Random matches have 0; six exact ones of a plane have 4.
_CONFIDENCE = 1.0
#: Cameras with a smaller focal length, px, are taken to be those of normalised coordinates.
_NORMALISED = 10.0


def findHomography(
    srcPoints,
    dstPoints,
    method="auto",
    ransacReprojThreshold=3.0,
    mask=None,
    maxIters=2000,
    confidence=0.995,
):
    """Return the homography from srcPoints to dstPoints and the mask of its inliers, as cv2.findHomography does.

    srcPoints, dstPoints    px: N x 2 or N x 1 x 2, real or whole numbers, kept in single precision
    method                  a number of cv2 or the name of a selector; see the module
    ransacReprojThreshold   largest error of an inlier, px; 0 = the selector's own. With a number of cv2 it is the error
                            in the right image, otherwise what the selector measures: the smaller one of both images
                            with "auto". Selectors that find their threshold themselves ignore it
    mask                    an array of N x 1, uint8, that receives the mask, too; or None
    maxIters, confidence    limits of the search. They have an effect where they ask for more than the selector's own

    Returns (H, mask): H is 3 x 3, float64, with H[2][2] = 1, or None; mask is N x 1, uint8, 1 = inlier. The time is that
    of the selector.

    Raises TypeError and ValueError for points of another shape, for a method that is unknown, needs more than positions
    or rejects no matches, and for a threshold or a confidence out of its range.
    """
    matches = Matches(*_both(srcPoints, dstPoints, "srcPoints", "dstPoints"))
    search = _Search("homography", method, ransacReprojThreshold, maxIters, confidence)
    return _answer(*search.run(matches), mask)


def findFundamentalMat(
    points1, points2, method="auto", ransacReprojThreshold=3.0, confidence=0.99, maxIters=1000, mask=None
):
    """Return the fundamental matrix F, x2^T F x1 = 0, and the mask of its inliers, as cv2.findFundamentalMat does.

    points1, points2        px: N x 2 or N x 1 x 2, real or whole numbers, kept in single precision
    method                  a number of cv2 or the name of a selector; see the module
    ransacReprojThreshold   largest Sampson distance of an inlier, px; 0 = the selector's own
    confidence, maxIters    as for findHomography(). As in cv2, the sixth argument may be the mask instead
    mask                    an array of N x 1, uint8, that receives the mask, too; or None

    Returns (F, mask): F is 3 x 3, float64, with F[2][2] = 1 where it is not 0, or None; mask is N x 1, uint8.

    Raises what findHomography() raises.
    """
    if isinstance(maxIters, np.ndarray):
        mask, maxIters = maxIters, 0
    matches = Matches(*_both(points1, points2, "points1", "points2"))
    search = _Search("fundamental", method, ransacReprojThreshold, maxIters, confidence)
    return _answer(*search.run(matches), mask)


def findEssentialMat(points1, points2, *arguments, **keywords):
    """Return the essential matrix E, d2^T E d1 = 0, and the mask of its inliers, as cv2.findEssentialMat does.

    The arguments after the points are one of cv2's lists:

        cameraMatrix, method="pose", prob=0.999, threshold=1.0, maxIters=1000, mask=None
        focal=1.0, pp=(0, 0), method="pose", prob=0.999, threshold=1.0, maxIters=1000, mask=None
        cameraMatrix1, distCoeffs1, cameraMatrix2, distCoeffs2, method="pose", prob=0.999, threshold=1.0, mask=None

    points1, points2   px, distorted as in the images: N x 2 or N x 1 x 2, real or whole numbers
    method             a number of cv2 or the name of a selector; see the module. "pose" and "auto" also find out that
                       the camera did not move, and then return None
    prob, maxIters     as for findHomography()
    threshold          largest error of an inlier, tangent Sampson, px; in units of the focal length where that is 1

    Returns (E, mask): E is 3 x 3, float64, of norm 1 as in cv2, or None; mask is N x 1, uint8. cv2.recoverPose() takes both.

    Raises what findHomography() raises, and ValueError for a camera that corrsel.Camera.from_opencv() refuses.
    """
    cameras, (method, prob, threshold, maxIters, mask) = _calibration(arguments, keywords)
    focal = cameras[0][0][0, 0]
    scale = 1000 / focal if 0 < focal < _NORMALISED else 1.0
    zoom = np.diag([scale, scale, 1])
    left, right = (Camera.from_opencv(zoom @ matrix, distortion) for matrix, distortion in cameras)
    points = (scale * side for side in _both(points1, points2, "points1", "points2"))
    matches = Matches(*points, left_camera=left, right_camera=right)
    search = _Search("essential", method, scale * threshold, maxIters, prob)
    return _answer(*search.run(matches), mask)


def matchGMS(
    size1,
    size2,
    keypoints1,
    keypoints2,
    matches1to2,
    withRotation=False,
    withScale=False,
    thresholdFactor=6.0,
):
    """Return the matches that the selector "gms" keeps, as cv2.xfeatures2d.matchGMS does.

    size1, size2              sizes of the images (width, height), px
    keypoints1, keypoints2    sequences of cv2.KeyPoint, or of anything with pt
    matches1to2               sequence of cv2.DMatch, or of anything with queryIdx and trainIdx
    withRotation, withScale   whether the second image may be turned, or larger or smaller
    thresholdFactor           larger keeps fewer matches

    Returns a list of those elements of matches1to2 that are kept, in their order. O(N).

    Raises IndexError for a match of a keypoint that does not exist, ValueError for a size or factor out of its range.
    """
    matches1to2 = list(matches1to2)
    left = [keypoints1[match.queryIdx].pt for match in matches1to2]
    right = [keypoints2[match.trainIdx].pt for match in matches1to2]
    selection = Matches(
        np.array(left, np.float32).reshape(-1, 2),
        np.array(right, np.float32).reshape(-1, 2),
        left_size=size1,
        right_size=size2,
    ).select("gms", rotation=bool(withRotation), scale=bool(withScale), alpha=float(thresholdFactor))
    return [match for match, keep in zip(matches1to2, _doors.kept(selection)) if keep]


class _Search:
    """A model of one kind, found by the selector that a call asks for."""

    def __init__(self, kind, method, threshold, iterations, confidence):
        self.kind = kind
        limits = (max(float(threshold), 0.0), int(iterations or 0), float(confidence))
        self.selector = _selector(_name_of(method), kind, not isinstance(method, str), *limits)
        self.fit = _selector("usac", kind, True, *limits)

    def run(self, matches):
        """Return the model, or None, and the mask."""
        selection = self.selector.select(matches)
        mask = _doors.kept(selection)
        model = self._model_of(selection)
        if model is not None and selection.group is not None:
            mask = mask & (selection.group == 0)
        if model is None and selection.pose is None and mask.any():
            rows = np.flatnonzero(mask)
            fitted = self.fit.select(matches[rows])
            model, mask = self._model_of(fitted), np.zeros_like(mask)
            mask[rows] = _doors.kept(fitted)
        if model is None or not mask.any():
            return None, np.zeros_like(mask)
        return self._scaled(model), mask

    def _model_of(self, selection):
        pose = selection.pose
        if self.kind == "essential" and pose is not None:
            x, y, z = pose.translation
            return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ pose.rotation if x or y or z else None
        return selection.model if selection.model_kind == self.kind else None

    def _scaled(self, model):
        """Return the model with the scale that cv2 gives it."""
        if self.kind == "essential":
            return model / np.linalg.norm(model)
        return model / model[2, 2] if model[2, 2] != 0 else model


@functools.lru_cache(maxsize=64)
def _selector(name, kind, as_cv2, threshold, iterations, confidence):
    """Return a Selector restricted to models of one kind, with the limits of a call.

    as_cv2   whether errors of a homography are measured as cv2 does, and a result that chance explains is none
    """
    plain = Selector(name)
    _check_input(name, kind)
    options = {option.name: option for option in plain.options}
    if "model" not in options and plain.name != "pose":
        return plain  # it fits no model, or "planes", which finds its threshold itself
    values = {}
    if "model" in options and kind in options["model"].choices:
        values["model"] = kind
    limit = "threshold"
    if kind != "homography" and "fundamental_threshold" in options:
        limit = "fundamental_threshold"
    if limit in options and threshold > 0:
        values[limit] = threshold
    if "max_iterations" in options and iterations > (options["max_iterations"].value or _HYPOTHESES[kind]):
        values["max_iterations"] = iterations
    if "confidence" in options and confidence > options["confidence"].value:
        values["confidence"] = confidence
    if as_cv2:
        values["min_confidence"] = _CONFIDENCE
        if "error" in options:
            values["error"] = "transfer"
    return Selector(name, **values)


def _check_input(name, kind):
    """Refuse a selector that needs what calls of cv2 do not give."""
    given = ("left_camera", "right_camera") if kind == "essential" else ()
    missing = [need for need in _core.Selector(name, {}).needed_input() if need not in given]
    if missing:
        raise ValueError(
            "method '%s' needs %s, which the functions of cv2 do not get; use corrsel.select(), which takes them"
            % (name, " and ".join(missing))
        )


def _name_of(method):
    """Return the name of the selector for an argument `method`."""
    if isinstance(method, str):
        return method
    if not isinstance(method, (int, np.integer)):
        raise TypeError(
            "method is %r; needed: a number of cv2 or the name of a selector, e.g. 'auto'" % (method,)
        )
    if method in _ALL_POINTS:
        raise ValueError(
            "method %s rejects no matches; call cv2 itself for that, or give the name of a selector, e.g. 'auto'"
            % _ALL_POINTS[method]
        )
    if method not in _METHODS:
        raise ValueError(
            "method is %r; needed: a robust method of cv2 (LMEDS, RANSAC, RHO, USAC_*) or the name of a selector, "
            "e.g. 'auto'" % (method,)
        )
    return _METHODS[method]


def _both(first, second, first_name, second_name):
    """Return the positions of both images as N x 2."""
    left, right = _points(first_name, first), _points(second_name, second)
    if len(left) != len(right):
        raise ValueError(
            "%s has %d points and %s has %d; needed: as many, one pair for each match"
            % (first_name, len(left), second_name, len(right))
        )
    return left, right


def _points(name, values):
    array = np.asarray(values)
    if array.size == 0:
        return np.empty((0, 2), np.float32)
    if array.dtype.kind not in "fiu":
        raise TypeError("%s has dtype %s; needed: real or whole numbers" % (name, array.dtype))
    if array.ndim == 3 and 1 in array.shape[:2]:
        array = array.reshape(-1, array.shape[2])
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(
            "%s has shape %s; needed: N x 2 or N x 1 x 2, (x, y) of each match" % (name, array.shape)
        )
    with np.errstate(over="ignore"):  # becomes infinite, and such matches are set aside
        return array.astype(np.float32)


def _calibration(arguments, keywords):
    """Return the cameras, two pairs of matrix and distortion, and the other arguments of findEssentialMat()."""
    by_matrix = bool(arguments) and np.ndim(arguments[0]) == 2
    if {"cameraMatrix1", "distCoeffs1"} & set(keywords) or by_matrix and _is_distortion(arguments[1:]):
        return _two_cameras(*arguments, **keywords)
    if "cameraMatrix" in keywords or by_matrix:
        return _one_camera(*arguments, **keywords)
    return _focal_length(*arguments, **keywords)


def _is_distortion(arguments):
    """Whether the next argument is no method: None, or coefficients."""
    return len(arguments) > 0 and (arguments[0] is None or np.ndim(arguments[0]) > 0)


def _one_camera(cameraMatrix, method="pose", prob=0.999, threshold=1.0, maxIters=1000, mask=None):
    if isinstance(maxIters, np.ndarray):
        mask, maxIters = maxIters, 0
    camera = (_arrays.matrix("cameraMatrix", cameraMatrix), None)
    return (camera, camera), (method, prob, threshold, maxIters, mask)


def _focal_length(
    focal=1.0, pp=(0.0, 0.0), method="pose", prob=0.999, threshold=1.0, maxIters=1000, mask=None
):
    matrix = [[focal, 0, pp[0]], [0, focal, pp[1]], [0, 0, 1]]
    return _one_camera(matrix, method, prob, threshold, maxIters, mask)


def _two_cameras(
    cameraMatrix1,
    distCoeffs1,
    cameraMatrix2,
    distCoeffs2,
    method="pose",
    prob=0.999,
    threshold=1.0,
    mask=None,
):
    cameras = (
        (_arrays.matrix("cameraMatrix1", cameraMatrix1), distCoeffs1),
        (_arrays.matrix("cameraMatrix2", cameraMatrix2), distCoeffs2),
    )
    return cameras, (method, prob, threshold, 0, mask)


def _answer(model, mask, buffer):
    """Return the model and the mask as cv2 does, and write it into the caller's array."""
    column = mask.astype(np.uint8).reshape(-1, 1)
    if isinstance(buffer, np.ndarray) and buffer.shape == column.shape and buffer.dtype == np.uint8:
        buffer[...] = column
        column = buffer
    return model, column
