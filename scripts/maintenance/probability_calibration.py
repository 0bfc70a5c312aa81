#!/usr/bin/env python3
"""Measure how well Selection.probability is calibrated, on the pairs of datasets with ground truth.

Of the matches with the probability p, the share p should be right. The program selects with one selector on every pair,
prints for each dataset and for all together a table by probability, and the average log loss of the probabilities beside
the lowest one that any threshold on them reaches: a prediction with two values, the shares of right matches on both
sides of the threshold.

DATA holds some of the folders vgg, symbench (homographies), kitti_stereo, strecha_dev (poses) and adelaidermf (labels), as
docs/datasets.md describes them. Needs scipy, and the Python package of corrsel: PYTHONPATH=build/python uses that of a
build folder. The run takes a minute.
"""
import argparse
import csv
import pathlib
import sys

import corrsel
import cv2
import numpy as np
from corrsel.files.truth import pose_truth, read_pair_list

FEATURES = ("sift+sift", "orb+orb")
TOLERANCE = {
    "vgg": 5,
    "symbench": 5,
    "kitti_stereo": 3,
    "strecha_dev": 5,
    "adelaidermf": 0,
}  # px, of a right match
BINS = np.linspace(0, 1, 11)
COLUMNS = ("dataset", "low", "high", "matches", "mean_probability", "share_right")


def image(path):
    """Return a grey image. Raises FileNotFoundError that names it."""
    pixels = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if pixels is None:
        raise FileNotFoundError("cannot read the image %s" % path)
    return pixels


def matched(left, right, **truth):
    """Yield the putative matches of two images by every kind of features, and their errors, px."""
    for features in FEATURES:
        matches = corrsel.match(image(left), image(right), features=features)
        yield matches, corrsel.ground_truth_errors(matches, **truth)


def vgg(folder):
    """Yield the matches of the first image of a scene with each of the others."""
    for truth in sorted(folder.glob("*/H1to*p")):
        number = truth.name[4:-1]
        left, right = (next(truth.parent.glob("img%s.p?m" % name)) for name in ("1", number))
        yield from matched(left, right, homography=np.loadtxt(truth))


def symbench(folder):
    """Yield the matches of the two images of every scene."""
    for truth in sorted(folder.glob("*/H1to2")):
        yield from matched(truth.parent / "01.png", truth.parent / "02.png", homography=np.loadtxt(truth))


def kitti_stereo(folder):
    """Yield the matches of raw stereo frames. The errors are those of the points without distortion."""
    lines = (
        line.split(":", 1)
        for line in (folder / "calib_cam_to_cam.txt").read_text(encoding="utf-8").splitlines()
    )
    values = {name: np.fromstring(text, sep=" ") for name, text in lines if name != "calib_time"}
    cameras = [values["K_0%d" % camera].reshape(3, 3) for camera in (0, 1)]
    turns = [values["R_0%d" % camera].reshape(3, 3) for camera in (0, 1)]
    rotation = turns[1] @ turns[0].T
    translation = values["T_01"] - rotation @ values["T_00"]
    truth = pose_truth(cameras[0], cameras[1], rotation, translation, "calib_cam_to_cam.txt").matrix
    for left in sorted(folder.glob("left_*.png")):
        for matches, _ in matched(
            left, left.with_name(left.name.replace("left", "right")), fundamental=truth
        ):
            points = [
                cv2.undistortPoints(side.astype(float)[:, None], camera, values["D_0%d" % number], P=camera)[
                    :, 0
                ]
                for number, (side, camera) in enumerate(zip((matches.left, matches.right), cameras))
            ]
            yield matches, corrsel.ground_truth_errors(corrsel.Matches(*points), fundamental=truth)


def strecha_dev(folder):
    """Yield the matches of the pairs of a list with poses."""
    for left, right, truth, _ in read_pair_list(folder / "pairs.txt"):
        yield from matched(folder / left, folder / right, fundamental=truth.matrix)


