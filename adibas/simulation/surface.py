"""Points that stick to a body's skin, and the rays that find them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, Int32Array, IntArray, check_shape, read_only

_EDGE = 1e-9
"""Barycentric slack at a triangle's edges."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceAnchors:
    """Named points on a mesh, given by triangle so that they follow the skin in any pose.

    Attributes
    ----------
    names : tuple of str
    triangles : (N,) array
        Index of the triangle that holds each point.
    barycentric : (N, 3) array
        Weights of its corners; they sum to 1.
    """

    names: tuple[str, ...]
    triangles: IntArray
    barycentric: FloatArray

    def __post_init__(self) -> None:
        check_shape("triangles", self.triangles, (len(self.names),))
        check_shape("barycentric", self.barycentric, (len(self.names), 3))
        read_only(self.triangles)
        read_only(self.barycentric)

    def on(self, vertex_values: FloatArray, mesh_triangles: Int32Array) -> FloatArray:
        """Interpolate (V, D) values at the vertices to (N, D) values at the anchors."""
        corners = vertex_values[mesh_triangles[self.triangles]]
        return np.asarray(np.einsum("nk,nkd->nd", self.barycentric, corners))

    def chosen(self, names: Iterable[str]) -> "SurfaceAnchors":
        """Return the anchors of these names, in that order."""
        wanted = tuple(names)
        rows = [self.names.index(name) for name in wanted]
        return SurfaceAnchors(wanted, self.triangles[rows], self.barycentric[rows])


@dataclass(frozen=True, slots=True, eq=False)
class Ray:
    """Where to look for a skin point: from inside the body outwards, on some parts only."""

    origin_m: FloatArray
    direction: FloatArray
    on_triangles: BoolArray


def anchor_rays(rays: dict[str, Ray], vertices_m: FloatArray, mesh: Int32Array) -> SurfaceAnchors:
    """Return the outermost point of the mesh that each ray meets.

    Raises
    ------
    ValueError
        A ray meets nothing: its rule does not fit this body.
    """
    hits = [_outermost(name, ray, vertices_m, mesh) for name, ray in rays.items()]
    return SurfaceAnchors(
        tuple(rays), np.array([hit[0] for hit in hits]), np.array([hit[1] for hit in hits])
    )


def _outermost(
    name: str, ray: Ray, vertices_m: FloatArray, mesh: Int32Array
) -> tuple[int, FloatArray]:
    """Return triangle and barycentric weights of the farthest hit.

    Source: Moeller & Trumbore, Fast, minimum storage ray-triangle intersection, 1997.
    """
    candidates = np.flatnonzero(ray.on_triangles)
    a, b, c = (vertices_m[mesh[candidates, i]] for i in range(3))
    across = np.cross(ray.direction, c - a)
    size = np.einsum("ij,ij->i", b - a, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_origin = ray.origin_m - a
        u = np.einsum("ij,ij->i", to_origin, across) / size
        along = np.cross(to_origin, b - a)
        v = along @ ray.direction / size
        distance = np.einsum("ij,ij->i", c - a, along) / size
        # Rays of the midline run along edges, where rounding must not let them slip through; those
        # along a triangle have no u and v, and do not meet it.
        met = (np.minimum(u, v) >= -_EDGE) & (u + v <= 1 + _EDGE) & (distance > 0)
    if not met.any():
        raise ValueError(f"no skin found for {name}")
    best = int(np.argmax(np.where(met, distance, -np.inf)))
    return int(candidates[best]), np.array([1 - u[best] - v[best], u[best], v[best]])
