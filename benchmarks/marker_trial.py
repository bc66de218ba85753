"""One analysis of the thesis' marker experiment: simulate, find, compare with the truth."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.data.markers import Marker
from adibas.errors import MarkerError
from adibas.markers.color_model import ColorModel
from adibas.markers.led import LedParams
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.pipeline.learning import LearningRequest, learn_from_picture
from adibas.pipeline.posture import MarkerFindings, MarkerTarget, PostureParams, analyse_burst
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.scenes import VIEW_MARKERS, SceneSettings, SimulatedScene
from adibas.simulation.truth import FrameTruth

N_CLICKS = 3
LEARNING_SEED = 990_017
"""A scene that is never evaluated: other room, light, clothes and sensor."""
SLIDER = (20.0, 16.0, 13.0, 10.0, 8.0, 6.0, 4.0)
"""Sensitivities that the user tries, until nothing but the stickers is shown as taken."""
SPILL = 2.0
"""Taken pixels over those of the stickers: more is skin."""
GATE_M = 0.012
"""A detection belongs to a marker if its centre lies this near to it on the skin."""
FAR = 1e3
NEARLY_STRAIGHT_RAD = math.radians(5.0)


class Compared(NamedTuple):
    """Values that were measured: true value, absolute error, 1 where the interval held it."""

    truth: FloatArray
    error: FloatArray
    is_covered: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Of one analysis, or of many together: see `pooled`.

    Attributes
    ----------
    n_visible, n_found : int
        Visible markers, and how many of them were found.
    n_detected, n_false : int
        All detections, and those where no marker is.
    n_without_position : int
        Found markers to which the depth gave no position.
    position_errors_m : (N,) array
        Of markers with a position.
    distances, angles : Compared
        Metres and radians.
    """

    n_visible: int
    n_found: int
    n_detected: int
    n_false: int
    n_without_position: int
    position_errors_m: FloatArray
    distances: Compared
    angles: Compared


@dataclass(frozen=True, slots=True)
class Trial:
    """What one analysis is done with.

    Attributes
    ----------
    settings : SceneSettings
    n_frames : tuple of int
        Lengths of the bursts to analyse; all begin with the first frame.
    left_bias_m : float
        Depth error that the calibration does not know.
    """

    settings: SceneSettings
    n_frames: tuple[int, ...] = (1, 30)
    left_bias_m: float = 0.0


def run_trial(trial: Trial) -> tuple[Outcome, ...]:
    """Return one outcome for each length of burst."""
    scene = SimulatedScene(trial.settings)
    frames: list[RgbdFrame] = []
    truths: list[FrameTruth] = []
    for index in range(max(trial.n_frames)):
        simulated = scene.frame(index)
        frames.append(to_rgbd(simulated.sensor_frame, scene.info))
        truths.append(simulated.truth)
    calibration = _calibration(scene, trial.left_bias_m)
    target = learned_target(trial.settings)
    return tuple(compare(find(frames[:n], calibration, target), truths[:n]) for n in trial.n_frames)


def learned_target(settings: SceneSettings) -> MarkerTarget:
    """Return the colours learned by some clicks on one picture of another scene."""
    if settings.markers.kind == "led":
        return LedParams()
    markers = replace(settings.markers, names=VIEW_MARKERS["anterior"])
    learning = SceneSettings(seed=LEARNING_SEED, color_size=settings.color_size, markers=markers)
    return _learned(learning)


def _learned(learning: SceneSettings) -> ColorModel:
    scene = SimulatedScene(learning)
    simulated = scene.frame(0)
    picture_rgb = to_rgbd(simulated.sensor_frame, scene.info).color_rgb
    visible = [marker for marker in simulated.truth.markers if marker.is_visible]
    frontal = sorted(visible, key=lambda marker: marker.view_angle_rad)[:N_CLICKS]
    request = LearningRequest(
        image=Path("learning"),
        seeds=tuple((float(round(marker.u)), float(round(marker.v))) for marker in frontal),
    )
    focal_px = scene.device.color.intrinsics.fx
    radius_px = focal_px * frontal[0].radius_m / frontal[0].position_m[2]
    for sensitivity in SLIDER:
        model, taken = learn_from_picture(picture_rgb, replace(request, sensitivity=sensitivity))
        if taken.sum() <= SPILL * N_CLICKS * math.pi * radius_px**2:
            break
    return model


def find(
    frames: Sequence[RgbdFrame], calibration: RgbdCalibration, target: MarkerTarget
) -> tuple[Marker, ...]:
    """Return the markers; none where the program says that it cannot."""
    found = findings_of(frames, calibration, target)
    return () if found is None else found.markers


def findings_of(
    frames: Sequence[RgbdFrame], calibration: RgbdCalibration, target: MarkerTarget
) -> MarkerFindings | None:
    """Return what a burst shows; None where the program says that it cannot."""
    try:
        return analyse_burst(frames, calibration, target, PostureParams())
    except MarkerError:
        return None


