"""Which unfinished files a crash left, and which somebody may still be writing.

The lock of a store in a file proves that nobody else writes; there all are left. On a server only
connections tell who is there, and after a restart of the server, or with a cable pulled, a
workstation goes on recording without one. The files of both are on one disk, and tell it.
"""

import os
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

Left = Callable[[Collection[Path]], set[Path]]
"""Picks from unfinished files those that a crash left; `set` takes them all."""

SECONDS_AT_REST = 600.0
"""A recording grows with every frame; no sensor is waited for as long as this."""
SECONDS_BETWEEN_LOOKS = 1.5
"""What is recorded is on the disk within a second."""


def files_at_rest(paths: Collection[Path]) -> set[Path]:
    """Return those files to which nobody has written for some minutes, and does not now.

    What cannot be read is not among them.
    """
    sizes = {path: _size(path) for path in paths if _is_old(path)}
    if sizes:  # file servers may keep the time of an open file as it was when it was opened
        time.sleep(SECONDS_BETWEEN_LOOKS)
    return {path for path, size in sizes.items() if size is not None and _size(path) == size}


def _is_old(path: Path) -> bool:
    """Compare times of one disk: the clock of a file server is not the one of this computer."""
    with suppress(OSError), TemporaryDirectory(dir=path.parent) as just_made:
        age_s = Path(just_made).stat().st_mtime - path.stat().st_mtime
        return age_s > SECONDS_AT_REST
    return False


def _size(path: Path) -> int | None:
    """Return the bytes as the disk has them: a file that is opened is asked for anew."""
    with suppress(OSError), path.open("rb") as file:
        return file.seek(0, os.SEEK_END)
    return None
