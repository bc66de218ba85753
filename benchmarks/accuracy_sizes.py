"""How much the measured diameters of one person's markers differ, all of which are of one size.

Names are told by it (`adibas.skeleton.sizes`), and `benchmarks.labelling_sets` draws from it. All
spots that were found in a burst and have a position count, whatever they are.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from adibas.arrays import FloatArray
from adibas.pipeline.skeleton_names import diameters_of
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.scenes import SceneSettings, SimulatedScene
from benchmarks.marker_trial import find, learned_target
from benchmarks.posture_trial import analyses
from benchmarks.posture_variants import changed, variants
from benchmarks.table import Row

SEED, N_FRAMES, EVERY = 900, 10, 13
LEAST_MARKERS = 5
AT_TWO_METRES = "8 mm, 2 m"
OTHERS = ("1.2 m", "2.6 m", "3.5 m", "LED of 5 mm", "stickers of 12 mm", "dark skin")


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure 16 analyses of each kind that no other benchmark has; with `quick` two."""
    every = 100 if quick else EVERY
    plain = analyses(SEED, N_FRAMES)
    kinds = {AT_TWO_METRES: plain}
    for number, variant in enumerate(variants(), 1):
        if variant.name in OTHERS:
            kinds[variant.name] = changed(plain, variant, number)
    for name, of_kind in kinds.items():
        off = np.concatenate([deviations(one.settings) for one in of_kind[::every]])
        yield from _rows(f"{name}, {len(of_kind[::every])} analyses, seed {SEED}", off)


def deviations(settings: SceneSettings) -> FloatArray:
    """Return the logarithms of the diameters about their median; none of fewer than five."""
    scene = SimulatedScene(settings)
    calibration = scene.info.calibration
    if calibration is None:
        raise ValueError("a simulated scene has a calibration")
    frames = [to_rgbd(scene.frame(index).sensor_frame, scene.info) for index in range(N_FRAMES)]
    found = find(frames, calibration, learned_target(settings))
    placed = [one for one in found if one.position_m is not None]
    if len(placed) < LEAST_MARKERS:
        return np.empty(0)
    logs = np.log(diameters_of(placed, calibration))
    return np.asarray(logs - np.median(logs))


def _rows(told: str, off: FloatArray) -> Iterator[Row]:
    yield Row(f"{told}: standard deviation of ln diameter of {len(off)}", float(off.std()), "")
    yield Row(f"{told}: 95 % of them differ by less than", float(np.quantile(abs(off), 0.95)), "")
