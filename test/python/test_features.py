#!/usr/bin/env python3
"""Extraction and matching: the results of C++, arguments of every kind, features of another source."""

import re
import unittest

import corrsel
import numpy as np
from support import expected, floats, images, matches_from, releases_the_lock

COLUMNS = (
    "left",
    "right",
    "distance",
    "second_distance",
    "probability",
    "left_frame",
    "right_frame",
    "left_index",
    "right_index",
)


class FeaturesCase(unittest.TestCase):
    """What the tests share."""

    def assert_same_matches(self, first, second):
        for name in COLUMNS:
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name), name)
        self.assertEqual((first.left_size, first.right_size), (second.left_size, second.right_size))

    def assert_raises(self, error, words, action, *arguments, **keywords):
        with self.assertRaises(error) as caught:
            action(*arguments, **keywords)
        self.assertIn(words, str(caught.exception))


class Results(FeaturesCase):
    """Features and matches are those of C++."""

    def test_extraction(self):
        left, _ = images()
        for name, result in expected()["features"].items():
            with self.subTest(features=name):
                features = corrsel.extract(left, name)
                self.assertGreater(len(features), 50)
                np.testing.assert_array_equal(
                    features.points, np.stack([floats(result["x"]), floats(result["y"])], 1)
                )
                for column in ("size", "angle", "response"):
                    np.testing.assert_array_equal(getattr(features, column), floats(result[column]))
                np.testing.assert_array_equal(features.octave, result["octave"])
                np.testing.assert_array_equal(features.frame, np.reshape(result["frame"], (-1, 2, 3)))
                np.testing.assert_array_equal(features.descriptors, result["descriptors"])
                self.assertEqual(features.descriptors.dtype, np.uint8 if name == "orb+orb" else np.float32)
                self.assertEqual(features.image_size, (320, 240))
                self.assertGreater(features.detect_seconds, 0)

    def test_matching(self):
        left, right = images()
        for name, result in expected()["features"].items():
            with self.subTest(features=name):
                matches = corrsel.match(left, right, name)
                self.assert_same_matches(matches, matches_from(result["matches"]))
                one_by_one = corrsel.match_features(corrsel.extract(left, name), corrsel.extract(right, name))
                self.assert_same_matches(matches, one_by_one)
                threaded = corrsel.match(left, right, name, threads=3)
                self.assert_same_matches(matches, threaded)

    def test_the_shift_between_the_images_is_found(self):
        matches = corrsel.match(*images(), features="sift+sift")
        selection = matches.select("usac")
        self.assertEqual(selection.status, "ok")
        shift = np.median(matches.right[selection.mask] - matches.left[selection.mask], axis=0)
        np.testing.assert_allclose(shift, (-9, -4), atol=0.1)

    def test_names(self):
        self.assertEqual(corrsel.Extractor().name, "sift+sift")
        self.assertIn("sift+sift", corrsel.extractor_names())
        self.assertIn("blob", corrsel.detector_names())
        self.assertIn("freak", corrsel.descriptor_names())

    def test_missing_algorithms_have_the_reason_of_the_error(self):
        missing = corrsel.missing_algorithms()
        for name in corrsel.detector_names():
            pairing = name + "+" + (name if name in corrsel.descriptor_names() else "sift")
            with self.subTest(features=pairing):
                if name in missing:
                    with self.assertRaisesRegex(ValueError, re.escape(missing[name])):
                        corrsel.Extractor(pairing)
                else:
                    self.assertEqual(corrsel.Extractor(pairing).name, pairing)


