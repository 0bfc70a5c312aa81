#!/usr/bin/env python3
"""Installs the package into a temporary folder and runs a nodelet from there."""

import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import time
import unittest


def free_port():
    """A TCP port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


class InstallSpace(unittest.TestCase):
    """The installed package works without the source and build folders."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_install_"))
        self.processes = []

    def tearDown(self):
        for process in reversed(self.processes):
            process.terminate()
            process.wait(timeout=30)
        shutil.rmtree(self.root)

    def shell(self, command, **kwargs):
        """Starts a bash command in the install space's environment."""
        environment = {
            key: value
            for key, value in os.environ.items()
            if key in ("HOME", "PATH", "LANG", "TMPDIR", "ROS_HOSTNAME")
        }
        environment["ROS_MASTER_URI"] = f"http://localhost:{self.port}"
        environment["ROS_HOME"] = str(self.root / "ros_home")
        script = f"source {self.prefix}/setup.bash && {command}"
        return subprocess.Popen(["bash", "-c", script], env=environment, text=True, **kwargs)

    def output_of(self, command, timeout=60):
        """Exit code and output of a command, both streams together."""
        process = self.shell(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        try:
            text, _ = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            process.kill()
            text, _ = process.communicate()
        return process.returncode, text

    def wait_for(self, command, part, seconds=60):
        """Repeats a command until its output holds `part`."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            text = self.output_of(command)[1]
            if part in text:
                return
            time.sleep(0.5)
        self.fail(f"'{command}' did not show '{part}': {text}")

    def run_folder(self):
        """A run without pairs, as small as a report can be made of."""
        folder = self.root / "run"
        folder.mkdir()
        (folder / "pairs.csv").touch()
        return folder

    def test_nodelet_and_programs_run_from_the_install_space(self):
        """A Selector nodelet answers a message; benchmark, report and launch files are found."""
        build = os.environ["CORRSEL_BINARY_DIR"]
        environment = dict(os.environ, DESTDIR=str(self.root / "destination"))
        subprocess.run(
            ["cmake", "--build", build, "--target", "install"],
            env=environment,
            check=True,
            stdout=subprocess.DEVNULL,
        )
        found = list((self.root / "destination").rglob("share/corrsel/nodelet_plugins.xml"))
        self.assertEqual(len(found), 1, "nodelet_plugins.xml is not installed")
        self.prefix = found[0].parents[2]
        self.port = free_port()

        code, text = self.output_of("rospack find corrsel")
        self.assertEqual((code, text.strip()), (0, str(self.prefix / "share" / "corrsel")))
        code, text = self.output_of("rosrun corrsel benchmark --list")
        self.assertEqual(code, 0, text)
        self.assertIn("lpm:v2", text)
        for program in ("report.py", "fetch_samples.sh", "make_dataset_bag"):
            self.assertTrue((self.prefix / "lib" / "corrsel" / program).exists(), program)
        code, text = self.output_of(f"rosrun corrsel report.py {self.run_folder()}")
        self.assertEqual((code, text.strip()), (0, str(self.root / "run" / "report.html")), text)
        self.assertIn("dataset", self.output_of("roslaunch --ros-args corrsel benchmark.launch")[1])
        for file, argument in (
            ("live", "standalone"),
            ("sequence", "min_overlap"),
            ("view", "autosize"),
            ("replay", "bag"),
        ):
            self.assertIn(argument, self.output_of(f"roslaunch --ros-args corrsel {file}.launch")[1])
        code, text = self.output_of("roslaunch --nodes corrsel live.launch record:=true view:=true")
        self.assertEqual(code, 0, text)
        self.assertIn("/recorder", text)
        program = (
            "from corrsel import matches; from corrsel.msg import Correspondences; "
            "print(matches.__file__, matches.points(Correspondences(left_x=[1], left_y=[2], right_x=[3], "
            "right_y=[4])), matches.keypoints(Correspondences()))"
        )
        code, text = self.output_of(f"python3 -c '{program}'")
        self.assertEqual(code, 0, text)
        self.assertTrue(text.startswith(str(self.prefix)), text)

        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.processes.append(self.shell(f"exec roscore -p {self.port}", **quiet))
        self.wait_for("rosnode list", "/rosout")
        command = "exec rosrun nodelet nodelet standalone corrsel/Selector __name:=filter --no-bond"
        self.processes.append(self.shell(command, **quiet))
        self.wait_for("rostopic list", "/selection")
        points = ",".join(str(10 * k) for k in range(20))
        message = f"{{left_x: [{points}], left_y: [{points}], right_x: [{points}], right_y: [{points}]}}"
        self.processes.append(
            self.shell(
                f'exec rostopic pub -r 5 /correspondences corrsel/Correspondences "{message}"', **quiet
            )
        )
        text = self.output_of("timeout 40 rostopic echo -n 1 /selection")[1]
        self.assertIn("n_input: 20", text)


if __name__ == "__main__":
    unittest.main()
