#!/usr/bin/env python3
"""A network in a node: examples/network_node.py with a stand-in of two lines, the Selector behind it, and features of a
network with the Matcher behind them. Run by test/launch/network.test."""

import importlib.util
import io
import pathlib
import sys
import threading
import time
import unittest

import numpy as np
import rospy
import rostest
from corrsel import messages
from corrsel.msg import Correspondences, Features, Selection
from sensor_msgs.msg import Image

sys.dont_write_bytecode = True
PATIENCE = 30  # s
EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/network_node.py"
RANDOM = np.random.default_rng(5)
COUNT, INLIERS = 300, 200
LEFT = RANDOM.uniform(10, 470, (COUNT, 2)).astype(np.float32)
RIGHT = np.where(np.arange(COUNT)[:, None] < INLIERS, LEFT + [30, -7], RANDOM.uniform(10, 470, (COUNT, 2)))
CONFIDENCES = np.where(np.arange(COUNT) < INLIERS, 0.9, 0.2).astype(np.float32)


def stand_in(_left, _right):
    """The network of the test."""
    return LEFT, RIGHT, CONFIDENCES


def image(stamp, side):
    """A grey image with a padded row."""
    message = Image(height=480, width=640, encoding="mono8", step=648, data=bytes(648 * 480))
    message.header.stamp, message.header.frame_id = rospy.Time(stamp), side + "_optical"
    return message


