"""Matches two images from the shell: python3 -m corrsel LEFT RIGHT (see docs/doors.md, and --help).

The program is that of corrsel_match, in C++. This front gives it the modules cv2, for image files, and yaml, for files of
cameras, and writes NPZ files.
"""

import sys

import numpy as np

from . import _features
from .camera import Camera
from .files.saved import selection_arrays
from .selectors import Matches

PROGRAM = "python3 -m corrsel"


class Front:
    """What the program needs beyond the libraries in C++."""

    def __init__(self, cv2):
        self._cv2 = cv2

    def decode(self, data):
        """Return the image in the bytes of a file, BGR, or None."""
        return self._cv2.imdecode(np.frombuffer(data, np.uint8), self._cv2.IMREAD_COLOR)

    def encode(self, ending, image):
        """Return the bytes of an image file; none for an unknown ending."""
        if not self._cv2.haveImageWriter("x" + ending):
            return b""
        return self._cv2.imencode(ending, image)[1].tobytes()

    @staticmethod
    def camera(path, name):
        """Return the Camera in a YAML file of Kalibr or EuRoC."""
        import yaml  # pylint: disable=import-outside-toplevel  # few calls need it

        try:
            with open(path, encoding="utf-8") as stream:
                values = yaml.safe_load(stream)
            if "intrinsics" not in values:
                values = values[name]
            if "distortion_coefficients" in values:
                values["distortion_coeffs"] = values["distortion_coefficients"]
            return Camera.from_kalibr(values)
        except (KeyError, TypeError, ValueError, yaml.YAMLError) as error:
            raise ValueError(
                "%s: no camera can be read (%s); give a YAML file of Kalibr or EuRoC, or fx,fy,cx,cy"
                % (path, error)
            ) from error

    @staticmethod
    def write_npz(path, matches, selection):
        """Write the arrays that docs/matches.md lists."""
        matches = Matches(**matches)
        rows = np.flatnonzero(selection["mask"])
        columns = {
            name: values[rows]
            for name, values in (
                ("score", selection["score"]),
                ("group", selection["group"]),
                ("distance", matches.distance),
                ("index_left", matches.left_index),
            )
            if values is not None
        }
        arrays = selection_arrays(
            matches,
            columns,
            rows,
            image_size0=np.array(matches.left_size, np.int32),
            image_size1=np.array(matches.right_size, np.int32),
            **{name: selection[name] for name in ("model", "model_kind", "status", "image0", "image1")},
        )
        try:
            with open(path, "wb") as stream:  # numpy would add an ending
                np.savez_compressed(stream, **arrays)
        except OSError as error:
            raise OSError(
                "%s: cannot be written (%s); check that the folder exists, its permissions and the free space"
                % (path, error.strerror)
            ) from error


def main(words):
    """Run the program and return its exit code."""
    try:
        import cv2  # pylint: disable=import-outside-toplevel  # may be missing
    except ImportError as error:
        print(
            "%s: image files are read by OpenCV's module cv2, which cannot be loaded (%s); install it, on Debian by "
            "apt-get install python3-opencv" % (PROGRAM, error),
            file=sys.stderr,
        )
        return 2
    code, text, errors = _features.match_program(PROGRAM, words, Front(cv2))
    sys.stdout.write(text)
    sys.stderr.write(errors)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
