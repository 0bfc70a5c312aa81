"""From images to features and to putative matches."""

import numpy as np

from . import _arrays, _features, _options
from .selectors import Matches, check_views


class Features:
    """Features of one image. Row i of every array belongs to feature i.

    points        positions, px, (x, y) with the origin at the centre of the first pixel: N x 2, float32
    descriptors   N x D; float32 is compared by L2, uint8 by Hamming distance
    frame         local affine frames [[a11, a12, x], [a21, a22, y]], which map the unit disc to the feature's ellipse,
                  px: N x 2 x 3, float32, or None
    size          diameter, px: N, float32, or None
    angle         degrees as in OpenCV: N, float32, or None
    response      strength, the detector's own measure: N, float32, or None
    octave        N, int32, or None
    image_size    (width, height), px, or None where unknown
    detect_seconds, describe_seconds   wall times, s; describe_seconds is 0 where one pass does both

    extract() makes them; make them yourself to match features of another source with match_features(). Raises
    TypeError for arrays of another dtype and ValueError for another shape or length, naming the argument.
    """

    __slots__ = (
        "points",
        "descriptors",
        "frame",
        "size",
        "angle",
        "response",
        "octave",
        "image_size",
        "detect_seconds",
        "describe_seconds",
    )

    def __init__(
        self,
        points,
        descriptors,
        *,
        frame=None,
        size=None,
        angle=None,
        response=None,
        octave=None,
        image_size=None,
        detect_seconds=0.0,
        describe_seconds=0.0
    ):
        one = "one element per feature"
        self.points = _arrays.floats("points", points, (None, 2), "one row (x, y) per feature")
        rows = len(self.points)

        def column(name, values, shape=(None,), meaning=one):
            return None if values is None else _arrays.floats(name, values, shape, meaning, rows)

        descriptors = np.asarray(descriptors)
        if descriptors.dtype == np.uint8:
            if descriptors.ndim != 2 or len(descriptors) != rows:
                raise ValueError(
                    "descriptors has shape %s; needed: (%d, D), one row per feature"
                    % (descriptors.shape, rows)
                )
            self.descriptors = descriptors
        else:
            self.descriptors = column("descriptors", descriptors, (None, None), "one row per feature")
        self.frame = column(
            "frame", frame, (None, 2, 3), "one frame [[a11, a12, x], [a21, a22, y]] per feature"
        )
        self.size = column("size", size)
        self.angle = column("angle", angle)
        self.response = column("response", response)
        self.octave = None if octave is None else np.asarray(octave)
        self.image_size = _arrays.size("image_size", image_size)
        self.detect_seconds = detect_seconds
        self.describe_seconds = describe_seconds

    def __len__(self):
        return len(self.points)

    def __repr__(self):
        return "<corrsel.Features: %d features with %d-dimensional descriptors of type %s, image_size=%s>" % (
            len(self),
            self.descriptors.shape[1],
            self.descriptors.dtype,
            self.image_size,
        )


