"""Figures of the evaluation's statistics from statsmodels and SciPy, for crates/evaluation/tests/statistics.rs.

    python -m venv /some/venv && /some/venv/bin/pip install statsmodels==0.14.5 scipy
    /some/venv/bin/python tests/judges/evaluation_statistics_reference.py tests/data/evaluation_statistics_reference.json
"""

import json
import sys

import scipy
import scipy.stats
import statsmodels
from statsmodels.stats.contingency_tables import mcnemar
from statsmodels.stats.proportion import proportion_confint

SHARES = [(0, 1), (1, 1), (0, 100), (1, 100), (50, 100), (82, 100), (83, 100), (97, 100), (99, 100), (100, 100),
          (3, 7), (0, 5), (5, 5), (1234, 5000), (9999, 10000)]
PAIRS = [(0, 0), (1, 0), (0, 1), (5, 5), (10, 2), (2, 10), (15, 3), (30, 12), (0, 20), (60, 41), (180, 120), (7, 8)]


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
    versions = {"statsmodels": statsmodels.__version__, "scipy": scipy.__version__}
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"versions": versions, "wilson": wilson, "mcnemar": pairs}, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main(sys.argv[1])
