"""Which part of the body each depth pixel shows, and how well it reflects infrared."""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, UInt8Array
from adibas.kernels import compiled
from adibas.simulation.color_kernels import Mesh, material_at
from adibas.simulation.raster import ray_weights


@compiled
def _strongest(part_weights: Float32Array, corners: Int32Array, weights: FloatArray) -> int:
    best, most = 0, -1.0
    for part in range(part_weights.shape[1]):
        share = 0.0
        for corner in range(3):
            share += part_weights[corners[corner], part] * weights[corner]
        if share > most:
            best, most = part, share
    return best


@compiled
def label_person(
    mesh: Mesh,
    part_weights: Float32Array,
    infrared: Float32Array,
    images: tuple[Int32Array, Float32Array],
    results: tuple[UInt8Array, Float32Array],
) -> None:
    """Fill labels (H, W), 0 elsewhere, and reflectance (H, W) where the person is seen.

    `part_weights` (V, P) are the shares of the parts, `infrared` (M,) the reflectances of the
    materials, `images` the triangle of each pixel and its ray.
    """
    seen, rays = images
    labels, reflectance = results
    weights = np.empty(3)
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            if seen[v, u] < 0:
                continue
            corners = mesh.triangles[seen[v, u]]
            weights[0], weights[1] = ray_weights(
                rays[v, u, 0], rays[v, u, 1], mesh.vertices, corners[0], corners[1], corners[2]
            )
            weights[2] = 1.0 - weights[0] - weights[1]
            labels[v, u] = np.uint8(_strongest(part_weights, corners, weights) + 1)
            reflectance[v, u] = infrared[material_at(mesh.covers, corners, weights)]