class Extractor:
    """A detector with a descriptor and their options, for use on many images, from any thread.

    features     "detector+descriptor", e.g. "orb+orb" or "hessian_affine+sift": see extractor_names()
    algorithms   options as dictionaries, by the name of the algorithm: sift={"max_features": 2000}; those of "image",
                 image={"equalize": "clahe"}, belong to every pairing

    Raises ValueError for names that do not exist, listing those that do, for pairings that cannot work, for options of
    an algorithm that is not part of the pairing, and for options that are unknown or out of their range.
    """

    def __init__(self, features="sift+sift", **algorithms):
        texts = {}
        for name, options in algorithms.items():
            if not isinstance(options, dict):
                raise TypeError(
                    '%s is %r; needed: a dictionary, e.g. {"max_features": 1000}' % (name, options)
                )
            texts[name] = _options.to_text(name, options)
        self._extractor = _features.Extractor(features, texts)
        parts = _features.algorithms_of(features)
        for name in algorithms:
            if name not in parts + ["image"]:
                raise ValueError(
                    "options of '%s', but %s is made of %s" % (name, features, " and ".join(parts))
                )

    @property
    def name(self):
        """The pairing: "detector+descriptor"."""
        return self._extractor.name()

    @property
    def options(self):
        """The options in force: lists of Option by the name of the algorithm."""
        return {name: _options.options_from(rows) for name, rows in self._extractor.options().items()}

    def extract(self, image, *, mask=None, area=None, threads=1):
        """Return the Features of an image. See corrsel.extract()."""
        return Features(
            **self._extractor.extract(
                _arrays.image("image", image),
                _arrays.image_mask("mask", mask),
                _arrays.area("area", area),
                _arrays.threads(threads),
            )
        )

    def match(
        self,
        image_left,
        image_right,
        *,
        left_mask=None,
        right_mask=None,
        left_area=None,
        right_area=None,
        left_camera=None,
        right_camera=None,
        guess=None,
        threads=1,
        **options
    ):
        """Return the Matches of two images. See corrsel.match()."""
        return Matches(
            left_camera=left_camera,
            right_camera=right_camera,
            guess=guess,
            **self._extractor.match(
                _arrays.image("image_left", image_left),
                _arrays.image("image_right", image_right),
                _arrays.image_mask("left_mask", left_mask),
                _arrays.image_mask("right_mask", right_mask),
                _arrays.area("left_area", left_area),
                _arrays.area("right_area", right_area),
                _guidance(left_camera, right_camera, guess),
                _options.to_text("match", options),
                _arrays.threads(threads),
            )
        )

    def __repr__(self):
        return "<corrsel.Extractor %s>" % self.name


def extract(image, features="sift+sift", *, mask=None, area=None, threads=1, **algorithms):
    """Return the Features of an image: points, frames, descriptors; the strongest feature comes first.

    image        uint8 or uint16: height x width (grey), height x width x 3 (BGR, as OpenCV reads it) or x 4 (BGRA).
                 Grey uint8 is used without a copy where the elements of a row are adjacent, as in image[y:y2, x:x2]. A
                 value v of uint16 becomes v / 257, rounded: 65535 becomes 255. Shift the values of a camera with 10,
                 12 or 14 bits up first, by image << (16 - bits), or its images are dark
    features     "detector+descriptor", e.g. "orb+orb" or "hessian_affine+sift": see extractor_names()
    mask         height x width, bool or uint8: features whose centre lies on a zero are dropped
    area         (x, y, width, height), px: only this part is looked at; what reaches over the image is cut off
    threads      threads that may be used; the result does not depend on it. Threads are kept for the next call; a
                 process that was forked after a call with more than one thread must not use more than one
    algorithms   options as dictionaries, by the name of the algorithm: sift={"max_features": 2000}; options("sift")
                 lists them. Those of "image", which has the name of a parameter here, are given to an Extractor:
                 Extractor(features, image={"equalize": "clahe"}).extract(image)

    An image without texture gives no features. Other Python threads run in the meantime.

    Raises TypeError for arrays of another dtype; ValueError for arrays of another shape, for names that do not exist,
    for pairings that cannot work, and for options that are unknown or out of their range.
    """
    return Extractor(features, **algorithms).extract(image, mask=mask, area=area, threads=threads)


