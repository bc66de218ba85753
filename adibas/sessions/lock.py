"""Who may write: the one process that holds the lock of the store's folder."""

import os
import sys
from pathlib import Path

from adibas.errors import StoreError

LOCK_FILE = "lock"


class StoreLock:
    """A lock of the operating system: it ends with the process, however that ends.

    Parameters
    ----------
    folder : Path
        The store; it exists.

    Attributes
    ----------
    is_held : bool
        False where another opener holds it.

    Raises
    ------
    StoreError
        The folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        try:
            descriptor = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise cannot_use(folder, error) from error
        self._descriptor: int | None = descriptor
        self.is_held = _take(descriptor)

    def release(self) -> None:
        """Let the next one write."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None
            self.is_held = False


def cannot_use(folder: Path, error: OSError) -> StoreError:
    """Say in words why the folder of the store cannot be used."""
    return StoreError(
        "The patient store in {folder} cannot be used: {reason}. Check that the disk is there and "
        "that you may write into the folder.",
        folder=folder.name,
        reason=error.strerror or str(error),
    )


if sys.platform == "win32":
    import msvcrt

    def _take(descriptor: int) -> bool:
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def _take(descriptor: int) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
