"""The motion of a calibrated camera between two images, as selectors return it."""

import collections

import numpy as np

Pose = collections.namedtuple("Pose", "rotation translation")
Pose.__doc__ = """A pose of the right camera relative to the left one, up to scale.

A point X of the left camera lies at rotation @ X + z * translation in the frame of the right one, with unknown z > 0.

rotation      3 x 3
translation   3 numbers, of length 1 or 0
"""


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
                 Without a translation the rows and columns of a and b are nan; where no covariance holds, all are
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
        turned = np.degrees(np.arccos(np.clip((np.trace(self.rotation) - 1) / 2, -1, 1)))
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
