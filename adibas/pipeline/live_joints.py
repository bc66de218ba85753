"""Which markers of live frames are which joints, to be drawn: their places are taken roughly."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.errors import ProtocolError
from adibas.geometry.distortion import undistort_pixels
from adibas.markers.blobs import Blob, long_radius_px
from adibas.measures.protocol_store import find_protocol
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.live_frames import Naming
from adibas.pipeline.namers import namer_of
from adibas.pipeline.posture import Sight
from adibas.pipeline.seen_body import with_body
from adibas.pipeline.seen_spaces import seen_spaces
from adibas.pipeline.skeleton_names import diameters_in_m, upright_turn
from adibas.pipeline.view_check import doubt_by_heading
from adibas.skeleton.namer import Namer
from adibas.skeleton.tracking import NamesSoFar
from adibas.texts import Message

ABOUT = 3.0
"""The depth about a marker is taken from so many of its radii, since its own may be missing."""
CHECK_S = 2.0
"""So often it is asked whether the patient shows the declared side."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedNow:
    """What the markers of one frame are.

    Attributes
    ----------
    joints : dict
        Pixel (u, v) of each joint that a marker surely marks, by its name.
    doubts : tuple of Message
        What must be known of the declared view.
    """

    joints: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    doubts: tuple[Message, ...] = ()


class LiveNames:
    """Names the markers of one live frame after the other; for one thread.

    Parameters
    ----------
    calibration : RgbdCalibration
        With the colour camera.
    naming : Naming
        Nothing is named after a protocol whose landmarks nobody knows, or that is lost.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """

    def __init__(self, calibration: RgbdCalibration, naming: Naming, rotation_deg: int = 0) -> None:
        self._calibration, self._naming = calibration, naming
        self._rotation_deg = rotation_deg
        self._turn = upright_turn(vertical_of(calibration, rotation_deg).up)
        _in_color, in_both = seen_spaces(calibration)
        self._seen = in_both.turned(self._turn)
        self._namer: Namer | None = None
        self._names = NamesSoFar(())
        self._checked_s, self._doubts = -math.inf, tuple[Message, ...]()

    def among(self, blobs: tuple[Blob, ...], sight: Sight, time_s: float) -> NamedNow:
        """Return what markers are.

        Parameters
        ----------
        blobs : tuple of Blob
            The markers in the colour image.
        sight : Sight
            Who wears them: where the body is tells which is which.
        time_s : float
            Later than that of the frame before.
        """
        camera, namer = self._calibration.color, self._namer_now()
        if camera is None or namer is None:
            return NamedNow()
        placed = [
            (blob, place_m)
            for blob in blobs
            if (place_m := _place_m(blob, sight.registration.depth_m, camera)) is not None
        ]
        if not placed:
            return NamedNow()
        places_m = np.stack([place_m for _blob, place_m in placed])
        radii_px = np.array([long_radius_px(b.radius_px, b.axis_ratio) for b, _place in placed])
        diameters_m = diameters_in_m(radii_px, places_m[:, 2], camera)
        upright_m = places_m @ self._turn.T
        knowing = self._who_knows(namer, sight, len(placed))
        labelling = knowing.label(upright_m, self._naming.view, diameters_m, seen=self._seen)
        named = self._names.hear(upright_m, time_s, labelling)
        joints = {
            name: (blob.u, blob.v)
            for name, (blob, _place) in zip(named.names, placed, strict=True)
            if name in JOINT_NAMES
        }
        self._check_view(namer, upright_m, diameters_m, time_s)
        return NamedNow(joints, self._doubts)

    def _check_view(
        self, namer: Namer, upright_m: FloatArray, diameters_m: FloatArray, time_s: float
    ) -> None:
        """Ask now and then whether the markers show the declared side; only joints tell."""
        if namer.names != JOINT_NAMES or time_s < self._checked_s + CHECK_S:
            return
        self._checked_s = time_s
        untold = namer.label(upright_m, diameters_m=diameters_m, seen=self._seen)
        doubt = doubt_by_heading(untold, self._naming.view)
        self._doubts = () if doubt is None else (doubt,)

    def _who_knows(self, namer: Namer, sight: Sight, n_markers: int) -> Namer:
        """Return the namer who knows the body; of all markers places tell enough, and sooner."""
        if n_markers >= len(JOINT_NAMES):
            return namer
        return with_body(
            namer,
            sight.depth_m,
            self._naming.view,
            self._calibration,
            self._rotation_deg,
            sight.body.pixels,
        )

    def _namer_now(self) -> Namer | None:
        """Return who names; with another model than before all that was told is forgotten."""
        try:
            protocol = find_protocol(self._naming.protocol)
        except ProtocolError:  # told where it is measured
            return None
        namer = namer_of(protocol, self._naming.view)
        if namer is not self._namer:
            self._namer, self._names = namer, NamesSoFar(() if namer is None else namer.names)
            self._checked_s, self._doubts = -math.inf, ()
        return None if namer is None else namer.holding_still()


def _place_m(
    blob: Blob, depth_in_color_m: Float32Array, camera: CameraCalibration
) -> FloatArray | None:
    reach_px = round(ABOUT * blob.radius_px)
    u, v = round(blob.u), round(blob.v)
    about = depth_in_color_m[
        max(v - reach_px, 0) : v + reach_px + 1, max(u - reach_px, 0) : u + reach_px + 1
    ]
    seen = about[np.isfinite(about)]
    if not seen.size:
        return None
    x, y = undistort_pixels(np.array([blob.u, blob.v]), camera.intrinsics, camera.distortion)
    place_m = float(np.median(seen)) * np.array([x, y, 1.0])
    return place_m if np.isfinite(place_m).all() else None
