"""What tests need that run commands as users do: a shell in a workspace's environment, and a master of its own."""

import os
import pathlib
import socket
import subprocess
import time


def free_port():
    """A TCP port on which no program listens."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


class RosShell:
    """Bash commands in the environment of the workspace whose setup.bash is `setup`, and no other; files go below
    the folder `root`, the master's port is `port`."""

    def __init__(self, setup, root):
        self.setup = setup
        self.root = pathlib.Path(root)
        self.port = free_port()
        self.processes = []

    def start(self, command, **kwargs):
        """Starts a command. Returns the subprocess.Popen."""
        environment = {
            key: value
            for key, value in os.environ.items()
            if key in ("HOME", "LANG", "TMPDIR", "ROS_HOSTNAME") or key.startswith("CCACHE")
        }
        environment["PATH"] = "/usr/bin:/bin:/usr/sbin:/sbin"
        environment["ROS_MASTER_URI"] = f"http://localhost:{self.port}"
        environment["ROS_HOME"] = str(self.root / "ros_home")
        environment["XDG_CACHE_HOME"] = str(self.root / "cache")
        return subprocess.Popen(
            ["bash", "-c", f"source {self.setup} && {command}"], env=environment, text=True, **kwargs
        )

    def run_beside(self, command):
        """Starts a command that runs until end(). Its output is left out."""
        self.processes.append(
            self.start(f"exec {command}", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        )

    def start_master(self):
        """Returns once a master replies; it runs until end()."""
        self.run_beside(f"roscore -p {self.port}")
        self.wait_for("rosnode list", "/rosout")

    def end(self):
        """Ends what runs beside, the newest first."""
        while self.processes:
            process = self.processes.pop()
            process.terminate()
            process.wait(timeout=30)

    def output_of(self, command, timeout=900):
        """Exit code and output of a command, both streams together."""
        process = self.start(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        try:
            text, _ = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            process.kill()
            text, _ = process.communicate()
        return process.returncode, text

    def wait_for(self, command, part, seconds=90):
        """Repeats a command until its output holds `part`. Throws AssertionError where it never does."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            text = self.output_of(command)[1]
            if part in text:
                return
            time.sleep(0.5)
        raise AssertionError(f"'{command}' did not show '{part}': {text}")
