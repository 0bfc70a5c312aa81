#!/usr/bin/env python3
"""Matches, Selector, Selection and select(): the results of C++, arguments of every kind, threads."""

import keyword
import pickle
import threading
import unittest

import corrsel
import numpy as np
from support import expected, floats, releases_the_lock, scene


def same(first, second):
    """Whether two selections agree in everything but the time."""
    return all(
        np.array_equal(first_value, second_value, equal_nan=True)
        if np.asarray(first_value).dtype.kind == "f"
        else np.array_equal(first_value, second_value)
        for first_value, second_value in (
            (getattr(first, name), getattr(second, name))
            for name in corrsel.Selection.__slots__
            if name != "seconds"
        )
    )


class Results(unittest.TestCase):
    """Selections are those of C++."""

    def test_every_selector_and_preset_selects_what_cpp_selects(self):
        for number, results in enumerate(expected()["scenes"]):
            matches = scene(number)
            for spec, result in results["selections"].items():
                with self.subTest(scene=number, selector=spec):
                    selection = matches.select(spec)
                    self.assertEqual(selection.mask.dtype, bool)
                    np.testing.assert_array_equal(selection.mask, np.array(result["mask"], bool))
                    if result["score"]:
                        self.assertEqual(selection.score.dtype, np.float32)
                        np.testing.assert_array_equal(selection.score, floats(result["score"]))
                    else:
                        self.assertIsNone(selection.score)
                    if result["group"]:
                        self.assertEqual(selection.group.dtype, np.int32)
                        np.testing.assert_array_equal(selection.group, result["group"])
                    else:
                        self.assertIsNone(selection.group)
                    if result["model_kind"] == "none":
                        self.assertIsNone(selection.model)
                    else:
                        np.testing.assert_array_equal(selection.model, np.reshape(result["model"], (3, 3)))
                    for (
                        name
                    ) in "model_kind guess status scene message iterations n_input n_ignored n_selected".split():
                        self.assertEqual(getattr(selection, name), result[name], name)
                    np.testing.assert_array_equal(
                        floats([selection.confidence]), floats([result["confidence"]])
                    )
                    if result["status"] == "unsupported_input":
                        continue  # The scenes have no cameras.
                    self.assertEqual(selection.probability is None, not spec.startswith("auto"), spec)
                    corrsel.add_probability(matches, selection)
                    np.testing.assert_array_equal(floats([selection.sigma]), floats([result["sigma"]]))
                    self.assertEqual(selection.probability.dtype, np.float32)
                    np.testing.assert_array_equal(selection.probability, floats(result["probability"]))
                    self.assertGreaterEqual(selection.seconds, 0)

    def test_the_names_are_those_of_the_factory(self):
        specs = set(expected()["scenes"][0]["selections"])
        names = corrsel.selector_names()
        presets = {"%s:%s" % (name, preset) for name in names for preset in corrsel.selector_presets(name)}
        self.assertEqual(specs, set(names) | presets)

    def test_groups_hold_every_selector_once(self):
        groups = corrsel.selector_groups()
        self.assertEqual([name for names in groups.values() for name in names], corrsel.selector_names())
        self.assertEqual(groups["paper"], "nnsr ransac st gtm usac vfc gms lpm".split())
        self.assertEqual(list(groups)[-1], "baseline")
        for group in groups:
            self.assertIn(group, corrsel.selector_groups.__doc__)
            self.assertEqual(corrsel.select.__doc__.count("\n    %s (" % group), 1, group)

    def test_the_groups_of_matches_are_those_of_the_models(self):
        """Two planes that move differently: each match has the number of its plane, wrong ones have -1."""
        random = np.random.default_rng(0)
        left = random.uniform((10, 10), (630, 470), (300, 2))
        plane = np.where(left[:, 0] < 300, 0, 1)
        right = np.where(plane[:, None] == 0, left + (8, 3), left @ [[1.1, 0.04], [-0.04, 1.1]] + (-60, 5))
        right[::10] = random.uniform((10, 10), (630, 470), (30, 2))
        selection = corrsel.select(left, right, "planes", left_size=(640, 480), right_size=(640, 480))
        self.assertEqual((selection.status, selection.group.dtype), ("ok", np.int32))
        self.assertEqual(set(selection.group), {-1, 0, 1})
        self.assertFalse(np.any(selection.group[~selection.mask] >= 0))
        right_ones = np.arange(300) % 10 != 0
        for number in (0, 1):
            chosen = right_ones & (selection.group == number)
            self.assertGreater(np.sum(chosen), 80)
            self.assertEqual(len(set(plane[chosen])), 1, "a group mixes the planes")
        self.assertIsNone(corrsel.select(left, right, "usac").group)

    def test_a_selector_selects_the_same_again(self):
        matches = scene()
        for name in corrsel.selector_names():
            selector = corrsel.Selector(name)
            self.assertTrue(same(selector.select(matches), selector.select(matches)), name)
            self.assertTrue(same(selector.select(matches), matches.select(name)), name)

    def test_an_option_changes_the_selection_and_is_listed(self):
        strict = corrsel.Selector("gms", alpha=8, rotation=True)
        values = {option.name: option.value for option in strict.options}
        self.assertEqual((values["alpha"], values["rotation"]), (8.0, True))
        matches = scene()
        self.assertLess(strict.select(matches).n_selected, matches.select("gms", alpha=0.5).n_selected)

    def test_the_seed_decides_on_the_samples(self):
        matches = scene()
        first, again, other = (matches.select("ransac", seed=seed, refine=False) for seed in (1, 1, 2))
        self.assertTrue(same(first, again))
        self.assertFalse(np.array_equal(first.model, other.model))

    def test_arrays_of_select_are_those_of_matches(self):
        matches = scene()
        selection = corrsel.select(
            matches.left.tolist(),
            matches.right.astype(np.float64),
            "gtm",
            left_frame=matches.left_frame,
            right_frame=matches.right_frame,
            left_size=(1024, 768),
            right_size=np.array([1024, 768]),
        )
        self.assertTrue(same(selection, matches.select("gtm")))
        self.assertGreater(selection.n_selected, 0)

    def test_probabilities_order_matches_without_distances(self):
        matches = scene()
        ratios = matches.distance / matches.second_distance
        columns = {"left_size": (1024, 768), "right_size": (1024, 768)}
        learned = corrsel.Matches(matches.left, matches.right, probability=1 - ratios, **columns)
        self.assertEqual(learned.select("usac:h").message, "")
        blind = corrsel.Matches(matches.left, matches.right, **columns)
        self.assertIn("nor probabilities", blind.select("usac:h").message)
        self.assertTrue(
            same(
                corrsel.select(matches.left, matches.right, "usac:h", probability=1 - ratios, **columns),
                learned.select("usac:h"),
            )
        )
        np.testing.assert_array_equal(learned[[3, 1]].probability, learned.probability[[3, 1]])

    def test_arrays_need_not_be_contiguous(self):
        matches = scene()
        wide = np.zeros((2 * len(matches), 5), np.float32)
        wide[::2, 1:4:2] = matches.left
        fortran = np.asfortranarray(matches.right)
        size = {"left_size": matches.left_size, "right_size": matches.right_size}
        selection = corrsel.select(wide[::2, 1:4:2], fortran, "gms", **size)
        self.assertTrue(same(selection, corrsel.select(matches.left, matches.right, "gms", **size)))
        backwards = corrsel.select(matches.left[::-1], matches.right[::-1], "gms", **size)
        np.testing.assert_array_equal(backwards.mask[::-1], selection.mask)
        swapped = matches.left.astype(">f4"), matches.right.astype(">f8")
        self.assertTrue(same(selection, corrsel.select(*swapped, "gms", **size)))

    def test_unaligned_arrays(self):
        matches = scene()
        bytes_of = np.zeros(8 * len(matches) + 1, np.uint8)
        unaligned = bytes_of[1:].view(np.float32).reshape(-1, 2)
        unaligned[:] = matches.left
        self.assertFalse(unaligned.flags.aligned)
        selection = corrsel.select(unaligned, matches.right, "vfc")
        self.assertTrue(same(selection, corrsel.select(matches.left, matches.right, "vfc")))


