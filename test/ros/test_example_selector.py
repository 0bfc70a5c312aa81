#!/usr/bin/env python3
"""Builds examples/corrsel_example_selector as its users would, and runs its selector in benchmark and nodelet."""

import csv
import os
import pathlib
import shutil
import tempfile
import unittest

import numpy as np
from catkin_pkg.packages import find_packages
from ros_shell import RosShell

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DEVEL = pathlib.Path(os.environ["CORRSEL_DEVEL_DIR"])
SELECTOR = "corrsel_example_selector/NormalizedMedian"


def write_scene(folder):
    """Six images of one plane in the form of the VGG dataset, each shifted by some whole pixels."""
    folder.mkdir(parents=True)
    random = np.random.default_rng(3)
    rows, columns = np.mgrid[0:300, 0:400]
    plane = np.full((300, 400, 3), 40, np.uint8)
    for _ in range(250):
        x, y, radius = random.integers(400), random.integers(300), random.integers(2, 10)
        plane[(columns - x) ** 2 + (rows - y) ** 2 <= radius**2] = random.integers(60, 255, 3)
    for k in range(6):
        shift_x, shift_y = 10 * k, 8 * k
        image = plane[shift_y : shift_y + 240, shift_x : shift_x + 320]
        (folder / f"img{k + 1}.ppm").write_bytes(b"P6\n320 240\n255\n" + image.tobytes())
        if k > 0:
            (folder / f"H1to{k + 1}p").write_text(f"1 0 {-shift_x}\n0 1 {-shift_y}\n0 0 1\n")


