"""Whether the markers look like a patient who shows the side that was declared."""

import math

import numpy as np

from adibas.data.calibration import RgbdCalibration
from adibas.data.joints import JOINT_NAMES, other_side
from adibas.data.markers import Marker
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.skeleton_names import diameters_of, upright_turn
from adibas.skeleton.followed_view import off_view_rad
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.namer import Namer
from adibas.skeleton.told_heading import tells_axis, tells_heading
from adibas.texts import Message, message

LOOKS_OTHERWISE = message(
    "The markers look like a patient who shows the camera the opposite side than declared: "
    "left and right may be exchanged. Check the view."
)
LOOKS_ASIDE = message(
    "The markers look like a patient who is turned by a quarter from the declared view. Check the "
    "view."
)
ASIDE_RAD, OPPOSITE_RAD = math.radians(60.0), math.radians(120.0)
"""So far from the declared view another one is seen; patients may stand somewhat askew."""


def doubts_about_view(
    namer: Namer,
    markers: tuple[Marker, ...],
    view: str,
    calibration: RgbdCalibration,
    rotation_deg: int = 0,
) -> tuple[Message, ...]:
    """Return what must be known of the declared view, or nothing.

    The markers are named once more without being told the view: where the shape alone is sure of
    left and right, and most of the names that were given say the contrary, or where it is sure that
    somebody faces another way, the view is doubted. Only the 15 joints show which way that is.

    Parameters
    ----------
    markers : tuple of Marker
        With their names.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """
    placed = [marker for marker in markers if marker.position_m is not None]
    if not view or namer.names != JOINT_NAMES or not placed:
        return ()
    positions_m = np.stack([one.position_m for one in placed if one.position_m is not None])
    upright_m = positions_m @ upright_turn(vertical_of(calibration, rotation_deg).up).T
    untold = namer.label(upright_m, diameters_m=diameters_of(placed, calibration))
    contrary = alike = 0
    for marker, name in zip(placed, untold.names, strict=True):
        if name is not None and other_side(name) != name:
            contrary += marker.label == other_side(name)
            alike += marker.label == name
    if contrary > alike:
        return (LOOKS_OTHERWISE,)
    doubt = doubt_by_heading(untold, view)
    return () if doubt is None else (doubt,)


def doubt_by_heading(untold: Labelling, view: str) -> Message | None:
    """Return what must be known of the declared view, by how joints are named without it.

    None where no view was, or where they do not tell which way somebody faces, or tell that view.
    """
    if not view:
        return None
    off_rad = off_view_rad(untold.heading_rad, view)
    if tells_heading(untold) and off_rad > OPPOSITE_RAD:
        return LOOKS_OTHERWISE
    return LOOKS_ASIDE if ASIDE_RAD < off_rad < OPPOSITE_RAD and tells_axis(untold) else None
