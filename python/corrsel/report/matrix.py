"""The matrix of all pairs of images as a picture: what was found above the diagonal, numbers of inliers below it."""
import base64
import struct
import zlib

import numpy as np

LARGEST = 1500  # cells of a side; more images share cells
WIDTH = 880  # px of the picture on the page, at least

# Numbers of configs in the order of the legend, beside their colours. The first three are no configs of COLMAP.
NOT_TRIED, REJECTED, FAULTY = 0, 1, 2
KINDS = (
    ("not tried", (255, 255, 255)),
    ("rejected", (214, 214, 214)),
    ("faulty", (200, 30, 30)),
    ("degenerate", (120, 120, 120)),
    ("multiple", (150, 100, 60)),
    ("planar_or_panoramic", (240, 170, 200)),
    ("panoramic", (170, 90, 180)),
    ("planar", (230, 159, 0)),
    ("uncalibrated", (0, 158, 115)),
    ("calibrated", (0, 114, 178)),
)
KIND_NUMBERS = {name: number for number, (name, _) in enumerate(KINDS)}
FEW, MANY = np.array((198, 219, 239.0)), np.array(
    (8, 48, 107.0)
)  # colours of the fewest and the most inliers


def png(pixels):
    """Return (height, width, 3) bytes as a PNG file."""

    def chunk(name, data):
        checked = name + data
        return struct.pack(">I", len(data)) + checked + struct.pack(">I", zlib.crc32(checked))

    height, width = pixels.shape[:2]
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each begins with the number of its filter, none
    rows[:, 1:] = pixels.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(rows.tobytes(), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def inlier_colours(kept, most):
    """Return the colours of numbers of inliers on a logarithmic scale from 10 to the most of all."""
    scale = np.log(np.clip(kept, 10, None) / 10) / max(np.log(max(most, 11) / 10), 1e-9)
    return (FEW + np.clip(scale, 0, 1)[:, None] * (MANY - FEW)).astype(np.uint8)


def cells(count):
    """Return how many images share a row of the picture."""
    return max(1, -(-count // LARGEST))


def picture(count, first, second, kinds, kept):
    """Return the pixels of the matrix, a cell a pixel.

    `first` and `second` are places of the images of the pairs in the order of the matrix. Of several pairs in one cell, the
    one whose kind comes last in the legend shows, and of these the one with the most inliers.
    """
    shared = cells(count)
    side = -(-count // shared)
    pixels = np.full((side, side, 3), 255, np.uint8)
    low, high = np.minimum(first, second) // shared, np.maximum(first, second) // shared
    order = np.lexsort((kept, kinds))  # the last one that is written stays
    low, high, kinds, kept = low[order], high[order], kinds[order], kept[order]
    colours = np.array([colour for _, colour in KINDS], np.uint8)[kinds]
    below = np.where((kinds > FAULTY)[:, None], inlier_colours(kept, kept.max(initial=0)), colours)
    pixels[high, low] = below
    pixels[low, high] = colours
    pixels[np.arange(side), np.arange(side)] = 90
    return pixels


def data_url(pixels):
    """Return a picture as the address of an <img>."""
    return "data:image/png;base64," + base64.b64encode(png(pixels)).decode("ascii")
