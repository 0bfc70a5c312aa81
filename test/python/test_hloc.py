#!/usr/bin/env python3
"""corrsel.hloc: files of matches as hloc writes and reads them, and its matcher by the contract of BaseModel."""

import os
import pathlib
import sys
import tempfile
import types
import unittest
from unittest import mock

import corrsel
import numpy as np
from corrsel import hloc
from corrsel.files.pairs import InputError
from generated_pairs import SIZE, described_pair, generated_pair

try:
    import h5py
except ImportError:
    h5py = None
try:
    import torch
except ImportError:
    torch = None

NAMES = ("db/1.jpg", "db/2.jpg", "q.jpg")


def stored_pair(path, name0, name1):
    """Return matches and scores as hloc.utils.io.get_matches() reads them."""
    with h5py.File(str(path), "r") as file:
        group, reverse = name0.replace("/", "-") + "/" + name1.replace("/", "-"), False
        if group not in file:
            group, reverse = name1.replace("/", "-") + "/" + name0.replace("/", "-"), True
        numbers, scores = (file[group][name][()] for name in ("matches0", "matching_scores0"))
    rows = np.flatnonzero(numbers != -1)
    pairs = np.stack([rows, numbers[rows]], -1)
    return pairs[:, ::-1] if reverse else pairs, scores[rows]


