#!/usr/bin/env python3
"""The live nodelets behind and before nodes of other packages: image_proc and stereo_image_proc in front, bags with
loops and jumps of time, cameras that stop, change and publish garbage, and rviz."""

import os
import pathlib
import shutil
import subprocess
import sys
import time
import unittest

import cv2
import numpy as np
import rosbag
import rosgraph
import rospy
from corrsel.msg import Camera, Correspondences, RelativePose, Selection
from diagnostic_msgs.msg import DiagnosticArray
from launched import PATIENCE, LaunchedTest, wait_until
from sensor_msgs.msg import CameraInfo, Image

WIDTH, HEIGHT, SHIFT = 480, 360, 15  # px
FOCAL, BASELINE = 400.0, 0.12  # px, m
DISTORTION = np.array([-0.25, 0.08, 0.001, -0.0005, 0.0])
RATE = 10  # Hz
FILM_RATE = 2  # Hz; slow, so that a busy machine matches every frame with the one before it
PACKAGE = pathlib.Path(__file__).resolve().parents[2]


def has_package(name):
    """Whether a ROS package is installed."""
    return subprocess.run(["rospack", "find", name], stdout=subprocess.DEVNULL, check=False).returncode == 0


def rectified_scene():
    """Grey rectified images of blocks on a plane: the right one is shifted by SHIFT px."""
    random = np.random.RandomState(3)
    image = np.full((HEIGHT + 100, WIDTH + SHIFT + 100), 128, np.uint8)
    for _ in range(900):
        x, y, size = random.randint(WIDTH + 100), random.randint(HEIGHT + 100), random.randint(4, 24)
        image[y : y + size, x : x + size] = random.randint(256)
    return image[:, : WIDTH + 100], image[:, SHIFT : SHIFT + WIDTH + 100]


def matrix():
    """K of both cameras, and the left 3 x 3 part of P."""
    return np.array([[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]])


def raw_image(rectified):
    """What a camera with DISTORTION sees where an ideal one, 50 px larger on every side, sees `rectified`."""
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    pixels = np.stack([x, y], axis=-1).reshape(-1, 1, 2).astype(np.float64)
    ideal = cv2.undistortPoints(pixels, matrix(), DISTORTION, P=matrix()).reshape(HEIGHT, WIDTH, 2) + 50
    return cv2.remap(rectified, ideal.astype(np.float32), None, cv2.INTER_LINEAR)


def camera_info(right):
    """Half of a rig whose images are still distorted."""
    info = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", D=list(DISTORTION))
    info.K, info.R = list(matrix().ravel()), list(np.eye(3).ravel())
    projection = np.hstack([matrix(), [[-FOCAL * BASELINE if right else 0.0], [0], [0]]])
    info.P = list(projection.ravel())
    return info


def image_message(pixels, stamp, frame, encoding="bayer_rggb8"):
    """A grey scene looks the same through every filter, so a Bayer image has the bytes of a grey one."""
    height, width = pixels.shape
    message = Image(width=width, height=height, encoding=encoding, step=width, data=pixels.tobytes())
    message.header.stamp, message.header.frame_id = stamp, frame
    return message


class Rig:
    """Two raw Bayer cameras below a namespace, and somebody who uses what corrsel makes of them."""

    def __init__(self, namespace):
        self.pixels = [raw_image(pixels) for pixels in rectified_scene()]
        self.camera_info = camera_info
        prefix = rospy.names.ns_join("/", namespace) + ("/" if namespace else "")
        names = [prefix + side + "/" for side in ("left", "right")]
        self.images = [rospy.Publisher(name + "image_raw", Image, queue_size=2) for name in names]
        self.infos = [rospy.Publisher(name + "camera_info", CameraInfo, queue_size=2) for name in names]
        self.matches, self.poses, self.selections = [], [], []
        self.subscribers = [
            rospy.Subscriber(prefix + topic, kind, store.append, queue_size=10)
            for topic, kind, store in (
                ("matches", Correspondences, self.matches),
                ("relative_pose", RelativePose, self.poses),
                ("selection", Selection, self.selections),
            )
        ]

    def play(self):
        """Publishes one frame of both cameras and waits for the next one's time."""
        stamp = rospy.Time.now()
        for side, frame in enumerate(("left", "right")):
            message = image_message(self.pixels[side], stamp, frame)
            info = self.camera_info(side == 1)
            info.header = message.header
            self.images[side].publish(message)
            self.infos[side].publish(info)
        time.sleep(1.0 / RATE)

    def matched(self):
        """Plays until matches arrive for a frame taken after this call. Returns the newest ones."""
        begin = rospy.Time.now()

        def arrived():
            return any(len(pair.left_x) > 0 and pair.header.stamp >= begin for pair in self.matches[-5:])

        wait_until(arrived, self.play)
        return self.matches[-1] if arrived() else None

    def close(self):
        """Ends publishers and subscribers."""
        for topic in self.images + self.infos + self.subscribers:
            topic.unregister()


