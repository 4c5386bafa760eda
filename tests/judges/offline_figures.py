"""Makes every shipped model from its configuration, verifies it, and prints the table of docs/figures.md.

    cargo build --release
    python tests/judges/offline_figures.py OUT [--only NAME ...] [--keep]

Needs Python's standard library and GNU-like `resource` only. OUT collects value files, models, times (figures.json) and, if
hj_reachability_speed.py was run with the same OUT, its comparison.json. With --keep a model that OUT already holds is not made
again; --only limits which are made, the table shows all that OUT knows.
"""

import argparse
import json
import os
import pathlib
import platform
import resource
import subprocess
import time

ROOT = pathlib.Path(__file__).parents[2]
CNCBF = pathlib.Path(os.environ.get("CNCBF", ROOT / "target" / "release" / "cncbf"))
NAMES = ["quadrotor_paper", "quadrotor", "ground_robot_paper", "ground_robot", "static_obstacles", "cyclist"]


def timed(*arguments):
    """Runs cncbf and returns its output with the seconds it took, by the wall and by the processors."""
    before, start_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run([CNCBF, *map(str, arguments)], stdout=subprocess.PIPE, text=True)
    wall_s, after = time.perf_counter() - start_s, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        raise SystemExit(f"cncbf {arguments} ended with {done.returncode}")
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.stdout, {"wall_s": round(wall_s, 1), "cpu_s": round(cpu_s, 1)}


def true_value(out, name):
    """The value file that judges, or nothing where a closed form does."""
    candidates = [out / f"{name}.value.true.safetensors", out / f"{name}.value.safetensors"]
    return next((file for file in candidates if file.exists()), None)


def make(name, out):
    """One model from its configuration, with the time of each step."""
    config, model = ROOT / "config" / f"{name}.toml", out / f"{name}.safetensors"
    value, seconds = out / f"{name}.value.safetensors", {}
    text = config.read_text()
    if 'target = "closed_form"' not in text:
        # Solved apart, so that the training's own time is seen.
        _, seconds["solve"] = timed("solve", config, "-o", value)
    _, seconds["train"] = timed("train", config, "--value", value, "-o", model, "--no-verify")
    truth = true_value(out, name)
    judge = ["--value", truth] if truth else []
    _, seconds["verify_without_rollouts"] = timed("verify", model, *judge, "--rollouts", "0")
    _, seconds["verify"] = timed("verify", model, *judge)
    return seconds


def percent(share, digits=3):
    return f"{100 * share['share']:.{digits}f} %"


def rows(name, metadata):
    """The lines of one model."""
    verification = metadata["verification"]
    error, condition = verification["value_error"], verification["condition"]
    scenario = verification.get("scenario")
    millimetres = " / ".join(f"{1e3 * error['error'][key]:.1f}" for key in ("mean_m", "p99_m", "max_m"))
    cells = [
        f"`{name}`",
        millimetres,
        f"{percent(error['shell_called_safe'])} ({1e3 * error['shell_called_safe_worst_m']:.0f} mm)",
        percent(error["safe_called_unsafe"]),
        percent(condition["violated_safe"], 4),
        percent(condition["violated_band_above"], 2),
        percent(condition["violated_band"], 2),
    ]
    if scenario:
        first = scenario["rows"][0]
        cells += [f"{first['failures']} of {first['rollouts']}", f"{first['epsilon']:.1e}"]
    return "| " + " | ".join(cells) + " |"


def table(out, figures):
    processor = next(
        (line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")),
        platform.processor(),
    )
    print(f"{time.strftime('%Y-%m-%d')}, {processor}, {os.cpu_count()} cores\n")
    comparison = out / "comparison.json"
    if comparison.exists():
        print("```json\n" + comparison.read_text() + "```\n")
    print("| model | error mean / p99 / max, mm | unsafe shell called safe (deepest) | safe called unsafe "
          "| CBF violated on h >= 0 | on 0 <= h < 5 cm | on abs(h) < 5 cm | rollouts failed | P(failure) <= |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in NAMES:
        model = out / f"{name}.safetensors"
        if model.exists():
            text, _ = timed("inspect", model, "--json")
            print(rows(name, json.loads(text)))
    print("\n| model | solve | train | verify without rollouts | verify with rollouts |\n|---|---|---|---|---|")
    for name in NAMES:
        if name in figures:
            steps = ["solve", "train", "verify_without_rollouts", "verify"]
            times = [figures[name].get(step) for step in steps]
            cells = [f"{t['wall_s']:.0f} s ({t['cpu_s']:.0f} CPU s)" if t else "-" for t in times]
            print(f"| `{name}` | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--only", nargs="*", choices=NAMES, default=NAMES)
    parser.add_argument("--keep", action="store_true")
    arguments = parser.parse_args()
    out = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    stored = out / "figures.json"
    figures = json.loads(stored.read_text()) if stored.exists() else {}
    for name in arguments.only:
        if not (arguments.keep and name in figures):
            figures[name] = make(name, out)
            stored.write_text(json.dumps(figures, indent=1) + "\n")
            print(name, figures[name], flush=True)
    table(out, figures)


main()
