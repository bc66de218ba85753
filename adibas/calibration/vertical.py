"""Which way is down, from the floor or from an accelerometer, and how sure that is.

A floor is taken for level. How uneven it is shows in the depth, how much it leans does not: the
angle's uncertainty is that of the measured normal.

Source: Hartley & Zisserman, Multiple View Geometry, 2nd ed., section 5.2, for the propagation;
blocks of neighbours that err together as in `adibas.calibration.extrinsics_uncertainty`.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only
from adibas.geometry.planes import Plane

LEAST_BLOCKS = 6
LEAST_SAMPLES = 10
LARGEST_SWAY = 0.05
"""Scatter of an accelerometer's length over its mean, beyond which the sensor is moved."""

MAD_TO_SD = 1.4826


@dataclass(frozen=True, slots=True, eq=False)
class Vertical:
    """Down in the axes of the depth camera.

    Attributes
    ----------
    gravity : (3,) array
        Unit vector that points down.
    sd_rad : float
        Standard deviation of its angle in the worse of two directions.
    floor : Plane or None
        Normal up; None from an accelerometer.
    flatness_m : float
        Root mean square of the floor's blocks about the plane; NaN from an accelerometer.
    """

    gravity: FloatArray
    sd_rad: float
    floor: Plane | None = None
    flatness_m: float = float("nan")

    def __post_init__(self) -> None:
        check_shape("gravity", self.gravity, (3,))
        read_only(self.gravity)

    def disagreement_rad(self, other: "Vertical") -> float:
        """Return the angle between two verticals."""
        sine = np.linalg.norm(np.cross(self.gravity, other.gravity))
        return float(np.arctan2(sine, self.gravity @ other.gravity))


def vertical_from_floor(blocks_m: FloatArray, floor: Plane) -> Vertical | None:
    """Refine a floor and say how sure its normal is.

    Parameters
    ----------
    blocks_m : (N, 3) array
        Means over blocks of floor pixels that are large enough to err independently, in the
        depth camera's axes, bias corrected, metres.
    floor : Plane
        Near the truth, normal up.

    Returns
    -------
    vertical : Vertical or None
        None for too few blocks, or blocks on a line.
    """
    check_shape("blocks_m", blocks_m, (None, 3))
    if len(blocks_m) < LEAST_BLOCKS:
        return None
    z_m = blocks_m[:, 2]
    # 1/z is linear in the ray, and its noise is the same everywhere.
    rays = blocks_m / z_m[:, None]
    try:
        m, normal_matrix, residuals, kept = _inverse_plane(rays, 1.0 / z_m)
    except np.linalg.LinAlgError:
        return None
    length = float(np.linalg.norm(m))
    up = m / length
    up = up if up @ floor.normal > 0 else -up
    n_free = int(kept.sum()) - 3
    variance = float((residuals[kept] ** 2).sum()) / max(n_free, 1)
    across = (np.eye(3) - np.outer(up, up)) / length
    covariance = across @ np.linalg.inv(normal_matrix) @ across.T * variance
    # The plane is m . p = 1, m along the normal or against it.
    offset_m = -1.0 / length if up @ m > 0 else 1.0 / length
    plane = Plane(up, offset_m)
    heights_m = plane.signed_distance_m(blocks_m[kept])
    return Vertical(
        -up,
        float(np.sqrt(np.linalg.eigvalsh(covariance)[-1])),
        plane,
        float(np.sqrt(np.mean(heights_m**2))),
    )


def _inverse_plane(
    rays: FloatArray, inverse_m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Fit ``1/z = m . ray`` without blocks that are far off; return m, J'J, residuals, kept."""
    kept: BoolArray = np.ones(len(rays), bool)
    for _ in range(4):
        normal_matrix = rays[kept].T @ rays[kept]
        if np.linalg.cond(normal_matrix) > 1e12:  # noqa: PLR2004  (blocks on a line)
            raise np.linalg.LinAlgError
        m = np.asarray(np.linalg.solve(normal_matrix, rays[kept].T @ inverse_m[kept]), float)
        residuals = inverse_m - rays @ m
        spread = max(MAD_TO_SD * float(np.median(np.abs(residuals[kept]))), 1e-9)
        kept = np.abs(residuals) < 4.0 * spread
    return m, rays[kept].T @ rays[kept], residuals, kept


def vertical_from_accelerometer(
    samples_m_s2: FloatArray, depth_from_sensor: FloatArray | None = None
) -> Vertical | None:
    """Return down from an accelerometer at rest, which shows the push against gravity.

    Parameters
    ----------
    samples_m_s2 : (N, 3) array
        Of a sensor that stands still, in its own axes.
    depth_from_sensor : (3, 3) array or None
        Rotation into the depth camera's axes; None: they are the same.

    Returns
    -------
    vertical : Vertical or None
        None for fewer than ten samples, or a sensor that is moved.
    """
    check_shape("samples_m_s2", samples_m_s2, (None, 3))
    if len(samples_m_s2) < LEAST_SAMPLES:
        return None
    mean = samples_m_s2.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if not np.linalg.norm(samples_m_s2, axis=1).std() < LARGEST_SWAY * length:
        return None
    up = mean / length
    across = (np.eye(3) - np.outer(up, up)) / length
    covariance = across @ np.cov(samples_m_s2.T) @ across.T / len(samples_m_s2)
    down = -up if depth_from_sensor is None else -(depth_from_sensor @ up)
    return Vertical(down, float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0))))
