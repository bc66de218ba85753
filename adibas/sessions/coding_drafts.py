"""What is coded of a recording of the store: sealed under the recording's key, and gone with it."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field

from adibas.errors import StoreError
from adibas.files import is_there
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
    _seen: dict[str, str | None] = field(default_factory=dict, compare=False, repr=False)
    """What stood in each part when it was read or written here last."""

    def read(self, part: str) -> str | None:
        """Return a part; None where it was never written.

        Raises
        ------
        StoreError
            There is no such recording, or the file is damaged.
        """
        text = self._kept(part, lambda: self.recordings.key(self.recording_id))
        self._seen[part] = text
        return text

    def write(self, part: str, text: str) -> None:
        """Keep a part; when this returns, it is on the disk.

        Raises
        ------
        StoreError
            There is no such recording, the store is read-only, or the disk is full; or somebody
            else coded the same meanwhile, under the same initials. What is kept stays then.
        """
        if self.recordings.is_read_only:
            raise StoreError(
                "Another window has the patient store open: what you code is not kept. Close that "
                "window, lock this one (Ctrl+L) and unlock it, or save the coding to a file."
            )
        key = self.recordings.key(self.recording_id)
        with self.recordings.one_at_a_time():
            if self.recordings.is_shared and part in self._seen:
                self._check_unchanged(part, text, key)
            self.recordings.codings.write(self._file_id(part), key, text.encode())
        self._seen[part] = text

    def _check_unchanged(self, part: str, text: str, key: bytes) -> None:
        if self._kept(part, lambda: key) not in (self._seen[part], text):
            raise StoreError(
                "Somebody else is coding this recording at another workstation under the same "
                "initials, and nothing of theirs is overwritten: what you code is not kept. Save "
                "the coding to a file, or code as a second observer."
            )

    def _kept(self, part: str, key: Callable[[], bytes]) -> str | None:
        codings, file_id = self.recordings.codings, self._file_id(part)
        if not is_there(codings.path_of(file_id)):
            return None
        return codings.read(file_id, key()).decode()

    def _file_id(self, part: str) -> str:
        name = f"{part}/{self.observer}{f'/{self.joined}' if self.joined else ''}"
        return f"{self.recording_id}-{hashlib.sha256(name.encode()).hexdigest()[:ID_DIGITS]}"
