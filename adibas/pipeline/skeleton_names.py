"""Markers of a posture analysis get the names of landmarks, where the model is sure."""

from dataclasses import replace

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import RgbdCalibration
from adibas.data.markers import Marker
from adibas.measures.sight_plane import vertical_of
from adibas.skeleton.namer import Namer

UP = np.array([0.0, -1.0, 0.0])
OPPOSITE = 1e-6


def with_names(
    namer: Namer,
    markers: tuple[Marker, ...],
    view: str,
    calibration: RgbdCalibration,
    named_by_hand: frozenset[str] = frozenset(),
) -> tuple[Marker, ...]:
    """Return the markers with the names that the model is sure of, in their order.

    Parameters
    ----------
    namer : Namer
        See `adibas.pipeline.namers.namer_of`.
    markers : tuple of Marker
        Those without a position keep their labels.
    view : str
        As declared; empty: left and right only where the shape tells them.
    named_by_hand : frozenset of str
        Labels that stay; no other marker gets one of them.
    """
    placed = [marker for marker in markers if marker.position_m is not None]
    if not placed:
        return markers
    positions_m = np.stack(
        [marker.position_m for marker in placed if marker.position_m is not None]
    )
    upright_m = positions_m @ upright_turn(vertical_of(calibration).up).T
    found = namer.label(upright_m, view)
    names = {
        marker.label: name
        for marker, name in zip(placed, found.names, strict=True)
        if name is not None and name not in named_by_hand and marker.label not in named_by_hand
    }
    return tuple(replace(marker, label=names.get(marker.label, marker.label)) for marker in markers)


def upright_turn(up: FloatArray) -> FloatArray:
    """Return the smallest (3, 3) rotation that takes `up` to where the camera has it, against y."""
    axis = np.cross(up, UP)
    cos = float(up @ UP)
    if 1.0 + cos < OPPOSITE:  # upside down: about the line of sight
        return np.diag([-1.0, -1.0, 1.0])
    x, y, z = axis
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + across + across @ across / (1.0 + cos))
