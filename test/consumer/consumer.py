#!/usr/bin/env python3
"""Uses the installed Python package: matches of a translation and unrelated ones, and two images of one scene."""

import corrsel
import numpy as np

random = np.random.default_rng(1)
left = random.uniform((0, 0), (600, 450), (100, 2)).astype(np.float32)
right = left + np.float32([30, 20])
right[80:] = random.uniform((0, 0), (640, 480), (20, 2))
selection = corrsel.select(left, right, "ransac", left_size=(640, 480), right_size=(640, 480))
print(f"corrsel {corrsel.__version__}: {np.count_nonzero(selection.mask)} of {len(left)} matches selected")
assert selection.mask[:80].all() and np.count_nonzero(selection.mask) < 85

scene = np.kron(random.integers(0, 256, (40, 50)), np.ones((8, 8))).astype(np.uint8)
matches = corrsel.match(scene[:240, :320], scene[16:256, 24:344], features="orb+orb")
selection = matches.select("gms")
print(f"{np.count_nonzero(selection.mask)} of {len(matches.left)} matches of two images selected")
shift = np.median((matches.left - matches.right)[selection.mask.astype(bool)], axis=0)
assert np.allclose(shift, (24, 16), atol=1), shift