class Extremes(unittest.TestCase):
    """Every selector survives any data and gives a mask of the right length."""

    def check(self, left, right, **columns):
        for name in corrsel.selector_names():
            with self.subTest(selector=name, matches=len(left)):
                selection = corrsel.select(left, right, name, **columns)
                self.assertEqual(selection.mask.shape, (len(left),))
                self.assertEqual(selection.n_selected, selection.mask.sum())
                self.assertEqual(selection.n_input, len(left))
                self.assertNotEqual(selection.status, "failed", selection.message)

    def test_no_match(self):
        self.check(np.zeros((0, 2)), np.zeros((0, 2)))
        self.check(
            np.zeros((0, 2)), np.zeros((0, 2)), left_size=(640, 480), right_size=(640, 480), distance=[]
        )

    def test_one_match(self):
        self.check([[1.0, 2.0]], [[3.0, 4.0]])
        self.check(
            [[1.0, 2.0]],
            [[3.0, 4.0]],
            left_size=(640, 480),
            right_size=(640, 480),
            distance=[0.5],
            second_distance=[np.nan],
            probability=[np.nan],
            left_frame=np.zeros((1, 2, 3)),
            right_frame=np.zeros((1, 2, 3)),
            left_index=[0],
            right_index=[7],
        )

    def test_a_confidence_below_the_asked_one_is_a_status(self):
        matches = scene()
        selection = matches.select("gms")
        self.assertEqual(selection.status, "ok")
        self.assertGreater(selection.confidence, 10)
        uncertain = matches.select("gms", min_confidence=selection.confidence + 1)
        self.assertEqual(uncertain.status, "uncertain")
        self.assertIn("below min_confidence", uncertain.message)
        self.assertEqual(uncertain.confidence, selection.confidence)
        np.testing.assert_array_equal(uncertain.mask, selection.mask)

    def test_probabilities_are_added_on_demand(self):
        matches = scene()
        selection = matches.select("usac:h")
        self.assertIsNone(selection.probability)
        self.assertTrue(np.isnan(selection.sigma))
        corrsel.add_probability(matches, selection)
        self.assertGreater(selection.probability[selection.mask].mean(), 0.9)
        self.assertLess(selection.probability[~selection.mask].mean(), 0.1)
        self.assertTrue(0.3 < selection.sigma < 3, selection.sigma)
        with self.assertRaisesRegex(ValueError, "of %d matches, but there are 7" % len(matches)):
            corrsel.add_probability(matches[:7], selection)
        with self.assertRaisesRegex(TypeError, "matches is None"):
            corrsel.add_probability(None, selection)
        with self.assertRaisesRegex(TypeError, "selection is None"):
            corrsel.add_probability(matches, None)

    def test_moving_groups_are_labelled_on_demand(self):
        random = np.random.RandomState(0)
        left = random.uniform((0, 0), (640, 480), (300, 2))
        inside = (abs(left - (250, 200)) < (70, 70)).all(axis=1)
        left = np.vstack([left[~inside], random.uniform((200, 150), (300, 250), (60, 2))])
        right = left + random.normal(0, 0.5, left.shape)
        right[-60:] += (30, 20)
        matches = corrsel.Matches(left, right, left_size=(640, 480), right_size=(640, 480))
        for selector in ("auto", "usac:h"):
            selection = matches.select(selector)
            self.assertIsNone(selection.motion)
            corrsel.label_motion(matches, selection)
            self.assertEqual(selection.motion, ("static", "moving"))
            self.assertGreater((selection.group[-60:] == 1).sum(), 57)
            self.assertFalse((selection.group[:-60] == 1).any())
            self.assertEqual(selection.n_selected, selection.mask.sum())
            self.assertTrue(selection.mask[selection.group == 1].all())
            self.assertEqual(corrsel.draw(None, None, matches, selection).shape[2], 3)
        with self.assertRaisesRegex(ValueError, "but there are 7"):
            corrsel.label_motion(matches[:7], selection)

    def test_coordinates_that_are_not_finite_are_ignored(self):
        random = np.random.RandomState(0)
        left, right = random.uniform(0, 600, (2, 60, 2))
        left[3, 0], left[4, 1], right[5, 0], right[6] = np.nan, np.inf, -np.inf, 1e300
        self.check(left, right, left_size=(640, 480), right_size=(640, 480))
        selection = corrsel.select(left, right, "keep_all")
        self.assertEqual(selection.n_ignored, 4)
        self.assertFalse(selection.mask[3:7].any())

    def test_arbitrary_columns(self):
        random = np.random.RandomState(0)
        special = np.array([np.nan, np.inf, -np.inf, 0, -1, 1e-30, 1e30])
        for n in (1, 2, 5, 9, 40, 200):
            for _ in range(5):

                def arbitrary(shape, scale):
                    values = random.uniform(-0.1, 1, shape) * scale
                    wild = random.uniform(size=shape) < random.choice([0, 0.02, 0.5])
                    return np.where(wild, random.choice(special, shape), values)

                self.check(
                    arbitrary((n, 2), 640),
                    arbitrary((n, 2), 480),
                    left_size=tuple(random.randint(1, 700, 2)),
                    right_size=tuple(random.randint(1, 700, 2)),
                    distance=arbitrary((n,), 1),
                    second_distance=arbitrary((n,), 1),
                    probability=np.where(random.uniform(size=n) < 0.1, np.nan, random.uniform(size=n)),
                    left_frame=arbitrary((n, 2, 3), 10),
                    right_frame=arbitrary((n, 2, 3), 10),
                    left_index=random.randint(0, 2**32, n, dtype=np.int64),
                    right_index=random.randint(0, 3, n),
                )

    def test_a_million_matches(self):
        random = np.random.RandomState(0)
        left = random.uniform(0, 1000, (10**6, 2)).astype(np.float32)
        selection = corrsel.select(left, left + 3, "gms", left_size=(1003, 1003), right_size=(1003, 1003))
        self.assertEqual(selection.status, "ok")
        self.assertGreater(selection.n_selected, 990000)

    def test_too_many_matches(self):
        left = np.random.RandomState(0).uniform(0, 1000, (60000, 2))
        frames = np.repeat([[[1.0, 0, 5], [0, 1, 5]]], 60000, 0)
        for name in ("st", "gtm"):
            selection = corrsel.select(
                left,
                left + 3,
                name,
                left_frame=frames,
                right_frame=frames,
                max_seconds=1e-6,
                memory_limit=1,
            )
            self.assertEqual(selection.status, "too_large")
            self.assertEqual(selection.mask.shape, (60000,))


