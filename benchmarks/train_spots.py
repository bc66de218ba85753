"""Learn the odds that a faint spot is a marker: python -m benchmarks.train_spots.

Prints the weights of `adibas.markers.faint.SpotOdds`. Markers that are found by their full colour
are not learned from; what lies on a hidden marker is neither a marker nor none. No scene is one of
a benchmark's.
"""

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from multiprocessing import get_context

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from adibas.arrays import BoolArray, FloatArray, UInt8Array
from adibas.markers.blobs import Blob, Looks
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, find_color_markers
from adibas.markers.faint import (
    FaintParams,
    SpotOdds,
    in_other_light,
    spot_features,
    ways_to_marker,
)
from adibas.markers.mean_picture import MeanPicture
from adibas.pipeline.posture import PostureParams, look_for_person
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.layouts import analysis_settings
from adibas.simulation.scenes import SceneSettings, SimulatedScene
from adibas.simulation.truth import FrameTruth
from benchmarks.accuracy_markers import COLORS
from benchmarks.marker_trial import GATE_M, learned_target
from benchmarks.posture_trial import analyses

SEEDS = (3, 4)
"""Of the scenes; the benchmarks have others."""
N_FRAMES, ALONE = 12, (0, 2)
"""Frames of a burst; those that are looked at one by one, beside the mean of all."""
N_PROCESSES = 2
N_FEATURES = len(fields(SpotOdds)) - 1
RIDGE = 1.0
SMALL_M, LARGE_M = 0.008, 0.012


def main() -> None:
    """Simulate, look for spots, and print the weights."""
    wanted = scenes()
    with ProcessPoolExecutor(N_PROCESSES, mp_context=get_context("spawn")) as pool:
        found = list(pool.map(spots_of, wanted))
    features = np.concatenate([one[0] for one in found])
    is_marker = np.concatenate([one[1] for one in found])
    odds = learn(features, is_marker)
    print(f"{len(is_marker)} spots in {len(wanted)} scenes, of which {is_marker.sum()} are markers")  # noqa: T201
    print(odds)  # noqa: T201


def scenes() -> list[SceneSettings]:
    """Return patients near and far, with small and large stickers of many colours."""
    wanted: list[SceneSettings] = []
    for seed in SEEDS:
        layouts = analysis_settings(seed)
        joints = [one.settings for one in analyses(seed, 1)]
        wanted += [_with(one, SMALL_M, distance_m=3.5) for one in joints[::7]]
        wanted += [_with(one, LARGE_M, distance_m=3.5) for one in layouts[::7]]
        for color in COLORS.values():
            wanted += [_with(one, LARGE_M, color=color) for one in layouts[3::14]]
        for one in layouts[5::14]:
            wanted += [_with(one, SMALL_M, distance_m=far_m) for far_m in (2.0, 2.6, 3.5)]
            wanted.append(replace(_with(one, SMALL_M), color_size=(480, 640)))
    return wanted


def _with(
    settings: SceneSettings,
    diameter_m: float,
    *,
    color: tuple[int, int, int] | None = None,
    distance_m: float = 2.0,
) -> SceneSettings:
    markers = replace(settings.markers, diameter_m=diameter_m)
    markers = markers if color is None else replace(markers, color=color)
    return replace(settings, markers=markers, distance_m=distance_m)


def spots_of(settings: SceneSettings) -> tuple[FloatArray, BoolArray]:
    """Return the (N, 7) features of the spots in one scene, and which are markers."""
    scene = SimulatedScene(settings)
    simulated = [scene.frame(index) for index in range(N_FRAMES)]
    frames = [to_rgbd(one.sensor_frame, scene.info) for one in simulated]
    truth, model = simulated[0].truth, learned_target(settings)
    sight = look_for_person(frames[-1], truth.calibration, PostureParams())
    if sight is None or not isinstance(model, ColorModel):
        raise ValueError("the patient of a simulated scene is seen, with coloured markers")
    outline, depth_m = sight.outline, sight.registration.depth_m
    focal_px = _focal_px(truth)

    def look(picture_rgb: UInt8Array, least: float) -> tuple[Blob, ...]:
        params = DetectionParams(faint=FaintParams(least_log_odds=least, greatest_nearness=1.0))
        return find_color_markers(picture_rgb, outline, depth_m, focal_px, model, params).blobs

    mean = MeanPicture()
    for frame in frames:
        mean.add(frame.color_rgb)
    pictures = [frames[index].color_rgb for index in ALONE] + [mean.result()]
    rows = [
        row
        for picture_rgb in pictures
        for row in _judged(look(picture_rgb, math.inf), look(picture_rgb, -math.inf), truth, model)
    ]
    features = np.array([row[0] for row in rows], float).reshape(-1, N_FEATURES)
    return features, np.array([row[1] for row in rows], bool)


def _judged(
    full: Sequence[Blob], all_blobs: Sequence[Blob], truth: FrameTruth, model: ColorModel
) -> Iterator[tuple[FloatArray, bool]]:
    """Give the features of the spots that are not found by full colour, and whether they are."""
    detection = DetectionParams()
    centroids_lab = model.pure_centroids_lab().astype(np.float32)
    colors_lab = in_other_light(centroids_lab, detection.faint.light_range)
    seen = {(one.u, one.v) for one in full}
    taken = {_marker_at(one, truth) for one in full}
    for blob in all_blobs:
        index = _marker_at(blob, truth)
        is_clear = index is None or (index not in taken and truth.markers[index].is_visible)
        if (blob.u, blob.v) in seen or not is_clear:
            continue
        looks = _looks(blob)
        way = ways_to_marker(looks, colors_lab, detection.lightness_weight)
        yield spot_features(looks, way, np.array([blob.axis_ratio]))[0], index is not None


def _looks(blob: Blob) -> Looks:
    return Looks(*(np.array([getattr(blob, name)]) for name in Looks._fields))


def _marker_at(blob: Blob, truth: FrameTruth) -> int | None:
    """Return which marker a blob lies on."""
    for index, one in enumerate(truth.markers):
        gate_px = GATE_M * _focal_px(truth) / float(one.position_m[2])
        if math.hypot(blob.u - one.u, blob.v - one.v) < gate_px:
            return index
    return None


def _focal_px(truth: FrameTruth) -> float:
    if truth.calibration.color is None:
        raise ValueError("a simulated scene has a colour camera")
    return truth.calibration.color.intrinsics.fx


def learn(features: FloatArray, is_marker: BoolArray) -> SpotOdds:
    """Return the weights of a logistic regression, with a ridge on standardised features."""
    mean, sd = features.mean(axis=0), features.std(axis=0)
    rows = np.column_stack([(features - mean) / sd, np.ones(len(features))])

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        log_odds = rows @ weights
        penalty = np.append(weights[:-1], 0.0)
        value = np.logaddexp(0.0, log_odds).sum() - log_odds[is_marker].sum()
        slope = rows.T @ (expit(log_odds) - is_marker) + RIDGE * penalty
        return float(value + 0.5 * RIDGE * (penalty**2).sum()), slope

    weights = minimize(loss, np.zeros(rows.shape[1]), jac=True).x
    slopes = weights[:-1] / sd
    return SpotOdds(*np.round([*slopes, weights[-1] - slopes @ mean], 3).tolist())


if __name__ == "__main__":
    main()
