"""Weights from PyTorch to a model file and back: the code that docs/weights.md shows.

`export` writes the network of tests/data/barrier_torch_cos_sin_reference.safetensors the way any PyTorch program would;
`import` reads a model file and checks that PyTorch computes the same residuals from it as from the original. Between the
two stands this project's own conversion. tests/data/barrier_torch_model.safetensors was made by

    python tests/judges/torch_weights_exchange.py export weights.safetensors
    cargo run -p barrier --example from_published -- weights.safetensors \\
        crates/barrier/examples/ground_robot_cos_sin.json tests/data/barrier_torch_model.safetensors
    python tests/judges/torch_weights_exchange.py import tests/data/barrier_torch_model.safetensors
"""

import sys
from pathlib import Path

import torch
from safetensors.torch import load_file, save_file

DATA = Path(__file__).resolve().parent.parent / "data"


class Residual(torch.nn.Module):
    def __init__(self, inputs=4):  # 4 raw, 5 heading_cos_sin, 2 position
        super().__init__()
        sizes = [inputs, 48, 48, 24, 24, 12, 12, 1]
        self.layers = torch.nn.ModuleList(torch.nn.Linear(a, b) for a, b in zip(sizes, sizes[1:]))

    def forward(self, a):
        for layer in self.layers[:-1]:
            a = torch.sin(layer(a))
        return torch.nn.functional.softplus(self.layers[-1](a)).squeeze(-1)


def reference() -> tuple[Residual, dict]:
    stored = load_file(DATA / "barrier_torch_cos_sin_reference.safetensors")
    net = Residual(inputs=5)
    net.load_state_dict({name: tensor for name, tensor in stored.items() if name.startswith("layers.")})
    return net, stored


def main() -> None:
    verb, path = sys.argv[1:]
    net, stored = reference()
    if verb == "export":
        save_file(net.state_dict(), path)
        return
    read = Residual(inputs=5)
    read.load_state_dict(load_file(path))
    z = stored["inputs"].double()
    inputs = torch.stack([z[:, 0], z[:, 1], torch.cos(z[:, 2]), torch.sin(z[:, 2]), z[:, 3]], dim=1)
    with torch.no_grad():
        error = (read.double()(inputs) - stored["residual"]).abs().max().item()
    print(f"largest difference of the residuals: {error:.1e} m")
    assert error < 1e-12, error


if __name__ == "__main__":
    main()