class Errors(unittest.TestCase):
    """Errors name the argument, what came and what is needed."""

    def setUp(self):
        self.left, self.right = np.zeros((2, 10, 2), np.float32)

    def assert_raises(self, error, words, left=None, right=None, selector="keep_all", **columns):
        with self.assertRaises(error) as caught:
            corrsel.select(
                self.left if left is None else left,
                self.right if right is None else right,
                selector,
                **columns
            )
        self.assertEqual(str(caught.exception), words)

    def test_dtypes(self):
        remedy = "; needed: float32 or float64 (numpy.asarray(%s, numpy.float32) converts)"
        for dtype in ("int64", "uint8", "float16", "complex64", "object", "bool"):
            self.assert_raises(
                TypeError, "left has dtype %s" % dtype + remedy % "left", left=self.left.astype(dtype)
            )
        self.assert_raises(
            TypeError,
            "distance has dtype int64" + remedy % "distance",
            distance=np.arange(10, dtype=np.int64),
        )
        self.assert_raises(
            TypeError, "left_index has dtype float64; needed: an integer type", left_index=np.zeros(10)
        )
        self.assert_raises(TypeError, "left has dtype <U1" + remedy % "left", left=[["a", "b"]] * 10)

    def test_shapes(self):
        points = "one row (x, y) per match"
        self.assert_raises(
            ValueError, "left has shape (10, 3); needed: (N, 2), " + points, left=np.zeros((10, 3))
        )
        self.assert_raises(
            ValueError, "right has shape (10, 1, 2); needed: (N, 2), " + points, right=np.zeros((10, 1, 2))
        )
        self.assert_raises(ValueError, "right has 9 rows; needed: 10, " + points, right=self.right[1:])
        self.assert_raises(
            ValueError,
            "distance has shape (10, 1); needed: (N,), one element per match",
            distance=np.zeros((10, 1)),
        )
        self.assert_raises(
            ValueError,
            "left_frame has shape (10, 6); needed: (N, 2, 3), one frame [[a11, a12, x], [a21, a22, y]] per match",
            left_frame=np.zeros((10, 6)),
        )
        self.assert_raises(
            ValueError, "right_index has 1 rows; needed: 10, one element per match", right_index=[1]
        )

    def test_probabilities(self):
        for wrong in (-0.25, 1.5, np.inf):
            values = np.full(10, 0.5)
            values[3], values[7] = np.nan, wrong
            self.assert_raises(
                ValueError,
                "probability holds %g in row 7; needed: 0 to 1, or NaN where it is not known" % wrong,
                probability=values,
            )
        self.assert_raises(
            ValueError, "probability has 1 rows; needed: 10, one element per match", probability=[0.5]
        )

    def test_numbers_and_sizes(self):
        self.assert_raises(
            ValueError,
            "left_index holds numbers from -1 to -1; needed: 0 to 4294967295",
            left_index=np.full(10, -1),
        )
        needed = "; needed: (width, height), px; of an image as an array, image.shape[1::-1]"
        self.assert_raises(ValueError, "left_size is (480, 640, 3)" + needed, left_size=(480, 640, 3))
        self.assert_raises(ValueError, "left_size is (-1, 640)" + needed, left_size=(-1, 640))
        self.assert_raises(
            TypeError,
            "right_size is (1.5, 2); needed: two integers (width, height), px",
            right_size=(1.5, 2),
        )

    def test_words_of_cpp(self):
        self.assert_raises(
            ValueError,
            "gms: option alpha = -1 is outside [0, 100]",
            selector="gms",
            alpha=-1,
        )
        self.assert_raises(
            ValueError,
            "unknown option gms.alpa; did you mean 'alpha'? valid: "
            + ", ".join(option.name for option in corrsel.options("gms")),
            selector="gms",
            alpa=1,
        )
        for spec, options, words in (
            ("gms", {"grid": 2.5}, "option gms.grid"),
            ("gms", {"alpha": "wide"}, "option gms.alpha"),
            ("gms", {"alpha": float("nan")}, "gms"),
            (
                "ransac",
                {"model": "affine"},
                "option ransac.model: 'affine' is not one of homography, fundamental",
            ),
            ("gsm", {}, "unknown selector 'gsm'; did you mean 'gms'? valid: "),
            ("lpm:v9", {}, "unknown preset 'v9' of selector lpm; valid: "),
            ("gms[alpha=-1]", {}, "selector 'gms[alpha=-1]': gms: option alpha = -1 is outside [0, 100]"),
            ("gms[alpa=1]", {}, "selector 'gms[alpa=1]': unknown option gms.alpa; did you mean 'alpha'?"),
            ("gms[alpha=1", {}, "selector 'gms[alpha=1': ']' is missing"),
            ("other/Selector", {}, "other/Selector"),
        ):
            with self.subTest(selector=spec, options=options):
                with self.assertRaises(ValueError) as caught:
                    corrsel.Selector(spec, **options)
                self.assertIn(words, str(caught.exception))
        with self.assertRaisesRegex(ValueError, "unknown selector 'gsm'"):
            corrsel.selector_presets("gsm")

    def test_values_that_are_no_options(self):
        self.assert_raises(
            TypeError,
            "option gms.alpha is [6]; needed: a number, a bool or a text",
            selector="gms",
            alpha=[6],
        )
        self.assert_raises(
            TypeError,
            "option gms.alpha is None; needed: a number, a bool or a text",
            selector="gms",
            alpha=None,
        )

    def test_a_missing_column_is_a_status(self):
        selection = corrsel.select(self.left, self.right, "gms")
        self.assertEqual(selection.status, "unsupported_input")
        self.assertIn("size", selection.message)

    def test_selectors_take_matches_only(self):
        with self.assertRaisesRegex(TypeError, "matches is ndarray; needed: corrsel.Matches"):
            corrsel.Selector("gms").select(self.left)


