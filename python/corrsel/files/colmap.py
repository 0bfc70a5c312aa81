"""Databases of COLMAP: SQLite files with cameras, images, keypoints and matches.

COLMAP's database format (colmap.github.io/database.html): keypoints are float32 rows of 2 (x, y), 4 (also scale and
orientation) or 6 columns (also a11 a12 a21 a22), the centre of the first pixel is (0.5, 0.5), matches are uint32 pairs
of rows of keypoints, and the row of a pair of images has the number 2147483647 * image_id1 + image_id2 with
image_id1 < image_id2.
"""
import contextlib
import sqlite3

import numpy as np

from .csv_list import similarity_shapes
from .pairs import InputError, MatchedPair, distinct_rows, points

LARGEST_ID = 2147483647
PIXEL_CENTRE = 0.5  # px, coordinate of the centre of the first pixel
SIMPLE_RADIAL = 2  # the number of the camera model f, cx, cy, k
FOCAL_FACTOR = 1.2  # of the larger side of the image: COLMAP's guess where nothing is known

# The columns that COLMAP has written from version 3.4 on; newer versions add their own tables when they open it.
SCHEMA = """
CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL,
  width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB, prior_focal_length INTEGER NOT NULL);
CREATE TABLE images (image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE,
  camera_id INTEGER NOT NULL, prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL, prior_tx REAL,
  prior_ty REAL, prior_tz REAL, CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647),
  FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE UNIQUE INDEX index_name ON images(name);
CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL,
  data BLOB, FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL,
  data BLOB, FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE matches (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB);
CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,
  cols INTEGER NOT NULL, data BLOB, config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);
"""


def pair_id(first, second):
    """Return the number of a pair of images."""
    return LARGEST_ID * min(first, second) + max(first, second)


def image_ids(number):
    """Return the two images of a pair's number."""
    return divmod(number, LARGEST_ID)


def read_database(path, listed=None):
    """Yield the MatchedPair of every pair of images with matches. Raises InputError that names the table and the row.

    listed: [(left name, right name, truth, place)] of the pairs to read; None: all
    """
    with _reading(path) as database:
        images = _images(database, path)
        keypoints = {}

        def keypoints_of(image):
            if image not in keypoints:
                keypoints[image] = _keypoints(database, path, image)
            return keypoints[image]

        for number, reverse in _pairs(database, path, images, listed):
            yield _pair(database, path, number, images, keypoints_of, reverse)


@contextlib.contextmanager
def _reading(path):
    """Open a database and turn errors of SQLite into InputError."""
    try:
        database = sqlite3.connect(path.resolve().as_uri() + "?mode=ro", uri=True)
        try:
            yield database
        finally:
            database.close()
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise InputError("%s is damaged or no database of COLMAP (%s)" % (path, error)) from error


def _images(database, path):
    """Return {image_id: (name, (width, height))}."""
    rows = database.execute(
        "SELECT image_id, name, width, height FROM images LEFT JOIN cameras ON images.camera_id = cameras.camera_id"
    ).fetchall()
    if not rows:
        raise InputError("%s: the table images is empty; run COLMAP's feature_extractor first" % path)
    for image, name, width, height in rows:
        if not isinstance(name, str) or not name:
            raise InputError(
                "%s: table images, image_id %d has the name %r, expected a text" % (path, image, name)
            )
        if not all(isinstance(side, int) and 0 < side < 2**20 for side in (width, height)):
            raise InputError(
                "%s: table images, image_id %d (%s): its camera has the size %sx%s, expected px"
                % (path, image, name, width, height)
            )
    return {image: (name, (width, height)) for image, name, width, height in rows}


