"""Matches with known truth, for the tests of the doors to other libraries."""

import numpy as np

#: The camera of both images, and their size, px.
MATRIX = np.array([[800, 0, 500], [0, 800, 400], [0, 0, 1.0]])
SIZE = (1000, 800)
NOISE = 0.7


def rotation(random, degrees):
    """Return a rotation by an angle around a random axis (Rodrigues' formula)."""
    axis = random.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def generated_pair(seed, plane, count=None, right=None):
    """Return positions in both images and which matches are right: N x 2, N x 2, float32, and N, bool.

    plane   whether the points lie on a plane, otherwise they have depth
    count, right   number of matches and the share of those that are right; None: random
    """
    random = np.random.RandomState(seed)
    count = random.randint(100, 1500) if count is None else count
    right = random.uniform(0.3, 0.8) if right is None else right
    turn, shift = rotation(random, random.uniform(2, 20)), random.uniform(-1, 1, 3)
    shift *= random.uniform(0.3, 1) / np.linalg.norm(shift)
    left_points = random.uniform((0, 0), SIZE, (count, 2))
    rays = np.column_stack([left_points, np.ones(count)]) @ np.linalg.inv(MATRIX).T
    depth = 6 / (rays @ (0.2, 0.1, 1)) if plane else random.uniform(3, 11, count)
    projected = (depth[:, None] * rays @ turn.T + shift) @ MATRIX.T
    right_points = projected[:, :2] / projected[:, 2:]
    truth = np.arange(count) < right * count
    left_points += random.normal(0, NOISE, (count, 2))
    right_points += random.normal(0, NOISE, (count, 2))
    right_points[~truth] = random.uniform((0, 0), SIZE, (np.count_nonzero(~truth), 2))
    order = random.permutation(count)
    return left_points[order].astype(np.float32), right_points[order].astype(np.float32), truth[order]


def described_pair(seed, count=600, dimensions=32):
    """Return keypoints and descriptors of two images, as a network has them, and the true partners.

    Returns (left, right), (left descriptors, right descriptors), float32, of which those of matches are alike, and the
    number of the right keypoint of every left one, -1 for those whose most similar descriptor is a wrong one: 40 %.
    """
    left, right, truth = generated_pair(seed, False, count, 0.6)
    random = np.random.RandomState(seed + 1000)
    descriptors = random.normal(size=(count, dimensions))
    other = descriptors + random.normal(0, 0.1, (count, dimensions))
    order = random.permutation(count)
    place = np.argsort(order)
    return (
        (left, right[order]),
        (descriptors.astype(np.float32), other[order].astype(np.float32)),
        np.where(truth, place, -1),
    )
