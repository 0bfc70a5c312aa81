#!/usr/bin/env python3
"""scripts/maintenance/release_check.py with steps of its own, in a repository of its own."""

import csv
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = "scripts/maintenance/release_check.py"
STEPS = """\
- {name: first, command: 'echo 3 passed, 0 failed; echo end', summary: passed}
- {name: second, command: 'test -f source.txt && echo found', summary: found}
"""


@unittest.skipIf(shutil.which("git") is None, "needs git")
class ReleaseCheck(unittest.TestCase):
    """Each test has a repository with one source file and one document."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="corrsel_release_test_")
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.package = self.root / "package"
        (self.package / "scripts/maintenance").mkdir(parents=True)
        shutil.copy(str(PACKAGE / SCRIPT), str(self.package / SCRIPT))
        self.write("source.txt", "1")
        self.write("docs/text.md", "1")
        self.git("init", "-q")
        self.commit()

    def write(self, name, text):
        """Writes a file of the repository."""
        path = self.package / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def git(self, *arguments):
        """Runs git in the repository."""
        who = ["-c", "user.name=Test", "-c", "user.email=test@example.org"]
        subprocess.run(["git", *who, *arguments], cwd=str(self.package), check=True)

    def commit(self):
        """Commits everything."""
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "change")

    def start(self, *arguments, steps=STEPS):
        """Starts the script."""
        (self.root / "steps.yaml").write_text(steps)
        return subprocess.Popen(
            [
                sys.executable,
                str(self.package / SCRIPT),
                "--steps",
                str(self.root / "steps.yaml"),
                *arguments,
            ],
            env=dict(os.environ, XDG_CACHE_HOME=str(self.root / "cache")),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
        )

    def run_script(self, *arguments, steps=STEPS):
        """Returns exit code and output."""
        with self.start(*arguments, steps=steps) as process:
            text = process.communicate()[0]
        return process.returncode, text

    def rows(self):
        """Returns the rows of the table by step."""
        with (self.package / "docs/data/release.csv").open(newline="") as file:
            return {row["step"]: row for row in csv.DictReader(file)}

    def test_all_steps_pass(self):
        code, text = self.run_script()
        self.assertEqual(code, 0, text)
        self.assertIn("Every step has passed with the code of HEAD.", text)
        rows = self.rows()
        self.assertEqual(list(rows), ["first", "second"])
        self.assertEqual(rows["first"]["result"], "passed")
        self.assertEqual(rows["first"]["summary"], "3 passed, 0 failed")
        self.assertEqual(rows["first"]["code"], rows["second"]["code"])
        self.assertTrue((self.root / "cache/corrsel/release/second.log").exists())

    def test_a_failure_is_recorded_and_the_next_step_runs(self):
        steps = STEPS.replace("echo end", "touch made_here; exit 3")
        code, text = self.run_script(steps=steps)
        self.assertEqual(code, 1)
        kept = list((self.root / "cache/corrsel/release").glob("clone_*/corrsel/made_here"))
        self.assertEqual(len(kept), 1, "the clone of the failed step alone is kept")
        self.assertIn("the clone and what it built stay in %s" % kept[0].parents[1], text)
        self.assertIn("first failed (exit code 3)", text)
        self.assertEqual(self.rows()["second"]["result"], "passed")

    def test_goes_on_with_what_is_missing(self):
        self.assertEqual(self.run_script("first")[0], 1)
        code, text = self.run_script()
        self.assertEqual(code, 0, text)
        self.assertNotIn("== first", text)
        self.assertIn("== second", text)
        code, text = self.run_script("--again", "first")
        self.assertIn("== first", text)

    def test_missing_steps_are_named(self):
        code, text = self.run_script("--list")
        self.assertEqual(code, 1)
        self.assertIn("first has not run", text)
        self.assertFalse((self.package / "docs/data/release.csv").exists())

    def test_other_code_is_refused_and_other_documentation_is_not(self):
        self.assertEqual(self.run_script()[0], 0)
        self.write("docs/text.md", "2")
        self.write("CHANGELOG.rst", "2")
        self.commit()
        self.assertEqual(self.run_script("--list")[0], 0)
        commit = self.rows()["second"]["commit"]
        self.write("source.txt", "2")
        self.commit()
        code, text = self.run_script("first")
        self.assertEqual(code, 1)
        self.assertIn("second ran with other code: commit " + commit, text)
        self.assertNotIn("first ran with other code", text)

    def test_changes_that_are_not_committed(self):
        self.write("docs/text.md", "2")
        self.assertEqual(self.run_script("first")[0], 1)
        self.write("source.txt", "2")
        code, text = self.run_script("first")
        self.assertEqual(code, 2)
        self.assertIn("source.txt is not committed", text)

    def test_a_step_runs_in_a_clone(self):
        code, text = self.run_script(steps=STEPS.replace("echo found", "touch made_here && echo found"))
        self.assertEqual(code, 0, text)
        self.assertFalse((self.package / "made_here").exists())
        self.assertEqual(list((self.root / "cache/corrsel/release").glob("clone_*")), [])

    def test_ended_in_the_middle(self):
        """The step ends with the program, and the next call goes on with it."""
        alive = self.root / "alive"
        # The step ignores SIGINT, as programs in the background do.
        command = 'trap "" INT; while sleep 0.1; do touch %s; done' % alive
        steps = STEPS.replace("test -f source.txt", command)
        for ending in (signal.SIGINT, signal.SIGTERM):
            with self.start(steps=steps) as process:
                while not alive.exists():
                    self.assertIsNone(process.poll())
                    time.sleep(0.05)
                process.send_signal(ending)
                text = process.communicate(timeout=60)[0]
            self.assertEqual(process.returncode, 130, text)
            self.assertEqual(list(self.rows()), ["first"])
            alive.unlink()
            time.sleep(0.5)
            self.assertFalse(alive.exists(), "the step still runs")
        code, text = self.run_script()
        self.assertEqual(code, 0, text)
        self.assertNotIn("== first", text)

    def test_wrong_arguments(self):
        code, text = self.run_script("third")
        self.assertEqual(code, 2)
        self.assertIn("unknown step 'third'; valid: first, second", text)
        code, text = self.run_script(steps="- {name: first}")
        self.assertEqual(code, 2)
        self.assertIn("a step has `name`, `command` and `summary`", text)
        code, text = self.run_script(steps="- {name: first, parts: 0, command: a, summary: b}")
        self.assertEqual(code, 2)
        self.assertIn("`parts` of first is 0; give a number from 1", text)

    def test_the_list_of_the_package(self):
        """Every command of the real list begins with a script that exists."""
        code, text = self.run_script(
            "--list", steps=(PACKAGE / "scripts/maintenance/release_steps.yaml").read_text()
        )
        self.assertEqual(code, 1, text)
        commands = [
            re.search("command: (.*?), summary", line).group(1)
            for line in (PACKAGE / "scripts/maintenance/release_steps.yaml").read_text().splitlines()
            if line.startswith("- ")
        ]
        self.assertGreater(len(commands), 15)
        for command in commands:
            self.assertTrue(os.access(str(PACKAGE / command.split()[0]), os.X_OK), command)

    def test_a_commit_during_a_step_is_other_code(self):
        commit = "cd %s && echo 2 >source.txt && git -c user.name=T -c user.email=t@e.org commit -qam x"
        steps = "- {name: first, command: '%s', summary: x}" % (commit % self.package)
        self.run_script(steps=steps)
        code, text = self.run_script("--list", steps=steps)
        self.assertEqual(code, 1)
        self.assertIn("first ran with other code", text)

    def test_parts_of_a_step_are_rows(self):
        steps = "- {name: long, parts: 2, command: printenv GTEST_SHARD_INDEX, summary: .}"
        self.assertEqual(self.run_script("long_2", steps=steps)[0], 1)
        self.assertEqual(list(self.rows()), ["long_2"])
        code, text = self.run_script(steps=steps)
        self.assertEqual(code, 0, text)
        self.assertEqual([row["summary"] for row in self.rows().values()], ["0", "1"])

    def test_two_calls_at_a_time_keep_both_rows(self):
        wait = "for i in $(seq 1200); do test -e %s && break; sleep 0.05; done"
        steps = (
            "- {name: slow, command: 'touch %s; %s', summary: x}\n- {name: quick, command: '%s', summary: x}\n"
            % (
                self.root / "begun",
                wait % (self.root / "go_on"),
                wait % (self.root / "begun"),
            )
        )
        with self.start("slow", steps=steps) as slow:
            self.run_script("quick", steps=steps)
            (self.root / "go_on").touch()
            slow.communicate()
        self.assertEqual(sorted(self.rows()), ["quick", "slow"])


if __name__ == "__main__":
    unittest.main()