def _keypoints(database, path, image):
    """Return positions and shapes (or None) of the keypoints of an image."""
    place = "%s: table keypoints, image_id %d" % (path, image)
    row = database.execute("SELECT rows, cols, data FROM keypoints WHERE image_id = ?", (image,)).fetchone()
    if row is None:
        raise InputError("%s is missing, but the image has matches" % place)
    count, columns, data = row
    if columns not in (2, 4, 6):
        raise InputError("%s has %s columns, expected 2, 4 or 6" % (place, columns))
    values = _array(data, np.float32, count, columns, place)
    positions = points(
        values[:, :2] - np.float32(PIXEL_CENTRE), str(path), "keypoints of image_id %d" % image
    )
    if columns == 2:
        return positions, None
    return positions, values[:, 2:] if columns == 6 else similarity_shapes(values[:, 2], values[:, 3])


def _pairs(database, path, images, listed):
    """Yield the numbers of pairs, and whether left and right are to be exchanged."""
    numbers = [number for number, in database.execute("SELECT pair_id FROM matches ORDER BY pair_id")]
    for number in numbers:
        for image in image_ids(number):
            if image not in images:
                raise InputError(
                    "%s: table matches, pair_id %d: there is no image_id %d in the table images"
                    % (path, number, image)
                )
    if listed is None:
        if not numbers:
            raise InputError("%s: the table matches is empty; run one of COLMAP's matchers first" % path)
        yield from ((number, False) for number in numbers)
        return
    matched = set(numbers)
    by_name = {name: image for image, (name, _) in images.items()}
    for left, right, _, place in listed:
        for name in (left, right):
            if name not in by_name:
                raise InputError("%s: there is no image '%s' in %s" % (place, name, path))
        number = pair_id(by_name[left], by_name[right])
        if number not in matched:
            raise InputError(
                "%s: the pair %s %s has no matches in %s; remove the line" % (place, left, right, path)
            )
        yield number, by_name[left] > by_name[right]


def _pair(database, path, number, images, keypoints_of, reverse):
    place = "%s: table matches, pair_id %d" % (path, number)
    count, columns, data = database.execute(
        "SELECT rows, cols, data FROM matches WHERE pair_id = ?", (number,)
    ).fetchone()
    if columns != 2 and count:
        raise InputError("%s has %s columns, expected 2" % (place, columns))
    rows = _array(data, np.uint32, count, 2, place)
    first, second = image_ids(number)
    positions, shapes, names, sizes, counts = [], [], [], [], []
    for side, image in enumerate((first, second)):
        points, shape = keypoints_of(image)
        wrong = np.flatnonzero(rows[:, side] >= len(points))
        if len(wrong):
            raise InputError(
                "%s, match %d names the keypoint %d of image_id %d, which has %d (numbers 0 to %d)"
                % (place, wrong[0], rows[wrong[0], side], image, len(points), len(points) - 1)
            )
        positions.append(points[rows[:, side]])
        shapes.append(None if shape is None else shape[rows[:, side]])
        counts.append(len(points))
        names.append(images[image][0])
        sizes.append(images[image][1])
    if shapes[0] is None or shapes[1] is None:
        shapes = [None, None]
    pair = MatchedPair(
        place,
        "",
        positions[0],
        positions[1],
        left_name=names[0],
        right_name=names[1],
        left_shape=shapes[0],
        right_shape=shapes[1],
        left_index=rows[:, 0],
        right_index=rows[:, 1],
        left_count=counts[0],
        right_count=counts[1],
        left_size=sizes[0],
        right_size=sizes[1],
    )
    return pair.exchanged() if reverse else pair


def _array(data, dtype, rows, columns, place):
    data = b"" if data is None else data
    for name, value, kind in (("rows", rows, int), ("cols", columns, int), ("data", data, bytes)):
        if not isinstance(value, kind):
            raise InputError(
                "%s: %s is %.40r, expected %s"
                % (place, name, value, "a whole number" if kind is int else "a BLOB")
            )
    expected = rows * columns * np.dtype(dtype).itemsize
    if len(data) != expected:
        raise InputError(
            "%s: data has %d bytes, expected %d for %d rows and %d columns; the database is damaged"
            % (place, len(data), expected, rows, columns)
        )
    return np.frombuffer(data, dtype).reshape(rows, columns)


