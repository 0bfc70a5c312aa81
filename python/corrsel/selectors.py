"""Putative matches, selectors and their results."""

import numpy as np

from . import _arrays, _core, _options
from .camera import Camera
from .pose import MotionGuess, PosePrior, PoseResult, RelativePose

_COLUMNS = (
    "left",
    "right",
    "distance",
    "second_distance",
    "probability",
    "left_frame",
    "right_frame",
    "left_index",
    "right_index",
)
_OF_IMAGES = ("left_size", "right_size", "left_camera", "right_camera", "prior", "guess")


class Matches:
    """Putative matches between two images. Row i of every array belongs to match i.

    left, right       positions, px, (x, y) with the origin at the centre of the first pixel: N x 2
    distance          descriptor distance to the nearest neighbour, in the metric's unit: N, or None
    second_distance   distance to the second-nearest neighbour, NaN where there is none: N, or None
    probability       of a learned matcher: that the match is right, from 0 to 1, NaN where it is not known: N, or None.
                      Selectors that begin with the best matches order by it where there are no distances
    left_frame, right_frame   local affine frames [[a11, a12, x], [a21, a22, y]], which map the unit disc to the
                      feature's ellipse, px: N x 2 x 3, or None
    left_index, right_index   numbers of the features in their images: N, or None
    left_size, right_size     image sizes (width, height), px, or None where unknown
    left_camera, right_camera   Camera of each image, or None: calibrated selectors such as "pose" need both
    prior             PosePrior: what is known of the motion, or None. The selector "pose" uses it
    guess             MotionGuess: what is believed of the motion, or None. The selectors "pose" and "auto" test it

    Real numbers are kept as float32 (float64 is converted), feature numbers as uint32. Arrays of those types are not
    copied. `matches[rows]` has the rows that a mask, a slice or an array of row numbers names. Attributes cannot be
    replaced.

    Raises TypeError for arrays of another dtype and ValueError for another shape or length or for a probability outside
    0 to 1, naming the argument.
    """

    __slots__ = _COLUMNS + _OF_IMAGES

    def __init__(
        self,
        left,
        right,
        *,
        distance=None,
        second_distance=None,
        probability=None,
        left_frame=None,
        right_frame=None,
        left_index=None,
        right_index=None,
        left_size=None,
        right_size=None,
        left_camera=None,
        right_camera=None,
        prior=None,
        guess=None
    ):
        point, one = "one row (x, y) per match", "one element per match"
        frame = "one frame [[a11, a12, x], [a21, a22, y]] per match"
        left = _arrays.floats("left", left, (None, 2), point)
        rows = len(left)

        def column(name, values, shape, meaning):
            return None if values is None else _arrays.floats(name, values, shape, meaning, rows)

        def index(name, values):
            return None if values is None else _arrays.numbers(name, values, one, rows)

        for name, value in (
            ("left", left),
            ("right", _arrays.floats("right", right, (None, 2), point, rows)),
            ("distance", column("distance", distance, (None,), one)),
            ("second_distance", column("second_distance", second_distance, (None,), one)),
            ("probability", _probability(column("probability", probability, (None,), one))),
            ("left_frame", column("left_frame", left_frame, (None, 2, 3), frame)),
            ("right_frame", column("right_frame", right_frame, (None, 2, 3), frame)),
            ("left_index", index("left_index", left_index)),
            ("right_index", index("right_index", right_index)),
            ("left_size", _arrays.size("left_size", left_size)),
            ("right_size", _arrays.size("right_size", right_size)),
            ("left_camera", _camera("left_camera", left_camera)),
            ("right_camera", _camera("right_camera", right_camera)),
            ("prior", _prior(prior)),
            ("guess", _guess(guess)),
        ):
            object.__setattr__(self, name, value)

    def select(self, selector, **options):
        """Return the Selection of a selector, e.g. matches.select("gms", alpha=6). See corrsel.select()."""
        return Selector(selector, **options).select(self)

    def with_cameras(self, left_camera, right_camera):
        """Return the same matches, whose arrays are shared, with the Camera of each image, e.g. for select("pose")."""
        values = {name: getattr(self, name) for name in self.__slots__}
        return Matches(**dict(values, left_camera=left_camera, right_camera=right_camera))

    def __setattr__(self, name, value):
        raise AttributeError("attributes of Matches cannot be replaced; make new Matches")

    def __len__(self):
        return len(self.left)

    def __getitem__(self, rows):
        if not isinstance(rows, slice):
            rows = np.asarray(rows)
            if rows.size == 0 and rows.dtype.kind != "b":
                rows = rows.astype(np.intp)
            if rows.ndim != 1:
                raise TypeError("matches[...] needs a slice, a mask or an array of row numbers")
        values = {name: getattr(self, name) for name in self.__slots__}
        for name in _COLUMNS:
            if values[name] is not None:
                values[name] = values[name][rows]
        return Matches(**values)

    def __reduce__(self):
        return _matches_from, ({name: getattr(self, name) for name in self.__slots__},)

    def __repr__(self):
        columns = [name for name in _COLUMNS[2:] if getattr(self, name) is not None]
        known = [name for name in _OF_IMAGES[2:] if getattr(self, name) is not None]
        return "<corrsel.Matches: %d matches with %s, %s and %s>" % (
            len(self),
            ", ".join(columns + known) or "positions only",
            "left_size=%s" % (self.left_size,),
            "right_size=%s" % (self.right_size,),
        )


