"""The Kalman filter and the interacting multiple models of filterpy, the judge of `obstacle_estimator`.

    python -m venv judge && judge/bin/pip install filterpy numpy scipy
    judge/bin/python tests/judges/estimators_reference.py   # writes tests/data/estimators_reference.json

One made-up walk with sightings at irregular intervals, their covariances different along the axes and correlated, is filtered by
filterpy's `KalmanFilter` (constant velocity, discrete white-noise acceleration) and by its `IMMEstimator` (two such walks and a
decaying acceleration). Means, covariances and probabilities after every fifth sighting are stored, and scipy's optimal
assignments of random matrices of costs.
"""

import json
import pathlib

import numpy as np
from filterpy.kalman import IMMEstimator, KalmanFilter
from scipy.optimize import linear_sum_assignment

STEPS, KEEP_EVERY = 60, 5
INITIAL_SPEED_SD = 1.5
KALMAN_Q, CALM_Q, LIVELY_Q = 1.0, 0.3, 2.0
MANOEUVRE_SD, MANOEUVRE_TAU, MEAN_STAY = 2.0, 0.5, 1.7
H = np.kron([[1.0, 0.0, 0.0]], np.eye(2))


def walk(t: float, q: float) -> tuple[np.ndarray, np.ndarray]:
    """Constant velocity along one axis; the acceleration is no part of it."""
    gain = q * np.array([[t**2 / 2], [t], [0.0]])
    return np.array([[1, t, 0], [0, 1, 0], [0, 0, 0.0]]), gain @ gain.T


def manoeuvre(t: float) -> tuple[np.ndarray, np.ndarray]:
    tau, rho = MANOEUVRE_TAU, np.exp(-t / MANOEUVRE_TAU)
    gain = MANOEUVRE_SD * np.sqrt(1 - rho**2) * np.array([[t**2 / 6], [t / 2], [1.0]])
    return np.array([[1, t, tau * (t - tau * (1 - rho))], [0, 1, tau * (1 - rho)], [0, 0, rho]]), gain @ gain.T


def both_axes(motion: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return np.kron(motion[0], np.eye(2)), np.kron(motion[1], np.eye(2))


def begin(y: np.ndarray, r: np.ndarray, acceleration_sd: float) -> KalmanFilter:
    kf = KalmanFilter(dim_x=6, dim_z=2)
    kf.H, kf.x = H, np.concatenate([y, np.zeros(4)])
    kf.P = np.zeros((6, 6))
    kf.P[:2, :2] = r
    kf.P[2:4, 2:4] = INITIAL_SPEED_SD**2 * np.eye(2)
    kf.P[4:, 4:] = acceleration_sd**2 * np.eye(2)
    return kf


def sightings() -> list[dict]:
    rng = np.random.default_rng(11)
    p, v, out = np.array([1.0, -2.0]), np.array([0.9, 0.3]), []
    for k in range(STEPS):
        t = rng.uniform(0.02, 0.2)
        a = np.array([0.0, 0.0]) if k < 20 else np.array([-1.5, 1.0]) if k < 30 else np.array([0.4, -0.8])
        p, v = p + v * t + a * t**2 / 2, v + a * t
        sd, angle = rng.uniform(0.02, 0.15, 2), rng.uniform(0, np.pi)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        r = turn @ np.diag(sd**2) @ turn.T
        out.append({"elapsed_s": t, "position_m": rng.multivariate_normal(p, r), "covariance_m2": r})
    return out


def kalman(seen: list[dict]) -> list[dict]:
    kf, kept = begin(seen[0]["position_m"], seen[0]["covariance_m2"], 0.0), []
    for k, s in enumerate(seen[1:], start=1):
        f, q = both_axes(walk(s["elapsed_s"], KALMAN_Q))
        kf.predict(F=f, Q=q)
        kf.update(s["position_m"], R=s["covariance_m2"])
        if k % KEEP_EVERY == 0:
            kept.append({"after": k, "mean": kf.x.copy(), "covariance": kf.P.copy()})
    return plain(kept)


def imm(seen: list[dict]) -> list[dict]:
    y, r = seen[0]["position_m"], seen[0]["covariance_m2"]
    filters = [begin(y, r, 0.0), begin(y, r, 0.0), begin(y, r, MANOEUVRE_SD)]
    bank, kept = IMMEstimator(filters, np.full(3, 1 / 3), np.eye(3)), []
    for k, s in enumerate(seen[1:], start=1):
        t = s["elapsed_s"]
        # The continuous-time chain whose every state is left after MEAN_STAY on average, for either other one alike.
        left = 2 / 3 * (1 - np.exp(-1.5 * t / MEAN_STAY))
        bank.M = np.full((3, 3), left / 2) + np.eye(3) * (1 - 1.5 * left)
        bank._compute_mixing_probabilities()
        for kf, motion in zip(filters, [walk(t, CALM_Q), walk(t, LIVELY_Q), manoeuvre(t)]):
            kf.F, kf.Q = both_axes(motion)
            kf.R = s["covariance_m2"]
        bank.predict()
        bank.update(s["position_m"])
        if k % KEEP_EVERY == 0:
            kept.append({"after": k, "mean": bank.x.copy(), "covariance": bank.P.copy(), "probabilities": bank.mu.copy()})
    return plain(kept)


def assignments() -> list[dict]:
    """The pairs that gain most together; a third of all pairs gain nothing and are not formed."""
    rng, kept = np.random.default_rng(3), []
    for shape in [(1, 1), (3, 3), (4, 7), (9, 5), (16, 16), (30, 30), (64, 12)]:
        gains = np.where(rng.uniform(size=shape) > 1 / 3, rng.uniform(0.0, 9.0, shape).round(6), 0.0)
        pairs = [[int(i), int(j)] for i, j in zip(*linear_sum_assignment(gains, maximize=True)) if gains[i, j] > 0]
        kept.append({"gains": gains.tolist(), "pairs": pairs})
    return kept


def plain(records: list[dict]) -> list[dict]:
    return [{k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in record.items()} for record in records]


if __name__ == "__main__":
    seen = sightings()
    out = pathlib.Path(__file__).parents[1] / "data" / "estimators_reference.json"
    out.write_text(json.dumps({
        "made_by": "tests/judges/estimators_reference.py",
        "sightings": plain(seen),
        "kalman": kalman(seen),
        "imm": imm(seen),
        "assignments": assignments(),
    }) + "\n")
