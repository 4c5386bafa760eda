"""What each choice of the real-time path costs on this machine, in one run, in turns: the table of docs/performance.md.

    cargo build --release
    python tests/judges/profile_choices.py RECORDING.mcap OUT [--rounds 3] [--seconds 20]

Every round profiles every choice once, so that whatever else the machine does meets all of them; a row is the median over the
rounds for p50 and p99, and the largest of all for the maximum. Needs nothing but Python and the built program.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target" / "release" / "cncbf"
SHIPPED = (ROOT / "config" / "ground_robot.toml").read_text()
LAST_PROCESSOR = max(os.sched_getaffinity(0))


def one_processor(settings):
    return settings.replace("lock_memory = true", f"lock_memory = true, processors = [{LAST_PROCESSOR}]")


def no_rights(settings):
    return re.sub(r"\[realtime\][^\[]*(?=\n\[)", "", settings)


CHOICES = [
    ("as shipped", lambda settings: settings, []),
    ("all on one processor", one_processor, []),
    ("default scheduler, nothing locked", no_rights, []),
    ("filter on its timer alone", lambda settings: settings, ["--trigger", "timer"]),
    ("over DDS", lambda settings: settings, ["--transport", "dds"]),
    ("over DDS, default scheduler", no_rights, ["--transport", "dds"]),
    ("spinning", lambda settings: settings, ["--wait", "spin"]),
]


def profile(recording, folder, name, change, options, seconds):
    folder.mkdir(parents=True)
    config = folder / "settings.toml"
    settings = change(SHIPPED)
    assert change is CHOICES[0][1] or settings != SHIPPED or options, f"{name} changes nothing"
    config.write_text(settings)
    command = [PROGRAM, "profile", recording, "--config", config, "--instance", "choices", "--repeat", "1"]
    command += ["--duration", str(seconds), "--report", folder / "run", *options]
    ended = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if ended.returncode not in (0, 1):
        raise SystemExit(f"{name}: {ended.stderr.strip().splitlines()[-1]}")
    return json.loads((folder / "run" / "profile.json").read_text())["pooled"]


def hop(pooled, name):
    return next(row for row in pooled["hops"] if row["hop"] == name)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=20)
    arguments = parser.parse_args()

    measured = {name: [] for name, _, _ in CHOICES}
    for number in range(arguments.rounds):
        for place, (name, change, options) in enumerate(CHOICES):
            folder = arguments.out / f"round_{number}" / str(place)
            pooled = profile(arguments.recording, folder, name, change, options, arguments.seconds)
            measured[name].append(pooled)
            print(f"round {number + 1} of {arguments.rounds}, {name}: done", flush=True)

    print("| choice | detections to command p50 / p99 / max, µs | filter lateness p50 / p99 / max, µs | misses |")
    print("|---|---|---|---|")
    for name, rounds in measured.items():
        cells = []
        for row in ("end_to_end", "filter_lateness"):
            values = [hop(pooled, row) for pooled in rounds]
            p50 = statistics.median(value["p50_ns"] for value in values) / 1e3
            p99 = statistics.median(value["p99_ns"] for value in values) / 1e3
            largest = max(value["max_ns"] for value in values) / 1e3
            cells.append(f"{p50:.0f} / {p99:.0f} / {largest:.0f}")
        misses = sum(pooled["deadline_misses"] for pooled in rounds)
        cycles = sum(pooled["cycles"] for pooled in rounds)
        print(f"| {name} | {cells[0]} | {cells[1]} | {misses} of {cycles} cycles |")


if __name__ == "__main__":
    main()
