"""Optimal plans of the four planners of crate `baselines`, found by CasADi and IPOPT.

Judge of SDF-MPC, DCBF-MPC, VO-MPC and RNTC-MPC. Writes `tests/data/baselines_casadi_reference.json`; the Rust test reads
that file and never runs Python.

    pip install casadi==3.8.2 numpy
    nice python tests/judges/casadi_baselines_reference.py

Problem: x = (x, y, heading), u = (speed, yaw rate), Euler step 0.1 s, 20 steps, goal pose at the origin,
J = sum_{k<20} x_k' Q x_k + u_k' R u_k + x_20' Q x_20 with Q = diag(50, 50, 1), R = I, speed in [0.25, 1] m/s, yaw rate in
[-0.8, 0.8] rad/s, up to four discs that keep their velocities, contact at 0.7 m. Hard demands, no slack, states free; the
distance at k = 0, which no control changes, is left out:

    sdf_mpc   |p_k - x_k| - R >= 0                     k = 1..20
    dcbf_mpc  h_k >= 0.7 h_{k-1}, h = |p - x| - R      k = 1..20
    vo_mpc    acos(cos angle(v_rel, p_rel)) >= asin(R / |p_rel|), both arguments cut at 0.999     k = 0..19
    rntc_mpc  as sdf_mpc for k < 20, and the model's value at the last state >= 0; the model is models/ground_robot_paper

The problems are nonconvex. Each is solved from a policy that turns to the goal and drives (to the left, to the right),
from the slowest straight line, from the corners of the control box and from random controls. Stored per problem: what IPOPT said from the first start and how
much processor time it took, and cost and first control of every start that ended at a feasible point.
"""

import json
import pathlib
import struct
import time

import casadi as ca
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
METHODS = ["sdf_mpc", "dcbf_mpc", "vo_mpc", "rntc_mpc"]
STEPS = 20
STEP_S = 0.1
STATE_WEIGHT = [50.0, 50.0, 1.0]
CONTROL_WEIGHT = [1.0, 1.0]
CONTROL_MIN = np.array([0.25, -0.8])
CONTROL_MAX = np.array([1.0, 0.8])
CONTACT_M = 0.7
GAMMA = 0.3
CUT = 1.0 - 1e-3
SLOTS = 4
ABSENT = [-100.0, -100.0, -0.01, 0.01]
PROBLEMS_PER_METHOD = 50
RANDOM_STARTS = 4
SEED = 20261122


def euler(x, u):
    return x + STEP_S * ca.vertcat(u[0] * ca.cos(x[2]), u[0] * ca.sin(x[2]), u[1])


def load_model():
    data = (ROOT / "models" / "ground_robot_paper.safetensors").read_bytes()
    (size,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8:8 + size])
    metadata = json.loads(header["__metadata__"]["cncbf"])
    tensors = {}
    for name, entry in header.items():
        if name != "__metadata__":
            first, last = entry["data_offsets"]
            raw = np.frombuffer(data[8 + size + first:8 + size + last], dtype=np.float32)
            tensors[name] = raw.astype(float).reshape(entry["shape"])
    return metadata, tensors


METADATA, TENSORS = load_model()


def value_function(state, obstacle):
    """The pairwise model at a robot state and an obstacle (x, y, heading, speed)."""
    low, high = METADATA["grid"]["min"], METADATA["grid"]["max"]
    dx, dy = obstacle[0] - state[0], obstacle[1] - state[1]
    c, s = ca.cos(state[2]), ca.sin(state[2])
    z = [c * dx + s * dy, -s * dx + c * dy, obstacle[2] - state[2], obstacle[3]]
    placed = [ca.fmin(ca.fmax(z[i], low[i]), high[i]) for i in range(4)]
    heading = ca.atan2(ca.sin(z[2]), ca.cos(z[2]))
    if METADATA["encoding"] == "raw":
        a = ca.vertcat(placed[0], placed[1], heading, placed[3])
    else:
        a = ca.vertcat(placed[0], placed[1], ca.cos(heading), ca.sin(heading), placed[3])
    layers = len(TENSORS) // 2
    for index in range(layers):
        y = ca.mtimes(TENSORS[f"layers.{index}.weight"], a) + TENSORS[f"layers.{index}.bias"]
        a = ca.sin(y) if index + 1 < layers else y
    residual = ca.fmax(a, 0) + ca.log1p(ca.exp(-ca.fabs(a)))
    return ca.sqrt(dx * dx + dy * dy) - CONTACT_M - residual


