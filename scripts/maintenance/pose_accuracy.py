#!/usr/bin/env python3
"""Measure the relative poses of selectors beside those of OpenCV, on the same matches.

Each FOLDER is a dataset of the layout `pair_list` (docs/datasets.md): pairs.txt, in SuperGlue's format with cameras and poses,
and the images. For every kind of matches and every estimator one line is printed: the AUC of the pose error at 5, 10 and 20
degrees, %, mean over the seeds, the mean number of pairs with an error above 20 degrees, and the median processor time, ms. A
pair without a pose has an error of 180 degrees.

Matches
  all         each feature of the left image with its nearest neighbour
  ratio 0.8   of these, the ones with a distance of at most 0.8 times that to the second neighbour
  half size   all matches of images of half the size; thresholds in px stay the same

Estimators
  pose, auto   the pose that the selector returns
  usac:e       the pose of its essential matrix, by cv2.recoverPose on its mask, which is not timed
  cv2 ...      cv2.findEssentialMat and cv2.recoverPose on undistorted points; the undistortion is not timed. A seed gives the
               matches another order, as these functions have no other way to vary their random numbers

PYTHONPATH must name the folder of the Python package of corrsel: PYTHONPATH=build/python uses that of a build folder.
"""
import argparse
import pathlib
import time

import corrsel
import cv2
import numpy as np
from corrsel.files.truth import read_pair_list

FEATURES = ("sift+sift", "orb+orb")
RATIO = 0.8
THRESHOLD = 1.0  # px, of OpenCV
FAILED = 180.0  # degrees
KINDS = ("all", "ratio %g" % RATIO, "half size")


class Pair:
    """Matches of a pair of images, with cameras, and the true pose."""

    def __init__(self, matches, rotation, translation):
        self.matches = matches
        self.truth = rotation, translation
        self.left = normalized(matches.left_camera, matches.left)
        self.right = normalized(matches.right_camera, matches.right)

    def error(self, pose):
        """Return the error of a pose (R, t), or of None, degrees."""
        return FAILED if pose is None else corrsel.pose_errors(*pose, *self.truth).pose

    def recover(self, essential, mask):
        """Return the pose (R, t) of an essential matrix, for which most of the selected matches lie in front."""
        rows = np.flatnonzero(mask)
        _, rotation, translation, _ = cv2.recoverPose(essential, self.left[rows], self.right[rows], np.eye(3))
        return rotation, translation.ravel()


def normalized(camera, points):
    """Return where a camera without distortion and with the identity as its matrix would see the points."""
    rays = camera.unproject(points)
    return rays[:, :2] / rays[:, 2:]


def timed(call, *arguments):
    """Return what a call returns, and its processor time, ms."""
    start = time.process_time()
    result = call(*arguments)
    return result, 1000 * (time.process_time() - start)


class OwnPose:
    """The pose that a selector returns."""

    def __init__(self, name):
        self.name = name

    def estimate(self, pair, seed):
        """Return the pose (R, t) or None, and the time, ms."""
        selection, milliseconds = timed(corrsel.Selector(self.name, seed=seed).select, pair.matches)
        pose = selection.pose
        known = pose is not None and pose.motion != "none"
        return (pose.rotation, pose.translation) if known else None, milliseconds


class PoseOfMatrix:
    """The pose of the essential matrix that a selector returns."""

    def __init__(self, name):
        self.name = name

    def estimate(self, pair, seed):
        """Return the pose (R, t) or None, and the time, ms."""
        selection, milliseconds = timed(corrsel.Selector(self.name, seed=seed).select, pair.matches)
        known = selection.model_kind == "essential"
        return pair.recover(selection.model, selection.mask) if known else None, milliseconds


