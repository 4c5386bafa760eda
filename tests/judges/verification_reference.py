"""Judge of `crates/verification`: the published quadrotor weights against the closed form of their pair.

Run where the published weights lie beside the checkout, with numpy and safetensors installed:

    python tests/judges/verification_reference.py ../shared/anchors/quadrotor_published_v1.safetensors \
        > tests/data/verification_reference.json

Shares no code with the crate: the network runs in float64, its gradient by the chain rule, the truth is a search over a grid of
relative accelerations and times. R = 0.7 m, positions within 4 m, velocities within 3.5 m/s, robot 2 m/s^2, obstacle 1 m/s^2.
"""

import json
import sys

import numpy as np
from safetensors.numpy import load_file

RADIUS_M = 0.7
LOW = np.array([-4.0, -4.0, -3.5, -3.5])
ALPHA_PER_S = 4.0
BAND_M = 0.05


def draw(rng, count):
    """States uniform in the box outside the failure disc."""
    z = rng.uniform(LOW, -LOW, size=(2 * count, 4))
    return z[np.hypot(z[:, 0], z[:, 1]) > RADIUS_M][:count]


def barrier(weights, z):
    """h = |p| - R - softplus(network(z)) and its gradient."""
    a, slopes = z, []
    for w, b in weights[:-1]:
        y = a @ w.T + b
        a, slope = np.sin(y), np.cos(y)
        slopes.append(slope)
    w, b = weights[-1]
    y = (a @ w.T + b)[:, 0]
    residual = np.logaddexp(0.0, y)
    back = (1.0 / (1.0 + np.exp(-y)))[:, None] * w
    for (w, _), slope in zip(reversed(weights[:-1]), reversed(slopes)):
        back = (back * slope) @ w
    distance = np.hypot(z[:, 0], z[:, 1])
    gradient = -back
    gradient[:, :2] += z[:, :2] / distance[:, None]
    return distance - RADIUS_M - residual, gradient


def truth(z):
    """max over constant a of min over t of |p + v t + a t^2 / 2|, minus R, on grids of a and t."""
    times = np.concatenate([np.arange(0.0, 3.0, 0.01), np.arange(3.0, 8.01, 0.05)])
    best = np.full(len(z), -np.inf)
    steps = np.linspace(-1.0, 1.0, 5)
    for ax in steps:
        for ay in steps:
            nearest = np.full(len(z), np.inf)
            for t in times:
                x = z[:, 0] + z[:, 2] * t + ax * t * t / 2.0
                y = z[:, 1] + z[:, 3] * t + ay * t * t / 2.0
                np.minimum(nearest, x * x + y * y, out=nearest)
            np.maximum(best, nearest, out=best)
    return np.sqrt(best) - RADIUS_M


def share(mask, of):
    return {"count": int(np.count_nonzero(mask & of)), "of": int(np.count_nonzero(of))}


def main():
    tensors = load_file(sys.argv[1])
    layer = lambda i, part: tensors[f"layers.{i}.{part}"].astype(np.float64)
    weights = [(layer(i, "weight"), layer(i, "bias")) for i in range(7)]
    rng = np.random.default_rng(20)

    z = draw(rng, 100_000)
    h, _ = barrier(weights, z)
    v = truth(z)
    error, near = h - v, np.abs(v) < 0.2
    size = np.sort(np.abs(error))

    h_condition, violated_parts = [], []
    for _ in range(20):
        zc = draw(rng, 100_000)
        hc, g = barrier(weights, zc)
        hamiltonian = g[:, 0] * zc[:, 2] + g[:, 1] * zc[:, 3] + np.abs(g[:, 2]) + np.abs(g[:, 3])
        h_condition.append(hc)
        violated_parts.append(hamiltonian + ALPHA_PER_S * hc)
    hc, c = np.concatenate(h_condition), np.concatenate(violated_parts)

    safe, above = hc >= 0.0, (hc >= 0.0) & (hc < BAND_M)
    json.dump(
        {
            "error": {
                "states": len(z),
                "bias_m": error.mean(),
                "mean_m": size.mean(),
                "p99_m": size[int(0.99 * (len(size) - 1))],
                "max_m": size[-1],
                "near_zero_mean_m": np.abs(error[near]).mean(),
            },
            "shell_called_safe": share(h >= 0.0, v < 0.0),
            "safe_called_unsafe": share(h < 0.0, v >= 0.0),
            "condition": {
                "alpha_per_s": ALPHA_PER_S,
                "violated_safe": share(c < 0.0, safe),
                "violated_band_above": share(c < 0.0, above),
                "violated_band": share(c < 0.0, np.abs(hc) < BAND_M),
                "worst_sampled_mps": c[safe].min(),
                "median_safe_mps": np.median(c[safe]),
            },
        },
        sys.stdout,
        indent=1,
    )
    print()


main()