def adelaidermf(folder):
    """Yield the given matches of every pair; the error is 0 for members of a structure, and infinite otherwise."""
    from scipy.io import loadmat

    for path in sorted(folder.glob("*.mat")):
        content = loadmat(path)
        points = content["data"]
        sizes = [content[name].shape[1::-1] for name in ("img1", "img2")]
        matches = corrsel.Matches(points[:2].T, points[3:5].T, left_size=sizes[0], right_size=sizes[1])
        yield matches, np.where(content["label"].ravel() > 0, 0.0, np.inf)


READERS = {reader.__name__: reader for reader in (vgg, symbench, kitti_stereo, strecha_dev, adelaidermf)}


def rated(pairs, tolerance, selector):
    """Return the probabilities of all matches of the pairs, and whether they are right."""
    probabilities, right = [np.empty(0)], [np.empty(0, bool)]
    for matches, errors in pairs:
        selection = matches.select(selector)
        corrsel.add_probability(matches, selection)
        probabilities.append(selection.probability.astype(float))
        right.append(errors <= tolerance)
    return np.concatenate(probabilities), np.concatenate(right)


def log_loss(probabilities, right):
    """Return the mean of -ln of the probability that was given to what is the case."""
    return -np.log(np.clip(np.where(right, probabilities, 1 - probabilities), 1e-9, 1)).mean()


def best_threshold(probabilities, right):
    """Return the lowest log loss of a prediction with two values, and its threshold."""
    order = np.argsort(probabilities, kind="stable")
    below = np.arange(1, len(order))
    right_below = np.cumsum(right[order])[:-1]
    counts = np.array([below, len(order) - below], float)
    shares = np.array([right_below, right.sum() - right_below]) / counts
    entropy = -sum(share * np.log(np.maximum(share, 1e-300)) for share in (shares, 1 - shares))
    losses = (counts * entropy).sum(0) / len(order)
    best = np.argmin(losses)
    return losses[best], probabilities[order][best + 1]


def table(dataset, probabilities, right):
    """Return the rows of a dataset: bins of the probability, and the one around 0.9."""
    rows = []
    for low, high in list(zip(BINS, BINS[1:])) + [(0.85, 0.95)]:
        inside = (probabilities >= low) & ((probabilities < high) | (high == 1))
        means = ["%.3f" % values[inside].mean() if inside.any() else "" for values in (probabilities, right)]
        rows.append([dataset, "%.2f" % low, "%.2f" % high, inside.sum()] + means)
    return rows


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=pathlib.Path, metavar="DATA", help="folder that holds the datasets")
    parser.add_argument("--selector", default="auto", help="default: %(default)s")
    parser.add_argument(
        "--csv", type=pathlib.Path, help="file to write the tables to, e.g. docs/data/probability.csv"
    )
    arguments = parser.parse_args()
    present = [name for name in READERS if (arguments.data / name).is_dir()]
    if not present:
        sys.exit("%s holds none of the folders %s" % (arguments.data, ", ".join(READERS)))
    results = {
        name: rated(READERS[name](arguments.data / name), TOLERANCE[name], arguments.selector)
        for name in present
    }
    results["all"] = tuple(np.concatenate(columns) for columns in zip(*results.values()))
    rows = []
    for name, (probabilities, right) in results.items():
        rows += table(name, probabilities, right)
        loss, threshold = best_threshold(probabilities, right)
        print(
            "%s: log loss %.4f, of the best threshold (%.3f) %.4f"
            % (name, log_loss(probabilities, right), threshold, loss)
        )
        for _, low, high, count, mean, share in rows[-len(BINS) :]:
            print(
                "  %s to %s: %7d matches, mean probability %5s, right %5s" % (low, high, count, mean, share)
            )
    if arguments.csv:
        with arguments.csv.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([COLUMNS] + rows)


if __name__ == "__main__":
    main()
