#!/usr/bin/env python3
"""Measure `auto` on generated scenes of which it is known what they show.

Without --error_rates, F of `auto` is compared with that of the best one of usac and acransac with either model, for scenes
of four kinds, three sizes of images, five numbers of matches and three shares of right ones. A scene counts where an
acransac has the status ok: where too few matches are right, nothing can be asked of any selector. The matches have
coordinates only.

With --error_rates, it counts how often `auto` says rigid where some points stand out from a plane, and where a facade has
equal windows, and prints the mean F of each.

PYTHONPATH must name the folder of the Python package of corrsel: PYTHONPATH=build/python uses that of a build folder.

Generator
  Cameras   The focal length is 0.9 times the width, and the principal point is the centre. The right camera turns by 2 to 8
            degrees about a random axis, and moves by 0.6, along the optical axis half as much as across.
  Planes    cross the optical axis of the left camera at a depth of 3 to 6, and are tilted by up to 0.5 in x and in y.
  Points    A left point is drawn anywhere in the image, and again until the right image shows it, too. Points in space
            have depths of 2 to 8.
  Noise     of 0.5 px is added to each coordinate of both points of a right match.
  Outliers  are anywhere in both images.
The same kind, size, number, share and seed give the same matches.
"""
import argparse
import collections
import zlib

import corrsel
import numpy as np

SIZES = ((160, 120), (640, 480), (4000, 3000))  # px
COUNTS = (20, 50, 100, 300, 2000)  # matches
SHARES = (0.3, 0.6, 0.9)  # of right matches
NOISE = 0.5  # px
DEPTHS = (2, 8)
OFF_PLANE = 0.1  # of the right matches of plane_10_off
OTHERS = ("usac:h", "usac:f", "acransac:h", "acransac:f")
WITHOUT_THRESHOLD = ("acransac:h", "acransac:f")
FAR_BEHIND = -1  # F of `auto` minus that of the best other one, in percent
LETTERS = {
    "nothing": "n",
    "at_rest": "a",
    "plane_or_rotation": "p",
    "rigid": "r",
    "several_motions": "s",
    "unknown": "u",
}
NOT_PLANE = ("rigid", "several_motions")

# --error_rates
RATE_SIZE, RATE_COUNT, RATE_SHARE = (640, 480), 1000, 0.6
RATE_NOISES = (0.5, 1, 2)  # px
RATE_OFF = (0, 0.02, 0.05, 0.1, 0.2, 0.5)  # of the right matches
RATE_PARALLAXES = (2, 5, 10, 20, 50)  # px
PERIODS = (20, 40, 80)  # px
FACADE_SHARES = (0.3, 0.5, 0.6, 0.9)

Plane = collections.namedtuple("Plane", "normal depth")  # unit vector; where the optical axis meets the plane


class Cameras:
    """Two views of a scene, drawn at random. The left camera is the origin."""

    def __init__(self, size, rng):
        self.size = size
        width, height = size
        focal = 0.9 * width
        self.intrinsics = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        self.rotation = rotation_about(axis, np.radians(rng.uniform(2, 8)))
        shift = rng.normal(size=3) * (1, 1, 0.5)
        self.shift = shift * (0.6 / np.linalg.norm(shift))

    def ray(self, left):
        """Return the point of depth 1 that the left image shows at a place."""
        return np.linalg.solve(self.intrinsics, np.append(left, 1))

    def project(self, point):
        """Return the place of a point in the right image, or None if it is behind the camera."""
        image = self.intrinsics @ (self.rotation @ point + self.shift)
        return image[:2] / image[2] if image[2] > 0 else None

    def show(self, place):
        """Return whether an image shows a place."""
        return 0 <= place[0] < self.size[0] and 0 <= place[1] < self.size[1]

    def along_epipolar_line(self, right):
        """Return the direction of the epipolar line through a place of the right image."""
        epipole = self.intrinsics @ self.shift
        direction = epipole[:2] - epipole[2] * right
        return direction / np.linalg.norm(direction)


