#!/usr/bin/env python3
"""live.launch as a robot runs it: what dies comes back, and what is recorded is read by the benchmark."""

import os
import pathlib
import re
import signal
import subprocess
import time
import unittest

import numpy as np
import rosbag
import rospy
from corrsel import matches
from corrsel.msg import Camera, Correspondences, Tracks
from launched import PATIENCE, LaunchedTest
from sensor_msgs.msg import CameraInfo, Image

WIDTH, HEIGHT, SHIFT = 320, 240, 12  # px
RATE = 10  # Hz


def scene(seed):
    """A left and a right image of blocks on a plane: the right one is shifted by SHIFT px."""
    random = np.random.RandomState(seed)
    image = np.full((HEIGHT, WIDTH + SHIFT), 128, np.uint8)
    for _ in range(250):
        x, y, size = random.randint(WIDTH), random.randint(HEIGHT), random.randint(4, 24)
        image[y : y + size, x : x + size] = random.randint(256)
    return image[:, :WIDTH], image[:, SHIFT:]


def camera_info(right):
    """Half of a rectified rig with a baseline of 0.1 m."""
    matrix = [300, 0, WIDTH / 2, 0, 300, HEIGHT / 2, 0, 0, 1]
    projection = [300, 0, WIDTH / 2, -30.0 if right else 0.0, 0, 300, HEIGHT / 2, 0, 0, 0, 1, 0]
    info = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", K=matrix, P=projection)
    info.D, info.R = [0] * 5, [1, 0, 0, 0, 1, 0, 0, 0, 1]
    return info


class Cameras:
    """A pair of cameras below a namespace, and somebody who uses the matches."""

    def __init__(self, namespace):
        def publisher(topic, kind):
            return rospy.Publisher("/%s/%s" % (namespace, topic), kind, queue_size=2)

        self.images = [publisher(side + "/image_rect", Image) for side in ("left", "right")]
        self.infos = [publisher(side + "/camera_info", CameraInfo) for side in ("left", "right")]
        self.newest = rospy.Time()  # stamp of the newest frame for which matches arrived
        topic = "/%s/matches" % namespace
        self.matches = rospy.Subscriber(topic, Correspondences, self._receive, queue_size=10)

    def _receive(self, message):
        if len(message.left_x) > 0:
            self.newest = max(self.newest, message.header.stamp)

    def play(self):
        """Publishes one frame of both cameras and waits for the next one's time."""
        stamp = rospy.Time.now()
        for side, (publisher, pixels) in enumerate(zip(self.images, scene(3))):
            image = Image(width=WIDTH, height=HEIGHT, encoding="mono8", step=WIDTH, data=pixels.tobytes())
            image.header.stamp, image.header.frame_id = stamp, ("left", "right")[side]
            publisher.publish(image)
            info = camera_info(side == 1)
            info.header = image.header
            self.infos[side].publish(info)
        time.sleep(1.0 / RATE)

    def answered(self):
        """Plays until matches arrive for a frame taken after this call. Returns whether they did."""
        begin, deadline = rospy.Time.now(), time.monotonic() + PATIENCE
        while self.newest < begin and time.monotonic() < deadline:
            self.play()
        return self.newest >= begin

    def close(self):
        """Ends publishers and subscriber."""
        for topic in self.images + self.infos + [self.matches]:
            topic.unregister()


