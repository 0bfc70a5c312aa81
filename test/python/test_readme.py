#!/usr/bin/env python3
"""The examples of README.md, docs/doors.md and docs/python.md, compiled and run as they are printed there.

They use the package as installed into a temporary folder."""

import importlib.util
import os
import pathlib
import re
import sys
import tempfile
import unittest

import installed

ROOT = pathlib.Path(__file__).resolve().parents[2]
SECTION = "C++ and Python without ROS"

#: What the examples of docs/doors.md print, by a line of theirs.
DOORS = {
    "corrsel.draw(": r"^\(\d+, \d+, 3\) plane_or_rotation\n$",
    "from corrsel.opencv import findHomography": r"^\d{2,} inliers \[\[(1.0|0.99), ",
    "import corrsel_rtabmap": r"^\d{2,} matches, int64",
    'corrsel.verify("matches.h5"': r"^1 of 1 pairs, \d{2,} of \d{3} matches$",
    'door.register("auto")': "^$",
    "tensors.filter_matches(": r"^\d{2,} of \d{3} matches; torch.int64$",
    "import match_adalam": r"^\((\d+), 2\) \(\1, 1\) int64$",
    "import pycolmap": "^$",
}
#: Writes the files of hloc that the examples read.
HLOC_FILES = """
import corrsel, cv2, h5py, numpy
left, right = (corrsel.extract(cv2.imread(name), "sift+sift") for name in ("left.png", "right.png"))
matches = corrsel.match_features(left, right)
numbers = numpy.full(len(left), -1, numpy.int16)
numbers[matches.left_index] = matches.right_index
with h5py.File("features.h5", "w") as file:
    for name, side in (("left.png", left), ("right.png", right)):
        file[name + "/keypoints"] = side.points.astype(numpy.float16)
        file[name + "/image_size"] = side.image_size
        file[name + "/descriptors"] = side.descriptors.T
with h5py.File("matches.h5", "w") as file:
    file["left.png/right.png/matches0"] = numbers
    file["left.png/right.png/matching_scores0"] = (numbers >= 0).astype(numpy.float16)
open("pairs.txt", "w").write("left.png right.png\\n")
"""
#: hloc's contract: how it loads a matcher, and what it gives to it.
HLOC = {
    "utils/base_model.py": """
class BaseModel:
    def __init__(self, conf):
        self._init({**self.default_conf, **conf})
""",
    "match_features.py": """
import h5py
def main(conf, pairs, features, matches):
    module = __import__("hloc.matchers." + conf["model"]["name"], fromlist=[""])
    classes = [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__]
    model, data, names = classes[0](conf["model"]), {}, pairs.read_text().split()
    with h5py.File(str(features), "r") as file:
        for side, name in zip("01", names):
            for key, value in file[name].items():
                data[key + side] = value[()][None]
    matched = model._forward(data)["matches0"][0]
    assert matched.max() > 0, matched
    matches.touch()
""",
}


def blocks(text):
    """Return the fenced blocks of a Markdown text: pairs of language and content."""
    return re.findall(r"^```(\w+)\n(.*?)^```", text, re.M | re.S)


def readme_blocks():
    """Return the fenced blocks of the README's section by their language."""
    text = (ROOT / "README.md").read_text("utf-8")
    section = re.search(r"^## %s\n(.*?)^## " % re.escape(SECTION), text, re.M | re.S).group(1)
    return dict(blocks(section))


