#!/usr/bin/env python3
"""Make a bag for the benchmark from your own images and ground truth. Copy this file and replace load_pairs().

Usage: make_bag.py FOLDER OUTPUT.bag

Here FOLDER holds a folder for each pair, with left.png, right.png and H.txt (a homography) or F.txt (a fundamental
matrix). The bag is then evaluated with: rosrun corrsel benchmark --bag OUTPUT.bag
"""
import sys
from pathlib import Path

import cv2
import numpy as np
import rosbag
import rospy
from sensor_msgs.msg import Image

from corrsel.msg import GroundTruth


def load_pairs(folder):
    """Yield (name, left, right, kind, matrix) of every pair: the part to replace by a loader of your own.

    left, right: 8-bit images, H x W (grey) or H x W x 3 (BGR)
    kind, matrix: KIND_HOMOGRAPHY with x' ~ H x, or KIND_FUNDAMENTAL with x'^T F x = 0. x is a pixel of the left
                  image, x' one of the right image; the centre of the first pixel is (0, 0).
    """
    for path in sorted(path for path in Path(folder).iterdir() if path.is_dir()):
        is_homography = (path / "H.txt").exists()
        matrix = np.loadtxt(str(path / ("H.txt" if is_homography else "F.txt"))).reshape(3, 3)
        kind = GroundTruth.KIND_HOMOGRAPHY if is_homography else GroundTruth.KIND_FUNDAMENTAL
        images = [cv2.imread(str(path / name)) for name in ("left.png", "right.png")]
        if images[0] is None or images[1] is None:
            raise SystemExit("%s: left.png or right.png is missing or cannot be decoded" % path)
        yield path.name, images[0], images[1], kind, matrix


def image_message(image, stamp, frame_id):
    """Return an 8-bit image as a message."""
    image = np.ascontiguousarray(image, dtype=np.uint8)
    message = Image(height=image.shape[0], width=image.shape[1], data=image.tobytes())
    message.header.stamp = stamp
    message.header.frame_id = frame_id
    message.encoding = "mono8" if image.ndim == 2 else "bgr8"
    message.step = len(message.data) // message.height
    return message


def write_bag(pairs, output, dataset):
    """Write the pairs; all messages of a pair have the same stamp. Return the number of pairs."""
    count = 0
    with rosbag.Bag(str(output), "w", compression="lz4") as bag:
        for name, left, right, kind, matrix in pairs:
            count += 1
            stamp = rospy.Time(count)
            truth = GroundTruth(dataset=dataset, sequence=name, pair="1-2", kind=kind)
            truth.header.stamp = stamp
            truth.matrix = matrix.flatten().tolist()
            bag.write("/ground_truth", truth, stamp)
            bag.write("/left/image", image_message(left, stamp, "left_camera_optical"), stamp)
            bag.write("/right/image", image_message(right, stamp, "right_camera_optical"), stamp)
    return count


def main():
    """Run on the command line's arguments."""
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    folder, output = sys.argv[1:]
    count = write_bag(load_pairs(folder), output, Path(folder).resolve().name)
    print("%d pairs written to %s" % (count, output))


if __name__ == "__main__":
    main()
