"""One analysis of the posture chain: calibrate, find, name, measure, hold against the truth.

Every sensor is calibrated before: 25 simulated images of the thesis' board, whose corners have the
noise of dark pictures, tell the depth camera and its error; the colour camera errs by as much as
its covariance says.
"""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.data.markers import Marker
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.pipeline.posture import MarkerFindings
from adibas.pipeline.seen_body import with_body
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import with_names
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.device import COLOR_SIZES
from adibas.simulation.patient import SHAPES, MarkerSettings
from adibas.simulation.postures import POSTURES
from adibas.simulation.scenes import SceneSettings, SimulatedScene
from adibas.simulation.truth import FrameTruth
from benchmarks.calibration_depth_trials import LARGE_BOARD, Setting, run_trial
from benchmarks.marker_trial import GATE_M, findings_of, learned_target

N_BODIES, N_REPEATS = 5, 10
VIEW = "anterior"
Z_95 = 1.959964
"""An interval is so many standard errors on each side."""
BOARDS = Setting(board=LARGE_BOARD, corner_sd_px=0.03)


@dataclass(frozen=True, slots=True)
class Analysis:
    """What one analysis is done with; `number` names it in the file of results."""

    number: int
    settings: SceneSettings
    n_frames: int


@dataclass(frozen=True, slots=True)
class Result:
    """What came of one analysis.

    Attributes
    ----------
    number : int
    n_visible, n_named, n_wrong : int
        Visible markers; those found with their right name; with a wrong one.
    distances, angles : list of [error, standard error, shortest side in metres, truth]
        Metres and radians; errors are signed.
    angles_in_image : list of the same
        Of the points as the colour camera sees them along its axis; no standard error.
    """

    number: int
    n_visible: int
    n_named: int
    n_wrong: int
    distances: list[list[float]]
    angles: list[list[float]]
    angles_in_image: list[list[float]]


def analyses(seed: int, n_frames: int) -> tuple[Analysis, ...]:
    """Return the 200 analyses: the 15 joints on 5 bodies in 4 postures, 10 times each."""
    settings = [
        SceneSettings(posture=posture, shape=shape, markers=MarkerSettings(JOINT_NAMES))
        for shape in SHAPES[:N_BODIES]
        for posture in POSTURES
        for _ in range(N_REPEATS)
    ]
    return tuple(
        Analysis(number, replace(one, seed=1000 * (seed + 7) + number), n_frames)
        for number, one in enumerate(settings)
    )


def analyse(analysis: Analysis) -> Result:
    """Do one analysis."""
    scene = SimulatedScene(analysis.settings)
    calibration = _calibrated(scene)
    simulated = [scene.frame(index) for index in range(analysis.n_frames)]
    frames = [to_rgbd(one.sensor_frame, scene.info) for one in simulated]
    found = findings_of(frames, calibration, learned_target(analysis.settings))
    named = () if found is None else _named(found, calibration)
    return _compared(analysis.number, named, [one.truth for one in simulated])


def _named(found: MarkerFindings, calibration: RgbdCalibration) -> tuple[Marker, ...]:
    """Name markers as a capture does."""
    namer = with_body(shipped_namer(), found.surface.depth_m, VIEW, calibration)
    return with_names(namer, found.markers, VIEW, calibration)


def _calibrated(scene: SimulatedScene) -> RgbdCalibration:
    """Return what boards tell of the scene's sensor; floor and vertical are the scene's."""
    truth = scene.info.calibration
    if truth is None:
        raise ValueError("a simulated scene has a calibration")
    if scene.settings.color_size != COLOR_SIZES[0]:
        raise ValueError("boards are seen by the whole colour camera")
    found = run_trial(scene.device, BOARDS).calibration
    return replace(found, gravity=truth.gravity, floor=truth.floor)


def run_all(
    wanted: Sequence[Analysis],
    results: Path | None,
    run: Callable[[Sequence[Analysis]], Iterator[Result]],
) -> list[Result]:
    """Do what the file of results does not have yet, and add each result to it at once."""
    done = _read(results) if results is not None else {}
    missing = [one for one in wanted if one.number not in done]
    for result in run(missing):
        done[result.number] = result
        if results is not None:
            with results.open("a", encoding="utf-8") as file:
                row = {name: getattr(result, name) for name in Result.__slots__}
                file.write(json.dumps(row) + "\n")
    return [done[one.number] for one in wanted]


