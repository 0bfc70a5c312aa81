#!/usr/bin/env python3
"""Print the ground truth of the sample set's pairs of the sequences rig, box and page (src/datasets/real_samples.cpp).

EXAMPLES is the folder usr/share/doc/opencv-doc/examples of Debian's package opencv-doc, installed or unpacked.

rig   The stereo rig is calibrated from the 54 inner corners of the chessboard in 13 pairs of images. Matches that are
      off the board took no part in the calibration. Their distances from it are printed as a check.
box   The homography of the front of a box, and
page  that of a printed page. Both are found from SIFT matches and refined on the grey values (cv2.findTransformECC),
      where nothing covers the plane. An overlay of both images is written for the eye: where they differ in place, its
      edges have orange and blue seams.
"""
import argparse
import pathlib

import cv2
import numpy as np

VIEWS = "01 02 03 04 05 06 07 08 09 11 12 13 14".split()
BOARD = (9, 6)  # inner corners
MARGIN = 25  # px around them, which the board fills
# Left image, right image, the visible part of the plane in the left image, and how many px ECC smooths.
PLANES = {
    "box": (
        "data/box.png",
        "data/box_in_scene.png",
        "12,14 300,14 300,40 240,40 225,62 275,140 275,195 90,195 70,190 50,190 12,180",
        5,
    ),
    "page": ("reg/LR_05.png", "reg/LR_06.png", "6,6 95,6 95,169 6,169", 3),
}


def read(path):
    """Return a grey image."""
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise SystemExit("%s is missing or no image; give the folder examples of opencv-doc" % path)
    return image


def sift_matches(left, right):
    """Return the points of the SIFT matches that pass the ratio test at 0.8."""
    sift = cv2.SIFT_create()
    (points, first), (others, second) = (sift.detectAndCompute(image, None) for image in (left, right))
    kept = [m for m, n in cv2.BFMatcher().knnMatch(first, second, k=2) if m.distance < 0.8 * n.distance]
    return (
        np.array([points[m.queryIdx].pt for m in kept]),
        np.array([others[m.trainIdx].pt for m in kept]),
    )


def corners(image):
    """Return the inner corners of the board, N x 1 x 2."""
    found, points = cv2.findChessboardCorners(image, BOARD)
    if not found:
        raise SystemExit("the board is not found in one of the images left*.jpg, right*.jpg")
    return cv2.cornerSubPix(image, points, (5, 5), (-1, -1), (3, 100, 1e-4))


def epipolar_errors(left, right, rig):
    """Return how far points lie from the epipolar lines in the right image without distortion, px."""
    k1, d1, k2, d2, rotation, t = rig
    cross = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]], float)
    first, second = (
        cv2.convertPointsToHomogeneous(cv2.undistortPoints(points.reshape(-1, 1, 2), k, d))[:, 0]
        for points, k, d in ((left, k1, d1), (right, k2, d2))
    )
    lines = first @ (cross @ rotation).T
    return np.abs((second * lines).sum(1)) / np.hypot(lines[:, 0], lines[:, 1]) * k2[0, 0]


def print_rig(examples):
    """Calibrate the rig, and check the calibration beside the board."""
    images = [
        [read(examples / "data" / (side + view + ".jpg")) for side in ("left", "right")] for view in VIEWS
    ]
    seen = [[corners(image) for image in pair] for pair in images]
    left, right = zip(*seen)
    board = np.zeros((BOARD[0] * BOARD[1], 3), np.float32)
    board[:, :2] = np.mgrid[0 : BOARD[0], 0 : BOARD[1]].T.reshape(-1, 2)  # the unit of length is a square
    boards, size = [board] * len(VIEWS), images[0][0].shape[::-1]
    flags = cv2.CALIB_FIX_K3
    cameras = []
    for points in (left, right):
        _, k, d, _, _ = cv2.calibrateCamera(boards, points, size, None, None, flags=flags)
        cameras += [k, d]
    flags |= cv2.CALIB_USE_INTRINSIC_GUESS
    rms, *rig, _, _ = cv2.stereoCalibrate(
        boards, left, right, *cameras, size, flags=flags, criteria=(3, 200, 1e-9)
    )
    rig[5] = rig[5].ravel()
    print("rig: RMS reprojection error %.3f px" % rms)
    for name, values in zip("left_K left_D right_K right_D R t".split(), rig):
        print("  %s:" % name, ", ".join("%.9g" % value for value in np.ravel(values)))
    for view, pair, (points, _) in zip(VIEWS, images, seen):
        hull = cv2.convexHull(points)
        matches = sift_matches(*pair)
        off = [cv2.pointPolygonTest(hull, tuple(map(float, p)), True) < -MARGIN for p in matches[0]]
        errors = epipolar_errors(*(m[off] for m in matches), rig)
        near = errors[errors <= 5]
        print(
            "  %s: of %d matches beside the board, %d are within 5 px, with the median %.2f px"
            % (view, len(errors), len(near), np.median(near))
        )


def print_plane(name, examples, overlays):
    """Find a homography, compare its two estimates, and write the overlay."""
    left_name, right_name, outline, smoothing = PLANES[name]
    left, right = read(examples / left_name), read(examples / right_name)
    matches = sift_matches(left, right)
    start, kept = cv2.findHomography(*matches, cv2.RANSAC, 2.0, maxIters=10000)
    polygon = np.array([corner.split(",") for corner in outline.split()], np.int32)
    visible = cv2.fillPoly(np.zeros_like(left), [polygon], 255)
    visible = cv2.warpPerspective(visible, start, right.shape[::-1], flags=cv2.INTER_NEAREST)
    criteria = (3, 500, 1e-8)
    correlation, refined = cv2.findTransformECC(
        left, right, start.astype(np.float32), cv2.MOTION_HOMOGRAPHY, criteria, visible, smoothing
    )
    refined = refined.astype(float) / refined[2, 2]
    inside = polygon[:, None].astype(float)
    moved = np.linalg.norm(
        cv2.perspectiveTransform(inside, start) - cv2.perspectiveTransform(inside, refined), axis=2
    )
    errors = np.linalg.norm(cv2.perspectiveTransform(matches[0][:, None], refined)[:, 0] - matches[1], axis=1)
    near = errors[errors <= 5]
    print("%s: correlation %.3f" % (name, correlation))
    print("  H:", ", ".join("%.9g" % value for value in refined.ravel()))
    print("  refining moved the corners of the visible part by %.2f px at most" % moved.max())
    print(
        "  of %d SIFT matches, %d are within 5 px, with the median %.2f px"
        % (len(errors), len(near), np.median(near))
    )
    scale = np.diag([4.0, 4.0, 1.0])
    size = tuple(4 * side for side in left.shape[::-1])
    a, b = (
        cv2.warpPerspective(i, scale @ h, size)
        for i, h in ((left, np.eye(3)), (right, np.linalg.inv(refined)))
    )
    cv2.imwrite(str(overlays / (name + ".png")), cv2.merge([a, cv2.addWeighted(a, 0.5, b, 0.5, 0), b]))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("examples", type=pathlib.Path, metavar="EXAMPLES")
    parser.add_argument("overlays", type=pathlib.Path, metavar="OVERLAYS", help="folder for the overlays")
    arguments = parser.parse_args()
    arguments.overlays.mkdir(parents=True, exist_ok=True)
    print_rig(arguments.examples)
    for name in PLANES:
        print_plane(name, arguments.examples, arguments.overlays)


if __name__ == "__main__":
    main()
