#!/usr/bin/env python3
"""How long importing the package takes, beside numpy, without which it cannot be used."""

import os
import subprocess
import sys
import unittest

REPEATS = 7
IMPORT = "import corrsel"
USE = "import corrsel; corrsel.select; corrsel.match"


def processor_seconds(program):
    """Return the processor time of an interpreter that runs a program, s."""
    process = subprocess.Popen([sys.executable, "-c", program])
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = status
    if status != 0:
        raise AssertionError("%s failed" % program)
    return usage.ru_utime + usage.ru_stime


class ImportTime(unittest.TestCase):
    """Processor time is compared, and only with what ran at the same time: other programs take turns with this one."""

    @classmethod
    def setUpClass(cls):
        programs = ("pass", "import numpy", IMPORT, USE)
        runs = [[processor_seconds(program) for program in programs] for _ in range(REPEATS)]
        cls.nothing, cls.numpy, cls.alone, cls.used = (min(times) for times in zip(*runs))

    def test_import_alone_takes_a_fraction_of_numpy(self):
        self.assertLess(self.alone - self.nothing, 0.5 * (self.numpy - self.nothing))

    def test_all_modules_take_less_than_numpy_again(self):
        self.assertLess(self.used, 2 * self.numpy)

    def test_nothing_else_is_loaded(self):
        """What takes long, and is needed by parts of the package alone."""
        program = (
            USE
            + "; import sys; print(sorted({'cv2', 'h5py', 'jinja2', 'matplotlib', 'yaml'} & set(sys.modules)))"
        )
        self.assertEqual(
            subprocess.check_output([sys.executable, "-c", program], universal_newlines=True), "[]\n"
        )


if __name__ == "__main__":
    unittest.main()