def _read(path: Path) -> dict[int, Result]:
    if not path.exists():
        return {}
    rows = [json.loads(line) for line in path.read_text("utf-8").splitlines() if line]
    return {row["number"]: Result(**row) for row in rows}


def _compared(number: int, markers: tuple[Marker, ...], truths: Sequence[FrameTruth]) -> Result:
    places_m = {
        one.name: np.mean([t.markers[i].position_m for t in truths], axis=0)
        for i, one in enumerate(truths[0].markers)
    }
    visible = {
        one.name
        for i, one in enumerate(truths[0].markers)
        if all(t.markers[i].is_visible for t in truths)
    }
    right: list[Marker] = []
    n_wrong = 0
    for marker in markers:
        if marker.label not in places_m:
            continue
        is_there = _is_at(marker, truths, marker.label)
        right += [marker] if is_there else []
        n_wrong += not is_there
    placed = [marker for marker in right if marker.position_m is not None]
    return Result(
        number,
        len(visible),
        len(visible & {marker.label for marker in right}),
        n_wrong,
        _distances(placed, places_m),
        _angles(placed, places_m),
        _angles_in_image(placed, places_m),
    )


def _is_at(marker: Marker, truths: Sequence[FrameTruth], name: str) -> bool:
    """Say whether a marker lies in the picture where the true one of that name is."""
    of_name = [one for truth in truths for one in truth.markers if one.name == name]
    u, v = (float(np.mean([getattr(one, axis) for one in of_name])) for axis in "uv")
    depth_m = float(np.mean([one.position_m[2] for one in of_name]))
    calibration = truths[0].calibration
    if calibration.color is None:
        raise ValueError("a simulated scene has a colour camera")
    gate_px = GATE_M * calibration.color.intrinsics.fx / depth_m
    return math.hypot(marker.u - u, marker.v - v) < gate_px


def _distances(markers: list[Marker], places_m: dict[str, FloatArray]) -> list[list[float]]:
    rows = []
    for measure in all_distances(markers):
        truth_m = float(np.linalg.norm(places_m[measure.a] - places_m[measure.b]))
        low_m, high_m = measure.interval_m
        error_m = measure.value_m - truth_m
        rows.append([error_m, (high_m - low_m) / (2 * Z_95), truth_m, truth_m])
    return rows


def _angles(markers: list[Marker], places_m: dict[str, FloatArray]) -> list[list[float]]:
    rows = []
    for measure in all_angles(markers):
        points_m = (places_m[name] for name in (measure.a, measure.vertex, measure.c))
        truth_rad, shortest_m = _angle(*points_m)
        low_rad, high_rad = measure.interval_rad
        error_rad = measure.value_rad - truth_rad
        rows.append([error_rad, (high_rad - low_rad) / (2 * Z_95), shortest_m, truth_rad])
    return rows


def _angles_in_image(markers: list[Marker], places_m: dict[str, FloatArray]) -> list[list[float]]:
    measured = {one.label: one.position_m for one in markers if one.position_m is not None}
    rows = []
    for vertex in measured:
        for a, c in combinations((name for name in measured if name != vertex), 2):
            value_rad, _ = _angle(*(measured[name][:2] for name in (a, vertex, c)))
            truth_rad, shortest_m = _angle(*(places_m[name][:2] for name in (a, vertex, c)))
            rows.append([value_rad - truth_rad, math.nan, shortest_m, truth_rad])
    return rows


def _angle(a_m: FloatArray, vertex_m: FloatArray, c_m: FloatArray) -> tuple[float, float]:
    """Return the angle at the vertex, and the shorter side; in space or in the plane."""
    first, second = a_m - vertex_m, c_m - vertex_m
    sides_m = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    cosine = float(first @ second)
    across = math.sqrt(max((sides_m[0] * sides_m[1]) ** 2 - cosine**2, 0.0))
    return math.atan2(across, cosine), min(sides_m)
