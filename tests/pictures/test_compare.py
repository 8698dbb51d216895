# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tests of the measures in compare.py on made-up pictures whose true differences are known.

    PYTHON_WITH_BPY tests/pictures/test_compare.py
"""

import os
import sys
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import compare  # noqa: E402


def replicates(truth, noise, seed, count=4):
    """Noisy pictures of `truth` (log-normal factors of mean 1 with the relative deviation `noise`)."""
    dice = np.random.default_rng(seed)
    spread = np.sqrt(np.log(1.0 + noise * noise))
    return [truth * dice.lognormal(-spread * spread / 2.0, spread, truth.shape) for _ in range(count)]


def truth(seed=1, height=72, width=96):
    return np.random.default_rng(seed).uniform(0.05, 2.0, (height, width, 3))


def true_error(x, r):
    return np.mean((x - r) ** 2 / (r * r + 0.01))


class Measures(unittest.TestCase):
    def test_noise_alone_is_no_error(self):
        """The estimate's mean over 40 trials is 0 within 4 standard errors, and its own standard error is honest."""
        r = truth()
        trials = [
            compare.relative_error(replicates(r, 0.3, 1000 + 2 * trial), replicates(r, 0.3, 1001 + 2 * trial))
            for trial in range(40)
        ]
        estimates, errors = np.array(trials).T
        self.assertLess(abs(estimates.mean()), 4.0 * errors.mean() / np.sqrt(40))
        # The spread of 40 estimates has itself a relative deviation of 1 / sqrt(80) = 0.11.
        self.assertLess(abs(estimates.std(ddof=1) / errors.mean() - 1.0), 4.0 * 0.11)

    def test_a_known_error_is_found(self):
        r = truth()
        x = r * (1.0 + 0.05 * np.sign(r - 1.0))
        estimate, error = compare.relative_error(replicates(x, 0.2, 5), replicates(r, 0.2, 6))
        # The weight comes from two noisy pictures: E[1 / (r'^2 + 0.01)] is above 1 / (r^2 + 0.01) by at most
        # 3 x 0.2^2 / 2 = 6 %, to second order.
        wanted = true_error(x, r)
        self.assertGreater(estimate, wanted - 3.0 * error)
        self.assertLess(estimate, 1.06 * wanted + 3.0 * error)

    def test_a_wrong_picture_fails(self):
        r = truth()
        for factor in (1.02, 0.98):
            result = compare.compare("made up", replicates(r * factor, 0.1, 7), replicates(r, 0.1, 8))
            self.assertFalse(result["passed"], result)
        self.assertTrue(compare.compare("made up", replicates(r, 0.1, 9), replicates(r, 0.1, 10))["passed"])

    def test_too_much_noise_fails(self):
        r = truth(height=12, width=16)
        self.assertFalse(compare.compare("made up", replicates(r, 1.5, 11), replicates(r, 1.5, 12))["passed"])

    def test_luminance_ratio(self):
        r = truth()
        ratio, error = compare.luminance_ratio(replicates(r * 1.03, 0.3, 13), replicates(r, 0.3, 14))
        self.assertLess(abs(ratio - 1.03), 3.0 * error)
        self.assertLess(error, 0.005)


if __name__ == "__main__":
    unittest.main()
