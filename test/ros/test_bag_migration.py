#!/usr/bin/env python3
"""Bags of version 0.1.0 become bags of this one by `rosbag fix`: python3 test_bag_migration.py"""
import csv
import inspect
import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

import genpy
import genpy.dynamic
import numpy as np
import rosbag
import rosbag.migration
import rospkg
from corrsel.msg import Camera, GroundTruth, Progress, Score, Selection
from ros_shell import RosShell

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DEVEL = pathlib.Path(os.environ["CORRSEL_DEVEL_DIR"])
RULES = SOURCE / "migration_rules" / "from_0_1_0.bmr"
#: The checksums of the messages of version 0.1.0.
CHECKSUMS = {
    "Correspondences": "ce0620d4082f4af54ca261c702a76f2d",
    "GroundTruth": "99d1af5e553e16fbe53b6a43c5496ca0",
    "Selection": "06e5d0f994072f2dae4a99789727084d",
}
STAMP = genpy.Time(7, 5)
HOMOGRAPHY = np.array([[1.0, 0, 30], [0, 1, -20], [0, 0, 1]])
MATCHES = 200

#: PEP 667: since Python 3.13 locals() does not see what exec() defines, on which rosbag's migration relied.
CONVERTS = sys.version_info < (3, 13) or "locals()[" not in inspect.getsource(rosbag.migration)
needs_conversion = unittest.skipUnless(CONVERTS, "this rosbag converts no bags with Python 3.13 and later")


def former_classes():
    """Return the classes of the messages of version 0.1.0 by name, from the definitions that the rules hold."""
    rules = {"MessageUpdateRule": object}
    exec(RULES.read_text(encoding="utf-8"), rules)  # pylint: disable=exec-used
    classes = {}
    for name in CHECKSUMS:
        text = rules[name + "_0_1_0"].old_full_text
        classes[name] = genpy.dynamic.generate_dynamic("corrsel/" + name, text)["corrsel/" + name]
    return classes


