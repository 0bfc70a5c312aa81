#!/usr/bin/env python3
"""Write raw stereo frames of KITTI as two datasets of the layout `pairs` (docs/datasets.md).

FRAMES holds left_*.png, right_*.png and calib_cam_to_cam.txt, of the cameras 0 and 1.

TARGET/kitti_stereo   images without distortion, with the fundamental matrix
TARGET/kitti_raw      putative matches of the raw images, by sift+sift and by orb+orb. Those within 3 px of the epipolar
                      line, apart from the distortion, are labelled as right.

PYTHONPATH must name the folder of the Python package of corrsel: PYTHONPATH=build/python uses that of a build folder.
"""
import argparse
import pathlib

import corrsel
import cv2
import numpy as np
from corrsel.files.truth import pose_truth

FEATURES = ("sift+sift", "orb+orb")
TOLERANCE = 3  # px
COLUMNS = (
    "x_left y_left x_right y_right distance second_distance size_left angle_left size_right angle_right label"
)


def calibration(path):
    """Return {name: numbers} of a calibration file."""
    lines = (line.split(":", 1) for line in path.read_text(encoding="utf-8").splitlines())
    return {name: np.array(text.split(), float) for name, text in lines if name != "calib_time"}


def write_raw(folder, frames, cameras, distortions, truth):
    """Write the labelled matches of two raw images, one folder for each kind of features."""
    for features in FEATURES:
        matches = corrsel.match(*frames, features=features)
        sides = list(zip((matches.left, matches.right), cameras, distortions))
        flat = [
            cv2.undistortPoints(points.astype(float)[:, None], camera, distortion, P=camera)[:, 0]
            for points, camera, distortion in sides
        ]
        right = corrsel.ground_truth_errors(corrsel.Matches(*flat), fundamental=truth) <= TOLERANCE
        columns = [matches.left, matches.right, matches.distance, matches.second_distance]
        for frame in (matches.left_frame, matches.right_frame):
            first = frame[:, :, 0]  # where the frame takes (1, 0): radius and angle of the keypoint
            columns += [2 * np.hypot(*first.T), np.degrees(np.arctan2(first[:, 1], first[:, 0]))]
        target = folder.with_name("%s-%s" % (folder.name, features.split("+")[0]))
        target.mkdir(parents=True)
        table = np.column_stack(columns + [right])
        np.savetxt(target / "matches.csv", table, delimiter=",", header=COLUMNS.replace(" ", ","), fmt="%.9g")
        sizes = [frame.shape[::-1] for frame in frames]
        (target / "size.txt").write_text("".join("%d %d\n" % size for size in sizes), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("frames", type=pathlib.Path, metavar="FRAMES")
    parser.add_argument("target", type=pathlib.Path, metavar="TARGET")
    arguments = parser.parse_args()
    values = calibration(arguments.frames / "calib_cam_to_cam.txt")
    cameras = [values["K_0%d" % camera].reshape(3, 3) for camera in (0, 1)]
    distortions = [values["D_0%d" % camera] for camera in (0, 1)]
    turns = [values["R_0%d" % camera].reshape(3, 3) for camera in (0, 1)]
    rotation = turns[1] @ turns[0].T
    translation = values["T_01"] - rotation @ values["T_00"]
    truth = pose_truth(*cameras, rotation, translation, "calib_cam_to_cam.txt").matrix
    for left in sorted(arguments.frames.glob("left_*.png")):
        number = left.stem.split("_")[1]
        files = [left, left.with_name("right_%s.png" % number)]
        frames = [cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in files]
        write_raw(arguments.target / "kitti_raw" / number, frames, cameras, distortions, truth)
        folder = arguments.target / "kitti_stereo" / number
        folder.mkdir(parents=True)
        for side, frame, camera, distortion in zip(("left", "right"), frames, cameras, distortions):
            cv2.imwrite(str(folder / (side + ".png")), cv2.undistort(frame, camera, distortion))
        np.savetxt(folder / "F.txt", truth)


if __name__ == "__main__":
    main()
