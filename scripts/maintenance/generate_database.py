#!/usr/bin/env python3
"""Generates a database of COLMAP with putative matches of many pairs, of which a given share has a model.

Usage: generate_database.py [--pairs N] [--matches N] [--true-share X] [--images-of-place N] [--seed N] DATABASE

Every image shows one of several places. The points of a place lie on a relief, which all images of the place see from
positions along a line. Pairs of one place come first and make up the given share; of their matches, half are right, with
a noise of 0.5 px. The other pairs are of different places, and their matches are random. Used to measure the speed, the
memory and the resuming of corrsel_verify (docs/verification.md); the same arguments give the same rows.
"""
import argparse
import itertools
import sqlite3
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from corrsel.files.colmap import SCHEMA, pair_id  # pylint: disable=wrong-import-position

WIDTH, HEIGHT, FOCAL = 1200, 800, 1000.0


def keypoints_of_place(random, images, points):
    """Return images x points x 2 positions of the points of a place, px with the corner as origin."""
    scene = random.uniform((-3, -3, 8), (3, 3, 14), (points, 3))
    out = np.empty((images, points, 2), np.float32)
    for k in range(images):
        angle, shift = 0.02 * (k - images / 2), 0.12 * (k - images / 2)
        turn = np.array(
            [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]], float
        )
        seen = (scene - (0, 0, 11)) @ turn.T + (shift, 0, 11)
        out[k] = FOCAL * seen[:, :2] / seen[:, 2:] + (WIDTH / 2, HEIGHT / 2)
    noisy = out + random.normal(0, 0.5, out.shape)
    return np.clip(noisy, 0, (WIDTH, HEIGHT)).astype(np.float32)


def matches_of_pair(random, matches, points, same_place):
    """Return matches x 2 numbers of keypoints; of two images of one place, every other match is right."""
    first = random.choice(points, matches, replace=False)
    second = random.choice(points, matches, replace=False)
    if same_place:
        second[::2] = first[::2]
    return np.stack([first, second], 1)[np.argsort(first)].astype("<u4")


def chosen_pairs(pairs, share, of_place, places):
    """Return (number of the first image, number of the second, whether of one place), in ascending order."""
    count = of_place * places
    inside = itertools.chain.from_iterable(
        itertools.combinations(range(p * of_place, (p + 1) * of_place), 2) for p in range(places)
    )
    true = list(itertools.islice(inside, round(pairs * share)))
    across = ((a, b) for a, b in itertools.combinations(range(count), 2) if a // of_place != b // of_place)
    false = list(itertools.islice(across, pairs - len(true)))
    if len(true) + len(false) < pairs:
        sys.exit(
            "generate_database.py: error: too few images for --pairs %d; raise --images-of-place" % pairs
        )
    return sorted([(a, b, True) for a, b in true] + [(a, b, False) for a, b in false])


def write(path, options):
    """Write the database."""
    random = np.random.default_rng(options.seed)
    of_place = options.images_of_place
    places = max(2, -(-round(options.pairs * options.true_share) // (of_place * (of_place - 1) // 2)))
    points = 2 * options.matches
    with sqlite3.connect(str(path)) as database:
        database.executescript("PRAGMA journal_mode = WAL; PRAGMA user_version = 3800;" + SCHEMA)
        camera = np.array([FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2])
        database.execute("INSERT INTO cameras VALUES (1, 1, ?, ?, ?, 1)", (WIDTH, HEIGHT, camera.tobytes()))
        for place in range(places):
            for k, positions in enumerate(keypoints_of_place(random, of_place, points)):
                number = place * of_place + k + 1
                name = "place%03d_%03d.jpg" % (place, k)
                database.execute(
                    "INSERT INTO images(image_id, name, camera_id) VALUES (?, ?, 1)", (number, name)
                )
                database.execute(
                    "INSERT INTO keypoints VALUES (?, ?, 2, ?)", (number, points, positions.tobytes())
                )
        rows = (
            (
                pair_id(a + 1, b + 1),
                options.matches,
                matches_of_pair(random, options.matches, points, same).tobytes(),
            )
            for a, b, same in chosen_pairs(options.pairs, options.true_share, of_place, places)
        )
        database.executemany("INSERT INTO matches VALUES (?, ?, 2, ?)", rows)
    database.close()


def parser():
    """Return the parser of the command line."""
    out = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    out.add_argument("database", metavar="DATABASE", type=Path)
    out.add_argument("--pairs", type=int, default=131000, help="number of pairs [131000]")
    out.add_argument("--matches", type=int, default=370, help="putative matches of every pair [370]")
    out.add_argument("--true-share", type=float, default=0.41, help="share of pairs with a model [0.41]")
    out.add_argument("--images-of-place", type=int, default=40, help="images that show one place [40]")
    out.add_argument("--seed", type=int, default=1)
    return out


def main():
    """Run the command line."""
    options = parser().parse_args()
    if options.database.exists():
        sys.exit("generate_database.py: error: %s exists" % options.database)
    write(options.database, options)


if __name__ == "__main__":
    main()
