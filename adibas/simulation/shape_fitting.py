"""Find the body model's parameters for a person of given stature and weight."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from adibas.arrays import Float32Array, FloatArray, Int32Array, UInt8Array
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.phenotype import PHENOTYPE_GRID, anny_age
from adibas.simulation.poses import standing
from adibas.simulation.skeleton import Skeleton, bone_turns
from adibas.simulation.skinning import skin

DENSITY_KG_PER_M3 = 985.0
"""Of a living body with air in the lungs: it just floats."""
STATURE_TOLERANCE_M = 0.0005
_PARAMETER_TOLERANCE = 1e-5
_AVERAGE = 0.5


class ShapeableModel(Protocol):
    """What a fit needs of a body model; see `adibas.simulation.body.BodyModel`."""

    @property
    def triangles(self) -> Int32Array:
        """(T, 3) vertex indices."""

    @property
    def bone_indices(self) -> UInt8Array:
        """(V, K): which bones move a vertex."""

    @property
    def bone_weights(self) -> Float32Array:
        """(V, K): by how much."""

    def evaluated(self, phenotype: FloatArray) -> tuple[FloatArray, Skeleton]:
        """Return (V, 3) rest vertices and the skeleton of a `PHENOTYPE_GRID` parameter vector."""


def fit_phenotype(model: ShapeableModel, shape: BodyShape) -> FloatArray:
    """Return the (6,) parameters in the order of `PHENOTYPE_GRID`.

    For each build the height parameter that gives the stature is found, and among these the
    build that gives the weight, or the nearest weight. With average muscle the model hardly
    changes its weight, so the muscle gives way where the weight asks for it and it was left open.

    Raises
    ------
    ValueError
        No height parameter gives the stature.
    """
    muscle = _AVERAGE if shape.muscle is None else shape.muscle

    def too_heavy_kg(muscle: float, weight: float) -> float:
        vertices_m, _ = model.evaluated(_at_stature(model, shape, muscle, weight))
        return DENSITY_KG_PER_M3 * volume_m3(vertices_m, model.triangles) - shape.weight_kg

    weight = _root_or_nearest(lambda value: too_heavy_kg(muscle, value))
    if shape.muscle is None and weight in (0.0, 1.0):
        sign = 1.0 if weight == 1.0 else -1.0
        slightness = _root_or_nearest(
            lambda value: sign * too_heavy_kg(_AVERAGE * (1 - value), weight)
        )
        muscle = _AVERAGE * (1 - slightness)
    found = _at_stature(model, shape, muscle, weight)
    reached_m = standing_stature_m(model, *model.evaluated(found))
    if abs(reached_m - shape.stature_m) > STATURE_TOLERANCE_M:
        raise ValueError(
            f"a {shape.sex} of {shape.age_years} years cannot be {shape.stature_m} m; "
            f"the nearest is {reached_m:.3f} m"
        )
    return found


def _at_stature(
    model: ShapeableModel, shape: BodyShape, muscle: float, weight: float
) -> FloatArray:
    """Return the parameters of that build at the wanted stature, or nearest to it."""

    def phenotype(height: float) -> FloatArray:
        values = {
            "gender": 0.0 if shape.sex == "male" else 1.0,
            "age": anny_age(shape.age_years),
            "muscle": muscle,
            "weight": weight,
            "height": height,
            "proportions": _AVERAGE,
        }
        return np.array([values[name] for name in PHENOTYPE_GRID])

    def too_tall_m(height: float) -> float:
        return standing_stature_m(model, *model.evaluated(phenotype(height))) - shape.stature_m

    return phenotype(_root_or_nearest(too_tall_m))


def standing_stature_m(model: ShapeableModel, vertices_m: FloatArray, skeleton: Skeleton) -> float:
    """Return the extent along the vertical of a body set into the standing pose, metres."""
    posed_m = np.empty_like(vertices_m)
    turns = bone_turns(skeleton, standing())
    skin(vertices_m, model.bone_indices, model.bone_weights, turns, posed_m)
    return float(np.ptp(posed_m[:, 1]))


def volume_m3(vertices_m: FloatArray, triangles: Int32Array) -> float:
    """Return the volume inside a closed mesh, cubic metres: the sum of signed tetrahedra."""
    a, b, c = (vertices_m[triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def _root_or_nearest(rising: Callable[[float], float]) -> float:
    """Return where a rising function of 0 ... 1 is zero, or the end where it is nearest to it."""
    if rising(0.0) >= 0.0:
        return 0.0
    if rising(1.0) <= 0.0:
        return 1.0
    return float(brentq(rising, 0.0, 1.0, xtol=_PARAMETER_TOLERANCE))