class Images(FeaturesCase):
    """Images and regions of every kind."""

    def test_layouts(self):
        left, _ = images()
        reference = corrsel.extract(left).points
        colour = np.repeat(left[:, :, None], 3, 2)
        wide = np.zeros((480, 640), np.uint8)
        wide[::2, ::2] = left
        for name, image in (
            ("colour", colour),
            ("four channels", np.repeat(left[:, :, None], 4, 2)),
            ("one channel", left[:, :, None]),
            ("every other pixel", wide[::2, ::2]),
            ("Fortran order", np.asfortranarray(left)),
            ("RGB as BGR", colour[:, :, ::-1]),
            ("part of an image", np.pad(left, 9, "constant", constant_values=255)[9:-9, 9:-9]),
            ("upside down twice", left[::-1].copy()[::-1]),
            ("16 bits", left.astype(np.uint16) * 257),
            ("16 bits, colour", colour.astype(np.uint16) * 257),
            ("16 bits, every other pixel", wide.astype(np.uint16)[::2, ::2] * 257),
        ):
            with self.subTest(name):
                np.testing.assert_array_equal(corrsel.extract(image).points, reference)

    def test_an_image_without_texture(self):
        grey = np.full((100, 100), 128, np.uint8)
        features = corrsel.extract(grey)
        self.assertEqual((len(features), features.points.shape), (0, (0, 2)))
        matches = corrsel.match(grey, images()[0])
        self.assertEqual(
            (len(matches), matches.distance.shape, matches.left_frame.shape), (0, (0,), (0, 2, 3))
        )
        self.assertEqual(matches.right_size, (320, 240))
        self.assertEqual(matches.select("usac").status, "too_few")

    def test_masks_and_areas(self):
        left, right = images()
        mask = np.zeros(left.shape, bool)
        mask[:, 160:] = True
        for values in (mask, mask.astype(np.uint8) * 255):
            points = corrsel.extract(left, mask=values).points
            self.assertGreater(len(points), 10)
            self.assertGreaterEqual(points[:, 0].min(), 159.5)
        points = corrsel.extract(left, area=(0, 0, 160, 240)).points
        self.assertGreater(len(points), 10)
        self.assertLess(points[:, 0].max(), 160)
        matches = corrsel.match(left, right, left_mask=mask, right_area=(0, 0, 320, 120))
        self.assertGreaterEqual(matches.left[:, 0].min(), 159.5)
        self.assertLess(matches.right[:, 1].max(), 120)

    def test_errors(self):
        left, right = images()
        extract, match = corrsel.extract, corrsel.match
        self.assert_raises(
            TypeError, "image has dtype float32; needed: uint8, values from", extract, left.astype(np.float32)
        )
        self.assert_raises(
            TypeError,
            "image_right is None; needed: an array of uint8 or uint16 (cv2.imread",
            match,
            left,
            None,
        )
        needed = "; needed: (height, width) for grey"
        self.assert_raises(ValueError, "image has shape (76800,)" + needed, extract, left.ravel())
        self.assert_raises(
            ValueError, "image_left has shape (240, 320, 2)" + needed, match, np.stack([left, left], 2), right
        )
        self.assert_raises(ValueError, "image is empty", extract, left[:0])
        self.assert_raises(ValueError, "mask", extract, left, mask=np.ones((10, 10), bool))
        self.assert_raises(ValueError, "mask has shape (240,)", extract, left, mask=np.ones(240, bool))
        self.assert_raises(
            TypeError, "left_mask has dtype float64", match, left, right, left_mask=np.ones(left.shape)
        )
        self.assert_raises(ValueError, "area", extract, left, area=(400, 0, 10, 10))
        self.assert_raises(
            ValueError, "area is (1, 2, 3); needed: (x, y, width, height), px", extract, left, area=(1, 2, 3)
        )
        self.assert_raises(
            TypeError, "right_area is (0, 0, 1.5, 2)", match, left, right, right_area=(0, 0, 1.5, 2)
        )
        self.assert_raises(ValueError, "threads is 0; needed: 1 or more", extract, left, threads=0)
        self.assert_raises(TypeError, "threads is 2.0; needed: an integer", extract, left, threads=2.0)


