"""Optimal costs of random unicycle MPC problems, found by CasADi and IPOPT.

Judge of `optimal_control::UnicycleMpc`. Writes `tests/data/mpc_casadi_reference.json`; the Rust test reads
that file and never runs Python.

    pip install casadi==3.8.2 numpy
    python tests/judges/casadi_mpc_reference.py

Problem: x = (x, y, heading) relative to the goal pose, u = (speed, yaw rate), Euler step 0.1 s, 20 steps,
J = sum_{k<20} x_k' Q x_k + u_k' R u_k + x_20' Q x_20 with Q = diag(50, 50, 1), R = I, speed in
[0.25, 1] m/s, yaw rate in [-0.8, 0.8] rad/s. The problem is nonconvex, so each one is solved from nine starts:
the first is what a controller without memory has (slowest straight line), the others are random controls.
Stored per problem: start state, cost and first control from the first start ("cold"), and the least cost over all
starts that converged ("best").
"""

import json
import pathlib

import casadi as ca
import numpy as np

STEPS = 20
STEP_S = 0.1
STATE_WEIGHT = [50.0, 50.0, 1.0]
CONTROL_WEIGHT = [1.0, 1.0]
CONTROL_MIN = [0.25, -0.8]
CONTROL_MAX = [1.0, 0.8]
PROBLEMS = 120
RANDOM_STARTS = 8
SEED = 20240611


def euler(x, u):
    return x + STEP_S * ca.vertcat(u[0] * ca.cos(x[2]), u[0] * ca.sin(x[2]), u[1])


def build():
    states = ca.MX.sym("X", 3, STEPS + 1)
    controls = ca.MX.sym("U", 2, STEPS)
    start = ca.MX.sym("x0", 3)
    q, r = ca.diag(STATE_WEIGHT), ca.diag(CONTROL_WEIGHT)
    cost = ca.bilin(q, states[:, STEPS])
    gaps = [states[:, 0] - start]
    for k in range(STEPS):
        cost += ca.bilin(q, states[:, k]) + ca.bilin(r, controls[:, k])
        gaps.append(states[:, k + 1] - euler(states[:, k], controls[:, k]))
    nlp = {
        "x": ca.vertcat(ca.vec(states), ca.vec(controls)),
        "f": cost,
        "g": ca.vertcat(*gaps),
        "p": start,
    }
    options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-9, "max_iter": 2000}}
    return ca.nlpsol("mpc", "ipopt", nlp, options)


def solve(solver, start, controls):
    states = [np.asarray(start, dtype=float)]
    for u in controls:
        x = states[-1]
        states.append(x + STEP_S * np.array([u[0] * np.cos(x[2]), u[0] * np.sin(x[2]), u[1]]))
    guess = np.concatenate([np.concatenate(states), controls.ravel()])
    free = np.full(3 * (STEPS + 1), np.inf)
    low = np.concatenate([-free, np.tile(CONTROL_MIN, STEPS)])
    high = np.concatenate([free, np.tile(CONTROL_MAX, STEPS)])
    result = solver(x0=guess, p=start, lbx=low, ubx=high, lbg=0.0, ubg=0.0)
    stats = solver.stats()
    first = np.asarray(result["x"]).ravel()[3 * (STEPS + 1):][:2]
    return bool(stats["success"]), float(result["f"]), first.tolist()


def main():
    rng = np.random.default_rng(SEED)
    solver = build()
    straight = np.tile([CONTROL_MIN[0], 0.0], (STEPS, 1))
    problems = []
    for index in range(PROBLEMS):
        # Three ranges alternate: at the goal, within the horizon, far beyond it.
        low, high = [(0.3, 1.0), (1.0, 3.0), (3.0, 15.0)][index % 3]
        distance, bearing = rng.uniform(low, high), rng.uniform(-np.pi, np.pi)
        start = [distance * np.cos(bearing), distance * np.sin(bearing), rng.uniform(-np.pi, np.pi)]
        converged, cold_cost, cold_first = solve(solver, start, straight)
        assert converged, f"IPOPT failed on problem {index}"
        best_cost, best_first = cold_cost, cold_first
        for _ in range(RANDOM_STARTS):
            guess = rng.uniform(CONTROL_MIN, CONTROL_MAX, (STEPS, 2))
            converged, cost, first = solve(solver, start, guess)
            if converged and cost < best_cost:
                best_cost, best_first = cost, first
        problems.append(
            {
                "start": start,
                "cold_cost": cold_cost,
                "cold_first_control": cold_first,
                "best_cost": best_cost,
                "best_first_control": best_first,
            }
        )
    document = {
        "made_by": "tests/judges/casadi_mpc_reference.py",
        "casadi": ca.__version__,
        "seed": SEED,
        "problems": problems,
    }
    target = pathlib.Path(__file__).resolve().parents[1] / "data" / "mpc_casadi_reference.json"
    target.write_text(json.dumps(document, indent=1) + "\n")
    worse = sum(p["cold_cost"] > p["best_cost"] * (1 + 1e-3) for p in problems)
    print(f"{len(problems)} problems; the cold start missed the best known optimum on {worse}")


if __name__ == "__main__":
    main()
