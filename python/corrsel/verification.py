"""Verification of whole databases of COLMAP, and of files of hloc."""

import collections
import os

import numpy as np

from . import _arrays, _database, _options

FaultyPair = collections.namedtuple("FaultyPair", "first second message")
FaultyPair.__doc__ = """A pair whose rows in the database cannot be used: two names of images, and why."""


class VerifyReport:
    """What verify() did and found. Row i of every array belongs to pair i, in ascending order of the pairs.

    path            the file with the results
    images          names of all images, by their numbers
    pairs           (N, 2) uint32: numbers of the images, the smaller one first; pairs that are stored, also by earlier
                    runs with the same configuration, but not faulty ones
    putative        (N,) uint32: number of matches that were given
    inliers         (N,) uint32: number of matches that are stored
    config          (N,) uint8: what was found, as COLMAP numbers it: CONFIGS[number] is its name; 0: rejected
    status          (N,) uint8: STATUSES[number] is the selector's status
    scene           (N,) uint8: SCENES[number] is what the matches show
    confidence      (N,) float64: see Selection.confidence; NaN where the selector has none
    ambiguity       (N,) float64 from 0 to 1: how well a second relation explains the matches; NaN if not examined
    faulty          list of FaultyPair: rows that cannot be used; nothing is written for them
    warnings        list of sentences about the database
    configuration   settings as text, by which a later run knows which pairs are done
    verified        number of pairs that this run has verified
    skipped         number of pairs that an earlier run has verified
    of_others       number of pairs that were left because another program has verified them
    seconds         duration of the verification
    """

    CONFIGS = tuple(_database.CONFIGS)
    STATUSES = tuple(_database.STATUSES)
    SCENES = tuple(_database.SCENES)

    def __init__(self, path, **values):
        self.path = path
        self.images = values["images"]
        self.pairs = values["pairs"]
        self.putative = values["putative"]
        self.inliers = values["inliers"]
        self.config = values["config"]
        self.status = values["status"]
        self.scene = values["scene"]
        self.confidence = values["confidence"]
        self.ambiguity = values["ambiguity"]
        self.faulty = [
            FaultyPair(self._name(first), self._name(second), message)
            for first, second, message in values["faulty"]
        ]
        self.warnings = values["warnings"]
        self.configuration = values["configuration"]
        self.verified = values["verified"]
        self.skipped = values["skipped"]
        self.of_others = values["of_others"]
        self.seconds = values["seconds"]

    @property
    def accepted(self):
        """(N,) bool: whether a relation between the images was found."""
        return self.config != 0

    @property
    def configs(self):
        """Numbers of pairs by the name of their config."""
        numbers, counts = np.unique(self.config, return_counts=True)
        return {self.CONFIGS[number]: int(count) for number, count in zip(numbers, counts)}

    def names(self):
        """Return the names of the images of every pair: [(first, second)]."""
        return [(self._name(first), self._name(second)) for first, second in self.pairs.tolist()]

    def __len__(self):
        return len(self.pairs)

    def __repr__(self):
        return "<corrsel.VerifyReport: %d of %d pairs accepted, %d faulty, in %s>" % (
            np.count_nonzero(self.config),
            len(self),
            len(self.faulty),
            self.path,
        )

    def _name(self, number):
        return self.images.get(number, "image_id %d" % number)


def verify(
    database,
    output=None,
    selector=None,
    *,
    features=None,
    threads=1,
    pairs=None,
    again=False,
    strict=False,
    dry_run=False,
    memory=1.0,
    progress=None,
    **options
):
    """Verify the pairs of images in a database of COLMAP, or in files of hloc, and store what was found.

    Returns a VerifyReport. COLMAP's mapper then starts without verifying again. A run that was interrupted or killed continues when it is
    called again with the same arguments: pairs are stored every 500 pairs or 2 s.

    database   a file of COLMAP 3.4 or later with keypoints, matches and cameras; or, with `features`, hloc's matches
    output     a new file that takes the results, called like it with ".part" appended until it is complete;
               None: the database itself changes, where rows of other programs stay unless `again` is set
    selector   name, preset and options of a selector that computes a confidence, e.g. "auto" or "auto:f"; None: the
               default of options("verification")
    features   hloc's file of features; the output is then a copy of the matches in which only inliers are left
    threads    number of threads; the result does not depend on it
    pairs      names of images, [(first, second)]: only these pairs; None: all that have matches
    again      verify pairs that are verified already
    strict     stop at the first pair whose rows cannot be used; the report then ends there
    dry_run    verify, and write nothing
    memory     GiB for keypoints that are kept for further pairs
    progress   a function of the numbers of pairs done, of all pairs, of accepted ones, and of the seconds since the
               start, called from time to time. What it raises ends the run, as Ctrl-C does: what is complete is stored,
               and verify() raises the same
    options    options of the verification, e.g. min_matches=30; options("verification") lists them

    Raises BlockingIOError where another program writes to the database, other kinds of OSError where a file cannot be
    opened, read or written, ValueError for a file that is no such database, and for options out of their range. The
    messages name the file, what is wrong, and the remedy. Rows that cannot be used do not raise: the report lists them.
    Takes about as long as `selector` takes for each pair.
    """
    database = os.fspath(database)
    if selector is not None:
        options["selector"] = selector
    names = None if pairs is None else [(str(first), str(second)) for first, second in pairs]
    run = {
        "threads": _arrays.threads(threads),
        "again": bool(again),
        "strict": bool(strict),
        "dry_run": bool(dry_run),
        "memory": float(memory),
    }
    if progress is not None and not callable(progress):
        raise TypeError("progress is %r; needed: a function of done, total, accepted, seconds" % (progress,))
    texts = _options.to_text("verification", options)
    if features is not None:
        if output is None and not dry_run:
            raise ValueError("output is None; needed: a new file, since files of hloc are never changed")
        output = "" if output is None or dry_run else os.fspath(output)
        files = (database, os.fspath(features), output, False)
        return VerifyReport(output or database, **_database.verify(files, texts, run, names, progress))
    if output is None or dry_run:
        files = (database, "", "", True)
        return VerifyReport(database, **_database.verify(files, texts, run, names, progress))
    return _verify_copy(database, os.fspath(output), texts, run, names, progress)


def _verify_copy(database, output, texts, run, names, progress):
    """Verify a copy of a database, which gets its name when it is complete."""
    if os.path.exists(output):
        raise FileExistsError(
            "%s exists; remove it or choose another name, or give it as database to continue it" % output
        )
    part = output + ".part"
    _database.continue_copy(database, part)
    result = _database.verify((part, "", "", False), texts, run, names, progress)
    if run["strict"] and result["faulty"]:
        return VerifyReport(part, **result)
    os.rename(part, output)
    return VerifyReport(output, **result)
