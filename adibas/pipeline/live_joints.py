"""Which markers of a live frame are which joints, to be drawn: their places are taken roughly."""

from collections.abc import Mapping

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.data.markers import Marker
from adibas.errors import ProtocolError
from adibas.geometry.distortion import undistort_pixels
from adibas.markers.blobs import Blob, long_radius_px
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.live_frames import Naming
from adibas.pipeline.namers import namer_of
from adibas.pipeline.posture import Sight
from adibas.pipeline.seen_body import with_body
from adibas.pipeline.skeleton_names import with_names

ABOUT = 3.0
"""The depth about a marker is taken from so many of its radii, since its own may be missing."""
ROUGH_M = 0.01
"""A burst measures better than a glance."""


def joints_among(
    blobs: tuple[Blob, ...],
    sight: Sight,
    calibration: RgbdCalibration,
    naming: Naming,
    rotation_deg: int = 0,
) -> Mapping[str, tuple[float, float]]:
    """Return the pixel (u, v) of each joint that a marker surely marks.

    Parameters
    ----------
    blobs : tuple of Blob
        The markers in the colour image.
    sight : Sight
        Who wears them: where the body is tells which is which.
    calibration : RgbdCalibration
        With the colour camera.
    naming : Naming
        Nothing is named after a protocol whose landmarks nobody knows, or that is lost.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """
    try:
        protocol = find_protocol(naming.protocol)
    except ProtocolError:  # told where it is measured
        return {}
    namer = namer_of(protocol, naming.view)
    if calibration.color is None or namer is None:
        return {}
    markers = tuple(
        Marker(
            f"m{number}",
            blob.u,
            blob.v,
            long_radius_px(blob.radius_px, blob.axis_ratio),
            np.eye(2),
            position_m,
            ROUGH_M**2 * np.eye(3),
        )
        for number, blob in enumerate(blobs, 1)
        if (position_m := _place_m(blob, sight.registration.depth_m, calibration.color)) is not None
    )
    if 0 < len(markers) < len(JOINT_NAMES):  # of all of them places tell enough, and sooner
        namer = with_body(
            namer, sight.depth_m, naming.view, calibration, rotation_deg, sight.body.pixels
        )
    named = with_names(namer, markers, naming.view, calibration, rotation_deg=rotation_deg)
    return {one.label: (one.u, one.v) for one in named if one.label in JOINT_NAMES}


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
