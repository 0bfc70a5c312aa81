"""Calibrated cameras: pixels to rays and back."""

import numpy as np

from . import _arrays, _core

#: Numbers of coefficients that a model takes; fewer than the most are completed by zeros.
_COEFFICIENTS = {"pinhole": (0, 4, 5, 8), "fisheye": (0, 4), "equirectangular": (0,)}
_A_MODEL = {"pinhole": "a pinhole", "fisheye": "a fisheye lens", "equirectangular": "a panorama"}
#: What Camera.from_kalibr() reads of a camera.
_KALIBR = ("camera_model", "intrinsics", "distortion_model", "distortion_coeffs", "resolution")


class Camera:
    """A calibrated camera: how points in front of it (x to the right, y down, z forward) are imaged.

    Images need not be rectified: give the camera of the image as it is.

    model        "pinhole", with OpenCV's radial and tangential distortion or its rational model; "fisheye", the
                 model of Kannala and Brandt ("equidistant" in ROS and Kalibr); or "equirectangular", a panorama of 360
                 by 180 degrees that fills the image
    matrix       [[fx, s, cx], [0, fy, cy], [0, 0, 1]], px, with the origin at the centre of the first pixel: 3 x 3;
                 None for a panorama
    distortion   of a pinhole k1, k2, p1, p2, k3, k4, k5, k6, of which 0, 4, 5 or 8 may be given; of a fisheye lens k1,
                 k2, k3, k4, or none. The attribute has all 8 or 4, none for a panorama
    size         (width, height) of the images, px, or None where unknown; a panorama needs it

    from_opencv(), from_camera_info(), from_colmap() and from_kalibr() read what other programs have. Attributes cannot
    be replaced, and the arrays cannot be written to. Cameras with equal parameters are equal.

    Raises ValueError that names the member, its value and what is valid; TypeError for what is not made of numbers.
    """

    __slots__ = ("model", "matrix", "distortion", "size")

    def __init__(self, model, matrix=None, distortion=(), size=None):
        model = str(model)
        values = {
            "model": model,
            "matrix": None if matrix is None else _arrays.reals("matrix", matrix, (3, 3)),
            "distortion": _coefficients(model, distortion),
            "size": _arrays.size("size", size),
        }
        if model == "equirectangular":
            if matrix is not None:
                raise ValueError("matrix is given, but an equirectangular camera has none; leave it out")
        elif matrix is None:
            raise ValueError("matrix is missing; needed: the 3 x 3 camera matrix of a %s camera, px" % model)
        self._set(values)
        self._set(_core.checked_camera(self))

    def _set(self, values):
        for name, value in values.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(self, name, value)

    @classmethod
    def from_opencv(cls, matrix, distortion=None, size=None, *, fisheye=False):
        """Return the camera with the matrix and the coefficients of OpenCV's calibration.

        matrix       3 x 3, px
        distortion   None, or what cv2.calibrateCamera returns, of any shape: 4, 5, 8, 12 or 14 numbers, of which those
                     after the eighth (thin prism, tilted sensor) must be zero; with fisheye, the 4 numbers of
                     cv2.fisheye.calibrate
        size         (width, height), px, or None
        fisheye      whether the coefficients are those of cv2.fisheye
        """
        return cls(
            **_core.camera_from_opencv(
                _arrays.reals("matrix", matrix, (3, 3)),
                _vector("distortion", () if distortion is None else np.ravel(distortion)),
                _arrays.size("size", size),
                bool(fisheye),
            )
        )

    @classmethod
    def from_camera_info(cls, info):
        """Return the camera of the raw images of a sensor_msgs/CameraInfo, of ROS 1 or ROS 2.

        info   any object with K or k, D or d, distortion_model, width and height; ROS is not needed. The distortion
               models are plumb_bob, rational_polynomial and equidistant

        Binning and region of interest are left aside: it is the camera of the whole image. That of an image with
        binning 2 x 2 is Camera.from_camera_info(info).scaled(0.5).
        """
        return cls(
            **_core.camera_from_info(
                str(_member(info, "distortion_model")),
                _arrays.reals("K", np.ravel(_member(info, "K", "k")), (9,)).reshape(3, 3),
                _vector("D", _member(info, "D", "d")),
                _arrays.size("size", (_member(info, "width"), _member(info, "height"))),
            )
        )

    @classmethod
    def from_colmap(cls, model, width, height, params):
        """Return the camera of a model of COLMAP, whose pixels have their centres at (0.5, 0.5).

        model           e.g. "OPENCV" or "OPENCV_FISHEYE"; the error for another one lists those that can be read
        width, height   px
        params          in COLMAP's order
        """
        return cls(
            **_core.camera_from_colmap(
                str(model), _arrays.size("size", (width, height)), _vector("params", params)
            )
        )

    @classmethod
    def from_kalibr(cls, camera):
        """Return the camera of a camchain file of Kalibr.

        camera   a dictionary with camera_model, intrinsics, distortion_model, distortion_coeffs and resolution:
                 yaml.safe_load(open("camchain.yaml"))["cam0"]
        """
        missing = [name for name in _KALIBR if name not in camera]
        if missing:
            raise ValueError(
                "the camera has no %s, only %s; give one camera of the file, e.g. chain['cam0']"
                % (" and no ".join(missing), ", ".join(map(str, camera)) or "nothing")
            )
        return cls(
            **_core.camera_from_kalibr(
                str(camera["camera_model"]),
                _vector("intrinsics", camera["intrinsics"]),
                str(camera["distortion_model"]),
                _vector("distortion_coeffs", camera["distortion_coeffs"]),
                _arrays.size("resolution", camera["resolution"]),
            )
        )

    def scaled(self, factor):
        """Return the camera of the image after it was scaled by a factor above 0, as cv2.resize does: u' = factor
        (u + 0.5) - 0.5."""
        return Camera(**_core.scaled_camera(self, float(factor)))

    def unproject(self, points, *, jacobians=False):
        """Return the unit rays of pixels, N x 3: where the points lie that are seen there. O(N).

        points      (x, y), px: N x 2
        jacobians   True returns a pair: the rays, and their derivatives by the pixel's coordinates, 1/px: N x 3 x 2

        Rows are nan where the model has no ray, for example beyond the turning point of a distortion polynomial, and
        for coordinates that are not finite. A ray of a fisheye lens or of a panorama may point backwards.
        """
        rays, derivatives = _core.unproject(self, _arrays.reals("points", points, (None, 2)), jacobians)
        return (rays, derivatives) if jacobians else rays

    def project(self, points):
        """Return the pixels (x, y) in which points (x, y, z) in the camera's frame are seen: N x 2. O(N).

        points   in any unit: N x 3

        Rows are nan where a point is not seen: behind a pinhole, or beyond the turning point of the distortion. Pixels
        may lie outside the image.
        """
        return _core.project(self, _arrays.reals("points", points, (None, 3)))

    def __setattr__(self, name, value):
        raise AttributeError("attributes of Camera cannot be replaced; make a new Camera")

    def __eq__(self, other):
        if not isinstance(other, Camera):
            return NotImplemented
        return _values(self) == _values(other)

    def __hash__(self):
        return hash(_values(self))

    def __reduce__(self):
        return Camera, (self.model, self.matrix, self.distortion, self.size)

    def __repr__(self):
        parts = [self.model]
        if self.matrix is not None:
            parts.append("fx=%.6g fy=%.6g cx=%.6g cy=%.6g" % tuple(self.matrix[[0, 1, 0, 1], [0, 1, 2, 2]]))
        if self.distortion.any():
            parts.append("distortion=%s" % np.trim_zeros(self.distortion, "b").tolist())
        if self.size is not None:
            parts.append("%dx%d" % self.size)
        return "<corrsel.Camera: %s>" % ", ".join(parts)


def _coefficients(model, values):
    array = _vector("distortion", values)
    lengths = _COEFFICIENTS.get(model, (len(array),))  # the error for an unknown model is C++'s
    if len(array) not in lengths:
        raise ValueError(
            "distortion has %d numbers; needed: %s of %s"
            % (len(array), " or ".join(", ".join(map(str, lengths)).rsplit(", ", 1)), _A_MODEL[model])
        )
    return array


def _vector(name, values):
    return _arrays.reals(name, values, (None,), "a list of numbers")


def _member(info, *names):
    """Return the first of some attributes."""
    for name in names:
        if hasattr(info, name):
            return getattr(info, name)
    raise ValueError(
        "info is %s without %s; needed: a sensor_msgs/CameraInfo, or an object with its members"
        % (type(info).__name__, " and ".join(names))
    )


def _values(camera):
    """Return all parameters as a value that can be compared and hashed."""
    matrix = None if camera.matrix is None else tuple(camera.matrix.ravel().tolist())
    return camera.model, matrix, tuple(camera.distortion.tolist()), camera.size
