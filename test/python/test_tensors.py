#!/usr/bin/env python3
"""corrsel.tensors: dictionaries of LightGlue and SuperGlue, and Kornia's match_adalam, in numpy and in torch."""

import subprocess
import sys
import unittest

import numpy as np
from corrsel import tensors
from generated_pairs import SIZE, described_pair, generated_pair

try:
    import torch
except ImportError:
    torch = None

SPARE = 7  # keypoints without a match


def superglue(seed=1, plane=True):
    """Return keypoints and the dictionary of SuperGlue for one pair, numpy with a leading 1, and which left keypoints
    have a right match."""
    left, right, truth = generated_pair(seed, plane, 500, 0.6)
    random = np.random.RandomState(seed)
    left = np.concatenate([random.uniform(0, 800, (SPARE, 2)), left]).astype(np.float32)
    order = random.permutation(len(right))
    matches0 = np.concatenate([np.full(SPARE, -1), np.argsort(order)])
    matches1 = order + SPARE
    scores = np.where(truth, 0.9, 0.4) + random.uniform(-0.1, 0.1, len(truth))
    output = {
        "matches0": matches0[None],
        "matches1": matches1[None],
        "matching_scores0": np.concatenate([np.zeros(SPARE), scores]).astype(np.float32)[None],
        "matching_scores1": scores[order].astype(np.float32)[None],
    }
    return left[None], right[order][None], output, np.concatenate([np.zeros(SPARE, bool), truth])


def lightglue(output):
    """Return the dictionary of LightGlue: that of SuperGlue, and lists."""
    rows = [np.flatnonzero(numbers >= 0) for numbers in output["matches0"]]
    lists = [np.stack([row, numbers[row]], 1) for row, numbers in zip(rows, output["matches0"])]
    scores = [values[row] for row, values in zip(rows, output["matching_scores0"])]
    return dict(output, matches=lists, scores=scores, stop=9)


def to_torch(values):
    """Return arrays, or lists or dictionaries of them, as tensors."""
    if isinstance(values, dict):
        return {key: to_torch(value) for key, value in values.items()}
    if isinstance(values, list):
        return [to_torch(value) for value in values]
    return torch.from_numpy(values) if isinstance(values, np.ndarray) else values


