"""From a view from behind to the line of the spine and the measures of the back."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.body_measures import BodyMeasure
from adibas.data.landmark_texts import SPINE
from adibas.data.markers import Marker
from adibas.data.sentence import Sentence
from adibas.errors import BodyError
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.body_views import BodyView
from adibas.surface.back_grid import BackGrid, GridParams, grid_of
from adibas.surface.back_measures import (
    C7,
    LEFT_PSIS,
    RIGHT_PSIS,
    PlacedMarker,
    back_measures,
)
from adibas.surface.patient_axes import axes_of_back, turned
from adibas.surface.sagittal import SagittalParams, SagittalShape, sagittal_shape
from adibas.surface.spine_profile import ProfileParams, SpineProfile, fit_profile
from adibas.surface.symmetry_line import SymmetryLine, SymmetryParams, find_symmetry_line
from adibas.surface.trunk import TrunkParams, back_points, chest_width_m, hidden_share, shows_toes
from adibas.texts import message

SPINOUS = SPINE[: SPINE.index("s1") + 1]
"""Names of markers on spinous processes: the line of the spine goes through them to the sacrum."""
NO_CURVES = message(
    "The curves of the spine were not found: the profile has no turn between chest and loin, or "
    "clothes hide it. Kyphosis, lordosis and what follows from them have no value."
)
NO_MARKERS = message(
    "Without markers named c7, left_psis and right_psis, measures of trunk and pelvis between "
    "these have no value."
)
N_TURNS, LEVEL_RAD = 4, 0.004
"""Rounds in which the axes are turned until the surface's mean rotation is less than that."""


@dataclass(frozen=True, slots=True)
class BackParams:
    """Settings of all steps."""

    trunk: TrunkParams = field(default_factory=TrunkParams)
    grid: GridParams = field(default_factory=GridParams)
    symmetry: SymmetryParams = field(default_factory=SymmetryParams)
    profile: ProfileParams = field(default_factory=ProfileParams)
    sagittal: SagittalParams = field(default_factory=SagittalParams)


@dataclass(frozen=True, slots=True, eq=False)
class Back:
    """What a view from behind gives; lengths in patient axes (`adibas.surface.patient_axes`).

    Attributes
    ----------
    patient_from_camera : RigidTransform
        From the depth camera's axes.
    stature_m : float
        From the floor to the highest place that is seen of the head, 10 to 19 mm below the crown:
        shares of heights on the back were found with it.
    grid : BackGrid
    profile : SpineProfile
    shape : SagittalShape or None
    markers : mapping
        By name.
    measures : tuple of BodyMeasure
    notices : tuple of Sentence
    """

    patient_from_camera: RigidTransform
    stature_m: float
    grid: BackGrid
    profile: SpineProfile
    shape: SagittalShape | None
    markers: Mapping[str, PlacedMarker]
    measures: tuple[BodyMeasure, ...]
    notices: tuple[Sentence, ...]

    @property
    def line(self) -> SymmetryLine:
        """The line of the spinous processes."""
        return self.profile.line


