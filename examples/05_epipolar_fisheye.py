#!/usr/bin/env python3
"""Draw epipolar curves on two raw fisheye images, and check that the selected matches lie on them.

    05_epipolar_fisheye.py [PICTURE.png]

The images are rendered here: a room with boxes, seen by a fisheye lens of 180 degrees from two places. For images of
your own, replace render() by cv2.imread(), and SIZE and CAMERA by the camera of your calibration. Needs the Python package of
corrsel, numpy and OpenCV. The program prints the pose, its errors, and how far the matches lie from their curves.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Sequence, Tuple

import corrsel
import cv2
import numpy as np

if TYPE_CHECKING:  # numpy has these types from 1.21 on
    from numpy.typing import NDArray

SIZE = (640, 640)
CAMERA = corrsel.Camera("fisheye", [[200, 0, 319.5], [0, 200, 319.5], [0, 0, 1]], [-0.02, 0.003, 0, 0], SIZE)
#: A point X of the left camera is TRUE_ROTATION @ X + TRUE_TRANSLATION in the frame of the right one, m.
TRUE_ROTATION, _ = cv2.Rodrigues(np.array([0.05, -0.2, 0.1]))
TRUE_TRANSLATION = TRUE_ROTATION @ [-0.6, 0.1, -0.3]
#: Corners of the room and of the boxes in it, in the frame of the left camera, m: x to the right, y down, z forward.
ROOM = ((-4, -1.6, -3), (4, 1.4, 6))
BOXES = (((-2.5, 0.2, 2), (-1.3, 1.4, 3)), ((0.9, -0.4, 2.4), (1.9, 1.4, 3.4)), ((2.4, -0.2, 0), (3, 1.4, 1)))


def hits(
    origin: NDArray[np.float64], rays: NDArray[np.float64], corners: Sequence[Sequence[float]]
) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances along rays at which they enter and leave a box."""
    with np.errstate(divide="ignore"):
        limits = (np.array(corners)[:, None] - origin) / rays
    return limits.min(0).max(1), limits.max(0).min(1)


