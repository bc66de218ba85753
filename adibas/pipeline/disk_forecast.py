"""How long a disk will hold what a sensor gives."""

import math
import shutil
from pathlib import Path

from adibas.errors import FileError

DEPTH_BYTES_PER_PIXEL = 0.35
COLOR_BYTES_PER_PIXEL = 1.6
"""Of a frame without loss: a quarter more than the 0.27 and 1.3 of the simulator's plain rooms."""

RESERVED_BYTES = 512 * 1024 * 1024
"""Left for the database and for everything else on the disk."""


def expected_bytes_per_s(
    color_size: tuple[int, int], depth_size: tuple[int, int], frame_rate_hz: float
) -> float:
    """Return what a recording takes, before anything was recorded.

    Parameters
    ----------
    color_size, depth_size : (int, int)
        Pixels, in either order; (0, 0) where there is no such image.
    """
    color_bytes = COLOR_BYTES_PER_PIXEL * color_size[0] * color_size[1]
    depth_bytes = DEPTH_BYTES_PER_PIXEL * depth_size[0] * depth_size[1]
    return (color_bytes + depth_bytes) * frame_rate_hz


def minutes_left(free_bytes: int, bytes_per_s: float) -> float:
    """Return how many minutes of recording fit; 0 where nothing does, inf where nothing comes."""
    usable = max(0, free_bytes - RESERVED_BYTES)
    if bytes_per_s <= 0:
        return math.inf
    return usable / bytes_per_s / 60.0


def free_bytes(folder: Path) -> int:
    """Return what is free on the disk of a folder, which need not exist yet.

    Raises
    ------
    FileError
        The disk cannot be asked.
    """
    try:
        existing = next((place for place in (folder, *folder.parents) if place.exists()), folder)
        return shutil.disk_usage(existing).free
    except OSError as error:
        raise FileError(
            "{folder} cannot be reached: {reason}. Check the disk.",
            folder=folder.name or str(folder),
            reason=error.strerror or str(error),
        ) from error
