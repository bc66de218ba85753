"""Markers of a posture analysis get the names of landmarks, where the model is sure."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.markers import AutomaticName, Marker, pixels_uv
from adibas.data.posture import Provenance
from adibas.geometry.distortion import undistort_pixels
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.seen_spaces import seen_spaces
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.namer import Namer
from adibas.skeleton.seen_space import SeenSpace

Names: TypeAlias = tuple[str | None, ...]

UP = np.array([0.0, -1.0, 0.0])
OPPOSITE = 1e-6
CONFIRMED = 0.9
"""How sure a name is of which the placed markers alone are not."""
TOLD = ("source", "version", "created_utc")
"""What a report says of the model that named."""


def with_names(
    namer: Namer,
    markers: tuple[Marker, ...],
    view: str,
    calibration: RgbdCalibration,
    named_by_hand: frozenset[str] = frozenset(),
    rotation_deg: int = 0,
) -> tuple[Marker, ...]:
    """Return the markers with the names that the model is sure of, in their order.

    Parameters
    ----------
    namer : Namer
        See `adibas.pipeline.namers.namer_of`.
    markers : tuple of Marker
        Those without a position are named as if they were where the depth about them says roughly,
        or as far away as the others where it says nothing; they get no name that another marker
        has.
    view : str
        As declared; empty: left and right only where the shape tells them.
    named_by_hand : frozenset of str
        Labels that stay; no other marker gets one of them. Names agree with them: where the model
        was not sure they decide, and where it was sure of another name a marker gets none.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.

    Returns
    -------
    markers : tuple of Marker
        Those that got a name tell from which model, and how sure it is.
    """
    placed = tuple(marker for marker in markers if marker.position_m is not None)
    if not placed:
        return markers
    turn = upright_turn(vertical_of(calibration, rotation_deg).up)
    positions_m = np.stack([one.position_m for one in placed if one.position_m is not None])
    diameters_m = diameters_of(placed, calibration)
    given = [_given(one, named_by_hand) for one in placed]
    in_color, in_both = (space.turned(turn) for space in seen_spaces(calibration))
    alone = _labelled(namer, positions_m @ turn.T, view, diameters_m, given, in_both)
    found, sure = alone.names, alone.confidences
    flat, flat_m = _roughly_placed(markers, positions_m, calibration)
    if flat:
        known_m = np.append(diameters_m, np.full(len(flat), np.nan))
        given += [_given(one, named_by_hand) for one in flat]
        places_m = np.vstack([positions_m, flat_m]) @ turn.T
        together = _labelled(namer, places_m, view, known_m, given, in_color)
        found = _agreed(alone, together)
        is_confirmed = np.array([name is None for name in alone.names])
        of_placed = np.where(is_confirmed, together.confidences[: len(placed)], sure)
        sure = np.concatenate([of_placed, together.confidences[len(placed) :]])
    names: dict[str, tuple[str, float]] = {}
    for marker, name, confidence in zip((*placed, *flat), found, sure.tolist(), strict=True):
        taken = named_by_hand | {given for given, _confidence in names.values()}
        if name is not None and name not in taken and marker.label not in named_by_hand:
            names[marker.label] = name, confidence
    return tuple(_named(marker, names.get(marker.label), namer.identity) for marker in markers)


def _given(marker: Marker, named_by_hand: frozenset[str]) -> str:
    """Return the name that a hand gave a marker; empty where none did."""
    return marker.label if marker.label in named_by_hand else ""


def _labelled(
    namer: Namer,
    points_m: FloatArray,
    view: str,
    diameters_m: FloatArray,
    given: Sequence[str],
    seen: SeenSpace,
) -> Labelling:
    """Return the naming that agrees with the given names, as far as it is none against a sure one.

    A hand errs, too: its error must not become a second one.
    """
    still = namer.holding_still()
    free = still.label(points_m, view, diameters_m, seen=seen)
    if not any(given):
        return free
    told = still.label(points_m, view, diameters_m, given, seen)
    names = tuple(
        name if other in (None, name) else None
        for name, other in zip(told.names, free.names, strict=True)
    )
    return replace(told, names=names)


def with_namer(provenance: Provenance, namer: Namer | None) -> Provenance:
    """Return the provenance with the model that named the markers; None: there was none.

    It tells as well whether the namer knew the body that the depth shows.
    """
    if namer is None:
        return provenance
    told = {key: namer.provenance[key] for key in TOLD if key in namer.provenance}
    names = {"model": namer.identity, **told, "knew_body": namer.knows_body}
    return replace(provenance, parameters={**provenance.parameters, "names": names})


def _named(marker: Marker, found: tuple[str, float] | None, model: str) -> Marker:
    if found is None:
        return marker
    name, confidence = found
    return replace(marker, label=name, named_by=AutomaticName(model, confidence))


def _agreed(alone: Labelling, together: Labelling) -> Names:
    """Return the names of the placed markers and those of the others, told once without these.

    Where the two contradict each other about a placed marker, the points can be read in two ways:
    it gets no name, and neither do those whose places are guessed. Where too few are placed to be
    sure of one, its name is what is most probable among them and sure among all.
    """
    n_placed = len(alone.names)
    again, more = together.names[:n_placed], together.names[n_placed:]
    told = zip(alone.names, alone.guesses, again, together.confidences, strict=False)
    confirmed = [
        name or (other if guess == other and confidence >= CONFIRMED else None)
        for name, guess, other, confidence in told
    ]
    agreed = tuple(
        one if other in (None, one) else None for one, other in zip(confirmed, again, strict=True)
    )
    is_contradicted = any(
        None not in (one, other) and one != other
        for one, other in zip(alone.names, again, strict=True)
    )
    return (*agreed, *((None,) * len(more) if is_contradicted else more))


def diameters_of(placed: Sequence[Marker], calibration: RgbdCalibration) -> FloatArray:
    """Return the (N,) diameters in metres of markers with a position; NaN without a camera."""
    if calibration.color is None:
        return np.full(len(placed), np.nan)
    radii_px = np.array([one.radius_px for one in placed])
    depths_m = np.array([one.position_m[2] for one in placed if one.position_m is not None])
    return diameters_in_m(radii_px, depths_m, calibration.color)


def diameters_in_m(
    radii_px: FloatArray, depths_m: FloatArray, camera: CameraCalibration
) -> FloatArray:
    """Return the diameters in metres of discs that are so large in a camera's picture."""
    return np.asarray(2.0 * radii_px * depths_m / camera.intrinsics.fx)


