"""The motion of a calibrated camera between two images, as selectors return it."""

import collections

import numpy as np

from . import _arrays, _core

Pose = collections.namedtuple("Pose", "rotation translation")
Pose.__doc__ = """A pose of the right camera relative to the left one, up to scale.

A point X of the left camera lies at rotation @ X + z * translation in the frame of the right one, with unknown z > 0.

rotation      3 x 3
translation   3 numbers, of length 1 or 0
"""


class _Value:
    """A value: its attributes are read-only, and those with the same numbers, by _numbers(), are equal."""

    __slots__ = ()

    def __setattr__(self, name, value):
        kind = type(self).__name__
        raise AttributeError("attributes of %s cannot be replaced; make a new %s" % (kind, kind))

    def __eq__(self, other):
        if not isinstance(other, type(self)):
            return NotImplemented
        return self._numbers() == other._numbers()

    def __hash__(self):
        return hash(self._numbers())

    def __reduce__(self):
        return _value_from, (type(self), {name: getattr(self, name) for name in self.__slots__})

    def _numbers(self):
        raise NotImplementedError


def _value_from(kind, values):
    return kind(**values)


class PosePrior(_Value):
    """What is known of the motion between two images besides their matches: exactly one of

    rotation     3 x 3: the rotation of a Pose, for example from an inertial unit
    vertical     (down_left, down_right): the same direction, such as that of gravity, in the frames of both cameras,
                 two vectors of 3 numbers and of any length
    rig          (rotation, translation): the pose of a calibrated rig. The translation, of any length above 0, may be
                 the baseline

    What is known is taken as exact: its error should be small against a pixel. Attributes are read-only arrays, or
    tuples of two, or None; directions have length 1.

    Raises TypeError for anything but numbers, and ValueError naming the argument for another shape, for numbers that
    are not finite, for a matrix that is no rotation, and unless exactly one is given.
    """

    __slots__ = ("rotation", "vertical", "rig")

    def __init__(self, *, rotation=None, vertical=None, rig=None):
        values = {"rotation": rotation, "vertical": vertical, "rig": rig}
        given = [name for name, value in values.items() if value is not None]
        if len(given) != 1:
            raise ValueError(
                "%s given; needed: exactly one of rotation, vertical and rig"
                % (" and ".join(given) + " are" if given else "nothing is")
            )
        if rotation is not None:
            values["rotation"] = _rotation("rotation", rotation)
        elif vertical is not None:
            left, right = _two("vertical", vertical, "(down_left, down_right)")
            values["vertical"] = _direction("vertical[0]", left), _direction("vertical[1]", right)
        else:
            turn, shift = _two("rig", rig, "(rotation, translation)")
            values["rig"] = _rotation("rig[0]", turn), _direction("rig[1]", shift)
        for name, value in values.items():
            object.__setattr__(self, name, value)
        _core.check_prior(self)

    def __repr__(self):
        return "<corrsel.PosePrior: %s>" % self._kind()

    def _kind(self):
        return next(name for name in self.__slots__ if getattr(self, name) is not None)

    def _numbers(self):
        kind = self._kind()
        value = getattr(self, kind)
        parts = (value,) if kind == "rotation" else value
        return (kind,) + tuple(number for part in parts for number in part.ravel().tolist())


class MotionGuess(_Value):
    """What is believed of the motion between two images before they are matched, for example from a gyroscope, or
    because the camera goes on as it did before. It is never taken as true: it tells where to look first, and is tested.
    What is known exactly is a PosePrior.

    rotation        3 x 3: the rotation of a Pose
    translation     3 numbers, of any length above 0: the direction of the translation of a Pose, or None where it is
                    not known
    rotation_sigma  standard deviation of the rotation about every axis, rad; at least 0

    Attributes are read-only; the translation has length 1.

    Raises TypeError for anything but numbers, and ValueError naming the argument for another shape, for numbers that
    are not finite, for a matrix that is no rotation, for a translation of length 0, and for a negative deviation.
    """

    __slots__ = ("rotation", "translation", "rotation_sigma")

    def __init__(self, rotation, *, translation=None, rotation_sigma=0.0):
        for name, value in (
            ("rotation", _rotation("rotation", rotation)),
            ("translation", None if translation is None else _direction("translation", translation)),
            ("rotation_sigma", float(_arrays.reals("rotation_sigma", rotation_sigma, ()))),
        ):
            object.__setattr__(self, name, value)
        _core.check_guess(self)

    def __repr__(self):
        text = "rotation by %.3g degrees" % np.degrees(_angle(self.rotation))
        if self.translation is not None:
            text += ", translation [%.3f, %.3f, %.3f]" % tuple(self.translation)
        return "<corrsel.MotionGuess: %s, rotation_sigma %.3g rad>" % (text, self.rotation_sigma)

    def _numbers(self):
        shift = None if self.translation is None else tuple(self.translation.tolist())
        return tuple(self.rotation.ravel().tolist()), shift, self.rotation_sigma


