"""Writes matched pairs as a bag that the benchmark and the live nodelets read."""
import functools
import math

import cv2
import genpy
import numpy as np
import rosbag
from corrsel.msg import Correspondences, GroundTruth
from sensor_msgs.msg import CompressedImage

from .pairs import InputError

FIRST_STAMP_NS = 10**9
IMAGE_FRAME = "image:"  # begins the frame id that names an image (src/ros/bags/bag_topics.h)
CAMERA_FRAMES = {"left": "left_camera_optical", "right": "right_camera_optical"}
KINDS = {
    "none": GroundTruth.KIND_NONE,
    "homography": GroundTruth.KIND_HOMOGRAPHY,
    "fundamental": GroundTruth.KIND_FUNDAMENTAL,
    "labels": GroundTruth.KIND_LABELS,
}
STAGES = ("wait", "detect", "describe", "match", "select", "publish")
FORMATS = {".jpg": "jpeg", ".jpeg": "jpeg"}
IMAGE_ENDINGS = (".png", ".jpg", ".jpeg", ".bmp", ".ppm", ".pgm", ".tif", ".tiff")


def write_bag(pairs, output, dataset, images=None, size=(0, 0), period=0.5):
    """Write a bag; it gets its name when it is complete. Return the numbers of pairs, matches and pairs with truth.

    images: folder of the images, which are then written, too: IMAGES/NAME where a pair names its images, otherwise
            IMAGES/KEY/left.* and right.*
    size:   of images whose size is not known otherwise, px
    period: between the stamps of two pairs, s
    """
    if not 0.001 <= period <= 3600:
        raise InputError("period = %g is outside [0.001, 3600] s" % period)
    part = output.with_name(output.name + ".part")
    count, n_matches, evaluated = 0, 0, 0
    read_image = functools.lru_cache(maxsize=8)(_read_image)  # neighbouring pairs share images
    try:
        with rosbag.Bag(str(part), "w", compression="lz4") as bag:
            for pair in pairs:
                stamp = genpy.Time(0, FIRST_STAMP_NS + round(count * period * 1e9))
                pictures = {} if images is None else _images_of(pair, images, read_image)
                for side in ("left", "right"):
                    _set_size(pair, side, pictures[side][1] if pictures else (0, 0), size)
                _write_pair(bag, pair, dataset, stamp, pictures)
                count += 1
                n_matches += len(pair.left)
                evaluated += pair.truth.kind != "none"
        if count == 0:
            raise InputError("there is no pair, so that no bag is written")
        part.replace(output)
    except OSError as error:
        raise InputError("cannot write %s: %s" % (output, error)) from error
    finally:
        if part.exists():
            part.unlink()
    return count, n_matches, evaluated


def _set_size(pair, side, of_image, given):
    known = getattr(pair, side + "_size")
    if of_image != (0, 0):
        if known not in ((0, 0), of_image):
            raise InputError(
                "%s: the %s image %s has %dx%d px, but its matches are of %dx%d px; give the images that were matched"
                % ((pair.source, side, getattr(pair, side + "_name")) + of_image + known)
            )
        known = of_image
    if known == (0, 0):
        known = given
    setattr(pair, side + "_size", known)
    if known == (0, 0):
        return
    positions = getattr(pair, side)
    wrong = np.flatnonzero((positions < -1).any(axis=1) | (positions > np.array(known)).any(axis=1))
    if len(wrong):
        raise InputError(
            "%s: match %d has the %s position (%g, %g), outside the image of %dx%d px; are the positions those of the "
            "image as it is stored?" % ((pair.source, wrong[0], side) + tuple(positions[wrong[0]]) + known)
        )


def _images_of(pair, folder, read_image):
    """Return {side: (file, (width, height), bytes)}."""
    result = {}
    for side in ("left", "right"):
        name = getattr(pair, side + "_name")
        path = folder / name
        if not name:
            found = [folder / pair.key / (side + ending) for ending in IMAGE_ENDINGS]
            path = next((file for file in found if file.is_file()), found[0])
        size, data = read_image(path)
        if size is None:
            raise InputError("%s: the %s image %s %s" % (pair.source, side, path, data))
        result[side] = (path, size, data)
    return result


def _read_image(path):
    """Return size and bytes of an image file, or None and what is wrong."""
    try:
        data = path.read_bytes()
    except OSError:
        return None, "is missing or cannot be read"
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if image is None:
        return None, "cannot be decoded"
    return (image.shape[1], image.shape[0]), data


def _write_pair(bag, pair, dataset, stamp, pictures):
    folder, _, name = pair.key.rpartition("/")
    frames = {}
    for side in ("left", "right"):
        image = getattr(pair, side + "_name")
        frames[side] = IMAGE_FRAME + image if image else CAMERA_FRAMES[side]
    place = {"dataset": dataset, "sequence": folder or dataset, "pair": name}
    if pair.truth.kind != "none" or pictures:  # a pair with images needs a ground truth that is not known
        bag.write("/ground_truth", _truth_message(pair, place, stamp, frames), stamp)
    bag.write("/correspondences", _matches_message(pair, place, stamp, frames), stamp)
    for side, (path, _, data) in pictures.items():
        image = CompressedImage(
            format=FORMATS.get(path.suffix.lower(), path.suffix.lower().lstrip(".")), data=data
        )
        image.header.stamp = stamp
        image.header.frame_id = frames[side]
        bag.write("/%s/image/compressed" % side, image, stamp)


def _matches_message(pair, place, stamp, frames):
    message = Correspondences(features="given", right_stamp=stamp, right_frame_id=frames["right"], **place)
    message.header.stamp = stamp
    message.header.frame_id = frames["left"]
    for side in ("left", "right"):
        width, height = getattr(pair, side + "_size")
        positions, shape, index = (getattr(pair, side + field) for field in ("", "_shape", "_index"))
        setattr(message, side + "_width", width)
        setattr(message, side + "_height", height)
        setattr(message, side + "_x", positions[:, 0].tolist())
        setattr(message, side + "_y", positions[:, 1].tolist())
        setattr(message, "n_%s_features" % side, getattr(pair, side + "_count") or len(positions))
        if shape is not None:
            rows = np.concatenate([shape[:, :2], positions[:, :1], shape[:, 2:], positions[:, 1:]], axis=1)
            setattr(message, side + "_frame", rows.reshape(-1).tolist())
        if index is not None:
            setattr(message, side + "_index", index.tolist())
    if pair.distance is not None:
        message.distance = pair.distance.tolist()
    if pair.second_distance is not None:
        message.second_distance = pair.second_distance.tolist()
    if pair.probability is not None:
        message.probability = pair.probability.tolist()
    for stage in STAGES:
        setattr(message.seconds, stage, math.nan)
    return message


def _truth_message(pair, place, stamp, frames):
    truth = pair.truth
    message = GroundTruth(kind=KINDS[truth.kind], **place)
    message.header.stamp = stamp
    message.header.frame_id = frames["left"]
    message.matrix = [math.nan] * 9 if truth.matrix is None else truth.matrix.reshape(-1).tolist()
    if truth.labels is not None:
        message.labels = truth.labels.tolist()
    if truth.pose is not None:
        fields = ("left_camera", "right_camera", "rotation", "translation")
        for field, values in zip(fields, truth.pose):
            setattr(message, field, values.reshape(-1).tolist())
    return message
