"""Checks and conversions of arguments: messages name the argument, what came and what is needed."""

import numpy as np

LARGEST_SIDE = 2**31 - 1
LARGEST_NUMBER = 2**32 - 1


def floats(name, values, shape, meaning, rows=None, dtype=np.float32):
    """Return an array of real numbers as `dtype`, without a copy where it has that type already.

    `shape` is the expected shape with None for any length; `meaning` explains it in messages; `rows` is the expected
    number of rows. Raises TypeError for elements that are not float32 or float64, ValueError for another shape.
    """
    array = np.asarray(values)
    if array.dtype.kind != "f" or array.dtype.itemsize not in (4, 8):
        raise TypeError(
            "%s has dtype %s; needed: float32 or float64 (numpy.asarray(%s, numpy.float32) converts)"
            % (name, array.dtype, name)
        )
    _check_shape(name, array, shape, meaning, rows)
    with np.errstate(over="ignore"):  # becomes infinite, and such matches are set aside
        return np.require(array, dtype, "A")


def reals(name, values, shape, meaning=""):
    """Return an array of real numbers, also given as integers, as float64: a copy of its own.

    `shape` and `meaning` are those of floats(). Raises TypeError for elements that are no numbers, ValueError for
    another shape.
    """
    array = np.asarray(values)
    if array.size == 0:
        array = array.astype(np.float64)
    if array.dtype.kind not in "fiu":
        raise TypeError("%s has dtype %s; needed: real numbers" % (name, array.dtype))
    _check_shape(name, array, shape, meaning)
    return np.array(array, np.float64, order="C")


def matrix(name, values):
    """Return a 3 x 3 matrix of finite numbers as float64. Raises TypeError or ValueError for anything else."""
    array = reals(name, values, (3, 3))
    if not np.isfinite(array).all():
        raise ValueError("%s holds a number that is not finite" % name)
    return array


def numbers(name, values, meaning, rows=None):
    """Return a one-dimensional array of whole numbers as uint32.

    Raises TypeError for elements that are no integers, ValueError for another shape or numbers beyond uint32.
    """
    array = np.asarray(values)
    if array.shape == (0,):
        array = array.astype(np.uint32)
    if array.dtype.kind not in "iu":
        raise TypeError("%s has dtype %s; needed: an integer type" % (name, array.dtype))
    _check_shape(name, array, (None,), meaning, rows)
    if array.size and not (0 <= array.min() and array.max() <= LARGEST_NUMBER):
        raise ValueError(
            "%s holds numbers from %d to %d; needed: 0 to %d"
            % (name, array.min(), array.max(), LARGEST_NUMBER)
        )
    return np.require(array, np.uint32, "A")


def mask(name, values, rows):
    """Return a mask as an array of bool. Raises TypeError for another type than bool and uint8, ValueError for
    another shape."""
    array = np.asarray(values)
    if array.shape == (0,):
        array = array.astype(bool)
    if array.dtype not in (np.dtype(bool), np.dtype(np.uint8)):
        raise TypeError("%s has dtype %s; needed: bool or uint8" % (name, array.dtype))
    _check_shape(name, array, (None,), "one element per match", rows)
    return array.astype(bool, copy=False)


def image(name, values):
    """Return an image as an array of uint8 or uint16 whose rows are contiguous; rows may be padded.

    The array itself is returned where it has this form, e.g. a rectangle of another image; otherwise a copy.
    Raises TypeError or ValueError for anything else.
    """
    if values is None:
        raise TypeError(
            "%s is None; needed: an array of uint8 or uint16 (cv2.imread returns None for a file that it cannot read)"
            % name
        )
    array = np.asarray(values)
    if array.dtype not in (np.dtype(np.uint8), np.dtype(np.uint16)):
        raise TypeError(
            "%s has dtype %s; needed: uint8, values from 0 to 255, or uint16, values from 0 to 65535"
            % (name, array.dtype)
        )
    if array.ndim not in (2, 3) or array.ndim == 3 and array.shape[2] not in (1, 3, 4):
        raise ValueError(
            "%s has shape %s; needed: (height, width) for grey, (height, width, 3) for BGR or "
            "(height, width, 4) for BGRA" % (name, array.shape)
        )
    row = array[:1]
    if row.flags.c_contiguous and array.flags.aligned and array.strides[0] >= row.nbytes:
        return array
    return np.ascontiguousarray(array)


def image_mask(name, values):
    """Return a mask of an image as a contiguous array of uint8, or None."""
    if values is None:
        return None
    array = np.asarray(values)
    if array.dtype not in (np.dtype(bool), np.dtype(np.uint8)):
        raise TypeError("%s has dtype %s; needed: bool or uint8, 0 = no features here" % (name, array.dtype))
    if array.ndim != 2:
        raise ValueError("%s has shape %s; needed: (height, width) of the image" % (name, array.shape))
    return np.ascontiguousarray(array).view(np.uint8)


def size(name, values):
    """Return an image size as a tuple of two ints, or None. Raises TypeError or ValueError for anything else."""
    if values is None:
        return None
    array = np.asarray(values)
    if array.dtype.kind not in "iu":
        raise TypeError("%s is %r; needed: two integers (width, height), px" % (name, values))
    if array.shape != (2,) or array.min() < 0 or array.max() > LARGEST_SIDE:
        raise ValueError(
            "%s is %r; needed: (width, height), px; of an image as an array, image.shape[1::-1]"
            % (name, values)
        )
    return int(array[0]), int(array[1])


def area(name, values):
    """Return a part of an image as a tuple of four ints, or None. Raises TypeError or ValueError."""
    if values is None:
        return None
    array = np.asarray(values)
    if array.dtype.kind not in "iu":
        raise TypeError("%s is %r; needed: four integers (x, y, width, height), px" % (name, values))
    if array.shape != (4,) or np.abs(array).max() > LARGEST_SIDE:
        raise ValueError("%s is %r; needed: (x, y, width, height), px" % (name, values))
    return tuple(int(side) for side in array)


def threads(value):
    """Return a number of threads. Raises TypeError or ValueError for anything but an integer from 1."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError("threads is %r; needed: an integer" % (value,))
    if not 1 <= value <= LARGEST_SIDE:
        raise ValueError("threads is %d; needed: 1 or more" % value)
    return int(value)


def _check_shape(name, array, shape, meaning, rows=None):
    lengths = ", ".join("N" if length is None else str(length) for length in shape)
    expected = "(%s,)" % lengths if len(shape) == 1 else "(%s)" % lengths
    fits = array.ndim == len(shape) and all(
        length is None or length == actual for length, actual in zip(shape, array.shape)
    )
    if not fits:
        needed = ", ".join(part for part in (expected, meaning) if part)
        raise ValueError("%s has shape %s; needed: %s" % (name, array.shape, needed))
    if rows is not None and len(array) != rows:
        raise ValueError("%s has %d rows; needed: %d, %s" % (name, len(array), rows, meaning))
