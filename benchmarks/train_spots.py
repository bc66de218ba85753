"""Learn the odds that a faint spot is a marker: python -m benchmarks.train_spots.

Prints `adibas/markers/spot_odds_learned.py`. What lies on a hidden marker is neither a marker nor
none. No scene is one of a benchmark's.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from typing import TypeAlias

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.markers.blobs import Blob
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, find_color_markers, spots_with_features
from adibas.markers.faint import FaintParams
from adibas.markers.lab import rgb_to_lab
from adibas.markers.mean_picture import MeanPicture
from adibas.markers.spot_odds import FEATURES
from adibas.pipeline.posture import PostureParams, look_for_person
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.layouts import analysis_settings
from adibas.simulation.patient import GREEN
from adibas.simulation.scenes import SceneSettings, SimulatedScene
from adibas.simulation.truth import FrameTruth
from benchmarks.accuracy_markers import COLORS
from benchmarks.marker_trial import GATE_M, learned_target
from benchmarks.posture_trial import analyses
from benchmarks.spot_learning import IS_MARKER, IS_NONE, IS_OPEN, Spots, joined, learn_all

SEEDS = (3, 4)
"""Of the scenes; the benchmarks have others."""
N_FRAMES, PLAIN_FRAME, FRINGED_FRAME = 12, 0, 2
"""Frames of a burst; those that are looked at one by one, beside the mean of all."""
FRINGES_PX = 0.3, 1.2
"""By how much a lens lays red and blue apart: borders of something bright have coloured fringes."""
N_PROCESSES = 2
NO_SPOTS = FaintParams(least_log_odds=math.inf)
SMALL_M, LARGE_M = 0.008, 0.012
FAR_APART = 60.0
"""Two colours, in the plane of CIELAB's a and b."""

Row: TypeAlias = tuple[FloatArray, int]
"""Features of a spot, and its kind."""


def main() -> None:
    """Simulate, look for spots, and print what was learned."""
    by_seed = []
    with ProcessPoolExecutor(N_PROCESSES, mp_context=get_context("spawn")) as pool:
        for seed in SEEDS:
            found = list(pool.map(spots_of, scenes(seed)))
            by_seed.append(joined(found))
            print(f"seed {seed}: {len(found)} scenes, {_told(by_seed[-1])}")  # noqa: T201
    odds = learn_all(by_seed)
    print(f"UNITS = {odds.units}\nOFFSET = {odds.offset}\nCROWD = {odds.crowd}")  # noqa: T201


def _told(spots: Spots) -> str:
    known = spots.known.kind
    return f"{len(known)} spots, of which {(known == IS_MARKER).sum()} are markers"


def scenes(seed: int) -> list[SceneSettings]:
    """Return patients near and far, with small and large stickers of many colours."""
    layouts = analysis_settings(seed)
    joints = [one.settings for one in analyses(seed, 1)]
    wanted = [_with(one, SMALL_M, distance_m=3.5) for one in joints[::7]]
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


def spots_of(settings: SceneSettings) -> Spots:
    """Return the spots in one scene.

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

    def spots(picture_rgb: UInt8Array, least_rise: float) -> Iterator[list[Row]]:
        faint = FaintParams(least_rise=least_rise, least_log_odds=-math.inf)
        params, at = DetectionParams(faint=faint), (picture_rgb, outline, depth_m, focal_px)
        full = find_color_markers(*at, model, replace(params, faint=NO_SPOTS)).blobs
        yield list(_judged(spots_with_features(*at, model, params), full, truth))
        others = spots_with_features(*at, stranger, params)
        yield [(row, IS_OPEN if blob is None else IS_NONE) for blob, row in others]

    mean = MeanPicture()
    for frame in frames:
        mean.add(frame.color_rgb)
    rng = np.random.default_rng(settings.seed)
    wanted = [
        (frames[PLAIN_FRAME].color_rgb, FaintParams().least_rise),
        (with_fringes(frames[FRINGED_FRAME].color_rgb, rng), FaintParams().least_rise),
        (mean.result(), PostureParams().least_rise_of_mean),
        (with_fringes(mean.result(), rng), PostureParams().least_rise_of_mean),
    ]
    return _spots([one for at in wanted for one in spots(*at)])


def with_fringes(color_rgb: UInt8Array, rng: np.random.Generator) -> UInt8Array:
    """Move red one way and blue the other, as a lens does far from its axis."""
    angle_rad, by_px = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(*FRINGES_PX)
    size = color_rgb.shape[1::-1]
    fringed = color_rgb.copy()
    for channel, share in ((0, 1.0), (2, -rng.uniform(0.3, 1.0))):
        u_px, v_px = (share * by_px * of(angle_rad) for of in (math.cos, math.sin))
        shift = np.array([[1.0, 0.0, u_px], [0.0, 1.0, v_px]])
        fringed[..., channel] = cv2.warpAffine(
            color_rgb[..., channel],
            shift,
            size,
            flags=cv2.INTER_CUBIC,
            borderMode=cv2.BORDER_REPLICATE,
        )
    return fringed


def _spots(pictures: Sequence[Sequence[Row]]) -> Spots:
    rows = [(*row, number) for number, picture in enumerate(pictures) for row in picture]
    features = np.array([row[0] for row in rows], float).reshape(-1, len(FEATURES))
    numbers = np.array([row[1:] for row in rows], int).reshape(-1, 2)
    return Spots(features, numbers[:, 0], numbers[:, 1])


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
    spots: Iterable[tuple[Blob | None, FloatArray]], full: Sequence[Blob], truth: FrameTruth
) -> Iterator[Row]:
    """Give the features of each spot, and its kind.

    One beside a marker that its full colour shows is none; one on a marker that is not in view is
    of no use.
    """
    taken = {_marker_at(one, truth) for one in full}
    for blob, features in spots:
        yield features, IS_OPEN if blob is None else _kind_of(_marker_at(blob, truth), taken, truth)


def _kind_of(marker: int | None, taken: set[int | None], truth: FrameTruth) -> int:
    if marker is None or marker in taken:
        return IS_NONE
    return IS_MARKER if truth.markers[marker].is_visible else IS_OPEN


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


if __name__ == "__main__":
    main()
