"""What tests need that start nodes as users do: a master for all tests of a class, and programs with a log."""

import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import rosgraph
import rospy
from ros_shell import free_port

PATIENCE = 90  # s; generous: the machine may be busy


def wait_until(condition, between=lambda: time.sleep(0.1)):
    """Calls `between` until the condition holds. Returns whether it did in time."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            return False
        between()
    return True


class LaunchedTest(unittest.TestCase):
    """One master for all tests of the class. One class per file, because rospy has one node per process."""

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_launched_"))
        os.environ["ROS_HOSTNAME"] = "localhost"
        os.environ["ROS_HOME"] = str(cls.root / "ros_home")
        cls.log = open(cls.root / "log.txt", "w+", encoding="utf-8")  # pylint: disable=consider-using-with
        cls.start_master()
        rospy.init_node("test_launched", disable_signals=True)

    @classmethod
    def start_master(cls):
        """Starts a master. On a busy machine roscore may give up, and another test may take the port before it."""
        for _ in range(5):
            cls.port = free_port()
            os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % cls.port
            cls.master = cls.start("roscore", "-p", str(cls.port))
            if (
                wait_until(lambda: cls.master.poll() is not None or cls.has_rosout())
                and cls.master.poll() is None
            ):
                return
            cls.end(cls.master)
        raise AssertionError("roscore does not start; its log:\n" + cls.text())

    @staticmethod
    def has_rosout():
        """Whether the master runs, with the node that roscore starts after it."""
        try:
            return "/rosout" in str(rosgraph.Master("/test_launched").getSystemState())
        except (OSError, rosgraph.MasterException):
            return False

    @classmethod
    def tearDownClass(cls):
        try:
            rospy.signal_shutdown("done")
        except AttributeError:
            pass  # rospy of Debian 11 calls Thread.isAlive(), which its Python 3.9 no longer has
        cls.end(cls.master)
        cls.log.close()
        shutil.rmtree(cls.root)

    @classmethod
    def start(cls, *command, **kwargs):
        """Starts a program whose output goes to the log."""
        return subprocess.Popen(command, stdout=cls.log, stderr=subprocess.STDOUT, **kwargs)

    @classmethod
    def end(cls, process):
        """Ends a program as Ctrl-C does."""
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(timeout=PATIENCE)

    def launch(self, namespace, file, *arguments):
        """Starts a launch file of the package in a namespace; it ends with the test."""
        environment = dict(
            os.environ, ROS_NAMESPACE=namespace, PWD=str(self.root), ROSCONSOLE_STDOUT_LINE_BUFFERED="1"
        )
        process = self.start("roslaunch", "corrsel", file, *arguments, env=environment, cwd=self.root)
        self.addCleanup(self.end, process)
        return process

    @classmethod
    def text(cls):
        """What the programs have printed so far, its end."""
        cls.log.flush()
        return (cls.root / "log.txt").read_text(encoding="utf-8", errors="replace")[-5000:]
