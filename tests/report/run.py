"""Opens reports in Chromium: PYTHON tests/report/run.py [NAME...]

The pages are those that `cargo test` has left in target/tmp/report (tests/report.rs knows their numbers). PYTHON is the
one of scripts/setup-browser.sh. Screenshots go to target/tmp/report/shots. Ends with the line "test result: …" that
scripts/test.sh adds up.
"""

import os
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))


def main(names):
    """Runs all tests, or those named; whether all passed."""
    names = names or sorted(path.stem for path in HERE.glob("test_*.py"))
    tests = unittest.defaultTestLoader.loadTestsFromNames(names)
    result = unittest.TextTestRunner(verbosity=1).run(tests)
    parts = [getattr(test, "test_case", test) for test, _ in result.failures + result.errors]
    failed, skipped = len({test.id() for test in parts}), len(result.skipped)
    for test, reason in result.skipped:
        print(f"skipped: {test.id()}: {reason}")
    verdict = "ok" if result.wasSuccessful() else "FAILED"
    # As cargo's summary.
    print(f"test result: {verdict}. {result.testsRun - failed - skipped} passed; {failed} failed; {skipped} ignored; 0 measured")
    return result.wasSuccessful()


if __name__ == "__main__":
    passed = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(0 if passed else 1)