class LiveLaunch(LaunchedTest):
    """One master for all tests; every test has a namespace of its own."""

    def live(self, namespace, *arguments, file="live.launch"):
        """Starts a launch file and returns the process and its cameras; both end with the test."""
        launch = self.launch(namespace, file, "features:=orb+orb", "selector:=gms", *arguments)
        cameras = Cameras(namespace)
        self.addCleanup(cameras.close)
        return launch, cameras

    def pid_of(self, launch, name, other_than=None):
        """The process of a node among the children of roslaunch; waits for one other than the pid given."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            for entry in pathlib.Path("/proc").glob("[0-9]*"):
                try:
                    parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
                    arguments = (entry / "cmdline").read_text().split("\0")
                except (OSError, IndexError):  # it has just ended
                    continue
                pid = int(entry.name)
                if parent == launch.pid and "__name:=" + name in arguments and pid != other_than:
                    return pid
            time.sleep(0.1)
        self.fail("no process of %s: %s" % (name, self.text()))

    def kill(self, launch, name):
        """Kills a node as a crash does; returns once its successor runs."""
        pid = self.pid_of(launch, name)
        os.kill(pid, signal.SIGKILL)
        self.pid_of(launch, name, other_than=pid)

    def settle(self, launch, name, cameras):
        """Plays until a loader's process lives for longer than the 4 s after which a manager notices the death
        of the one before, takes the nodelet away, and accepts it anew."""
        pid, since = self.pid_of(launch, name), time.monotonic()
        deadline = since + PATIENCE
        while time.monotonic() < min(since + 8, deadline):
            cameras.play()
            now = self.pid_of(launch, name)
            if now != pid:
                pid, since = now, time.monotonic()
        self.assertLess(time.monotonic(), deadline, self.text())

    def test_a_killed_process_comes_back_with_its_nodelets(self):
        """Matches arrive again, also when it dies right after its first result."""
        launch, cameras = self.live("together", "respawn:=true")
        for _ in range(3):
            self.assertTrue(cameras.answered(), self.text())
            self.kill(launch, "corrsel_manager")
        self.assertTrue(cameras.answered(), self.text())
        self.assertIsNone(launch.poll())

    def test_another_manager_gets_its_nodelets_back(self):
        """Matches arrive again after the manager, and after a loader, was killed."""

        def manager():
            process = self.start(
                "rosrun", "nodelet", "nodelet", "manager", "__name:=cameras", "__ns:=managed"
            )
            self.addCleanup(self.end, process)
            return process

        robot = manager()
        launch, cameras = self.live("managed", "respawn:=true", "load_manager:=false", "manager:=cameras")
        self.assertTrue(cameras.answered(), self.text())
        self.settle(launch, "feature_matcher", cameras)  # the bond is watched from its second heartbeat on
        robot.kill()
        robot.wait()
        manager()
        self.assertTrue(cameras.answered(), self.text())
        self.kill(launch, "selector")
        self.settle(launch, "selector", cameras)
        self.assertTrue(cameras.answered(), self.text())
        self.assertIsNone(launch.poll())

    def test_standalone_nodelets_respawn(self):
        """Every nodelet is a process of its own and comes back alone."""
        launch, cameras = self.live("alone", "respawn:=true", "standalone:=true")
        self.assertTrue(cameras.answered(), self.text())
        for victim in ("selector", "feature_matcher"):
            self.kill(launch, victim)
            self.assertTrue(cameras.answered(), "after the death of %s: %s" % (victim, self.text()))

    def test_a_sequence_is_matched_with_earlier_frames_and_drawn(self):
        """sequence.launch: the newest frame is the left one; matches/image comes from the same launch file."""
        _, cameras = self.live(
            "walk",
            "image:=left/image_rect",
            "step:=2",
            "tracks:=true",
            "tracks_file:=tracks.csv",
            file="sequence.launch",
        )
        pairs, drawn, tracks = [], [], []
        topics = [
            rospy.Subscriber("/walk/tracks", Tracks, tracks.append, queue_size=10),
            rospy.Subscriber("/walk/matches", Correspondences, pairs.append, queue_size=10),
            rospy.Subscriber("/walk/matches/image", Image, drawn.append, queue_size=10),
        ]
        for topic in topics:
            self.addCleanup(topic.unregister)
        self.assertTrue(cameras.answered(), self.text())
        self.assertTrue(all(pair.right_stamp < pair.header.stamp for pair in pairs))
        self.assertEqual(
            pairs[-1].left_camera.model, Camera.MODEL_PINHOLE, "camera_info lies beside the image"
        )
        # The earlier frame may have come before the first camera_info.
        deadline = time.monotonic() + PATIENCE
        while pairs[-1].right_camera != pairs[-1].left_camera and time.monotonic() < deadline:
            cameras.play()
        self.assertEqual(pairs[-1].right_camera, pairs[-1].left_camera)
        deadline = time.monotonic() + PATIENCE
        while not (drawn and tracks) and time.monotonic() < deadline:
            cameras.play()
        self.assertTrue(drawn, self.text())
        self.assertEqual((drawn[0].width, drawn[0].height), (2 * WIDTH, HEIGHT))
        self.assertTrue(tracks, self.text())
        self.assertGreater(len(tracks[-1].id), 20)
        self.assertGreater(len(matches.tracks(self.root / "tracks.csv")), 20)

    def record(self, namespace, prefix):
        """Records some frames with live.launch and returns the bag."""
        launch, cameras = self.live(namespace, "record:=true", "bag:=" + prefix)
        deadline = time.monotonic() + PATIENCE
        active = []
        while not active and time.monotonic() < deadline:  # the recorder runs
            active = list(self.root.glob(prefix + "_*.bag.active"))
            cameras.play()
        self.assertTrue(active, self.text())
        for _ in range(3):
            self.assertTrue(cameras.answered(), self.text())
        self.end(launch)
        bags = list(self.root.glob(prefix + "_*.bag"))
        self.assertEqual(len(bags), 1, self.text())
        return bags[0]

    def benchmark(self, *arguments):
        """Runs the benchmark; returns its exit code and what it printed."""
        result = subprocess.run(
            ["rosrun", "corrsel", "benchmark", *arguments],
            cwd=self.root,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=4 * PATIENCE,
            check=False,
        )
        return result.returncode, result.stdout

    def test_a_recording_is_evaluated_by_the_benchmark(self):
        """Correspondences, matches, selections and camera_info are in the bag; gms is evaluated on it."""
        path = self.record("recorded", "drive")
        with rosbag.Bag(str(path)) as bag:
            topics = bag.get_type_and_topic_info().topics
            found = [message for _, message, _ in bag.read_messages(topics=["correspondences"])]
        self.assertEqual(found[-1].right_camera.model, Camera.MODEL_PINHOLE)
        self.assertAlmostEqual(found[-1].rig_translation[0], -0.1)
        for name, kind in (
            ("correspondences", "corrsel/Correspondences"),
            ("matches", "corrsel/Correspondences"),
            ("selection", "corrsel/Selection"),
            ("left/camera_info", "sensor_msgs/CameraInfo"),
            ("right/camera_info", "sensor_msgs/CameraInfo"),
        ):
            self.assertIn(name, topics)
            self.assertEqual(topics[name].msg_type, kind)

        folder = self.root / "evaluated"
        arguments = ["--bag", path.name, "--selectors", "gms,ransac", "--output-dir", str(folder)]
        code, text = self.benchmark(*arguments)
        self.assertEqual(code, 0, text)
        self.assertIn("the matches are those on correspondences", text)
        self.assertIn("are evaluated with camera_info on left/camera_info", text)
        rows = (folder / "pairs.csv").read_text(encoding="utf-8").splitlines()[1:]
        header = rows[0].split(",")
        evaluated = [dict(zip(header, row.split(","))) for row in rows[1:]]
        best = [row for row in evaluated if row["selector"] == "gms"]
        self.assertGreater(len(best), 0)
        for row in best:
            self.assertEqual(row["features"], "given")
            self.assertGreater(int(row["n_putative"]), 50, row)
            self.assertGreater(int(row["n_correct_5px"]), 0.9 * int(row["n_selected"]), row)
        self.assertTrue((folder / "report.html").exists())

    def test_a_recording_without_truth_is_counted_and_timed(self):
        """No precision and no recall, but numbers of matches, times, a report, and a folder that compares."""
        path = self.record("untrue", "blind")
        bare = self.root / "bare.bag"
        with rosbag.Bag(str(path)) as source, rosbag.Bag(str(bare), "w") as target:
            for topic, message, stamp in source.read_messages(topics=["correspondences"]):
                target.write(topic, message, stamp)
        folder = self.root / "counted"
        code, text = self.benchmark("--bag", bare.name, "--selectors", "gms", "--output-dir", str(folder))
        self.assertEqual(code, 0, text)
        self.assertIn("no precision and no recall", text)
        rows = (folder / "pairs.csv").read_text(encoding="utf-8").splitlines()[1:]
        header = rows[0].split(",")
        row = dict(zip(header, rows[1].split(",")))
        self.assertGreater(int(row["n_putative"]), 50)
        self.assertGreater(int(row["n_selected"]), 20)
        self.assertEqual((row["truth"], row["n_inliers_5px"], row["n_correct_5px"]), ("none", "", ""))
        self.assertGreater(float(row["select_s"]), 0)
        self.assertTrue((folder / "report.html").exists())
        compared = subprocess.run(
            ["rosrun", "corrsel", "compare_runs", str(folder), str(folder)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        self.assertEqual(compared.returncode, 0, compared.stdout)

    def test_a_killed_recording_says_how_to_repair_it(self):
        """The file that is left behind has no index: the message names rosbag reindex, which helps."""
        launch, cameras = self.live("killed", "record:=true", "bag:=broken")
        deadline = time.monotonic() + PATIENCE
        active = []
        while not active and time.monotonic() < deadline:
            active = list(self.root.glob("broken_*.bag.active"))
            cameras.play()
        self.assertTrue(active, self.text())
        while active[0].stat().st_size < 1 << 20 and time.monotonic() < deadline:  # a chunk is written
            cameras.play()
        os.kill(self.pid_of(launch, "recorder"), signal.SIGKILL)
        self.end(launch)
        code, text = self.benchmark("--bag", str(active[0]), "--dry_run")
        self.assertEqual(code, 2, text)
        self.assertIn("run: rosbag reindex %s" % active[0], text)
        subprocess.run(["rosbag", "reindex", str(active[0])], check=True, stdout=self.log, timeout=PATIENCE)
        code, text = self.benchmark(
            "--bag", str(active[0]), "--dry_run", "--features", "orb+orb", "--selectors", "gms"
        )
        self.assertRegex(text, r"found \d+ pairs")
        self.assertNotEqual(code, 2, text)  # the last messages may be lost


class Library(unittest.TestCase):
    def test_nodelets_load_neither_the_benchmark_nor_the_methods_for_comparison(self):
        library = pathlib.Path(os.environ["CORRSEL_DEVEL_DIR"]) / "lib" / "libcorrsel_nodelets.so"
        loaded = subprocess.run(["ldd", str(library)], check=True, stdout=subprocess.PIPE, text=True).stdout
        own = sorted(set(re.findall(r"libcorrsel_(\w+)", loaded)))
        self.assertEqual(own, ["core", "features", "ros"])


if __name__ == "__main__":
    unittest.main()