class Options(FeaturesCase):
    """Options of features and of matching."""

    def test_options_of_algorithms(self):
        left, right = images()
        self.assertGreater(len(corrsel.extract(left, "sift+sift")), 20)
        self.assertEqual(len(corrsel.extract(left, "sift+sift", sift={"max_features": 20})), 20)
        matches = corrsel.match(left, right, "sift+sift", sift={"max_features": 30}, mutual=True)
        self.assertLessEqual(len(matches), 30)
        self.assertEqual(len(np.unique(matches.right_index)), len(matches))
        options = corrsel.Extractor("sift+freak", sift={"max_features": 30}).options
        self.assertEqual(sorted(options), ["freak", "image", "sift"])
        self.assertIn(("max_features", 30), {(option.name, option.value) for option in options["sift"]})
        dark = left // 8
        equalized = corrsel.Extractor("orb+orb", image={"equalize": "clahe"})
        raised = equalized.extract(dark)
        self.assertGreater(len(raised), len(corrsel.extract(dark, "orb+orb")))
        matches = corrsel.match(dark, right, "orb+orb", image={"equalize": "clahe"})
        self.assert_same_matches(matches, equalized.match(dark, right))
        self.assert_raises(ValueError, "equalize", corrsel.Extractor, image={"equalize": "all"})

    def test_errors(self):
        left, right = images()
        extract, match = corrsel.extract, corrsel.match
        self.assert_raises(ValueError, "foo", extract, left, "foo+sift")
        self.assert_raises(
            ValueError,
            "unknown features 'sift'; did you mean 'sift+sift'",
            match,
            left,
            right,
            features="sift",
        )
        self.assert_raises(ValueError, "unknown option sift.sgima", extract, left, sift={"sgima": 1})
        self.assert_raises(ValueError, "max_features = -1", extract, left, sift={"max_features": -1})
        self.assert_raises(
            ValueError,
            "options of 'orb', but sift+sift is made of sift",
            extract,
            left,
            orb={"max_features": 1},
        )
        self.assert_raises(TypeError, "sift is 7; needed: a dictionary", extract, left, "sift+sift", sift=7)
        self.assert_raises(
            ValueError,
            "unknown option match.mutal; did you mean 'mutual'? valid: mutual, second_distance_radius",
            match,
            left,
            right,
            mutal=True,
        )
        self.assert_raises(
            ValueError, "second_distance_radius = -1", match, left, right, second_distance_radius=-1
        )

    def test_the_help_has_the_options_of_matching(self):
        for option in corrsel.options("match"):
            self.assertIn("%s=%r" % (option.name, option.value), corrsel.match.__doc__)
            self.assertIn(option.description, corrsel.match.__doc__)

    def test_algorithms_and_parameters_have_different_names(self):
        names = {part for name in corrsel.extractor_names() for part in name.split("+")}
        for function in (corrsel.match, corrsel.extract, corrsel.match_features):
            parameters = set(function.__kwdefaults__) | {"image", "image_left", "image_right", "features"}
            self.assertFalse(parameters & (names | {option.name for option in corrsel.options("match")}))