class Options(unittest.TestCase):
    """Values of options, and their list."""

    def test_numbers_of_numpy_and_of_python_are_the_same(self):
        for values in (
            {"alpha": 6, "grid": 10, "rotation": True},
            {"alpha": np.float32(6), "grid": np.int64(10), "rotation": np.bool_(True)},
            {"alpha": "6", "grid": "10", "rotation": "true"},
        ):
            options = {option.name: option.value for option in corrsel.Selector("gms", **values).options}
            self.assertEqual((options["alpha"], options["grid"], options["rotation"]), (6.0, 10, True))

    def test_numbers_arrive_bit_by_bit(self):
        for value in (0.1, 1 / 3, 1e-3, np.nextafter(1.0, 2)):
            options = {option.name: option.value for option in corrsel.Selector("gms", alpha=value).options}
            self.assertEqual(options["alpha"], value)

    def test_an_option_named_like_a_word_of_python(self):
        options = {option.name: option.value for option in corrsel.Selector("vfc", lambda_=5).options}
        self.assertEqual(options["lambda"], 5)
        same_options = corrsel.Selector("vfc", **{"lambda": 5}).options
        self.assertEqual({option.name: option.value for option in same_options}, options)

    def test_no_option_is_hidden_by_a_parameter(self):
        parameters = set(corrsel.select.__kwdefaults__) | {"left", "right", "selector", "name", "self"}
        for name in corrsel.selector_names():
            self.assertFalse(parameters & {option.name for option in corrsel.options(name)}, name)

    def test_a_preset_shows_in_the_values(self):
        self.assertNotEqual(corrsel.options("lpm"), corrsel.options("lpm:v2"))
        self.assertEqual(corrsel.options("lpm:v2"), corrsel.Selector("lpm:v2").options)

    def test_options_in_brackets_win_over_the_preset_and_over_keywords(self):
        spec = "lpm:v2[lambda_first=3;k=5]"
        values = {option.name: option.value for option in corrsel.options(spec)}
        self.assertEqual((values["lambda_first"], values["k"], values["lambda_second"]), (3.0, 5, 0.5))
        selector = corrsel.Selector(spec, k=7, lambda_second=1)
        self.assertEqual(selector.name, "lpm")
        values = {option.name: option.value for option in selector.options}
        self.assertEqual((values["k"], values["lambda_second"]), (5, 1.0))
        matches = scene(0)
        self.assertTrue(same(matches.select("gms[alpha=1]"), matches.select("gms", alpha=1)))
        with self.assertRaisesRegex(ValueError, "unknown selector or algorithm of features 'gsm"):
            corrsel.options("gsm[alpha=1]")

    def test_choices_have_meanings(self):
        model = next(option for option in corrsel.options("usac") if option.name == "model")
        self.assertEqual(
            (model.value, model.unit, list(model.choices)),
            ("homography", "-", ["homography", "fundamental", "essential"]),
        )
        self.assertTrue(all(model.choices.values()))

    def test_features_have_options_too(self):
        self.assertIn("max_features", {option.name for option in corrsel.options("orb")})
        self.assertIn("mutual", {option.name for option in corrsel.options("match")})
        with self.assertRaisesRegex(ValueError, "'sfit'; did you mean 'sift'. valid: nnsr, .*, sift"):
            corrsel.options("sfit")

    def test_the_help_has_every_option_with_its_range(self):
        for selector in corrsel.selector_names():
            self.assertIn("\n    %s: " % selector, corrsel.select.__doc__)
            for preset in corrsel.selector_presets(selector):
                self.assertIn("%s:%s" % (selector, preset), corrsel.select.__doc__)
            for option in corrsel.options(selector):
                name = option.name + "_" * keyword.iskeyword(option.name)
                self.assertIn("        %s=%r" % (name, option.value), corrsel.select.__doc__)
                self.assertIn(option.description, corrsel.select.__doc__)
        self.assertIn(
            "    gms: Grid-based motion statistics\n        needs: left_size, right_size\n",
            corrsel.select.__doc__,
        )
        self.assertNotIn(
            "needs: ", corrsel.select.__doc__.partition("    ransac: ")[2].partition("    st: ")[0]
        )