def demands(method, states, controls, obstacles):
    rows = []

    def place(j, k):
        return obstacles[:2, j] + k * STEP_S * obstacles[2:4, j]

    def distance(j, k):
        return ca.norm_2(place(j, k) - states[:2, k]) - CONTACT_M

    for j in range(SLOTS):
        for k in range(1, STEPS + 1):
            if method == "dcbf_mpc":
                rows.append(distance(j, k) - (1 - GAMMA) * distance(j, k - 1))
            elif method == "sdf_mpc" or (method == "rntc_mpc" and k < STEPS):
                rows.append(distance(j, k))
            elif method == "rntc_mpc":
                other = ca.vertcat(place(j, k), obstacles[4, j], obstacles[5, j])
                rows.append(value_function(states[:, k], other))
        if method == "vo_mpc":
            for k in range(STEPS):
                p = place(j, k) - states[:2, k]
                u = controls[0, k]
                v = u * ca.vertcat(ca.cos(states[2, k]), ca.sin(states[2, k])) - obstacles[2:4, j]
                cosine = ca.dot(p, v) / (ca.norm_2(p) * ca.norm_2(v))
                alpha = ca.acos(ca.fmin(ca.fmax(cosine, -CUT), CUT))
                beta = ca.asin(ca.fmin(ca.fmax(CONTACT_M / ca.norm_2(p), -CUT), CUT))
                rows.append(alpha - beta)
    return ca.vertcat(*rows)


def build(method):
    states = ca.MX.sym("X", 3, STEPS + 1)
    controls = ca.MX.sym("U", 2, STEPS)
    start = ca.MX.sym("x0", 3)
    obstacles = ca.MX.sym("O", 6, SLOTS)
    q, r = ca.diag(STATE_WEIGHT), ca.diag(CONTROL_WEIGHT)
    cost = ca.bilin(q, states[:, STEPS])
    gaps = [states[:, 0] - start]
    for k in range(STEPS):
        cost += ca.bilin(q, states[:, k]) + ca.bilin(r, controls[:, k])
        gaps.append(states[:, k + 1] - euler(states[:, k], controls[:, k]))
    rows = demands(method, states, controls, obstacles)
    nlp = {
        "x": ca.vertcat(ca.vec(states), ca.vec(controls)),
        "f": cost,
        "g": ca.vertcat(*gaps, rows),
        "p": ca.vertcat(start, ca.vec(obstacles)),
    }
    options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 1000}}
    return ca.nlpsol(method, "ipopt", nlp, options), rows.numel()


def roll_out(start, policy):
    states, controls = [np.asarray(start, dtype=float)], []
    for k in range(STEPS):
        x = states[-1]
        u = np.clip(policy(k, x), CONTROL_MIN, CONTROL_MAX)
        controls.append(u)
        states.append(x + STEP_S * np.array([u[0] * np.cos(x[2]), u[0] * np.sin(x[2]), u[1]]))
    return np.concatenate(states), np.concatenate(controls)


def wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def turn_then_drive(side):
    def policy(_, x):
        bearing = wrapped(np.arctan2(-x[1], -x[0]) - x[2])
        turn = bearing
        if side > 0 and bearing < -np.pi / 2:
            turn += 2 * np.pi
        if side < 0 and bearing > np.pi / 2:
            turn -= 2 * np.pi
        return np.array([np.hypot(x[0], x[1]) * np.cos(bearing) / STEP_S, turn / STEP_S])

    return policy


def solve(solver, row_count, problem, policy):
    states, controls = roll_out(problem["start"], policy)
    slots = [[*o[:4], *o[4:]] for o in problem["obstacles"]]
    slots += [[*ABSENT, 0.0, 0.0]] * (SLOTS - len(slots))
    free = np.full(3 * (STEPS + 1), np.inf)
    gaps = np.zeros(3 * (STEPS + 1))
    begun = time.process_time()
    result = solver(
        x0=np.concatenate([states, controls]),
        p=np.concatenate([problem["start"], np.ravel(slots)]),
        lbx=np.concatenate([-free, np.tile(CONTROL_MIN, STEPS)]),
        ubx=np.concatenate([free, np.tile(CONTROL_MAX, STEPS)]),
        lbg=np.concatenate([gaps, np.zeros(row_count)]),
        ubg=np.concatenate([gaps, np.full(row_count, np.inf)]),
    )
    taken_ms = 1e3 * (time.process_time() - begun)
    stats = solver.stats()
    first = np.asarray(result["x"]).ravel()[3 * (STEPS + 1):][:2]
    return {
        "status": stats["return_status"],
        "success": bool(stats["success"]),
        "cost": round(float(result["f"]), 6),
        "first_control": [round(float(u), 6) for u in first],
        "cpu_ms": round(taken_ms, 3),
        "iterations": int(stats["iter_count"]),
    }


