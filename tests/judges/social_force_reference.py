"""Independent social-force pedestrians in numpy, the judge of `crowd_sim`.

Written from the published formulas of the social force model as lightsfm and HuNavSim use it, not from the Rust code:
angles are taken with complex numbers and all pairs are evaluated as arrays.

    python tests/judges/social_force_reference.py        # writes tests/data/social_force_reference.json

Needs numpy only. The stored scene has ten people for ten seconds at 100 Hz; every tenth state is kept.
"""

import json
import pathlib

import numpy as np

GOAL_WEIGHT, RELAXATION_S, SOCIAL_WEIGHT = 2.0, 0.5, 5.0
LAMBDA, GAMMA, N_PRIME, N = 2.0, 0.35, 3.0, 2.0
DT_S, STEPS, KEEP_EVERY, REACHED_MARGIN_M = 0.01, 1000, 10, 0.1


def scene(seed: int = 7, count: int = 10) -> dict:
    rng = np.random.default_rng(seed)
    low, high = np.array([0.0, -4.0]), np.array([9.0, 4.0])
    return {
        "position_m": rng.uniform(low, high, (count, 2)),
        "goals_m": rng.uniform(low, high, (count, 3, 2)),
        "desired_speed_mps": rng.uniform(0.6, 1.5, count),
        "goal_radius_m": np.where(np.arange(count) % 2 == 0, 0.3, 0.05),
    }


def social_forces(p: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Sum over all others of w_s (f_v t + f_theta n), rows are people."""
    z, w = p[:, 0] + 1j * p[:, 1], v[:, 0] + 1j * v[:, 1]
    diff = z[None, :] - z[:, None]
    np.fill_diagonal(diff, 1.0)
    d = np.abs(diff)
    e = diff / d
    interaction = LAMBDA * (w[:, None] - w[None, :]) + e
    b = GAMMA * np.abs(interaction)
    t = interaction / np.abs(interaction)
    theta = np.angle(e) - np.angle(t)
    theta = np.where(theta <= -np.pi, theta + 2 * np.pi, theta)
    theta = np.where(theta > np.pi, theta - 2 * np.pi, theta)
    # Equal velocities make the angle zero; what the subtraction leaves is rounding, not a side to step to.
    theta = np.where(np.abs(theta) < 1e-12, 0.0, theta)
    f_v = -np.exp(-d / b - (N_PRIME * b * theta) ** 2)
    f_theta = -np.sign(theta) * np.exp(-d / b - (N * b * theta) ** 2)
    f = SOCIAL_WEIGHT * (f_v + 1j * f_theta) * t
    np.fill_diagonal(f, 0.0)
    f = f.sum(axis=1)
    return np.stack([f.real, f.imag], axis=1)


def simulate(s: dict) -> tuple[np.ndarray, np.ndarray, int]:
    p, v = s["position_m"].copy(), np.zeros_like(s["position_m"])
    rows, current, switches = np.arange(len(p)), np.zeros(len(p), dtype=int), 0
    positions, velocities = [p.copy()], [v.copy()]
    for step in range(1, STEPS + 1):
        to_goal = s["goals_m"][rows, current] - p
        dist = np.linalg.norm(to_goal, axis=1)
        arrived = dist <= s["goal_radius_m"] + REACHED_MARGIN_M
        pull = GOAL_WEIGHT / RELAXATION_S * (s["desired_speed_mps"][:, None] * to_goal / dist[:, None] - v)
        v_new = v + (pull + social_forces(p, v)) * DT_S
        speed = np.linalg.norm(v_new, axis=1)
        v_new *= np.minimum(1.0, s["desired_speed_mps"] / np.maximum(speed, 1e-300))[:, None]
        # Whoever has arrived turns to the next goal and does not move; velocity is the difference of positions.
        v = np.where(arrived[:, None], 0.0, v_new)
        p = p + v * DT_S
        current = (current + arrived) % s["goals_m"].shape[1]
        switches += int(arrived.sum())
        if step % KEEP_EVERY == 0:
            positions.append(p.copy())
            velocities.append(v.copy())
    return np.array(positions), np.array(velocities), switches


if __name__ == "__main__":
    s = scene()
    positions, velocities, switches = simulate(s)
    gaps = np.linalg.norm(positions[:, :, None] - positions[:, None, :], axis=-1)
    gaps += 100.0 * np.eye(gaps.shape[1])
    print(f"goal switches {switches}, closest centres {gaps.min():.3f} m")
    data = {
        "script": "tests/judges/social_force_reference.py",
        "dt_s": DT_S,
        "keep_every": KEEP_EVERY,
        "goal_switches": switches,
        **{key: value.tolist() for key, value in s.items()},
        "positions_m": positions.tolist(),
        "velocities_mps": velocities.tolist(),
    }
    out = pathlib.Path(__file__).parent.parent / "data" / "social_force_reference.json"
    out.write_text(json.dumps(data) + "\n")
