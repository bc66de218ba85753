"""Linear blend skinning: each vertex follows a few bones."""

from adibas.arrays import Float32Array, FloatArray, UInt8Array
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
