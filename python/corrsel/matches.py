"""Convert corrsel/Correspondences, corrsel/Selection and corrsel/Tracks messages to arrays and to OpenCV's keypoints.

    import cv2, rospy
    from corrsel import matches
    from corrsel.msg import Correspondences

    def use(msg):
        left, right = matches.points(msg)
        if len(left) >= 8:
            fundamental, mask = cv2.findFundamentalMat(left, right)

    rospy.init_node("consumer")
    rospy.Subscriber("matches", Correspondences, use, queue_size=1)
    rospy.spin()
"""

import collections

import numpy as np

__all__ = ["KeypointsAndMatches", "groups", "keypoints", "points", "selected_rows", "tracks"]

#: Two lists of cv2.KeyPoint and a list of cv2.DMatch between them: queryIdx is an index into the left list.
KeypointsAndMatches = collections.namedtuple("KeypointsAndMatches", "left right matches")

FRAME_NUMBERS = 6

#: The columns of a file of tracks, and of a Tracks message, with the types of their arrays.
_SIGHT = [
    ("track", np.uint64),
    ("stamp", np.uint64),
    ("keypoint", np.uint32),
    ("x", np.float32),
    ("y", np.float32),
]
_PREVIOUS = [("age", np.uint32), ("previous_x", np.float32), ("previous_y", np.float32)]


def points(msg):
    """Return the positions in the left and the right image as two float32 arrays of shape (N, 2): x, y in px.

    Raises ValueError that names an array of the message whose length is not the number of matches.
    """
    count = len(msg.left_x)
    left = np.stack([_column(msg, "left_x", count), _column(msg, "left_y", count)], axis=1)
    right = np.stack([_column(msg, "right_x", count), _column(msg, "right_y", count)], axis=1)
    return left, right


def keypoints(msg):
    """Return the KeypointsAndMatches of a Correspondences message, with the matches in the message's order.

    If the message has indices of features, a feature of several matches is one keypoint, with the index as
    class_id; otherwise every match has keypoints of its own, with class_id -1. If the message has affine
    frames, the size of a keypoint is the diameter, px, of the circle with the area of the frame's ellipse, and
    its angle is that of the frame's first axis, degrees in [0, 360); otherwise they are 0 and -1. The distance
    of a match is 1 - probability if the message has no distances, and without probabilities the largest float32, as
    in OpenCV.

    Raises ValueError that names an array of the wrong length, and ImportError if OpenCV's module is missing.
    """
    cv2 = _opencv()
    count = len(msg.left_x)
    left_points, right_points = points(msg)
    distances = _column(msg, "distance", count, optional=True)
    probabilities = _column(msg, "probability", count, optional=True)
    if distances is None and probabilities is not None:
        distances = 1 - probabilities
    elif distances is None:
        distances = np.full(count, np.finfo(np.float32).max, np.float32)
    left, left_rows = _side(cv2, msg, "left", left_points)
    right, right_rows = _side(cv2, msg, "right", right_points)
    pairs = [cv2.DMatch(*row) for row in zip(left_rows, right_rows, distances.tolist())]
    return KeypointsAndMatches(left, right, pairs)


def selected_rows(msg):
    """Return the indices of the matches that a Selection message kept, in rising order.

    They are rows of the Correspondences with the same stamp on the topic that the selector reads
    (`correspondences`), not on the topic `matches`, which holds only the selected ones. Raises ValueError if
    n_input is not the length of the mask.
    """
    mask = np.frombuffer(bytes(msg.mask), np.uint8)
    if len(mask) != msg.n_input:
        raise ValueError("Selection message: mask has %d elements, expected %d" % (len(mask), msg.n_input))
    return np.flatnonzero(mask)


def groups(msg):
    """Return the number of the model of each match of a Selection message, int32; None if it has no such numbers.

    -1 means that the match is not selected or belongs to no model. Raises ValueError if the number of elements is not
    that of the mask.
    """
    if len(msg.group) == 0:
        return None
    if len(msg.group) != len(msg.mask):
        text = "Selection message: group has %d elements, expected 0 or %d"
        raise ValueError(text % (len(msg.group), len(msg.mask)))
    return np.asarray(msg.group, np.int32)


