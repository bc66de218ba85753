"""How large and how shared out what was found is: figures that people have and things seldom.

Part of what tells people from things; see `adibas.limbs.likeness`. The figures are ours.
"""

import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, FloatArray, check_shape
from adibas.data.joints import BODY_PART_NAMES
from adibas.data.limbs import LimbParts

FIGURES = (
    "torso_squared",
    "head_squared",
    "least_forearm",
    "upper_arms",
    "head_over_torso",
    "thickness",
    "width",
    "legs_width",
)
"""What `describe_figure` gives, in this order: shares, and metres."""
MOST_POINTS = 2000
LEGS_BELOW_M = (0.8, 1.0)
"""Under the top of an adult the thighs, of a child the knees."""
LEAST_POINTS = 4


def describe_figure(
    depth_m: Float32Array, mask: BoolArray, rays: Float32Array, parts: LimbParts
) -> FloatArray:
    """Return the (8,) `FIGURES` of limbs that were found.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Metres; NaN where not measured.
    mask : (H, W) bool array
        Whose limbs they are; at least some pixels with depth.
    rays : (H, W, 3) float32 array
        Direction of each pixel, z = 1.
    parts : LimbParts
        Of the full body.
    """
    check_shape("rays", rays, (*depth_m.shape, 3))
    index = np.flatnonzero(mask & np.isfinite(depth_m))
    index = index[:: max(1, len(index) // MOST_POINTS)]
    rows, columns = np.divmod(index, mask.shape[1])
    points_m = (rays[rows, columns] * depth_m[rows, columns][:, None]).astype(np.float64)
    labels = parts.chosen[rows, columns]
    return np.array([*_shares(labels), *_sizes(points_m, labels)])


def _shares(labels: AnyArray) -> tuple[float, float, float, float]:
    """Return what the trunk, the head, the less visible forearm and the upper arms have of all."""
    torso, head = (_share(labels, name) for name in ("torso", "head"))
    forearms = [_share(labels, f"{side}_lower_arm") for side in ("left", "right")]
    upper_arms = [_share(labels, f"{side}_upper_arm") for side in ("left", "right")]
    return torso**2, head**2, min(forearms), sum(upper_arms)


def _sizes(points_m: FloatArray, labels: AnyArray) -> tuple[float, ...]:
    x_m, y_m = points_m[:, 0], points_m[:, 1]
    middles_m = [
        float(y_m[here].mean()) if here.sum() >= LEAST_POINTS else np.nan
        for here in (labels == BODY_PART_NAMES.index(name) for name in ("head", "torso"))
    ]
    spreads_m2 = np.linalg.eigvalsh(np.cov(points_m.T))
    below_m = y_m - np.percentile(y_m, 0.5)
    legs = (below_m > LEGS_BELOW_M[0]) & (below_m < LEGS_BELOW_M[1])
    return (
        float(np.nan_to_num(middles_m[1] - middles_m[0])),
        float(np.sqrt(max(spreads_m2[0], 0.0))),
        float(np.ptp(np.percentile(x_m, (2, 98)))),
        float(np.ptp(np.percentile(x_m[legs], (5, 95)))) if legs.sum() >= LEAST_POINTS else 0.0,
    )


def _share(labels: AnyArray, name: str) -> float:
    return float((labels == BODY_PART_NAMES.index(name)).mean())
