"""Several standing views of one patient joined into one surface."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from types import MappingProxyType

import cv2
import numpy as np

from adibas.alignment.sights import color_pixels
from adibas.alignment.views import ViewParams, prepare_view
from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.errors import BodyError
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.body_views import BodyView
from adibas.surface.merging import BodySurface, MergeParams, SeenPoints, merge_points
from adibas.surface.patient_axes import guessed_axes
from adibas.surface.view_joining import JoinedViews, JoinParams, OrientedPoints, join_views

SQUARE_COSINE = 0.34
"""Points seen at a greater slant, 70 degrees, are no help in joining."""


@dataclass(frozen=True, slots=True)
class WholeBodyParams:
    """Settings of all steps.

    Attributes
    ----------
    places, planes : ViewParams
        Windows of 3 x 3 pixels for where the surface is, of 7 x 7 for its normal: a plane over
        more of a round body lies inside it, by 0.8 mm at 7 x 7.
    joining : JoinParams
    merging : MergeParams
    """

    places: ViewParams = field(default_factory=lambda: ViewParams(n_levels=1, half_px=1))
    planes: ViewParams = field(default_factory=lambda: ViewParams(n_levels=1))
    joining: JoinParams = field(default_factory=JoinParams)
    merging: MergeParams = field(default_factory=MergeParams)


@dataclass(frozen=True, slots=True, eq=False)
class WholeBody:
    """One surface from several views, in the patient axes of the first.

    Attributes
    ----------
    patient_from_camera : mapping
        Of each view, by its name.
    surface : BodySurface
    joined : JoinedViews or None
        None of a single view.
    """

    patient_from_camera: Mapping[str, RigidTransform]
    surface: BodySurface
    joined: JoinedViews | None


def join_body(views: Sequence[BodyView], params: WholeBodyParams | None = None) -> WholeBody:
    """Join standing views; the first, best the posterior one, gives the axes.

    Raises
    ------
    BodyError
        The same side is given twice, or the views do not fit together.
    """
    params = params or WholeBodyParams()
    names = [view.view for view in views]
    if len(set(names)) < len(names):
        raise BodyError("The same side is given twice. Give each view once.")
    guesses = guessed_axes({view.view: (view.points_m(), view.floor) for view in views})
    seen = [seen_points(view, guesses[view.view], params) for view in views]
    if len(views) == 1:
        return WholeBody(MappingProxyType(guesses), merge_points(seen, params.merging), joined=None)
    oriented = [
        OrientedPoints(one.points_m[fine], one.normals[fine])
        for one in seen
        for fine in (one.cosines >= SQUARE_COSINE,)
    ]
    joined = join_views(oriented, params.joining)
    if joined is None:
        raise BodyError(
            "The views do not fit together: {pair} share too little. Give views that are a "
            "quarter turn apart, of one patient who keeps the posture.",
            pair=" + ".join(_strangers(names)),
        )
    placed = [moved(one, motion) for one, motion in zip(seen, joined.motions, strict=True)]
    poses = {
        name: motion @ guesses[name] for name, motion in zip(names, joined.motions, strict=True)
    }
    return WholeBody(MappingProxyType(poses), merge_points(placed, params.merging), joined)


def seen_points(
    view: BodyView, axes: RigidTransform, params: WholeBodyParams | None = None
) -> SeenPoints:
    """Return the person's surface as small planes, in patient axes."""
    params = params or WholeBodyParams()
    inner = off_edges(view.body, view.surface.mean_per_m, params)
    inverse = np.where(inner, view.surface.mean_per_m, np.nan)
    with np.errstate(divide="ignore"):
        depth_m = np.asarray(1.0 / inverse, np.float32)
    near, wide = (
        prepare_view(depth_m, view.camera, one).levels[0] for one in (params.places, params.planes)
    )
    half = wide.cell_px // 2
    n_rows, n_columns, _ = wide.planes.shape
    rows = np.arange(n_rows) * wide.cell_px + half
    columns = np.arange(n_columns) * wide.cell_px + half
    rays = np.ones((n_rows, n_columns, 3))
    rays[..., :2] = wide.rays[np.ix_(rows, columns)]
    normals = wide.planes.astype(float)
    per_m = (rays * near.planes).sum(axis=-1)
    with np.errstate(invalid="ignore"):
        inside = np.isfinite(normals).all(axis=-1) & (per_m > 0)
    rays, normals = rays[inside], normals[inside]
    points_m = rays / per_m[inside, None]
    outward = -normals / np.linalg.norm(normals, axis=1, keepdims=True)
    distances_m = np.linalg.norm(points_m, axis=1)
    cosines = -(outward * points_m).sum(axis=1) / distances_m
    return SeenPoints(
        axes.apply(points_m),
        np.asarray(outward @ axes.rotation.T),
        cosines,
        distances_m,
        _colors(view, points_m),
    )


def _colors(view: BodyView, points_m: FloatArray) -> FloatArray:
    """Return (N, 3) colours of points in the depth camera's axes; NaN where none was seen."""
    colors = np.full((len(points_m), 3), np.nan)
    picture_rgb = view.picture_rgb
    if picture_rgb is None:
        return colors
    columns, rows = np.nan_to_num(np.rint(color_pixels(points_m, view.calibration)), nan=-1.0).T
    height, width = picture_rgb.shape[:2]
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    at = rows[inside].astype(int), columns[inside].astype(int)
    colors[inside] = picture_rgb[at]
    return colors


def off_edges(body: BoolArray, inverse_per_m: Float32Array, params: WholeBodyParams) -> BoolArray:
    """Return the (H, W) pixels of the person that are not at an edge of the depth.

    A structured-light sensor sees edges shifted by 0.8 pixels (Nguyen et al. 2012).
    """
    measured = np.where(body, inverse_per_m, np.float32(0.0)).astype(np.float32)
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    step = cv2.dilate(measured, cross) - cv2.erode(measured, cross)
    return np.asarray(body & (step <= params.planes.gate_per_m))


def moved(points: SeenPoints, motion: RigidTransform) -> SeenPoints:
    """Return what a view saw after a motion."""
    return SeenPoints(
        motion.apply(points.points_m),
        points.normals @ motion.rotation.T,
        points.cosines,
        points.distances_m,
        points.colors,
    )


def _strangers(names: Sequence[str]) -> tuple[str, ...]:
    """Return two views that are most likely the ones that share nothing: opposite sides."""
    opposite = ({"anterior", "posterior"}, {"left_lateral", "right_lateral"})
    for pair in combinations(names, 2):
        if set(pair) in opposite:
            return pair
    return tuple(names[:2])
