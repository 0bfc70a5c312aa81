#!/usr/bin/env python3
"""Installs the package into a temporary folder and runs a nodelet from there."""

import pathlib
import shutil
import tempfile
import unittest

import installed
from ros_shell import RosShell


class InstallSpace(unittest.TestCase):
    """The installed package works without the source and build folders."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_install_"))

    def tearDown(self):
        shutil.rmtree(self.root)

    def run_folder(self):
        """A run without pairs, as small as a report can be made of."""
        folder = self.root / "run"
        folder.mkdir()
        (folder / "pairs.csv").touch()
        return folder

    def test_nodelet_and_programs_run_from_the_install_space(self):
        """A Selector nodelet processes a message; benchmark, report and launch files are found."""
        prefix = installed.install(self.root / "destination")
        plugins = list((self.root / "destination").rglob("share/corrsel/nodelet_plugins.xml"))
        self.assertEqual(len(plugins), 1, "nodelet_plugins.xml is not installed")
        shell = RosShell(prefix / "setup.bash", self.root)
        self.addCleanup(shell.end)

        code, text = shell.output_of("rospack find corrsel")
        self.assertEqual((code, text.strip()), (0, str(prefix / "share" / "corrsel")))
        code, text = shell.output_of("rosrun corrsel benchmark --list")
        self.assertEqual(code, 0, text)
        self.assertIn("lpm:v2", text)
        self.assertRegex(text, r"\n  local \([^\n]+\)\n    adalam {7}Adaptive[^\n]*\n    laf ")
        for program in ("report.py", "fetch_samples.sh", "make_dataset_bag"):
            self.assertTrue((prefix / "lib" / "corrsel" / program).exists(), program)
        code, text = shell.output_of(f"rosrun corrsel report.py {self.run_folder()}")
        self.assertEqual((code, text.splitlines()[-1]), (0, str(self.root / "run" / "report.html")), text)
        self.assertIn("dataset", shell.output_of("roslaunch --ros-args corrsel benchmark.launch")[1])
        for file, argument in (
            ("live", "standalone"),
            ("sequence", "min_overlap"),
            ("view", "autosize"),
            ("replay", "bag"),
        ):
            self.assertIn(argument, shell.output_of(f"roslaunch --ros-args corrsel {file}.launch")[1])
        code, text = shell.output_of("roslaunch --nodes corrsel live.launch record:=true view:=true")
        self.assertEqual(code, 0, text)
        self.assertIn("/recorder", text)
        program = (
            "from corrsel import matches; from corrsel.msg import Correspondences; "
            "print(matches.__file__, matches.points(Correspondences(left_x=[1], left_y=[2], right_x=[3], "
            "right_y=[4])), matches.keypoints(Correspondences()))"
        )
        code, text = shell.output_of(f"python3 -c '{program}'")
        self.assertEqual(code, 0, text)
        self.assertTrue(text.startswith(str(prefix)), text)
        program = (
            "import corrsel, sys; from corrsel import _core, _features; print(_core.__file__, _features.__file__, "
            "corrsel.select([[1.0, 2]], [[3.0, 4]], 'keep_all').mask, 'rospy' in sys.modules)"
        )
        code, text = shell.output_of(f'python3 -c "{program}"')
        self.assertEqual(code, 0, text)
        self.assertTrue(text.startswith(str(prefix)), text)
        self.assertTrue(text.endswith("[ True] False\n"), text)

        shell.start_master()
        shell.run_beside("rosrun nodelet nodelet standalone corrsel/Selector __name:=filter --no-bond")
        shell.wait_for("rostopic list", "/selection")
        points = ",".join(str(10 * k) for k in range(20))
        message = f"{{left_x: [{points}], left_y: [{points}], right_x: [{points}], right_y: [{points}]}}"
        shell.run_beside(f'rostopic pub -r 5 /correspondences corrsel/Correspondences "{message}"')
        text = shell.output_of("timeout 40 rostopic echo -n 1 /selection")[1]
        self.assertIn("n_input: 20", text)


if __name__ == "__main__":
    unittest.main()
