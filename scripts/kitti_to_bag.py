#!/usr/bin/env python3
"""Make a stereo bag from raw KITTI frames, as a robot would record it.

Usage: kitti_to_bag.py FOLDER --output FILE [--rate HZ] [--every N]

FOLDER holds left_*.png and right_*.png (cameras 00 and 01, unrectified) and calib_cam_to_cam.txt. The bag has
/stereo/left/image_raw/compressed and /stereo/right/image_raw/compressed (the PNG files as they are) and
/stereo/left/camera_info and /stereo/right/camera_info. The first stamp is 1 s, the next ones follow at the
rate given. The same files always give the same messages.
Exit status: 0 written, 2 unusable input.
"""
import argparse
import math
import struct
import sys
from pathlib import Path

import genpy
import rosbag
from sensor_msgs.msg import CameraInfo, CompressedImage

CALIBRATION = "calib_cam_to_cam.txt"
SIDES = (("left", "00"), ("right", "01"))
FIRST_STAMP_NS = 10**9
# KITTI's name of a matrix, how many numbers it has, and the field of CameraInfo that takes it.
MATRICES = (("K", 9, "K"), ("D", 5, "D"), ("R_rect", 9, "R"), ("P_rect", 12, "P"))


class InputError(Exception):
    """Input from which no bag can be made; the message names the input, the reason and the remedy."""


def read_calibration(path):
    """Return the lines 'NAME: NUMBER...' of a calibration file as {name: [number...]}."""
    if not path.is_file():
        raise InputError("%s is missing: copy it from the calibration of the same day of KITTI raw" % path)
    numbers = {}
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        name, _, values = line.partition(":")
        try:
            numbers[name.strip()] = [float(value) for value in values.split()]
        except ValueError:  # calib_time is a date
            continue
    return numbers


def camera_info(calibration, path, camera, side):
    """Return the CameraInfo, without stamp, of a camera such as '00'."""

    def entry(name, count):
        values = calibration.get("%s_%s" % (name, camera))
        if values is None or len(values) != count or not all(math.isfinite(value) for value in values):
            raise InputError("%s: %s_%s is missing or is not %d numbers" % (path, name, camera, count))
        return values

    info = CameraInfo(distortion_model="plumb_bob")
    info.header.frame_id = side + "_camera_optical"
    info.width, info.height = (int(value) for value in entry("S", 2))
    for name, count, field in MATRICES:
        setattr(info, field, entry(name, count))
    return info


def png_size(path, data):
    """Return width and height of a PNG file."""
    if len(data) < 24 or data[:8] != b"\x89PNG\r\n\x1a\n" or data[12:16] != b"IHDR":
        raise InputError("%s is not a PNG file" % path)
    return struct.unpack(">II", data[16:24])


def find_frames(folder):
    """Return the (left, right) files, in the order of their numbers."""
    if not folder.is_dir():
        raise InputError("%s is not a folder" % folder)
    frames = []
    for left in sorted(folder.glob("left_*.png")):
        right = left.with_name("right_" + left.name[len("left_") :])
        if not right.is_file():
            raise InputError("%s is missing, the right image of %s" % (right, left.name))
        frames.append((left, right))
    if not frames:
        raise InputError(
            "%s has no left_*.png: name the raw frames of camera 00 left_NUMBER.png and those of camera 01 "
            "right_NUMBER.png" % folder
        )
    return frames


def write_frame(bag, stamp, files, infos):
    """Write the two images of a frame and their camera_info."""
    for (side, _), file, info in zip(SIDES, files, infos):
        data = file.read_bytes()
        size = png_size(file, data)
        if size != (info.width, info.height):
            raise InputError(
                "%s has %dx%d px, its calibration is for %dx%d px: only raw frames (KITTI's "
                "unsynced+unrectified archives) can be used" % ((file,) + size + (info.width, info.height))
            )
        info.header.stamp = stamp
        image = CompressedImage(header=info.header, format="png", data=data)
        bag.write("/stereo/%s/image_raw/compressed" % side, image, stamp)
        bag.write("/stereo/%s/camera_info" % side, info, stamp)


def convert(folder, output, rate=10.0, every=1):
    """Write the bag; return the number of frames. It gets its name when it is complete."""
    if not 0.01 <= rate <= 1000:
        raise InputError("rate = %g is outside [0.01, 1000] Hz" % rate)
    frames = find_frames(folder)
    if not 1 <= every <= len(frames):
        raise InputError(
            "every = %d is outside [1, %d]: %s has %d frames" % (every, len(frames), folder, len(frames))
        )
    frames = frames[::every]
    path = folder / CALIBRATION
    calibration = read_calibration(path)
    infos = [camera_info(calibration, path, camera, side) for side, camera in SIDES]
    part = Path(str(output) + ".part")
    try:
        with rosbag.Bag(str(part), "w") as bag:
            for i, files in enumerate(frames):
                nanoseconds = FIRST_STAMP_NS + round(i * 1e9 / rate)
                write_frame(bag, genpy.Time(0, nanoseconds), files, infos)
        part.replace(output)
    except OSError as error:
        raise InputError("cannot write %s: %s" % (output, error)) from error
    finally:
        if part.exists():
            part.unlink()
    return len(frames)


def main(argv=None):
    """Run with these arguments, by default those of the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n", maxsplit=1)[0],
        epilog="Then: roslaunch corrsel benchmark.launch bag:=FILE left:=/stereo/left/image_raw "
        "right:=/stereo/right/image_raw",
    )
    parser.add_argument("folder", type=Path, help="left_*.png, right_*.png and " + CALIBRATION)
    parser.add_argument("--output", type=Path, required=True, help="the bag; an older one is replaced")
    parser.add_argument("--rate", type=float, default=10.0, help="frames a second (default: 10)")
    parser.add_argument("--every", type=int, default=1, help="take every Nth frame (default: 1)")
    arguments = parser.parse_args(argv)
    try:
        count = convert(arguments.folder, arguments.output, arguments.rate, arguments.every)
    except InputError as error:
        print("kitti_to_bag.py: %s" % error, file=sys.stderr)
        return 2
    print("%d frames written to %s" % (count, arguments.output))
    return 0


if __name__ == "__main__":
    sys.exit(main())
