"""Learn the odds that a faint spot is a marker: python -m benchmarks.train_spots.

Prints the weights of `adibas.markers.spot_odds.SpotOdds`. What lies on a hidden marker is neither a
marker nor none. No scene is one of a benchmark's.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from adibas.arrays import BoolArray, FloatArray, UInt8Array
from adibas.markers.blobs import Blob
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, find_color_markers, spots_with_features
from adibas.markers.faint import FaintParams
from adibas.markers.lab import rgb_to_lab
from adibas.markers.mean_picture import MeanPicture
from adibas.markers.spot_odds import FEATURES, SpotOdds
from adibas.pipeline.posture import PostureParams, look_for_person
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.layouts import analysis_settings
from adibas.simulation.patient import GREEN
from adibas.simulation.scenes import SceneSettings, SimulatedScene
from adibas.simulation.truth import FrameTruth
from benchmarks.accuracy_markers import COLORS
from benchmarks.marker_trial import GATE_M, learned_target
from benchmarks.posture_trial import analyses

SEEDS = (3, 4)
"""Of the scenes; the benchmarks have others."""
N_FRAMES, ALONE = 12, (0, 2)
"""Frames of a burst; those that are looked at one by one, beside the mean of all."""
LEAST_RISE_IN_FRAME = 5.0
"""CIELAB units: some that are not looked for there, to save time, are learned from."""
N_PROCESSES = 2
RIDGE = 1.0
N_STEPS = 2000
NO_SPOTS = FaintParams(least_log_odds=math.inf)
SMALL_M, LARGE_M = 0.008, 0.012
FAR_APART = 60.0
"""Two colours, in the plane of CIELAB's a and b."""


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
    """Return the (N, 8) features of the spots in one scene, and which are markers.

    They are looked for by the markers' colour, and by one of which none is a marker.
    """
    scene = SimulatedScene(settings)
    simulated = [scene.frame(index) for index in range(N_FRAMES)]
    frames = [to_rgbd(one.sensor_frame, scene.info) for one in simulated]
    truth, model = simulated[0].truth, learned_target(settings)
    sight = look_for_person(frames[-1], truth.calibration, PostureParams())
    if sight is None or not isinstance(model, ColorModel):
        raise ValueError("the patient of a simulated scene is seen, with coloured markers")
    outline, depth_m = sight.outline, sight.registration.depth_m
    focal_px = _focal_px(truth)

    stranger = _stranger(settings)

    def spots(picture_rgb: UInt8Array, least_rise: float) -> Iterator[tuple[FloatArray, bool]]:
        faint = FaintParams(least_rise=least_rise, least_log_odds=-math.inf)
        params, at = DetectionParams(faint=faint), (picture_rgb, outline, depth_m, focal_px)
        full = find_color_markers(*at, model, replace(params, faint=NO_SPOTS)).blobs
        yield from _judged(spots_with_features(*at, model, params), full, truth)
        for _, features in spots_with_features(*at, stranger, params):
            yield features, False

    mean = MeanPicture()
    for frame in frames:
        mean.add(frame.color_rgb)
    rows = [row for index in ALONE for row in spots(frames[index].color_rgb, LEAST_RISE_IN_FRAME)]
    rows += spots(mean.result(), PostureParams().least_rise_of_mean)
    features = np.array([row[0] for row in rows], float).reshape(-1, len(FEATURES))
    return features, np.array([row[1] for row in rows], bool)


def _stranger(settings: SceneSettings) -> ColorModel:
    """Return the learned model of a colour that is far from the markers'."""
    colors = np.array([settings.markers.color, GREEN, *COLORS.values()], np.uint8)
    lab = rgb_to_lab(colors[None])[0]
    far = np.flatnonzero(np.linalg.norm(lab[:, 1:] - lab[0, 1:], axis=1) > FAR_APART)
    color = tuple(colors[far[settings.seed % len(far)]].tolist())
    model = learned_target(replace(settings, markers=replace(settings.markers, color=color)))
    if not isinstance(model, ColorModel):
        raise TypeError("a colour was learned")
    return model


def _judged(
    spots: Iterable[tuple[Blob, FloatArray]], full: Sequence[Blob], truth: FrameTruth
) -> Iterator[tuple[FloatArray, bool]]:
    """Give the features of each spot, and whether it is a marker.

    One beside a marker that its full colour shows is none; one on a marker that is not in view is
    left out.
    """
    taken = {_marker_at(one, truth) for one in full}
    for blob, features in spots:
        index = _marker_at(blob, truth)
        if index is None or index in taken or truth.markers[index].is_visible:
            yield features, index is not None and index not in taken


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
    """Return the weights of a logistic regression on products, with a ridge."""
    standard = _standardising(features)
    terms = np.column_stack([np.ones(len(features)), features]) @ standard.T
    upper = np.triu_indices(terms.shape[1])
    rows = terms[:, upper[0]] * terms[:, upper[1]]

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        log_odds = rows @ weights
        penalty = np.append(0.0, weights[1:])
        value = np.logaddexp(0.0, log_odds).sum() - log_odds[is_marker].sum()
        slope = rows.T @ (expit(log_odds) - is_marker) + RIDGE * penalty
        return float(value + 0.5 * RIDGE * (penalty**2).sum()), slope

    weights = minimize(loss, np.zeros(rows.shape[1]), jac=True, options={"maxiter": N_STEPS}).x
    matrix = np.zeros_like(standard)
    matrix[upper] = weights
    both = standard.T @ matrix @ standard
    whole = np.triu(both) + np.triu(both.T, 1)
    rounded = [[float(f"{value:.5g}") for value in row] for row in whole]
    return SpotOdds(tuple(tuple(row[index:]) for index, row in enumerate(rounded)))


def _standardising(features: FloatArray) -> FloatArray:
    """Return what makes 1 and the features 1 and features of mean 0 and standard deviation 1."""
    sd = features.std(axis=0)
    matrix = np.diag(np.append(1.0, 1.0 / sd))
    matrix[1:, 0] = -features.mean(axis=0) / sd
    return matrix


if __name__ == "__main__":
    main()