def check_views(left_camera, right_camera, guess):
    """Raise the TypeError of Matches unless these are of the right types or None."""
    _camera("left_camera", left_camera)
    _camera("right_camera", right_camera)
    _guess(guess)


def _matches_from(columns):
    return Matches(**columns)


def _probability(values):
    if values is not None:
        wrong = np.flatnonzero(~(np.isnan(values) | ((values >= 0) & (values <= 1))))
        if wrong.size:
            raise ValueError(
                "probability holds %g in row %d; needed: 0 to 1, or NaN where it is not known"
                % (values[wrong[0]], wrong[0])
            )
    return values


def _camera(name, value):
    return None if value is None else _require_camera(name, value)


def _prior(value):
    if value is not None and not isinstance(value, PosePrior):
        raise TypeError("prior is %s; needed: corrsel.PosePrior" % type(value).__name__)
    return value


def _guess(value):
    if value is not None and not isinstance(value, MotionGuess):
        raise TypeError("guess is %s; needed: corrsel.MotionGuess" % type(value).__name__)
    return value


def _require_camera(name, value):
    if not isinstance(value, Camera):
        raise TypeError(
            "%s is %s; needed: corrsel.Camera, e.g. corrsel.Camera.from_opencv(matrix, distortion)"
            % (name, type(value).__name__)
        )
    return value


class Selection:
    """The result of a selector.

    mask         True where the match is selected: N, bool
    score        per match, higher is better, its meaning given by the selector; NaN = none: N, float32, or None
    group        per match, number of the model that a selected match belongs to, counted from 0 in the order in which
                 the selector finds them; -1 = not selected, or selected without a model: N, int32. None if the selector
                 finds one model or none. The matches of the second plane of "planes": matches[selection.group == 1]
    motion       per group what it does: a tuple of "static", "moving" or "unknown". None before label_motion()
    model        left to right, 3 x 3, float64, or None: x' ~ H x of a homography, x'^T F x = 0 of a fundamental matrix;
                 with the unit rays d of calibrated cameras, d'^T E d = 0 of an essential matrix, d' = R d of a rotation
    model_kind   "none", "homography", "fundamental", "essential" or "rotation"
    status       "ok"; "too_few", "degenerate", "no_model", "unsupported_input" (a column, an image size or a camera is
                 missing), "too_large", "time_limit" (stopped at max_seconds: the best result so far), "failed" or
                 "uncertain" (the confidence is below min_confidence; mask and model are there, but should not be relied
                 on)
    scene        what the matches show, as far as the selector finds it out ("auto" does): "unknown"; "nothing" (chance
                 explains all that agrees), "at_rest" (nothing has moved), "plane_or_rotation", "rigid" (with depth) or
                 "several_motions"
    confidence   -log10 of the number of agreements as good as this one that are expected by chance; nan where it could
                 not be computed (status "failed" or "unsupported_input")
    sigma        noise of the inliers of the model: standard deviation of each coordinate of their residual, px; nan where
                 there is no model, and where nobody has computed it
    probability  per match, selected or not, the probability that it is right: N, float32; 0 where nothing was found, and
                 for matches that were ignored. None where nobody has computed it: "auto" does, add_probability() does
                 for the others
    pose         of calibrated selectors, such as "pose": the PoseResult; None of others, and without a result
    guess        what the matches show about the guess of Matches, of selectors that test it ("pose" and "auto"): "none"
                 (there was no guess, or nothing has tested it), "confirmed" (they agree with its rotation) or
                 "contradicted" (they show another rotation)
    message      one sentence that explains the status; may be empty
    seconds      wall time, s
    iterations   hypotheses, EM steps or passes: the selector's own count
    n_input, n_ignored, n_selected   number of matches given, of those ignored beforehand because a coordinate is NaN,
                 infinite or beyond 1e6 px, and of those selected
    """

    __slots__ = (
        "mask",
        "score",
        "group",
        "motion",
        "model",
        "model_kind",
        "status",
        "scene",
        "confidence",
        "sigma",
        "probability",
        "pose",
        "guess",
        "message",
        "seconds",
        "iterations",
        "n_input",
        "n_ignored",
        "n_selected",
    )

    def __init__(self, **values):
        for name in self.__slots__:
            setattr(self, name, values[name])

    def __repr__(self):
        return "<corrsel.Selection: %s, %d of %d matches selected, model %s, %.3g ms%s>" % (
            self.status,
            self.n_selected,
            self.n_input,
            self.model_kind,
            1000 * self.seconds,
            ": " + self.message if self.message else "",
        )