class Inbox:
    """The newest message of a topic by its stamp."""

    def __init__(self, topic, kind):
        self.messages, self.changed = {}, threading.Condition()
        self.subscriber = rospy.Subscriber(topic, kind, self.receive, queue_size=100)

    def receive(self, message):
        """Keep a message."""
        with self.changed:
            self.messages[message.header.stamp] = message
            self.changed.notify_all()

    def wait(self, stamp, send):
        """Return the message of this stamp; `send` is called until it comes, as a first message may be too early."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            send()
            with self.changed:
                if self.changed.wait_for(lambda: rospy.Time(stamp) in self.messages, 0.5):
                    return self.messages[rospy.Time(stamp)]
        raise AssertionError("no message with the stamp %g" % stamp)


def example():
    """Return the module of the example."""
    spec = importlib.util.spec_from_file_location("network_node", str(EXAMPLE))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class NetworkNode(unittest.TestCase):
    """Messages in and out."""

    def test_matches_of_a_network_are_selected_by_their_probability(self):
        """The node's message holds what the network returned, and the Selector keeps the inliers."""
        putative, selections = Inbox("correspondences", Correspondences), Inbox("selection", Selection)
        publishers = [rospy.Publisher(side + "/image", Image, queue_size=5) for side in ("left", "right")]
        self.addCleanup(putative.subscriber.unregister)
        example().NetworkNode(stand_in)

        def send():
            for publisher, side in zip(publishers, ("left", "right")):
                publisher.publish(image(10, side))

        begin = time.monotonic()
        message = putative.wait(10, send)
        elapsed = time.monotonic() - begin
        np.testing.assert_array_equal(np.stack([message.left_x, message.left_y], 1), LEFT)
        np.testing.assert_array_equal(
            np.stack([message.right_x, message.right_y], 1), RIGHT.astype(np.float32)
        )
        np.testing.assert_array_equal(np.float32(message.probability), CONFIDENCES)
        self.assertEqual((len(message.distance), len(message.left_index), len(message.left_frame)), (0, 0, 0))
        self.assertEqual((message.left_width, message.right_height), (640, 480))
        self.assertEqual((message.header.frame_id, message.right_frame_id), ("left_optical", "right_optical"))
        self.assertEqual(message.right_stamp, rospy.Time(10))
        self.assertTrue(0 <= message.seconds.match < elapsed and np.isnan(message.seconds.detect))
        self.assertTrue(np.isnan(message.rig_rotation).all() and message.left_camera.model == 0)
        selection = selections.wait(10, send)
        self.assertEqual((selection.status, selection.n_input), (Selection.STATUS_OK, COUNT))
        self.assertEqual(selection.message, "", "the samples are drawn by the probabilities")
        mask = np.frombuffer(bytes(selection.mask), np.uint8)
        self.assertTrue(mask[:INLIERS].all())
        self.assertLess(mask[INLIERS:].sum(), 5)

    def test_features_of_a_network_are_matched(self):
        """The Matcher nodelet compares descriptors of 16 bits; the features of the right image have another order."""
        order = RANDOM.permutation(COUNT)
        descriptors = RANDOM.standard_normal((COUNT, 64)).astype(np.float16)
        found = Inbox("by_features/correspondences", Correspondences)
        publishers = [
            rospy.Publisher("by_features/%s/features" % side, Features, queue_size=5)
            for side in ("left", "right")
        ]
        left = messages.features(
            LEFT, descriptors, image(20, "left"), "net", scores=CONFIDENCES, seconds=0.25
        )
        right = messages.features(RIGHT[order], descriptors[order], image(20, "right"), "net", seconds=0.5)

        def send():
            publishers[0].publish(left)
            publishers[1].publish(right)

        message = found.wait(20, send)
        self.assertEqual(len(message.left_x), COUNT)
        np.testing.assert_array_equal(order[list(message.right_index)], np.arange(COUNT))
        np.testing.assert_array_equal(message.distance, np.zeros(COUNT))
        self.assertTrue((np.array(message.second_distance) > 1).all())
        np.testing.assert_array_equal(message.right_x, RIGHT[:, 0].astype(np.float32))
        self.assertEqual((message.features, message.left_width, message.n_left_features), ("net", 640, COUNT))
        self.assertAlmostEqual(message.seconds.detect, 0.75)
        self.assertEqual(message.right_frame_id, "right_optical")

    def test_the_node_costs_little_beyond_the_network(self):
        """With 2000 matches, the node takes a fraction of the processor time of a loop over the matches. Both are measured
        by turns, because the speed of the machine may change."""
        left, right = RANDOM.uniform(0, 480, (2, 2000, 2)).astype(np.float32)
        confidences = RANDOM.uniform(0, 1, 2000).astype(np.float32)
        node = example().NetworkNode(lambda _left, _right: (left, right, confidences))
        deadline = time.monotonic() + PATIENCE
        while node.publisher.get_num_connections() != 1 and time.monotonic() < deadline:
            time.sleep(0.05)  # the Selector alone listens
        pair = image(30, "left"), image(30, "right")

        def loop():
            """Fill a message as rospy's own classes do it, one number after the other, and serialize it."""
            message = Correspondences()
            for x, y in left:
                message.left_x.append(x)
                message.left_y.append(y)
            for x, y in right:
                message.right_x.append(x)
                message.right_y.append(y)
            for confidence in confidences:
                message.probability.append(confidence)
            message.serialize(io.BytesIO())

        def seconds(work):
            begin = time.thread_time()
            work()
            return time.thread_time() - begin

        node_time, loop_time = [], []
        for _ in range(100):
            node_time.append(seconds(lambda: node.process(*pair)))
            loop_time.append(seconds(loop))
            time.sleep(0.002)
        medians = 1000 * np.median(node_time), 1000 * np.median(loop_time)
        print("2000 matches: the node takes %.3f ms of processor time, a loop %.3f ms" % medians)
        self.assertLess(medians[0], 0.5 * medians[1])

    def test_wrong_arrays_are_named(self):
        """What a network returned in another form."""
        here = image(1, "left"), image(1, "right")
        for arguments, known, text in (
            ((LEFT, RIGHT[1:]), {}, r"right has the shape \(299, 2\); needed: \(300, 2\)"),
            ((LEFT, RIGHT), {"probability": [0.5]}, r"probability has the shape \(1,\); needed: \(300,\)"),
            ((LEFT, RIGHT), {"probability": 2 * CONFIDENCES}, "probability holds a number outside 0 to 1"),
        ):
            with self.assertRaisesRegex(ValueError, text):
                messages.correspondences(*arguments, *here, **known)
        with self.assertRaisesRegex(TypeError, "unknown keyword scores"):
            messages.correspondences(LEFT, RIGHT, *here, scores=CONFIDENCES)
        with self.assertRaisesRegex(ValueError, r"descriptors has the shape \(5, 8\) and the type int64"):
            messages.features(LEFT, np.zeros((5, 8), np.int64), here[0], "net")
        with self.assertRaisesRegex(ValueError, "binary descriptors have the type float32; needed: uint8"):
            messages.features(LEFT, np.zeros((COUNT, 8), np.float32), here[0], "net", binary=True)
        empty = messages.correspondences([], [], *here)
        self.assertEqual(empty.left_x.shape, (0,))
        here[0].encoding = "yuv422"
        with self.assertRaisesRegex(ValueError, "image encoding 'yuv422' is not one of mono8"):
            messages.image(here[0])
        here[1].data = bytes(5)
        with self.assertRaisesRegex(ValueError, "has 5 bytes; needed: 311040"):
            messages.image(here[1])
        colours = Image(height=2, width=1, encoding="bgr8", step=4, data=bytes(range(8)))
        np.testing.assert_array_equal(messages.image(colours), [[[0, 1, 2]], [[4, 5, 6]]])


if __name__ == "__main__":
    rospy.init_node("network_test")
    rostest.rosrun("corrsel", "network_test", NetworkNode, sys.argv)
