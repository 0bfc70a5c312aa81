"""Ground truth of pairs of images: from arrays, from a folder, from lists of pairs with poses."""
import numpy as np

from .pairs import InputError, Truth

POSE_NUMBERS = 34  # K, K' and the 4 x 4 matrix from the left camera to the right one, row by row


def matrix_truth(kind, values, source):
    """Return the Truth of a 3 x 3 matrix; kind is "homography" or "fundamental"."""
    matrix = _matrix(values, (3, 3), source)
    rank, least = np.linalg.matrix_rank(matrix), 3 if kind == "homography" else 2
    if rank < least:
        raise InputError(
            "%s is %s, which has the rank %d, expected %d" % (source, matrix.tolist(), rank, least)
        )
    return Truth(kind, matrix)


def pose_truth(left_camera, right_camera, rotation, translation, source):
    """Return the Truth of two calibrated cameras: the fundamental matrix K'^-T [t]x R K^-1 (Hartley and Zisserman,
    Multiple View Geometry, Eq. 9.12), or the homography K' R K^-1 where the camera only turned."""
    left_camera = _matrix(left_camera, (3, 3), source + ": K of the left image")
    right_camera = _matrix(right_camera, (3, 3), source + ": K of the right image")
    rotation = _matrix(rotation, (3, 3), source + ": R")
    translation = _matrix(translation, (3,), source + ": t")
    for name, camera in (("left", left_camera), ("right", right_camera)):
        below = (camera[1, 0],) + tuple(camera[2])
        if not (camera[0, 0] > 0 and camera[1, 1] > 0 and np.allclose(below, (0, 0, 0, 1))):
            raise InputError(
                "%s: K of the %s image is %s, expected fx s cx 0 fy cy 0 0 1, px"
                % (source, name, camera.tolist())
            )
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-4) or np.linalg.det(rotation) < 0:
        raise InputError("%s: R is %s, which is not a rotation" % (source, rotation.tolist()))
    pose = left_camera, right_camera, rotation, translation
    if not np.any(translation):
        return Truth("homography", right_camera @ rotation @ np.linalg.inv(left_camera), pose=pose)
    x, y, z = translation
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation
    matrix = np.linalg.inv(right_camera).T @ essential @ np.linalg.inv(left_camera)
    return Truth("fundamental", matrix / np.linalg.norm(matrix), pose=pose)


def motion_of(values, source):
    """Return R and t of the 4 x 4 matrix from the left camera to the right one."""
    matrix = _matrix(values, (4, 4), source + ": T")
    if not np.allclose(matrix[3], (0, 0, 0, 1)):
        raise InputError(
            "%s: the last row of T is %s, expected 0 0 0 1; is the matrix transposed?"
            % (source, matrix[3].tolist())
        )
    return matrix[:3, :3], matrix[:3, 3]


def pose_of_numbers(numbers, source):
    """Return the Truth of POSE_NUMBERS numbers."""
    numbers = _matrix(numbers, (POSE_NUMBERS,), source)
    rotation, translation = motion_of(numbers[18:].reshape(4, 4), source)
    return pose_truth(numbers[:9].reshape(3, 3), numbers[9:18].reshape(3, 3), rotation, translation, source)


def label_truth(labels, source):
    """Return the Truth of one label for each match: 0 = outlier, k = member of structure k."""
    array = np.asarray(labels)
    wrong = np.flatnonzero(~((array >= 0) & (array == np.floor(array)) & (array < 2**32)))
    if len(wrong):
        raise InputError(
            "%s, row %d is %s, expected 0 (outlier), 1 (inlier) or the number of a structure"
            % (source, wrong[0], array[wrong[0]])
        )
    return Truth("labels", labels=array.astype(np.uint32))


def truth_in_folder(folder, key):
    """Return the Truth of the pair `key` (a path) in a folder of ground truth, or None where there is none.

    folder/key/ holds H.txt or F.txt (nine numbers), or pose.txt (POSE_NUMBERS numbers).
    """
    found = [
        folder / key / name for name in ("H.txt", "F.txt", "pose.txt") if (folder / key / name).is_file()
    ]
    if not found:
        return None
    if len(found) > 1:
        raise InputError(
            "%s: %s are several ground truths; keep one" % (folder / key, [f.name for f in found])
        )
    file = found[0]
    try:
        numbers = [float(word) for word in file.read_text(encoding="utf-8").replace(",", " ").split()]
    except ValueError as error:
        raise InputError("%s: %s; write numbers" % (file, error)) from error
    if file.name == "pose.txt":
        return pose_of_numbers(numbers, str(file))
    kind = "homography" if file.name == "H.txt" else "fundamental"
    if len(numbers) != 9:
        raise InputError("%s holds %d numbers, expected 9: the matrix, row by row" % (file, len(numbers)))
    return matrix_truth(kind, np.reshape(numbers, (3, 3)), str(file))


def read_pair_list(path):
    """Return [(left name, right name, Truth or None, place)] of a text file with one pair of images per line.

    A line is `left right`, as in hloc's lists, or `left right rotation rotation K K' T` (38 words), as in
    SuperGlue's lists, where T is the 4 x 4 matrix from the left camera to the right one.
    """
    result, lines_of = [], {}
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError("%s cannot be read as a list of pairs: %s" % (path, error)) from error
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        place = "%s, line %d" % (path, number)
        if len(words) not in (2, 4, 4 + POSE_NUMBERS):
            raise InputError(
                "%s has %d words, expected 2 (two images), 4 (with their rotations) or %d (also K, K' and T)"
                % (place, len(words), 4 + POSE_NUMBERS)
            )
        if (words[0], words[1]) in lines_of:
            raise InputError(
                "%s: the pair %s %s stands in line %d, too; remove one of the lines"
                % (place, words[0], words[1], lines_of[words[0], words[1]])
            )
        lines_of[words[0], words[1]] = number
        if any(word not in ("0", "0.0") for word in words[2:4]):
            raise InputError(
                "%s: the images are to be rotated by %s and %s quarter turns, which is not supported; rotate images and "
                "matches, and write 0" % (place, words[2], words[3])
            )
        truth = None
        if len(words) > 4:
            try:
                truth = pose_of_numbers([float(word) for word in words[4:]], place)
            except ValueError as error:
                raise InputError("%s: %s; write numbers" % (place, error)) from error
        result.append((words[0], words[1], truth, place))
    if not result:
        raise InputError("%s holds no pair; write one line for each pair: left.jpg right.jpg" % path)
    return result


def _matrix(values, shape, source):
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "fiub":
            raise ValueError("the type is %s" % array.dtype)
    except ValueError as error:
        raise InputError("%s is not numeric: %s" % (source, error)) from error
    array = array.astype(np.float64)
    array = array.reshape(-1) if len(shape) == 1 else array
    array = array[0] if array.ndim == 3 and array.shape[0] == 1 else array
    if array.shape != shape:
        raise InputError(
            "%s has the shape %s, expected %s"
            % (source, "x".join(map(str, array.shape)), "x".join(map(str, shape)))
        )
    if not np.isfinite(array).all():
        raise InputError(
            "%s holds %s, expected finite numbers"
            % (source, array.reshape(-1)[~np.isfinite(array.reshape(-1))][0])
        )
    return array
