# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the add-on's tests in the Blender of its own interpreter: PYTHON tests/addon/run.py [NAME...]

NAME is as unittest takes it (test_export_objects, test_export_objects.Placed). Several are shared out among as many Blenders as there are
processors: most tests keep one busy. Each ends with the line "test result: …" that scripts/test.sh adds up.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

# With it, names are taken from a folder.
TAKE = "--take"


def all_names():
    """All modules of tests, those that take longest first: the last ones of each Blender are short."""
    # The package has a program of its own, which needs no Blender around it.
    names = [path.stem for path in HERE.glob("test_*.py") if path.stem != "test_package"]
    return sorted(names, key=lambda name: ("parity" not in name, name))


def taken(folder):
    """Names from a folder, each of which one Blender gets."""
    for path in sorted(folder.glob("todo/*")):
        try:
            path.rename(folder / "begun" / path.name)
        except FileNotFoundError:
            continue
        yield path.name.partition(" ")[2]


class Timed(unittest.TextTestResult):
    """Says which tests take long."""

    LONG = 10  # Seconds.

    def startTest(self, test):
        self.start = time.monotonic()
        super().startTest(test)

    def stopTest(self, test):
        super().stopTest(test)
        seconds = time.monotonic() - self.start
        if seconds > self.LONG:
            print(f"{test.id()} took {seconds:.0f} s", flush=True)


def run(names):
    """Runs tests one after the other; whether all passed."""
    count = failed = skipped = 0
    verdict = "ok"
    for name in names:
        # At once: a crash of Blender's tells nothing more.
        print(name, flush=True)
        result = unittest.TextTestRunner(verbosity=1, resultclass=Timed).run(unittest.defaultTestLoader.loadTestsFromName(name))
        # A test fails once, however many of its parts do.
        parts = [getattr(test, "test_case", test) for test, _ in result.failures + result.errors]
        count += result.testsRun
        failed += len({test.id() for test in parts})
        skipped += len(result.skipped)
        if not result.wasSuccessful():
            verdict = "FAILED"
    # As cargo's summary.
    print(f"test result: {verdict}. {count - failed - skipped} passed; {failed} failed; {skipped} ignored; 0 measured")
    return verdict == "ok"


def run_here(names):
    """Runs tests in this process and ends it."""
    import bpy

    with tempfile.TemporaryDirectory(prefix="sundog-test-cache-") as cache:
        # The user's own cache of exported scenes stays out of it.
        os.environ["XDG_CACHE_HOME"] = cache
        passed = run(names)
    sys.stdout.flush()
    sys.stderr.flush()
    # Blender's own teardown has nothing to say on the tests, but for its folder.
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    os._exit(0 if passed else 1)


def share_out(names, processes):
    """Has several Blenders run the tests, and says what each said, one after the other; whether all passed."""
    with tempfile.TemporaryDirectory(prefix="sundog-tests-") as folder:
        folder = Path(folder)
        for name in ("todo", "begun"):
            (folder / name).mkdir()
        for number, name in enumerate(names):
            (folder / "todo" / f"{number:03} {name}").touch()
        logs = [folder / f"log {number}" for number in range(processes)]
        running = []
        for log in logs:
            with log.open("wb") as out:
                running.append(subprocess.Popen([sys.executable, __file__, TAKE, folder], stdout=out, stderr=subprocess.STDOUT))
        codes = [process.wait() for process in running]
        for log, code in zip(logs, codes):
            sys.stdout.buffer.write(log.read_bytes())
            if code not in (0, 1):
                # It has not come to its summary.
                print(f"a Blender ended with {code}\ntest result: FAILED. 0 passed; 1 failed; 0 ignored; 0 measured")
        return not any(codes) and not any(folder.glob("todo/*"))


def main(arguments):
    """Runs all tests, or those named; whether all passed."""
    if arguments[:1] == [TAKE]:
        run_here(taken(Path(arguments[1])))
    names = arguments or all_names()
    processes = min(len(names), len(os.sched_getaffinity(0)))
    if processes == 1:
        run_here(names)
    return share_out(names, processes)


if __name__ == "__main__":
    passed = main(sys.argv[1:])
    sys.stdout.flush()
    sys.exit(0 if passed else 1)
