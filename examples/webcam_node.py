#!/usr/bin/env python3
"""Publish the images of a webcam, or of a video file, as a camera driver does.

    roscore &
    python3 webcam_node.py &                              # the first camera; or _source:=1, or _source:=video.avi
    roslaunch corrsel sequence.launch image:=/webcam/image_raw view:=true

There is no camera_info, which poses need. The program ends with the video, or when the camera gives no more images.
Needs rospy and OpenCV (Debian's python3-opencv).
"""

import sys

import cv2
import rospy
from sensor_msgs.msg import Image


def frames_of(source):
    """Return the images of a camera, which is given by its number, or of a video file, until they end."""
    capture = cv2.VideoCapture(int(source) if str(source).isdigit() else source)
    if not capture.isOpened():
        sys.exit(
            "webcam_node.py: %s cannot be opened; give the number of a camera or a video as _source" % source
        )
    more, frame = capture.read()
    while more:
        yield frame
        more, frame = capture.read()


def image_message(frame):
    """Return the message of an image, H x W x 3, uint8, in the order blue, green, red."""
    height, width = frame.shape[:2]
    message = Image(height=height, width=width, encoding="bgr8", step=3 * width, data=frame.tobytes())
    message.header.stamp, message.header.frame_id = rospy.Time.now(), "webcam"
    return message


if __name__ == "__main__":
    rospy.init_node("webcam")
    publisher = rospy.Publisher("~image_raw", Image, queue_size=1)
    rate = rospy.Rate(rospy.get_param("~rate", 30.0))  # Hz; a camera that is slower sets the pace itself
    for image in frames_of(rospy.get_param("~source", 0)):
        if rospy.is_shutdown():
            break
        publisher.publish(image_message(image))
        rate.sleep()
