"""All the people in a depth image, one mask each, without a background learned before.

As in `adibas.body.mask`, the image falls apart at the steps of the depth; here every surface that
can be a person starts a body of its own, and no body takes a surface that is another's. Tables
are taken away before, as the floor is: a child who sits at one touches it.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray, check_shape
from adibas.body.component_kernels import label_surfaces, surface_moments
from adibas.body.floor import level_grid
from adibas.body.mask import (
    bodies_parts,
    box_of,
    close_bays,
    fill_holes,
    heights_over,
    standing_free,
)
from adibas.body.person import BodyParams, Surfaces, find_persons
from adibas.body.rays import viewing_rays
from adibas.body.staying import Moment, put_together
from adibas.data.calibration import CameraCalibration
from adibas.data.masks import BodyMask
from adibas.geometry.planes import Plane

TOP_PERCENTILE = 99.5
LEAST_SPAN_M2 = 1e-3
N_WITNESSES, N_PLANES = 300, 100
"""Points of a surface that are looked at, and planes that are tried, when it may be a box."""


@dataclass(frozen=True, slots=True)
class PeopleParams:
    """Settings of the search for several people.

    Attributes
    ----------
    body : BodyParams
        Of each of them.
    most_people : int
        The nearest so many are kept: 6.
    seated_top_m : float
        Somebody who is not tall enough to be a person by the rules for one, but has head and
        shoulders, reaches at least so high over the floor: 0.75 (a child of 6 years on a low
        chair).
    head_width_m, shoulders_width_m : (float, float)
        Of the outline 2 to 12 cm and 28 to 42 cm below its top: 0.08 to 0.25, and 0.18 to 0.75.
    head_share : float
        The head is at most so wide as this share of the shoulders: 0.8.
    known_m : float
        Whoever was so near a moment ago is there still: 0.2.
    flat_share : float
        Furniture has more than this share of its surface on one plane: 0.7. Of
        somebody who walks by, seen from the side, up to 0.67.
    flat_band_m : float
        Half thickness of that plane: 0.01, and the floor's noise.
    table_heights_m : (float, float)
        Where tops of tables are looked for: 0.3 to 1.2.
    table_area_m2 : float
        A level surface from this size on is furniture: 0.15, more than the thighs of an adult
        who sits.
    table_band_m : float
        Half thickness of what is taken away with a table: 0.025, and the floor's noise.
    grid_px : int
        Only every n-th row and column is looked at for tables: 4.
    """

    body: BodyParams = field(default_factory=BodyParams)
    most_people: int = 6
    seated_top_m: float = 0.75
    head_width_m: tuple[float, float] = (0.08, 0.25)
    shoulders_width_m: tuple[float, float] = (0.18, 0.75)
    head_share: float = 0.8
    known_m: float = 0.2
    flat_share: float = 0.7
    flat_band_m: float = 0.01
    table_heights_m: tuple[float, float] = (0.3, 1.2)
    table_area_m2: float = 0.15
    table_band_m: float = 0.025
    grid_px: int = 4


def find_people(
    depth_m: Float32Array,
    depth_camera: CameraCalibration,
    floor: Plane | None = None,
    params: PeopleParams | None = None,
    known_m: FloatArray | None = None,
    before: Moment | None = None,
) -> tuple[BodyMask, ...]:
    """Return a mask of each person, the nearest first.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Along the depth camera's z, metres; NaN where not measured.
    depth_camera : CameraCalibration
        Of the camera that took `depth_m`.
    floor : Plane or None
        In the depth camera's axes, normal up; without it tables stay, and nobody is found who
        sits behind something.
    known_m : (N, 3) array or None
        Middles of the people of a moment ago: whoever is there still needs no head above the
        rest, and may hold a hand over it.
    before : Moment or None
        The image of a tenth of a second ago or less: who was in it stays whole.
    """
    params = params or PeopleParams()
    check_shape("depth_m", depth_m, (depth_camera.height, depth_camera.width))
    rays = viewing_rays(depth_camera)
    heights_m = None if floor is None else heights_over(depth_m, depth_camera, floor)
    inverse_depth = standing_free(depth_m, heights_m, params.body)
    if floor is not None and heights_m is not None:
        inverse_depth[tables(depth_m, heights_m, depth_camera, floor, params)] = 0.0
    labels, n_labels = label_surfaces(inverse_depth, params.body.step_per_m, params.body.step_m)
    moments = surface_moments(labels, n_labels, inverse_depth, rays)
    pixel_rad = float(rays[0, 1, 0] - rays[0, 0, 0])
    surfaces = Surfaces(labels, moments, inverse_depth, heights_m, pixel_rad)

    def is_known(label: int) -> bool:
        return _is_known(moments[label, 1:4] / moments[label, 0], known_m, params)

    def is_seated(label: int) -> bool:
        return is_known(label) or has_head(surfaces, label, params)

    bodies = [
        label
        for label in find_persons(surfaces, params.body, is_seated)
        if is_known(label) or not is_boxy(surfaces, label, rays, params)
    ]
    bodies = sorted(bodies, key=lambda label: moments[label, 3] / moments[label, 0])
    masks = _masks(surfaces, bodies[: params.most_people], depth_m, params.body)
    if before is None or not before.people:
        return masks
    return put_together(masks, labels, depth_m, before)[: params.most_people]


def _masks(
    surfaces: Surfaces, bodies: list[int], depth_m: Float32Array, params: BodyParams
) -> tuple[BodyMask, ...]:
    owners = _owners(surfaces, bodies, params)
    measured = np.isfinite(depth_m)
    taken = np.zeros(depth_m.shape, np.bool_)
    masks = []
    for number in range(len(bodies)):
        pixels = np.take(owners == number, surfaces.labels)
        box = box_of(pixels, params.bay_px + 1)
        here = measured[box]
        pixels[box] = fill_holes(close_bays(pixels[box], here, params), here, params)
        pixels &= ~taken
        taken |= pixels
        masks.append(BodyMask(pixels))
    return tuple(masks)


def _owners(surfaces: Surfaces, bodies: list[int], params: BodyParams) -> IntArray:
    """Return for each surface the number of the body it belongs to; -1: to none."""
    owners = np.full(len(surfaces.moments), -1, np.int64)
    nearest_m = np.full(len(surfaces.moments), np.inf)
    for number, body in enumerate(bodies):
        belongs = bodies_parts(surfaces, body, params)
        gaps_m = np.abs(surfaces.borders(body, params.joint_reach_px)[:, 1])
        better = belongs & (gaps_m < nearest_m)
        owners[better] = number
        nearest_m[better] = gaps_m[better]
    for number, body in enumerate(bodies):
        owners[body] = number
    return owners


def _is_known(middle_m: FloatArray, known_m: FloatArray | None, params: PeopleParams) -> bool:
    """Say whether somebody was there a moment ago."""
    if known_m is None or not len(known_m):
        return False
    return bool(np.linalg.norm(known_m - middle_m, axis=1).min() < params.known_m)


def is_boxy(surfaces: Surfaces, label: int, rays: Float32Array, params: PeopleParams) -> bool:
    """Say whether most of a surface lies on one plane, as that of a cupboard or a screen does.

    The plane is the one of many through three points of the surface that holds most of it.
    """
    index = surfaces.pixels_of(label)
    chosen = index[np.linspace(0, len(index) - 1, N_WITNESSES).astype(np.int64)]
    rows, columns = np.divmod(chosen, surfaces.labels.shape[1])
    points_m = rays[rows, columns] / surfaces.inverse_depth[rows, columns][:, None]
    corners = np.random.default_rng(0).integers(0, N_WITNESSES, (N_PLANES, 3))
    a, b, c = (points_m[corners[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    # Three points on a line span no plane: NaN lies near nothing.
    normals /= np.where(lengths > LEAST_SPAN_M2, lengths, np.nan)
    off_m = np.abs(points_m @ normals.T - (a * normals).sum(axis=1))
    band_m = params.flat_band_m + params.body.floor_band_per_m * points_m[:, 2] ** 2
    share = (off_m < band_m[:, None]).mean(axis=0)
    return bool(share.max() > params.flat_share)


def has_head(surfaces: Surfaces, label: int, params: PeopleParams) -> bool:
    """Say whether a surface that reaches high enough ends above in a head over shoulders."""
    if surfaces.heights_m is None:
        return False
    index = surfaces.pixels_of(label)
    heights_m = surfaces.heights_m.ravel()[index]
    top_m = float(np.percentile(heights_m, TOP_PERCENTILE))
    if top_m < params.seated_top_m:
        return False
    columns = index % surfaces.labels.shape[1]
    across_m = surfaces.pixel_rad * columns / surfaces.inverse_depth.ravel()[index]
    below_m = top_m - heights_m
    head = across_m[(below_m > 0.02) & (below_m < 0.12)]  # noqa: PLR2004  (see PeopleParams)
    shoulders = across_m[(below_m > 0.28) & (below_m < 0.42)]  # noqa: PLR2004
    if not (len(head) and len(shoulders)):
        return False
    (left, right), (low, high) = (np.percentile(one, (5, 95)) for one in (head, shoulders))
    head_m, shoulders_m = right - left, high - low
    return bool(
        params.head_width_m[0] < head_m < params.head_width_m[1]
        and params.shoulders_width_m[0] < shoulders_m < params.shoulders_width_m[1]
        and head_m < params.head_share * shoulders_m
        and low < 0.5 * (left + right) < high
    )


def tables(
    depth_m: Float32Array,
    heights_m: Float32Array,
    camera: CameraCalibration,
    floor: Plane,
    params: PeopleParams,
) -> BoolArray:
    """Return the (H, W) pixels of level surfaces too large for a part of a person.

    `heights_m` (H, W) are those over the floor.
    """
    points_m, normals = level_grid(depth_m, camera, params.grid_px)
    along_m = points_m @ floor.normal
    grid_m = along_m + floor.offset_m
    with np.errstate(invalid="ignore"):
        level = normals @ floor.normal > np.cos(np.radians(25.0))
        level &= (grid_m > params.table_heights_m[0]) & (grid_m < params.table_heights_m[1])
    found = np.zeros(depth_m.shape, np.bool_)
    if not level.any():
        return found
    areas_m2 = np.zeros(level.shape)
    areas_m2[level] = _level_areas_m2(points_m[level], along_m[level], camera, params.grid_px)
    for height_m in _table_heights_m(grid_m[level], areas_m2[level], params):
        near = level & (np.abs(grid_m - height_m) < 2.0 * params.table_band_m)
        # A table is a small part of the picture: only its surroundings are looked at.
        here = np.nonzero(_grown(near, areas_m2, depth_m.shape, params))
        with np.errstate(invalid="ignore"):
            band_m = params.table_band_m + params.body.floor_band_per_m * depth_m[here] ** 2
            found[here] |= np.abs(heights_m[here] - height_m) < band_m
    return found


def _level_areas_m2(
    points_m: FloatArray, along_m: FloatArray, camera: CameraCalibration, step: int
) -> FloatArray:
    """Return the level area that each of (N, 3) points of the grid stands for.

    `along_m` (N,) is how far they are from the camera along the floor's normal.
    """
    k = camera.intrinsics
    distance_m = np.linalg.norm(points_m, axis=-1)
    slant = np.abs(along_m) / distance_m
    facing_m2 = step * step * points_m[:, 2] * distance_m / (k.fx * k.fy)
    return np.asarray(facing_m2 / np.maximum(slant, 0.05))


def _table_heights_m(
    heights_m: FloatArray, areas_m2: FloatArray, params: PeopleParams
) -> list[float]:
    """Return where the level area of a band of heights is that of a table."""
    low, high = params.table_heights_m
    n_bins = round((high - low) / params.table_band_m)
    areas, edges = np.histogram(heights_m, n_bins, (low, high), weights=areas_m2)
    pairs = np.convolve(areas, np.ones(3), mode="same")
    found = []
    while pairs.max() > params.table_area_m2:
        best = int(pairs.argmax())
        found.append(float(0.5 * (edges[best] + edges[best + 1])))
        pairs[max(0, best - 2) : best + 3] = 0.0
    return found


def _grown(
    near: BoolArray, areas_m2: FloatArray, shape: tuple[int, ...], params: PeopleParams
) -> BoolArray:
    """Return the (H, W) pixels about those pieces of a level that are large enough."""
    joined = cv2.dilate(near.astype(np.uint8), np.ones((3, 3), np.uint8))
    n_pieces, pieces = cv2.connectedComponents(joined, connectivity=8)
    piece_m2 = np.bincount(pieces[near], areas_m2[near], minlength=n_pieces)
    large = piece_m2 > 0.5 * params.table_area_m2
    large[0] = False
    mask = cv2.dilate(large[pieces].astype(np.uint8), np.ones((5, 5), np.uint8))
    size = (shape[1], shape[0])
    return np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_NEAREST) > 0)
