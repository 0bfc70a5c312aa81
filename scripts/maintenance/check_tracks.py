#!/usr/bin/env python3
"""Checks tracks of a real image sequence, whose true motion is not known, by optical flow.

    scripts/maintenance/check_tracks.py TRACKS.csv IMAGE...

TRACKS.csv is what examples/06_track_images.cpp has written for the same images. From every sight of a track, its point
is followed by pyramidal Lucas-Kanade from image to image up to the track's next sight, and back. Where it comes back
to within 0.5 px, the flow is taken as true, and the step is wrong if the sight is more than 3 px from it. A track is
wrong if one of its steps is. Flow and descriptors fail for different reasons, so that this is independent of the
tracks. It needs OpenCV's Python module and the package corrsel.
"""

import sys
from collections import defaultdict

import cv2
import numpy as np
from corrsel import matches

TOLERANCE = 3.0  # px
RETURN = 0.5  # px


def flow(images, begin, end, points):
    """Follow points from one image to another, image by image."""
    step = 1 if end > begin else -1
    valid = np.ones(len(points), bool)
    for k in range(begin, end, step):
        points, found, _ = cv2.calcOpticalFlowPyrLK(
            images[k], images[k + step], points, None, winSize=(21, 21), maxLevel=4
        )
        valid &= found.ravel() > 0
    return points, valid


def steps_of(rows):
    """Return the pairs of rows that follow each other in a track, by (image, next image), numbered from 0."""
    order = np.argsort(rows["track"], kind="stable")
    pairs = defaultdict(list)
    for a, b in zip(order[:-1], order[1:]):
        if rows["track"][a] == rows["track"][b]:
            pairs[int(rows["stamp"][a]) - 1, int(rows["stamp"][b]) - 1].append((a, b))
    return pairs


def main(arguments):
    """Print lengths and the share of wrong steps and tracks."""
    rows = matches.tracks(arguments[0])
    images = [cv2.imread(path, cv2.IMREAD_GRAYSCALE) for path in arguments[1:]]
    at = np.stack([rows["x"], rows["y"]], axis=1)
    lengths = np.unique(rows["track"], return_counts=True)[1]
    wrong_tracks, checked_tracks = set(), set()
    counts = defaultdict(lambda: np.zeros(2, int))  # by gap: checked, wrong
    for (begin, end), pairs in steps_of(rows).items():
        first, second = np.array(pairs).T
        there, valid = flow(images, begin, end, at[first][:, None])
        back, valid_back = flow(images, end, begin, there)
        true = valid & valid_back & (np.linalg.norm(back[:, 0] - at[first], axis=1) <= RETURN)
        wrong = true & (np.linalg.norm(there[:, 0] - at[second], axis=1) > TOLERANCE)
        counts[end - begin - 1] += true.sum(), wrong.sum()
        checked_tracks.update(rows["track"][first[true]].tolist())
        wrong_tracks.update(rows["track"][first[wrong]].tolist())
    print(
        "%d tracks, length median %g, mean %.2f; %d checked, %.2f %% of them wrong"
        % (
            len(lengths),
            np.median(lengths),
            lengths.mean(),
            len(checked_tracks),
            100 * len(wrong_tracks) / max(1, len(checked_tracks)),
        )
    )
    for gap, (checked, wrong) in sorted(counts.items()):
        print("  gap %d: %d steps checked, %.2f %% wrong" % (gap, checked, 100 * wrong / max(1, checked)))


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(sys.argv[1:])