def match(
    image_left,
    image_right,
    features="sift+sift",
    *,
    left_mask=None,
    right_mask=None,
    left_area=None,
    right_area=None,
    left_camera=None,
    right_camera=None,
    guess=None,
    threads=1,
    **options
):
    """Return the putative Matches of two images, with all columns: for every left feature the nearest right one.

    image_left, image_right   uint8 or uint16: height x width (grey), height x width x 3 (BGR, as OpenCV reads it) or
                 x 4 (BGRA); see extract()
    features     "detector+descriptor", e.g. "orb+orb" or "hessian_affine+sift": see extractor_names()
    left_mask, right_mask     height x width, bool or uint8: features whose centre lies on a zero are dropped
    left_area, right_area     (x, y, width, height), px: only this part is looked at
    left_camera, right_camera   Camera of each image as it is; the Matches have them
    guess        MotionGuess: what is believed of the motion. It needs both cameras. Features are compared with those near
                 their predicted places only, unless a test of some features by all others shows that it is wrong; then
                 the matches are those without it. The Matches have the guess, so that select("pose") tests it, too, and
                 reports what it found as Selection.guess
    threads      threads that may be used; the result does not depend on it. Threads are kept for the next call; a
                 process that was forked after a call with more than one thread must not use more than one
    options      of the matching, by keyword; and, as dictionaries, of the algorithms that make the features:
                 mutual=True, sift={"max_features": 2000}; options("sift") lists the latter

    The search is exact, O(N_left N_right) without a guess, and without a ratio test: several left features may have the
    same right one. Other Python threads run in the meantime.

    Raises TypeError for arrays of another dtype, and for cameras and guesses of another type; ValueError for arrays of
    another shape, for a guess without both cameras, for names that do not exist, for pairings that cannot work, and for
    options that are unknown or out of their range.

    Options of the matching, with defaults and ranges:
    """
    algorithms = {name: value for name, value in options.items() if isinstance(value, dict)}
    return Extractor(features, **algorithms).match(
        image_left,
        image_right,
        left_mask=left_mask,
        right_mask=right_mask,
        left_area=left_area,
        right_area=right_area,
        left_camera=left_camera,
        right_camera=right_camera,
        guess=guess,
        threads=threads,
        **{name: value for name, value in options.items() if name not in algorithms}
    )


def match_features(left, right, *, left_camera=None, right_camera=None, guess=None, threads=1, **options):
    """Return the putative Matches between two Features: for every left feature the nearest right one.

    left, right   Features with descriptors of the same type and length; several left features may have the same right
                  one. Descriptors that hold NaN are in no match
    left_camera, right_camera, guess   as for match(). The guess is tested by the features with the highest response
    threads       threads that may be used; the result does not depend on it
    options       of the matching, by keyword: see help(corrsel.match)

    The matches have frames where both sides have them. The search is exact, O(N_left N_right) without a guess. Other
    Python threads run in the meantime.

    Raises TypeError for anything but Features and for cameras and guesses of another type, ValueError for descriptors
    that differ in type or length, for a guess without both cameras, and for options that are unknown or out of their
    range.
    """
    for name, value in (("left", left), ("right", right)):
        if not isinstance(value, Features):
            raise TypeError("%s is %s; needed: corrsel.Features" % (name, type(value).__name__))
    return Matches(
        left_camera=left_camera,
        right_camera=right_camera,
        guess=guess,
        **_features.match_features(
            left,
            right,
            _guidance(left_camera, right_camera, guess),
            _options.to_text("match", options),
            _arrays.threads(threads),
        )
    )


def _guidance(left_camera, right_camera, guess):
    """Return what matching in C++ takes as a guess, None or a tuple. Raises what match() raises."""
    check_views(left_camera, right_camera, guess)
    if guess is None:
        return None
    for name, camera in (("left_camera", left_camera), ("right_camera", right_camera)):
        if camera is None:
            raise ValueError("a guess is given, but no %s; a guess needs the cameras of both images" % name)
    return left_camera, right_camera, guess


def extractor_names():
    """Return pairings "detector+descriptor", the default first. Other pairings of detector_names() and
    descriptor_names() work too, unless extract() raises an error with the reason."""
    return _features.extractor_names()


def detector_names():
    """Return the names of all detectors."""
    return _features.detector_names()


def descriptor_names():
    """Return the names of all descriptors."""
    return _features.descriptor_names()


def missing_algorithms():
    """Return the detectors that this version of OpenCV lacks, as a dict from the name to the reason that extract()
    gives in its error."""
    return dict(_features.missing_algorithms())


if match.__doc__:  # there is none under python3 -OO
    match.__doc__ = "%s\n%s\n    " % (
        match.__doc__.rstrip(),
        _options.describe(_options.options("match"), " " * 8),
    )
