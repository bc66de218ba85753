"""Both values of the measures of one kind: in the plane, and in space."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.protocol_measures import Estimate
from adibas.data.protocols import KINDS, VIEW_AXES, MeasureDefinition, Protocol
from adibas.geometry.uncertainty import UncertainValues, uncertain_angles, uncertain_distances
from adibas.measures.kind_values import PROJECTED, SPATIAL, SUMS, Value
from adibas.measures.propagation import Function, Inputs, first_order, folded, sum_of_sizes
from adibas.measures.sight_plane import Vertical, axis_along

Estimates = list[Estimate | None]

ONLY_PROJECTED = ("offset", "offset_share", "side_share", "trunk_symmetry")
"""Kinds that have no value in space (docs/protocols.md says why)."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacedLandmarks:
    """The landmarks that have a place.

    Attributes
    ----------
    names : tuple of str
        Ids of landmarks that are marked.
    positions_m : (N, 3) array
        In the colour camera's axes.
    covariance_m2 : (3N, 3N) array
        Joint one.
    """

    names: tuple[str, ...]
    positions_m: FloatArray
    covariance_m2: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Sightline:
    """What the plane of the projected values is made of.

    Attributes
    ----------
    view : str
        Of `VIEWS`.
    vertical : Vertical
        Up.
    across : tuple of two str
        Landmarks between which the plane's level direction goes, from right to left or from back
        to front; empty for the sensor's plane.
    is_sideways : bool
        Whether it goes from right to left.
    """

    view: str
    vertical: Vertical
    across: tuple[str, ...] = ()
    is_sideways: bool = True


class Measurer:
    """Measures definitions of one kind together, since a protocol may have thousands."""

    def __init__(self, protocol: Protocol, placed: PlacedLandmarks, sight: Sightline) -> None:
        self._protocol = protocol
        self._placed = placed
        self._sight = sight
        self._at = {name: place for place, name in enumerate(placed.names)}

    def projected(self, definitions: Sequence[MeasureDefinition]) -> Estimates:
        """Return the values in the plane; None where points coincide.

        Parameters
        ----------
        definitions : sequence of MeasureDefinition
            Of one kind and one axis, whose landmarks all have a place; one at least.
        """
        kind = definitions[0].kind
        if kind in SUMS:
            return sum_of_sizes(*self._moving(SUMS[kind], definitions))
        found = self._first_order(PROJECTED[kind], definitions)
        return [folded(one) for one in found] if kind == "angle" else found

    def spatial(self, definitions: Sequence[MeasureDefinition]) -> Estimates:
        """Return the values in space; None where there is none, or points coincide."""
        kind = definitions[0].kind
        if kind in SPATIAL:
            return self._first_order(SPATIAL[kind], definitions)
        if kind in ONLY_PROJECTED:
            return [None] * len(definitions)
        points_m, covariances_m2 = self._points(definitions, ())
        if kind == "distance":
            return _estimates(uncertain_distances(points_m, covariances_m2))
        if kind == "line_to_line":
            points_m, covariances_m2 = _as_arms(points_m, covariances_m2)
        if kind == "line_to_vertical":
            points_m, covariances_m2 = self._beside_up(points_m, covariances_m2)
        angles = _estimates(uncertain_angles(points_m, covariances_m2))
        if kind == "deviation_from_straight":
            return [None if angle is None else _complement(angle) for angle in angles]
        return angles

    def _first_order(self, value: Value, definitions: Sequence[MeasureDefinition]) -> Estimates:
        is_angle = KINDS[definitions[0].kind].quantity == "angle"
        return first_order(*self._moving(value, definitions), is_angle=is_angle)

    def _moving(
        self, value: Value, definitions: Sequence[MeasureDefinition]
    ) -> tuple[Function, Inputs]:
        """Return a value as a function of points and tilts of the vertical, and its inputs."""
        sight, n_own = self._sight, len(definitions[0].points)
        axis = definitions[0].axis or VIEW_AXES[sight.view][0]
        points_m, covariances_m2 = self._points(definitions, sight.across)

        def of(moved_m: FloatArray, tilts_rad: FloatArray) -> FloatArray:
            up = sight.vertical.tilted(tilts_rad)
            across_m = None
            if sight.across:
                across_m = moved_m[..., n_own + 1, :] - moved_m[..., n_own, :]
            direction = axis_along(axis, sight.view, up, across_m, is_sideways=sight.is_sideways)
            return value(moved_m[..., :n_own, :], (direction, up))

        return of, Inputs(points_m, covariances_m2, sight.vertical.sd_rad)

    def _points(
        self, definitions: Sequence[MeasureDefinition], across: tuple[str, ...]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the (M, n, 3) points and the (M, 3n, 3n) covariances."""
        shares = np.zeros(
            (len(definitions), len(definitions[0].points) + len(across), len(self._placed.names))
        )
        for row, definition in zip(shares, definitions, strict=True):
            for name, weights in self._protocol.shares_of(definition.points).items():
                row[: len(weights), self._at[name]] = weights
            for place, name in enumerate(across, len(definition.points)):
                row[place, self._at[name]] = 1.0
        points_m = shares @ self._placed.positions_m
        spread = np.kron(shares, np.eye(3))
        return points_m, spread @ self._placed.covariance_m2 @ spread.swapaxes(1, 2)

    def _beside_up(
        self, points_m: FloatArray, covariances_m2: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the line, a vertex, and the vertical as the three points of an angle."""
        join = np.kron([[1.0, -1.0], [0.0, 0.0], [0.0, 0.0]], np.eye(3))
        covariances_m2 = join @ covariances_m2 @ join.T
        covariances_m2[:, 6:, 6:] += self._sight.vertical.covariance
        corners_m = np.zeros((len(points_m), 3, 3))
        corners_m[:, 0] = points_m[:, 0] - points_m[:, 1]
        corners_m[:, 2] = self._sight.vertical.up
        return corners_m, covariances_m2


def _as_arms(points_m: FloatArray, covariances_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two lines as the arms of one angle."""
    join = np.array([[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.0]])
    spread = np.kron(join, np.eye(3))
    return join @ points_m, spread @ covariances_m2 @ spread.T


def _estimates(found: UncertainValues) -> Estimates:
    return [
        Estimate(value, (low, high)) if np.isfinite([value, low, high]).all() else None
        for value, (low, high) in zip(found.values.tolist(), found.intervals.tolist(), strict=True)
    ]


def _complement(angle: Estimate) -> Estimate:
    low, high = angle.interval
    return Estimate(np.pi - angle.value, (np.pi - high, np.pi - low))
