"""Solves the relative unicycle game on a coarse grid with hj_reachability and stores the values.

Independent judge of `crates/reachability`: same problem, same numerical scheme, other people's code.

    pip install "jax[cpu]" hj-reachability==0.7.0 safetensors numpy
    python tests/judges/hj_reachability_reference.py        # writes tests/data/hj_unicycle_reference.safetensors

Every second node along x and y is stored, which keeps the file small and includes both ends.
"""

import json
import pathlib
from importlib.metadata import version

import hj_reachability as hj
import jax
import jax.numpy as jnp
import numpy as np
from safetensors.numpy import save_file

RADIUS_M = 0.7
HORIZON_S = 2.0
LOWER = np.array([-6.0, -6.0, -np.pi, 0.0])
UPPER = np.array([6.0, 6.0, np.pi, 1.5])
SHAPE = (31, 31, 16, 5)
CONTROL = ([0.25, -0.8], [1.0, 0.8])
DISTURBANCE = ([-0.35], [0.35])
STRIDE = 2


class RelativeUnicycle(hj.ControlAndDisturbanceAffineDynamics):
    """State: obstacle position in the robot's frame, relative heading, obstacle speed."""

    def __init__(self):
        super().__init__(
            "max",
            "min",
            hj.sets.Box(jnp.array(CONTROL[0]), jnp.array(CONTROL[1])),
            hj.sets.Box(jnp.array(DISTURBANCE[0]), jnp.array(DISTURBANCE[1])),
        )

    def open_loop_dynamics(self, state, time):
        _, _, heading, speed = state
        return jnp.array([speed * jnp.cos(heading), speed * jnp.sin(heading), 0.0, 0.0])

    def control_jacobian(self, state, time):
        x, y, _, _ = state
        return jnp.array([[-1.0, y], [0.0, -x], [0.0, -1.0], [0.0, 0.0]])

    def disturbance_jacobian(self, state, time):
        return jnp.array([[0.0], [0.0], [1.0], [0.0]])


def main():
    grid = hj.Grid.from_lattice_parameters_and_boundary_conditions(
        hj.sets.Box(LOWER, UPPER), SHAPE, periodic_dims=2
    )
    failure = jnp.linalg.norm(grid.states[..., :2], axis=-1) - RADIUS_M
    variational = {"value_postprocessor": lambda time, values: jnp.minimum(values, failure)}
    freezing = {"hamiltonian_postprocessor": hj.solver.backwards_reachable_tube}
    runs = {
        "first_order_euler": ("low", variational),
        "eno2_rk2": ("medium", variational),
        "weno3_rk3": ("high", variational),
        "weno5_rk3": ("very_high", variational),
        "weno3_rk3_freezing": ("high", freezing),
    }
    tensors = {}
    for name, (accuracy, options) in runs.items():
        settings = hj.SolverSettings.with_accuracy(accuracy, **options)
        values = hj.step(settings, RelativeUnicycle(), grid, 0.0, failure, -HORIZON_S, progress_bar=False)
        tensors[name] = np.ascontiguousarray(np.asarray(values, dtype=np.float32)[::STRIDE, ::STRIDE])
        print(name, float(tensors[name].min()), float((tensors[name] < 0).mean()))
    description = {
        "made_by": "tests/judges/hj_reachability_reference.py",
        "hj_reachability": version("hj-reachability"),
        "jax": jax.__version__,
        "radius_m": RADIUS_M,
        "horizon_s": HORIZON_S,
        "shape": SHAPE,
        "stride_xy": STRIDE,
    }
    target = pathlib.Path(__file__).parents[1] / "data" / "hj_unicycle_reference.safetensors"
    save_file(tensors, target, metadata={"judge": json.dumps(description)})


if __name__ == "__main__":
    main()
