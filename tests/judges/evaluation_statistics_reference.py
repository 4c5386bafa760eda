"""Figures of the evaluation's statistics from statsmodels and SciPy, for crates/evaluation/tests/statistics.rs.

Neither package has an interval for the difference of paired shares. Newcombe's is put together here from statsmodels' Wilson
intervals and numpy's correlation of the pairs themselves, and held against SciPy's BCa bootstrap and against its own coverage.

    python -m venv /some/venv && /some/venv/bin/pip install statsmodels==0.14.5 scipy
    /some/venv/bin/python tests/judges/evaluation_statistics_reference.py tests/data/evaluation_statistics_reference.json
"""

import json
import sys

import numpy as np
import scipy
import scipy.stats
import statsmodels
from statsmodels.stats.contingency_tables import mcnemar
from statsmodels.stats.proportion import proportion_confint

SHARES = [(0, 1), (1, 1), (0, 100), (1, 100), (50, 100), (82, 100), (83, 100), (97, 100), (99, 100), (100, 100),
          (3, 7), (0, 5), (5, 5), (1234, 5000), (9999, 10000)]
PAIRS = [(0, 0), (1, 0), (0, 1), (5, 5), (10, 2), (2, 10), (15, 3), (30, 12), (0, 20), (60, 41), (180, 120), (7, 8)]


# both, only the first, only the second, neither.
TABLES = [(36, 12, 2, 0), (60, 18, 5, 17), (70, 20, 4, 6), (50, 5, 25, 20), (98, 1, 1, 0), (100, 0, 0, 0), (0, 0, 0, 50),
          (0, 30, 0, 70), (0, 20, 20, 0), (40, 10, 10, 40), (3, 2, 1, 4), (1, 0, 0, 0), (333, 77, 21, 69)]


def paired_difference(both, only_first, only_second, neither):
    cells = np.array([both, only_first, only_second, neither])
    n = int(cells.sum())
    first = np.repeat([1, 1, 0, 0], cells)
    second = np.repeat([1, 0, 1, 0], cells)
    shares = [first.mean(), second.mean()]
    bounds = [proportion_confint(int(one.sum()), n, alpha=0.05, method="wilson") for one in (first, second)]
    phi = 0.0
    if all(0.0 < share < 1.0 for share in shares):
        covariance = (first * second).mean() - shares[0] * shares[1]
        # The numerator of phi, less n/2 where it is positive, is n^2 times the covariance.
        corrected = max(covariance - 0.5 / n, 0.0) if covariance > 0.0 else covariance
        phi = corrected / (first.std() * second.std())
    (low_1, high_1), (low_2, high_2) = bounds
    down = np.array([shares[0] - low_1, high_2 - shares[1]])
    up = np.array([high_1 - shares[0], shares[1] - low_2])
    spread = np.array([[1.0, -phi], [-phi, 1.0]])
    difference = shares[0] - shares[1]
    return difference, difference - np.sqrt(down @ spread @ down), difference + np.sqrt(up @ spread @ up)


def check_paired_difference():
    # Newcombe's own worked table.
    assert np.allclose(paired_difference(36, 12, 2, 0), (0.2, 0.0569, 0.3404), atol=5e-5)
    for table in [(60, 18, 5, 17), (50, 5, 25, 20), (333, 77, 21, 69)]:
        pairs = np.repeat([1.0, 1.0, -1.0, 0.0], [0, table[1], table[2], table[0] + table[3]])
        drawn = scipy.stats.bootstrap((pairs,), np.mean, n_resamples=9999, random_state=1).confidence_interval
        _, low, high = paired_difference(*table)
        assert abs(low - drawn.low) < 0.02 and abs(high - drawn.high) < 0.02, (table, low, high, drawn)
    random = np.random.default_rng(1)
    for chances in [(0.7, 0.15, 0.05, 0.1), (0.4, 0.2, 0.2, 0.2), (0.9, 0.06, 0.02, 0.02)]:
        truth = chances[1] - chances[2]
        tables = random.multinomial(100, chances, 2000)
        covered = [low <= truth <= high for _, low, high in (paired_difference(*table) for table in tables)]
        assert 0.935 < np.mean(covered) < 0.985, (chances, np.mean(covered))


def main(path):
    wilson = []
    for successes, trials in SHARES:
        low, high = proportion_confint(successes, trials, alpha=0.05, method="wilson")
        by_scipy = scipy.stats.binomtest(successes, trials).proportion_ci(0.95, method="wilson")
        assert abs(low - by_scipy.low) < 1e-12 and abs(high - by_scipy.high) < 1e-12, (successes, trials)
        wilson.append({"successes": successes, "trials": trials, "low": low, "high": high})
    pairs = []
    for first, second in PAIRS:
        p = float(mcnemar([[3, first], [second, 4]], exact=True).pvalue)
        if first + second > 0:
            by_scipy = scipy.stats.binomtest(first, first + second, 0.5).pvalue
            assert abs(p - by_scipy) < 1e-12, (first, second)
        pairs.append({"only_first": first, "only_second": second, "p": p})
    check_paired_difference()
    differences = []
    for table in TABLES:
        cells = dict(zip(("both", "only_first", "only_second", "neither"), table, strict=True))
        difference, low, high = map(float, paired_difference(*table))
        differences.append(cells | {"difference": difference, "low": low, "high": high})
    versions = {"statsmodels": statsmodels.__version__, "scipy": scipy.__version__}
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"versions": versions, "wilson": wilson, "mcnemar": pairs, "paired_difference": differences}, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main(sys.argv[1])
