"""The person in a depth image.

The floor is taken away; what is left falls apart at the steps of the depth into surfaces. The
largest one that can be a person (size, not flat) is the body; surfaces that border on it and are
hardly farther away (an arm before the trunk, the far leg) belong to it too. Holes without depth
inside it (dark hair, LEDs) are filled.
"""

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, check_shape
from adibas.body.component_kernels import label_surfaces, surface_moments
from adibas.body.person import BodyParams, Surfaces, find_person
from adibas.body.rays import rise_of_rays, viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.data.masks import BodyMask
from adibas.geometry.planes import Plane


def find_body(
    depth_m: Float32Array,
    depth_camera: CameraCalibration,
    floor: Plane | None = None,
    params: BodyParams | None = None,
) -> BodyMask | None:
    """Return the pixels of the largest person, or None where there is nobody.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Along the depth camera's z, metres; NaN where not measured.
    depth_camera : CameraCalibration
        Of the camera that took `depth_m`.
    floor : Plane or None
        In the depth camera's axes, normal up; see `adibas.body.floor.find_floor`. None where no
        floor is in view.
    """
    params = params or BodyParams()
    check_shape("depth_m", depth_m, (depth_camera.height, depth_camera.width))
    rays = viewing_rays(depth_camera)
    heights_m = None if floor is None else heights_over(depth_m, depth_camera, floor)
    inverse_depth = standing_free(depth_m, heights_m, params)
    labels, n_labels = label_surfaces(inverse_depth, params.step_per_m, params.step_m)
    moments = surface_moments(labels, n_labels, inverse_depth, rays)
    pixel_rad = float(rays[0, 1, 0] - rays[0, 0, 0])
    surfaces = Surfaces(labels, moments, inverse_depth, heights_m, pixel_rad)
    body = find_person(surfaces, params)
    if body is None:
        return None
    belongs = bodies_parts(surfaces, body, params)
    pixels = belongs[labels]
    box = box_of(pixels, params.bay_px + 1)
    measured = np.isfinite(depth_m[box])
    pixels[box] = fill_holes(close_bays(pixels[box], measured, params), measured, params)
    return BodyMask(pixels)


def heights_over(
    depth_m: Float32Array, depth_camera: CameraCalibration, floor: Plane
) -> Float32Array:
    """Return the (H, W) height over the floor, metres; NaN where there is no depth."""
    heights_m: Float32Array = rise_of_rays(depth_camera, floor) * depth_m
    heights_m += np.float32(floor.offset_m)
    return heights_m


def standing_free(
    depth_m: Float32Array, heights_m: Float32Array | None, params: BodyParams
) -> Float32Array:
    """Return inverse depth (1/m), 0 where there is none, out of range or on the floor."""
    with np.errstate(invalid="ignore"):
        usable = (depth_m > params.range_m[0]) & (depth_m < params.range_m[1])
        if heights_m is not None:
            band_m = np.float32(params.floor_band_per_m) * depth_m
            band_m *= depth_m
            band_m += np.float32(params.floor_band_m)
            usable &= heights_m > band_m
    inverse = np.zeros(depth_m.shape, np.float32)
    np.divide(np.float32(1), depth_m, out=inverse, where=usable)
    return inverse


def bodies_parts(surfaces: Surfaces, body: int, params: BodyParams) -> BoolArray:
    """Say of each label whether it belongs to the person."""
    moments = surfaces.moments
    border = surfaces.borders(body, params.joint_reach_px)
    touches = border[:, 0] > 0
    gap_m, share = border[:, 1], moments[:, 0] / moments[body, 0]
    middle_m = moments[body, 1:4] / moments[body, 0]
    before = (gap_m > -params.front_gap_m) & (gap_m < params.level_gap_m) & (share < 1.0)
    behind = (gap_m >= 0.0) & (gap_m < params.back_gap_m) & (share < params.max_part_share)
    offsets_m = np.abs(moments[:, 1:4] / np.maximum(moments[:, :1], 1e-9) - middle_m)
    in_line = (offsets_m[:, 2] < params.in_line_m) & (
        offsets_m[:, :2].min(axis=1) < params.in_line_m
    )
    belongs: BoolArray = touches & (
        before | behind | (in_line & (moments[:, 0] < params.max_area_m2))
    )
    belongs[body] = True
    belongs[0] = False
    return belongs


def box_of(pixels: BoolArray, margin_px: int) -> tuple[slice, slice]:
    """Return the rows and columns around what is True."""
    rows, columns = (np.flatnonzero(pixels.any(axis=axis)) for axis in (1, 0))
    return (
        slice(max(rows[0] - margin_px, 0), rows[-1] + margin_px + 1),
        slice(max(columns[0] - margin_px, 0), columns[-1] + margin_px + 1),
    )


def close_bays(pixels: BoolArray, measured: BoolArray, params: BodyParams) -> BoolArray:
    """Close bays of the outline where nothing was measured: dark cloth seen at a slant."""
    size = 2 * params.bay_px + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    closed = cv2.morphologyEx(pixels.astype(np.uint8), cv2.MORPH_CLOSE, disc)
    return pixels | (closed.astype(bool) & ~measured)


def fill_holes(pixels: BoolArray, measured: BoolArray, params: BodyParams) -> BoolArray:
    """Fill the stretches without depth that the body surrounds."""
    holes = ~measured & ~pixels
    index = np.flatnonzero(holes)  # few pixels
    n_holes, hole_labels = cv2.connectedComponents(holes.view(np.uint8), connectivity=4)
    of_pixel = hole_labels.ravel()[index]
    rim = _beside(pixels).ravel()[index]
    inner = np.bincount(of_pixel[rim], minlength=n_holes)
    touching = _beside(~pixels & measured).ravel()[index]
    outer = np.bincount(of_pixel[touching], minlength=n_holes)
    areas_px = np.bincount(of_pixel, minlength=n_holes)
    most_px = params.max_hole_share * np.count_nonzero(pixels)
    fill = (outer <= 0.1 * inner) & (areas_px < most_px)
    filled = pixels.copy()
    filled.ravel()[index] = fill[of_pixel]
    return filled


def _beside(pixels: BoolArray) -> BoolArray:
    """Return the pixels of an image and those that touch them."""
    return cv2.dilate(pixels.view(np.uint8), np.ones((3, 3), np.uint8)).view(np.bool_)
