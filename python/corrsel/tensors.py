"""Dictionaries and tensors of matching networks: LightGlue, SuperGlue and Kornia, in numpy or torch.

    filtered = tensors.filter_matches(matcher({"image0": feats0, "image1": feats1}), feats0, feats1, "auto")

    matches_of      the Matches of a network's dictionary, for select()
    filter_matches  the dictionary with the matches that a selector keeps
    match_adalam    kornia.feature.match_adalam

Tensors may be on any device; results are where the input was. torch is used through the tensors that come, and is not
imported. Nothing is differentiated.
"""

import collections
import collections.abc

import numpy as np

from . import _arrays, _doors
from .features import Features, match_features
from .files.pairs import InputError, matched_rows
from .selectors import Matches, Selector

__all__ = ["filter_matches", "match_adalam", "matches_of"]

#: Options of Kornia's AdaLAM by ours, and the value that stands for its None.
_ADALAM = {
    "area_ratio": ("area_ratio", None),
    "search_expansion": ("search_expansion", None),
    "ransac_iters": ("samples", None),
    "min_inliers": ("min_members", None),
    "min_confidence": ("confidence", None),
    "orientation_difference_threshold": ("max_rotation", 180),
    "scale_rate_threshold": ("max_scale_change", 10),
    "detected_scale_rate_threshold": ("max_stretch", None),
}
#: Options of Kornia's AdaLAM without a counterpart.
_NOT_NEEDED = ("refit", "force_seed_mnn", "device")


def matches_of(output, image0=None, image1=None, *, left_size=None, right_size=None):
    """Return the Matches of the dictionary of one pair of images.

    output       with `matches` (S x 2, pairs of numbers of keypoints) and `scores` (S) as LightGlue returns them, or
                 with `matches0` (N, the number of the right keypoint, -1 = none) and `matching_scores0` (N) as
                 SuperGlue does. Arrays may have a leading dimension of 1, and the lists of LightGlue one element
    image0, image1   keypoints, px: N x 2, or a dictionary with `keypoints` and perhaps `image_size` (width, height), as
                 the extractors return them. None: `keypoints0` and `keypoints1` of the output
    left_size, right_size   sizes (width, height), px, where image0 and image1 do not have them

    Scores from 0 to 1 become probabilities. Numbers of keypoints are kept as left_index and right_index.

    Raises ValueError that names the key for arrays that do not belong together, and KeyError for a missing key.
    """
    return _Output(output, image0, image1, left_size, right_size).pair(0).matches


def filter_matches(
    output, image0=None, image1=None, selector="auto", *, left_size=None, right_size=None, **options
):
    """Return the dictionary of a network with those matches alone that a selector keeps.

    output, image0, image1, left_size, right_size   those of matches_of(); the dictionary may hold several pairs of
                 images of the same size (B x N, or lists of B tensors)
    selector, options   those of corrsel.select(). Where its status is neither "ok" nor "time_limit", nothing is kept

    Returns a new dictionary with the same keys and types. In `matches0`, `matches1` rejected matches are -1, in
    `matching_scores0`, `matching_scores1` 0. In `matches`, `scores` they are left out. Other keys are those of the output.

    Raises what matches_of() and corrsel.Selector() raise.
    """
    chosen = Selector(selector, **options)
    whole = _Output(output, image0, image1, left_size, right_size)
    pairs = [whole.pair(row) for row in range(whole.count)]
    return whole.filtered([(pair, _doors.kept(chosen.select(pair.matches))) for pair in pairs])