class Readme(unittest.TestCase):
    """The section for programs that do not use ROS."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="corrsel_readme_")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.work = pathlib.Path(cls.folder.name)
        cls.prefix = installed.install(cls.work / "destination")
        packages = [path.parent.parent for path in cls.prefix.glob("lib/**/corrsel/_core.*.so")]
        paths = [str(path) for path in packages] + [os.environ.get("PYTHONPATH", "")]
        cls.environment = {"PYTHONPATH": os.pathsep.join(paths)}

    def run_cpp(self, name, program):
        """Return what a program in C++ prints, built by the README's project."""
        folder = self.work / name
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text(readme_blocks()["cmake"], "utf-8")
        (folder / "main.cpp").write_text(program, "utf-8")
        code, text = installed.build_project(folder, folder / "build", self.prefix)
        self.assertEqual(code, 0, text)
        code, text = installed.run([folder / "build" / "example"])
        self.assertEqual(code, 0, text)
        return text

    def test_cpp(self):
        program = readme_blocks()["cpp"]
        text = self.run_cpp("readme", program)
        self.assertRegex(text, "^ok, ")
        self.assertIn("// " + text, program)

    def test_doors_in_cpp(self):
        text = (ROOT / "docs" / "doors.md").read_text("utf-8")
        section = re.search(r"^## OpenCV in C\+\+\n(.*?)(?:^## |\Z)", text, re.M | re.S).group(1)
        printed = self.run_cpp("opencv", dict(blocks(section))["cpp"])
        self.assertRegex(printed, r"^20\d inliers, shift (8|7\.9|8\.0)")

    def run_python(self, program):
        """Return what a program prints in a folder that holds left.png and right.png."""
        try:
            import corrsel  # pylint: disable=import-outside-toplevel
            import cv2  # pylint: disable=import-outside-toplevel
            from support import images  # pylint: disable=import-outside-toplevel
        except ImportError as error:
            self.skipTest("%s; python3-opencv and the Python package are needed" % error)
        if "match" not in corrsel.__all__:
            self.skipTest("the Python package was built without features")
        for name, image in zip(("left", "right"), images()):
            cv2.imwrite(str(self.work / (name + ".png")), image)
        code, text = installed.run(
            [sys.executable, "-c", "import os; os.chdir(%r)\n%s" % (str(self.work), program)],
            **self.environment,
        )
        self.assertEqual(code, 0, text)
        return text

    def test_python(self):
        where = self.run_python("from corrsel import _core; print(_core.__file__)")
        self.assertTrue(where.startswith(str(self.prefix)), where)
        output = self.run_python(readme_blocks()["python"])
        lines = output.splitlines()
        self.assertIn("# " + lines[0] + "\n", readme_blocks()["python"])
        self.assertTrue(lines[1].startswith("ok [["), output)

    def test_python_documentation(self):
        text = (ROOT / "docs" / "python.md").read_text("utf-8")
        programs = [block for language, block in blocks(text) if language == "python"]
        outputs = [self.run_python(program) for program in programs]
        self.assertEqual(len(outputs), 7)
        self.assertRegex(outputs[0], r"^\d+ of \d+ matches; a plane .* model: \[\[")
        self.assertRegex(outputs[1], r"^\d+ of \d+ matches are likely to be right; noise \d\.\d+ px\n$")
        self.assertRegex(outputs[2], r"^plane 0 has \d+ matches around \[")
        self.assertRegex(outputs[3], r"^<corrsel.Selection: ok, .* model homography")
        self.assertRegex(
            outputs[4],
            r"^3\d\d of 500 matches, wrong by 0\.\d\d degrees\nstandard deviations, degrees: \[0\.",
        )
        self.assertRegex(
            outputs[5], r"^auto +P 1.000 R 1.000 F 1.000\nlpm +P [01].*\nransac +P 1.000 R 1.000 F 1.000\n$"
        )
        self.assertRegex(
            outputs[6], r"^AUC at 5, 10, 20 degrees \[0\.314\d* +0\.323\d* +0\.328\d*\] mAA 0\.333\d*\n$"
        )

    def test_doors(self):
        text = (ROOT / "docs" / "doors.md").read_text("utf-8")
        programs = [block for language, block in blocks(text) if language == "python"]
        self.assertEqual(len(programs), len(DOORS))
        self.run_python("")
        for file, content in HLOC.items():
            (self.work / "hloc" / file).parent.mkdir(parents=True, exist_ok=True)
            (self.work / "hloc" / file).write_text(content, "utf-8")
        if importlib.util.find_spec("h5py"):
            self.run_python(HLOC_FILES)
        for program, (line, expected) in zip(programs, DOORS.items()):
            self.assertIn(line, program)
            needed = set(re.findall(r"^import (torch|pycolmap)", program, re.M))
            needed |= {"h5py"} if "features.h5" in program else set()
            missing = [name for name in needed if not importlib.util.find_spec(name)]
            with self.subTest(line):
                if missing:
                    self.skipTest("needs " + ", ".join(missing))
                self.assertRegex(self.run_python(program), expected)
        if importlib.util.find_spec("h5py"):
            self.assertTrue((self.work / "matched.h5").exists())

    def test_rtabmap_s_file_is_installed_beside_the_package(self):
        where = self.run_python("import corrsel_rtabmap; print(corrsel_rtabmap.__file__)").strip()
        self.assertTrue(where.startswith(str(self.prefix)), where)


if __name__ == "__main__":
    unittest.main()
