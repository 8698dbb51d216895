# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the add-on's tests in the Blender of its own interpreter: PYTHON tests/addon/run.py [NAME...]

NAME is as unittest takes it (test_export_objects, test_export_objects.Placed). Ends with the line "test result: …" that
scripts/test.sh adds up.
"""

import os
import shutil
import sys
import tempfile
import unittest

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)


def main(names):
    """Runs all tests, or those named; whether all passed."""
    # The package has a program of its own, which needs no Blender around it.
    apart = {"test_package.py"}
    names = names or sorted(name[:-3] for name in os.listdir(HERE) if name.startswith("test_") and name.endswith(".py") and name not in apart)
    tests = unittest.defaultTestLoader.loadTestsFromNames(names)
    result = unittest.TextTestRunner(verbosity=1).run(tests)
    # A test fails once, however many of its parts do.
    parts = [getattr(test, "test_case", test) for test, _ in result.failures + result.errors]
    failed, skipped = len({test.id() for test in parts}), len(result.skipped)
    verdict = "ok" if result.wasSuccessful() else "FAILED"
    # As cargo's summary.
    print(f"test result: {verdict}. {result.testsRun - failed - skipped} passed; {failed} failed; {skipped} ignored; 0 measured")
    return result.wasSuccessful()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="sundog-test-cache-") as cache:
        # The user's own cache of exported scenes stays out of it.
        os.environ["XDG_CACHE_HOME"] = cache
        passed = main(sys.argv[1:])
    sys.stdout.flush()
    sys.stderr.flush()
    # Blender's own teardown has nothing to say on the tests, but for its folder.
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    os._exit(0 if passed else 1)