class Pipelines(LaunchedTest):
    """Real nodes of other packages; every test has a namespace of its own."""

    def rig(self, namespace):
        """Cameras that end with the test."""
        rig = Rig(namespace)
        self.addCleanup(rig.close)
        return rig

    def node(self, namespace, *command):
        """Starts a node of another package in a namespace; it ends with the test."""
        process = self.start("rosrun", *command, "__ns:=" + namespace)
        self.addCleanup(self.end, process)
        return process

    def rectifying_node(self, namespace, package, topic):
        """Starts the node that rectifies the images of a namespace, and waits for its topic. Debian 11's image_proc
        does not find its own nodelets, which skips the test."""
        self.node(namespace, package, package)

        def fails():
            return "Could not find library corresponding to plugin image_proc/" in self.text()

        def advertises():
            return any(name == topic for name, _ in rospy.get_published_topics())

        wait_until(lambda: fails() or advertises())
        if fails():
            self.skipTest("image_proc cannot load its own nodelets on this system")

    def assert_shift(self, pair, tolerance):
        """The disparity of the matches is that of the scene, and their rows are equal."""
        x = np.array(pair.left_x) - np.array(pair.right_x)
        y = np.array(pair.left_y) - np.array(pair.right_y)
        self.assertGreater(len(x), 50)
        self.assertAlmostEqual(float(np.median(x)), SHIFT, delta=tolerance)
        self.assertAlmostEqual(float(np.median(y)), 0, delta=tolerance)
        self.assertLess(float(np.percentile(np.abs(x - SHIFT), 90)), 1.5)

    @unittest.skipUnless(has_package("stereo_image_proc"), "stereo_image_proc is missing")
    def test_stereo_image_proc_in_front(self):
        """Bayer images are rectified by stereo_image_proc; camera_info beside them is understood as that of
        rectified images, and the pose is the rig's."""
        self.rectifying_node("front", "stereo_image_proc", "/front/left/image_rect")
        self.launch("front", "live.launch", "features:=orb+orb", "selector:=pose")
        rig = self.rig("front")
        pair = rig.matched()
        self.assertIsNotNone(pair, self.text())
        self.assert_shift(pair, 0.5)
        self.assertEqual(pair.left_camera.model, Camera.MODEL_PINHOLE)
        self.assertEqual(set(pair.left_camera.distortion), {0.0})
        self.assertAlmostEqual(pair.rig_translation[0], -BASELINE)
        self.assertTrue(wait_until(lambda: rig.poses, rig.play), self.text())
        self.assertTrue(rig.poses[-1].scale_known)
        self.assertAlmostEqual(rig.poses[-1].scale, BASELINE)

    def test_raw_bayer_images_need_no_rectification(self):
        """The raw images of the same rig, with their distortion."""
        self.launch(
            "raw",
            "live.launch",
            "features:=orb+orb",
            "selector:=pose",
            "left_image:=left/image_raw",
            "right_image:=right/image_raw",
        )
        rig = self.rig("raw")
        pair = rig.matched()
        self.assertIsNotNone(pair, self.text())
        self.assertGreater(len(pair.left_x), 50)
        self.assertAlmostEqual(pair.left_camera.distortion[0], DISTORTION[0])
        self.assertAlmostEqual(pair.rig_translation[0], -BASELINE)
        shift = np.median(np.array(pair.left_x) - np.array(pair.right_x))
        self.assertAlmostEqual(float(shift), SHIFT, delta=SHIFT * 0.4)  # the lens moves points off the axis

    @unittest.skipUnless(has_package("image_proc"), "image_proc is missing")
    def test_image_proc_in_front_of_a_sequence(self):
        """image_proc rectifies one camera; it stands still, which the matches show."""
        self.rectifying_node("mono/left", "image_proc", "/mono/left/image_rect")
        self.launch("mono", "sequence.launch", "image:=left/image_rect", "features:=orb+orb")
        rig = self.rig("mono")
        pair = rig.matched()
        self.assertIsNotNone(pair, self.text())
        self.assertEqual(set(pair.left_camera.distortion), {0.0})
        self.assertEqual(np.abs(np.array(pair.left_x) - np.array(pair.right_x)).max(), 0)
        self.assertTrue(
            wait_until(
                lambda: rig.selections and rig.selections[-1].scene == Selection.SCENE_AT_REST, rig.play
            ),
            self.text(),
        )

    def write_video(self):
        """A video of 200 s of a scene that moves by 2 px per frame, to the left and back."""
        scene = cv2.cvtColor(rectified_scene()[0], cv2.COLOR_GRAY2BGR)
        path = self.root / "film.avi"
        video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), FILM_RATE, (WIDTH, HEIGHT))
        for number in range(200 * FILM_RATE):
            x = abs(2 * number % 160 - 80)
            video.write(scene[:HEIGHT, x : x + WIDTH])
        video.release()
        return path

    def test_a_webcam_in_front_of_a_sequence(self):
        self.launch("film", "sequence.launch", "image:=/webcam/image_raw", "features:=orb+orb")
        matches = []
        subscriber = rospy.Subscriber("/film/matches", Correspondences, matches.append, queue_size=10)
        self.addCleanup(subscriber.unregister)
        example = str(PACKAGE / "examples" / "webcam_node.py")
        camera = self.start(
            sys.executable, example, "_source:=%s" % self.write_video(), "_rate:=%d" % FILM_RATE
        )
        # Ctrl-C is not used, because rospy of Debian 11 does not always end by it (see tearDownClass).
        self.addCleanup(camera.wait)
        self.addCleanup(camera.kill)

        def motion(pair):
            return float(np.median(np.abs(np.array(pair.left_x) - np.array(pair.right_x))))

        def moved(pair):
            return len(pair.left_x) > 50 and abs(motion(pair) - 2) < 0.5

        found = wait_until(lambda: any(moved(pair) for pair in list(matches)))
        seen = [(len(pair.left_x), motion(pair)) for pair in list(matches) if pair.left_x]
        self.assertTrue(found, "numbers of matches and their motions (px): %s\n%s" % (seen, self.text()))

    def write_bag(self, stamps):
        """A bag with the rig's images at these times (s)."""
        pixels = [raw_image(scene) for scene in rectified_scene()]
        path = self.root / "drive.bag"
        with rosbag.Bag(str(path), "w") as bag:
            for seconds in stamps:
                stamp = rospy.Time.from_sec(seconds)
                for side, frame in enumerate(("left", "right")):
                    message = image_message(pixels[side], stamp, frame, "mono8")
                    info = camera_info(side == 1)
                    info.header = message.header
                    bag.write("/played/%s/image_raw" % frame, message, stamp)
                    bag.write("/played/%s/camera_info" % frame, info, stamp)
        return path

    def test_a_bag_in_a_loop_with_jumps_of_time(self):
        """The clock jumps forward within the bag and back at its end; matches go on, and the jumps are reported."""
        rospy.set_param("/use_sim_time", True)
        self.addCleanup(rospy.delete_param, "/use_sim_time")
        steps = [k / RATE for k in range(12)]
        path = self.write_bag([1000 + step for step in steps] + [1010 + step for step in steps])
        launch = self.launch(
            "played",
            "live.launch",
            "features:=orb+orb",
            "left_image:=left/image_raw",
            "right_image:=right/image_raw",
        )
        rig = self.rig("played")
        complaints = []
        diagnostics = rospy.Subscriber("/diagnostics", DiagnosticArray, complaints.append, queue_size=50)
        self.addCleanup(diagnostics.unregister)
        self.assertTrue(wait_until(lambda: rig.subscribers[0].get_num_connections() > 0), self.text())
        # rosrun becomes the player itself. Debian 11's `rosbag play` does not pass on the SIGINT that ends it.
        player = self.start(
            "rosrun", "rosbag", "play", "--clock", "--loop", "--quiet", "-d", "1", "-s", "0", str(path)
        )
        self.addCleanup(self.end, player)

        def rounds():
            """How often the stamps of the matches went back, with matches of the newest round."""
            stamps = [pair.header.stamp for pair in list(rig.matches) if len(pair.left_x) > 50]
            return sum(later < earlier for earlier, later in zip(stamps, stamps[1:]))

        looped = wait_until(lambda: rounds() >= 2)
        arrived = [(pair.header.stamp.to_sec(), len(pair.left_x)) for pair in list(rig.matches)]
        self.assertTrue(looped, "stamps and numbers of matches: %s\n%s" % (arrived, self.text()))
        stamps = {pair.header.stamp.to_sec() for pair in list(rig.matches)}
        self.assertTrue(any(stamp < 1002 for stamp in stamps) and any(stamp >= 1010 for stamp in stamps))
        self.assertTrue(wait_until(lambda: "time went backwards" in self.text()), self.text())
        self.assertIsNone(launch.poll(), self.text())
        self.assertTrue(complaints, "diagnostics are published under a simulated clock")

    def test_cameras_that_stop_change_and_publish_garbage(self):
        """After each disturbance matches arrive again, from the same process."""
        launch = self.launch(
            "bad",
            "live.launch",
            "features:=orb+orb",
            "left_image:=left/image_raw",
            "right_image:=right/image_raw",
        )
        rig = self.rig("bad")
        self.assertIsNotNone(rig.matched(), self.text())
        time.sleep(3)  # the cameras stop
        self.assertIsNotNone(rig.matched(), self.text())

        good = rig.pixels
        rig.pixels = [np.ascontiguousarray(pixels[20:280, 30:430]) for pixels in good]
        pair = rig.matched()
        self.assertIsNotNone(pair, self.text())
        self.assertEqual((pair.left_width, pair.left_height), (400, 260))
        self.assertEqual(pair.left_camera.model, Camera.MODEL_UNKNOWN, "camera_info is of another size")

        def publish_garbage():
            for time_of in (rospy.Time.now, rospy.Time):
                for encoding, data in (
                    ("32FC1", b""),
                    ("mono8", b"\0" * 7),
                    ("no such encoding", bytes(range(100))),
                ):
                    message = Image(width=10, height=10, encoding=encoding, step=10, data=data)
                    message.header.stamp = time_of()
                    for topic in rig.images:
                        topic.publish(message)
                    time.sleep(1.0 / RATE)

        # Again and again, because ROS drops messages when a queue is full.
        publish_garbage()
        self.assertTrue(wait_until(lambda: ": dropped: image " in self.text(), publish_garbage), self.text())
        rig.pixels = good
        nan = [float("nan")] * 9
        rig.camera_info = lambda _: CameraInfo(
            width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", K=nan
        )
        self.assertTrue(wait_until(lambda: "K is [nan" in self.text(), rig.play), self.text())
        rig.camera_info = camera_info
        pair = rig.matched()
        self.assertIsNotNone(pair, self.text())
        self.assertEqual((pair.left_width, pair.left_height), (WIDTH, HEIGHT))
        self.assertIsNone(launch.poll(), self.text())

    @unittest.skipUnless(
        all(map(shutil.which, ("rviz", "Xvfb", "import"))), "rviz, Xvfb or ImageMagick is missing"
    )
    def test_rviz_shows_poses_tracks_and_matches(self):
        """config/corrsel.rviz: rviz subscribes to what it names, and its window is no blank."""
        display = ":%d" % (self.port % 10000 + 100)
        screen = self.start("Xvfb", display, "-screen", "0", "1280x960x24", "-nolisten", "tcp")
        self.addCleanup(self.end, screen)
        config = PACKAGE / "config" / "corrsel.rviz"
        rviz = self.start(
            "env",
            "DISPLAY=" + display,
            "LIBGL_ALWAYS_SOFTWARE=1",
            "QT_X11_NO_MITSHM=1",
            "rviz",
            "-d",
            str(config),
        )
        self.addCleanup(self.end, rviz)
        self.launch(
            "",
            "sequence.launch",
            "features:=orb+orb",
            "selector:=pose",
            "image:=left/image_raw",
            "tracks:=true",
        )
        rig = self.rig("")
        scene = rectified_scene()[0]
        frames = [raw_image(np.roll(scene, 3 * k, axis=1)) for k in range(20)]

        def walk():
            """The camera moves on to the right."""
            frames.append(frames.pop(0))
            rig.pixels[0] = frames[0]
            rig.play()

        self.assertTrue(wait_until(lambda: rig.matches, walk), self.text())
        master = rosgraph.Master("/test_pipelines")

        def shown():
            subscribed = {
                topic for topic, nodes in master.getSystemState()[1] if any("rviz" in n for n in nodes)
            }
            return {"/matches/image", "/tracks/image", "/pose"} <= subscribed

        self.assertTrue(wait_until(shown, walk), self.text())
        for _ in range(10 * RATE):
            walk()
        picture = self.root / "rviz.png"
        subprocess.run(
            ["import", "-display", display, "-window", "root", str(picture)], check=True, timeout=PATIENCE
        )
        window = cv2.imread(str(picture))
        self.assertGreater(len(np.unique(window.reshape(-1, 3), axis=0)), 100, "the window is blank")
        self.assertIsNone(rviz.poll(), self.text())
        keep = os.environ.get("CORRSEL_PICTURES")
        if keep:
            shutil.copy(str(picture), keep)


if __name__ == "__main__":
    unittest.main()
