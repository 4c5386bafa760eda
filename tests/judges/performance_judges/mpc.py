"""CasADi's IPOPT as the nominal controller, in the same closed loop as `benches/scenes/drive.rs`.

The problem is that of `casadi_mpc_reference.py`. Each step starts from the previous plan, shifted by the period. `IpoptDrive` is
what one writes: matrices of symbols, IPOPT's own options. `TunedIpoptDrive` is the fastest found: scalar symbols, multipliers kept,
a small barrier from the start, a blunter tolerance.
"""

import time

import casadi as ca
import numpy as np


class IpoptDrive:
    """A robot that does as IPOPT says, on its way between the goals."""

    name = "CasADi IPOPT, warm"
    symbol = ca.MX
    ipopt = {}
    keeps_multipliers = False

    def __init__(self, described):
        self.settings = described["mpc"]
        self.low, self.high = np.array(described["control_min"]), np.array(described["control_max"])
        self.steps = self.settings["horizon_steps"]
        self.solver = self.build()
        states = 3 * (self.steps + 1)
        free = np.full(states, np.inf)
        self.bounds = {
            "lbx": np.concatenate([-free, np.tile(self.low, self.steps)]),
            "ubx": np.concatenate([free, np.tile(self.high, self.steps)]),
            "lbg": 0.0,
            "ubg": 0.0,
        }
        self.multipliers = {}
        self.controls = np.tile(0.5 * (self.low + self.high), (self.steps, 1))
        self.pose = np.zeros(3)
        self.cycle = 0

    def euler(self, x, u):
        step_s = self.settings["step_s"]
        return x + step_s * ca.vertcat(u[0] * ca.cos(x[2]), u[0] * ca.sin(x[2]), u[1])

    def build(self):
        states = self.symbol.sym("X", 3, self.steps + 1)
        controls = self.symbol.sym("U", 2, self.steps)
        start = self.symbol.sym("x0", 3)
        q, last_q, r = (
            ca.diag(self.settings[key]) for key in ("state_weight", "terminal_weight", "control_weight")
        )
        cost = ca.bilin(last_q, states[:, self.steps])
        gaps = [states[:, 0] - start]
        for k in range(self.steps):
            cost += ca.bilin(q, states[:, k]) + ca.bilin(r, controls[:, k])
            gaps.append(states[:, k + 1] - self.euler(states[:, k], controls[:, k]))
        problem = {
            "x": ca.vertcat(ca.vec(states), ca.vec(controls)), "f": cost, "g": ca.vertcat(*gaps), "p": start
        }
        ipopt = {"print_level": 0, "sb": "yes"} | self.ipopt
        return ca.nlpsol("mpc", "ipopt", problem, {"print_time": False, "ipopt": ipopt})

    def guess(self, start):
        states = [start]
        for u in self.controls:
            x = states[-1]
            flow = np.array([u[0] * np.cos(x[2]), u[0] * np.sin(x[2]), u[1]])
            states.append(x + self.settings["step_s"] * flow)
        return np.concatenate([np.concatenate(states), self.controls.ravel()])

    def solve(self, start):
        return self.solver(x0=self.guess(start), p=start, **self.bounds, **self.multipliers)

    def advance(self, control):
        period_s = self.settings["period_s"]
        x, y, heading = self.pose
        speed, yaw_rate = control
        heading_after = heading + period_s * yaw_rate
        self.pose = np.array([
            x + period_s * speed * np.cos(heading),
            y + period_s * speed * np.sin(heading),
            np.arctan2(np.sin(heading_after), np.cos(heading_after)),
        ])
        # Controls are constant within a step: half a period later the plan mixes neighbours.
        part = period_s / self.settings["step_s"]
        following = np.vstack([self.controls[1:], self.controls[-1:]])
        self.controls = (1.0 - part) * self.controls + part * following

    def round(self):
        """One goal; returns the durations of its solves in us."""
        goals = self.settings["goals"]
        durations_us = []
        goal = np.array([*goals[self.cycle % len(goals)], 0.0])
        self.cycle += 1
        for _ in range(self.settings["steps_per_goal"]):
            start = self.pose - goal
            if np.hypot(start[0], start[1]) < 0.3:
                break
            began_ns = time.perf_counter_ns()
            result = self.solve(start)
            durations_us.append((time.perf_counter_ns() - began_ns) * 1e-3)
            if self.keeps_multipliers:
                self.multipliers = {"lam_x0": result["lam_x"], "lam_g0": result["lam_g"]}
            solution = np.asarray(result["x"]).ravel()
            self.controls = solution[3 * (self.steps + 1):].reshape(self.steps, 2)
            self.advance(self.controls[0])
        return durations_us


class TunedIpoptDrive(IpoptDrive):
    """The same, tuned for the closed loop."""

    name = "CasADi IPOPT, warm and tuned"
    symbol = ca.SX
    ipopt = {
        "tol": 1e-6, "warm_start_init_point": "yes", "warm_start_bound_push": 1e-6,
        "warm_start_mult_bound_push": 1e-6, "mu_init": 1e-4,
    }
    keeps_multipliers = True
