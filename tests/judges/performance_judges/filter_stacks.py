"""The filter's cycle as others compute it: from states of robot and people to the safe control.

`TorchStack` is the paper's stack: network and gradient by PyTorch's autograd on one thread, the CBF-QP by CasADi's
qpOASES. `JaxStack` is the best that Python offers: everything, an exact QP included, in one compiled function. Both take
the shipped model and the scenes that `examples/performance.rs` describes, and must come to its controls.
"""

import casadi as ca
import jax
import jax.numpy as jnp
import numpy as np
import torch
from safetensors.numpy import load_file


class Scenes:
    """People, robot poses and nominal controls, as arrays."""

    def __init__(self, described):
        people = described["people"]
        self.states = np.array([person["state"] for person in people], dtype=np.float32)
        self.rates = np.array([person["rate"] for person in people], dtype=np.float32)
        self.radii = np.array([person["radius_m"] for person in people], dtype=np.float32)
        self.poses = np.array(described["robot_poses"], dtype=np.float32)
        self.nominals = np.array(described["nominal_controls"], dtype=np.float32)
        self.alpha, self.beta = described["alpha_per_s"], described["beta_per_m"]
        self.slack_weight = described["slack_weight"]
        self.low, self.high = (np.array(described[key]) for key in ("control_min", "control_max"))
        self.answers = {answer["people"]: np.array(answer["controls"]) for answer in described["answers"]}


