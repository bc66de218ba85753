"""The person in a depth image.

The floor is taken away; what is left falls apart at the steps of the depth into surfaces. The
largest one that can be a person (size, not flat) is the body; surfaces that border on it and are
hardly farther away (an arm before the trunk, the far leg) belong to it too. Holes without depth
inside it (dark hair, LEDs) are filled.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, Int32Array, UInt8Array, check_shape
from adibas.body.component_kernels import gaps_to_body, label_surfaces, surface_moments
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.data.masks import BodyMask
from adibas.geometry.planes import Plane

TOP_PERCENTILE = 98.0
BOTTOM_ROWS = 8
"""Above the lowest row with depth: dips of an outline that the image cuts off."""


@dataclass(frozen=True, slots=True)
class BodyParams:
    """Settings of the body mask.

    Attributes
    ----------
    range_m : tuple
        Depths where a person is looked for: what the sensor measures (thesis 6.1.1.1: 1.2-3.5 m;
        PrimeSense from 0.5 m).
    step_per_m : float
        Step of inverse depth (1/m) that parts two surfaces. 0.012: 48 mm at 2 m, over four steps of
        disparity of a PrimeSense.
    step_m : float
        Smallest step in depth that parts two surfaces, 0.025: at close range a slanted surface
        falls by more than the noise from one pixel to the next.
    floor_band_m, floor_band_per_m : float
        Height over the floor under which all is floor: 8 mm and 1.2 mm times depth squared (three
        standard deviations of the noise seen at the usual slant).
    min_area_m2, max_area_m2 : float
        Of the body's front: a child's trunk 0.05; a large adult with arms spread 1.6.
    min_length_m : float
        Of the part in view, 0.35.
    standing_length_m, standing_top_m : float
        A person in view down to the floor is longer or reaches higher than that, unlike a chair:
        0.95 and 1.0 (children from 6 years on).
    min_cut_m : float
        Width at the image's lower edge of someone seen from the waist up, 0.1.
    min_relief : float
        Depth of the shape as a share of its width (standard deviations along the shortest and the
        middle principal axis): a wall has 0.04 of noise, a trunk from the front 0.13. 0.07.
    joint_reach_px : int
        Width of the shadow between an arm and the trunk that still counts as touching, 24.
    front_gap_m, level_gap_m : float
        How far a bordering surface of any size may be before and behind the body to belong to it:
        raised forearms part head and chest from the rest. 0.6 (an arm's length), and 0.13 (less
        than a trunk is thick).
    back_gap_m, max_part_share : float
        How far a bordering surface may be behind if it has less than that share of the body's
        area: the far leg. 0.28 and 0.3.
    in_line_m : float
        A bordering surface belongs to the body if its middle lies that near to the body's in depth
        and to one side: the legs under raised forearms. 0.2.
    bay_px : int
        Radius of the disc that closes bays of the outline without depth, 2.
    max_hole_share : float
        Of the body's area that one hole may have, 0.03.
    """

    range_m: tuple[float, float] = (0.4, 4.5)
    step_per_m: float = 0.012
    step_m: float = 0.025
    floor_band_m: float = 0.008
    floor_band_per_m: float = 0.0012
    min_area_m2: float = 0.05
    max_area_m2: float = 1.6
    min_length_m: float = 0.35
    standing_length_m: float = 0.95
    standing_top_m: float = 1.0
    min_cut_m: float = 0.1
    min_relief: float = 0.07
    joint_reach_px: int = 24
    front_gap_m: float = 0.6
    level_gap_m: float = 0.13
    back_gap_m: float = 0.28
    max_part_share: float = 0.3
    in_line_m: float = 0.2
    bay_px: int = 2
    max_hole_share: float = 0.03


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
    heights_m = None if floor is None else _heights_m(depth_m, rays, floor)
    inverse_depth = _standing_free(depth_m, heights_m, params)
    labels, n_labels = label_surfaces(inverse_depth, params.step_per_m, params.step_m)
    moments = surface_moments(labels, n_labels, inverse_depth, rays)
    pixel_rad = float(rays[0, 1, 0] - rays[0, 0, 0])
    body = _body_label(moments, labels, pixel_rad, heights_m, params)
    if body is None:
        return None
    belongs = _parts(labels, moments, inverse_depth, body, params)
    pixels = belongs[labels]
    box = _box(pixels, params.bay_px + 1)
    measured = np.isfinite(depth_m[box])
    pixels[box] = _without_holes(_closed(pixels[box], measured, params), measured, params)
    return BodyMask(pixels)


def _heights_m(depth_m: Float32Array, rays: Float32Array, floor: Plane) -> Float32Array:
    """Return the (H, W) height over the floor, metres; NaN where there is no depth."""
    heights_m = (rays @ floor.normal.astype(np.float32)) * depth_m
    heights_m += np.float32(floor.offset_m)
    return heights_m


def _standing_free(
    depth_m: Float32Array, heights_m: Float32Array | None, params: BodyParams
) -> Float32Array:
    """Return inverse depth (1/m), 0 where there is none, out of range or on the floor."""
    with np.errstate(invalid="ignore"):
        usable = (depth_m > params.range_m[0]) & (depth_m < params.range_m[1])
        if heights_m is not None:
            band_m = np.float32(params.floor_band_per_m) * depth_m * depth_m
            usable &= heights_m > band_m + np.float32(params.floor_band_m)
    inverse = np.zeros(depth_m.shape, np.float32)
    np.divide(np.float32(1), depth_m, out=inverse, where=usable)
    return inverse


def _body_label(
    moments: FloatArray,
    labels: Int32Array,
    pixel_rad: float,
    heights_m: Float32Array | None,
    params: BodyParams,
) -> int | None:
    """Return the label of the largest surface that can be a person."""
    area_m2 = moments[:, 0]
    large = np.flatnonzero((area_m2 > params.min_area_m2) & (area_m2 < params.max_area_m2))
    last_row = np.flatnonzero((labels > 0).any(axis=1))[-1] if large.size else 0
    bottom = slice(max(last_row - BOTTOM_ROWS, 0), last_row + 1)
    for label in sorted(large.tolist(), key=lambda label: -area_m2[label]):
        shape = _Shape(moments[label])
        if not shape.is_solid(params) or shape.length_m < params.min_length_m:
            continue
        if shape.length_m > params.standing_length_m:
            return int(label)
        if heights_m is not None:
            top_m = float(np.percentile(heights_m[labels == label], TOP_PERCENTILE))
            if top_m > params.standing_top_m:
                return int(label)
            continue
        # Someone seen from the waist up is cut off by the lower edge of the image, across.
        cut_px = (labels[bottom] == label).any(axis=0).sum()
        if cut_px * pixel_rad * shape.mean_m[2] > params.min_cut_m:
            return int(label)
    return None


class _Shape:
    """Size and form of one surface, out of its moments."""

    def __init__(self, moments: FloatArray) -> None:
        self.mean_m = moments[1:4] / moments[0]
        xx, yy, zz, xy, xz, yz = moments[4:] / moments[0]
        second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        self._covariance = second - np.outer(self.mean_m, self.mean_m)
        self._variances = np.maximum(np.linalg.eigvalsh(self._covariance), 0.0)

    @property
    def length_m(self) -> float:
        """Length of the evenly filled bar that spreads as much along the longest axis."""
        return float(np.sqrt(12.0 * self._variances[2]))

    def is_solid(self, params: BodyParams) -> bool:
        """Say whether it is no plane."""
        return bool(self._variances[0] > params.min_relief**2 * self._variances[1])


def _parts(
    labels: Int32Array,
    moments: FloatArray,
    inverse_depth: Float32Array,
    body: int,
    params: BodyParams,
) -> BoolArray:
    """Say of each label whether it belongs to the person."""
    border = gaps_to_body(labels, len(moments) - 1, body, inverse_depth, params.joint_reach_px)
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


def _box(pixels: BoolArray, margin_px: int) -> tuple[slice, slice]:
    """Return the rows and columns around what is True."""
    rows, columns = (np.flatnonzero(pixels.any(axis=axis)) for axis in (1, 0))
    return (
        slice(max(rows[0] - margin_px, 0), rows[-1] + margin_px + 1),
        slice(max(columns[0] - margin_px, 0), columns[-1] + margin_px + 1),
    )


def _closed(pixels: BoolArray, measured: BoolArray, params: BodyParams) -> BoolArray:
    """Close bays of the outline where nothing was measured: dark cloth seen at a slant."""
    size = 2 * params.bay_px + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    closed = cv2.morphologyEx(pixels.astype(np.uint8), cv2.MORPH_CLOSE, disc)
    return pixels | (closed.astype(bool) & ~measured)


def _without_holes(pixels: BoolArray, measured: BoolArray, params: BodyParams) -> BoolArray:
    """Fill the stretches without depth that the body surrounds."""
    holes: UInt8Array = (~measured & ~pixels).astype(np.uint8)
    n_holes, hole_labels, stats, _ = cv2.connectedComponentsWithStats(holes, connectivity=4)
    rim = cv2.dilate(pixels.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    inner = np.bincount(hole_labels[rim], minlength=n_holes)
    outside = ~pixels & measured
    touching = cv2.dilate(outside.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    outer = np.bincount(hole_labels[touching], minlength=n_holes)
    fill = (outer <= 0.1 * inner) & (
        stats[:, cv2.CC_STAT_AREA] < params.max_hole_share * pixels.sum()
    )
    fill[0] = False
    filled: BoolArray = pixels | fill[hole_labels]
    return filled
