"""corrsel as the matcher of rtabmap: point PyMatcher/Path to this file.

    rtabmap --Vis/CorNNType 6 --PyMatcher/Path /usr/lib/python3/dist-packages/corrsel_rtabmap.py --PyMatcher/Model auto

PyMatcher/Model is the name of a selector, optionally with a preset and options, e.g. "usac:f" or
"auto[max_seconds=0.05]"; rtabmap's default "indoor", and what names no selector, mean "auto". PyMatcher/Threshold is the
least probability of a match, for selectors that compute it. The descriptors must be real numbers (SIFT, SURF,
SuperPoint), since rtabmap gives no others to a matcher.
"""

import re

import numpy as np

import corrsel
from corrsel import _doors

_state = {"selector": corrsel.Selector("auto"), "threshold": 0.0}


def init(descriptorDim, matchThreshold, iterations, cuda, model):
    """Choose the selector. rtabmap calls it before the first pair.

    matchThreshold   least probability of a match, from 0 to 1
    model            name of a selector; unknown names mean "auto"
    descriptorDim, iterations, cuda   have no effect

    Raises ValueError for a preset or an option of the model that does not exist.
    """
    known = re.split(r"[:\[]", model)[0] in corrsel.selector_names()
    _state["selector"] = corrsel.Selector(model if known else "auto")
    _state["threshold"] = matchThreshold


def match(kptsFrom, kptsTo, scoresFrom, scoresTo, descriptorsFrom, descriptorsTo, imageWidth, imageHeight):
    """Return the matches of two images of one camera: S x 2, int64, C-contiguous, rows of From and of To.

    kptsFrom, kptsTo                  px: N x 2, float32. From is the newer image
    scoresFrom, scoresTo              responses, not used
    descriptorsFrom, descriptorsTo    N x D, float32
    imageWidth, imageHeight           px

    The selector gets mutual nearest neighbours without a ratio test. Data never raise; where the selector is not sure,
    there are no matches. Nothing of the arrays is kept. O(N^2 D).
    """
    size = int(imageWidth), int(imageHeight)
    matches = corrsel.match_features(
        corrsel.Features(kptsFrom, descriptorsFrom, image_size=size),
        corrsel.Features(kptsTo, descriptorsTo, image_size=size),
        mutual=True,
    )
    selection = _state["selector"].select(matches)
    keep = _doors.kept(selection)
    if selection.probability is not None:
        keep = keep & (selection.probability >= _state["threshold"])
    # rtabmap reads the memory of the array as it is, and numbers of type uint64 twice.
    rows = np.stack([matches.left_index[keep], matches.right_index[keep]], axis=1)
    return np.ascontiguousarray(rows, np.int64)