class TorchStack:
    """torch + CasADi qpOASES."""

    name = "PyTorch + CasADi qpOASES"

    def __init__(self, scenes, model_path, people):
        torch.set_num_threads(1)
        self.scenes = scenes
        weights = load_file(model_path)
        self.layers = []
        for index in range(len(weights) // 2):
            weight = torch.from_numpy(weights[f"layers.{index}.weight"])
            layer = torch.nn.Linear(weight.shape[1], weight.shape[0])
            layer.weight = torch.nn.Parameter(weight, requires_grad=False)
            bias = torch.from_numpy(weights[f"layers.{index}.bias"])
            layer.bias = torch.nn.Parameter(bias, requires_grad=False)
            self.layers.append(layer)
        self.rates = torch.from_numpy(scenes.rates[:people])
        self.radii = torch.from_numpy(scenes.radii[:people])
        self.states = torch.from_numpy(scenes.states[:people])
        shapes = {"h": ca.Sparsity.diag(3), "a": ca.Sparsity.dense(1, 3)}
        self.qp = ca.conic("qp", "qpoases", shapes, {"printLevel": "none", "print_time": False})
        self.hessian = ca.diag([1.0, 1.0, scenes.slack_weight])
        self.low = np.append(scenes.low, 0.0)
        self.high = np.append(scenes.high, np.inf)

    def composite(self, pose, states):
        sin, cos = torch.sin(pose[2]), torch.cos(pose[2])
        dx, dy = states[:, 0] - pose[0], states[:, 1] - pose[1]
        x, y = cos * dx + sin * dy, cos * dy - sin * dx
        heading = states[:, 2] - pose[2]
        a = torch.stack([x, y, torch.cos(heading), torch.sin(heading), states[:, 3]], dim=1)
        for layer in self.layers[:-1]:
            a = torch.sin(layer(a))
        residual = torch.nn.functional.softplus(self.layers[-1](a)).squeeze(1)
        h_bar = torch.hypot(x, y) - self.radii - residual
        return -torch.logsumexp(-self.scenes.beta * h_bar, 0) / self.scenes.beta

    def step(self, variant):
        pose = torch.from_numpy(self.scenes.poses[variant]).requires_grad_()
        states = self.states.clone().requires_grad_()
        h = self.composite(pose, states)
        by_pose, by_states = torch.autograd.grad(h, (pose, states))
        drift = float((by_states * self.rates).sum())
        by_x, by_y, by_heading = by_pose.tolist()
        heading = self.scenes.poses[variant][2]
        row = [by_x * np.cos(heading) + by_y * np.sin(heading), by_heading, 1.0]
        nominal = self.scenes.nominals[variant]
        solution = self.qp(
            h=self.hessian, g=[-nominal[0], -nominal[1], 0.0], a=ca.DM([row]),
            lba=-(drift + self.scenes.alpha * h.item()), uba=np.inf, lbx=self.low, ubx=self.high,
        )
        return np.asarray(solution["x"]).ravel()[:2]


class JaxStack:
    """One jitted function."""

    name = "JAX, one jit, with an exact QP"

    def __init__(self, scenes, model_path, people):
        self.scenes = scenes
        weights = load_file(model_path)
        layers = [
            (jnp.asarray(weights[f"layers.{k}.weight"]), jnp.asarray(weights[f"layers.{k}.bias"]))
            for k in range(len(weights) // 2)
        ]
        states, rates, radii = (
            jnp.asarray(array[:people]) for array in (scenes.states, scenes.rates, scenes.radii)
        )
        low, high = jnp.asarray(scenes.low, jnp.float32), jnp.asarray(scenes.high, jnp.float32)

        def composite(pose, states):
            sin, cos = jnp.sin(pose[2]), jnp.cos(pose[2])
            dx, dy = states[:, 0] - pose[0], states[:, 1] - pose[1]
            x, y = cos * dx + sin * dy, cos * dy - sin * dx
            heading = states[:, 2] - pose[2]
            a = jnp.stack([x, y, jnp.cos(heading), jnp.sin(heading), states[:, 3]], axis=1)
            for weight, bias in layers[:-1]:
                a = jnp.sin(a @ weight.T + bias)
            weight, bias = layers[-1]
            h_bar = jnp.hypot(x, y) - radii - jax.nn.softplus(a @ weight.T + bias)[:, 0]
            return -jax.scipy.special.logsumexp(-scenes.beta * h_bar) / scenes.beta

        def project(nominal, row, offset):
            """The root of the piecewise linear dual, over its at most five segments."""
            safe = jnp.where(row == 0.0, 1.0, row)
            ends = jnp.where(row == 0.0, 0.0, (jnp.stack([low, high]) - nominal) / safe)
            starts = jnp.sort(jnp.maximum(jnp.append(ends.ravel(), 0.0), 0.0))
            multiplier = starts[:, None]
            control = jnp.clip(nominal + multiplier * row, low, high)
            residual = control @ row + offset + starts / scenes.slack_weight
            last = jnp.maximum(jnp.sum(residual < 0.0) - 1, 0)
            beyond = nominal + (starts[last] + 1e-4) * row
            free = (beyond > low) & (beyond < high)
            slope = 1.0 / scenes.slack_weight + jnp.sum(jnp.where(free, row * row, 0.0))
            root = jnp.where(residual[0] >= 0.0, 0.0, starts[last] - residual[last] / slope)
            return jnp.clip(nominal + root * row, low, high)

        @jax.jit
        def step(pose, nominal, states, rates):
            h, (by_pose, by_states) = jax.value_and_grad(composite, (0, 1))(pose, states)
            speed = by_pose[0] * jnp.cos(pose[2]) + by_pose[1] * jnp.sin(pose[2])
            row = jnp.stack([speed, by_pose[2]])
            offset = jnp.sum(by_states * rates) + scenes.alpha * h
            return project(nominal, row, offset)

        self.compiled = lambda pose, nominal: step(pose, nominal, states, rates)

    def step(self, variant):
        return np.asarray(self.compiled(self.scenes.poses[variant], self.scenes.nominals[variant]))


def disagreement(stack, scenes, people):
    """Largest difference to this project's controls over all variants, in m/s and rad/s."""
    answers = scenes.answers[people]
    return max(float(np.abs(stack.step(k) - answer).max()) for k, answer in enumerate(answers))
