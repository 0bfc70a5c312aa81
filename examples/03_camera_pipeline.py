#!/usr/bin/env python3
"""Follow a camera: match every frame with the one before, select with auto, and act on what the scene is.

    03_camera_pipeline.py IMAGE IMAGE ...

The images are the frames in their order; replace frames() by your camera. Needs the Python package of corrsel, numpy and
OpenCV. One line is printed for every frame but the first.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Iterator, List

import corrsel
import cv2
import numpy as np

if TYPE_CHECKING:  # numpy has these types from 1.21 on
    from numpy.typing import NDArray


def frames(files: List[str]) -> Iterator[NDArray[np.uint8]]:
    """Yield the images in their order."""
    for file in files:
        image = cv2.imread(file, cv2.IMREAD_GRAYSCALE)
        if image is None:
            sys.exit("03_camera_pipeline.py: cannot read '%s'; give image files" % file)
        yield image


def action(selection: corrsel.Selection) -> str:
    """Return what a robot would do with a selection: the kinds of scene ask for different things."""
    if selection.scene == "nothing":
        return "the view is lost: relocalise"
    if selection.scene == "at_rest":
        return "standing still: keep the pose"
    if selection.scene == "plane_or_rotation":
        return "decompose the homography; there is no depth to triangulate"
    if selection.scene == "rigid":
        return "estimate the motion from the fundamental matrix, and triangulate"
    if selection.scene == "several_motions" and selection.group is not None:
        return "%d moving objects: use the motion of group 0" % selection.group.max()
    return "do not use the matches" if selection.status != "ok" else "use the matches without a model"


def main(files: List[str]) -> None:
    extractor = corrsel.Extractor("orb+orb", orb={"max_features": 1000})
    selector = corrsel.Selector("auto", max_seconds=0.1)
    earlier = None
    for number, image in enumerate(frames(files)):
        features = extractor.extract(image)
        if earlier is not None:
            matches = corrsel.match_features(features, earlier)  # the newer frame is the left one
            selection = selector.select(matches)
            counts = "%d of %d" % (selection.n_selected, selection.n_input)
            print(
                "frame %d: %s, %s, %s: %s"
                % (number, counts, selection.status, selection.scene, action(selection))
            )
        earlier = features


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1:])
