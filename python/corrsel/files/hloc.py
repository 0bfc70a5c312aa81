"""HDF5 files of hloc (Sarlin et al., CVPR 2019): keypoints in one file, matches in another one."""
import contextlib

import numpy as np

from .pairs import InputError, MatchedPair, image_size, matched_rows, points, set_scores, vector

try:
    import h5py
except ImportError:  # needed for these files alone
    h5py = None

#: Most keypoints of an image: hloc stores their numbers in 16 bits.
MOST_KEYPOINTS = 32768


def read_hloc(matches, features, listed=None, scores="confidence"):
    """Yield the MatchedPair of every pair in a file of matches. Raises InputError that names file and group.

    features: NAME/keypoints, N x 2, and optionally NAME/image_size; NAME is the path of an image
    matches:  A/B/matches0, for every keypoint of the first image the number of one of the second image, -1 = none,
              and optionally A/B/matching_scores0. A and B are the names of the images with '/' replaced by '-'.
              Older files have the group A_B instead of A/B.
              Confidences that are all 0 are no scores.
    listed:   [(left name, right name, truth, place)] of the pairs to read; None: all
    """
    with _damage(matches, features), _open(features) as feature_file, _open(matches) as match_file:
        names = _image_names(feature_file)
        if not names:
            raise InputError("%s has no group with keypoints; is it the file of the features?" % features)
        if listed is None:
            wanted = [(left, right, None) for left, right in _pairs_in(match_file, matches, names, features)]
        else:
            wanted = [(left, right, place) for left, right, _, place in listed]
        for left, right, place in wanted:
            group, reverse = _group_of(match_file, left, right, place, matches)
            first, second = (right, left) if reverse else (left, right)
            pair = _read_pair(match_file, group, feature_file, (first, second), (matches, features), scores)
            yield pair.exchanged() if reverse else pair


def _open(path):
    if h5py is None:
        raise InputError("%s: reading HDF5 needs the Python package h5py: apt install python3-h5py" % path)
    try:
        return h5py.File(str(path), "r")
    except OSError as error:
        raise InputError("%s is damaged or no HDF5 file (%s)" % (path, error)) from error


@contextlib.contextmanager
def _damage(matches, features):
    """Turn what h5py raises inside of a damaged file into InputError."""
    try:
        yield
    except (OSError, RuntimeError, KeyError) as error:
        raise InputError("%s or %s is damaged (%s)" % (matches, features, error)) from error


def _values(group, name, place):
    """Return the values of a data set."""
    item = group[name]
    if not isinstance(item, h5py.Dataset):
        raise InputError("%s/%s is a group, expected numbers" % (place, name))
    return item[()]


def _encoded(name):
    return name.replace("/", "-")


def _image_names(feature_file):
    names = []

    def visit(name, item):
        if isinstance(item, h5py.Group) and "keypoints" in item:
            names.append(name)

    feature_file.visititems(visit)
    return names


def _pairs_in(match_file, path, names, features):
    """Return the pairs of a file of matches as names of images."""
    by_code = {}
    for name in names:
        by_code.setdefault(_encoded(name), []).append(name)

    def decoded(code, group):
        found = by_code.get(code, [])
        if len(found) == 1:
            return found[0]
        if not found:
            raise InputError(
                "%s, group %s: '%s' is no image of %s; do the two files belong together?"
                % (path, group, code, features)
            )
        raise InputError(
            "%s, group %s: '%s' stands for %s; give the list of pairs by --pairs"
            % (path, group, code, " or ".join(sorted(found)))
        )

    pairs = []
    for first, item in match_file.items():
        if not isinstance(item, h5py.Group):
            continue
        if "matches0" in item:
            cuts = [i for i, character in enumerate(first) if character == "_"]
            found = [
                (first[:i], first[i + 1 :])
                for i in cuts
                if first[:i] in by_code and first[i + 1 :] in by_code
            ]
            if len(found) != 1:
                raise InputError(
                    "%s, group %s: %s of its splits at '_' names two images of %s; give the list of pairs by --pairs"
                    % (path, first, "none" if not found else "more than one", features)
                )
            pairs.append(tuple(decoded(code, first) for code in found[0]))
            continue
        for second in item:
            group = first + "/" + second
            if isinstance(item[second], h5py.Group) and "matches0" in item[second]:
                pairs.append((decoded(first, group), decoded(second, group)))
    if not pairs:
        raise InputError("%s has no group with matches0; is it the file of the matches?" % path)
    return pairs


def _group_of(match_file, left, right, place, path):
    """Return the name of the group of a pair, and whether it holds the pair in the reverse order."""
    for reverse, (first, second) in ((False, (left, right)), (True, (right, left))):
        for separator in "/_":
            group = _encoded(first) + separator + _encoded(second)
            if group in match_file and "matches0" in match_file[group]:
                return group, reverse
    raise InputError(
        "%s: the pair %s %s is not in %s; match it, or remove the line" % (place or path, left, right, path)
    )


def _read_pair(match_file, group, feature_file, names, paths, scores):
    matches, features = (str(path) for path in paths)
    keypoints, sizes = [], []
    for name in names:
        if name not in feature_file or "keypoints" not in feature_file[name]:
            raise InputError(
                "%s has no group %s with keypoints, which %s matches" % (features, name, matches)
            )
        item = feature_file[name]
        place = "%s: %s" % (features, name)
        values = np.asarray(_values(item, "keypoints", place))
        keypoints.append(points(values[:, :2] if values.ndim == 2 else values, features, name + "/keypoints"))
        sizes.append((0, 0))
        if "image_size" in item:
            sizes[-1] = image_size(_values(item, "image_size", place), features, name + "/image_size")
    item = match_file[group]
    counts = tuple(len(values) for values in keypoints)
    place = "%s: %s" % (matches, group)
    numbers = _values(item, "matches0", place)
    if numbers.dtype == np.int16 and counts[1] > MOST_KEYPOINTS:
        raise InputError(
            "%s/matches0 holds numbers of 16 bits, but %s has %d keypoints, so that some numbers are lost; match again "
            "with at most %d keypoints" % (place, names[1], counts[1], MOST_KEYPOINTS)
        )
    left, right, rows, total = matched_rows(numbers, counts, matches, group + "/matches0")
    pair = MatchedPair(
        "%s, group %s" % (matches, group),
        "",
        keypoints[0][left],
        keypoints[1][right],
        left_name=names[0],
        right_name=names[1],
        left_index=left.astype(np.uint32),
        right_index=right.astype(np.uint32),
        left_count=counts[0],
        right_count=counts[1],
        left_size=sizes[0],
        right_size=sizes[1],
    )
    if "matching_scores0" in item:
        name = group + "/matching_scores0"
        values = vector(_values(item, "matching_scores0", place), matches, name, total)[rows]
        if scores != "confidence" or values.any():  # hloc's AdaLAM writes zeros
            set_scores(pair, values, "matching_scores0", scores)
    return pair
