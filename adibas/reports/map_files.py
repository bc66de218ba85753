"""A map as files that other programs read: PLY for the surface, TUM's format for the path."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from adibas.alignment.surfels import Surface
from adibas.clock import NS_PER_S
from adibas.data.sentence import Sentence
from adibas.files import written_whole
from adibas.pipeline.map_body import BodyMotion
from adibas.pipeline.mapping import MappedRecording
from adibas.texts import message

DIGITS = 4
ROW = np.dtype(
    [
        *((name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")),
        *((name, "u1") for name in ("red", "green", "blue")),
        ("radius", "<f4"),
        ("confidence", "<f4"),
    ]
)
TYPE_NAMES = {"f": "float", "u": "uchar"}


def write_ply(surface: Surface, path: Path) -> None:
    """Write a surface as binary PLY: points in metres, normals, colours, radii, confidences.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    rows = np.empty(len(surface.points_m), ROW)
    for names, columns in (
        (("x", "y", "z"), surface.points_m),
        (("nx", "ny", "nz"), surface.normals),
        (("red", "green", "blue"), surface.colors_rgb),
    ):
        for name, column in zip(names, columns.T, strict=True):
            rows[name] = column
    rows["radius"], rows["confidence"] = surface.radii_m, surface.confidences
    properties = [f"property {TYPE_NAMES[ROW[name].kind]} {name}" for name in ROW.names or ()]
    header = [
        *("ply", "format binary_little_endian 1.0", "comment metres; made by ADiBAS"),
        f"element vertex {len(rows)}",
        *properties,
        "end_header\n",
    ]
    with written_whole(path) as unfinished, unfinished.open("wb") as file:
        file.write("\n".join(header).encode("ascii"))
        file.write(rows.tobytes())


def write_trajectory(mapped: MappedRecording, path: Path) -> None:
    """Write the depth camera's path as TUM's tools read it: time, place, quaternion (x, y, z, w).

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    for time_ns, pose in zip(mapped.timestamps_ns.tolist(), mapped.world_from_camera, strict=True):
        turn = Rotation.from_matrix(pose.rotation).as_quat()
        numbers = " ".join(f"{value:.6f}" for value in (*pose.translation_m, *turn))
        lines.append(f"{time_ns // NS_PER_S}.{time_ns % NS_PER_S:09d} {numbers}")
    with written_whole(path) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="ascii")


def map_to_json(mapped: MappedRecording) -> dict[str, Any]:
    """Return the document of ``adibas map --json``."""
    return {
        "frames": mapped.n_frames,
        "placed": len(mapped.world_from_camera),
        "path_m": round(mapped.path_m, DIGITS),
        "key_frames": mapped.n_key_frames,
        "loops": mapped.n_loops,
        "wrong_loops": mapped.n_wrong_loops,
        "surfels": len(mapped.surface.points_m),
        "body": None if mapped.motion is None else _motion_to_json(mapped.motion),
        "notices": [notice.text for notice in mapped.notices],
    }


def motion_sentence(motion: BodyMotion) -> Sentence:
    """Say how a person was not rigid."""
    if motion.wandered_mm is None:
        return Sentence(
            message(
                "Single frames lie {residual} mm from the joined surface (root mean square, noise "
                "included; the worst {largest} mm). How far the body moved over the floor is not "
                "known: it was not seen from all around."
            ),
            {"residual": motion.residual_mm, "largest": motion.largest_mm},
        )
    return Sentence(
        message(
            "Single frames lie {residual} mm from the joined surface (root mean square, noise "
            "included; the worst {largest} mm); the middle of the body moved {wandered} mm over "
            "the floor."
        ),
        {
            "residual": motion.residual_mm,
            "largest": motion.largest_mm,
            "wandered": motion.wandered_mm,
        },
    )


def _motion_to_json(motion: BodyMotion) -> dict[str, Any]:
    return {
        "residual_mm": round(motion.residual_mm, DIGITS),
        "largest_mm": round(motion.largest_mm, DIGITS),
        "bands_mm": {name: round(value, DIGITS) for name, value in motion.bands_mm.items()},
        "wandered_mm": None if motion.wandered_mm is None else round(motion.wandered_mm, DIGITS),
    }
