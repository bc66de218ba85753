"""The thesis' marker experiment on the simulator: 5 bodies x 4 postures x 10 layouts.

Stickers of 8 mm at 2 m, colour 1280x1024, depth 640x480, another light, room and sensor in every
analysis; one frame, and a burst of 30. The colour is learned by three clicks on one picture of
another scene. Source of the reference figures: thesis, table 6.1, and the goals of the project.
"""

import math
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

from adibas.arrays import FloatArray
from adibas.simulation.depth_noise import DepthNoise
from adibas.simulation.layouts import analysis_settings
from adibas.simulation.patient import GREEN
from adibas.simulation.scenes import SceneSettings
from benchmarks.marker_trial import Compared, Outcome, Trial, nearly_straight, pooled, run_trial
from benchmarks.table import Row

SEED = int(os.environ.get("ADIBAS_BENCHMARK_SEED", "0"))
"""Of the 200 analyses; another one to develop with."""
N_PROCESSES = 2
QUICK_STEP = 23
VARIANT_STEP = 7
"""Every seventh analysis is enough for the variants; it meets every layout, posture and body."""

COLORS = {
    "yellow": (235, 205, 40),
    "orange": (240, 120, 30),
    "red": (200, 30, 40),
    "pink": (230, 50, 140),
    "blue": (30, 90, 200),
    "cyan": (30, 180, 190),
}
"""Of other stickers, sRGB; clothes and walls of the simulated scenes come in many of them."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A change of the experiment: its name, and what is done to every analysis."""

    name: str
    step: int = VARIANT_STEP
    diameter_m: float = 0.008
    kind: str = "sticker"
    color_size: tuple[int, int] = (1024, 1280)
    disparity_sd: float = 0.5
    left_bias_m: float = 0.0
    distance_m: float = 2.0
    color: tuple[int, int, int] = GREEN

    def trial(self, settings: SceneSettings) -> Trial:
        """Return one analysis with the change."""
        markers = replace(
            settings.markers,
            diameter_m=self.diameter_m,
            kind=self.kind,  # type: ignore[arg-type]
            color=self.color,
        )
        changed = replace(
            settings,
            markers=markers,
            color_size=self.color_size,
            depth_noise=DepthNoise(disparity_sd=self.disparity_sd),
            distance_m=self.distance_m,
        )
        return Trial(changed, left_bias_m=self.left_bias_m)


THESIS = Variant("8 mm green", step=1)
VARIANTS = (
    Variant("12 mm green", diameter_m=0.012),
    Variant("LED", diameter_m=0.005, kind="led"),
    Variant("8 mm green, colour 640x480", color_size=(480, 640)),
    Variant("8 mm green, disparity noise 0.1", disparity_sd=0.1),
    Variant("8 mm green, 2 cm bias not corrected", left_bias_m=0.02),
    Variant("8 mm green at 2.6 m", distance_m=2.6),
    Variant("8 mm green at 3.5 m", distance_m=3.5),
    Variant("12 mm green at 3.5 m", diameter_m=0.012, distance_m=3.5),
    *(Variant(f"12 mm {name}", diameter_m=0.012, color=color) for name, color in COLORS.items()),
)


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` every 23rd analysis, and of the variants two."""
    settings = analysis_settings(SEED)
    with ProcessPoolExecutor(N_PROCESSES, mp_context=get_context("spawn")) as pool:
        for variant in (THESIS, *VARIANTS):
            chosen = settings[:: variant.step * (QUICK_STEP if quick else 1)]
            trials = [variant.trial(one) for one in chosen]
            outcomes = list(pool.map(run_trial, trials))
            told = f"{variant.name}, {len(trials)} analyses, seed {SEED}"
            for n_frames, same_length in zip(
                trials[0].n_frames, zip(*outcomes, strict=True), strict=True
            ):
                frames = "1 frame" if n_frames == 1 else f"burst of {n_frames}"
                yield from _rows(f"{told}, {frames}", pooled(same_length), n_frames)


def _rows(told: str, outcome: Outcome, n_frames: int) -> Iterator[Row]:
    found = 100 * outcome.n_found / max(outcome.n_visible, 1)
    false = 100 * outcome.n_false / max(outcome.n_detected, 1)
    goal_mm, goal_deg = (2.3, 1.5) if n_frames == 1 else (1.0, 0.5)
    yield Row(f"{told}: found of {outcome.n_visible} visible", found, "%", 97.0, "goal >=")
    yield Row(f"{told}: false of {outcome.n_detected} found", false, "%", 0.5, "goal <")
    without = 100 * outcome.n_without_position / max(outcome.n_detected, 1)
    yield Row(f"{told}: without a position", without, "%")
    yield Row(f"{told}: mean position error", 1e3 * _mean(outcome.position_errors_m), "mm")
    distances, angles = outcome.distances, outcome.angles
    yield Row(
        f"{told}: mean distance error", 1e3 * _mean(distances.error), "mm", goal_mm, "goal <="
    )
    yield Row(
        f"{told}: mean angle error", math.degrees(_mean(angles.error)), "deg", goal_deg, "goal <="
    )
    straight = nearly_straight(angles)
    for name, compared in (
        ("distances", distances),
        ("angles", angles),
        ("angles near straight", straight),
    ):
        yield _coverage(f"{told}: intervals that hold the truth, {name}", compared)


def _coverage(told: str, compared: Compared) -> Row:
    share = 100 * _mean(compared.is_covered)
    return Row(f"{told} ({len(compared.truth)} cases)", share, "%", 95.0, "nominal")


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else math.nan