def former_matches(make):
    """Return Correspondences of version 0.1.0, half of which follow the homography."""
    random = np.random.RandomState(1)
    left = random.uniform(100, 500, (MATCHES, 2)).astype(np.float32)
    right = left + np.float32((30, -20))
    right[::2] = random.uniform(0, 600, (MATCHES // 2, 2))
    message = make(dataset="mine", sequence="drive", pair="7", features="sift+sift")
    message.left_width = message.right_width = message.left_height = message.right_height = 640
    message.left_x, message.left_y = left.T.tolist()
    message.right_x, message.right_y = right.T.tolist()
    message.distance = np.linspace(0.5, 1, MATCHES, dtype=np.float32).tolist()
    message.second_distance = [1.25] * MATCHES
    message.n_left_features, message.n_right_features = 1000, 900
    message.wait_seconds, message.detect_seconds, message.publish_seconds = 0.125, 0.25, 0.5
    return message


class BagMigration(unittest.TestCase):
    """A bag with a message of every type that version 0.1.0 recorded."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_migration_"))
        self.addCleanup(shutil.rmtree, str(self.root))
        self.shell = RosShell(DEVEL / "setup.bash", self.root)
        self.classes = former_classes()
        self.old, self.new = self.root / "old.bag", self.root / "new.bag"

    def write(self):
        """Write the bag; return its messages by topic."""
        truth = self.classes["GroundTruth"](dataset="mine", sequence="drive", pair="7")
        truth.kind, truth.matrix = GroundTruth.KIND_HOMOGRAPHY, HOMOGRAPHY.ravel().tolist()
        selection = self.classes["Selection"](selector="lpm:v2", status=Selection.STATUS_TIME_LIMIT)
        selection.mask, selection.message = bytes([1, 0] * (MATCHES // 2)), "it took long"
        selection.n_input, selection.n_selected, selection.iterations = MATCHES, MATCHES // 2, 42
        selection.select_seconds = 0.75
        messages = {
            "/ground_truth": truth,
            "/correspondences": former_matches(self.classes["Correspondences"]),
            "/selection": selection,
            "/score": Score(selector="lpm:v2", n_selected=MATCHES // 2),
            "/progress": Progress(current="mine/drive/7"),
        }
        with rosbag.Bag(str(self.old), "w") as bag:
            for topic, message in messages.items():
                message.header.stamp, message.header.frame_id = STAMP, "left_camera"
                bag.write(topic, message, STAMP)
        return messages

    def fix(self):
        """Apply the rules as docs/own_bag.md says; return the messages of the new bag by topic."""
        document = (SOURCE / "docs" / "own_bag.md").read_text(encoding="utf-8")
        command = re.search(r"^rosbag fix -n old\.bag new\.bag .*", document, flags=re.M).group()
        code, text = self.shell.output_of("cd %s && %s" % (self.root, command))
        self.assertEqual(code, 0, text)
        self.assertTrue(self.new.exists(), text)
        with rosbag.Bag(str(self.new)) as bag:
            return {topic: message for topic, message, _ in bag.read_messages()}

    def test_the_rules_hold_the_definitions_of_that_version(self):
        self.assertEqual({name: made._md5sum for name, made in self.classes.items()}, CHECKSUMS)

    def test_rosbag_finds_the_rules_of_an_installed_package(self):
        """It does so where rosdep is initialised."""
        manifest = rospkg.RosPack([str(SOURCE)]).get_manifest("corrsel")
        self.assertEqual(
            manifest.get_export("rosbag", "migration_rule_file"), [str(RULES.relative_to(SOURCE))]
        )

    @needs_conversion
    def test_check_names_what_has_changed(self):
        self.write()
        _, text = self.shell.output_of("rosbag check %s" % self.old)
        for name in CHECKSUMS:
            self.assertIn("corrsel/" + name, text)
        for name in ("Score", "Progress", "cannot"):
            self.assertNotIn(name, text)

    @needs_conversion
    def test_what_was_recorded_is_kept(self):
        written, read = self.write(), self.fix()
        self.assertEqual(set(written), set(read))
        for topic, old in written.items():
            new = read[topic]
            self.assertEqual((new.header.stamp, new.header.frame_id), (STAMP, "left_camera"))
            for name in old.__slots__[1:]:
                value = getattr(old, name)
                stage = name[: -len("_seconds")]
                kept = getattr(new, name) if hasattr(new, name) else getattr(new.seconds, stage)
                if isinstance(value, bytes):
                    self.assertEqual(kept, value, name)
                else:
                    np.testing.assert_array_equal(np.array(kept), np.array(value), name)

    @needs_conversion
    def test_what_was_not_recorded_is_unknown(self):
        self.write()
        read = self.fix()
        matches, selection = read["/correspondences"], read["/selection"]
        for message in (matches, selection):
            self.assertTrue(
                all(np.isnan(value) for value in (message.left_quality.blur, message.right_quality.noise))
            )
        self.assertTrue(np.isnan(matches.seconds.select))
        self.assertEqual(matches.left_camera.model, Camera.MODEL_UNKNOWN)
        self.assertEqual(set(matches.rig_rotation), {0})
        self.assertEqual(len(matches.probability), 0)
        self.assertTrue(np.isnan(selection.confidence) and np.isnan(selection.sigma))
        self.assertEqual(selection.scene, Selection.SCENE_UNKNOWN)
        self.assertEqual((selection.mask_use, selection.guess), (Selection.MASK_UNUSED, Selection.GUESS_NONE))
        self.assertEqual(set(read["/ground_truth"].left_camera), {0})

    @needs_conversion
    def test_the_benchmark_refuses_the_old_bag_with_the_remedy_and_reads_the_new_one(self):
        self.write()
        command = "rosrun corrsel benchmark --bag %s --preselection none --selectors usac --report false --output_dir %s/run_%s"
        code, text = self.shell.output_of(command % (self.old, self.root, "old"))
        self.assertNotEqual(code, 0, text)
        self.assertIn("rosbag fix", text)
        self.fix()
        code, text = self.shell.output_of(command % (self.new, self.root, "new"))
        self.assertEqual(code, 0, text)
        with (self.root / "run_new" / "pairs.csv").open(encoding="utf-8", newline="") as file:
            file.readline()  # the format
            rows = [row for row in csv.DictReader(file) if row["selector"] == "usac"]
        self.assertTrue(rows)
        for row in rows:
            self.assertEqual((row["dataset"], row["sequence"], row["pair"]), ("mine", "drive", "7"))
            self.assertEqual((row["truth"], row["n_inliers_5px"]), ("homography", str(MATCHES // 2)))
            self.assertEqual(row["status"], "ok")


if __name__ == "__main__":
    unittest.main()
