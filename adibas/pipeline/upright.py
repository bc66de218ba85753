"""Sensors on their side or their head: pictures are turned before people are found in them.

Forests, heads over shoulders, sides and fronts know people who stand upright in the picture. Depth,
camera and floor are turned by the quarters that bring up nearest to the picture's upper side, and
what was found is turned back into the depth camera's own axes and pixels.
"""

from dataclasses import replace

import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.limbs import LimbParts
from adibas.geometry.planes import Plane
from adibas.geometry.quarter_turns import QUARTERS, QuarterTurn
from adibas.measures.sight_plane import up_of_picture
from adibas.pipeline.pose_following import PersonNow, PoseNow
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.picture import Picture

LEAST_ACROSS = 0.25
"""Length of up in the picture's plane; less, and the camera looks down or up within 15 degrees."""


def turn_to_upright(calibration: RgbdCalibration, rotation_deg: int = 0) -> QuarterTurn:
    """Return the turn after which people stand upright in the depth camera's picture.

    Parameters
    ----------
    calibration : RgbdCalibration
        Its gravity, or else its floor, says where up is.
    rotation_deg : int
        By how much the picture is turned clockwise to be shown: what is gone by where neither is
        known, or where the camera looks straight down.
    """
    up = up_of_picture(rotation_deg)
    if calibration.gravity is not None:
        known = -calibration.gravity
    else:
        known = up if calibration.floor is None else calibration.floor.normal
    if np.hypot(known[0], known[1]) > LEAST_ACROSS:
        up = known
    turns = [QuarterTurn(n_quarters) for n_quarters in range(QUARTERS)]
    return min(turns, key=lambda turn: float(turn.points(up)[1]))


def turned_camera(camera: CameraCalibration, turn: QuarterTurn) -> CameraCalibration:
    """Return the camera that would take the turned pictures."""
    size = camera.height, camera.width
    height, width = turn.size(size)
    return CameraCalibration(
        width,
        height,
        turn.intrinsics(camera.intrinsics, size),
        turn.distortion(camera.distortion),
    )


def turned_floor(floor: Plane | None, turn: QuarterTurn) -> Plane | None:
    """Return the floor in the turned camera's axes; None where it is not known."""
    return None if floor is None else turn.plane(floor)


def turned_parts(parts: LimbParts, turn: QuarterTurn) -> LimbParts:
    """Return limbs in the pixels of the turned picture."""
    if turn.n_quarters == 0:
        return parts
    place = np.zeros(parts.pixels.shape, np.intp)
    place[parts.pixels] = np.arange(len(parts.probabilities))
    pixels = turn.picture(parts.pixels)
    return LimbParts(
        parts.labels,
        pixels,
        parts.probabilities[turn.picture(place)[pixels]],
        turn.picture(parts.chosen),
    )


def turned_joints(one: ChosenJoints, turn: QuarterTurn) -> ChosenJoints:
    """Return joints in the axes of the turned picture."""
    return replace(one, joints_m=turn.points(one.joints_m))


def turned_pose(now: PoseNow, turn: QuarterTurn) -> PoseNow:
    """Return everybody in the pixels and axes of the turned picture."""
    if turn.n_quarters == 0:
        return now
    return PoseNow(tuple(_turned_person(one, turn) for one in now.people), now.notices)


def _turned_person(one: PersonNow, turn: QuarterTurn) -> PersonNow:
    seen = one.picture
    size = seen.camera.height, seen.camera.width
    return PersonNow(
        one.person,
        turn.picture(one.pixels),
        turned_parts(one.parts, turn),
        turned_joints(one.joints, turn),
        turned_joints(one.raw, turn),
        Picture(
            turned_camera(seen.camera, turn), turn.box(seen.box, size), turn.edges(seen.is_cut)
        ),
    )
