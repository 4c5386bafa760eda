"""How far velocity estimates are off on recorded people, by the filters of `estimators_reference.py`.

    judge/bin/pip install filterpy mcap mcap-ros2-support numpy scipy
    judge/bin/python tests/judges/estimators_on_people.py RECORDING.mcap...

Reads `/detections` (vision_msgs/Detection3DArray with identities). The truth is each person's recorded path smoothed by a quadratic over
0.85 s; the filters see the recorded positions plus white noise, in every frame and in every other one. Prints one row for each
recording, rate and noise: root mean square error of the velocity in m/s from one second after a person appears, and the noise as third
differences show it, m: their nine-tenths quantile over that of a normal distribution, scaled to one position.
"""

import pathlib
import sys

import numpy as np
from filterpy.kalman import IMMEstimator
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.signal import savgol_filter
from scipy.stats import norm

from estimators_reference import CALM_Q, KALMAN_Q, LIVELY_Q, MANOEUVRE_SD, MEAN_STAY, begin, both_axes, manoeuvre, walk

WINDOW = 17


def paths(file: pathlib.Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Times (s) and positions (m) of every person seen without a gap for at least 3 s."""
    seen: dict[str, list] = {}
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=["/detections"]):
            at = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
            for detection in message.detections:
                p = detection.bbox.center.position
                seen.setdefault(detection.id, []).append((at, p.x, p.y))
    all_paths = [(np.array(s)[:, 0], np.array(s)[:, 1:]) for s in seen.values() if len(s) > 60]
    return [(t, p) for t, p in all_paths if np.diff(t).max() < 0.06]


def difference(t: np.ndarray, y: np.ndarray, sd: float) -> np.ndarray:
    return np.vstack([[np.nan, np.nan], np.diff(y, axis=0) / np.diff(t)[:, None]])


def kalman(t: np.ndarray, y: np.ndarray, sd: float) -> np.ndarray:
    kf = begin(y[0], sd**2 * np.eye(2), 0.0)
    out = [kf.x[2:4].copy()]
    for dt, position in zip(np.diff(t), y[1:]):
        f, q = both_axes(walk(dt, KALMAN_Q))
        kf.predict(F=f, Q=q)
        kf.update(position, R=sd**2 * np.eye(2))
        out.append(kf.x[2:4].copy())
    return np.array(out)


def imm(t: np.ndarray, y: np.ndarray, sd: float) -> np.ndarray:
    r = sd**2 * np.eye(2)
    filters = [begin(y[0], r, 0.0), begin(y[0], r, 0.0), begin(y[0], r, MANOEUVRE_SD)]
    bank, out = IMMEstimator(filters, np.full(3, 1 / 3), np.eye(3)), [np.zeros(2)]
    for dt, position in zip(np.diff(t), y[1:]):
        left = 2 / 3 * (1 - np.exp(-1.5 * dt / MEAN_STAY))
        bank.M = np.full((3, 3), left / 2) + np.eye(3) * (1 - 1.5 * left)
        bank._compute_mixing_probabilities()
        for kf, motion in zip(filters, [walk(dt, CALM_Q), walk(dt, LIVELY_Q), manoeuvre(dt)]):
            kf.F, kf.Q = both_axes(motion)
            kf.R = r
        bank.predict()
        bank.update(position)
        out.append(bank.x[2:4].copy())
    return np.array(out)


if __name__ == "__main__":
    rng = np.random.default_rng(5)
    print("| recording | people | Hz | noise, m | difference | kalman | imm | learnt, m |\n|---|---|---|---|---|---|---|---|")
    for file in map(pathlib.Path, sys.argv[1:]):
        people = paths(file)
        for every in (1, 2):
            for sd in (0.02, 0.05, 0.10, 0.15):
                squares, residuals = {difference: [], kalman: [], imm: []}, []
                for t, p in people:
                    step = float(np.median(np.diff(t)))
                    truth = savgol_filter(p, WINDOW, 2, deriv=1, delta=step, axis=0)[::every]
                    t_seen, seen = t[::every], (p + rng.normal(0.0, sd, p.shape))[::every]
                    counts = t_seen - t_seen[0] >= 1.0
                    residuals.append(np.abs(np.diff(seen, n=3, axis=0)).ravel() / np.sqrt(1 + 9 + 9 + 1))
                    for estimator, errors in squares.items():
                        off = estimator(t_seen, seen, sd) - truth
                        errors.append((off[counts] ** 2).sum(axis=1))
                cells = " | ".join(f"{np.sqrt(np.concatenate(e).mean()):.3f}" for e in squares.values())
                learnt = np.quantile(np.concatenate(residuals), 0.9) / norm.ppf(0.95)
                print(f"| {file.stem} | {len(people)} | {20 // every} | {sd:.2f} | {cells} | {learnt:.3f} |", flush=True)
