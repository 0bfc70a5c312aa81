#!/usr/bin/env python3
"""Camera against closed forms and OpenCV, and relative_pose() against known motions."""

import pickle
import types
import unittest

import corrsel
import numpy as np

PINHOLE = [[500, 0, 320], [0, 510, 240], [0, 0, 1]]
LENS = [[981.2178, 0, 690], [0, 975.8994, 247.1364], [0, 0, 1]]
RADTAN = [-0.3791375, 0.2148119, 0.001227094, 0.002343833, -0.07910379]
WIDE = [[400, 0, 639.5], [0, 400, 479.5], [0, 0, 1]]
BRANDT = [-0.02, 0.003, 0, 0]


def cameras():
    """Return a camera of every model."""
    return {
        "pinhole": corrsel.Camera("pinhole", LENS, RADTAN, (1392, 512)),
        "rational": corrsel.Camera(
            "pinhole", PINHOLE, [0.3, 0.1, 1e-3, -2e-3, 0.01, 0.4, 0.1, 0.01], (640, 480)
        ),
        "fisheye": corrsel.Camera("fisheye", WIDE, BRANDT, (1280, 960)),
        "equirectangular": corrsel.Camera("equirectangular", size=(2048, 1024)),
    }


def pixels_of(camera, count=200):
    """Return pixels all over the image of a camera."""
    return np.random.default_rng(0).uniform((0, 0), np.array(camera.size) - 1, (count, 2))