class Dictionaries(unittest.TestCase):
    """matches_of() and filter_matches()."""

    def setUp(self):
        self.left, self.right, self.output, self.truth = superglue()

    def expect_filtered(self, result, output=None):
        """The right matches are left, in all arrays alike."""
        output = output or self.output
        self.assertEqual(list(result), list(output))
        kept = np.asarray(result["matches0"])[0] >= 0
        self.assertGreater(kept[self.truth].mean(), 0.95)
        self.assertGreater(self.truth[kept].mean(), 0.95)
        for key in ("matches0", "matching_scores0"):
            before, after = np.asarray(output[key])[0], np.asarray(result[key])[0]
            np.testing.assert_array_equal(after[kept], before[kept])
            np.testing.assert_array_equal(after[~kept], -1 if key == "matches0" else 0)
        back = np.asarray(result["matches1"])[0]
        self.assertEqual((back >= 0).sum(), kept.sum())
        np.testing.assert_array_equal(np.flatnonzero(kept), np.sort(back[back >= 0]))
        np.testing.assert_array_equal(np.asarray(result["matching_scores1"])[0] > 0, back >= 0)
        return kept

    def test_superglue(self):
        before = {key: value.copy() for key, value in self.output.items()}
        result = tensors.filter_matches(self.output, self.left, self.right)
        self.expect_filtered(result)
        for key, value in before.items():  # what came is as it was
            np.testing.assert_array_equal(self.output[key], value)
            self.assertEqual(result[key].dtype, value.dtype)
        whole = dict(self.output, keypoints0=self.left, keypoints1=self.right)
        np.testing.assert_array_equal(tensors.filter_matches(whole)["matches0"], result["matches0"])

    def test_without_a_batch(self):
        flat = {key: value[0] for key, value in self.output.items()}
        result = tensors.filter_matches(flat, self.left[0], self.right[0])
        self.expect_filtered({key: value[None] for key, value in result.items()})
        lists = {
            key: value[0] if isinstance(value, list) else value
            for key, value in lightglue(self.output).items()
        }
        lists = {key: lists[key] for key in ("matches", "scores")}
        result = tensors.filter_matches(lists, self.left[0], self.right[0])
        self.assertGreater(self.truth[result["matches"][:, 0]].mean(), 0.95)
        self.assertEqual(len(result["matches"]), len(result["scores"]))

    def test_lightglue(self):
        output = lightglue(self.output)
        images = [{"keypoints": side, "image_size": np.array([SIZE])} for side in (self.left, self.right)]
        result = tensors.filter_matches(output, *images, "adalam")  # it needs the sizes
        kept = self.expect_filtered(result, output)
        np.testing.assert_array_equal(result["matches"][0][:, 0], np.flatnonzero(kept))
        np.testing.assert_array_equal(result["scores"][0], self.output["matching_scores0"][0][kept])
        self.assertEqual(result["stop"], 9)

    def test_several_pairs(self):
        parts = [superglue(1, True), superglue(2, True)]
        left, right = (np.concatenate([part[side] for part in parts]) for side in (0, 1))
        output = lightglue({key: np.concatenate([part[2][key] for part in parts]) for key in self.output})
        result = tensors.filter_matches(output, left, right)
        for row, part in enumerate(parts):
            alone = tensors.filter_matches(lightglue(part[2]), part[0], part[1])
            for key in self.output:
                np.testing.assert_array_equal(result[key][row], alone[key][0])
            np.testing.assert_array_equal(result["matches"][row], alone["matches"][0])

    @unittest.skipUnless(torch, "needs python3-torch")
    def test_tensors_stay_tensors(self):
        for output in (self.output, lightglue(self.output)):
            expected = tensors.filter_matches(output, self.left, self.right)
            given = to_torch(output)
            given["matching_scores0"] = given["matching_scores0"].requires_grad_()
            result = tensors.filter_matches(given, to_torch(self.left), to_torch(self.right))
            for key in self.output:
                self.assertIsInstance(result[key], torch.Tensor)
                self.assertEqual(
                    (result[key].dtype, result[key].device), (given[key].dtype, given[key].device)
                )
                np.testing.assert_array_equal(result[key].numpy(), expected[key])
            if "matches" in output:
                self.assertEqual(result["matches"][0].dtype, torch.int64)
                np.testing.assert_array_equal(result["matches"][0].numpy(), expected["matches"][0])
                np.testing.assert_array_equal(result["scores"][0].numpy(), expected["scores"][0])

    @unittest.skipUnless(torch, "needs python3-torch")
    def test_half_precision(self):
        output = to_torch(self.output)
        for kind in (torch.float16, torch.bfloat16):
            output["matching_scores0"] = to_torch(self.output["matching_scores0"]).to(kind)
            result = tensors.filter_matches(
                output, to_torch(self.left).to(torch.float16), to_torch(self.right)
            )
            self.assertEqual(result["matching_scores0"].dtype, kind)
            kept = result["matches0"] >= 0
            self.assertTrue(
                bool((result["matching_scores0"][kept] == output["matching_scores0"][kept]).all())
            )

    def test_torch_is_not_imported(self):
        program = "import sys, corrsel.tensors, corrsel.hloc, corrsel.opencv; print('torch' in sys.modules, 'cv2' in sys.modules, 'h5py' in sys.modules)"
        answer = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE, check=True).stdout
        self.assertEqual(answer.split()[:2], [b"False", b"False"])

    def test_matches(self):
        matches = tensors.matches_of(self.output, self.left, self.right, left_size=SIZE, right_size=SIZE)
        self.assertEqual((len(matches), matches.left_size), (500, SIZE))
        np.testing.assert_array_equal(matches.left, self.left[0, matches.left_index])
        np.testing.assert_array_equal(matches.right, self.right[0, matches.right_index])
        np.testing.assert_array_equal(matches.right_index, self.output["matches0"][0, matches.left_index])
        np.testing.assert_allclose(
            matches.probability, self.output["matching_scores0"][0, matches.left_index], atol=1e-6
        )
        self.output["matching_scores0"][:] = 0  # as hloc's AdaLAM has it
        self.assertIsNone(tensors.matches_of(self.output, self.left, self.right).probability)

    def test_no_matches(self):
        self.output["matches0"][:] = -1
        self.output["matches1"][:] = -1
        result = tensors.filter_matches(lightglue(self.output), self.left, self.right)
        self.assertEqual(result["matches"][0].shape, (0, 2))
        self.assertTrue((result["matches0"] == -1).all())
        nothing = {"matches0": np.empty((1, 0), np.int64), "matching_scores0": np.empty((1, 0), np.float32)}
        result = tensors.filter_matches(nothing, np.empty((1, 0, 2)), self.right)
        self.assertEqual(result["matches0"].shape, (1, 0))

    def test_wrong_input(self):
        for error, text, output, left in (
            (KeyError, "neither matches nor matches0; it has scores", {"scores": 1}, self.left),
            (KeyError, "keypoints0", self.output, None),
            (KeyError, "keypoints", self.output, {"keypoint": self.left}),
            (ValueError, r"keypoints0 has shape \(507, 3\)", self.output, np.ones((1, 507, 3))),
            (
                ValueError,
                r"keypoints0 has shape \(2, 507, 2\); needed: 1 x N",
                self.output,
                np.ones((2, 507, 2)),
            ),
            (ValueError, "matches0 has the shape 507", self.output, self.left[:, :100]),
            (
                ValueError,
                "row 0 names the right keypoint 899",
                dict(self.output, matches0=self.output["matches0"] + 900),
                self.left,
            ),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                tensors.filter_matches(output, left, self.right)


def described_frames(seed=4):
    """Return frames, 1 x N x 2 x 3, and descriptors of two images, and the true partners."""
    keypoints, descriptors, partner = described_pair(seed)
    frames = [
        np.concatenate([np.tile(8 * np.eye(2, dtype=np.float32), (len(side), 1, 1)), side[:, :, None]], 2)[
            None
        ]
        for side in keypoints
    ]
    return frames, descriptors, partner


class Kornia(unittest.TestCase):
    """match_adalam() by its written contract."""

    def setUp(self):
        self.frames, self.descriptors, self.partner = described_frames()
        self.shape = SIZE[::-1]

    def expect_right(self, matches):
        """Most of the right matches, and few others."""
        right = self.partner[matches[:, 0]] == matches[:, 1]
        self.assertGreater(right.mean(), 0.95)
        self.assertGreater(right.sum(), 0.5 * (self.partner >= 0).sum())

    def test_arrays(self):
        quality, matches = tensors.match_adalam(
            *self.descriptors, *self.frames, hw1=self.shape, hw2=self.shape
        )
        self.assertEqual((quality.shape, quality.dtype), ((len(matches), 1), np.float32))
        self.assertEqual((matches.shape[1], matches.dtype), (2, np.int64))
        self.expect_right(matches)
        self.assertTrue((np.diff(matches[:, 0]) > 0).all())
        left, right = self.descriptors
        distance = np.linalg.norm(left[matches[:, 0]] - right[matches[:, 1]], axis=1)
        np.testing.assert_allclose(quality[:, 0], distance, rtol=1e-3)
        _, without = tensors.match_adalam(*self.descriptors, *self.frames)
        self.expect_right(without)

    def test_a_matrix_of_distances(self):
        left, right = self.descriptors
        distances = np.linalg.norm(left[:, None] - right[None], axis=2)
        arguments = dict(hw1=self.shape, hw2=self.shape)
        expected = tensors.match_adalam(left, right, *self.frames, **arguments)
        found = tensors.match_adalam(left, right, *self.frames, dm=distances, **arguments)
        np.testing.assert_array_equal(found[1], expected[1])
        np.testing.assert_allclose(found[0], expected[0], rtol=1e-3)
        with self.assertRaisesRegex(ValueError, "dm has shape"):
            tensors.match_adalam(left, right, *self.frames, dm=distances[:5])

    def test_config(self):
        strict = {"min_inliers": 90, "refit": True, "device": None}
        loose = {"orientation_difference_threshold": None, "scale_rate_threshold": None}
        kept = [
            len(tensors.match_adalam(*self.descriptors, *self.frames, config)[1])
            for config in (strict, None, loose)
        ]
        self.assertLess(kept[0], kept[1])
        self.assertGreater(kept[2], 0.9 * kept[1])
        with self.assertRaisesRegex(ValueError, "unknown option min_inlier; known are area_ratio"):
            tensors.match_adalam(*self.descriptors, *self.frames, {"min_inlier": 3})

    def test_nothing(self):
        for count in (0, 1):
            frames = [side[:, :count] for side in self.frames]
            descriptors = [side[:count] for side in self.descriptors]
            for dm in (None, np.ones((count, count))):
                quality, matches = tensors.match_adalam(*descriptors, *frames, dm=dm)
                self.assertEqual((quality.shape, matches.shape), ((0, 1), (0, 2)))
        with self.assertRaisesRegex(ValueError, "lafs1 has shape"):
            tensors.match_adalam(*self.descriptors, self.frames[0][0], self.frames[1])

    @unittest.skipUnless(torch, "needs python3-torch")
    def test_tensors(self):
        expected = tensors.match_adalam(*self.descriptors, *self.frames)
        quality, matches = tensors.match_adalam(*to_torch(list(self.descriptors)), *to_torch(self.frames))
        self.assertEqual((quality.dtype, matches.dtype), (torch.float32, torch.int64))
        np.testing.assert_array_equal(matches.numpy(), expected[1])
        np.testing.assert_array_equal(quality.numpy(), expected[0])


if __name__ == "__main__":
    unittest.main()
