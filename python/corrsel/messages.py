"""Make corrsel/Features and corrsel/Correspondences messages of arrays, for nodes that run a network.

    import rospy
    from corrsel import messages
    from corrsel.msg import Correspondences

    publisher = rospy.Publisher("correspondences", Correspondences, queue_size=1)
    publisher.publish(messages.correspondences(left_points, right_points, left_image, right_image, probability=scores))

The arrays are sent as they are, without a loop over matches, and no cv_bridge is needed for images of 8 bits.
examples/network_node.py is a complete node.
"""

import math

import numpy as np
from corrsel.msg import Correspondences, Features
from rospy.numpy_msg import numpy_msg

#: Messages whose arrays are numpy's. They are sent on topics of the plain types.
_Correspondences, _Features = numpy_msg(Correspondences), numpy_msg(Features)

_STAGES = ("wait", "detect", "describe", "match", "select", "publish")
_TYPES = {
    np.dtype(np.uint8): Features.DESCRIPTOR_UINT8,
    np.dtype(np.int8): Features.DESCRIPTOR_INT8,
    np.dtype(np.float16): Features.DESCRIPTOR_FLOAT16,
    np.dtype(np.float32): Features.DESCRIPTOR_FLOAT32,
    np.dtype(np.float64): Features.DESCRIPTOR_FLOAT64,
}
_CHANNELS = {"mono8": 1, "8UC1": 1, "bgr8": 3, "rgb8": 3, "8UC3": 3}


class _Sent(np.ndarray):
    """An array of a message. genpy calls tostring(), which numpy 1.19 deprecates, with a warning that costs more than the
    copy, and numpy 2.3 lacks."""

    def tostring(self, order="C"):
        """Return the bytes."""
        return self.tobytes(order)


def image(msg):
    """Return the pixels of a sensor_msgs/Image as an array that shares the message's memory: H x W or H x W x 3, uint8.

    Raises ValueError for encodings other than mono8, bgr8, rgb8, 8UC1 and 8UC3, and for data that do not fit the header.
    """
    channels = _CHANNELS.get(msg.encoding)
    if channels is None:
        raise ValueError(
            "image encoding '%s' is not one of %s; convert it with cv_bridge"
            % (msg.encoding, ", ".join(_CHANNELS))
        )
    if len(msg.data) != msg.step * msg.height or msg.step < msg.width * channels:
        raise ValueError(
            "image of %dx%d px, %s, step %d has %d bytes; needed: %d"
            % (msg.width, msg.height, msg.encoding, msg.step, len(msg.data), msg.step * msg.height)
        )
    rows = np.frombuffer(msg.data, np.uint8).reshape(msg.height, msg.step)[:, : msg.width * channels]
    return rows if channels == 1 else rows.reshape(msg.height, msg.width, channels)


def correspondences(left, right, left_image, right_image, *, probability=None, distance=None, **known):
    """Return a message with N putative matches, for the topic that the Selector nodelet reads.

    left, right     positions, px, (x, y) with the origin at the centre of the first pixel: N x 2
    left_image, right_image   the sensor_msgs/Image messages: their headers and sizes become those of the message
    probability     of the matcher: that the match is right, 0 to 1, NaN where it is not known: N
    distance        descriptor distances to the nearest neighbour: N
    known           second_distance (N), left_index, right_index (N), features (what has made the matches, a text),
                    seconds (wall time of the matcher)

    The cameras are unknown. Where they are calibrated, fill left_camera and right_camera before the message is published:
    message.left_camera.model = Camera.MODEL_PINHOLE, message.left_camera.matrix[:] = K.ravel()...

    Raises ValueError that names an array of another shape, or a probability outside 0 to 1; TypeError for another
    keyword.
    """
    message = _Correspondences()
    count = len(left)
    message.left_x, message.left_y = _positions("left", left, count)
    message.right_x, message.right_y = _positions("right", right, count)
    message.probability = _column("probability", probability, count)
    if ((message.probability < 0) | (message.probability > 1)).any():
        raise ValueError("probability holds a number outside 0 to 1")
    message.distance = _column("distance", distance, count)
    message.second_distance = _column("second_distance", known.pop("second_distance", None), count)
    for name in ("left_index", "right_index"):
        setattr(message, name, _column(name, known.pop(name, None), count, np.uint32))
    message.left_frame = message.right_frame = _column("frame", None, count)
    message.features = known.pop("features", "network")
    for stage in _STAGES:
        setattr(message.seconds, stage, math.nan)
    message.seconds.match = known.pop("seconds", math.nan)
    if known:
        raise TypeError("unknown keyword %s" % ", ".join(sorted(known)))
    message.header = left_image.header
    message.right_stamp, message.right_frame_id = right_image.header.stamp, right_image.header.frame_id
    message.left_width, message.left_height = left_image.width, left_image.height
    message.right_width, message.right_height = right_image.width, right_image.height
    message.rig_rotation, message.rig_translation = _numbers(9, math.nan), _numbers(3, math.nan)
    message.guess_rotation, message.guess_translation = _numbers(9, math.nan), _numbers(3, math.nan)
    message.guess_sigma = math.nan
    for quality in (message.left_quality, message.right_quality):
        for number in quality.__slots__:
            setattr(quality, number, math.nan)
    for camera in (message.left_camera, message.right_camera):
        _leave_unknown(camera)
    return message


