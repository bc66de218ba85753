"""Learn the odds that a faint spot is a marker: python -m benchmarks.train_spots.

Prints `adibas/markers/spot_odds_learned.py`. What lies on a hidden marker is neither a marker nor
none. No scene is one of a benchmark's.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import TypeAlias

import cv2
import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray, UInt8Array
from adibas.markers.blobs import Blob
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, find_color_markers, spots_with_features
from adibas.markers.faint import FaintParams
from adibas.markers.lab import rgb_to_lab
from adibas.markers.mean_picture import MeanPicture
from adibas.markers.spot_odds import FEATURES, LARGEST_CROWD, SpotOdds, crowd_size
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
N_FRAMES, PLAIN_FRAME, FRINGED_FRAME = 12, 0, 2
"""Frames of a burst; those that are looked at one by one, beside the mean of all."""
FRINGES_PX = 0.3, 1.2
"""By how much a lens lays red and blue apart: borders of something bright have coloured fringes."""
N_PROCESSES = 2
N_UNITS, RIDGE, N_STEPS = 24, 5.0, 600
UNIT_SEED = 0
LEAST_ODDS = -12.0
"""Of spots by which it is learned what a crowd makes of log odds: all others are no markers."""
IS_MARKER, IS_NONE, IS_OPEN = 1, 0, -1
N_PICTURES = 8
"""Of a scene: a frame and the mean, plain and with fringes, each looked at by two colours."""
NO_SPOTS = FaintParams(least_log_odds=math.inf)
NO_CROWD = 0.0, 1.0, 0.0, 0.0
SMALL_M, LARGE_M = 0.008, 0.012
FAR_APART = 60.0
"""Two colours, in the plane of CIELAB's a and b."""

Row: TypeAlias = tuple[FloatArray, int]
"""Features of a spot, and its kind."""


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """N spots to learn from.

    Attributes
    ----------
    features : (N, 8) array
    kind : (N,) int array
        `IS_MARKER`, `IS_NONE`, or `IS_OPEN`: of no use but as one of the crowd.
    picture : (N,) int array
        Which picture each is in.
    """

    features: FloatArray
    kind: IntArray
    picture: IntArray

    @property
    def known(self) -> "Spots":
        """Return those that are a marker, or surely none."""
        return self.chosen(self.kind != IS_OPEN)

    def chosen(self, is_chosen: BoolArray) -> "Spots":
        """Return some of them."""
        return Spots(self.features[is_chosen], self.kind[is_chosen], self.picture[is_chosen])


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


def joined(found: Sequence[Spots]) -> Spots:
    """Return the spots of several scenes, whose pictures are different ones."""
    pictures = [N_PICTURES * index + one.picture for index, one in enumerate(found)]
    return Spots(
        np.concatenate([one.features for one in found]),
        np.concatenate([one.kind for one in found]),
        np.concatenate(pictures),
    )


def learn_all(parts: Sequence[Spots]) -> SpotOdds:
    """Learn the network from all spots, and the crowd's weights from what it says of unseen ones.

    For that, each of the two parts is judged by a network which learned from the other.
    """
    first, second = parts
    judged = [
        _crowded(learn_look(first.known), second),
        _crowded(learn_look(second.known), first),
    ]
    rows = np.concatenate([one[0] for one in judged])
    is_marker = np.concatenate([one[1] for one in judged])
    return replace(learn_look(joined(parts).known), crowd=learn_crowd(rows, is_marker))


def _crowded(odds: SpotOdds, spots: Spots) -> tuple[FloatArray, BoolArray]:
    """Return the log odds of each known spot alone and its crowd, (N, 2), and what is a marker."""
    in_best_form = odds.alone_in_best_form(spots.features[:, :-1])
    crowds = np.zeros(len(in_best_form))
    for picture in np.unique(spots.picture):
        is_there = spots.picture == picture
        crowds[is_there] = crowd_size(in_best_form[is_there])
    rows = np.column_stack([odds.alone(spots.features), crowds])
    is_used = (spots.kind != IS_OPEN) & (rows[:, 0] > LEAST_ODDS)
    return rows[is_used], spots.kind[is_used] == IS_MARKER


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
        index = None if blob is None else _marker_at(blob, truth)
        is_marker = index is not None and index not in taken
        is_open = blob is None or (is_marker and not truth.markers[index or 0].is_visible)
        yield features, IS_OPEN if is_open else IS_MARKER if is_marker else IS_NONE


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