def match_adalam(desc1, desc2, lafs1, lafs2, config=None, hw1=None, hw2=None, dm=None):
    """Match descriptors and keep what the selector "adalam" keeps, as kornia.feature.match_adalam does.

    desc1, desc2   compared by L2: N1 x D, N2 x D
    lafs1, lafs2   local affine frames [[a11, a12, x], [a21, a22, y]], px: 1 x N1 x 2 x 3, 1 x N2 x 2 x 3
    config         options of Kornia's AdaLAM as a dictionary; refit, force_seed_mnn and device are ignored
    hw1, hw2       sizes of the images (height, width), px; None: the extent of the frames' centres
    dm             distances of all descriptors, in place of desc1 and desc2: N1 x N2

    Returns (quality, matches): quality is S x 1, the distances of the descriptors; matches is S x 2, int64, rows of
    desc1 and desc2 in the order of desc1. Both are tensors if desc1 is one. The time is O(N1 N2 D).

    Raises ValueError that names the argument and its shape.
    """
    frames = [_frames(name, lafs) for name, lafs in (("lafs1", lafs1), ("lafs2", lafs2))]
    sizes = [_size_of(frame[:, :, 2], hw) for frame, hw in zip(frames, (hw1, hw2))]
    if dm is None:
        sides = zip(frames, (desc1, desc2), sizes)
        left, right = (
            Features(frame[:, :, 2], _doors.to_floats(desc), frame=frame, image_size=size)
            for frame, desc, size in sides
        )
        matches = match_features(left, right)
    else:
        matches = _nearest(_doors.to_floats(dm), frames, sizes)
    matches = matches[_doors.kept(matches.select("adalam", **_adalam_options(config or {})))]
    rows = np.stack([matches.left_index, matches.right_index], axis=1).astype(np.int64)
    return _doors.like(desc1, matches.distance[:, None]), _doors.like(desc1, rows)


#: The Matches of one pair of images, and the rows of keypoints that they join.
_Pair = collections.namedtuple("_Pair", "matches left right")


class _Output:
    """The dictionary of a network: one pair of images, or a batch of pairs."""

    def __init__(self, output, image0, image1, left_size, right_size):
        self.output = output
        self.key = next((key for key in ("matches", "matches0") if key in output), None)
        if self.key is None:
            raise KeyError("output has neither matches nor matches0; it has %s" % ", ".join(map(str, output)))
        self.keypoints, self.sizes = [], []
        for name, image, size in (("keypoints0", image0, left_size), ("keypoints1", image1, right_size)):
            features = image if isinstance(image, collections.abc.Mapping) else {}
            values = features["keypoints"] if features else output[name] if image is None else image
            self.keypoints.append(_doors.to_floats(values))
            self.sizes.append(features.get("image_size") if size is None else size)
        self.batch = not _is_flat(output[self.key], 2 if self.key == "matches" else 1)
        self.count = len(output[self.key]) if self.batch else 1

    def pair(self, row):
        """Return the _Pair of one pair of images."""
        keypoints = [self._keypoints("keypoints%d" % side, row, side) for side in (0, 1)]
        indices = _doors.to_numpy(self._element(self.key, row))
        counts = tuple(len(values) for values in keypoints)
        try:
            left, right, rows, _ = matched_rows(indices, counts, "output", self.key)
        except InputError as error:
            raise ValueError(str(error)) from error
        scores = "scores" if self.key == "matches" else "matching_scores0"
        probability = None
        if scores in self.output:
            probability = _probability(_doors.to_floats(self._element(scores, row)).reshape(-1)[rows])
        sizes = [None if size is None else self._size(size, row) for size in self.sizes]
        matches = Matches(
            keypoints[0][left],
            keypoints[1][right],
            probability=probability,
            left_index=left,
            right_index=right,
            left_size=sizes[0],
            right_size=sizes[1],
        )
        return _Pair(matches, left, right)

    def filtered(self, answers):
        """Return the dictionary without the rejected matches. answers: a _Pair and its mask for each pair."""
        result = dict(self.output)
        for key, place, empty in (
            ("matches0", "left", -1),
            ("matches1", "right", -1),
            ("matching_scores0", "left", 0),
            ("matching_scores1", "right", 0),
        ):
            if key in result:
                array = _doors.to_numpy(result[key]).copy()
                rows = array if self.batch else array[None]
                for values, (pair, keep) in zip(rows, answers):
                    values[getattr(pair, place)[~keep]] = empty
                result[key] = _doors.like(result[key], array)
        if self.key == "matches":
            for key in ("matches", "scores"):
                if key in result:
                    result[key] = self._shortened(result[key], answers)
        return result

    def _shortened(self, values, answers):
        """Return lists, or a tensor, of rows of matches without those that are rejected."""
        masks = [keep for _, keep in answers]
        if not self.batch:
            return _doors.like(values, _doors.to_numpy(values)[masks[0]])
        parts = [_doors.like(part, _doors.to_numpy(part)[keep]) for part, keep in zip(values, masks)]
        if isinstance(values, (list, tuple)):
            return parts
        if len(parts) != 1:
            raise ValueError("matches of several pairs of images are one tensor; needed: a list of S x 2")
        return parts[0][None]

    def _element(self, key, row):
        return self.output[key][row] if self.batch else self.output[key]

    def _keypoints(self, name, row, side):
        values = self.keypoints[side]
        if values.ndim == 3 and len(values) != self.count:
            raise ValueError(
                "%s has shape %s; needed: %d x N x 2, as there are matches of so many pairs"
                % (name, values.shape, self.count)
            )
        values = values[row] if values.ndim == 3 else values
        return _arrays.floats(name, values, (None, 2), "(x, y) of each keypoint")

    @staticmethod
    def _size(size, row):
        values = _doors.to_numpy(size)
        return tuple(int(side) for side in (values[row] if values.ndim == 2 else values))


