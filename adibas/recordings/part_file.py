"""A file in the making that stays readable when the disk is full or the program dies.

It grows under a name of its own beside its place, ``NAME.part.mcap`` for ``NAME.mcap``, and is
renamed when it is whole. A part file that a crash left is never overwritten.
"""

import os
import time
from contextlib import suppress
from io import FileIO
from itertools import count, takewhile
from pathlib import Path

from adibas.errors import RecordingError
from adibas.files import FULL, flush_folder

SECONDS_BETWEEN_SYNCS = 1.0


class PartFile:
    """Appends whole pieces; a piece that does not fit is taken back.

    Parameters
    ----------
    path : Path
        The name that the file gets when it is whole; its folder is made where it is missing.
    head : bytes
        What stands at the beginning.
    """

    def __init__(self, path: Path, head: bytes) -> None:
        self.path = path
        self.size = 0
        self._synced_at = time.monotonic()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self.part_path, self._file = _open_part(path)
            flush_folder(path.parent)
        except OSError as error:
            raise cannot_record(path, error) from error
        try:
            self.append(head)
        except RecordingError:
            self.remove()
            raise

    def append(self, data: bytes) -> None:
        """Write `data` whole or not at all, and see that it is on the disk within a second."""
        try:
            self._write(data)
            if time.monotonic() - self._synced_at > SECONDS_BETWEEN_SYNCS:
                self.sync()
        except OSError as error:
            with suppress(OSError):  # the first error is the one to tell
                self._file.truncate(self.size)
                self._file.seek(self.size)
            raise cannot_record(self.path, error, kept=self.part_path) from error
        self.size += len(data)

    def _write(self, data: bytes) -> None:
        left = memoryview(data)
        while left:
            left = left[self._file.write(left) or 0 :]

    def overwrite(self, position: int, data: bytes) -> None:
        """Replace bytes that are already there."""
        try:
            self._file.seek(position)
            self._write(data)
            self._file.seek(self.size)
        except OSError as error:
            raise cannot_record(self.path, error, kept=self.part_path) from error

    def sync(self) -> None:
        """Wait until everything is on the disk."""
        os.fsync(self._file.fileno())
        self._synced_at = time.monotonic()

    def finish(self) -> None:
        """Give the file its name."""
        try:
            self.sync()
            self._file.close()
            self.part_path.replace(self.path)
            flush_folder(self.path.parent)
        except OSError as error:
            raise cannot_record(self.path, error, kept=self.part_path) from error

    def let_go(self) -> None:
        """Close the file and leave what is whole under the name of the part file."""
        self._file.close()

    def remove(self) -> None:
        """Delete everything."""
        self._file.close()
        self.part_path.unlink(missing_ok=True)


def part_path_of(path: Path, number: int = 1) -> Path:
    """Return the name under which `path` grows; a higher `number` where that one is taken."""
    return path.with_name(f"{path.stem}.part{'' if number == 1 else number}{path.suffix}")


def part_paths(path: Path) -> tuple[Path, ...]:
    """Return the part files of `path` that there are."""
    numbered = (part_path_of(path, number) for number in count(1))
    return tuple(takewhile(Path.is_file, numbered))


def _open_part(path: Path) -> tuple[Path, FileIO]:
    number = 1
    while True:
        part_path = part_path_of(path, number)
        try:
            return part_path, part_path.open("xb", buffering=0)
        except FileExistsError:
            number += 1


def cannot_record(path: Path, error: OSError, kept: Path | None = None) -> RecordingError:
    """Say in words why `path` cannot be written, and where the frames until now are."""
    is_full = error.errno in FULL
    fields = {"file": path.name, "reason": error.strerror or str(error)}
    if is_full and kept is not None:
        return RecordingError(
            "{file} cannot be recorded any longer: the disk is full. The frames until now are in "
            "{kept}. Free some space and record again.",
            **fields,
            kept=kept.name,
        )
    if is_full:
        return RecordingError(
            "{file} cannot be recorded: the disk is full. Free some space and try again.", **fields
        )
    if kept is not None:
        return RecordingError(
            "{file} cannot be recorded any longer: {reason}. The frames until now are in {kept}. "
            "Check the disk and record again.",
            **fields,
            kept=kept.name,
        )
    return RecordingError("{file} cannot be recorded: {reason}. Choose another folder.", **fields)


def nothing_kept(error: BaseException, path: Path) -> BaseException:
    """Return `error` without the promise that frames are kept, where it makes one."""
    is_promise = isinstance(error, RecordingError) and "kept" in error.fields
    cause = error.__cause__
    return cannot_record(path, cause) if is_promise and isinstance(cause, OSError) else error