class ExampleSelector(unittest.TestCase):
    """A copy of the example, built outside the source tree."""

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="corrsel_example_"))
        cls.shell = RosShell(DEVEL / "setup.bash", cls.root)
        shutil.copytree(SOURCE / "examples" / "corrsel_example_selector", cls.root / "src")
        configure = f"cmake -S {cls.root}/src -B {cls.root}/build -DCATKIN_DEVEL_PREFIX={cls.root}/devel"
        cls.build_log = cls.shell.output_of(
            f"{configure} -DCMAKE_CXX_FLAGS=-Werror && cmake --build {cls.root}/build --target all tests"
        )
        cls.shell.setup = cls.root / "devel" / "setup.bash"
        write_scene(cls.root / "data" / "vgg" / "shifts")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root)

    def benchmark(self, arguments):
        """Runs the benchmark on the scene, without a master."""
        data = f"--dataset vgg --data_root {self.root}/data --features orb+orb"
        return self.shell.output_of(f"rosrun corrsel benchmark {data} {arguments}")

    def test_is_not_built_unasked(self):
        """A workspace that holds corrsel itself does not see the example."""
        (self.root / "workspace").mkdir()
        (self.root / "workspace" / "corrsel").symlink_to(SOURCE)
        self.assertEqual(list(find_packages(str(self.root / "workspace"))), ["corrsel"])

    def test_builds_and_passes_its_own_tests(self):
        """Configured against the devel space, with warnings as errors."""
        self.assertEqual(self.build_log[0], 0, self.build_log[1])
        tests = list((self.root / "devel").rglob("test_normalized_median"))
        self.assertEqual(len(tests), 1)
        code, text = self.shell.output_of(str(tests[0]))
        self.assertEqual(code, 0, text)

    def test_benchmark_lists_and_runs_it(self):
        """--list, options, results, report, resume, merge and compare_runs know its name."""
        code, text = self.shell.output_of("rosrun corrsel benchmark --list")
        self.assertEqual(code, 0, text)
        self.assertIn(f"{SELECTOR}.threshold = 2  [0, 1000]", text)
        self.assertIn(f"{SELECTOR}:strict", text)
        self.assertIn(f"\n  other packages (loaded at run time)\n    {SELECTOR}\n", text)

        code, text = self.benchmark(f"--selectors gms,{SELECTOR} --options {SELECTOR}.treshold=3")
        self.assertEqual(code, 2, text)
        self.assertIn(
            f"unknown option {SELECTOR}.treshold; did you mean 'threshold'? valid: neighbours, threshold, noise",
            text,
        )

        # As if no workspace had been sourced.
        code, text = self.shell.output_of(
            f"ROS_PACKAGE_PATH= {DEVEL}/lib/corrsel/benchmark --selectors {SELECTOR}"
        )
        self.assertEqual(code, 2, text)
        self.assertIn(f"unknown selector '{SELECTOR}'; selectors of other packages: none", text)
        self.assertIn("source the setup.bash of the workspace", text)

        run = self.root / "run"
        arguments = f"--selectors gms,{SELECTOR} --options {SELECTOR}.threshold=3"
        code, text = self.benchmark(f"{arguments} --output_dir {run}")
        self.assertEqual(code, 0, text)
        self.assertIn(f"{SELECTOR}:", (run / "config.yaml").read_text())
        with open(run / "pairs.csv", newline="", encoding="utf-8") as file:
            next(file)  # the format
            rows = [row for row in csv.DictReader(file) if row["selector"] == SELECTOR]
        # 5 pairs, with and without preselection
        self.assertEqual(len(rows), 10)
        self.assertEqual({row["status"] for row in rows}, {"ok"})
        for row in rows:
            if row["preselection"] == "none":
                everything = float(row["n_ground_truth"]) / float(row["n_putative"])
                self.assertGreater(float(row["n_correct_5px"]) / float(row["n_selected"]), everything)
        with open(run / "images" / "index.csv", newline="", encoding="utf-8") as file:
            pictures = [row["file"] for row in csv.DictReader(file) if row["selector"] == SELECTOR]
        self.assertTrue(pictures)
        for name in pictures:
            self.assertTrue((run / "images" / name).is_file(), name)
        self.assertIn(SELECTOR, (run / "report.html").read_text())

        code, text = self.benchmark(f"{arguments} --output_dir {run} --resume true")
        self.assertEqual(code, 0, text)
        parts = []
        for part in ("1/2", "2/2"):
            parts.append(str(self.root / part.replace("/", "of")))
            code, text = self.benchmark(f"{arguments} --output_dir {parts[-1]} --shard {part} --report false")
            self.assertEqual(code, 0, text)
        merged = self.root / "merged"
        code, text = self.benchmark(
            f"{arguments} --output_dir {merged} --merge {','.join(parts)} --report false"
        )
        self.assertEqual(code, 0, text)
        code, text = self.shell.output_of(f"rosrun corrsel compare_runs {run} {merged}")
        self.assertEqual(code, 0, text)

    def test_nodelet_runs_it(self):
        """Chosen by start parameters, changed by dynamic_reconfigure; a refused change leaves it in force."""
        self.addCleanup(self.shell.end)
        self.shell.start_master()
        self.shell.run_beside(
            f"rosrun nodelet nodelet standalone corrsel/Selector __name:=filter --no-bond "
            f"_selector:={SELECTOR} _options:=neighbours=4,threshold=3"
        )
        self.shell.wait_for("rostopic list", "/selection")
        left = ",".join(str(10 * k) for k in range(20))
        right = ",".join(str(10 * k + (300 if k == 7 else 5)) for k in range(20))
        zeros = ",".join(["0"] * 20)
        message = f"{{left_x: [{left}], left_y: [{zeros}], right_x: [{right}], right_y: [{zeros}]}}"
        self.shell.run_beside(f'rostopic pub -r 10 /correspondences corrsel/Correspondences "{message}"')
        self.shell.wait_for("timeout 20 rostopic echo -n 1 /selection", f'selector: "{SELECTOR}"')
        # Every match but the one that goes elsewhere.
        self.shell.wait_for("timeout 20 rostopic echo -n 1 /selection/n_selected", "19")

        set_parameter = "rosrun dynamic_reconfigure dynparam set /filter"
        self.shell.output_of(f"{set_parameter} preset strict")
        self.shell.wait_for("timeout 20 rostopic echo -n 1 /selection", f'selector: "{SELECTOR}:strict"')
        self.shell.output_of(f"{set_parameter} preset ''")
        self.shell.output_of(f"{set_parameter} options threshold=1000,noise=1")
        self.shell.wait_for("timeout 20 rostopic echo -n 1 /selection/n_selected", "20")
        for name, value in (
            ("options", "threshold=-1"),
            ("selector", "corrsel_example_selector/Typo"),
        ):
            self.shell.output_of(f"{set_parameter} {name} {value}")
            text = self.shell.output_of("timeout 20 rostopic echo -n 1 /selection")[1]
            self.assertIn(f'selector: "{SELECTOR}"', text)
            self.assertIn("n_selected: 20", text)
        text = self.shell.output_of("rosrun dynamic_reconfigure dynparam get /filter")[1]
        self.assertIn("'noise=1,threshold=1000'", text)


if __name__ == "__main__":
    unittest.main()
