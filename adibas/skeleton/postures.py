"""Which posture of a model a set of points is nearest to, before any of them has a name.

Source: thesis, section 6.1.2.1: the class of the known shape that is nearest by shape distance.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.shapes.shape_context import nearest_shape
from adibas.skeleton.model import PointModel
from adibas.skeleton.starts import turn_back

IN_PICTURE = 2


@dataclass(frozen=True, slots=True)
class NearestPosture:
    """What a set of points looks like.

    Attributes
    ----------
    kind : str
        What the nearest prototype's shapes were called in the training; may be empty.
    distance : float
        Shape distance; infinite where there are too few points to compare.
    """

    kind: str
    distance: float


def nearest_posture(
    model: PointModel, points_m: FloatArray, heading_rad: float = math.nan
) -> NearestPosture:
    """Compare points with the mean of each prototype, as both are seen from the front.

    Parameters
    ----------
    points_m : (M, D) array
        In metres, y down, of as many dimensions as the model.
    heading_rad : float
        Of the patient, in space; NaN: facing the camera.
    """
    seen = points_m
    if points_m.shape[1] > IN_PICTURE and math.isfinite(heading_rad):
        seen = points_m @ turn_back(heading_rad).T
    known = [_seen(prototype.mean) for prototype in model.prototypes]
    best, distance = nearest_shape(_seen(seen), known)
    kind = model.prototypes[best].kind if math.isfinite(distance) else ""
    return NearestPosture(kind, distance)


def _seen(points: FloatArray) -> FloatArray:
    return np.ascontiguousarray(points[:, :IN_PICTURE])
