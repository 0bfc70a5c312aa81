#!/usr/bin/env python3
"""Tests of scripts/kitti_to_bag.py: python3 test_kitti_to_bag.py"""
import contextlib
import io
import pathlib
import struct
import sys
import tempfile
import unittest
import zlib

import genpy
import rosbag

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import kitti_to_bag  # noqa: E402  (found through the path above)

WIDTH, HEIGHT = 20, 10
IDENTITY = "1 0 0 0 1 0 0 0 1"
CALIBRATION = """calib_time: 09-Jan-2012 13:58:50
S_00: 20 10
K_00: 15 0 10 0 15 5 0 0 1
D_00: -0.3 0.2 0.001 0.002 -0.07
R_rect_00: {r}
P_rect_00: 14 0 10 0 0 14 5 0 0 0 1 0
S_01: 20 10
K_01: 16 0 10 0 16 5 0 0 1
D_01: -0.2 0.1 0 0 0
R_rect_01: {r}
P_rect_01: 14 0 10 -7.5 0 14 5 0 0 0 1 0
""".format(
    r=IDENTITY
)


def png(value, width=WIDTH, height=HEIGHT):
    """The bytes of a grey PNG file."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    pixels = (b"\0" + bytes([value]) * width) * height
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(pixels))
        + chunk(b"IEND", b"")
    )


class KittiToBag(unittest.TestCase):
    """The script on a made-up folder of three frames."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name) / "frames"
        self.folder.mkdir()
        self.bag = pathlib.Path(self.temporary.name) / "kitti.bag"
        (self.folder / "calib_cam_to_cam.txt").write_text(CALIBRATION, encoding="utf-8")
        for i in range(3):
            (self.folder / ("left_%010d.png" % i)).write_bytes(png(10 * i))
            (self.folder / ("right_%010d.png" % i)).write_bytes(png(10 * i + 1))

    def convert(self, *arguments):
        """Exit status and output of the script."""
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
            code = kitti_to_bag.main([str(self.folder), "--output", str(self.bag), *arguments])
        return code, text.getvalue()

    def messages(self):
        """(topic, message, time) of the bag."""
        with rosbag.Bag(str(self.bag)) as bag:
            return list(bag.read_messages())

    def expect_error(self, *parts):
        """The script refuses with a message and leaves no file."""
        code, text = self.convert()
        self.assertEqual(code, 2, text)
        for part in parts:
            self.assertIn(part, text)
        self.assertEqual(list(self.bag.parent.glob("*.bag*")), [])

    def test_images_are_the_files(self):
        """Every frame has four messages of one stamp, 10 a second."""
        code, text = self.convert()
        self.assertEqual((code, text), (0, "3 frames written to %s\n" % self.bag))
        messages = self.messages()
        self.assertEqual(len(messages), 12)
        for i in range(3):
            stamp = genpy.Time(1, i * 10**8)
            frame = {topic: message for topic, message, time in messages if time == stamp}
            self.assertEqual(len(frame), 4)
            for side, value in (("left", 10 * i), ("right", 10 * i + 1)):
                image = frame["/stereo/%s/image_raw/compressed" % side]
                self.assertEqual(image.data, png(value))
                self.assertEqual(image.format, "png")
                for message in (image, frame["/stereo/%s/camera_info" % side]):
                    self.assertEqual(message.header.stamp, stamp)
                    self.assertEqual(message.header.frame_id, side + "_camera_optical")

    def test_calibration_of_each_camera(self):
        """K, D, R and P are those of the file."""
        self.convert()
        infos = {topic: message for topic, message, _ in self.messages() if topic.endswith("camera_info")}
        left, right = infos["/stereo/left/camera_info"], infos["/stereo/right/camera_info"]
        self.assertEqual((left.width, left.height, left.distortion_model), (WIDTH, HEIGHT, "plumb_bob"))
        self.assertEqual(list(left.D), [-0.3, 0.2, 0.001, 0.002, -0.07])
        self.assertEqual(list(left.K), [15, 0, 10, 0, 15, 5, 0, 0, 1])
        self.assertEqual(list(left.R), [1, 0, 0, 0, 1, 0, 0, 0, 1])
        self.assertEqual(list(right.K), [16, 0, 10, 0, 16, 5, 0, 0, 1])
        self.assertEqual(list(right.P), [14, 0, 10, -7.5, 0, 14, 5, 0, 0, 0, 1, 0])

    def test_same_files_give_the_same_messages(self):
        """Nothing of the time of conversion is in the bag."""
        self.convert()
        first = self.bag.read_bytes()
        self.convert()
        self.assertEqual(self.bag.read_bytes(), first)

    def test_rate_and_every(self):
        """Every second frame, five a second."""
        code, text = self.convert("--rate", "5", "--every", "2")
        self.assertEqual(code, 0, text)
        images = [entry for entry in self.messages() if "left/image_raw" in entry[0]]
        self.assertEqual([time.to_nsec() for _, _, time in images], [10**9, 12 * 10**8])
        self.assertEqual(images[1][1].data, png(20))
        for arguments in (("--rate", "0"), ("--rate", "nan"), ("--every", "0"), ("--every", "1" * 20)):
            code, text = self.convert(*arguments)
            self.assertEqual(code, 2, text)
            self.assertIn("=", text)

    def test_missing_right_image(self):
        """It is named, and the bag is not half made."""
        (self.folder / "right_0000000001.png").unlink()
        self.expect_error("right_0000000001.png is missing, the right image of left_0000000001.png")

    def test_missing_folder_images_and_calibration(self):
        """Each is named."""
        (self.folder / "calib_cam_to_cam.txt").rename(self.folder / "calib.txt")
        self.expect_error("calib_cam_to_cam.txt is missing")
        for file in self.folder.glob("left_*"):
            file.unlink()
        self.expect_error("has no left_*.png")
        self.folder = self.folder / "nowhere"
        self.expect_error("nowhere is not a folder")

    def test_broken_calibration(self):
        """The entry is named, whether absent, too short or no number."""
        file = self.folder / "calib_cam_to_cam.txt"
        for old, new in (("P_rect_01:", "P_rect_09:"), ("-7.5", ""), ("-7.5", "x"), ("-7.5", "nan")):
            file.write_text(CALIBRATION.replace(old, new), encoding="utf-8")
            self.expect_error("calib_cam_to_cam.txt: P_rect_01 is missing or is not 12 numbers")

    def test_rectified_frames_are_refused(self):
        """Frames of another size than the calibration's are not raw."""
        (self.folder / "left_0000000002.png").write_bytes(png(0, WIDTH - 1))
        self.expect_error("left_0000000002.png has 19x10 px, its calibration is for 20x10 px", "unrectified")

    def test_other_files_are_not_images(self):
        """A file that is named .png but is none."""
        (self.folder / "right_0000000000.png").write_bytes(b"text")
        self.expect_error("right_0000000000.png is not a PNG file")

    def test_output_that_cannot_be_written(self):
        """The folder does not exist."""
        self.bag = self.bag.parent / "no" / "such" / "folder.bag"
        self.expect_error("cannot write", "folder.bag")


if __name__ == "__main__":
    unittest.main()