class Selector:
    """A selector with its options, for use on many sets of matches, from any thread.

    name      a selector of selector_names(), optionally with a preset of selector_presets() and with options in
              brackets: "gms", "lpm:v2", "lpm[lambda_first=4;lambda_second=4]"
    options   by keyword, on top of those of the preset; those in brackets win. See options(name) or
              help(corrsel.select)

    Raises ValueError for an unknown name, preset or option, listing the valid ones, and for an option that is out of
    its range.
    """

    def __init__(self, name, **options):
        self._selector = _core.Selector(name, _options.to_text(name, options))

    @property
    def name(self):
        """Name without preset."""
        return self._selector.name()

    @property
    def options(self):
        """The options in force: a list of Option."""
        return _options.options_from(self._selector.options())

    def select(self, matches):
        """Return the Selection for Matches. It never raises on data: the status of the Selection reports problems.

        Other Python threads run while the selector works. The same matches and options give the same mask, score and
        model, bit for bit, whatever the thread. KeyboardInterrupt comes after the selector has ended; give
        max_seconds where that matters.
        """
        if not isinstance(matches, Matches):
            raise TypeError(
                "matches is %s; needed: corrsel.Matches, e.g. corrsel.Matches(left, right)"
                % type(matches).__name__
            )
        values = self._selector.select(matches)
        return Selection(**dict(values, pose=PoseResult.from_core(values["pose"])))

    def __repr__(self):
        values = ", ".join(
            "%s=%r" % (_options.keyword_of(option.name), option.value) for option in self.options
        )
        return "<corrsel.Selector %s: %s>" % (self.name, values)


def select(
    left,
    right,
    selector,
    *,
    left_size=None,
    right_size=None,
    distance=None,
    second_distance=None,
    probability=None,
    left_frame=None,
    right_frame=None,
    left_index=None,
    right_index=None,
    left_camera=None,
    right_camera=None,
    **options
):
    """Decide which of N putative matches are correct. Return a Selection with mask, score, model, status and message.

    left, right       positions, px, (x, y) with the origin at the centre of the first pixel: N x 2, float32 or float64
                      (kept in single precision)
    selector          a name of selector_names(), optionally with a preset: "gms", "lpm:v2", "ransac:f"
    left_size, right_size       image sizes (width, height), px
    distance, second_distance   descriptor distances to the nearest and to the second-nearest neighbour: N
    probability                 of a learned matcher: that the match is right, 0 to 1, or NaN where it is not known: N
    left_frame, right_frame     local affine frames [[a11, a12, x], [a21, a22, y]], px: N x 2 x 3
    left_index, right_index     numbers of the features in their images: N
    left_camera, right_camera   Camera of each image, which calibrated selectors need
    options           of the selector, by keyword; lambda and global, words of Python, are written lambda_ and global_

    Matches with a coordinate that is NaN, infinite or beyond 1e6 px are not selected and do not influence the others.
    A column or camera that the selector needs and does not get gives the status "unsupported_input".

    This is Selector(selector, **options).select(Matches(left, right, ...)). Results are reproducible bit for bit:
    random numbers come from the option seed. Other Python threads run in the meantime.

    Raises TypeError for arrays of another dtype; ValueError for arrays of another shape or length, naming the argument,
    and for an unknown selector, preset or option or an option out of its range.

    Selectors group by group, with the columns that they need, their presets, and their options with defaults and
    ranges:
    """
    return Matches(
        left,
        right,
        distance=distance,
        second_distance=second_distance,
        probability=probability,
        left_frame=left_frame,
        right_frame=right_frame,
        left_index=left_index,
        right_index=right_index,
        left_size=left_size,
        right_size=right_size,
        left_camera=left_camera,
        right_camera=right_camera,
    ).select(selector, **options)


