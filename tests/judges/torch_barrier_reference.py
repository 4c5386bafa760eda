"""PyTorch's value and gradient of seeded random residual networks, as the judge of crate `barrier`.

Writes tests/data/barrier_torch_reference.safetensors (inputs as in the paper) and
tests/data/barrier_torch_cos_sin_reference.safetensors (heading as cosine and sine). Each holds the weights
(`layers.N.weight`, `layers.N.bias`), 200 relative states (`inputs`, [200, 4]), residuals (`residual`, [200]) and their
gradients with respect to the state (`gradient`, [200, 4]). Values and gradients are computed in float64 from the float32
weights and states, so that they judge rounding too.

Run:  pip install torch numpy safetensors && python tests/judges/torch_barrier_reference.py
"""

from pathlib import Path

import numpy as np
import torch
from safetensors.numpy import save_file

HIDDEN = [48, 48, 24, 24, 12, 12, 1]
SEED = 20_250_117
SAMPLES = 200
# Three times the default scale of torch.nn.Linear: gradients then reach the size of a trained model's.
WEIGHT_SCALE = 3.0


def raw(z: torch.Tensor) -> torch.Tensor:
    return z


def heading_cos_sin(z: torch.Tensor) -> torch.Tensor:
    return torch.stack([z[:, 0], z[:, 1], torch.cos(z[:, 2]), torch.sin(z[:, 2]), z[:, 3]], dim=1)


def write(name: str, encode, input_count: int) -> None:
    torch.manual_seed(SEED)
    sizes = [input_count, *HIDDEN]
    layers = [torch.nn.Linear(a, b) for a, b in zip(sizes[:-1], sizes[1:])]
    with torch.no_grad():
        for layer in layers:
            layer.weight *= WEIGHT_SCALE
    tensors = {}
    for index, layer in enumerate(layers):
        tensors[f"layers.{index}.weight"] = layer.weight.detach().numpy().astype(np.float32)
        tensors[f"layers.{index}.bias"] = layer.bias.detach().numpy().astype(np.float32)

    limits = torch.tensor([6.0, 6.0, np.pi, 1.5], dtype=torch.float64)
    unit = torch.rand(SAMPLES, 4, dtype=torch.float64)
    inputs = (2.0 * unit - 1.0) * limits
    inputs = inputs.float().double().requires_grad_(True)  # float32 numbers, computed on in float64

    a = encode(inputs)
    for layer in layers[:-1]:
        a = torch.sin(layer.double()(a))
    residual = torch.nn.functional.softplus(layers[-1].double()(a)).squeeze(1)
    (gradient,) = torch.autograd.grad(residual.sum(), inputs)

    tensors["inputs"] = inputs.detach().numpy().astype(np.float32)
    tensors["residual"] = residual.detach().numpy()
    tensors["gradient"] = gradient.numpy()
    norms = np.linalg.norm(tensors["gradient"], axis=1)
    path = Path(__file__).resolve().parent.parent / "data" / f"{name}.safetensors"
    save_file(tensors, path, metadata={"made_by": Path(__file__).name, "torch": torch.__version__})
    print(f"{path.name}: residual {residual.min():.3f} to {residual.max():.3f} m, "
          f"gradient norm median {np.median(norms):.3f}, max {norms.max():.3f}")


def main() -> None:
    torch.set_num_threads(1)
    write("barrier_torch_reference", raw, 4)
    write("barrier_torch_cos_sin_reference", heading_cos_sin, 5)


if __name__ == "__main__":
    main()