def _is_flat(values, dimensions):
    """Whether values belong to one pair of images, without a dimension for a batch."""
    if isinstance(values, (list, tuple)) and len(values) > 0 and hasattr(values[0], "ndim"):
        return values[0].ndim == dimensions - 1
    return np.ndim(_doors.to_numpy(values)) == dimensions


def _probability(scores):
    """Return scores from 0 to 1 as probabilities, although rounded; None where they tell nothing."""
    return np.clip(scores, 0, 1) if scores.any() else None


def _frames(name, lafs):
    array = _doors.to_floats(lafs)
    if array.ndim != 4 or array.shape[0] != 1 or array.shape[2:] != (2, 3):
        raise ValueError("%s has shape %s; needed: 1 x N x 2 x 3" % (name, array.shape))
    return array[0]


def _size_of(centres, shape):
    """Return (width, height) of a shape (height, width), or of the extent of points."""
    if shape is not None:
        height, width = (int(side) for side in shape[:2])
        return width, height
    if len(centres) == 0:
        return None
    return tuple(int(side) + 1 for side in np.ceil(np.nanmax(centres, axis=0)))


def _nearest(distances, frames, sizes):
    """Return the Matches of every row of a matrix of distances with its nearest column."""
    if distances.shape != (len(frames[0]), len(frames[1])):
        raise ValueError(
            "dm has shape %s; needed: %d x %d" % (distances.shape, len(frames[0]), len(frames[1]))
        )
    rows = np.arange(len(distances) if distances.shape[1] else 0)
    nearest = distances.argmin(axis=1) if len(rows) else rows
    best = distances[rows, nearest]
    others = distances.copy()
    others[rows, nearest] = np.inf
    second = others.min(axis=1) if len(rows) else best
    return Matches(
        frames[0][rows, :, 2],
        frames[1][nearest, :, 2],
        distance=best,
        second_distance=np.where(np.isfinite(second), second, np.nan),
        left_frame=frames[0][rows],
        right_frame=frames[1][nearest],
        left_index=rows,
        right_index=nearest,
        left_size=sizes[0],
        right_size=sizes[1],
    )


def _adalam_options(config):
    """Return the options of the selector for those of Kornia's AdaLAM."""
    unknown = [key for key in config if key not in _ADALAM and key not in _NOT_NEEDED]
    if unknown:
        raise ValueError(
            "config has the unknown option %s; known are %s"
            % (unknown[0], ", ".join((*_ADALAM, *_NOT_NEEDED)))
        )
    options = {}
    for key, (name, none) in _ADALAM.items():
        if key in config:
            options[name] = none if config[key] is None else config[key]
    return options