class OpenCv:
    """cv2.findEssentialMat and cv2.recoverPose."""

    def __init__(self, name, method):
        self.name = name
        self.method = method

    def estimate(self, pair, seed):
        """Return the pose (R, t) or None, and the time, ms."""
        order = np.random.RandomState(seed).permutation(len(pair.left))
        left, right = pair.left[order], pair.right[order]
        return timed(self.pose, left, right, THRESHOLD / pair.matches.left_camera.matrix[0, 0])

    def pose(self, left, right, threshold):
        if len(left) < 5:
            return None
        essential, mask = cv2.findEssentialMat(
            left, right, np.eye(3), method=self.method, threshold=threshold
        )
        if essential is None or len(essential) < 3:
            return None
        _, rotation, translation, _ = cv2.recoverPose(essential[:3], left, right, np.eye(3), mask=mask)
        return rotation, translation.ravel()


def estimators():
    found = [OwnPose("pose"), PoseOfMatrix("usac:e"), OwnPose("auto"), OpenCv("cv2 RANSAC", cv2.RANSAC)]
    if hasattr(cv2, "USAC_MAGSAC"):
        found.append(OpenCv("cv2 USAC_MAGSAC", cv2.USAC_MAGSAC))
    return found


def features_of(file, extractor, scale):
    image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise SystemExit("%s cannot be read as an image" % file)
    if scale != 1:
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return extractor.extract(image)


def read_pairs(folders, features, scale):
    """Return the Pairs of all folders, with all matches."""
    extractor = corrsel.Extractor(features)
    pairs, extracted = [], {}
    for folder in folders:
        for left, right, truth, place in read_pair_list(folder / "pairs.txt"):
            if truth is None or truth.pose is None:
                raise SystemExit("%s has no pose" % place)
            for name in (left, right):
                if folder / name not in extracted:
                    extracted[folder / name] = features_of(folder / name, extractor, scale)
            matches = corrsel.match_features(extracted[folder / left], extracted[folder / right])
            cameras = [corrsel.Camera("pinhole", matrix).scaled(scale) for matrix in truth.pose[:2]]
            pairs.append(Pair(matches.with_cameras(*cameras), *truth.pose[2:]))
    return pairs


def with_ratio(pair):
    """Return the Pair of the matches that pass the ratio test."""
    matches = pair.matches
    kept = matches.distance <= RATIO * matches.second_distance
    return Pair(matches[kept], *pair.truth)


def measure(estimator, pairs, seeds):
    """Return the pose errors, seeds x pairs, degrees, and the times, ms."""
    errors, times = np.empty((seeds, len(pairs))), np.empty((seeds, len(pairs)))
    for seed in range(seeds):
        for k, pair in enumerate(pairs):
            pose, times[seed, k] = estimator.estimate(pair, seed)
            errors[seed, k] = pair.error(pose)
    return errors, times


def print_line(what, name, errors, times):
    auc = 100 * np.mean([corrsel.error_auc(row) for row in errors], axis=0)
    far = np.mean(np.sum(errors > 20, axis=1))
    print(
        "%-22s %-16s %5.1f %5.1f %5.1f %8.1f %9.2f" % ((what, name) + tuple(auc) + (far, np.median(times))),
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", type=pathlib.Path, metavar="FOLDER", nargs="+")
    parser.add_argument("--seeds", type=int, default=4, help="runs of each estimator; default: %(default)s")
    parser.add_argument("--features", nargs="+", default=FEATURES, help="default: %s" % " ".join(FEATURES))
    parser.add_argument("--matches", nargs="+", choices=KINDS, default=KINDS, help="default: all three kinds")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    print("%-22s %-16s %5s %5s %5s %8s %9s" % ("matches", "estimator", "5", "10", "20", "above 20", "ms"))
    for features in arguments.features:
        whole = read_pairs(arguments.folders, features, 1)
        for kind in arguments.matches:
            pairs = whole
            if kind == "half size":
                pairs = read_pairs(arguments.folders, features, 0.5)
            elif kind != "all":
                pairs = [with_ratio(pair) for pair in whole]
            for estimator in estimators():
                print_line(
                    "%s, %s" % (features, kind), estimator.name, *measure(estimator, pairs, arguments.seeds)
                )


if __name__ == "__main__":
    main()
