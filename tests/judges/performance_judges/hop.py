"""One hop of 2 KiB at 250 Hz between two processes, the receiver asleep, over CycloneDDS and over this project's ports."""

import contextlib
import json
import os
import pathlib
import subprocess
import sys

import numpy as np

HERE = pathlib.Path(__file__).parent
PERIOD_US = 4000
# The loopback alone, found without multicast, so that no other machine and no other robot takes part.
CYCLONE_SETTINGS = (
    '<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    '<MaxAutoParticipantIndex>11</MaxAutoParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)
CYCLONE = "CycloneDDS, waitset"


def build(folder):
    """Compiles the C judge with what idlc makes of its message."""
    made = folder / "hop_idl"
    made.mkdir(exist_ok=True)
    subprocess.run(["idlc", HERE / "hop.idl"], cwd=made, check=True)
    program = folder / "hop_cyclonedds"
    command = ["cc", "-O2", f"-I{made}", "-o", program, HERE / "hop.c", made / "hop.c", "-lddsc"]
    subprocess.run(command, check=True)
    return program


@contextlib.contextmanager
def process(*command, **options):
    """A child that is gone afterwards, whatever happened."""
    child = subprocess.Popen(command, **options)
    try:
        yield child
    finally:
        child.kill()
        child.wait()


def cyclone(program, messages):
    """One-way times in us, and how many messages never came."""
    environment = os.environ | {"CYCLONEDDS_URI": CYCLONE_SETTINGS}
    receive = [program, "receive", str(messages)]
    with process(*receive, env=environment, stdout=subprocess.PIPE, text=True) as receiver:
        publish = [program, "publish", str(messages), str(PERIOD_US)]
        subprocess.run(publish, env=environment, check=True, timeout=60 + messages * PERIOD_US * 1e-6)
        output, _ = receiver.communicate(timeout=60)
    *latencies, lost = output.splitlines()
    return [int(latency) * 1e-3 for latency in latencies], int(lost.removeprefix("lost "))


def percentiles(latencies_us, lost):
    p50, p90, p99, p999 = np.percentile(latencies_us, [50, 90, 99, 99.9])
    return {
        "count": len(latencies_us), "lost": lost, "p50_us": p50, "p90_us": p90, "p99_us": p99, "p999_us": p999,
        "max_us": max(latencies_us),
    }


def own(program, messages):
    """`crates/node_runtime/examples/hop`: bare iceoryx2, our ports over it, and our ports over DDS, in turns of a second."""
    command = [program, "--count", str(messages), "--period-us", str(PERIOD_US), "--modes", "bare,ours,dds"]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    found = {}
    for line in output.splitlines():
        entry = json.loads(line)
        quantiles = {"p50": "p50", "p90": "p90", "p99": "p99", "p99_9": "p999", "max": "max"}
        found[entry["mode"]] = {f"{to}_us": entry[f"{of}_ns"] * 1e-3 for of, to in quantiles.items()}
        found[entry["mode"]]["count"] = entry["count"]
    return found


def race(own_program, size, folder):
    """All of them, a few times in turns; each turn's percentiles."""
    judge = build(folder)
    turns = []
    for number in range(size["hop_turns"]):
        turn = own(own_program, size["hop_messages"])
        turn[CYCLONE] = percentiles(*cyclone(judge, size["hop_messages"]))
        turns.append(turn)
        print(f"hop {number + 1} of {size['hop_turns']}", file=sys.stderr, flush=True)
    return turns


def median(turns, of, quantile):
    return float(np.median([turn[of][quantile] for turn in turns]))


def rows(turns):
    """Medians over the turns, and the median of each turn's own ratio, which no change of the machine between turns bends."""

    def ratio(a, b):
        return float(np.median([turn[a]["p50_us"] / turn[b]["p50_us"] for turn in turns]))

    def shown(of):
        return f"{median(turns, of, 'p50_us'):.1f} / {median(turns, of, 'p99_us'):.1f}"

    to_bare, to_dds = ratio("ours", "bare"), ratio(CYCLONE, "ours")
    near, far = ("yes" if to_bare <= 1.15 else "NO"), ("yes" if to_dds >= 3.0 else "NO")
    ours = shown("ours")
    return [
        ("one hop, 2 KiB at 250 Hz", f"bare iceoryx2: {shown('bare')}", ours, f"{to_bare:.2f} of bare; at most 1.15: {near}"),
        ("the same", f"{CYCLONE}: {shown(CYCLONE)}", ours, f"{to_dds:.1f} times faster; at least 3: {far}"),
        ("the same", f"our ports over DDS: {shown('dds')}", ours, f"{ratio('dds', 'ours'):.1f} times"),
    ]
