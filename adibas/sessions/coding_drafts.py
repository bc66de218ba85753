"""What is coded of a recording of the store: sealed under the recording's key, and gone with it."""

import hashlib
from dataclasses import dataclass

from adibas.errors import StoreError
from adibas.sessions.stored_recordings import Recordings

ID_DIGITS = 16


@dataclass(frozen=True, slots=True)
class InStore:
    """The parts of the draft of one observer.

    Attributes
    ----------
    recordings : Recordings
    recording_id : str
    observer : str
        Initials of a second observer; empty for the first one.
    joined : str
        Which other recordings are watched with it as one; empty for none.
    """

    recordings: Recordings
    recording_id: str
    observer: str = ""
    joined: str = ""

    def read(self, part: str) -> str | None:
        """Return a part; None where it was never written.

        Raises
        ------
        StoreError
            There is no such recording, or the file is damaged.
        """
        codings, file_id = self.recordings.codings, self._file_id(part)
        if not codings.path_of(file_id).exists():
            return None
        payload = codings.read(file_id, self.recordings.key(self.recording_id))
        return payload.decode()

    def write(self, part: str, text: str) -> None:
        """Keep a part; when this returns, it is on the disk.

        Raises
        ------
        StoreError
            There is no such recording, the store is read-only, or the disk is full.
        """
        if self.recordings.is_read_only:
            raise StoreError(
                "Another window has the patient store open: what you code is not kept. Close that "
                "window, lock this one (Ctrl+L) and unlock it, or save the coding to a file."
            )
        key = self.recordings.key(self.recording_id)
        self.recordings.codings.write(self._file_id(part), key, text.encode())

    def _file_id(self, part: str) -> str:
        name = f"{part}/{self.observer}{f'/{self.joined}' if self.joined else ''}"
        return f"{self.recording_id}-{hashlib.sha256(name.encode()).hexdigest()[:ID_DIGITS]}"