def relative_pose(
    left,
    right,
    camera_left,
    camera_right,
    *,
    distance=None,
    second_distance=None,
    probability=None,
    left_frame=None,
    right_frame=None,
    left_index=None,
    right_index=None,
    left_size=None,
    right_size=None,
    rotation=None,
    vertical=None,
    rig=None,
    **options
):
    """Return the RelativePose between two calibrated images, of N putative matches: how the camera has moved, with its
    covariance, and the mask of the matches that agree.

    left, right    positions in the images as they are, distorted or not, px: N x 2, float32 or float64
    camera_left, camera_right   Camera of each image
    distance, second_distance   descriptor distances: N. The search is faster with them, as it tries the best ratios
                   first; `probability` of a learned matcher serves it as well. They and the other columns are those of select()
    rotation       the known rotation, 3 x 3; two matches then determine the direction of the translation
    vertical       (down_left, down_right), the same known direction in both cameras; three matches then do
    rig            (rotation, translation), the known pose: nothing is searched, matches are judged by it. At most one
                   of the three is given. They are taken as exact, and are those of PosePrior
    options        of the selector "pose", by keyword: threshold, seed, max_seconds...; see options("pose")

    Data never raise an exception: look at motion, and at status. This is
    Matches(left, right, ..., left_camera=camera_left, right_camera=camera_right, prior=PosePrior(...))
    .select("pose", **options) with its pose and mask.

    Raises TypeError for a camera that is not a Camera and for arrays of another dtype; ValueError for arrays of another
    shape or length, naming the argument, and for an unknown option or one out of its range.
    """
    for name, camera in (("camera_left", camera_left), ("camera_right", camera_right)):
        _require_camera(name, camera)
    known = {"rotation": rotation, "vertical": vertical, "rig": rig}
    return RelativePose(
        Matches(
            left,
            right,
            distance=distance,
            second_distance=second_distance,
            probability=probability,
            left_frame=left_frame,
            right_frame=right_frame,
            left_index=left_index,
            right_index=right_index,
            left_size=left_size,
            right_size=right_size,
            left_camera=camera_left,
            right_camera=camera_right,
            prior=None if all(value is None for value in known.values()) else PosePrior(**known),
        ).select("pose", **options)
    )


def add_probability(matches, selection):
    """Compute sigma and probability of a Selection, by the same definition for every selector, and store them in it.

    matches     those that the selector was given
    selection   of these matches; one that has a probability already stays as it is, and so does one with the status
                "failed" or "unsupported_input"
    """
    _require_selection(matches, selection)
    if selection.probability is None:
        selection.confidence, selection.sigma, selection.probability = _core.probability_of(
            matches, selection
        )


def label_motion(matches, selection):
    """Find out which groups of a Selection are the scene, which stands still, and which are objects that move.

    It fills selection.motion, and adds groups of objects that the selector has not found to selection.group and
    selection.mask. A selection without groups gets them. docs/selectors.md describes what two images can show. The
    matches of moving objects:

        moving = np.isin(selection.group, [g for g, m in enumerate(selection.motion) if m == "moving"])

    matches     those that the selector was given
    selection   of these matches; one that has been labelled already stays as it is
    """
    _require_selection(matches, selection)
    if selection.motion is None:
        selection.mask, selection.group, selection.motion = _core.motion_of(matches, selection)
        selection.n_selected = int(np.count_nonzero(selection.mask))


def _require_selection(matches, selection):
    if not isinstance(matches, Matches):
        raise TypeError("matches is %s; needed: corrsel.Matches" % type(matches).__name__)
    if not isinstance(selection, Selection):
        raise TypeError("selection is %s; needed: corrsel.Selection" % type(selection).__name__)
    if len(selection.mask) != len(matches):
        raise ValueError(
            "the selection is of %d matches, but there are %d; give the matches that the selector was given"
            % (len(selection.mask), len(matches))
        )


def selector_names():
    """Return the names of all selectors, group by group; keep_all, which selects every match, comes last."""
    return _core.selector_names()


def selector_groups():
    """Return the names of the selectors by what they do, a dict: {"paper": [...], "consensus": [...], ...}.

    The groups are paper (the eight of Zhao et al.), consensus, local, multi-structure, automatic, reference (further
    published methods, for comparison) and baseline. help(corrsel.select) tells what the selectors of a group have in common.
    """
    groups = {}
    for group, _, name, _ in _core.selector_list():
        groups.setdefault(group, []).append(name)
    return groups


def selector_presets(name):
    """Return the presets of a selector, to be used as "name:preset". Raises ValueError for an unknown name."""
    return _core.selector_presets(name)


def _selectors_text():
    parts, group = [], None
    for name_of_group, meaning_of_group, name, meaning in _core.selector_list():
        if name_of_group != group:
            group = name_of_group
            parts.append("\n    %s (%s)\n" % (group, meaning_of_group))
        parts.append("    %s: %s" % (name, meaning))
        presets = ["%s:%s" % (name, preset) for preset in selector_presets(name)]
        for title, items in (("needs", _core.Selector(name, {}).needed_input()), ("presets", presets)):
            if items:
                parts.append("        %s: %s" % (title, ", ".join(items)))
        parts.append(_options.describe(_options.options(name), " " * 8))
    return "\n".join(part for part in parts if part)


if select.__doc__:  # there is none under python3 -OO
    select.__doc__ = "%s\n%s\n    " % (select.__doc__.rstrip(), _selectors_text())