def compare(markers: tuple[Marker, ...], truths: Sequence[FrameTruth]) -> Outcome:
    """Hold what was found against the mean truth of the burst's frames."""
    on_skin = [
        index
        for index, marker in enumerate(truths[0].markers)
        if marker.view_angle_rad < math.pi / 2
    ]
    names = [truths[0].markers[index].name for index in on_skin]
    pixels, positions_m = _mean_truth(truths, on_skin)
    is_visible = np.array(
        [all(truth.markers[index].is_visible for truth in truths) for index in on_skin], bool
    )
    match = _matches(markers, pixels, positions_m, truths[0].calibration)
    named = [
        replace(marker, label=names[match[i]])
        for i, marker in enumerate(markers)
        if i in match and marker.position_m is not None
    ]
    places_m = dict(zip(names, positions_m, strict=True))
    found = set(match.values())
    return Outcome(
        n_visible=int(is_visible.sum()),
        n_found=sum(bool(is_visible[j]) for j in found),
        n_detected=len(markers),
        n_false=len(markers) - len(match),
        n_without_position=len(match) - len(named),
        position_errors_m=np.array(
            [
                np.linalg.norm(marker.position_m - places_m[marker.label])
                for marker in named
                if marker.position_m is not None
            ],
            float,
        ),
        distances=_distances(named, places_m),
        angles=_angles(named, places_m),
    )


def pooled(outcomes: Sequence[Outcome]) -> Outcome:
    """Put many analyses together."""
    return Outcome(
        n_visible=sum(outcome.n_visible for outcome in outcomes),
        n_found=sum(outcome.n_found for outcome in outcomes),
        n_detected=sum(outcome.n_detected for outcome in outcomes),
        n_false=sum(outcome.n_false for outcome in outcomes),
        n_without_position=sum(outcome.n_without_position for outcome in outcomes),
        position_errors_m=np.concatenate([outcome.position_errors_m for outcome in outcomes]),
        distances=_joined([outcome.distances for outcome in outcomes]),
        angles=_joined([outcome.angles for outcome in outcomes]),
    )


def nearly_straight(angles: Compared) -> Compared:
    """Return the angles whose truth is within 5 degrees of 0 or 180."""
    chosen = np.minimum(angles.truth, math.pi - angles.truth) < NEARLY_STRAIGHT_RAD
    return Compared(*(values[chosen] for values in angles))


def _joined(parts: Sequence[Compared]) -> Compared:
    return Compared(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _calibration(scene: SimulatedScene, left_bias_m: float) -> RgbdCalibration:
    calibration = scene.info.calibration
    if calibration is None:
        raise ValueError("a simulated scene has a calibration")
    bias = calibration.depth_bias
    return replace(calibration, depth_bias=replace(bias, a=bias.a + left_bias_m))


def _mean_truth(
    truths: Sequence[FrameTruth], chosen: Sequence[int]
) -> tuple[FloatArray, FloatArray]:
    """Return (N, 2) pixels and (N, 3) positions: means over the frames."""
    markers = [[truth.markers[index] for index in chosen] for truth in truths]
    pixels = np.array([[(marker.u, marker.v) for marker in row] for row in markers])
    positions_m = np.array([[marker.position_m for marker in row] for row in markers])
    return pixels.mean(axis=0), positions_m.mean(axis=0)


def _matches(
    markers: Sequence[Marker],
    pixels: FloatArray,
    positions_m: FloatArray,
    calibration: RgbdCalibration,
) -> dict[int, int]:
    """Return the true marker of each found one, by nearness in the picture."""
    if not markers or not len(pixels) or calibration.color is None:
        return {}
    found = np.array([[marker.u, marker.v] for marker in markers])
    distances_px = np.linalg.norm(found[:, None] - pixels, axis=2)
    gates_px = GATE_M * calibration.color.intrinsics.fx / positions_m[:, 2]
    costs = np.where(distances_px < gates_px, distances_px, FAR)
    rows, columns = linear_sum_assignment(costs)
    return {int(i): int(j) for i, j in zip(rows, columns, strict=True) if costs[i, j] < FAR}


def _distances(markers: Sequence[Marker], places_m: dict[str, FloatArray]) -> Compared:
    rows = []
    for measure in all_distances(markers):
        truth_m = float(np.linalg.norm(places_m[measure.a] - places_m[measure.b]))
        low_m, high_m = measure.interval_m
        rows.append((truth_m, abs(measure.value_m - truth_m), low_m <= truth_m <= high_m))
    return Compared(*np.array(rows, float).reshape(-1, 3).T)


def _angles(markers: Sequence[Marker], places_m: dict[str, FloatArray]) -> Compared:
    true_angles = {
        (a, vertex, c): _angle_rad(places_m[a], places_m[vertex], places_m[c])
        for a, vertex, c in permutations([marker.label for marker in markers], 3)
    }
    rows = []
    for measure in all_angles(markers):
        truth_rad = true_angles[measure.a, measure.vertex, measure.c]
        low_rad, high_rad = measure.interval_rad
        error_rad = abs(measure.value_rad - truth_rad)
        rows.append((truth_rad, error_rad, low_rad <= truth_rad <= high_rad))
    return Compared(*np.array(rows, float).reshape(-1, 3).T)


def _angle_rad(a: FloatArray, vertex: FloatArray, c: FloatArray) -> float:
    first, second = a - vertex, c - vertex
    return math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second))
