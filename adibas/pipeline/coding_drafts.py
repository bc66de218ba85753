"""The coding of a recording in the making, kept where a crash does not reach it.

Beside a recording stand ``NAME.coding.csv``, a coding like any other, and ``NAME.detected.csv``,
what the program saw and nobody decided yet. Those of a second observer have his initials in their
names. In the store of sessions the same is sealed.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from adibas.behaviour.editing import Draft
from adibas.data.coding import Coding
from adibas.data.ethogram import Ethogram
from adibas.files import written_whole
from adibas.recordings.coding_csv import coding_csv_text, codings_of_csv
from adibas.recordings.joints_csv import recording_name
from adibas.recordings.reading import cannot_read

CODED, DETECTED = "coding", "detected"
UNNAMED = "recording"
ENDINGS = {"steps": "json", "blind": "txt"}
"""Of the files of parts that are no tables."""


class DraftPlace(Protocol):
    """Where the parts of a draft are kept, as texts."""

    def read(self, part: str) -> str | None:
        """Return a part; None where it was never written."""

    def write(self, part: str, text: str) -> None:
        """Keep a part; when this returns, it is on the disk."""


@dataclass(frozen=True, slots=True)
class BesideRecording(DraftPlace):
    """Files beside a recording.

    Attributes
    ----------
    recording : Path
    observer : str
        Initials of a second observer; empty for the first one.
    """

    recording: Path
    observer: str = ""

    def path(self, part: str) -> Path:
        """Return where a part is kept."""
        coder = re.sub(r"[^\w-]+", "_", self.observer)
        ending = ENDINGS.get(part, "csv")
        name = f"{recording_name(self.recording)}.{part}{f'-{coder}' if coder else ''}.{ending}"
        return self.recording.with_name(name)

    def read(self, part: str) -> str | None:
        """Return a part; None where it was never written."""
        path = self.path(part)
        try:
            return path.read_bytes().decode("utf-8-sig") if path.exists() else None
        except (OSError, UnicodeDecodeError) as error:
            told = error if isinstance(error, OSError) else OSError(str(error))
            raise cannot_read(path.name, told) from error

    def write(self, part: str, text: str) -> None:
        """Keep a part, written beside itself and renamed."""
        with written_whole(self.path(part)) as unfinished:
            unfinished.write_text(text, encoding="utf-8", newline="")


def new_draft(name: str, observed_ms: tuple[int, int], ethogram: Ethogram, observer: str) -> Draft:
    """Return a draft of a session in which nothing is coded yet."""
    return Draft(Coding(name or UNNAMED, ethogram, *observed_ms, (), observer, media=(name,)))


def read_draft(place: DraftPlace) -> Draft | None:
    """Return the draft that is kept at a place; None where there is none.

    Raises
    ------
    RecordingError, StoreError
        A part cannot be read.
    BehaviourError, ProtocolError
        It is no coding any more.
    """
    text = place.read(CODED)
    codings = () if text is None else codings_of_csv(text, CODED)
    if not codings:
        return None
    proposed = place.read(DETECTED)
    found = () if proposed is None else codings_of_csv(proposed, DETECTED)
    return Draft(codings[0], (), found[0] if found else None)


def write_draft(place: DraftPlace, draft: Draft, at_ms: int) -> None:
    """Keep a draft; states without an end are kept as if they ended at `at_ms`.

    Raises
    ------
    FileError, StoreError
        It cannot be written.
    """
    place.write(CODED, coding_csv_text([draft.settled(at_ms)]))
    if draft.detected is not None:
        place.write(DETECTED, coding_csv_text([draft.detected]))