def learn_look(spots: Spots) -> SpotOdds:
    """Return the network that tells markers from others best, with a ridge; no crowd counts."""
    mean, sd = spots.features.mean(axis=0), spots.features.std(axis=0)
    inputs = ((spots.features - mean) / sd).astype(np.float32)
    is_marker = spots.kind == IS_MARKER
    network = _Network(inputs, is_marker)
    found = minimize(
        network.loss,
        network.start(),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": N_STEPS, "maxfun": 2 * N_STEPS, "maxcor": 20},
    ).x
    values, biases, weights, offset = network.parts(found)
    weights = weights / sd
    units = np.column_stack([values, biases - weights @ mean, weights])
    rounded = tuple(tuple(_rounded(value) for value in unit) for unit in units)
    return SpotOdds(rounded, _rounded(offset), NO_CROWD)


class _Network:
    """Minus log likelihood of (N, F) inputs, as a function of one vector of weights."""

    def __init__(self, inputs: Float32Array, is_marker: BoolArray) -> None:
        self._inputs, self._is_marker = inputs, is_marker
        self._n_inputs = inputs.shape[1]

    def start(self) -> FloatArray:
        """Return small random weights, and the offset of something seldom."""
        rng = np.random.default_rng(UNIT_SEED)
        n = self._n_inputs
        weights = rng.normal(0.0, 1.0 / math.sqrt(n), n * N_UNITS)
        return np.concatenate([rng.normal(0.0, 0.5, 2 * N_UNITS), weights, [-4.0]])

    def parts(self, vector: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """Return the units' (U,) values, (U,) biases and (U, F) weights, and the offset."""
        values, biases = vector[:N_UNITS], vector[N_UNITS : 2 * N_UNITS]
        weights = vector[2 * N_UNITS : -1].reshape(N_UNITS, self._n_inputs)
        return values, biases, weights, float(vector[-1])

    def loss(self, vector: FloatArray) -> tuple[float, FloatArray]:
        """Return it and its gradient."""
        values, biases, weights, offset = self.parts(vector.astype(np.float32))
        units = np.tanh(self._inputs @ weights.T + biases)
        log_odds = (units @ values).astype(float) + offset
        ridge = RIDGE * np.append(vector[:-1], 0.0)
        value = np.logaddexp(0.0, log_odds).sum() - log_odds[self._is_marker].sum()
        error = (expit(log_odds) - self._is_marker).astype(np.float32)
        through = error[:, None] * values * (1.0 - units**2)
        slopes = (units.T @ error, through.sum(axis=0), (through.T @ self._inputs).ravel())
        slope = np.concatenate([*slopes, [error.sum()]]).astype(float) + ridge
        return float(value + 0.5 * ridge @ vector), slope


def learn_crowd(rows: FloatArray, is_marker: BoolArray) -> tuple[float, float, float, float]:
    """Return the weights of 1, log odds, crowd and both, of (N, 2) log odds alone and crowds."""
    alone, much = rows[:, 0], np.log1p(np.minimum(rows[:, 1], LARGEST_CROWD))
    terms = np.column_stack([np.ones(len(rows)), alone, much, alone * much])

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        log_odds = terms @ weights
        value = np.logaddexp(0.0, log_odds).sum() - log_odds[is_marker].sum()
        return float(value), terms.T @ (expit(log_odds) - is_marker)

    found = minimize(loss, np.array(NO_CROWD), jac=True).x
    base, slope, of_crowd, of_both = (_rounded(value) for value in found)
    return base, slope, of_crowd, of_both


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")


if __name__ == "__main__":
    main()