@unittest.skipUnless(h5py, "needs python3-h5py")
class Verify(unittest.TestCase):
    """A file of matches before and after."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="corrsel_hloc_")
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.features, self.matches = self.root / "features.h5", self.root / "matches.h5"
        self.output = self.root / "verified.h5"
        left, right, self.truth = generated_pair(1, True, 500, 0.6)
        random = np.random.RandomState(2)
        keypoints = left, right, random.uniform((0, 0), SIZE, (500, 2))
        with h5py.File(str(self.features), "w") as file:
            for name, points in zip(NAMES, keypoints):
                file[name + "/keypoints"] = points.astype(np.float16)
                file[name + "/image_size"] = SIZE
        self.numbers = np.arange(500)
        self.scores = np.where(self.truth, 0.9, 0.5)
        self.write(NAMES[0], NAMES[1], self.numbers)
        self.write(NAMES[0], NAMES[2], self.numbers)

    def write(self, name0, name1, numbers, **others):
        """Writes a pair as hloc does."""
        with h5py.File(str(self.matches), "a", libver="latest") as file:
            name = name0.replace("/", "-") + "/" + name1.replace("/", "-")
            if name in file:
                del file[name]
            file[name + "/matches0"] = numbers.astype(np.int16)
            file[name + "/matching_scores0"] = self.scores.astype(np.float16)
            for key, values in others.items():
                file[name + "/" + key] = values

    def verify(self, *arguments, **options):
        """Calls verify() with the files."""
        return hloc.verify(self.matches, self.features, self.output, *arguments, **options)

    def test_right_matches_stay(self):
        self.write(NAMES[0], NAMES[1], self.numbers, remark=np.arange(3))
        before = self.matches.read_bytes()
        report = self.verify()
        pairs, scores = stored_pair(self.output, NAMES[0], NAMES[1])
        self.assertEqual(tuple(report), (2, 1, 1000, len(pairs)))
        self.assertGreater(self.truth[pairs[:, 0]].mean(), 0.97)
        self.assertGreater(len(pairs), 0.95 * self.truth.sum())
        np.testing.assert_array_equal(pairs[:, 0], pairs[:, 1])
        np.testing.assert_array_equal(scores, self.scores.astype(np.float16)[pairs[:, 0]])
        self.assertEqual(len(stored_pair(self.output, NAMES[0], NAMES[2])[0]), 0)
        with h5py.File(str(self.output), "r") as file:
            group = file["db-1.jpg/db-2.jpg"]
            self.assertEqual(sorted(group), ["matches0", "matching_scores0", "remark"])
            self.assertEqual(
                (group["matches0"].dtype, group["matching_scores0"].dtype), (np.int16, np.float16)
            )
            rejected = group["matches0"][()] == -1
            self.assertTrue((group["matching_scores0"][()][rejected] == 0).all())
            self.assertEqual(group.attrs["corrsel_status"], "ok")
            self.assertGreater(group.attrs["corrsel_confidence"], 4)
            self.assertNotEqual(file["db-1.jpg/q.jpg"].attrs["corrsel_status"], "ok")
        self.assertEqual(self.matches.read_bytes(), before)
        self.assertEqual(sorted(os.listdir(str(self.root))), ["features.h5", "matches.h5", "verified.h5"])

    def test_the_same_selection_as_select(self):
        """With the scores as probabilities, and sizes."""
        self.verify(selector="adalam")
        with h5py.File(str(self.features), "r") as file:
            left, right = (file[name]["keypoints"][()].astype(np.float32) for name in NAMES[:2])
        probability = self.scores.astype(np.float16).astype(np.float64)
        selection = corrsel.select(
            left, right, "adalam", probability=probability, left_size=SIZE, right_size=SIZE
        )
        pairs, _ = stored_pair(self.output, NAMES[0], NAMES[1])
        np.testing.assert_array_equal(pairs[:, 0], np.flatnonzero(selection.mask))

    def test_a_list_of_pairs(self):
        """Chooses the pairs; hloc's lists may name them in any order, and in both."""
        numbers = np.roll(np.arange(500), 3)  # the left keypoint 3 has the right keypoint 0
        self.write(NAMES[2], NAMES[0], numbers)
        with h5py.File(str(self.features), "a") as file:
            points = file[NAMES[0]]["keypoints"][()] + np.float16(20)
            file[NAMES[2]]["keypoints"][...] = np.roll(points, 3, axis=0)
        listed = self.root / "pairs.txt"
        listed.write_text("db/1.jpg q.jpg\nq.jpg db/1.jpg\n", encoding="utf-8")
        with h5py.File(str(self.matches), "a") as file:
            del file["db-1.jpg/q.jpg"]
        report = self.verify(listed)
        self.assertEqual((report.pairs, report.accepted), (1, 1))
        pairs, _ = stored_pair(self.output, NAMES[2], NAMES[0])
        self.assertGreater(len(pairs), 400)
        np.testing.assert_array_equal(numbers[pairs[:, 0]], pairs[:, 1])
        with h5py.File(str(self.output), "r") as file:
            self.assertEqual(list(file), ["q.jpg"])

    def test_groups_of_older_files(self):
        """A_B instead of A/B."""
        with h5py.File(str(self.matches), "a") as file:
            file.move("db-1.jpg/db-2.jpg", "db-1.jpg_db-2.jpg")
            del file["db-1.jpg/q.jpg"]
        self.assertEqual(self.verify()[:2], (1, 1))
        with h5py.File(str(self.output), "r") as file:
            self.assertEqual(list(file), ["db-1.jpg_db-2.jpg"])
            self.assertGreater((file["db-1.jpg_db-2.jpg/matches0"][()] >= 0).sum(), 0.95 * self.truth.sum())

    def test_scores_of_zero_are_no_probabilities(self):
        self.scores[:] = 0
        self.write(NAMES[0], NAMES[1], self.numbers)
        with mock.patch.object(hloc, "Matches", side_effect=corrsel.Matches) as made:
            self.verify()
        self.assertEqual([call[1]["probability"] is None for call in made.call_args_list], [True, False])
        pairs, scores = stored_pair(self.output, NAMES[0], NAMES[1])
        self.assertGreater(len(pairs), 0.95 * self.truth.sum())
        self.assertEqual(scores.max(), 0)

    def test_input_that_cannot_be_used(self):
        """Names the file, and leaves the older output as it was."""
        self.output.write_text("older", encoding="utf-8")
        self.write(NAMES[0], NAMES[2], self.numbers + 1)
        with self.assertRaisesRegex(
            InputError, "matches.h5: db-1.jpg/q.jpg/matches0, row 499 names the right"
        ):
            self.verify()
        with self.assertRaisesRegex(ValueError, "unknown selector 'none'"):
            self.verify(selector="none")
        self.write(NAMES[0], NAMES[2], np.arange(1000).reshape(500, 2) // 2)
        with self.assertRaisesRegex(
            InputError, "has the shape 500x2, expected one element for each keypoint"
        ):
            self.verify()
        with self.assertRaisesRegex(InputError, "is the file of the matches; give another name"):
            hloc.verify(self.matches, self.features, self.matches)
        with self.assertRaisesRegex(InputError, "nowhere/verified.h5 cannot be written"):
            hloc.verify(self.matches, self.features, self.root / "nowhere" / "verified.h5")
        self.assertEqual(self.output.read_text(encoding="utf-8"), "older")
        self.assertEqual(sorted(os.listdir(str(self.root))), ["features.h5", "matches.h5", "verified.h5"])

    def test_numbers_beyond_16_bits(self):
        """hloc writes them as other numbers, of which some would look valid."""
        with h5py.File(str(self.features), "a") as file:
            del file[NAMES[1]]["keypoints"]
            file[NAMES[1]]["keypoints"] = np.zeros((40000, 2), np.float16)
        with self.assertRaisesRegex(InputError, "16 bits, but db/2.jpg has 40000 keypoints.*at most 32768"):
            self.verify()


class BaseModel:
    """The contract of hloc.utils.base_model.BaseModel, without torch."""

    default_conf, required_inputs = {}, []

    def __init__(self, conf):
        self.conf = conf = {**self.default_conf, **conf}
        self._init(conf)

    def __call__(self, data):
        for key in self.required_inputs:
            assert key in data, key
        return self._forward(data)


class Matcher(unittest.TestCase):
    """match() and register()."""

    def setUp(self):
        keypoints, descriptors, self.partner = described_pair(3)
        self.data = {}
        for side, points, described in zip("01", keypoints, descriptors):
            self.data["image" + side] = np.empty((1, 1, SIZE[1], SIZE[0]), np.float32)
            self.data["keypoints" + side] = points[None]
            self.data["descriptors" + side] = np.ascontiguousarray(described.T)[None]
            self.data["scales" + side] = np.full((1, len(points)), 4, np.float32)
            self.data["oris" + side] = np.full((1, len(points)), 30, np.float32)

    def expect_right(self, result):
        """Most of the right matches, and few others."""
        numbers, scores = (np.asarray(result[name])[0] for name in ("matches0", "matching_scores0"))
        self.assertEqual((numbers.dtype, scores.dtype), (np.int64, np.float32))
        found = numbers >= 0
        right = found & (numbers == self.partner)
        self.assertGreater(right.sum(), 0.9 * (self.partner >= 0).sum())
        self.assertGreater(right.sum(), 0.95 * found.sum())
        self.assertTrue((scores[~found] == 0).all() and (scores[found] > 0).all() and scores.max() <= 1)

    def test_arrays(self):
        self.expect_right(hloc.match(self.data))
        for selector in ("lpm", "adalam"):  # the latter needs the sizes
            scores = hloc.match(self.data, selector)["matching_scores0"][0]
            self.assertEqual(set(scores.tolist()), {0.0, 1.0})

    def test_frames_from_scales_and_orientations(self):
        with mock.patch.object(hloc, "Features", side_effect=corrsel.Features) as made:
            hloc.match(self.data, "gtm", max_seconds=0.1)
        frame = made.call_args_list[0][1]["frame"][5]
        c, s = 4 * np.cos(np.radians(30)), 4 * np.sin(np.radians(30))
        expected = np.column_stack([[[c, -s], [s, c]], self.data["keypoints0"][0, 5]])
        np.testing.assert_allclose(frame, expected, rtol=1e-5)

    def test_few_and_many_keypoints(self):
        for count in (0, 1):
            data = {key: value[:, :count] if "points" in key else value for key, value in self.data.items()}
            for side in "01":
                data["descriptors" + side] = self.data["descriptors" + side][:, :, :count]
                del data["scales" + side]
            result = hloc.match(data)
            self.assertEqual(result["matches0"].shape, (1, count))
            self.assertTrue((result["matches0"] == -1).all())
        self.data["keypoints1"] = np.zeros((1, 40000, 2), np.float32)
        with self.assertRaisesRegex(
            ValueError, "keypoints1 has 40000 keypoints.*16 bits.*lower max_keypoints to 32768"
        ):
            hloc.match(self.data)
        self.data["keypoints1"] = np.zeros((40000, 2), np.float32)
        with self.assertRaisesRegex(ValueError, r"keypoints1 has shape \(40000, 2\).*needed: 1 x N x 2"):
            hloc.match(self.data)

    def registered(self, base):
        """Returns the model that hloc.utils.base_model.dynamic_load() finds for a configuration."""
        package, module = types.ModuleType("hloc"), types.ModuleType("hloc.utils.base_model")
        module.BaseModel = base
        known = {"hloc": package, "hloc.utils": types.ModuleType("hloc.utils"), module.__name__: module}
        known["hloc.matchers"] = types.ModuleType("hloc.matchers")
        self.enter(mock.patch.dict(sys.modules, known))
        conf = hloc.register("auto", seed=5)
        self.assertEqual(conf["output"], "matches-corrsel-auto")
        path = "hloc.matchers." + conf["model"]["name"]
        found = __import__(path, fromlist=[""])
        classes = [
            value
            for value in vars(found).values()
            if isinstance(value, type) and value.__module__ == path and issubclass(value, base)
        ]
        self.assertEqual(len(classes), 1)
        return classes[0](conf["model"])

    def enter(self, context):
        """unittest's enterContext() of Python 3.11."""
        context.__enter__()
        self.addCleanup(context.__exit__, None, None, None)

    def test_the_model_that_hloc_loads(self):
        model = self.registered(BaseModel)
        result = model(self.data)
        self.expect_right(result)
        np.testing.assert_array_equal(result["matches0"], hloc.match(self.data, "auto", seed=5)["matches0"])
        with self.assertRaises(AssertionError):
            model({"keypoints0": 1})
        with self.assertRaisesRegex(ValueError, "unknown selector 'otto'"):
            hloc.register("otto")

    @unittest.skipUnless(torch, "needs python3-torch")
    def test_the_model_in_torch(self):
        class Module(BaseModel, torch.nn.Module):
            """As hloc's."""

            def __init__(self, conf):
                torch.nn.Module.__init__(self)
                BaseModel.__init__(self, conf)

        model = self.registered(Module).eval().to("cpu")
        data = {key: torch.from_numpy(value) for key, value in self.data.items()}
        with torch.no_grad():
            result = model(data)
        self.assertEqual((result["matches0"].dtype, result["matches0"].shape), (torch.int64, (1, 600)))
        self.expect_right({key: value.numpy() for key, value in result.items()})
        stored = result["matches0"][0].cpu().short().numpy()  # as hloc writes it
        np.testing.assert_array_equal(stored, hloc.match(self.data, seed=5)["matches0"][0])

    def test_without_hloc(self):
        with mock.patch.dict(sys.modules, {"hloc": None, "hloc.utils.base_model": None}):
            with self.assertRaises(ImportError):
                hloc.register()


if __name__ == "__main__":
    unittest.main()
