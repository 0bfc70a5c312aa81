#!/usr/bin/env python3
"""corrsel.hloc: its matcher by the contract of BaseModel."""

import sys
import types
import unittest
from unittest import mock

import corrsel
import numpy as np
from corrsel import hloc
from generated_pairs import SIZE, described_pair

try:
    import torch
except ImportError:
    torch = None


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
