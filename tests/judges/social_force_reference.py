"""Independent pedestrians in numpy, the judge of `crowd_sim`.

Written from the published formulas of the social force model as lightsfm and HuNavSim use it, not from the Rust code:
angles are taken with complex numbers and all pairs are evaluated as arrays. In the second scene five walk so among three who
bounce off walls (a triangle wave here) and four on recorded tracks (scipy's Hermite spline over numpy's gradient), two of
whom come late and two of whom leave early.

    python tests/judges/social_force_reference.py   # writes tests/data/{social_force,mixed_crowd}_reference.json

Needs numpy and scipy. The stored scenes have ten and twelve people for ten seconds at 100 Hz; every tenth state is kept.
"""

import json
import pathlib

import numpy as np
from scipy.interpolate import CubicHermiteSpline

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


def mixed_scene(seed: int = 11) -> dict:
    rng = np.random.default_rng(seed)
    low, high = np.array([0.0, -4.0]), np.array([9.0, 4.0])
    angle = rng.uniform(-np.pi, np.pi, 3)
    tracks = []
    for first, last in [(-1.0, 30.0), (2.015, 30.0), (0.0, 6.43), (3.2, 7.0)]:
        times = np.cumsum(np.concatenate([[first], rng.uniform(0.1, 0.6, int((last - first) / 0.3))]))
        times = times[times <= last]
        headings = np.cumsum(rng.normal(0.0, 0.3, len(times))) + rng.uniform(-np.pi, np.pi)
        steps = np.diff(times, prepend=times[0])[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1)
        tracks.append({"times_s": times, "positions_m": rng.uniform([3.0, -2.0], [6.0, 2.0]) + np.cumsum(steps, axis=0)})
    return {
        "arena_m": np.array([low, high]),
        "position_m": rng.uniform(low, high, (5, 2)),
        "goals_m": rng.uniform(low, high, (5, 3, 2)),
        "desired_speed_mps": rng.uniform(0.6, 1.5, 5),
        "goal_radius_m": np.full(5, 0.3),
        "bounce_position_m": rng.uniform(low, high, (3, 2)),
        "bounce_velocity_mps": rng.uniform(0.8, 1.5, 3)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1),
        "tracks": tracks,
    }


def triangle_wave(start: np.ndarray, velocity: np.ndarray, time_s: float, arena: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where reflections lead, and the velocity: the unfolded way modulo two widths, its second half backwards."""
    low, width = arena[0], arena[1] - arena[0]
    phase = np.mod(start - low + velocity * time_s, 2 * width)
    return low + width - np.abs(width - phase), np.where(phase > width, -velocity, velocity)


def simulate_mixed(s: dict) -> dict:
    splines = [
        CubicHermiteSpline(t["times_s"], t["positions_m"], np.gradient(t["positions_m"], t["times_s"], axis=0))
        for t in s["tracks"]
    ]

    def others(time_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        bp, bv = triangle_wave(s["bounce_position_m"], s["bounce_velocity_mps"], time_s, s["arena_m"])
        here = np.array([x.x[0] - 1e-9 <= time_s <= x.x[-1] + 1e-9 for x in splines])
        tp = np.array([x(time_s) if ok else [np.nan] * 2 for x, ok in zip(splines, here)])
        tv = np.array([x(time_s, 1) if ok else [np.nan] * 2 for x, ok in zip(splines, here)])
        return np.concatenate([bp, tp]), np.concatenate([bv, tv]), np.concatenate([[True] * len(bp), here])

    walkers, current = s["position_m"].copy(), np.zeros(5, dtype=int)
    v, rows = np.zeros_like(walkers), np.arange(5)
    kept: dict = {"positions_m": [], "velocities_mps": [], "present": []}
    for step in range(STEPS + 1):
        op, ov, here = others(step * DT_S)
        if step % KEEP_EVERY == 0:
            kept["positions_m"].append(np.where(np.isnan(q := np.concatenate([walkers, op])), 0.0, q).tolist())
            kept["velocities_mps"].append(np.where(np.isnan(q := np.concatenate([v, ov])), 0.0, q).tolist())
            kept["present"].append([True] * 5 + here.tolist())
        force = social_forces(np.concatenate([walkers, op[here]]), np.concatenate([v, ov[here]]))[:5]
        to_goal = s["goals_m"][rows, current] - walkers
        dist = np.linalg.norm(to_goal, axis=1)
        arrived = dist <= s["goal_radius_m"] + REACHED_MARGIN_M
        pull = GOAL_WEIGHT / RELAXATION_S * (s["desired_speed_mps"][:, None] * to_goal / dist[:, None] - v)
        v_new = v + (pull + force) * DT_S
        speed = np.linalg.norm(v_new, axis=1)
        v_new *= np.minimum(1.0, s["desired_speed_mps"] / np.maximum(speed, 1e-300))[:, None]
        v = np.where(arrived[:, None], 0.0, v_new)
        walkers = walkers + v * DT_S
        current = (current + arrived) % 3
    return kept


def plain(value):
    """Arrays as lists, however deep."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list) else value


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

    s = mixed_scene()
    data = {"script": "tests/judges/social_force_reference.py", "dt_s": DT_S, "keep_every": KEEP_EVERY}
    data |= plain(s) | simulate_mixed(s)
    out.with_name("mixed_crowd_reference.json").write_text(json.dumps(data) + "\n")
