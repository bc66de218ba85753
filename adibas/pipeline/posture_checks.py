"""What else a burst shows, so that no number looks right and is not: other people, other spots."""

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.body.people import find_people
from adibas.data.calibration import CameraCalibration
from adibas.data.markers import Marker, RejectedBlob
from adibas.data.masks import BodyMask
from adibas.geometry.planes import Plane
from adibas.markers.burst import BurstMarker
from adibas.markers.detection import Detections
from adibas.markers.merged import MERGED, MergedParams, are_merged
from adibas.markers.position import PositionFinder
from adibas.texts import message

BESIDE = message("not on the patient")
GAP = message("faint, and between two surfaces, as a gap between fingers is")
NOT_COUNTED = message("Not counted as a marker ({n}): {reason}.")
SMALL = 0.85
"""Of the median size: eleven of twelve true stickers measure more (see `skeleton.sizes`)."""
OWN_SHARE = 0.5
"""Of a piece's pixels that the body has, too: from there on it is no other person."""
MOST_BESIDE = 10
"""Spots beside the patient that are told, the surest ones: a wall may be full of them."""


def count_people(
    depth_m: Float32Array, depth_camera: CameraCalibration, floor: Plane | None, body: BodyMask
) -> int:
    """Return how many people a depth image shows; the pieces of `body` are one person."""
    others = (one.pixels for one in find_people(depth_m, depth_camera, floor))
    return 1 + sum(float(body.pixels[pixels].mean()) < OWN_SHARE for pixels in others)


def refuse_beside(
    seen: Detections, markers: Sequence[Marker], greatest_share: float
) -> tuple[RejectedBlob, ...]:
    """Return what looks like a marker and is on nobody.

    Parameters
    ----------
    seen : Detections
        In the picture without the patient.
    markers : sequence of Marker
        Whose own rims are no spots of their own.
    greatest_share : float
        Where more of the picture than that looks so, nothing is told: it is a wall.
    """
    if seen.matched_share > greatest_share:
        return ()
    spots = [
        blob
        for blob in sorted(seen.blobs, key=lambda blob: -blob.separation)
        if all(
            math.dist((blob.u, blob.v), (one.u, one.v)) > 2.0 * one.radius_px + blob.radius_px
            for one in markers
        )
    ]
    return tuple(RejectedBlob(one.u, one.v, BESIDE) for one in spots[:MOST_BESIDE])


class Spot(Protocol):
    """How a marker looks."""

    @property
    def radius_px(self) -> float:
        """Of the disc with its area."""
        ...

    @property
    def axis_ratio(self) -> float:
        """Short over long axis."""
        ...


def are_two_in_one(
    spots: Sequence[Spot],
    depths_m: FloatArray,
    focal_px: float,
    params: MergedParams | None = None,
) -> BoolArray:
    """Say of each spot of the colour picture whether it is two markers.

    Parameters
    ----------
    depths_m : (N,) array
        Of the spots, colour camera; NaN where not known.
    focal_px : float
        Of the colour camera.
    """
    radii_m = np.array([one.radius_px for one in spots]) * depths_m / focal_px
    return are_merged(radii_m, np.array([one.axis_ratio for one in spots]), params)


def are_gaps(
    found: Sequence[BurstMarker], markers: Sequence[Marker], finder: PositionFinder
) -> BoolArray:
    """Say of each spot whether it is more likely a gap between fingers than a marker at an outline.

    A marker lies on skin: what is too faint to have the marker's colour, and smaller than the
    others, and has no skin of its own but several surfaces about it, has nothing that speaks for
    it.

    Parameters
    ----------
    found, markers : sequence
        The same ones: as they look, and where they are.
    finder : PositionFinder
        That measured them.
    """
    is_small = _are_small(found, markers)
    return np.array(
        [
            look.is_faint
            and small
            and marker.position_m is None
            and finder.is_between_surfaces(np.array([look.u, look.v]))
            for look, marker, small in zip(found, markers, is_small, strict=True)
        ],
        np.bool_,
    )


def _are_small(found: Sequence[BurstMarker], markers: Sequence[Marker]) -> BoolArray:
    """Say of each spot whether its area is less than of most; False where nothing says how far."""
    depths_m = _depths_m(markers)
    rough_m = np.array([one.rough_depth_m for one in markers], float)  # None becomes NaN
    sizes = np.array([one.radius_px for one in found]) * np.fmax(depths_m, rough_m)
    known = sizes[np.isfinite(sizes)]
    if not len(known):
        return np.zeros(len(markers), np.bool_)
    return np.asarray(sizes < SMALL * np.median(known), np.bool_)


def _depths_m(markers: Sequence[Marker]) -> FloatArray:
    """Return the (N,) depths of markers, colour camera; NaN of those without a position."""
    return np.array([np.nan if one.position_m is None else one.position_m[2] for one in markers])


def apart_from_others(
    found: Sequence[BurstMarker], markers: Sequence[Marker], is_gap: BoolArray, focal_px: float
) -> tuple[tuple[Marker, ...], tuple[RejectedBlob, ...]]:
    """Return the markers that are one each, and what is two in one or a gap.

    Parameters
    ----------
    found, markers : sequence
        The same ones: as they look, and where they are.
    is_gap : (N,) bool array
        See `are_gaps`.
    focal_px : float
        Of the colour camera.
    """
    is_merged = are_two_in_one(found, _depths_m(markers), focal_px)
    kept = tuple(one for one, out in zip(markers, is_merged | is_gap, strict=True) if not out)
    refused = tuple(
        RejectedBlob(one.u, one.v, GAP if gap else MERGED)
        for one, gap, merged in zip(markers, is_gap, is_merged, strict=True)
        if gap or merged
    )
    return kept, refused
