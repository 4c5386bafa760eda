"""This project against what else does the same work, in one run on one machine, in turns.

    pip install torch casadi "jax[cpu]" numpy safetensors      # in an environment of its own
    apt install gcc cyclonedds-dev cyclonedds-tools            # for the bound and the hop
    nice -n -10 python tests/judges/performance.py OUT [--quick] [--only steps|hop]

It builds this project's programs and the C judges, then takes turns: a round of ours, a round of each judge, and again, so that
whatever else the machine does meets all of them. Every call counts; nothing is filtered away. It prints a table for
docs/performance.md with a verdict for each target, and writes OUT/performance.json. Nothing is installed here.

Compared: the filter's cycle with PyTorch + CasADi qpOASES (the paper's stack, one thread) and with JAX; its network with the
arithmetic bound of this processor; the CBF-QP with Clarabel; the nominal controller with CasADi's IPOPT, warm; one hop between two
processes with CycloneDDS and with bare iceoryx2. The judges must come to the same controls.
"""

import argparse
import json
import os
import pathlib
import platform
import subprocess
import sys
import time

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODEL = ROOT / "models" / "ground_robot.safetensors"
PEOPLE = [1, 5, 15, 20, 64]
# Rounds, and calls of each judge of the filter in one: at least 10,000 calls of everything at full size.
FULL = {"rounds": 50, "judge_calls": 200, "hop_turns": 4, "hop_messages": 2500}
QUICK = {"rounds": 3, "judge_calls": 100, "hop_turns": 1, "hop_messages": 500}
# Controls may differ by what single precision and two solvers' tolerances leave, m/s and rad/s.
AGREEMENT = 2e-3


def cargo(*arguments):
    """Builds, and returns the folder of the examples."""
    subprocess.run(["cargo", "build", "--release", "--quiet", *arguments], cwd=ROOT, check=True)
    metadata = subprocess.run(
        ["cargo", "metadata", "--no-deps", "--format-version", "1"],
        cwd=ROOT, check=True, capture_output=True, text=True,
    )
    return pathlib.Path(json.loads(metadata.stdout)["target_directory"]) / "release" / "examples"


class Ours:
    """`examples/performance.rs`, which runs a round for each line it is given."""

    def __init__(self):
        program = cargo("-p", "cncbf", "--example", "performance") / "performance"
        self.child = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.described = json.loads(self.child.stdout.readline())

    def round(self):
        self.child.stdin.write("round\n")
        self.child.stdin.flush()
        answer = self.child.stdout.readline()
        if answer != "done\n":
            sys.exit("the program `performance` ended early; run it alone to see why")

    def finish(self):
        output, _ = self.child.communicate()
        return json.loads(output)


def figures(durations_us):
    import numpy as np

    p50, p90, p99, p999 = np.percentile(durations_us, [50, 90, 99, 99.9])
    return {
        "calls": len(durations_us), "min_us": min(durations_us), "p50_us": p50, "p90_us": p90, "p99_us": p99,
        "p999_us": p999, "max_us": max(durations_us),
    }


def timed_calls(step, calls, variants):
    durations_us = []
    for call in range(calls):
        began_ns = time.perf_counter_ns()
        step(call % variants)
        durations_us.append((time.perf_counter_ns() - began_ns) * 1e-3)
    return durations_us


def steps(size, folder):
    """The pure steps and their judges."""
    from performance_judges import bound
    from performance_judges.filter_stacks import JaxStack, Scenes, TorchStack, disagreement
    from performance_judges.mpc import IpoptDrive, TunedIpoptDrive

    ours = Ours()
    scenes = Scenes(ours.described)
    stacks = {
        (kind.name, people): kind(scenes, MODEL, people) for kind in (TorchStack, JaxStack) for people in PEOPLE
    }
    differences = {
        name: max(disagreement(stack, scenes, people) for (other, people), stack in stacks.items() if other == name)
        for name in {name for name, _ in stacks}
    }
    if max(differences.values()) > AGREEMENT:
        sys.exit(f"the judges compute other controls than this project does: {differences}; nothing was timed")
    peaks, peak_programs = {}, bound.build(folder)
    drives = [IpoptDrive(ours.described), TunedIpoptDrive(ours.described)]
    durations = {key: [] for key in stacks} | {drive.name: [] for drive in drives}
    for number in range(size["rounds"]):
        ours.round()
        for key, stack in stacks.items():
            durations[key] += timed_calls(stack.step, size["judge_calls"], len(scenes.poses))
        for drive in drives:
            durations[drive.name] += drive.round()
        bound.measure(peak_programs, peaks)
        print(f"round {number + 1} of {size['rounds']}", file=sys.stderr, flush=True)
    qp_program = cargo("-p", "barrier", "--example", "qp_comparison") / "qp_comparison"
    qp = subprocess.run([qp_program, str(size["rounds"])], check=True, capture_output=True, text=True)
    judges = {f"{name}/{people}": figures(durations[name, people]) for name, people in stacks}
    return {
        "kernel": ours.described["kernel"],
        "ours": ours.finish(),
        "judges": judges | {drive.name: figures(durations[drive.name]) for drive in drives},
        "largest_difference_of_controls": differences,
        "qp": json.loads(qp.stdout),
        "peaks": peaks,
        "bounds_us": {
            kernel: {people: bound.bound_us(peak, MODEL, people) for people in PEOPLE}
            for kernel, peak in peaks.items()
        },
    }


