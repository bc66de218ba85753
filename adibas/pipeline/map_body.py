"""How a person who is mapped alone was not rigid: sway over the floor, breathing, head and arms."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.alignment.surfels import Distances
from adibas.arrays import FloatArray
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform

BANDS = {"legs": (0.0, 0.5), "trunk": (0.5, 0.85), "head": (0.85, 1.01)}
"""Shares of the stature; arms hang along legs and trunk."""
TRIMMED = (1, 99)
"""Percentiles of the heights between which the person stands."""
FEWEST_POINTS = 50


@dataclass(frozen=True, slots=True)
class BodyMotion:
    """What single frames differ by from the joined surface, sensor noise included.

    Attributes
    ----------
    residual_mm : float
        Root mean square distance from the surface, median of the frames.
    largest_mm : float
        That of the worst frame.
    bands_mm : dict of str to float
        `residual_mm` by height: legs, trunk, head; those that were seen.
    wandered_mm : float
        How far the middle of the body was from its mean over the floor, root mean square: sway and
        steps, which the alignment follows.
    """

    residual_mm: float
    largest_mm: float
    bands_mm: dict[str, float]
    wandered_mm: float


def body_motion(
    distances: Sequence[Distances], world_from_camera: Sequence[RigidTransform], floor: Plane
) -> BodyMotion | None:
    """Sum up how frames differ from the surface; None where hardly anything is seen.

    Parameters
    ----------
    distances : sequence of Distances
        Of each frame.
    world_from_camera : sequence of RigidTransform
        Of the same frames.
    floor : Plane
        In the camera's axes, which stands still.
    """
    seen = [
        (one, pose)
        for one, pose in zip(distances, world_from_camera, strict=True)
        if len(one.behind_m) >= FEWEST_POINTS
    ]
    if not seen:
        return None
    heights_m = [floor.signed_distance_m(pose.inverse().apply(one.points_m)) for one, pose in seen]
    low_m, high_m = np.percentile(np.concatenate(heights_m), TRIMMED)
    shares = [(height_m - low_m) / max(high_m - low_m, 1e-6) for height_m in heights_m]
    bands = {
        name: [
            _rms_mm(one.behind_m[(share >= low) & (share < high)])
            for (one, _), share in zip(seen, shares, strict=True)
        ]
        for name, (low, high) in BANDS.items()
    }
    whole = [_rms_mm(one.behind_m) for one, _ in seen]
    return BodyMotion(
        float(np.nanmedian(whole)),
        float(np.nanmax(whole)),
        {name: float(np.nanmedian(one)) for name, one in bands.items() if np.isfinite(one).any()},
        _wandered_mm(distances, world_from_camera, floor),
    )


def _rms_mm(distances_m: FloatArray) -> float:
    if len(distances_m) < FEWEST_POINTS:
        return float("nan")
    return 1e3 * float(np.sqrt(np.mean(distances_m**2)))


def _wandered_mm(
    distances: Sequence[Distances], world_from_camera: Sequence[RigidTransform], floor: Plane
) -> float:
    """Return the path of the middle of the whole surface, over the floor."""
    middle_m = np.mean(np.concatenate([one.points_m for one in distances]), axis=0)
    path_m = np.array([pose.inverse().apply(middle_m) for pose in world_from_camera])
    over = path_m - np.outer(floor.signed_distance_m(path_m), floor.normal)
    off_m = over - over.mean(axis=0)
    return 1e3 * float(np.sqrt((off_m**2).sum(axis=1).mean()))
