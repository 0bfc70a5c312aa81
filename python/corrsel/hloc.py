"""hloc (Sarlin et al., CVPR 2019): its geometric verification, and a matcher for its configurations.

    from corrsel import hloc as door

    door.verify(matches, features, verified, pairs)                 # in place of pycolmap's verification
    hloc.reconstruction.main(..., features, verified, skip_geometric_verification=True)

    conf = door.register("auto")                                    # a configuration of hloc.match_features
    hloc.match_features.main(conf, pairs, features, matches=matches)

Neither hloc nor torch is imported before register() is called.
"""

import collections
import importlib
import pathlib
import sys
import types

import numpy as np

from . import _doors
from .features import Features, match_features
from .files.hloc import MOST_KEYPOINTS, read_hloc, write_hloc
from .files.truth import read_pair_list
from .selectors import Matches, Selector

__all__ = ["Verified", "match", "register", "verify"]

Verified = collections.namedtuple("Verified", "pairs accepted matches kept")
Verified.__doc__ = (
    """What verify() did: numbers of pairs, of pairs with a result, of their matches, and of those kept."""
)


def verify(matches, features, output, pairs=None, selector="auto", *, scores="confidence", **options):
    """Write the file of matches with those matches alone that a selector keeps. Return Verified.

    matches     hloc's HDF5 file of matches
    features    hloc's HDF5 file of features: keypoints and image_size
    output      the new file; an older one is replaced once the new one is complete
    pairs       hloc's list of pairs, a text file: only these pairs are written. None: all of the file
    selector, options   those of corrsel.select()
    scores      "confidence" from 0 to 1, "distance" or "none": what matching_scores0 is. Scores that are all 0 are left
                aside

    The output has the layout of the input. A rejected match is -1 in matches0 and 0 in matching_scores0. Each pair gets
    the attributes corrsel_status and corrsel_confidence; unless the status is "ok" or "time_limit", it keeps no match.
    hloc stores keypoints as float16, in steps of 1 px from 1024 px and of 2 px from 2048 px, so that small thresholds
    lose matches. The time is that of the selector, pair by pair.

    Raises corrsel.files.pairs.InputError that names file, group and value for files that cannot be used, among them
    images with more than 32768 keypoints, whose numbers hloc cannot store; and what corrsel.Selector() raises.
    """
    chosen = Selector(selector, **options)
    listed = None if pairs is None else _distinct(read_pair_list(pathlib.Path(pairs)))
    counts = []

    def answers():
        for pair in read_hloc(matches, features, listed, scores):
            selection = chosen.select(_matches_of(pair))
            keep = _doors.kept(selection)
            counts.append((len(keep), np.count_nonzero(keep)))
            yield pair, keep, {
                "corrsel_status": selection.status,
                "corrsel_confidence": selection.confidence,
            }

    write_hloc(matches, output, answers())
    putative, remaining = np.array(counts, int).reshape(-1, 2).T.tolist()
    return Verified(len(counts), sum(count > 0 for count in remaining), sum(putative), sum(remaining))


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


def _distinct(listed):
    """Return the first line of every pair: hloc's lists may name it in both orders, but it is one group."""
    first = {}
    for line in listed:
        first.setdefault(frozenset(line[:2]), line)
    return list(first.values())


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


def _matches_of(pair):
    """Return the Matches of a MatchedPair."""
    return Matches(
        pair.left,
        pair.right,
        distance=pair.distance,
        probability=pair.probability,
        left_index=pair.left_index,
        right_index=pair.right_index,
        left_size=pair.left_size if all(pair.left_size) else None,
        right_size=pair.right_size if all(pair.right_size) else None,
    )