def features(
    positions, descriptors, of_image, name, *, scores=None, sizes=None, angles=None, binary=False, **known
):
    """Return a message with the features of an image, for the topics that the Matcher nodelet reads.

    positions     px, (x, y) with the origin at the centre of the first pixel: N x 2
    descriptors   N x D, of uint8, int8, float16, float32 or float64. With float16, messages are half as large
    of_image      the sensor_msgs/Image message: its header and size become those of the message
    name          what has made them, e.g. "superpoint": only features of one name are matched with each other
    scores        of the detector, higher is better: N
    sizes, angles diameters, px, and degrees as in cv2.KeyPoint: N
    binary        whether descriptors of uint8 are bits, compared by the Hamming distance instead of L2
    known         seconds (wall time of finding the features)

    Raises ValueError that names an array of another shape or type; TypeError for another keyword.
    """
    message = _Features()
    count = len(positions)
    message.x, message.y = _positions("positions", positions, count)
    message.score = _column("scores", scores, count)
    message.size, message.angle = _column("sizes", sizes, count), _column("angles", angles, count)
    descriptors = np.ascontiguousarray(descriptors)
    if descriptors.ndim != 2 or len(descriptors) != count or descriptors.dtype not in _TYPES:
        raise ValueError(
            "descriptors has the shape %s and the type %s; needed: (%d, D) of %s"
            % (descriptors.shape, descriptors.dtype, count, ", ".join(str(kind) for kind in _TYPES))
        )
    if binary and descriptors.dtype != np.uint8:
        raise ValueError("binary descriptors have the type %s; needed: uint8" % descriptors.dtype)
    message.descriptor_type = Features.DESCRIPTOR_BINARY if binary else _TYPES[descriptors.dtype]
    message.descriptor_length = descriptors.shape[1]
    message.descriptors = descriptors.tobytes()
    message.features = name
    message.seconds = known.pop("seconds", math.nan)
    if known:
        raise TypeError("unknown keyword %s" % ", ".join(sorted(known)))
    message.header = of_image.header
    message.width, message.height = of_image.width, of_image.height
    _leave_unknown(message.camera)
    return message


def _positions(name, values, count):
    """Return the columns of positions."""
    array = np.asarray(values, np.float32)
    if count == 0:
        array = array.reshape(0, 2)
    if array.shape != (count, 2):
        raise ValueError("%s has the shape %s; needed: (%d, 2)" % (name, array.shape, count))
    return np.ascontiguousarray(array.T).view(_Sent)


def _column(name, values, count, dtype=np.float32):
    """Return an optional column; it is empty where it is absent."""
    if values is None:
        return np.empty(0, dtype).view(_Sent)
    array = np.ascontiguousarray(values, dtype)
    if array.shape != (count,):
        raise ValueError("%s has the shape %s; needed: (%d,)" % (name, array.shape, count))
    return array.view(_Sent)


def _numbers(count, value):
    """Return an array of fixed length."""
    array = np.empty(count)
    array.fill(value)
    return array.view(_Sent)


def _leave_unknown(camera):
    camera.matrix, camera.distortion = _numbers(9, 0), _numbers(8, 0)