def _angle(rotation):
    """Return the angle of a rotation, rad."""
    return np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))


def _two(name, values, meaning):
    try:
        first, second = values
    except (TypeError, ValueError):
        raise ValueError("%s is %r; needed: %s" % (name, values, meaning)) from None
    return first, second


def _rotation(name, values):
    array = _arrays.matrix(name, values)
    array.setflags(write=False)
    return array


def _direction(name, values):
    array = _arrays.reals(name, values, (3,))
    length = np.linalg.norm(array)
    if not (np.isfinite(length) and length > 0):
        raise ValueError("%s is %s; needed: finite numbers that are not all 0" % (name, array.tolist()))
    if abs(length - 1) > 1e-15:  # so that a copy is the same
        array = array / length
    array.setflags(write=False)
    return array


class PoseResult:
    """What a calibrated selector found out about the motion between two images.

    motion       "none" (no motion of a camera explains more matches than chance), "rest" (neither turned nor
                 translated), "rotation" (turned; a translation does not show), "general" (translated, in a scene with
                 depth) or "planar" (translated before a plane, or before a scene whose depth does not show)
    rotation     3 x 3: a point X of the left camera lies at rotation @ X + z * translation in the frame of the right
                 one, with unknown z > 0. The identity for "none" and "rest"
    translation  3 numbers: a direction, of length 1, for "general" and "planar", otherwise zero
    basis        the directions b1 and b2, orthogonal to the translation, by which the covariance measures it: 2 x 3.
                 None where the translation is zero
    covariance   5 x 5, in the order w1, w2, w3, a, b, rad: the true rotation is exp([w]x) @ rotation, with w in the
                 frame of the right camera, and the true translation is the direction of translation + a b1 + b b2.
                 Without a translation the rows and columns of a and b are nan; where no covariance holds, all are.
                 It is 0 in directions that are known by a PosePrior
    uncertain    whether outliers that agree by chance are so many that no covariance holds
    noise        standard deviation of each coordinate of a feature, px; nan where it is not known
    parallax     root mean square of the displacements that the rotation does not explain, px; nan for "none"
    second       "planar": the other Pose that explains the plane, where the matches do not exclude it. None otherwise
    """

    __slots__ = (
        "motion",
        "rotation",
        "translation",
        "basis",
        "covariance",
        "uncertain",
        "noise",
        "parallax",
        "second",
    )

    def __init__(self, **values):
        for name in PoseResult.__slots__:
            setattr(self, name, values[name])

    @classmethod
    def from_core(cls, values):
        """Return the PoseResult of what C++ returns, a dictionary or None."""
        if values is None:
            return None
        second = values["second"]
        return cls(**dict(values, second=None if second is None else Pose(*second)))

    def __repr__(self):
        turned = np.degrees(_angle(self.rotation))
        return "<corrsel.%s: %s, rotation by %.3g degrees, translation [%.3f, %.3f, %.3f]%s>" % (
            (type(self).__name__, self.motion, turned)
            + tuple(self.translation)
            + (", uncertain" if self.uncertain else "",)
        )


class RelativePose(PoseResult):
    """The PoseResult of relative_pose(), and how it came about.

    mask         True where the match agrees with the pose: N, bool
    status, confidence, message   as those of Selection; where the status is "too_few", "degenerate" or another one
                 without a result, motion is "none"
    """

    __slots__ = ("mask", "status", "confidence", "message")

    def __init__(self, selection):
        pose = selection.pose
        super().__init__(
            **{name: value if pose is None else getattr(pose, name) for name, value in _no_pose().items()}
        )
        for name in self.__slots__:
            setattr(self, name, getattr(selection, name))


def _no_pose():
    """Return the members of a PoseResult that knows nothing."""
    return {
        "motion": "none",
        "rotation": np.eye(3),
        "translation": np.zeros(3),
        "basis": None,
        "covariance": np.full((5, 5), np.nan),
        "uncertain": False,
        "noise": np.nan,
        "parallax": np.nan,
        "second": None,
    }