def texture(points: NDArray[np.float64], surfaces: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the grey values of the surfaces: rectangles of random brightness, of several sizes."""
    values = np.full(len(points), 128.0)
    for side, contrast in ((0.4, 50), (0.13, 40), (0.05, 30)):
        cells = np.floor(points / side + 1e-6 + [0.13, 0.37, 0.71]).astype(np.int64)
        random = np.sin(cells @ [12.9898, 78.233, 37.719] + surfaces) * 43758.5453
        values += contrast * (2 * (random - np.floor(random)) - 1)
    return values


def render(
    camera: corrsel.Camera, rotation: NDArray[np.float64], translation: NDArray[np.float64]
) -> NDArray[np.uint8]:
    """Return the grey image of the room; each pixel is the mean of 2 x 2 rays."""
    fine, (width, height) = camera.scaled(2), (2 * SIZE[0], 2 * SIZE[1])
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).reshape(-1, 2)
    rays = fine.unproject(pixels)
    seen = np.flatnonzero(rays[:, 2] > 0)  # the lens shows 180 degrees
    origin, rays = -rotation.T @ translation, rays[seen] @ rotation
    depth = hits(origin, rays, ROOM)[1]
    number: NDArray[np.float64] = np.zeros(len(rays))
    for k, corners in enumerate(BOXES, 1):
        near, far = hits(origin, rays, corners)
        in_front = (near > 0) & (near < far) & (near < depth)
        depth, number = np.where(in_front, near, depth), np.where(in_front, k, number)
    image = np.zeros(height * width, np.float32)
    image[seen] = np.clip(texture(origin + depth[:, None] * rays, number), 0, 255)
    image = cv2.resize(image.reshape(height, width), SIZE, interpolation=cv2.INTER_AREA)
    return image.astype(np.uint8)


def epipolar_curve(
    pose: corrsel.PoseResult,
    camera_left: corrsel.Camera,
    camera_right: corrsel.Camera,
    point: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return points of the curve on which the right image shows a point of the left one, from near to far: M x 2."""
    far = pose.rotation @ camera_left.unproject([point])[0]
    share = np.linspace(0, 1, 200)[:, None]
    places = (1 - share) * pose.translation + share * far
    curve = camera_right.project(places[places[:, 2] > -0.02])  # a little beyond the 180 degrees of the lens
    visible: NDArray[np.float32] = curve[np.isfinite(curve).all(1)].astype(np.float32)
    return visible


def distance_to_curve(curve: NDArray[np.float32], point: NDArray[np.float32]) -> float:
    """Return the distance of a point to the segments between the points of a curve, px."""
    start, step = curve[:-1], np.diff(curve, axis=0)
    along = ((point - start) * step).sum(1) / np.maximum((step**2).sum(1), 1e-12)
    return float(np.linalg.norm(start + np.clip(along, 0, 1)[:, None] * step - point, axis=1).min())


def draw(
    images: Sequence[NDArray[np.uint8]], matches: corrsel.Matches, curves: Sequence[NDArray[np.float32]]
) -> NDArray[np.uint8]:
    """Return both images side by side with points on the left one and, on the right one, their curves and matches."""
    left, right = (cv2.cvtColor(image // 2, cv2.COLOR_GRAY2BGR) for image in images)
    hues = np.linspace(0, 179, len(curves), endpoint=False).astype(np.uint8)
    hsv = np.stack([hues, np.full_like(hues, 255), np.full_like(hues, 255)], 1)
    colours = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2BGR)[0].tolist()
    for row, (curve, colour) in enumerate(zip(curves, colours)):
        cv2.polylines(right, [np.round(8 * curve).astype(np.int32)], False, colour, 1, cv2.LINE_AA, 3)
        for image, place in ((left, matches.left[row]), (right, matches.right[row])):
            cv2.circle(image, tuple(int(x) for x in np.round(place)), 5, colour, 2, cv2.LINE_AA)
    return np.hstack([left, right])


def main(picture: str) -> None:
    images = [render(CAMERA, np.eye(3), np.zeros(3)), render(CAMERA, TRUE_ROTATION, TRUE_TRANSLATION)]
    matches = corrsel.match(images[0], images[1], features="sift+sift", sift={"max_features": 2000})
    pose = corrsel.relative_pose(
        matches.left,
        matches.right,
        CAMERA,
        CAMERA,
        distance=matches.distance,
        second_distance=matches.second_distance,
    )
    if pose.motion != "general":
        sys.exit(
            "05_epipolar_fisheye.py: no translation: %s, %s %s" % (pose.motion, pose.status, pose.message)
        )
    selected = matches[pose.mask]
    errors = corrsel.pose_errors(pose.rotation, pose.translation, TRUE_ROTATION, TRUE_TRANSLATION)
    deviations = np.degrees(np.sqrt(np.diag(pose.covariance)))
    print("%s: %d of %d matches, noise %.2f px" % (pose.motion, len(selected), len(matches), pose.noise))
    print("rotation wrong by %.3f, direction by %.3f degrees" % (errors.rotation, errors.translation))
    print("standard deviations: %s degrees" % np.round(deviations, 3))
    curves = [epipolar_curve(pose, CAMERA, CAMERA, point) for point in selected.left]
    distances = [distance_to_curve(curve, selected.right[row]) for row, curve in enumerate(curves)]
    print("mean distance of the selected matches to their curves: %.2f px" % np.mean(distances))
    chosen = np.linspace(0, len(selected) - 1, min(24, len(selected))).astype(int)
    if not cv2.imwrite(picture, draw(images, selected[chosen], [curves[row] for row in chosen])):
        sys.exit("05_epipolar_fisheye.py: cannot write '%s'" % picture)


if __name__ == "__main__":
    main(*(sys.argv[1:] or ["epipolar_curves.png"]))