def write_database(path, images, matches):
    """Write a database; an older file is replaced.

    images:  [(name, (width, height), positions, shapes or None)]; positions with the centre of the first pixel at
             (0, 0); image_id and camera_id count from 1 in this order
    matches: [(first, second, (N, 2) rows of keypoints)] with numbers of images from 0
    """
    with _writing(path) as database:
        database.executescript(SCHEMA)
        for number, (name, (width, height), positions, shapes) in enumerate(images, 1):
            parameters = np.array([FOCAL_FACTOR * max(width, height), width / 2, height / 2, 0], np.float64)
            database.execute(
                "INSERT INTO cameras VALUES (?, ?, ?, ?, ?, 0)",
                (number, SIMPLE_RADIAL, width, height, parameters.tobytes()),
            )
            database.execute(
                "INSERT INTO images(image_id, name, camera_id) VALUES (?, ?, ?)", (number, name, number)
            )
            rows = np.asarray(positions, np.float32) + np.float32(PIXEL_CENTRE)
            if shapes is not None:
                rows = np.concatenate([rows, np.asarray(shapes, np.float32)], axis=1)
            database.execute(
                "INSERT INTO keypoints VALUES (?, ?, ?, ?)",
                (number, len(rows), rows.shape[1], rows.tobytes()),
            )
        _write_matches(database, [(first + 1, second + 1, rows) for first, second, rows in matches])


def replace_matches(source, path, matches):
    """Write a copy of a database whose matches are replaced and whose verified geometries are removed.

    matches: [(name, name, (N, 2) rows of keypoints)]
    """
    with _reading(source) as database:
        images = _images(database, source)
        counts = dict(database.execute("SELECT image_id, rows FROM keypoints").fetchall())
    numbers = {name: image for image, (name, _) in images.items()}
    rows_of = []
    for left, right, rows in matches:
        for name, column in ((left, 0), (right, 1)):
            if name not in numbers:
                raise InputError(
                    "%s has no image '%s', which the run has; give the database of these images"
                    % (source, name)
                )
            if len(rows) and rows[:, column].max() >= counts.get(numbers[name], 0):
                raise InputError(
                    "%s: the image '%s' has %d keypoints, the run has a keypoint %d of it; give the database from which "
                    "the matches came" % (source, name, counts.get(numbers[name], 0), rows[:, column].max())
                )
        rows_of.append((numbers[left], numbers[right], rows))
    with _writing(path, source) as database:
        database.execute("DELETE FROM matches")
        database.execute("DELETE FROM two_view_geometries")
        _write_matches(database, rows_of)


def _write_matches(database, matches):
    together = {}
    for first, second, rows in matches:
        rows = np.asarray(rows, np.uint32).reshape(-1, 2)
        if first > second:
            rows = rows[:, ::-1]
        together.setdefault(pair_id(first, second), []).append(rows)
    for number, parts in sorted(together.items()):
        rows = np.concatenate(parts)
        rows = rows[np.sort(distinct_rows(rows)[1])]  # COLMAP allows each match once
        database.execute(
            "INSERT INTO matches VALUES (?, ?, 2, ?)",
            (number, len(rows), np.ascontiguousarray(rows).tobytes()),
        )


@contextlib.contextmanager
def _writing(path, source=None):
    """Yield a database that gets its name when it is complete."""
    part = path.with_name(path.name + ".part")
    try:
        if part.exists():
            part.unlink()
        database = sqlite3.connect(str(part))
        try:
            if source is not None:
                with _reading(source) as original:
                    original.backup(
                        database
                    )  # unlike a copy of the file, with what is in its write-ahead log
            yield database
            database.commit()
        finally:
            database.close()
        part.replace(path)
    except (OSError, sqlite3.Error) as error:
        raise InputError("cannot write %s: %s" % (path, error)) from error
    finally:
        if part.exists():
            part.unlink()