class MatchesTest(unittest.TestCase):
    """Matches as a container."""

    def test_arrays_of_the_right_type_are_not_copied(self):
        left, right = np.zeros((2, 10, 2), np.float32)
        frames, index = np.zeros((10, 2, 3), np.float32), np.zeros(10, np.uint32)
        matches = corrsel.Matches(left, right, left_frame=frames, left_index=index)
        for mine, kept in (
            (left, matches.left),
            (right, matches.right),
            (frames, matches.left_frame),
            (index, matches.left_index),
        ):
            self.assertTrue(np.shares_memory(mine, kept))

    def test_rows(self):
        matches = scene()
        mask = matches.select("gms").mask
        numbers = np.arange(len(matches))
        selected = np.flatnonzero(mask)
        for rows, expected_rows in (
            (mask, selected),
            (mask.tolist(), selected),
            (selected, selected),
            (selected.tolist(), selected),
            (slice(3, 20, 2), numbers[3:20:2]),
            ([], numbers[:0]),
        ):
            some = matches[rows]
            self.assertEqual(len(some), len(expected_rows))
            np.testing.assert_array_equal(some.left, matches.left[expected_rows])
            np.testing.assert_array_equal(some.distance, matches.distance[expected_rows])
            np.testing.assert_array_equal(some.left_frame, matches.left_frame[expected_rows])
            self.assertEqual(some.left_size, (1024, 768))
            self.assertIsNone(some.left_index)
        with self.assertRaisesRegex(TypeError, "a slice, a mask or an array of row numbers"):
            matches[3]
        with self.assertRaises(IndexError):
            matches[[len(matches)]]

    def test_attributes_stay(self):
        matches = scene()
        with self.assertRaisesRegex(AttributeError, "cannot be replaced"):
            matches.left = matches.right

    def test_texts(self):
        self.assertIn("300 matches with distance, second_distance, left_frame", repr(scene()))
        self.assertIn("positions only", repr(corrsel.Matches([[1.0, 2]], [[3.0, 4]])))
        self.assertIn("of 300 matches selected, model homography", repr(scene().select("ransac")))
        self.assertIn("gms needs the size", repr(corrsel.select([[1.0, 2]], [[3.0, 4]], "gms")))
        self.assertIn("alpha=6.0", repr(corrsel.Selector("gms", alpha=6)))

    def test_pickle(self):
        matches = scene()
        again = pickle.loads(pickle.dumps(matches))
        np.testing.assert_array_equal(again.left_frame, matches.left_frame)
        self.assertEqual(again.left_size, matches.left_size)


class Threads(unittest.TestCase):
    """The interpreter's lock is released while C++ works."""

    def test_another_thread_runs_during_a_selection(self):
        matches = corrsel.Matches(*np.random.RandomState(0).uniform(0, 1000, (2, 1500, 2)))
        selector = corrsel.Selector("st")
        self.assertTrue(releases_the_lock(lambda: selector.select(matches)))

    def test_one_selector_serves_many_threads(self):
        matches, selectors = scene(), [corrsel.Selector(name) for name in corrsel.selector_names()]
        alone = [selector.select(matches) for selector in selectors]
        failures = []

        def work():
            for _ in range(5):
                for selector, result in zip(selectors, alone):
                    if not same(selector.select(matches), result):
                        failures.append(selector.name)

        workers = [threading.Thread(target=work) for _ in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertEqual(failures, [])


if __name__ == "__main__":
    unittest.main()
