"""What the spine of a simulated body measures: by the definitions, on its own skin's midline."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from adibas.arrays import BoolArray, FloatArray, Int32Array
from adibas.pipeline.back import Back
from adibas.surface.sagittal import SagittalParams
from adibas.surface.spine_profile import ProfileParams, fit_profile
from adibas.surface.symmetry_line import SymmetryLine

STEP_M = 0.002
HALF_TANGENT_M = 0.03
N_HEIGHTS = 200
N_SAMPLES = 400_000


@dataclass(frozen=True, slots=True)
class TrueSpine:
    """Angles in degrees and fleches in millimetres."""

    kyphosis_deg: float
    lordosis_deg: float
    fleche_cervicale_mm: float
    fleche_lombaire_mm: float

    def values(self) -> FloatArray:
        """Return the four as an array."""
        return np.array(
            [
                self.kyphosis_deg,
                self.lordosis_deg,
                self.fleche_cervicale_mm,
                self.fleche_lombaire_mm,
            ]
        )


def true_rotation_rad(points_m: FloatArray, midline_m: FloatArray, back: Back) -> FloatArray:
    """Return the course of the rotation along the midline of a surface without noise.

    Parameters
    ----------
    points_m : (N, 3) array
        Of the back without noise, patient axes.
    midline_m : (N, 3) array
        The skin over the spinous processes, from the neck down.
    back : Back
        The estimate: the course goes from turn to turn.
    """
    if back.shape is None:
        raise ValueError("a back without curves has no rotation")
    top_m = min(back.profile.top_m, midline_m[0, 1])
    bottom_m = max(back.profile.bottom_m, midline_m[-1, 1])
    y_m = np.linspace(top_m, bottom_m, N_HEIGHTS)
    x_m = np.interp(y_m, midline_m[::-1, 1], midline_m[::-1, 0])
    line = SymmetryLine(y_m, x_m, np.zeros(N_HEIGHTS), np.zeros(N_HEIGHTS))
    between_m = np.arange(max(back.shape.ils_m, bottom_m), min(back.shape.ict_m, top_m), STEP_M)
    return fit_profile(points_m, line).rotation_rad(between_m)


def smoothed_truth(midline_m: FloatArray, stature_m: float, top_m: float) -> TrueSpine:
    """Return the measures of a midline whose waves under 0.13 m are halved, as the estimate's are.

    Parameters
    ----------
    midline_m : (N, 3) array
        Patient axes, from the neck down.
    top_m : float
        Height at which the estimate's profile begins.
    """
    y_m = np.arange(midline_m[-1, 1], midline_m[0, 1], STEP_M)
    z_m = np.interp(y_m, midline_m[::-1, 1], midline_m[::-1, 2])
    third = np.diff(np.eye(len(y_m)), 3, axis=0) / STEP_M**3
    stiffness = (ProfileParams().shortest_wave_m / (2.0 * np.pi)) ** 6
    smooth_m = np.linalg.solve(np.eye(len(y_m)) + stiffness * third.T @ third, z_m)
    return _measured(y_m, smooth_m, np.gradient(smooth_m, y_m), stature_m, top_m)


def plain_truth(midline_m: FloatArray, stature_m: float, top_m: float) -> TrueSpine:
    """Return the measures of the midline as it is; a tangent touches 60 mm of it."""
    y_m = np.arange(midline_m[-1, 1], midline_m[0, 1], STEP_M)
    z_m = np.interp(y_m, midline_m[::-1, 1], midline_m[::-1, 2])
    half = round(HALF_TANGENT_M / STEP_M)
    places = range(half, len(y_m) - half)
    slopes = [
        float(np.polyfit(y_m[at - half : at + half + 1], z_m[at - half : at + half + 1], 1)[0])
        for at in places
    ]
    inner = slice(half, len(y_m) - half)
    return _measured(y_m[inner], z_m[inner], np.array(slopes), stature_m, top_m)


def distances_mm(points_m: FloatArray, vertices_m: FloatArray, triangles: Int32Array) -> FloatArray:
    """Return the signed distance of (N, 3) points from a mesh, outward."""
    on_mesh_m, normals = mesh_samples(vertices_m, triangles)
    nearest = np.asarray(cKDTree(on_mesh_m).query(points_m)[1])
    off_m = ((points_m - on_mesh_m[nearest]) * normals[nearest]).sum(axis=1)
    return np.asarray(1e3 * off_m)


def mesh_samples(vertices_m: FloatArray, triangles: Int32Array) -> tuple[FloatArray, FloatArray]:
    """Return points spread evenly over a mesh, and the triangles' normals there."""
    rng = np.random.default_rng(0)
    a, b, c = (vertices_m[triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    chosen = rng.choice(len(area), N_SAMPLES, p=area / area.sum())
    u, v = rng.random((2, N_SAMPLES))
    over = u + v > 1.0
    u[over], v[over] = 1.0 - u[over], 1.0 - v[over]
    points_m = a[chosen] + u[:, None] * (b - a)[chosen] + v[:, None] * (c - a)[chosen]
    return points_m, cross[chosen] / area[chosen, None]


def _measured(
    y_m: FloatArray, z_m: FloatArray, slopes: FloatArray, stature_m: float, top_m: float
) -> TrueSpine:
    params = SagittalParams()
    share = y_m / stature_m
    low, high = params.thoracolumbar
    itl = _argmax(slopes, (share >= low) & (share <= high) & _is_peak(slopes))
    ict = _argmax(-slopes, (y_m > y_m[itl]) & (y_m < top_m))
    ils = _argmax(-slopes, (y_m < y_m[itl]) & (share >= params.lowest))
    angles_deg = np.degrees(np.arctan(slopes[[ict, itl, ils]]))
    apex_m = z_m[itl : ict + 1].max()
    neck_m = z_m[(y_m >= y_m[ict]) & (y_m < top_m)].min()
    return TrueSpine(
        float(angles_deg[1] - angles_deg[0]),
        float(angles_deg[1] - angles_deg[2]),
        1e3 * float(apex_m - neck_m),
        1e3 * float(apex_m - z_m[ils : itl + 1].min()),
    )


def _argmax(values: FloatArray, allowed: BoolArray) -> int:
    places = np.flatnonzero(allowed)
    return int(places[values[places].argmax()])


def _is_peak(values: FloatArray) -> BoolArray:
    """Return where a curve turns; at the border of what is allowed it only goes on."""
    is_peak = np.zeros(len(values), np.bool_)
    is_peak[1:-1] = (values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])
    return is_peak