def tracks(source):
    """Return the rows of a file of tracks, or of a corrsel/Tracks message, as one structured array.

    `source` is the message, or the path of the file that the nodelet corrsel/Tracker has written. The fields are track
    (its identity, uint64), stamp (of the image, ns, uint64), keypoint (number of the feature in its image, uint32), x
    and y (px, float32); those of a message also age (uint32) and previous_x and previous_y (float32, NaN = not seen in
    the image before). The rows of a file are in its order, in which those of each track have rising stamps; a last line
    that was not written to its end is left out. Sort them by `np.argsort(rows["track"], kind="stable")` to have track
    after track.

    Raises ValueError that names the array or the line that is wrong, and OSError if the file cannot be read.
    """
    if not hasattr(source, "previous_x"):
        return _tracks_of_file(source)
    rows = np.empty(len(source.id), _SIGHT + _PREVIOUS)
    fields = {"track": "id", "keypoint": "feature_index"}
    for name in rows.dtype.names:
        if name == "stamp":
            rows[name] = source.header.stamp.to_nsec()
            continue
        values = getattr(source, fields.get(name, name))
        if len(values) != len(rows):
            text = "Tracks message: %s has %d elements, expected %d"
            raise ValueError(text % (fields.get(name, name), len(values), len(rows)))
        rows[name] = values
    return rows


def _tracks_of_file(path):
    """Return the rows of a file of tracks."""
    with open(path, encoding="ascii") as file:
        lines = file.read().split("\n")[:-1]  # what follows the last line feed is incomplete
    names = ",".join(name for name, _ in _SIGHT)
    if not lines or lines[0] != names:
        raise ValueError("%s is no file of tracks: its first line is not %r" % (path, names))
    rows = np.empty(len(lines) - 1, _SIGHT)
    for number, line in enumerate(lines[1:]):
        try:
            track, stamp, keypoint, x, y = line.split(",")
            rows[number] = int(track), int(stamp), int(keypoint), float(x), float(y)
        except ValueError as error:
            raise ValueError("%s, line %d is %r: %s" % (path, number + 2, line, error)) from error
    return rows


def _opencv():
    try:
        import cv2  # pylint: disable=import-outside-toplevel  # points() does without it
    except ImportError as error:
        raise ImportError(
            "corrsel.matches.keypoints needs OpenCV's Python module: install python3-opencv (%s)" % error
        ) from error
    return cv2


def _column(msg, field, length, optional=False, dtype=np.float32):
    """Return a field as an array, or None if it is optional and empty."""
    values = np.asarray(getattr(msg, field), dtype)
    if optional and len(values) == 0:
        return None
    if len(values) != length:
        expected = "%s%d" % ("0 or " if optional else "", length)
        raise ValueError(
            "Correspondences message: %s has %d elements, expected %s" % (field, len(values), expected)
        )
    return values


def _side(cv2, msg, side, positions):
    """Return the keypoints of one image and, per match, the index of its keypoint."""
    count = len(positions)
    index = _column(msg, side + "_index", count, optional=True, dtype=np.int64)
    frames = _column(msg, side + "_frame", FRAME_NUMBERS * count, optional=True)
    sizes, angles = np.zeros(count, np.float32), np.full(count, -1, np.float32)
    if frames is not None:
        a11, a12, _, a21, a22, _ = frames.reshape(count, FRAME_NUMBERS).T
        sizes = 2 * np.sqrt(np.abs(a11 * a22 - a12 * a21))
        angles = np.degrees(np.arctan2(a21, a11))
        angles = np.where(angles < 0, angles + 360, angles)
    numbers, rows, result = {}, [], []
    for i in range(count):
        key = i if index is None else int(index[i])
        if key not in numbers:
            numbers[key] = len(result)
            (x, y), number = positions[i], -1 if index is None else key
            keypoint = cv2.KeyPoint(float(x), float(y), float(sizes[i]), float(angles[i]))
            keypoint.class_id = number
            result.append(keypoint)
        rows.append(numbers[key])
    return result, rows
