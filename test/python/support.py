"""What the tests of the Python package share: results of C++ to compare with, images, arrays from JSON."""

import functools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

import corrsel
import numpy as np


@functools.lru_cache(maxsize=None)
def images():
    """Return two grey images, 240 x 320 px, of the same rectangles; the right one shows them 9 px to the left and
    4 px higher."""
    random = np.random.RandomState(1)
    canvas = np.full((300, 400), 128, np.uint8)
    for _ in range(250):
        x, y = random.randint(0, 380), random.randint(0, 280)
        width, height = random.randint(3, 25, 2)
        canvas[y : y + height, x : x + width] = random.randint(0, 256)
    return canvas[20:260, 20:340].copy(), canvas[24:264, 29:349].copy()


@functools.lru_cache(maxsize=None)
def expected():
    """Return what the program python_expected prints: results of C++ for two generated scenes and for images()."""
    program = pathlib.Path(os.environ["CORRSEL_BINARY_DIR"]) / "test" / "python_expected"
    with tempfile.TemporaryDirectory() as folder:
        for name, image in zip(("left", "right"), images()):
            header = b"P5 %d %d 255\n" % (image.shape[1], image.shape[0])
            (pathlib.Path(folder) / (name + ".pgm")).write_bytes(header + image.tobytes())
        return json.loads(subprocess.run([program, folder], stdout=subprocess.PIPE, check=True).stdout)


def releases_the_lock(action):
    """Whether another thread runs while the action does. The interpreter would never take its lock from the thread of
    the action, so the other thread counts only if the lock is given away. How long that takes depends on the machine,
    whether it happens does not: up to 100 calls are tried."""
    counted, ended = [0], threading.Event()

    def count():
        while not ended.is_set():
            counted[0] += 1
            time.sleep(1e-4)

    def counts_during_a_call():
        before = counted[0]
        action()
        return counted[0] > before

    counter = threading.Thread(target=count)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    counter.start()
    try:
        return any(counts_during_a_call() for _ in range(100))
    finally:
        ended.set()
        counter.join()
        sys.setswitchinterval(interval)


def floats(values):
    """Return JSON's numbers as float32; null stands for NaN."""
    return np.array([np.nan if value is None else value for value in values], np.float32)


def matches_from(columns):
    """Return the Matches of a scene of expected()."""
    arrays = {
        "distance": floats(columns["distance"]),
        "second_distance": floats(columns["second_distance"]),
        "probability": floats(columns["probability"]),
        "left_frame": np.array(columns["left_frame"], np.float32).reshape(-1, 2, 3),
        "right_frame": np.array(columns["right_frame"], np.float32).reshape(-1, 2, 3),
        "left_index": np.array(columns["left_index"], np.uint32),
        "right_index": np.array(columns["right_index"], np.uint32),
    }
    return corrsel.Matches(
        np.stack([floats(columns["left_x"]), floats(columns["left_y"])], 1),
        np.stack([floats(columns["right_x"]), floats(columns["right_y"])], 1),
        left_size=columns["left_size"],
        right_size=columns["right_size"],
        **{name: array for name, array in arrays.items() if len(array)}
    )


def scene(number=0):
    """Return the Matches of a generated scene: 0 is a plane, with frames; 1 has depth, without frames."""
    return matches_from(expected()["scenes"][number]["matches"])
