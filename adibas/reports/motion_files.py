"""Joints over time as C3D and TRC, which motion analysis programs open.

Both are in millimetres and have upright axes, see `upright_axes`. C3D: x to the right, y away from
the camera, z up. TRC, as OpenSim has it: x away from the camera, y up, z to the right.
"""

from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.data.movement import Movement
from adibas.errors import FileError, ReportError
from adibas.files import HALVES, whole_letters, written_whole
from adibas.geometry.angles import unit
from adibas.measures.sight_plane import to_the_right
from adibas.texts import message

MM_PER_M = 1000.0
TRC_FIELDS = (
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame"
    "\tOrigNumFrames"
)
MOST_C3D_FRAMES = 65_535
"""A C3D file counts its frames in 16 bits."""
NO_TEXT = message("it is no text")


def upright_axes(up: FloatArray) -> FloatArray:
    """Return (3, 3) rows of length 1: to the right, away from the camera, up.

    They are those of somebody who stands behind the camera and looks where it looks, however it is
    turned and tilted, as in the measures; where it looks straight down or up, the right is its
    picture's.
    """
    up = unit(np.asarray(up, float))
    right = to_the_right(up)
    if np.isnan(right).any():
        right = np.array([1.0, 0.0, 0.0])
    return np.stack([right, np.cross(up, right), up])


def write_c3d(movement: Movement, path: Path) -> None:
    """Write the fifteen joints; NaN where not seen.

    Raises
    ------
    ReportError
        There are more frames than the format counts.
    FileError
        The disk is full, or the folder cannot be written, or its name is no text.
    """
    import ezc3d

    if HALVES.search(str(path.parent)):  # the library takes text alone
        raise FileError(
            "{file} cannot be written: {reason}. Choose another folder, or close the program that "
            "uses it.",
            file=str(path.parent),
            reason=NO_TEXT,
        )

    n_frames = len(movement.times_s)
    if n_frames > MOST_C3D_FRAMES:
        raise ReportError(
            "A C3D file holds {most} frames at most, and this movement has {n}. Write TRC, or a "
            "part of the recording.",
            most=MOST_C3D_FRAMES,
            n=n_frames,
        )
    places_mm = MM_PER_M * movement.joints_m @ upright_axes(movement.up).T
    seen = np.isfinite(places_mm).all(axis=2).T
    points = np.ones((4, len(JOINT_NAMES), n_frames))
    points[:3] = np.moveaxis(places_mm, 2, 0).transpose(0, 2, 1)
    c3d = ezc3d.c3d()
    group = c3d["parameters"]["POINT"]
    group["UNITS"]["value"] = ["mm"]
    group["RATE"]["value"] = [_rate_hz(movement)]
    group["LABELS"]["value"] = list(JOINT_NAMES)
    group["DESCRIPTIONS"]["value"] = [movement.origin] * len(JOINT_NAMES)
    c3d.add_parameter("MANUFACTURER", "SOFTWARE", [f"ADiBAS {__version__}"])
    c3d["data"]["points"] = points
    c3d["data"]["meta_points"]["residuals"] = np.where(seen, 0.0, -1.0)[None]
    with written_whole(path) as unfinished:
        c3d.write(str(unfinished))


def write_trc(movement: Movement, path: Path) -> None:
    """Write the fifteen joints; NaN where not seen.

    An empty cell would do for programs that count the tabs. Those that split a line at any white
    space would take the next joint's place for it.

    The format has no place for where joints come from: the first line, which no program reads,
    says it after the name where they were found without markers.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    origin = " (markerless)" if movement.origin == "markerless" else ""
    right, away, up = upright_axes(movement.up)
    places_mm = MM_PER_M * movement.joints_m @ np.stack([away, up, right]).T
    rate = f"{_rate_hz(movement):.6g}"
    n_frames, n_joints = places_mm.shape[:2]
    head = [
        f"PathFileType\t4\t(X/Y/Z)\t{whole_letters(path.name)}{origin}",
        TRC_FIELDS,
        f"{rate}\t{rate}\t{n_frames}\t{n_joints}\tmm\t{rate}\t1\t{n_frames}",
        "Frame#\tTime\t" + "\t\t\t".join(JOINT_NAMES) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{k}" for k in range(1, n_joints + 1) for axis in "XYZ"),
        "",
    ]
    rows = [
        f"{number}\t{time_s:.6f}\t" + "\t".join(_cell(value) for value in frame)
        for number, (time_s, frame) in enumerate(
            zip(movement.times_s, places_mm.reshape(n_frames, -1).tolist(), strict=True), 1
        )
    ]
    with written_whole(path) as unfinished:
        unfinished.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")


def _cell(value: float) -> str:
    return "NaN" if np.isnan(value) else f"{value:.4f}"


def _rate_hz(movement: Movement) -> float:
    return movement.rate_hz if np.isfinite(movement.rate_hz) else 1.0
