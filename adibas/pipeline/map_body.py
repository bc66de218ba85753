"""How a person who is mapped alone was not rigid: sway over the floor, breathing, head and arms."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.alignment.surfels import Distances
from adibas.arrays import FloatArray
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.surface.hanging_arms import are_of_arms

BANDS = {"legs": (-0.05, 0.5), "trunk": (0.5, 0.85), "head": (0.85, 1.05)}
"""Shares of the stature, without arms that hang beside the trunk."""
ARMS = "arms"
HIGHEST = 99
"""Percentile of the heights over the floor up to which the person reaches."""
FEWEST_POINTS = 50
STILL_RAD, AROUND_RAD = 0.05, 4.0
"""A turn by less hardly moves a middle that is 0.1 m amiss; after a turn by more, of 230 degrees,
all sides were seen at less than 65 degrees."""
EDGES = (1, 99)
"""Percentiles between which the body lies, across the floor."""


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
        `residual_mm` of legs, trunk, head by their heights, and of arms as far as they hang apart
        from the trunk; those that were seen, and none without a floor: of somebody seen from the
        waist up nothing else would tell that these are no legs.
    wandered_mm : float or None
        How far the middle of the body was from its mean over the floor, root mean square: sway and
        steps, which the alignment follows. None of somebody who turned without being seen from all
        around: where the middle is, half a surface does not tell, and it would go round with them.
    """

    residual_mm: float
    largest_mm: float
    bands_mm: dict[str, float]
    wandered_mm: float | None


def body_motion(
    distances: Sequence[Distances],
    world_from_camera: Sequence[RigidTransform],
    level: Plane,
    *,
    is_floor: bool,
) -> BodyMotion | None:
    """Sum up how frames differ from the surface; None where hardly anything is seen.

    Parameters
    ----------
    distances : sequence of Distances
        Of each frame.
    world_from_camera : sequence of RigidTransform
        Of the same frames.
    level : Plane
        The floor, or a level plane anywhere, in the camera's axes, which stands still.
    is_floor : bool
        It is the floor.
    """
    seen = [
        (one, pose)
        for one, pose in zip(distances, world_from_camera, strict=True)
        if len(one.behind_m) >= FEWEST_POINTS
    ]
    if not seen:
        return None
    whole = [_rms_mm(one.behind_m) for one, _ in seen]
    return BodyMotion(
        float(np.nanmedian(whole)),
        float(np.nanmax(whole)),
        _bands_mm(seen, level) if is_floor else {},
        _wandered_mm(distances, world_from_camera, level),
    )


def _bands_mm(seen: Sequence[tuple[Distances, RigidTransform]], floor: Plane) -> dict[str, float]:
    points_m = np.concatenate([one.points_m for one, _ in seen])
    heights_m = np.concatenate(
        [floor.signed_distance_m(pose.inverse().apply(one.points_m)) for one, pose in seen]
    )
    high_m = max(float(np.percentile(heights_m, HIGHEST)), 1e-6)
    # Places on the body, in which it stands still, not those over the floor.
    inside_m = seen[0][1].inverse().apply(points_m)
    are_arms = are_of_arms(inside_m @ _over(floor).T, heights_m, high_m)
    parts = {
        name: ~are_arms & (heights_m >= low * high_m) & (heights_m < high * high_m)
        for name, (low, high) in BANDS.items()
    }
    ends = np.cumsum([len(one.points_m) for one, _ in seen])[:-1]
    found = {
        name: [
            _rms_mm(one.behind_m[is_of_part])
            for (one, _), is_of_part in zip(seen, np.split(is_of, ends), strict=True)
        ]
        for name, is_of in {**parts, ARMS: are_arms}.items()
    }
    return {name: float(np.nanmedian(one)) for name, one in found.items() if np.isfinite(one).any()}


def _over(level: Plane) -> FloatArray:
    """Return two axes (2, 3) along a level plane."""
    aside = np.eye(3)[int(np.abs(level.normal).argmin())]
    right = np.cross(level.normal, aside)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, level.normal)])


def _rms_mm(distances_m: FloatArray) -> float:
    if len(distances_m) < FEWEST_POINTS:
        return float("nan")
    return 1e3 * float(np.sqrt(np.mean(distances_m**2)))


def _wandered_mm(
    distances: Sequence[Distances], world_from_camera: Sequence[RigidTransform], level: Plane
) -> float | None:
    """Return the path of the middle of the whole surface, over the floor."""
    bodies = [pose.inverse() for pose in world_from_camera]
    over = _over(level)
    if STILL_RAD < _turn_rad(bodies, over) < AROUND_RAD:
        return None
    points_m = np.concatenate([one.points_m for one in distances])
    # Between the edges: sides that were seen more often count no more.
    inside_m = bodies[0].apply(points_m)
    low_m, high_m = np.percentile(inside_m @ over.T, EDGES, axis=0)
    middle_m = inside_m.mean(axis=0)
    middle_m += ((low_m + high_m) / 2.0 - over @ middle_m) @ over
    fixed_m = world_from_camera[0].apply(middle_m)
    path_m = np.array([body.apply(fixed_m) for body in bodies]) @ over.T
    off_m = path_m - path_m.mean(axis=0)
    return 1e3 * float(np.sqrt((off_m**2).sum(axis=1).mean()))


def _turn_rad(bodies: Sequence[RigidTransform], over: FloatArray) -> float:
    """Return between which directions a body looked, however often it went round."""
    ahead = bodies[0].rotation.T @ over[0]
    looks = np.array([over @ body.rotation @ ahead for body in bodies])
    return float(np.ptp(np.unwrap(np.arctan2(looks[:, 1], looks[:, 0]))))
