"""Gains and Riccati solutions of random LQR problems, found by SciPy.

Judge of `optimal_control::{continuous_lqr, discrete_lqr}`. Writes `tests/data/mpc_lqr_scipy_reference.json`.

    pip install scipy==1.17.1 numpy
    python tests/judges/scipy_lqr_reference.py
"""

import json
import pathlib

import numpy as np
import scipy
from scipy.linalg import solve_continuous_are, solve_discrete_are

SEED = 7
SHAPES = [(1, 1), (2, 1), (3, 2), (4, 2), (6, 3), (8, 2)]
PER_SHAPE = 4


def main():
    rng = np.random.default_rng(SEED)
    cases = []
    for nx, nu in SHAPES:
        for _ in range(PER_SHAPE):
            a = rng.normal(size=(nx, nx))
            b = rng.normal(size=(nx, nu))
            root_q, root_r = rng.normal(size=(nx, nx)), rng.normal(size=(nu, nu))
            q = root_q @ root_q.T + 0.1 * np.eye(nx)
            r = root_r @ root_r.T + 0.1 * np.eye(nu)
            p_continuous = solve_continuous_are(a, b, q, r)
            p_discrete = solve_discrete_are(a, b, q, r)
            cases.append(
                {
                    "a": a.tolist(),
                    "b": b.tolist(),
                    "q": q.tolist(),
                    "r": r.tolist(),
                    "continuous_gain": np.linalg.solve(r, b.T @ p_continuous).tolist(),
                    "continuous_riccati": p_continuous.tolist(),
                    "discrete_gain": np.linalg.solve(r + b.T @ p_discrete @ b, b.T @ p_discrete @ a).tolist(),
                    "discrete_riccati": p_discrete.tolist(),
                }
            )
    document = {
        "made_by": "tests/judges/scipy_lqr_reference.py",
        "scipy": scipy.__version__,
        "seed": SEED,
        "cases": cases,
    }
    target = pathlib.Path(__file__).resolve().parents[1] / "data" / "mpc_lqr_scipy_reference.json"
    target.write_text(json.dumps(document) + "\n")
    print(f"{len(cases)} cases")


if __name__ == "__main__":
    main()