def _roughly_placed(
    markers: Sequence[Marker], positions_m: FloatArray, calibration: RgbdCalibration
) -> tuple[tuple[Marker, ...], FloatArray]:
    """Return the markers without a position, and rough (N, 3) places by their pixels.

    Those whose depth is not known roughly are taken to be as far away as the others; those at
    pixels that the camera's model of distortion does not reach are left out.
    """
    flat = tuple(marker for marker in markers if marker.position_m is None)
    if not flat or calibration.color is None:
        return (), np.empty((0, 3))
    camera = calibration.color
    rays = undistort_pixels(pixels_uv(flat), camera.intrinsics, camera.distortion)
    is_known = np.asarray(np.isfinite(rays).all(axis=1))
    usual_m = float(np.median(positions_m[:, 2]))
    depths_m = [usual_m if one.rough_depth_m is None else one.rough_depth_m for one in flat]
    places_m = np.array(depths_m)[:, None] * np.column_stack([rays, np.ones(len(rays))])
    return tuple(one for one, known in zip(flat, is_known, strict=True) if known), places_m[
        is_known
    ]


def upright_turn(up: FloatArray) -> FloatArray:
    """Return the smallest (3, 3) rotation that takes `up` to where the camera has it, against y."""
    axis = np.cross(up, UP)
    cos = float(up @ UP)
    if 1.0 + cos < OPPOSITE:  # upside down: about the line of sight
        return np.diag([-1.0, -1.0, 1.0])
    x, y, z = axis
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + across + across @ across / (1.0 + cos))
