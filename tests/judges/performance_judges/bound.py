"""What the network and its gradient take at least on this machine, by `peak.c`."""

import json
import pathlib
import subprocess

from safetensors.numpy import load_file

HERE = pathlib.Path(__file__).parent
FLAGS = {8: ["-mavx2", "-mfma"], 16: ["-mavx512f", "-mavx512dq"]}
KERNELS = {8: "avx2-fma", 16: "avx512"}


def build(folder):
    """Compiles one program for each width of vectors that this processor has."""
    words = pathlib.Path("/proc/cpuinfo").read_text().split()
    programs = {}
    for lanes, flags in FLAGS.items():
        if not all(flag.removeprefix("-m") in words for flag in flags):
            continue
        programs[lanes] = folder / f"peak{lanes}"
        command = ["cc", "-O3", "-ffp-contract=fast", f"-DLANES={lanes}", *flags]
        subprocess.run([*command, "-o", programs[lanes], HERE / "peak.c"], check=True)
    return programs


def measure(programs, peaks):
    """Runs each once more and keeps the best of all runs."""
    for lanes, program in programs.items():
        seen = json.loads(subprocess.run([program], check=True, capture_output=True, text=True).stdout)
        best = peaks.setdefault(KERNELS[lanes], dict(seen))
        best["gflops"] = max(best["gflops"], seen["gflops"])
        best["sine_cosine_ns"] = min(best["sine_cosine_ns"], seen["sine_cosine_ns"])


def work(model_path):
    """Float operations and sine-cosine pairs that one person takes, forward and backward."""
    weights = [tensor for name, tensor in load_file(model_path).items() if name.endswith("weight")]
    # A product and a sum per weight and direction; the output layer has no sine, the heading has one.
    return 4 * sum(weight.size for weight in weights), sum(w.shape[0] for w in weights)


def bound_us(peak, model_path, people):
    """The time of these operations at the measured rates, nothing else, no idle lanes."""
    flops, pairs = work(model_path)
    return people * (flops / peak["gflops"] + pairs * peak["sine_cosine_ns"]) * 1e-3
