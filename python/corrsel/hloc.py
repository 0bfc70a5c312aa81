"""A matcher for the configurations of hloc (Sarlin et al., CVPR 2019). corrsel.verify() verifies hloc's files.

    from corrsel import hloc as door

    conf = door.register("auto")                                    # a configuration of hloc.match_features
    hloc.match_features.main(conf, pairs, features, matches=matches)

Neither hloc nor torch is imported before register() is called.
"""

import importlib
import sys
import types

import numpy as np

from . import _doors
from .features import Features, match_features
from .files.hloc import MOST_KEYPOINTS
from .selectors import Selector

__all__ = ["match", "register"]


def match(data, selector="auto", **options):
    """Match the features of two images and keep what a selector keeps: what a matcher of hloc does.

    data   tensors of torch, or arrays: keypoints0, keypoints1 (1 x N x 2, px) and descriptors0, descriptors1 (1 x D x N,
           compared by L2); image0 and image1 (1 x C x height x width) for their sizes, and scales0, scales1, oris0, oris1
           (1 x N, px and degrees) for local frames, where they are there
    selector, options   those of corrsel.select(); it gets mutual nearest neighbours without a ratio test

    Returns matches0 (1 x N, int64, -1 = none) and matching_scores0 (1 x N, the probability that the match is right, or 1
    where the selector has none; 0 = no match).

    Raises ValueError for more than 32768 keypoints, which hloc cannot store, and for shapes that do not fit.
    """
    return _match(data, Selector(selector, **options))


def register(selector="auto", **options):
    """Make hloc know the matcher "corrsel". Return the configuration for hloc.match_features.main().

    selector, options   those of corrsel.select()

    The model is the class of a new module hloc.matchers.corrsel. Raises ImportError without hloc, and what
    corrsel.Selector() raises.
    """
    Selector(selector, **options)
    base = importlib.import_module("hloc.utils.base_model").BaseModel
    module = types.ModuleType("hloc.matchers.corrsel", "corrsel's matcher, see corrsel.hloc.")

    class Corrsel(base):
        """A matcher of hloc."""

        __module__ = module.__name__
        default_conf = {"selector": selector, "options": dict(options)}
        required_inputs = ["keypoints0", "keypoints1", "descriptors0", "descriptors1"]

        def _init(self, conf):
            self.selector = Selector(conf["selector"], **conf["options"])

        def _forward(self, data):
            return _match(data, self.selector)

    module.Corrsel = Corrsel
    sys.modules[module.__name__] = module
    return {
        "output": "matches-corrsel-" + selector.replace(":", "-"),
        "model": {"name": "corrsel", "selector": selector, "options": dict(options)},
    }


def _match(data, selector):
    left, right = (_features(data, side) for side in "01")
    matches = match_features(left, right, mutual=True)
    selection = selector.select(matches)
    keep = _doors.kept(selection)
    rows = matches.left_index[keep]
    numbers, scores = np.full(len(left), -1, np.int64), np.zeros(len(left), np.float32)
    numbers[rows] = matches.right_index[keep]
    scores[rows] = 1 if selection.probability is None else selection.probability[keep]
    example = data["keypoints0"]
    return {
        "matches0": _doors.like(example, numbers[None]),
        "matching_scores0": _doors.like(example, scores[None]),
    }


def _features(data, side):
    """Return the Features of one image of hloc's dictionary."""
    keypoints, descriptors = (_doors.to_floats(data[name + side]) for name in ("keypoints", "descriptors"))
    if keypoints.ndim != 3 or len(keypoints) != 1 or descriptors.ndim != 3 or len(descriptors) != 1:
        raise ValueError(
            "keypoints%s has shape %s and descriptors%s %s; needed: 1 x N x 2 and 1 x D x N"
            % (side, keypoints.shape, side, descriptors.shape)
        )
    if keypoints.shape[1] > MOST_KEYPOINTS:
        raise ValueError(
            "keypoints%s has %d keypoints, but hloc stores their numbers in 16 bits; lower max_keypoints to %d"
            % (side, keypoints.shape[1], MOST_KEYPOINTS)
        )
    frame = None
    if "scales" + side in data and "oris" + side in data:
        scale, angle = (_doors.to_floats(data[name + side])[0] for name in ("scales", "oris"))
        cos, sin = scale * np.cos(np.radians(angle)), scale * np.sin(np.radians(angle))
        x, y = keypoints[0].T
        frame = np.stack([cos, -sin, x, sin, cos, y], axis=1).reshape(-1, 2, 3)
    size = tuple(data["image" + side].shape[:1:-1]) if "image" + side in data else None
    return Features(keypoints[0], descriptors[0].T, frame=frame, image_size=size)
