"""Races hj_reachability against this project's solver: the same game, grid, horizon and accuracy, on the same cores.

    pip install "jax[cpu]" hj-reachability==0.7.0 safetensors numpy
    cargo build --release -p reachability --example solver_comparison
    taskset -c 0,1 python tests/judges/hj_reachability_speed.py OUT [--quick]

hj_reachability solves first (about ten minutes of two cores at full size), then the example runs with its own solves, a finer
reference and the quadrotor's grid. OUT/comparison.json holds both halves and the ratios, by wall clock and by processor time;
only the latter means something on a machine that does other work too. Compilation by JAX is timed apart and left out.
"""

import argparse
import json
import os
import pathlib
import platform
import subprocess
import time
from importlib.metadata import version

import hj_reachability as hj
import jax
import jax.numpy as jnp
import numpy as np
from hj_reachability_reference import LOWER, RADIUS_M, UPPER, RelativeUnicycle
from safetensors.numpy import save_file

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLE = ROOT / "target" / "release" / "examples" / "solver_comparison"
# As in the example's FULL and QUICK.
FULL = ((80, 80, 20, 10), 5.0)
QUICK = ((40, 40, 12, 5), 1.0)


def solve(shape, horizon_s):
    """Returns the values and the seconds of compilation and of the solve."""
    grid = hj.Grid.from_lattice_parameters_and_boundary_conditions(
        hj.sets.Box(LOWER, UPPER), shape, periodic_dims=2
    )
    failure = jnp.linalg.norm(grid.states[..., :2], axis=-1) - RADIUS_M
    settings = hj.SolverSettings.with_accuracy(
        "high", value_postprocessor=lambda time, values: jnp.minimum(values, failure)
    )
    dynamics = RelativeUnicycle()

    def timed(target_s):
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        values = hj.step(settings, dynamics, grid, 0.0, failure, target_s, progress_bar=False)
        values.block_until_ready()
        return values, {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}

    _, compilation = timed(-1e-4)
    values, seconds = timed(-horizon_s)
    return np.asarray(values, dtype=np.float32), compilation, seconds


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    shape, horizon_s = QUICK if arguments.quick else FULL
    load_before = os.getloadavg()[0]
    values, compilation, seconds = solve(shape, horizon_s)
    print("hj_reachability", seconds, "compilation", compilation, flush=True)
    save_file({"value": values}, arguments.out / "hj_ground_robot.safetensors")
    command = [EXAMPLE, arguments.out] + (["--quick"] if arguments.quick else [])
    ours = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
    ground_robot = ours["ground_robot"]
    ground_robot["hj_reachability"].update(seconds=seconds, compilation=compilation)
    mine = ground_robot["ours"]["seconds"]
    ground_robot["ratio"] = {clock: seconds[clock] / mine[clock] for clock in ("wall_s", "cpu_s")}
    ours["machine"] = {
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load_before": load_before,
        "load_after": os.getloadavg()[0],
        "hj_reachability": version("hj-reachability"),
        "jax": jax.__version__,
    }
    text = json.dumps(ours, indent=1)
    (arguments.out / "comparison.json").write_text(text + "\n")
    print(text)


if __name__ == "__main__":
    main()
