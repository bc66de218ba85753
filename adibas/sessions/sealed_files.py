"""Small files, such as pictures, each sealed with AES-256-GCM under a key of its own."""

from pathlib import Path

from adibas.errors import FileError, StoreError
from adibas.files import flush_folder, unfinished_in, written_whole
from adibas.recordings.seal import SealError
from adibas.sessions.left_files import Left
from adibas.sessions.sealed_folder import SealedFolder, cannot_read, cannot_save, cannot_unseal
from adibas.sessions.sealing import NONCE_SIZE, TAG_SIZE, AesSeal

MAGIC = b"\x8aADIBAS\x01"
"""Eight bytes; the last is the version."""
SCOPE = "adibas-file-1"
MAX_PAYLOAD = 1 << 30
"""Largest content of a file, bytes: a damaged disk must not make us take all memory."""
MAX_SIZE = len(MAGIC) + NONCE_SIZE + MAX_PAYLOAD + TAG_SIZE


class SealedFiles(SealedFolder):
    """Files of ``MAGIC, nonce (12 bytes), ciphertext, tag (16 bytes)``, bound to their ids."""

    def write(self, file_id: str, key: bytes, payload: bytes) -> None:
        """Save `payload` under the 32-byte `key`; when this returns it is on the disk.

        Raises
        ------
        StoreError
            The disk is full or cannot be written; an older content is untouched.
        """
        if len(payload) > MAX_PAYLOAD:
            raise ValueError(f"{len(payload)} bytes are too many for one file")
        path = self.path_of(file_id)
        sealed = AesSeal(key, SCOPE).seal(file_id, payload)
        try:
            is_new_folder = not path.parent.exists()  # an error where a network share is gone
            with written_whole(path) as unfinished, unfinished.open("wb") as file:
                file.write(MAGIC)
                file.write(sealed)
            if is_new_folder:
                flush_folder(self.folder)
        except OSError as error:
            raise cannot_save(error) from error
        except FileError as error:
            raise _as_store_error(error) from error

    def read(self, file_id: str, key: bytes) -> bytes:
        """Return the content of a file.

        Raises
        ------
        StoreError
            It is missing, was changed, moved or damaged, or the key is another one.
        """
        path = self.path_of(file_id)
        seal = AesSeal(key, SCOPE)
        if self.size(file_id) > MAX_SIZE:
            raise cannot_unseal(path)
        try:
            data = path.read_bytes()
        except OSError as error:
            raise cannot_read(path, error) from error
        if not data.startswith(MAGIC):
            raise cannot_unseal(path)
        try:
            return seal.open(file_id, data[len(MAGIC) :])
        except SealError as error:
            raise cannot_unseal(path) from error

    def unfinished(self) -> list[Path]:
        """Return the files that are being written, or that a crash left half written."""
        try:
            return [path for folder in self.folder.glob("*/") for path in unfinished_in(folder)]
        except OSError as error:
            raise cannot_save(error) from error

    def remove_unfinished(self, left: Left = set) -> int:
        """Remove what a crash left half written; return how many files that were.

        Parameters
        ----------
        left : callable
            Tells them from files in the making, which look the same; all of them where this one
            alone may write.
        """
        unfinished = left(self.unfinished())
        try:
            for path in unfinished:
                path.unlink(missing_ok=True)
        except OSError as error:
            raise cannot_save(error) from error
        return len(unfinished)


def _as_store_error(error: FileError) -> StoreError:
    """Return the sentence for the store in place of the one for a file that the user named."""
    cause = error.__cause__
    return cannot_save(cause) if isinstance(cause, OSError) else StoreError(error.message_id)
