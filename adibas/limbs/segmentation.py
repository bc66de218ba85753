"""From the depth of a person to limbs: forest, then graph cut on the person's pixels alone.

Source: thesis, section 6.2.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import cv2
import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, FloatArray, check_shape
from adibas.data.limbs import NO_LABEL, LimbParts
from adibas.graphcut.boundary import boundary_weights
from adibas.graphcut.energy import EnergyParams, equal_penalties, label_energy
from adibas.graphcut.in_time import follow, ties_in_time
from adibas.graphcut.minimising import minimise
from adibas.graphcut.neighbors import Connectivity, connect_pixels
from adibas.limbs.cells import PersonView
from adibas.limbs.context import limb_probabilities
from adibas.limbs.filling_kernels import filled_between
from adibas.limbs.model import LimbModel

Cut: TypeAlias = Literal["omega_1", "omega_2", "none"]


@dataclass(frozen=True, slots=True)
class LimbParams:
    """How limbs are segmented; the defaults are the live ones.

    Attributes
    ----------
    cut : str
        ``omega_1`` (alpha-expansion), ``omega_2`` (alpha-beta swap), or ``none``: the likeliest
        label of the forest.
    smoothness : float
        Lambda. The thesis has 50; 1 is right more often (see ``docs/limbs.md``).
    over_time : float
        Lambda of the ties to the frame before, where one is given; 0: none.
    connectivity : 4 or 8
    step : int
        Of how many rows and columns one is looked at; the pixels between take the label of the
        nearest one. 2 is a quarter of the work.
    is_from_behind : bool
        The person's back is seen: left and right are swapped.
    """

    cut: Cut = "omega_1"
    smoothness: float = 1.0
    over_time: float = 0.0
    connectivity: Connectivity = 8
    step: int = 2
    is_from_behind: bool = False

    def __post_init__(self) -> None:
        if self.step < 1:
            raise ValueError(f"step must be positive, got {self.step}")
        if not self.over_time >= 0.0:
            raise ValueError(f"over_time must not be negative, got {self.over_time}")


@dataclass(frozen=True, slots=True, eq=False)
class FrameBefore:
    """What was found one frame before: each pixel is tied to itself.

    Attributes
    ----------
    depth_m : (H, W) array
        NaN where not measured.
    parts : LimbParts
    """

    depth_m: Float32Array
    parts: LimbParts


def segment(
    depth_m: Float32Array,
    mask: BoolArray,
    focal_px: float,
    model: LimbModel,
    params: LimbParams | None = None,
    before: FrameBefore | None = None,
) -> LimbParts:
    """Find the limbs of one person.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Metres; NaN where not measured.
    mask : (H, W) bool array
        The person's pixels; may be empty.
    focal_px : float
        Of the camera that took `depth_m`, pixels: any resolution and field of view will do.
    model : LimbModel
    params : LimbParams or None
    before : FrameBefore or None
        Of the same camera; counts with ``over_time``.

    Returns
    -------
    LimbParts
        Pixels of the mask without depth have even probabilities, and the label that their
        neighbours suggest.
    """
    params = params or LimbParams()
    check_shape("mask", mask, depth_m.shape)
    every = np.s_[:: params.step, :: params.step]
    pixels = np.zeros_like(mask)
    pixels[every] = mask[every]
    last = None
    if before is not None and params.over_time > 0.0:
        last = _tied(before, depth_m, pixels, params)
    box = _looked_at(mask, params.step)
    view = PersonView(depth_m[box], mask[box], pixels[box], focal_px, params.step)
    probabilities = limb_probabilities(view, model)
    n_limbs = len(model.labels)
    chosen = np.full(mask.shape, NO_LABEL, np.int16)
    chosen[box] = _chosen(view, probabilities, model, params, last)
    chosen[chosen >= n_limbs] = NO_LABEL
    limbs = np.ascontiguousarray(probabilities[:, :n_limbs])
    parts = LimbParts(model.labels, pixels, limbs, chosen)
    return parts.with_sides_swapped() if params.is_from_behind else parts


def _looked_at(mask: BoolArray, step: int) -> tuple[slice, slice]:
    """Return the box about a mask, from a row and a column on that are looked at.

    A person fills an eighth of the image or so: all else would be searched for nothing.
    """
    left, top, width, height = cv2.boundingRect(np.ascontiguousarray(mask).view(np.uint8))
    first_row, first_column = top - top % step, left - left % step
    return slice(first_row, top + height + step), slice(first_column, left + width + step)


def _chosen(
    view: PersonView,
    probabilities: Float32Array,
    model: LimbModel,
    params: LimbParams,
    last: tuple[AnyArray, FloatArray] | None,
) -> AnyArray:
    """Return the (H, W) labels of a view whose first pixel is looked at, clutter among them."""
    every = np.s_[:: params.step, :: params.step]
    mask = np.ascontiguousarray(view.mask[every])
    thin = np.full(mask.shape, NO_LABEL, np.int16)
    thin[mask] = cut_labels(view.depth_m[every], mask, probabilities, model, params, last)
    if params.step == 1:
        return thin
    return filled_between(thin, np.ascontiguousarray(view.mask), params.step)


def cut_labels(
    picture: AnyArray,
    mask: BoolArray,
    probabilities: Float32Array,
    model: LimbModel,
    params: LimbParams,
    last: tuple[AnyArray, FloatArray] | None = None,
) -> AnyArray:
    """Return the (N,) labels of the forest at the mask's pixels, clutter among them.

    Parameters
    ----------
    picture : (H, W) or (H, W, C) array
        Depth, colour or both: where it changes, labels may.
    mask : (H, W) bool array
        N pixels.
    probabilities : (N, K) float32 array
        Of the forest's labels.
    model : LimbModel
        For its table.
    params : LimbParams
    last : (labels, weights) or None
        (N,) labels of the frame before, -1 where there was none, and how much each counts.
    """
    if params.cut == "none" or not len(probabilities):
        return np.asarray(probabilities.argmax(axis=1))
    n_labels = probabilities.shape[1]
    penalties = model.omega_2 if params.cut == "omega_2" else equal_penalties(n_labels)
    graph = connect_pixels(mask, params.connectivity)
    boundary = boundary_weights(graph, picture)
    weighing = EnergyParams(params.smoothness)
    energy = label_energy(graph, probabilities, boundary, penalties, weighing)
    if last is not None:
        labels, weights = last
        energy = follow(energy, labels, params.over_time * weighing.units_per_nat * weights)
    return minimise(energy).labels


def _tied(
    before: FrameBefore, depth_m: Float32Array, pixels: BoolArray, params: LimbParams
) -> tuple[AnyArray, FloatArray]:
    """Return the labels of the pixels one frame before, as the forest calls them, and ties."""
    check_shape("before.depth_m", before.depth_m, depth_m.shape)
    parts = before.parts.with_sides_swapped() if params.is_from_behind else before.parts
    return parts.chosen[pixels], ties_in_time(depth_m[pixels], before.depth_m[pixels])
