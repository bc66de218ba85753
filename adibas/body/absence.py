"""Why nobody is found in a depth image, for the word that is said."""

from typing import Literal, TypeAlias

import numpy as np

from adibas.arrays import BoolArray, Float32Array
from adibas.body.component_kernels import label_surfaces, surface_moments
from adibas.body.holes import hole_share
from adibas.body.mask import heights_over, standing_free
from adibas.body.person import BodyParams, could_be_of_a_person
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.geometry.picture_edges import cut_px, seen_box
from adibas.geometry.planes import Plane

Absence: TypeAlias = Literal["blind", "holes", "near", "cut", "gap", "thing", "nobody"]

LEAST_MEASURED = 0.1
"""Share of the picture: with less the camera is covered, blinded, or somebody is before it."""
MOST_HOLES = 0.3
"""Share of the picture in holes that measured pixels surround."""
NEAREST_M, NEAR_SHARE = 0.8, 0.05
"""So many of the measured pixels nearer than that are somebody too near."""
LARGE_GAP = 0.25
"""Share of the picture without depth in which somebody may stand, nearer than sensors measure."""
LEAST_CUT = 0.12
"""Share of the picture's height: so much of an edge is touched by what it cuts off."""


def why_nobody(
    depth_m: Float32Array,
    camera: CameraCalibration,
    floor: Plane | None = None,
    params: BodyParams | None = None,
) -> Absence:
    """Return why nobody was found: the first of these that holds.

    ``blind``: hardly any depth; ``near``: something is nearer than a person can be measured;
    ``holes``: the depth is full of holes; ``cut``: what may be a part of a person is cut off by
    the edge of the picture; ``gap``: a large part of the picture has no depth, as where somebody
    stands nearer than the sensor measures; ``thing``: what stands there is too low or too flat for
    a person; ``nobody``.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Metres; NaN where not measured.
    camera : CameraCalibration
        Of the camera that took `depth_m`.
    floor : Plane or None
        In the camera's axes, normal up.
    params : BodyParams or None
    """
    measured = np.asarray(np.isfinite(depth_m))
    if measured.mean() < LEAST_MEASURED:
        return "blind"
    if (depth_m[measured] < NEAREST_M).mean() > NEAR_SHARE:
        return "near"
    if hole_share(measured) > MOST_HOLES:
        return "holes"
    return _what_stands(depth_m, measured, camera, floor, params or BodyParams())


def _what_stands(
    depth_m: Float32Array,
    measured: BoolArray,
    camera: CameraCalibration,
    floor: Plane | None,
    params: BodyParams,
) -> Absence:
    rays = viewing_rays(camera)
    heights_m = None if floor is None else heights_over(depth_m, camera, floor)
    inverse_depth = standing_free(depth_m, heights_m, params)
    labels, n_labels = label_surfaces(inverse_depth, params.step_per_m, params.step_m)
    moments = surface_moments(labels, n_labels, inverse_depth, rays)
    standing = [
        label for label in range(1, n_labels + 1) if could_be_of_a_person(moments[label], params)
    ]
    box = seen_box(measured)
    least_px = LEAST_CUT * camera.height
    if any(cut_px(np.asarray(labels == label), box).max() > least_px for label in standing):
        return "cut"
    if 1.0 - measured.mean() > LARGE_GAP:
        return "gap"
    return "thing" if standing else "nobody"
