#!/usr/bin/env python3
"""Run a matcher of your own, such as a network, in ROS: images in, corrsel/Correspondences with probabilities out.

    roscore &
    rosrun nodelet nodelet standalone corrsel/Selector &
    python3 network_node.py left/image:=/stereo/left/image_rect right/image:=/stereo/right/image_rect

The Selector then publishes the inliers on `matches`. Replace network() by your own; it gets the pixels and returns arrays.
Needs rospy, message_filters, numpy and corrsel built with ROS.
"""

import time

import message_filters
import rospy
from corrsel import messages
from corrsel.msg import Correspondences
from sensor_msgs.msg import Image


def network(left, right):
    """Return the matches between two images (H x W or H x W x 3, uint8): positions in the left and in the right image,
    px, N x 2, and the confidence of each match, 0 to 1, N. This stand-in matches a grid of points with itself.
    """
    points = [(x, y) for y in range(8, left.shape[0], 16) for x in range(8, left.shape[1], 16)]
    return points, points, [0.5] * len(points)


class NetworkNode:
    """Publishes the matches of every pair of images with equal stamps on `correspondences`."""

    def __init__(self, match=network):
        self.match = match
        self.publisher = rospy.Publisher("correspondences", Correspondences, queue_size=1)
        images = [message_filters.Subscriber(side + "/image", Image) for side in ("left", "right")]
        self.pairs = message_filters.TimeSynchronizer(images, queue_size=5)
        self.pairs.registerCallback(self.process)

    def process(self, left, right):
        """Match a pair of image messages and publish the result."""
        pixels = messages.image(left), messages.image(right)
        begin = time.perf_counter()
        left_points, right_points, confidences = self.match(*pixels)
        seconds = time.perf_counter() - begin
        self.publisher.publish(
            messages.correspondences(
                left_points, right_points, left, right, probability=confidences, seconds=seconds
            )
        )


if __name__ == "__main__":
    rospy.init_node("network")
    NetworkNode()
    rospy.spin()
