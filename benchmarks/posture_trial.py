"""One analysis of the posture chain: simulate, find, name, measure, hold against the truth."""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.data.markers import Marker
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import with_names
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.patient import SHAPES, MarkerSettings
from adibas.simulation.postures import POSTURES
from adibas.simulation.scenes import SceneSettings, SimulatedScene
from adibas.simulation.truth import FrameTruth
from benchmarks.marker_trial import GATE_M, find, learned_target

N_BODIES, N_REPEATS = 5, 10
Z_95 = 1.959964
"""An interval is so many standard errors on each side."""


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
    """

    number: int
    n_visible: int
    n_named: int
    n_wrong: int
    distances: list[list[float]]
    angles: list[list[float]]


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
    calibration = scene.info.calibration
    if calibration is None:
        raise ValueError("a simulated scene has a calibration")
    simulated = [scene.frame(index) for index in range(analysis.n_frames)]
    frames = [to_rgbd(one.sensor_frame, scene.info) for one in simulated]
    found = find(frames, calibration, learned_target(analysis.settings))
    named = with_names(shipped_namer(), found, "anterior", calibration)
    return _compared(analysis.number, named, [one.truth for one in simulated])


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
        first = places_m[measure.a] - places_m[measure.vertex]
        second = places_m[measure.c] - places_m[measure.vertex]
        across = float(np.linalg.norm(np.cross(first, second)))
        truth_rad = math.atan2(across, float(first @ second))
        low_rad, high_rad = measure.interval_rad
        shortest_m = float(min(np.linalg.norm(first), np.linalg.norm(second)))
        error_rad = measure.value_rad - truth_rad
        rows.append([error_rad, (high_rad - low_rad) / (2 * Z_95), shortest_m, truth_rad])
    return rows
