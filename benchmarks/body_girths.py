"""Girths and volumes of simulated people against slices of their meshes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.body_measures import BodyMeasure
from adibas.data.joints import BODY_PART_NAMES
from adibas.pipeline.whole_body import WholeBody
from adibas.surface.girths import slice_measures
from adibas.surface.merging import BodySurface
from benchmarks.body_scenes import BackScene
from benchmarks.body_truth import mesh_samples
from benchmarks.table import Row

ARM_PARTS = ("_arm", "_hand")


@dataclass(slots=True)
class Girths:
    """What was measured so far.

    Attributes
    ----------
    errors : dict of str to list of float
        Shares of the truth, by measure.
    held : list of bool
        Whether the intervals hold the truth.
    n_unknown : int
        Measures without a value, where the truth has one.
    """

    errors: dict[str, list[float]] = field(default_factory=dict)
    held: list[bool] = field(default_factory=list)
    n_unknown: int = 0

    def add(self, scene: BackScene, whole: WholeBody, found: Sequence[BodyMeasure]) -> None:
        """Compare the measures of a body, whose posterior view is as the scene draws it."""
        axes = whole.patient_from_camera["posterior"] @ scene.depth_from_world
        truths = _true_girths(scene, axes.apply(scene.posed("posterior").vertices_m))
        for one in found:
            truth = truths.get(one.definition.measure_id)
            if truth is None:
                continue
            if one.value is None or one.interval is None:
                self.n_unknown += 1
                continue
            share = (one.value - truth) / truth
            self.errors.setdefault(one.definition.measure_id, []).append(share)
            self.held.append(one.interval[0] <= truth <= one.interval[1])

    def rows(self, told: str) -> Iterator[Row]:
        """Print what was found."""
        for name, shares in self.errors.items():
            error = 100.0 * float(np.sqrt(np.mean(np.square(shares))))
            worst = 100.0 * float(np.abs(shares).max())
            yield Row(f"{told}: {name} ({len(shares)}), rms", error, "%")
            yield Row("same, largest", worst, "%")
        share = 100.0 * float(np.mean(self.held))
        name = f"{told}: intervals of girths and volumes that hold the truth ({len(self.held)})"
        yield Row(name, share, "%", 95.0, "goal 93-97")
        yield Row("same: not measured", float(self.n_unknown), "")


def _true_girths(scene: BackScene, vertices_m: FloatArray) -> dict[str, float]:
    """Return girths and volumes by their ids: of slices of the mesh without arms, patient axes."""
    model = scene.patient.body.model
    arms = [number for number, part in enumerate(BODY_PART_NAMES) if part.endswith(ARM_PARTS)]
    triangles = model.triangles[~np.isin(model.triangle_parts, arms)]
    points_m, normals = mesh_samples(vertices_m, triangles)
    n = len(points_m)
    surface = BodySurface(points_m, normals, np.ones(n), np.ones(n), np.full((n, 3), np.nan))
    found = slice_measures(surface, float(vertices_m[:, 1].max()))
    return {one.definition.measure_id: one.value for one in found if one.value is not None}
