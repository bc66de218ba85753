"""Files in a folder under random names, ``xx/ID.sealed``; `xx` are the first two digits of ID."""

import hashlib
import re
from pathlib import Path

from adibas.errors import StoreError
from adibas.files import FULL, flush_folder

ENDING = ".sealed"
BLOCK_SIZE = 1 << 20
_ID = re.compile(r"[0-9a-f]{2}[0-9a-f-]{6,62}")


class SealedFolder:
    """What sealed files of all kinds have in common.

    Parameters
    ----------
    folder : Path
        It need not exist yet.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def path_of(self, file_id: str) -> Path:
        """Return where the file `file_id` (lower-case hex digits and dashes) is or will be."""
        if not _ID.fullmatch(file_id):
            raise ValueError(f"no id: {file_id!r}")
        return self.folder / file_id[:2] / f"{file_id}{ENDING}"

    def ids(self) -> set[str]:
        """Return the ids of all whole files."""
        return {
            path.stem
            for path in self._paths()
            if _ID.fullmatch(path.stem) and path.parent.name == path.stem[:2]
        }

    def delete(self, file_id: str) -> None:
        """Remove a file for good; nothing happens where it is gone already."""
        path = self.path_of(file_id)
        try:
            path.unlink(missing_ok=True)
            if path.parent.exists():
                flush_folder(path.parent)
        except OSError as error:
            raise cannot_save(error) from error

    def sha256(self, file_id: str) -> str:
        """Return the checksum of the file as it is on the disk, hexadecimal.

        Raises
        ------
        StoreError
            The file is missing or cannot be read.
        """
        digest = hashlib.sha256()
        path = self.path_of(file_id)
        try:
            with path.open("rb") as file:
                while block := file.read(BLOCK_SIZE):
                    digest.update(block)
        except OSError as error:
            raise cannot_read(path, error) from error
        return digest.hexdigest()

    def size(self, file_id: str) -> int:
        """Return the bytes that the file takes on the disk.

        Raises
        ------
        StoreError
            The file is missing.
        """
        path = self.path_of(file_id)
        try:
            return path.stat().st_size
        except OSError as error:
            raise cannot_read(path, error) from error

    def _paths(self) -> list[Path]:
        """Return everything that looks like a sealed file, whole or not."""
        try:
            return list(self.folder.glob(f"*/*{ENDING}"))
        except OSError as error:
            raise cannot_read(self.folder, error) from error


def cannot_save(error: OSError) -> StoreError:
    """Say in words why nothing can be written into the store."""
    if error.errno in FULL:
        return StoreError(
            "This cannot be saved: the disk is full. What was saved before is unharmed. Free some "
            "space and try again."
        )
    return StoreError(
        "This cannot be saved: {reason}. What was saved before is unharmed. Check the disk and try "
        "again.",
        reason=error.strerror or str(error),
    )


def cannot_read(path: Path, error: OSError) -> StoreError:
    """Say in words why a file of the store cannot be read."""
    if isinstance(error, FileNotFoundError):
        return StoreError(
            "{file} is missing from the store. Restore the store's folder from a backup.",
            file=path.name,
        )
    return StoreError(
        "{file} cannot be read: {reason}. Check the disk and try again.",
        file=path.name,
        reason=error.strerror or str(error),
    )


def cannot_unseal(path: Path) -> StoreError:
    """Say that a file of the store does not open under its key."""
    return StoreError(
        "{file} cannot be opened: it was changed or damaged, or does not belong to this store. "
        "Restore the store's folder from a backup.",
        file=path.name,
    )