class OwnFeatures(FeaturesCase):
    """Features that come from elsewhere."""

    def test_descriptors_of_float(self):
        points = np.array([[1, 1], [2, 2], [3, 3]], np.float64)
        left = corrsel.Features(points, np.eye(3), image_size=(10, 20))
        right = corrsel.Features(points + 5, np.eye(3)[[2, 0, 1]])
        matches = corrsel.match_features(left, right)
        np.testing.assert_array_equal(matches.right_index, [1, 2, 0])
        np.testing.assert_array_equal(matches.right, (points + 5)[[1, 2, 0]])
        np.testing.assert_array_equal(matches.distance, np.zeros(3))
        np.testing.assert_allclose(matches.second_distance, np.full(3, np.sqrt(2)), rtol=1e-6)
        self.assertEqual((matches.left_size, matches.right_size), ((10, 20), (0, 0)))
        self.assertIsNone(matches.left_frame)

    def test_binary_descriptors_that_are_not_contiguous(self):
        random = np.random.RandomState(0)
        descriptors = random.randint(0, 256, (20, 64), dtype=np.uint8)[:, ::2]
        points = random.uniform(0, 100, (20, 2))
        features = corrsel.Features(points, descriptors)
        matches = corrsel.match_features(features, features)
        np.testing.assert_array_equal(matches.right_index, np.arange(20))

    def test_errors(self):
        points = np.zeros((3, 2))
        self.assert_raises(
            ValueError, "descriptors has shape (2, 8)", corrsel.Features, points, np.zeros((2, 8), np.uint8)
        )
        self.assert_raises(
            ValueError, "descriptors has 2 rows; needed: 3", corrsel.Features, points, np.zeros((2, 8))
        )
        self.assert_raises(
            TypeError, "descriptors has dtype int32", corrsel.Features, points, np.zeros((3, 8), np.int32)
        )
        left = corrsel.Features(points, np.zeros((3, 8)))
        right = corrsel.Features(points, np.zeros((3, 8), np.uint8))
        self.assert_raises(ValueError, "descriptors differ", corrsel.match_features, left, right)
        self.assert_raises(
            TypeError, "right is ndarray; needed: corrsel.Features", corrsel.match_features, left, points
        )