def row(name, reference, ours, verdict=""):
    return f"| {name} | {reference} | {ours} | {verdict} |"


def pair(entry):
    digits = 3 if entry["p50_us"] < 1 else 1
    return f"{entry['p50_us']:.{digits}f} / {entry['p99_us']:.{digits}f}"


def verdict(met, text):
    return f"{text}: {'yes' if met else 'NO'}"


def step_rows(result):
    ours, judges = result["ours"], result["judges"]
    rows = []
    for name in dict.fromkeys(key.rsplit("/", 1)[0] for key in judges if "/" in key):
        for people in PEOPLE:
            judge, mine = judges[f"{name}/{people}"], ours[f"filter_step/{people}"]
            ratio = judge["p50_us"] / mine["p50_us"]
            target = people == 20 and "PyTorch" in name
            note = verdict(ratio >= 120.0, f"{ratio:.0f} times faster; at least 120") if target else f"{ratio:.0f} times"
            rows.append(row(f"filter step, M = {people}", f"{name}: {pair(judge)}", pair(mine), note))
    mine = ours["filter_step/20"]
    met = mine["p50_us"] <= 10.0 and mine["p99_us"] <= 20.0
    rows.append(row("filter step, M = 20, absolute", "10 / 20", pair(mine), verdict(met, "within")))
    for kernel, bounds in result["bounds_us"].items():
        for people in (20, 64):
            mine = ours[f"network/{kernel}/{people}"]
            ratio = mine["p50_us"] / bounds[people]
            note = verdict(ratio <= 1.6, f"{ratio:.2f} of the bound; at most 1.6") if people == 20 else f"{ratio:.2f}"
            bound = f"bound {bounds[people]:.2f}"
            rows.append(row(f"network and gradient, {kernel}, M = {people}", bound, pair(mine), note))
    mine = ours["mpc_step"]
    for name in (key for key in judges if key.startswith("CasADi")):
        ratio = judges[name]["p50_us"] / mine["p50_us"]
        target = name.endswith("warm")
        note = verdict(ratio >= 12.0, f"{ratio:.1f} times faster; at least 12") if target else f"{ratio:.1f} times"
        rows.append(row("MPC step", f"{name}: {pair(judges[name])}", pair(mine), note))
    met = mine["p50_us"] <= 400.0 and mine["p99_us"] <= 900.0
    rows.append(row("MPC step, absolute", "400 / 900", pair(mine), verdict(met, "within")))
    qp = result["qp"]
    ratio = qp["clarabel"]["p50_us"] / qp["exact"]["p50_us"]
    rows.append(row("CBF-QP", f"Clarabel: {pair(qp['clarabel'])}", pair(qp["exact"]), f"{ratio:.0f} times"))
    for name, entry in ours.items():
        if name.startswith(("estimator", "encode", "decode", "composite")):
            rows.append(row(name.replace("/", ", "), "", pair(entry)))
    return rows


def machine():
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": names[0] if names else platform.processor(),
        "cores": len(os.sched_getaffinity(0)),
        "kernel": platform.release(),
        "load": os.getloadavg()[0],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path, help="folder for performance.json and the programs built")
    parser.add_argument("--quick", action="store_true", help="a few rounds, to see whether everything runs")
    parser.add_argument("--only", choices=["steps", "hop"], help="one half")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    size = QUICK if arguments.quick else FULL
    result, rows = {"machine": machine()}, []
    if arguments.only != "hop":
        result["steps"] = steps(size, arguments.out)
        rows += step_rows(result["steps"])
    if arguments.only != "steps":
        from performance_judges import hop

        result["hop"] = hop.race(cargo("-p", "node_runtime", "--example", "hop") / "hop", size, arguments.out)
        rows += [row(*cells) for cells in hop.rows(result["hop"])]
    result["machine"]["load_after"] = os.getloadavg()[0]
    (arguments.out / "performance.json").write_text(json.dumps(result, indent=1) + "\n")
    print(f"\n{result['machine']}\n")
    print("| quantity | reference, p50 / p99 us | ours, p50 / p99 us | verdict |\n|---|---|---|---|")
    print("\n".join(rows))


if __name__ == "__main__":
    main()