def random_problem(rng):
    """A robot on its way to the origin, people around it who walk past or towards it."""
    distance, bearing = rng.uniform(1.0, 12.0), rng.uniform(-np.pi, np.pi)
    start = np.array([distance * np.cos(bearing), distance * np.sin(bearing)])
    heading = wrapped(np.arctan2(-start[1], -start[0]) + rng.normal(0.0, 0.5))
    obstacles = []
    while len(obstacles) < rng.integers(1, SLOTS + 1):
        # Two of three stand or walk in the way, the others anywhere.
        on_the_way = rng.random() < 2 / 3
        around = heading + rng.normal(0.0, 0.4) if on_the_way else rng.uniform(-np.pi, np.pi)
        away = rng.uniform(0.9, 2.6) if on_the_way else rng.uniform(0.75, 4.0)
        place = start + away * np.array([np.cos(around), np.sin(around)])
        walk, speed = rng.uniform(-np.pi, np.pi), rng.uniform(0.05, 1.4)
        if rng.random() < 0.5:
            aim = start + rng.normal(0.0, 0.7, 2)
            walk = np.arctan2(aim[1] - place[1], aim[0] - place[0])
        velocity = speed * np.array([np.cos(walk), np.sin(walk)])
        obstacles.append([*place, *velocity, walk, speed])
    digits = lambda values: [round(float(value), 9) for value in values]
    return {"start": digits([*start, heading]), "obstacles": [digits(o) for o in obstacles]}


def main():
    rng = np.random.default_rng(SEED)
    problems = []
    for method in METHODS:
        solver, row_count = build(method)
        for _ in range(PROBLEMS_PER_METHOD):
            problem = random_problem(rng)
            policies = [turn_then_drive(+1), turn_then_drive(-1), lambda _, x: CONTROL_MIN * [1.0, 0.0]]
            corners = [[1.0, 0.8], [1.0, -0.8], [0.25, 0.8], [0.25, -0.8]]
            policies += [lambda _, x, corner=corner: np.array(corner) for corner in corners]
            for _ in range(RANDOM_STARTS):
                controls = rng.uniform(CONTROL_MIN, CONTROL_MAX, (STEPS, 2))
                policies.append(lambda k, x, controls=controls: controls[k])
            runs = [solve(solver, row_count, problem, policy) for policy in policies]
            feasible = sorted((r["cost"], *r["first_control"]) for r in runs if r["success"])
            minima = []
            for cost, *first in feasible:
                if not minima or cost > minima[-1]["cost"] * (1 + 1e-4):
                    minima.append({"cost": cost, "first_control": first})
            problems.append(
                {
                    "method": method,
                    **problem,
                    "first_status": runs[0]["status"],
                    "first_cost": runs[0]["cost"] if runs[0]["success"] else None,
                    "first_cpu_ms": runs[0]["cpu_ms"],
                    "first_iterations": runs[0]["iterations"],
                    "statuses": sorted({r["status"] for r in runs}),
                    "minima": minima,
                }
            )
        done = [p for p in problems if p["method"] == method]
        solved = sum(bool(p["minima"]) for p in done)
        several = sum(len(p["minima"]) > 1 for p in done)
        times = np.median([p["first_cpu_ms"] for p in done])
        print(f"{method}: feasible {solved} of {len(done)}, several minima {several}, median {times:.1f} ms")
    document = {
        "made_by": "tests/judges/casadi_baselines_reference.py",
        "casadi": ca.__version__,
        "seed": SEED,
        "contact_m": CONTACT_M,
        "problems": problems,
    }
    target = ROOT / "tests" / "data" / "baselines_casadi_reference.json"
    target.write_text(json.dumps(document, separators=(",", ":")).replace('{"method"', '\n{"method"') + "\n")


if __name__ == "__main__":
    main()
