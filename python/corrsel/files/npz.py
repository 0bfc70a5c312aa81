"""NPZ files of matchers: one file for each pair."""
import zipfile
import zlib

import numpy as np

from .pairs import InputError, MatchedPair, image_size, matched_rows, points, set_scores, vector
from .truth import label_truth, matrix_truth, motion_of, pose_truth

#: The keys of scores: of every left keypoint or of every match.
SCORES = ("match_confidence", "matching_scores0", "matching_scores", "scores", "mconf", "confidence")
MATCHES = ("matches", "matches0")
#: Endings of files that are not part of a pair's name.
ENDINGS = ("_matches",)


def read_npz(path, key, scores="confidence"):
    """Return the MatchedPair of a file. Raises InputError that names the file, the key and the row.

    The keys are those of docs/matches.md.
    """
    arrays = _load(path)
    source = str(path)
    if "mkpts0" in arrays or "mkpts1" in arrays:
        pair, rows, total = _matched_points(arrays, ("mkpts0", "mkpts1"), source, key)
    elif not any(name in arrays for name in MATCHES):
        pair, rows, total = _matched_points(arrays, ("keypoints0", "keypoints1"), source, key)
    else:
        pair, rows, total = _keypoints_and_matches(arrays, source, key)
    for name in SCORES:
        if name in arrays:
            set_scores(pair, _per_match(arrays[name], rows, total, source, name), name, scores)
            break
    for name, meaning, may_be_nan in (
        ("distance", "distance", False),
        ("match_probability", "confidence", True),
    ):
        if name in arrays:
            values = _per_match(arrays[name], rows, total, source, name)
            set_scores(pair, values, name, meaning, may_be_nan)
    for side, name in (("left", "0"), ("right", "1")):
        if "image" + name in arrays:
            setattr(pair, side + "_name", _name(arrays["image" + name], source, "image" + name))
        if "image_size" + name in arrays:
            setattr(
                pair, side + "_size", image_size(arrays["image_size" + name], source, "image_size" + name)
            )
    _read_truth(arrays, pair, rows, total, source)
    return pair


def _load(path):
    try:
        with open(str(path), "rb") as opened:
            file = np.load(opened, allow_pickle=False)
            if isinstance(file, np.ndarray):
                raise ValueError("it holds an array without a key")
            arrays = {}
            for name in file.files:
                try:
                    arrays[name] = file[name]
                except ValueError:  # objects, which would be run as a program
                    continue
            return arrays
    except (OSError, ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(
            "%s is damaged or no NPZ file (%s); write it with numpy.savez" % (path, error)
        ) from error


def _name(value, source, key):
    """Return the name of an image: one text, which may be in an array of one."""
    array = np.asarray(value)
    if array.size != 1 or array.dtype.kind not in "US":
        raise InputError(
            "%s: %s has the shape %s and the type %s, expected a text: the path of the image"
            % (source, key, "x".join(map(str, array.shape)) or "of one value", array.dtype)
        )
    text = array.reshape(-1)[0]
    try:
        return text.decode("utf-8") if isinstance(text, bytes) else str(text)
    except UnicodeDecodeError as error:
        raise InputError("%s: %s is no UTF-8 text (%s)" % (source, key, error)) from error


def _keypoints_and_matches(arrays, source, key):
    for name in ("keypoints0", "keypoints1"):
        if name not in arrays:
            raise InputError(
                "%s has no key %s beside its matches (it has %s); write keypoints0, keypoints1 and matches"
                % (source, name, ", ".join(sorted(arrays)))
            )
    left = points(arrays["keypoints0"], source, "keypoints0")
    right = points(arrays["keypoints1"], source, "keypoints1")
    name = next(name for name in MATCHES if name in arrays)
    left_rows, right_rows, rows, total = matched_rows(arrays[name], (len(left), len(right)), source, name)
    pair = MatchedPair(
        source,
        key,
        left[left_rows],
        right[right_rows],
        left_index=left_rows.astype(np.uint32),
        right_index=right_rows.astype(np.uint32),
        left_count=len(left),
        right_count=len(right),
    )
    return pair, rows, total


def _matched_points(arrays, names, source, key):
    for name in names:
        if name not in arrays:
            raise InputError(
                "%s has no key %s (it has %s); write keypoints0, keypoints1 and matches, or mkpts0 and mkpts1"
                % (source, name, ", ".join(sorted(arrays)) or "none that can be read")
            )
    left, right = (points(arrays[name], source, name) for name in names)
    if len(left) != len(right):
        raise InputError(
            "%s: %s has %d rows and %s has %d, but there is no key matches; write as many rows, one for each match"
            % (source, names[0], len(left), names[1], len(right))
        )
    return MatchedPair(source, key, left, right), np.arange(len(left)), len(left)


def _per_match(values, rows, total, source, name):
    """Return the values of the matches. There are values of these or of all rows of the array of matches."""
    size = np.asarray(values).size
    if size == len(rows) != total:
        return vector(values, source, name, len(rows))
    return vector(values, source, name, total)[rows]


def _read_truth(arrays, pair, rows, total, source):
    found = [name for name in ("H", "F", "labels") if name in arrays]
    if len(found) > 1:
        raise InputError(
            "%s: the keys %s are several ground truths; keep one" % (source, " and ".join(found))
        )
    pose = None
    if "K0" in arrays and "K1" in arrays and ("T_0to1" in arrays or ("R" in arrays and "t" in arrays)):
        if "T_0to1" in arrays:
            rotation, translation = motion_of(arrays["T_0to1"], source)
        else:
            rotation, translation = arrays["R"], arrays["t"]
        pose = pose_truth(arrays["K0"], arrays["K1"], rotation, translation, source)
        pair.truth = pose
    if not found:
        return
    if found[0] == "labels":
        pair.truth = label_truth(
            _per_match(arrays["labels"], rows, total, source, "labels"), source + ": labels"
        )
    else:
        kind = "homography" if found[0] == "H" else "fundamental"
        pair.truth = matrix_truth(kind, arrays[found[0]], "%s: %s" % (source, found[0]))
    pair.truth.pose = None if pose is None else pose.pose
