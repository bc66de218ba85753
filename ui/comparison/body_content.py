"""What the page of the whole body shows; without Qt."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adibas.data.body_measures import BodyMeasure
from adibas.data.discs import Discs
from adibas.reports.body_numbers import GREY
from ui.widgets.space import Space

if TYPE_CHECKING:
    from adibas.pipeline.body import MeasuredBody
    from adibas.surface.merging import BodySurface

AHEAD = np.array([1.0, -1.0, -1.0])
"""From patient axes (right, up, back) to those of who stands behind: right, down, away."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenBody:
    """One body.

    Attributes
    ----------
    space : Space
        The joined surface, seen from behind.
    views : tuple of str
        What it is joined from.
    stature_mm : float or None
        To the crown; None where every view cuts the head off.
    apart_mm : float or None
        Root mean square distance between the views; None of a single one.
    landmarks_apart_mm : mapping
        Of landmarks that several views saw: how far they lie from their mean.
    measures : tuple of BodyMeasure
        Girths and volumes.
    """

    space: Space
    views: tuple[str, ...]
    stature_mm: float | None
    apart_mm: float | None
    landmarks_apart_mm: dict[str, float]
    measures: tuple[BodyMeasure, ...]


@dataclass(frozen=True, slots=True)
class Bodies:
    """The bodies of two sessions; None where one could not be joined, as a sentence says."""

    earlier: SeenBody | None = None
    later: SeenBody | None = None
    sentences: tuple[str, ...] = ()


def seen_body(body: "MeasuredBody") -> SeenBody:
    """Return what is shown of a body."""
    surface, joined = body.whole.surface, body.whole.joined
    space = Space(
        _discs_of(surface),
        {
            mark.name: np.mean(list(mark.places_m.values()), axis=0) * AHEAD
            for mark in body.landmarks
        },
    )
    return SeenBody(
        space,
        tuple(body.n_frames),
        None if body.stature_m is None else 1e3 * body.stature_m,
        None if joined is None else 1e3 * joined.rms_m,
        {mark.name: 1e3 * mark.apart_m for mark in body.landmarks if mark.apart_m is not None},
        body.girths,
    )


def _discs_of(surface: "BodySurface") -> Discs:
    """Return it as discs that leave no gap; grey where no colour is known."""
    from adibas.surface.covering import covering_radii_m

    return Discs(
        (surface.points_m * AHEAD).astype(np.float32),
        (surface.normals * AHEAD).astype(np.float32),
        covering_radii_m(surface.points_m),
        np.where(np.isnan(surface.colors), GREY, surface.colors).astype(np.uint8),
    )