def rotation_about(axis, angle):
    """Return the matrix of Rodrigues."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def draw_plane(rng):
    normal = np.array([rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), 1])
    return Plane(normal / np.linalg.norm(normal), rng.uniform(3, 6))


def depth_on(plane, ray):
    """Return the depth at which a ray meets a plane."""
    return plane.depth / (plane.normal @ ray) * plane.normal[2]


def draw_left(size, rng):
    return np.array([rng.uniform(0, size[0]), rng.uniform(0, size[1])])


def anywhere(_):
    return True


def draw_right_matches(count, cameras, plane, rng, allowed=anywhere):
    """Return the exact left and right points of `count` points of a plane, or of space where it is None, one by one.

    After 20000 points, those outside of the right image are taken, too: it may show nothing of a plane.
    """
    drawn = found = 0
    while found < count:
        drawn += 1
        left = draw_left(cameras.size, rng)
        ray = cameras.ray(left)
        depth = rng.uniform(*DEPTHS) if plane is None else depth_on(plane, ray)
        if plane is not None and not 0.5 < depth < 40:
            continue
        if not allowed(left):
            continue
        right = cameras.project(ray * depth)
        if right is None or not cameras.show(right) and drawn < 20000:
            continue
        found += 1
        yield left, right


def noisy(pairs, noise, rng):
    """Return pairs of points with noise."""
    # The noise of a match is drawn before the next match is.
    return [(left + rng.normal(size=2) * noise, right + rng.normal(size=2) * noise) for left, right in pairs]


def shuffled(right_matches, outliers, size, rng, ratios=None):
    """Return Matches in random order and the mask of the right ones.

    ratios  of the descriptor distances, of the right matches and then of the outliers; None = there are no distances
    """
    points = np.array(right_matches + outliers, float).reshape(-1, 2, 2)
    order = rng.permutation(len(points))
    columns = {}
    if ratios is not None:
        second = rng.uniform(200, 400, len(points))
        columns = {"second_distance": second, "distance": np.clip(ratios, 0.05, 1)[order] * second}
    left, right = points[order, 0], points[order, 1]
    matches = corrsel.Matches(left, right, left_size=size, right_size=size, **columns)
    return matches, order < len(right_matches)


def random_outliers(count, size, rng):
    left = rng.uniform(0, 1, (count, 2)) * size
    right = rng.uniform(0, 1, (count, 2)) * size
    return list(zip(left, right))


def seeded(*key):
    return np.random.RandomState(zlib.crc32(repr(key).encode()))


def parts_plane(count, size, planes):
    return [(count, planes[0], anywhere)]


def parts_rigid(count, size, planes):
    return [(count, None, anywhere)]


def parts_two_planes(count, size, planes):
    """The first plane fills the left half of the left image, and the second one the right half."""
    middle = size[0] / 2
    return [
        (count - count // 2, planes[0], lambda left: left[0] < middle),
        (count // 2, planes[1], lambda left: left[0] >= middle),
    ]


def parts_plane_off(count, size, planes):
    off = max(1, int(round(count * OFF_PLANE)))
    return [(count - off, planes[0], anywhere), (off, None, anywhere)]


# The parts of a scene: number of right matches, plane or None for space, and where in the left image they are.
KINDS = {
    "plane": parts_plane,
    "rigid": parts_rigid,
    "two_planes": parts_two_planes,
    "plane_10_off": parts_plane_off,
}


def make_scene(kind, size, count, share, seed):
    """Return Matches of a scene and the mask of the right ones."""
    rng = seeded(kind, size, count, share, seed)
    cameras = Cameras(size, rng)
    planes = [draw_plane(rng), draw_plane(rng)]
    n_right = int(round(count * share))
    right_matches = []
    for part, plane, allowed in KINDS[kind](n_right, size, planes):
        right_matches += noisy(draw_right_matches(part, cameras, plane, rng, allowed), NOISE, rng)
    return shuffled(right_matches, random_outliers(count - n_right, size, rng), size, rng)


def make_rough_plane(off, parallax, noise, seed):
    """Return Matches of a plane, with a share of the right ones displaced along the epipolar lines, and the mask of these.

    off       share of the right matches that are displaced
    parallax  px: the displacements are uniform from -parallax to parallax
    """
    rng = seeded("rough_plane", off, parallax, noise, seed)
    cameras = Cameras(RATE_SIZE, rng)
    n_right = int(round(RATE_COUNT * RATE_SHARE))
    n_off = int(round(n_right * off))
    pairs = []
    for left, right in draw_right_matches(n_right, cameras, draw_plane(rng), rng):
        if len(pairs) < n_off:
            right = right + rng.uniform(-parallax, parallax) * cameras.along_epipolar_line(right)
        pairs.append((left, right))
    outliers = random_outliers(RATE_COUNT - n_right, RATE_SIZE, rng)
    return shuffled(noisy(pairs, noise, rng), outliers, RATE_SIZE, rng)


def make_facade(period, share, distances, seed):
    """Return Matches of a plane with equal windows: half of the outliers are windows taken for one of their neighbours.

    period     px: a window is taken for one that is one to three periods to its left or right in the left image
    distances  of the descriptors: "alike" = those of all matches have ratios around 0.85, as in the generator of the C++
               tests; "apart" = around 0.6 for right matches, and around 0.78 for outliers; "none"
    """
    rng = seeded("facade", period, share, distances, seed)
    cameras = Cameras(RATE_SIZE, rng)
    plane = draw_plane(rng)
    n_right = int(round(RATE_COUNT * share))
    n_outliers = RATE_COUNT - n_right
    right_matches = noisy(draw_right_matches(n_right, cameras, plane, rng), NOISE, rng)
    mistaken = []
    for _ in range(n_outliers // 2):
        move = np.array([rng.choice((-3, -2, -1, 1, 2, 3)) * period, 0])
        (pair,) = draw_right_matches(1, cameras, plane, rng, lambda left: cameras.show(left + move))
        mistaken.append((pair[0] + move, pair[1]))
    outliers = noisy(mistaken, NOISE, rng) + random_outliers(n_outliers - len(mistaken), RATE_SIZE, rng)
    ratios = {
        "alike": rng.normal(0.85, 0.08, RATE_COUNT),
        "apart": np.append(rng.normal(0.6, 0.12, n_right), rng.normal(0.78, 0.1, n_outliers)),
        "none": None,
    }[distances]
    return shuffled(right_matches, outliers, RATE_SIZE, rng, ratios)


def f_of(mask, right):
    """Return F in percent."""
    return 200 * np.sum(mask & right) / (np.sum(mask) + np.sum(right))


def measure_cell(kind, size, count, share, seeds, selectors):
    """Return F of each selector for the scenes where acransac finds something, and the Selections of `auto` of all."""
    scores = {name: [] for name in selectors}
    answers = []
    for seed in range(seeds):
        matches, right = make_scene(kind, size, count, share, seed)
        found = {name: selector.select(matches) for name, selector in selectors.items()}
        answers.append(found["auto"])
        if any(found[name].status == "ok" for name in WITHOUT_THRESHOLD):
            for name, selection in found.items():
                scores[name].append(f_of(selection.mask, right))
    return scores, answers


def difference(scores):
    """Return the mean F of `auto` minus that of the best other selector, NaN without scenes."""
    if not scores["auto"]:
        return np.nan
    return np.mean(scores["auto"]) - max(np.mean(scores[name]) for name in OTHERS)


def cell_text(scores, answers):
    counts = collections.Counter(answer.scene for answer in answers)
    scenes = " ".join("%d%s" % (counts[scene], letter) for scene, letter in LETTERS.items() if counts[scene])
    return "%6.1f (%d) %-9s" % (difference(scores), len(scores["auto"]), scenes)


def print_grid(seeds):
    selectors = {name: corrsel.Selector(name) for name in ("auto",) + OTHERS}
    differences, certain = {}, collections.defaultdict(list)
    print(
        "F of auto minus that of the best of %s, %% (scenes where an acransac has the status ok),"
        % ", ".join(OTHERS)
    )
    print(
        "and the scenes found: %s" % ", ".join("%s %s" % (letter, scene) for scene, letter in LETTERS.items())
    )
    print(
        "%-12s %9s %4s" % ("", "px", "N"), *("| %-20s" % ("%d %% right" % (100 * share)) for share in SHARES)
    )
    for kind in KINDS:
        for size in SIZES:
            for count in COUNTS:
                texts = []
                for share in SHARES:
                    scores, answers = measure_cell(kind, size, count, share, seeds, selectors)
                    differences[kind, size, count, share] = difference(scores)
                    certain[kind] += [answer.scene for answer in answers if answer.status == "ok"]
                    texts.append("| " + cell_text(scores, answers))
                print("%-12s %9s %4d" % (kind, "%dx%d" % size, count), *texts, flush=True)
    print_summary(differences, certain)


def print_summary(differences, certain):
    """Print what the table shows.

    certain  of each kind of scene, what was found with the status ok
    """
    print("\nMean of the cells:\n%-12s" % "", *("N = %-5d" % count for count in COUNTS))
    for kind in KINDS:
        rows = [[d for key, d in differences.items() if key[0] == kind and key[2] == n] for n in COUNTS]
        print("%-12s" % kind, *("%-9s" % ("%.1f" % np.nanmean(row)) for row in rows))
    values = np.array(list(differences.values()))
    print("\nCells below %d: %d of %d" % (FAR_BEHIND, np.sum(values < FAR_BEHIND), np.sum(~np.isnan(values))))
    print("Wrong kind of scene, with the status ok:")
    for kind, scenes in certain.items():
        wrong = NOT_PLANE if kind == "plane" else ("plane_or_rotation",)
        count = sum(scene in wrong for scene in scenes)
        print("  %s called %s: %d of %d" % (kind, " or ".join(wrong), count, len(scenes)))


def measure_rates(selector, make, seeds, *key):
    """Return how many percent of the scenes of a kind are called rigid, and the mean F."""
    rigid, scores = [], []
    for seed in range(seeds):
        matches, right = make(*key, seed)
        selection = selector.select(matches)
        rigid.append(selection.scene == "rigid")
        scores.append(f_of(selection.mask, right))
    return 100 * np.mean(rigid), np.mean(scores)


def print_error_rates(seeds):
    auto = corrsel.Selector("auto")
    print("Called rigid, %%, and mean F. %d matches, %dx%d px" % (RATE_COUNT, *RATE_SIZE))
    for noise in RATE_NOISES:
        print("\nPlane, %d %% right, noise %g px; off the plane and parallax:" % (100 * RATE_SHARE, noise))
        print("%8s" % "", *("%11d px" % parallax for parallax in RATE_PARALLAXES))
        for off in RATE_OFF:
            rates = [measure_rates(auto, make_rough_plane, seeds, off, p, noise) for p in RATE_PARALLAXES]
            print("%6d %%" % (100 * off), *("%8.1f %5.1f" % rate for rate in rates), flush=True)
    print("\nFacade, noise %g px; ratios of descriptor distances, period and right matches:" % NOISE)
    print("%14s" % "", *("%12d %%" % (100 * share) for share in FACADE_SHARES))
    for distances in ("alike", "apart", "none"):
        for period in PERIODS:
            rates = [measure_rates(auto, make_facade, seeds, period, s, distances) for s in FACADE_SHARES]
            print("%8s %2d px" % (distances, period), *("%8.1f %5.1f" % rate for rate in rates), flush=True)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=4, help="scenes of each kind; default: %(default)s")
    parser.add_argument("--error_rates", action="store_true", help="count the planes that are called rigid")
    arguments = parser.parse_args()
    (print_error_rates if arguments.error_rates else print_grid)(arguments.seeds)


if __name__ == "__main__":
    main()