def measure_back(
    view: BodyView, markers: tuple[Marker, ...] = (), params: BackParams | None = None
) -> Back:
    """Measure the back.

    Parameters
    ----------
    markers : tuple of Marker
        In the colour camera's axes; those named ``c7``, ``left_psis``, ``right_psis`` and after
        vertebrae are of use, and need a position.

    Raises
    ------
    BodyError
        The head is cut off, the back is not turned to the sensor, or something lies before it.
    """
    params = params or BackParams()
    if view.is_cut_above:
        raise BodyError(
            "The head is cut off by the picture, and heights on the back are told from the whole "
            "stature. Step back, or raise the sensor."
        )
    camera_m = view.points_m()
    axes = axes_of_back(camera_m, view.floor)
    stature_m = float(axes.apply(camera_m)[:, 1].max())
    _check_side(axes.apply(camera_m), stature_m, params.trunk)
    is_back = back_points(axes.apply(camera_m), stature_m, params.trunk)
    if not is_back.any():
        raise BodyError(
            "The back is not in the picture. Show the patient from the head down to the seat."
        )
    camera_m = camera_m[is_back]
    axes = _with_pelvis(axes, markers, view)
    mean_rad = 0.0
    for _ in range(N_TURNS):
        axes = turned(axes, mean_rad)
        points_m, placed = axes.apply(camera_m), _placed(markers, view, axes)
        grid, profile = _spine(points_m, placed, params)
        mean_rad = _mean_rotation_rad(profile, stature_m)
        if has_pelvis(placed) or abs(mean_rad) < LEVEL_RAD:
            break
    if hidden_share(grid, profile, stature_m, params.trunk) > params.trunk.most_hidden:
        raise BodyError(
            "Something lies before the back: an arm, hair or loose clothes. Let the arms hang, "
            "tie the hair up, bare the back, and record again."
        )
    shape = sagittal_shape(profile, stature_m, params.sagittal)
    notices = [] if shape is not None else [Sentence(NO_CURVES)]
    if not {C7, LEFT_PSIS, RIGHT_PSIS} <= set(placed):
        notices.append(Sentence(NO_MARKERS))
    vertical_sd_rad = view.calibration.gravity_sd_rad or 0.0
    measures = back_measures(profile, shape, placed, vertical_sd_rad)
    return Back(axes, stature_m, grid, profile, shape, placed, measures, tuple(notices))


def has_pelvis(markers: Mapping[str, PlacedMarker]) -> bool:
    """Say whether the pelvis is marked."""
    return {LEFT_PSIS, RIGHT_PSIS} <= set(markers)


def _spine(
    points_m: FloatArray, markers: Mapping[str, PlacedMarker], params: BackParams
) -> tuple[BackGrid, SpineProfile]:
    """Return the grid and the profile along the symmetry line."""
    spinous = [markers[name].position_m for name in SPINOUS if name in markers]
    grid = grid_of(points_m, params.grid)
    line = find_symmetry_line(grid, np.array(spinous) if spinous else None, params.symmetry)
    if line is None:
        raise BodyError(
            "The back is not in the picture. Show the patient from the head down to the seat."
        )
    return grid, fit_profile(points_m, line, params.profile)


def _mean_rotation_rad(profile: SpineProfile, stature_m: float) -> float:
    """Return the rotation of the middle of the trunk, where neither neck nor seat count."""
    heights_m = np.linspace(0.58, 0.80, 60) * stature_m
    inside = (heights_m > profile.bottom_m) & (heights_m < profile.top_m)
    return float(profile.rotation_rad(heights_m[inside]).mean()) if inside.any() else 0.0


def _check_side(points_m: FloatArray, stature_m: float, params: TrunkParams) -> None:
    if shows_toes(points_m, stature_m, params):
        raise BodyError(
            "The toes point to the sensor: this is the front, not the back. Name the view "
            "anterior, or turn the patient round and record again."
        )
    width_m = chest_width_m(points_m, stature_m, params)
    if width_m < params.least_width * stature_m:
        raise BodyError(
            "The back is not turned to the sensor: the body is only {width} cm wide at the chest. "
            "Turn the patient's back squarely to it, and record again.",
            width=round(100 * width_m),
        )


def _with_pelvis(
    axes: RigidTransform, markers: tuple[Marker, ...], view: BodyView
) -> RigidTransform:
    """Return axes whose frontal plane is that of the marked pelvis."""
    placed = _placed(markers, view, axes)
    if not has_pelvis(placed):
        return axes
    way = placed[RIGHT_PSIS].position_m - placed[LEFT_PSIS].position_m
    return turned(axes, float(np.arctan2(way[2], way[0])))


def _placed(
    markers: tuple[Marker, ...], view: BodyView, axes: RigidTransform
) -> dict[str, PlacedMarker]:
    """Return the markers with a position by name, in patient axes."""
    patient_from_color = axes @ view.calibration.color_from_depth.inverse()
    turn = patient_from_color.rotation
    return {
        marker.label: PlacedMarker(
            patient_from_color.apply(marker.position_m), turn @ marker.covariance_m2 @ turn.T
        )
        for marker in markers
        if marker.position_m is not None and marker.covariance_m2 is not None
    }