class Guided(FeaturesCase):
    """Matching with a guess of the motion."""

    def setUp(self):
        self.camera = corrsel.Camera(
            "pinhole", [[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1]], size=(320, 240)
        )
        self.views = {"left_camera": self.camera, "right_camera": self.camera}
        c, s = np.cos(0.3), np.sin(0.3)
        self.right = corrsel.MotionGuess(np.eye(3), rotation_sigma=1e-3)
        self.wrong = corrsel.MotionGuess([[c, 0, s], [0, 1, 0], [-s, 0, c]], rotation_sigma=1e-3)

    def farthest(self, matches):
        """Return the largest distance of a match from the place that self.right predicts."""
        return np.linalg.norm(matches.right - matches.left, axis=1).max()

    def test_matches_are_near_the_places_of_a_right_guess(self):
        pixels = images()
        for name in ("orb+orb", "sift+sift"):
            with self.subTest(features=name):
                plain = corrsel.match(*pixels, name)
                guided = corrsel.match(*pixels, name, guess=self.right, **self.views)
                self.assertGreater(self.farthest(plain), 200)
                self.assertLess(self.farthest(guided), 70)
                self.assertGreater(len(guided), len(plain) // 2)
                self.assertEqual(guided.guess, self.right)
                self.assertEqual((guided.left_camera, guided.right_camera), (self.camera, self.camera))
                left, right = (corrsel.extract(image, name) for image in pixels)
                one_by_one = corrsel.match_features(left, right, guess=self.right, threads=2, **self.views)
                self.assert_same_matches(guided, one_by_one)
                self.assertEqual(one_by_one.guess, self.right)

    def test_a_wrong_guess_is_dropped(self):
        pixels = images()
        matches = corrsel.match(*pixels, guess=self.wrong, **self.views)
        self.assert_same_matches(matches, corrsel.match(*pixels))
        self.assertEqual(matches.guess, self.wrong)

    def test_the_strongest_features_test_a_guess(self):
        left, right = (corrsel.extract(image, "orb+orb") for image in images())
        # At every place there are a feature that has its like in the right image and one that has none.
        useless = np.random.RandomState(0).randint(0, 256, left.descriptors.shape).astype(np.uint8)
        points = np.concatenate([left.points, left.points])
        descriptors = np.concatenate([useless, left.descriptors])
        strength = np.repeat(np.float32([1, 2]), len(left))
        for response, near in ((strength, True), (3 - strength, False)):
            features = corrsel.Features(points, descriptors, response=response, image_size=(320, 240))
            matches = corrsel.match_features(features, right, guess=self.right, **self.views)
            self.assertEqual(self.farthest(matches) < 70, near)

    def test_cameras_without_a_guess_are_kept(self):
        matches = corrsel.match(*images(), **self.views)
        self.assert_same_matches(matches, corrsel.match(*images()))
        self.assertEqual((matches.left_camera, matches.right_camera), (self.camera, self.camera))
        self.assertIsNone(matches.guess)

    def test_errors(self):
        left, right = images()
        features = corrsel.extract(left)
        for function, pair in (
            (corrsel.match, (left, right)),
            (corrsel.match_features, (features, features)),
        ):
            for views, error, text in (
                ({}, ValueError, "a guess is given, but no left_camera; a guess needs the cameras of both"),
                ({"left_camera": self.camera}, ValueError, "a guess is given, but no right_camera"),
                ({"left_camera": "pinhole"}, TypeError, "left_camera is str; needed: corrsel.Camera"),
                ({"guess": np.eye(3)}, TypeError, "guess is ndarray; needed: corrsel.MotionGuess"),
            ):
                self.assert_raises(error, text, function, *pair, **dict({"guess": self.right}, **views))
        features.response = features.response[1:]
        self.assert_raises(
            ValueError,
            "points and response differ in length",
            corrsel.match_features,
            features,
            corrsel.extract(right),
        )


class Threads(FeaturesCase):
    """The interpreter's lock is released while C++ works."""

    def test_another_thread_runs_during_matching(self):
        left, right = images()
        extractor = corrsel.Extractor("sift+sift")
        self.assertTrue(releases_the_lock(lambda: extractor.extract(left)))
        self.assertTrue(releases_the_lock(lambda: extractor.match(left, right)))


class Drawing(unittest.TestCase):
    """Pictures of selections; what they show is tested in C++."""

    def setUp(self):
        self.left, self.right = images()
        self.matches = corrsel.match(self.left, self.right, "orb+orb")
        self.selection = self.matches.select("auto")

    def draw(self, **options):
        return corrsel.draw(self.left, self.right, self.matches, self.selection, **options)

    def test_a_picture_is_an_image_of_opencv(self):
        picture = self.draw(width=500)
        self.assertEqual((picture.dtype, picture.ndim, picture.shape[2]), (np.uint8, 3, 3))
        self.assertAlmostEqual(picture.shape[1], 500, delta=1)
        self.assertTrue(picture.flags.c_contiguous and picture.flags.writeable)
        self.assertEqual(
            self.draw(width=0).shape[1], 320 + 320 + 3
        )  # the gap is a two-hundredth of the width
        # Yellow lines and discs: much green and red, little blue.
        bright = (picture[:, :, 1].astype(int) - picture[:, :, 0]) > 60
        self.assertGreater(bright.sum(), 500)
        without = self.draw(width=500, max_lines=0)
        self.assertLess(((without[:, :, 1].astype(int) - without[:, :, 0]) > 60).sum(), bright.sum())

    def test_images_may_be_missing_or_of_other_kinds(self):
        expected = self.draw()
        colour = np.repeat(self.left[:, :, None], 3, axis=2)
        deep = self.right.astype(np.uint16) * 257
        np.testing.assert_array_equal(corrsel.draw(colour, deep, self.matches, self.selection), expected)
        plain = corrsel.draw(None, None, self.matches, self.selection)
        self.assertEqual(plain.shape, expected.shape)

    def test_the_title_replaces_what_was_found(self):
        self.assertFalse(np.array_equal(self.draw(title="mine"), self.draw()))

    def test_wrong_arguments_are_named(self):
        for arguments, error, text in (
            ((self.left, self.right, self.selection, self.selection), TypeError, "matches is Selection"),
            ((self.left, self.right, self.matches, self.selection.mask), TypeError, "selection is ndarray"),
            ((self.left * 1.0, self.right, self.matches, self.selection), TypeError, "image_left has dtype"),
            ((self.left, self.right, self.matches[:5], self.selection), ValueError, "there are 5"),
        ):
            with self.assertRaisesRegex(error, text):
                corrsel.draw(*arguments)
        with self.assertRaisesRegex(ValueError, "width is -1"):
            self.draw(width=-1)


if __name__ == "__main__":
    unittest.main()
