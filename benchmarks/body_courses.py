"""How far the spine deviates and turns at most, and the intervals of that, against the truth.

C7 and the dimples bear markers here, each seen with an error of half a millimetre.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.body_measures import BodyMeasure
from adibas.data.markers import Marker
from adibas.errors import BodyError
from adibas.pipeline.back import Back, measure_back
from adibas.pipeline.body_views import BodyView
from adibas.surface.back_measures import C7, LEFT_PSIS, RIGHT_PSIS
from adibas.surface.course_errors import greatest, rms
from benchmarks.body_scenes import BackScene, true_midline_m
from benchmarks.table import Row

MARKER_SD_M = 0.0005
STEP_M = 0.004
NAMES = {
    "BACK.DEVIATION.RMS": "lateral deviation, root mean square",
    "BACK.DEVIATION.MAX": "lateral deviation, greatest",
}


@dataclass(slots=True)
class Deviations:
    """What was measured so far.

    Attributes
    ----------
    errors_mm : dict of str to list of float
        By measure.
    held : dict of str to list of bool
        Whether the interval holds the truth.
    """

    errors_mm: dict[str, list[float]] = field(default_factory=dict)
    held: dict[str, list[bool]] = field(default_factory=dict)

    def add(self, scene: BackScene, view: BodyView, seed: int) -> None:
        """Measure a back once more, with markers; one that cannot be measured is left out."""
        landmarks = scene.posed("posterior").landmarks
        rng = np.random.default_rng([seed, 0xDE])
        to_color = scene.calibration.color_from_depth @ scene.depth_from_world
        markers = tuple(
            Marker(
                name,
                *(0.0, 0.0, 3.0, np.eye(2)),
                position_m=to_color.apply(landmarks[name]) + rng.normal(0.0, MARKER_SD_M, 3),
                covariance_m2=MARKER_SD_M**2 * np.eye(3),
            )
            for name in (C7, LEFT_PSIS, RIGHT_PSIS)
        )
        try:
            back = measure_back(view, markers)
        except BodyError:
            return
        truths = _truths(scene, back)
        for one in back.measures:
            if one.definition.measure_id in truths:
                self._compare(one, truths[one.definition.measure_id])

    def rows(self, told: str) -> Iterator[Row]:
        """Print what was found."""
        for name, errors_mm in self.errors_mm.items():
            error = float(np.sqrt(np.mean(np.square(errors_mm))))
            yield Row(f"{told}: {NAMES[name]} ({len(errors_mm)}), rms", error, "mm")
            share = 100.0 * float(np.mean(self.held[name]))
            yield Row("same: intervals that hold the truth", share, "%", 95.0, "goal 93-97")

    def _compare(self, found: BodyMeasure, truth_m: float) -> None:
        if found.value is None or found.interval is None:
            raise ValueError("with markers a deviation has a value and an interval")
        name = found.definition.measure_id
        self.errors_mm.setdefault(name, []).append(1e3 * (found.value - truth_m))
        low_m, high_m = found.interval
        self.held.setdefault(name, []).append(low_m <= truth_m <= high_m)


def _truths(scene: BackScene, back: Back) -> dict[str, float]:
    """Return the measures of the skin over the spinous processes, between the true landmarks."""
    posed = scene.posed("posterior")
    axes = back.patient_from_camera @ scene.depth_from_world
    vp_m, left_m, right_m = (
        axes.apply(posed.landmarks[name]) for name in (C7, LEFT_PSIS, RIGHT_PSIS)
    )
    dm_m = (left_m + right_m) / 2.0
    midline_m: FloatArray = axes.apply(true_midline_m(scene, posed))
    low_m, high_m = max(dm_m[1], back.profile.bottom_m), min(vp_m[1], back.profile.top_m)
    y_m = np.arange(low_m, high_m, STEP_M)
    aside_m = np.interp(y_m, midline_m[::-1, 1], midline_m[::-1, 0]) - np.interp(
        y_m, [dm_m[1], vp_m[1]], [dm_m[0], vp_m[0]]
    )
    return {"BACK.DEVIATION.RMS": rms(aside_m), "BACK.DEVIATION.MAX": greatest(aside_m)}
