"""Linear blend skinning: each vertex follows a few bones; and the normals that result."""

import math

from adibas.arrays import Float32Array, FloatArray, Int32Array, UInt8Array
from adibas.kernels import compiled


@compiled
def skin(
    rest_m: FloatArray,
    bone_indices: UInt8Array,
    bone_weights: Float32Array,
    turns: FloatArray,
    posed_m: FloatArray,
) -> None:
    """Write the (V, 3) vertices of a posed body into `posed_m`.

    `bone_indices` and `bone_weights` are (V, K), the weights of a vertex sum to 1 and fall from
    left to right; `turns` (B, 3, 4) maps rest points onto posed ones, bone by bone.
    """
    for vertex in range(rest_m.shape[0]):
        x, y, z = rest_m[vertex, 0], rest_m[vertex, 1], rest_m[vertex, 2]
        moved_x = moved_y = moved_z = 0.0
        for k in range(bone_indices.shape[1]):
            weight = bone_weights[vertex, k]
            if weight == 0.0:
                break
            t = turns[bone_indices[vertex, k]]
            moved_x += weight * (t[0, 0] * x + t[0, 1] * y + t[0, 2] * z + t[0, 3])
            moved_y += weight * (t[1, 0] * x + t[1, 1] * y + t[1, 2] * z + t[1, 3])
            moved_z += weight * (t[2, 0] * x + t[2, 1] * y + t[2, 2] * z + t[2, 3])
        posed_m[vertex, 0] = moved_x
        posed_m[vertex, 1] = moved_y
        posed_m[vertex, 2] = moved_z


@compiled
def add_normals(vertices_m: FloatArray, triangles: Int32Array, normals: FloatArray) -> None:
    """Turn `normals`, (V, 3) zeros, into unit vertex normals that point outwards.

    Each is the mean over its triangles by area; zero where these have none.
    """
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ux = vertices_m[b, 0] - vertices_m[a, 0]
        uy = vertices_m[b, 1] - vertices_m[a, 1]
        uz = vertices_m[b, 2] - vertices_m[a, 2]
        vx = vertices_m[c, 0] - vertices_m[a, 0]
        vy = vertices_m[c, 1] - vertices_m[a, 1]
        vz = vertices_m[c, 2] - vertices_m[a, 2]
        for vertex in (a, b, c):
            normals[vertex, 0] += uy * vz - uz * vy
            normals[vertex, 1] += uz * vx - ux * vz
            normals[vertex, 2] += ux * vy - uy * vx
    for vertex in range(normals.shape[0]):
        n = normals[vertex]
        length = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        if length > 0.0:
            n /= length