def rotation_of(vector):
    """Return exp([v]x), Rodrigues' formula."""
    vector = np.asarray(vector, np.float64)
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def vector_of(rotation):
    """Return the rotation vector of a rotation by less than 180 degrees."""
    angle = np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))
    axis = [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    return np.array(axis) * (0.5 if angle < 1e-9 else angle / (2 * np.sin(angle)))


class Scene:
    """Matches of two images of points at depths of 4 to 12, of which a share is wrong."""

    def __init__(self, camera, rotation, translation, count=400, right_share=0.7, noise=0.5, seed=0):
        random = np.random.default_rng(seed)
        size = np.array(camera.size)
        left = random.uniform((0, 0), size - 1, (4 * count, 2))
        depth = random.uniform(4, 12, (4 * count, 1))
        right = camera.project(depth * camera.unproject(left) @ rotation.T + translation)
        seen = np.isfinite(right).all(1) & (right > 0).all(1) & (right < size - 1).all(1)
        left, right = left[seen][:count], right[seen][:count]
        self.inlier = random.uniform(size=count) < right_share
        right[~self.inlier] = random.uniform((0, 0), size - 1, (count, 2))[~self.inlier]
        self.left = left + random.normal(0, noise, left.shape)
        self.right = right + random.normal(0, noise, right.shape)


class ClosedForms(unittest.TestCase):
    """Rays and pixels are those of the models' formulas."""

    def test_a_pinhole(self):
        camera = corrsel.Camera("pinhole", PINHOLE)
        pixels = np.array([[320.0, 240], [820, 240], [100, 400]])
        rays = np.column_stack([pixels, np.ones(3)]) @ np.linalg.inv(PINHOLE).T
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        np.testing.assert_allclose(camera.unproject(pixels), rays, atol=1e-15)
        np.testing.assert_allclose(camera.project(7 * rays), pixels, atol=1e-11)

    def test_an_equidistant_lens(self):
        camera = corrsel.Camera("fisheye", WIDE)
        angle, turn = np.radians([[0, 10, 60, 90, 120], [0, 30, 100, 200, 300]])
        rays = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], 1)
        pixels = 400 * angle[:, None] * np.stack([np.cos(turn), np.sin(turn)], 1) + [639.5, 479.5]
        np.testing.assert_allclose(camera.project(rays), pixels, atol=1e-10)
        np.testing.assert_allclose(camera.unproject(pixels), rays, atol=1e-12)

    def test_a_panorama(self):
        camera = corrsel.Camera("equirectangular", size=(2048, 1024))
        pixels = np.array([[1023.5, 511.5], [1535.5, 511.5], [511.5, 511.5], [1023.5, 255.5]])
        half = np.sqrt(0.5)
        rays = [[0, 0, 1], [1, 0, 0], [-1, 0, 0], [0, -half, half]]
        np.testing.assert_allclose(camera.unproject(pixels), rays, atol=1e-15)
        np.testing.assert_allclose(camera.project(rays), pixels, atol=1e-10)

    def test_known_rays_and_jacobians(self):
        for name, pixel, ray, jacobian in (
            (
                "pinhole",
                (100, 50),
                (-0.575473130637, -0.193575576442, 0.794581129980),
                (
                    (0.000890496421, -0.000027282021),
                    (-0.000026741011, 0.000969651257),
                    (0.000638424873, 0.000216467173),
                ),
            ),
            (
                "fisheye",
                (100, 100),
                (-0.810566848488, -0.570176309548, -0.133717463935),
                (
                    (0.000262508074, -0.000872204811),
                    (-0.000872204811, 0.000888906622),
                    (0.002127846058, 0.00149678884),
                ),
            ),
            (
                "equirectangular",
                (100, 200),
                (-0.175119720907, -0.816700572867, -0.549848395131),
                ((-0.001686913749, -0.000760371101), (0, 0.001770403039), (0.000537260575, -0.002387445727)),
            ),
        ):
            with self.subTest(camera=name):
                rays, jacobians = cameras()[name].unproject([pixel], jacobians=True)
                np.testing.assert_allclose(rays, [ray], atol=1e-12)
                np.testing.assert_allclose(jacobians, [jacobian], atol=1e-12)

    def test_pixels_return(self):
        for name, camera in cameras().items():
            with self.subTest(camera=name):
                pixels = pixels_of(camera)
                rays = camera.unproject(pixels)
                np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1, atol=1e-14)
                np.testing.assert_allclose(camera.project(3 * rays), pixels, atol=1e-7)

    def test_jacobians_are_the_derivatives(self):
        step = 1e-3
        for name, camera in cameras().items():
            pixels = pixels_of(camera, 50)
            rays, jacobians = camera.unproject(pixels, jacobians=True)
            self.assertEqual((rays.shape, jacobians.shape), ((50, 3), (50, 3, 2)))
            for column, offset in enumerate(([step, 0], [0, step])):
                change = camera.unproject(pixels + offset) - camera.unproject(pixels - offset)
                np.testing.assert_allclose(
                    jacobians[:, :, column], change / (2 * step), atol=1e-8, err_msg=name
                )

    def test_rays_of_a_distorted_lens_are_those_of_opencv(self):
        try:
            import cv2  # pylint: disable=import-outside-toplevel
        except ImportError as error:
            self.skipTest("%s; python3-opencv is needed" % error)
        criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-14)
        camera = cameras()["pinhole"]
        pixels = pixels_of(camera)
        flat = cv2.undistortPointsIter(
            pixels[:, None], camera.matrix, camera.distortion, None, None, criteria
        ).reshape(-1, 2)
        rays = camera.unproject(pixels)
        np.testing.assert_allclose(rays[:, :2] / rays[:, 2:], flat, atol=1e-9)
        camera = cameras()["fisheye"]
        pixels = np.random.default_rng(0).uniform((300, 200), (980, 760), (200, 2))
        rays = camera.unproject(pixels)
        flat = cv2.fisheye.undistortPoints(pixels[:, None], camera.matrix, camera.distortion).reshape(-1, 2)
        np.testing.assert_allclose(rays[:, :2] / rays[:, 2:], flat, atol=1e-7)

    def test_what_is_not_seen_is_nan(self):
        camera = cameras()["pinhole"]
        pixels = [[100, 50], [-900, 250], [np.nan, 50], [np.inf, 50]]
        rays, jacobians = camera.unproject(pixels, jacobians=True)
        np.testing.assert_array_equal(np.isnan(rays).all(1), [False, True, True, True])
        np.testing.assert_array_equal(np.isnan(jacobians).all((1, 2)), [False, True, True, True])
        self.assertFalse(np.isnan(rays[0]).any() or np.isnan(jacobians[0]).any())
        seen = camera.project([[0, 0, 1], [0, 0, -1], [0.1, 0, -1], [np.nan, 0, 1]])
        np.testing.assert_array_equal(np.isnan(seen).all(1), [False, True, True, True])

    def test_a_scaled_camera_sees_the_same(self):
        for name, camera in cameras().items():
            with self.subTest(camera=name):
                half = camera.scaled(0.5)
                self.assertEqual(half.size, (camera.size[0] // 2, camera.size[1] // 2))
                pixels = pixels_of(camera)
                np.testing.assert_allclose(
                    half.unproject(0.5 * (pixels + 0.5) - 0.5), camera.unproject(pixels), atol=1e-12
                )
        for factor in (0, -1, np.nan, np.inf):
            with self.assertRaisesRegex(ValueError, "factor"):
                cameras()["pinhole"].scaled(factor)


class Formats(unittest.TestCase):
    """Cameras as other programs describe them."""

    def test_opencv(self):
        camera = corrsel.Camera("pinhole", LENS, RADTAN, (1392, 512))
        size = (1392, 512)
        for distortion in (RADTAN, [RADTAN], np.reshape(RADTAN, (5, 1)), RADTAN + [0] * 7, RADTAN + [0] * 9):
            self.assertEqual(corrsel.Camera.from_opencv(np.array(LENS), distortion, size), camera)
        self.assertEqual(corrsel.Camera.from_opencv(PINHOLE), corrsel.Camera("pinhole", PINHOLE))
        fisheye = corrsel.Camera.from_opencv(WIDE, np.reshape(BRANDT, (4, 1)), (1280, 960), fisheye=True)
        self.assertEqual(fisheye, cameras()["fisheye"])
        with self.assertRaisesRegex(ValueError, "distortion.*thin prism|thin prism.*distortion"):
            corrsel.Camera.from_opencv(LENS, RADTAN + [0, 0, 0, 0.1, 0, 0, 0])
        with self.assertRaisesRegex(ValueError, "distortion"):
            corrsel.Camera.from_opencv(LENS, [0.1, 0.2, 0.3])
        with self.assertRaisesRegex(ValueError, "distortion"):
            corrsel.Camera.from_opencv(WIDE, RADTAN, fisheye=True)

    def test_camera_info(self):
        names = {"distortion_model": "plumb_bob", "width": 1392, "height": 512}
        flat = np.ravel(LENS).tolist()
        for info in (
            types.SimpleNamespace(K=tuple(flat), D=RADTAN, **names),
            types.SimpleNamespace(k=np.ravel(LENS), d=np.array(RADTAN), **names),
        ):
            self.assertEqual(corrsel.Camera.from_camera_info(info), cameras()["pinhole"])
        wide = types.SimpleNamespace(
            K=np.ravel(WIDE).tolist(), D=BRANDT, distortion_model="equidistant", width=1280, height=960
        )
        self.assertEqual(corrsel.Camera.from_camera_info(wide), cameras()["fisheye"])
        rational = cameras()["rational"]
        info = types.SimpleNamespace(
            K=np.ravel(PINHOLE),
            D=rational.distortion,
            distortion_model="rational_polynomial",
            width=640,
            height=480,
        )
        self.assertEqual(corrsel.Camera.from_camera_info(info), rational)

    def test_camera_info_that_is_not_calibrated(self):
        info = types.SimpleNamespace(K=[0.0] * 9, D=[], distortion_model="plumb_bob", width=640, height=480)
        with self.assertRaisesRegex(ValueError, "^matrix = .*0 0 0.* positive fx"):
            corrsel.Camera.from_camera_info(info)
        info.K = np.ravel(PINHOLE)
        info.distortion_model = "thirdorder"
        with self.assertRaisesRegex(ValueError, "thirdorder.*plumb_bob"):
            corrsel.Camera.from_camera_info(info)
        with self.assertRaisesRegex(ValueError, "K .*CameraInfo"):
            corrsel.Camera.from_camera_info(
                types.SimpleNamespace(width=1, height=1, distortion_model="plumb_bob")
            )

    def test_colmap(self):
        for model, params, camera in (
            (
                "SIMPLE_PINHOLE",
                [500, 320.5, 240.5],
                ("pinhole", [[500, 0, 320], [0, 500, 240], [0, 0, 1]], []),
            ),
            ("PINHOLE", [500, 510, 320.5, 240.5], ("pinhole", PINHOLE, [])),
            (
                "OPENCV",
                [500, 510, 320.5, 240.5, 0.1, 0.2, 3e-3, 4e-3],
                ("pinhole", PINHOLE, [0.1, 0.2, 3e-3, 4e-3]),
            ),
            ("OPENCV_FISHEYE", [500, 510, 320.5, 240.5] + BRANDT, ("fisheye", PINHOLE, BRANDT)),
        ):
            with self.subTest(model=model):
                read = corrsel.Camera.from_colmap(model, 640, 480, params)
                self.assertEqual(read, corrsel.Camera(*camera, size=(640, 480)))
        with self.assertRaisesRegex(ValueError, "FOV.*OPENCV_FISHEYE"):
            corrsel.Camera.from_colmap("FOV", 640, 480, [500, 510, 320.5, 240.5, 0.1])
        with self.assertRaisesRegex(ValueError, "PINHOLE has 3 numbers; valid: 4"):
            corrsel.Camera.from_colmap("PINHOLE", 640, 480, [500, 320.5, 240.5])

    def test_kalibr(self):
        chain = {
            "cam0": {
                "camera_model": "pinhole",
                "intrinsics": [400, 400, 639.5, 479.5],
                "distortion_model": "equidistant",
                "distortion_coeffs": BRANDT,
                "resolution": [1280, 960],
                "rostopic": "/cam0/image_raw",
            }
        }
        self.assertEqual(corrsel.Camera.from_kalibr(chain["cam0"]), cameras()["fisheye"])
        radtan = dict(chain["cam0"], distortion_model="radtan", distortion_coeffs=[0.1, 0.2, 3e-3, 4e-3])
        expected = corrsel.Camera("pinhole", WIDE, [0.1, 0.2, 3e-3, 4e-3], (1280, 960))
        self.assertEqual(corrsel.Camera.from_kalibr(radtan), expected)
        with self.assertRaisesRegex(ValueError, "no camera_model.*only cam0.*chain"):
            corrsel.Camera.from_kalibr(chain)
        with self.assertRaisesRegex(ValueError, "omni"):
            corrsel.Camera.from_kalibr(dict(chain["cam0"], camera_model="omni"))
        with self.assertRaisesRegex(ValueError, "fov"):
            corrsel.Camera.from_kalibr(dict(chain["cam0"], distortion_model="fov"))


class Values(unittest.TestCase):
    """Cameras as values, and what is wrong with arguments."""

    def test_members(self):
        camera = corrsel.Camera("pinhole", PINHOLE, RADTAN[:4], [640, 480])
        self.assertEqual((camera.model, camera.size), ("pinhole", (640, 480)))
        np.testing.assert_array_equal(camera.matrix, PINHOLE)
        np.testing.assert_array_equal(camera.distortion, RADTAN[:4] + [0] * 4)
        self.assertEqual(len(corrsel.Camera("fisheye", WIDE).distortion), 4)
        panorama = cameras()["equirectangular"]
        self.assertIsNone(panorama.matrix)
        self.assertEqual(len(panorama.distortion), 0)
        self.assertIsNone(corrsel.Camera("fisheye", WIDE).size)
        self.assertIn("pinhole, fx=500 fy=510 cx=320 cy=240, distortion=[-0.379", repr(camera))
        self.assertEqual(repr(panorama), "<corrsel.Camera: equirectangular, 2048x1024>")

    def test_cameras_are_values(self):
        for camera in cameras().values():
            again = pickle.loads(pickle.dumps(camera))
            self.assertEqual(again, camera)
            self.assertEqual(hash(again), hash(camera))
            self.assertNotEqual(camera, camera.scaled(2))
        camera = cameras()["pinhole"]
        self.assertNotEqual(camera, "pinhole")
        with self.assertRaisesRegex(AttributeError, "cannot be replaced"):
            camera.size = None
        with self.assertRaisesRegex(ValueError, "read-only"):
            camera.matrix[0, 0] = 1
        matrix = np.array(PINHOLE, np.float64)
        camera = corrsel.Camera("pinhole", matrix)
        matrix[0, 0] = 1
        self.assertEqual(camera.matrix[0, 0], 500)

    def test_errors_name_member_value_and_remedy(self):
        eye = np.eye(3)
        for arguments, text in (
            (("pinhol", PINHOLE), "pinhol.*pinhole, fisheye, equirectangular"),
            (("pinhole",), "matrix is missing; needed: the 3 x 3"),
            (("pinhole", [[1, 0], [0, 1]]), r"matrix has shape \(2, 2\); needed: \(3, 3\)"),
            (("pinhole", -eye), "matrix"),
            (("pinhole", eye * np.nan), "matrix"),
            (("fisheye", eye + np.eye(3, k=-1)), "matrix"),
            (
                ("pinhole", PINHOLE, [0.1, 0.2, 0.3]),
                "distortion has 3 numbers; needed: 0, 4, 5 or 8 of a pinhole",
            ),
            (("fisheye", WIDE, RADTAN), "distortion has 5 numbers; needed: 0 or 4 of a fisheye"),
            (("fisheye", WIDE, [np.inf, 0, 0, 0]), "distortion.*finite|not finite.*distortion"),
            (("pinhole", PINHOLE, [[0.1, 0, 0, 0]]), r"distortion has shape \(1, 4\); needed: \(N,\)"),
            (("equirectangular", PINHOLE, (), (20, 10)), "matrix is given"),
            (("equirectangular", None, [0.1, 0, 0, 0], (20, 10)), "distortion has 4 numbers; needed: 0"),
            (("equirectangular",), "size"),
            (("pinhole", PINHOLE, (), (640, 480, 3)), r"size is \(640, 480, 3\); needed: \(width, height\)"),
        ):
            with self.subTest(arguments=arguments), self.assertRaisesRegex(ValueError, text):
                corrsel.Camera(*arguments)
        with self.assertRaisesRegex(TypeError, "matrix has dtype <U1; needed: real numbers"):
            corrsel.Camera("pinhole", "K")
        with self.assertRaisesRegex(ValueError, r"points has shape \(4, 3\); needed: \(N, 2\)"):
            cameras()["pinhole"].unproject(np.zeros((4, 3)))
        with self.assertRaisesRegex(ValueError, r"points has shape \(2,\); needed: \(N, 3\)"):
            cameras()["pinhole"].project([1, 2])

    def test_no_points(self):
        for camera in cameras().values():
            self.assertEqual(camera.unproject(np.zeros((0, 2))).shape, (0, 3))
            self.assertEqual(camera.project(np.zeros((0, 3))).shape, (0, 2))


class RelativePose(unittest.TestCase):
    """The motion between two images."""

    rotation, translation = rotation_of([0.1, -0.15, 0.05]), np.array([1.2, 0.3, -0.5])

    def normalised_error(self, pose):
        """Return e^T C^-1 e with the error in the covariance's own parameters: 5 in the mean."""
        true = self.translation / np.linalg.norm(self.translation)
        turn = vector_of(self.rotation @ pose.rotation.T)
        error = np.concatenate([turn, pose.basis @ true / (pose.translation @ true)])
        return error @ np.linalg.solve(pose.covariance, error)

    def test_known_motions(self):
        for name, camera in cameras().items():
            with self.subTest(camera=name):
                scene = Scene(camera, self.rotation, self.translation)
                pose = corrsel.relative_pose(scene.left, scene.right, camera, camera, seed=1)
                self.assertEqual(
                    (pose.status, pose.motion, pose.uncertain), ("ok", "general", False), pose.message
                )
                errors = corrsel.pose_errors(pose.rotation, pose.translation, self.rotation, self.translation)
                self.assertLess(errors.rotation, 0.5)
                self.assertLess(errors.translation, 2)
                self.assertTrue(np.isfinite(pose.covariance).all())
                np.testing.assert_array_equal(pose.covariance, pose.covariance.T)
                self.assertGreater(np.linalg.eigvalsh(pose.covariance)[0], 0)
                self.assertLess(self.normalised_error(pose), 20.5)  # exceeded by one in a thousand
                self.assertTrue(0.4 < pose.noise < 0.6, pose.noise)
                self.assertGreater(pose.parallax, 10)
                self.assertGreater(pose.mask[scene.inlier].mean(), 0.7)
                self.assertLess(pose.mask[~scene.inlier].mean(), 0.1)
                self.assertIsNone(pose.second)

    def test_it_is_the_selector_pose(self):
        camera = cameras()["fisheye"]
        scene = Scene(camera, self.rotation, self.translation)
        pose = corrsel.relative_pose(scene.left, scene.right, camera, camera, threshold=2, seed=3)
        matches = corrsel.Matches(scene.left, scene.right).with_cameras(camera, camera)
        selection = matches.select("pose", threshold=2, seed=3)
        self.assertEqual(selection.model_kind, "essential")
        np.testing.assert_array_equal(selection.mask, pose.mask)
        for name in ("rotation", "translation", "basis", "covariance"):
            np.testing.assert_array_equal(getattr(selection.pose, name), getattr(pose, name))
        self.assertIn("general, rotation by", repr(selection.pose))
        rays = [camera.unproject(side[selection.mask]) for side in (matches.left, matches.right)]
        self.assertLess(np.abs(np.einsum("ni,ij,nj->n", rays[1], selection.model, rays[0])).max(), 0.02)

    def test_two_different_cameras(self):
        left, right = cameras()["fisheye"], cameras()["equirectangular"]
        random = np.random.default_rng(5)
        points = random.uniform((-5, -4, 2), (5, 4, 9), (300, 3))
        seen = left.project(points), right.project(points @ self.rotation.T + self.translation)
        pose = corrsel.relative_pose(
            *(side + random.normal(0, 0.5, side.shape) for side in seen), left, right
        )
        self.assertEqual(pose.motion, "general")
        self.assertLess(
            corrsel.pose_errors(pose.rotation, pose.translation, self.rotation, self.translation).pose, 1
        )

    def test_the_basis_is_orthonormal(self):
        camera = cameras()["pinhole"]
        scene = Scene(camera, self.rotation, self.translation)
        pose = corrsel.relative_pose(scene.left, scene.right, camera, camera)
        axes = np.vstack([pose.translation, pose.basis])
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)

    def test_a_camera_that_only_turns_has_no_translation(self):
        camera = cameras()["fisheye"]
        scene = Scene(camera, self.rotation, np.zeros(3))
        pose = corrsel.relative_pose(scene.left, scene.right, camera, camera)
        self.assertEqual(pose.motion, "rotation")
        self.assertLess(np.degrees(np.linalg.norm(vector_of(pose.rotation @ self.rotation.T))), 0.2)
        np.testing.assert_array_equal(pose.translation, np.zeros(3))
        self.assertIsNone(pose.basis)
        self.assertTrue(np.isfinite(pose.covariance[:3, :3]).all())
        self.assertTrue(np.isnan(pose.covariance[3:]).all() and np.isnan(pose.covariance[:, 3:]).all())

    def test_a_plane_has_two_poses(self):
        camera = cameras()["fisheye"]
        random = np.random.default_rng(2)
        points = np.column_stack([random.uniform((-6, -4), (6, 4), (400, 2)), np.full(400, 6.0)])
        points[:, 2] += 0.3 * points[:, 0]
        seen = camera.project(points), camera.project(points @ self.rotation.T + self.translation)
        pose = corrsel.relative_pose(
            *(side + random.normal(0, 0.5, side.shape) for side in seen), camera, camera
        )
        self.assertEqual(pose.motion, "planar")
        poses = [(pose.rotation, pose.translation)] + [pose.second] * (pose.second is not None)
        errors = [corrsel.pose_errors(*each, self.rotation, self.translation).pose for each in poses]
        self.assertLess(min(errors), 2)

    def test_without_an_answer_there_is_no_motion(self):
        camera = cameras()["pinhole"]
        random = np.random.default_rng(0)
        for left, right in (
            (np.zeros((0, 2)), np.zeros((0, 2))),
            (np.zeros((3, 2)), np.ones((3, 2))),
            (np.full((50, 2), 100.0), random.uniform(0, 400, (50, 2))),
        ):
            pose = corrsel.relative_pose(left, right, camera, camera)
            self.assertNotEqual(pose.status, "ok")
            self.assertTrue(pose.message)
            self.assertEqual(pose.motion, "none")
            np.testing.assert_array_equal(pose.rotation, np.eye(3))
            np.testing.assert_array_equal(pose.translation, np.zeros(3))
            self.assertTrue(np.isnan(pose.covariance).all())
            self.assertEqual(pose.mask.tolist(), [False] * len(left))

    def test_points_without_a_ray_are_ignored(self):
        camera = cameras()["pinhole"]
        scene = Scene(camera, self.rotation, self.translation)
        left = np.vstack([[[-900, 250], [np.nan, 0]], scene.left])
        right = np.vstack([scene.right[:2], scene.right])
        matches = corrsel.Matches(left, right, left_camera=camera, right_camera=camera)
        selection = matches.select("pose", seed=1)
        self.assertEqual((selection.n_ignored, selection.mask[:2].tolist()), (2, [False, False]))
        self.assertEqual(selection.pose.motion, "general")
        alone = corrsel.relative_pose(scene.left, scene.right, camera, camera, seed=1)
        np.testing.assert_array_equal(selection.mask[2:], alone.mask)

    def test_a_missing_camera(self):
        camera = cameras()["pinhole"]
        left, right = np.random.default_rng(0).uniform(0, 400, (2, 50, 2))
        with self.assertRaisesRegex(TypeError, "camera_left is NoneType; needed: corrsel.Camera"):
            corrsel.relative_pose(left, right, None, camera)
        with self.assertRaisesRegex(TypeError, "camera_right is list; needed: corrsel.Camera"):
            corrsel.relative_pose(left, right, camera, PINHOLE)
        with self.assertRaisesRegex(TypeError, "left_camera is ndarray; needed: corrsel.Camera"):
            corrsel.Matches(left, right, left_camera=np.eye(3))
        for given in ({}, {"left_camera": camera}, {"right_camera": camera}):
            selection = corrsel.select(left, right, "pose", **given)
            self.assertEqual(selection.status, "unsupported_input")
            self.assertIn("camera", selection.message)
            self.assertIsNone(selection.pose)

    def test_wrong_shapes(self):
        camera = cameras()["pinhole"]
        left, right = np.random.default_rng(0).uniform(0, 400, (2, 50, 2))
        with self.assertRaisesRegex(ValueError, "right has 49 rows; needed: 50"):
            corrsel.relative_pose(left, right[1:], camera, camera)
        with self.assertRaisesRegex(ValueError, r"left has shape \(2, 50\)"):
            corrsel.relative_pose(left.T, right.T, camera, camera)
        with self.assertRaisesRegex(ValueError, "distance has 3 rows; needed: 50"):
            corrsel.relative_pose(left, right, camera, camera, distance=[0.1, 0.2, 0.3])
        with self.assertRaisesRegex(ValueError, "threshold"):
            corrsel.relative_pose(left, right, camera, camera, threshold=-1)

    def test_other_selectors_return_no_pose(self):
        left, right = np.random.default_rng(0).uniform(0, 400, (2, 50, 2))
        self.assertIsNone(corrsel.select(left, right, "usac").pose)

    def test_matches_keep_their_cameras(self):
        camera, other = cameras()["pinhole"], cameras()["fisheye"]
        matches = corrsel.Matches(*np.zeros((2, 5, 2)), left_camera=camera, right_camera=other)
        for kept in (matches[1:3], pickle.loads(pickle.dumps(matches)), matches):
            self.assertEqual((kept.left_camera, kept.right_camera), (camera, other))
        self.assertIn("with left_camera, right_camera, ", repr(matches))
        swapped = matches.with_cameras(other, None)
        self.assertEqual((swapped.left_camera, swapped.right_camera), (other, None))
        self.assertTrue(np.shares_memory(swapped.left, matches.left))


class Priors(unittest.TestCase):
    """Motions that are known in part."""

    rotation, translation = RelativePose.rotation, RelativePose.translation
    down = np.array([0.1, 0.9, -0.2])

    def setUp(self):
        self.camera = cameras()["fisheye"]
        self.scene = Scene(self.camera, self.rotation, self.translation, right_share=0.4)

    def pose(self, **known):
        return corrsel.relative_pose(self.scene.left, self.scene.right, self.camera, self.camera, **known)

    def check(self, pose):
        self.assertEqual((pose.status, pose.motion), ("ok", "general"), pose.message)
        errors = corrsel.pose_errors(pose.rotation, pose.translation, self.rotation, self.translation)
        self.assertLess(errors.pose, 2)

    def test_a_known_rotation(self):
        pose = self.pose(rotation=self.rotation)
        self.check(pose)
        np.testing.assert_array_equal(pose.rotation, self.rotation)
        np.testing.assert_array_equal(pose.covariance[:3], np.zeros((3, 5)))
        self.assertGreater(np.linalg.eigvalsh(pose.covariance[3:, 3:])[0], 0)

    def test_a_known_vertical(self):
        right = self.rotation @ self.down
        pose = self.pose(vertical=(9.81 * self.down, right))
        self.check(pose)
        np.testing.assert_allclose(pose.rotation @ self.down, right, atol=1e-12)
        axis = right / np.linalg.norm(right)
        turns = pose.covariance[:3, :3]
        np.testing.assert_allclose(turns, (axis @ turns @ axis) * np.outer(axis, axis), atol=1e-15)
        self.assertGreater(axis @ turns @ axis, 1e-10)

    def test_a_known_rig(self):
        pose = self.pose(rig=(self.rotation, self.translation))
        self.check(pose)
        np.testing.assert_array_equal(pose.rotation, self.rotation)
        np.testing.assert_allclose(
            pose.translation, self.translation / np.linalg.norm(self.translation), atol=1e-15
        )
        np.testing.assert_array_equal(pose.covariance, np.zeros((5, 5)))
        self.assertGreater(pose.mask[self.scene.inlier].mean(), 0.7)
        self.assertLess(pose.mask[~self.scene.inlier].mean(), 0.1)

    def test_it_belongs_to_the_matches(self):
        prior = corrsel.PosePrior(rotation=self.rotation)
        matches = corrsel.Matches(self.scene.left, self.scene.right, prior=prior)
        matches = matches.with_cameras(self.camera, self.camera)
        for kept in (matches, matches[:], pickle.loads(pickle.dumps(matches))):
            self.assertEqual(kept.prior, prior)
            selection = kept.select("pose")
            np.testing.assert_array_equal(
                selection.pose.translation, self.pose(rotation=self.rotation).translation
            )
        self.assertIn("prior", repr(matches))

    def test_priors_are_values(self):
        priors = [
            corrsel.PosePrior(rotation=self.rotation),
            corrsel.PosePrior(vertical=(self.down, self.rotation @ self.down)),
            corrsel.PosePrior(rig=(self.rotation, self.translation)),
        ]
        for prior, kind in zip(priors, ("rotation", "vertical", "rig")):
            again = pickle.loads(pickle.dumps(prior))
            self.assertEqual((again, hash(again)), (prior, hash(prior)))
            self.assertEqual(repr(prior), "<corrsel.PosePrior: %s>" % kind)
        self.assertEqual(len(set(priors)), 3)
        self.assertNotEqual(priors[0], self.rotation.tolist())
        np.testing.assert_allclose(np.linalg.norm(priors[1].vertical, axis=1), 1, atol=1e-15)
        with self.assertRaisesRegex(AttributeError, "cannot be replaced"):
            priors[0].rotation = None
        with self.assertRaisesRegex(ValueError, "read-only"):
            priors[0].rotation[0, 0] = 1

    def test_errors_name_the_argument(self):
        eye, down = np.eye(3), [0, 1, 0]
        for known, text in (
            ({"rotation": eye, "rig": (eye, down)}, "rotation and rig are given; needed: exactly one"),
            ({"rotation": 1.01 * eye}, "rotation = .* is not a rotation"),
            ({"rotation": eye[:2]}, r"rotation has shape \(2, 3\)"),
            ({"vertical": down}, r"vertical is \[0, 1, 0\]; needed: \(down_left, down_right\)"),
            ({"vertical": (down, [0, 0, 0])}, r"vertical\[1\] is \[0.0, 0.0, 0.0\]; needed"),
            ({"vertical": (down, [0, np.nan, 0])}, r"vertical\[1\] is .*nan.*finite"),
            ({"rig": eye}, "(?s)rig is .*needed: .rotation, translation"),
            ({"rig": (-eye, down)}, "rotation = .* is not a rotation"),
            ({"rig": (eye, [0, 0, 0])}, r"rig\[1\] is \[0.0, 0.0, 0.0\]"),
        ):
            with self.subTest(known=known), self.assertRaisesRegex(ValueError, text):
                self.pose(**known)
        with self.assertRaisesRegex(ValueError, "nothing is given; needed: exactly one"):
            corrsel.PosePrior()
        with self.assertRaisesRegex(TypeError, "rotation has dtype"):
            corrsel.PosePrior(rotation="R")
        with self.assertRaisesRegex(TypeError, "prior is ndarray; needed: corrsel.PosePrior"):
            corrsel.Matches(self.scene.left, self.scene.right, prior=eye)


class Guesses(unittest.TestCase):
    """Motions that are believed."""

    rotation, translation = RelativePose.rotation, RelativePose.translation

    def setUp(self):
        self.camera = cameras()["fisheye"]
        self.scene = Scene(self.camera, self.rotation, self.translation)

    def matches(self, guess=None):
        return corrsel.Matches(
            self.scene.left,
            self.scene.right,
            left_camera=self.camera,
            right_camera=self.camera,
            guess=guess,
        )

    def test_it_is_confirmed_or_contradicted(self):
        near = rotation_of([0.002, -0.001, 0]) @ self.rotation
        far = rotation_of([0, 0.3, 0]) @ self.rotation
        without = self.matches().select("pose")
        self.assertEqual((without.status, without.guess), ("ok", "none"))
        for rotation, verdict in ((near, "confirmed"), (far, "contradicted")):
            guess = corrsel.MotionGuess(rotation, translation=self.translation, rotation_sigma=0.003)
            matches = self.matches(guess)
            for name in ("pose", "auto"):
                with self.subTest(selector=name, verdict=verdict):
                    selection = matches.select(name)
                    self.assertEqual((selection.status, selection.guess), ("ok", verdict))
                    errors = corrsel.pose_errors(
                        selection.pose.rotation, selection.pose.translation, self.rotation, self.translation
                    )
                    self.assertLess(errors.pose, 2)
                    corrsel.add_probability(matches, selection)
                    corrsel.label_motion(matches, selection)
                    self.assertEqual(selection.guess, verdict)
            self.assertEqual(matches.select("ransac").guess, "none")
        np.testing.assert_array_equal(selection.mask, self.matches().select("auto").mask)

    def test_its_uncertainty_counts(self):
        far = rotation_of([0, 0.05, 0]) @ self.rotation
        for sigma, verdict in ((0.001, "contradicted"), (0.05, "confirmed")):
            selection = self.matches(corrsel.MotionGuess(far, rotation_sigma=sigma)).select("pose")
            self.assertEqual(selection.guess, verdict)

    def test_it_belongs_to_the_matches(self):
        guess = corrsel.MotionGuess(self.rotation)
        matches = self.matches(guess)
        for kept in (matches[3:], pickle.loads(pickle.dumps(matches)), matches.with_cameras(None, None)):
            self.assertEqual(kept.guess, guess)
        self.assertIn("guess", repr(matches))
        self.assertIsNone(self.matches().guess)

    def test_guesses_are_values(self):
        guesses = [
            corrsel.MotionGuess(self.rotation),
            corrsel.MotionGuess(np.eye(3)),
            corrsel.MotionGuess(self.rotation, translation=self.translation),
            corrsel.MotionGuess(self.rotation, rotation_sigma=np.float32(0.25)),
        ]
        for guess in guesses:
            again = pickle.loads(pickle.dumps(guess))
            self.assertEqual((again, hash(again)), (guess, hash(guess)))
        self.assertEqual(len(set(guesses)), 4)
        self.assertNotEqual(guesses[0], corrsel.PosePrior(rotation=self.rotation))
        self.assertEqual((guesses[0].translation, guesses[0].rotation_sigma), (None, 0))
        self.assertEqual((type(guesses[3].rotation_sigma), guesses[3].rotation_sigma), (float, 0.25))
        np.testing.assert_allclose(
            guesses[2].translation, self.translation / np.linalg.norm(self.translation), atol=1e-15
        )
        guess = corrsel.MotionGuess(rotation_of([0, 0.5, 0]), translation=[0, 0, 2], rotation_sigma=0.01)
        self.assertEqual(
            repr(guess),
            "<corrsel.MotionGuess: rotation by 28.6 degrees, translation [0.000, 0.000, 1.000], "
            "rotation_sigma 0.01 rad>",
        )
        with self.assertRaisesRegex(AttributeError, "attributes of MotionGuess cannot be replaced"):
            guess.rotation_sigma = 1
        with self.assertRaisesRegex(ValueError, "read-only"):
            guess.translation[0] = 1

    def test_errors_name_the_argument(self):
        eye = np.eye(3)
        for arguments, error, text in (
            ({"rotation": 1.01 * eye}, ValueError, "rotation = .* is not a rotation"),
            ({"rotation": eye[:2]}, ValueError, r"rotation has shape \(2, 3\)"),
            ({"rotation": np.nan * eye}, ValueError, "rotation holds a number that is not finite"),
            ({"rotation": "R"}, TypeError, "rotation has dtype"),
            ({"translation": [0, 0, 0]}, ValueError, r"translation is \[0.0, 0.0, 0.0\]; needed"),
            ({"translation": [0, 1]}, ValueError, r"translation has shape \(2,\)"),
            ({"rotation_sigma": -0.1}, ValueError, "rotation_sigma = -0.1 rad must be"),
            ({"rotation_sigma": np.nan}, ValueError, "rotation_sigma = nan rad must be"),
            ({"rotation_sigma": [0.1, 0.2]}, ValueError, r"rotation_sigma has shape \(2,\)"),
            ({"rotation_sigma": None}, TypeError, "rotation_sigma has dtype object"),
        ):
            with self.subTest(arguments=arguments), self.assertRaisesRegex(error, text):
                corrsel.MotionGuess(**dict({"rotation": eye}, **arguments))
        with self.assertRaisesRegex(TypeError, "guess is ndarray; needed: corrsel.MotionGuess"):
            self.matches(eye)


if __name__ == "__main__":
    unittest.main()
