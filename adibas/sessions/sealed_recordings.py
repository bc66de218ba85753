"""Recordings of the store: MCAP files whose content is sealed under a key of their own."""

from pathlib import Path

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import RecordingError, StoreError
from adibas.files import FULL, flush_folder, is_there
from adibas.progress import Progress
from adibas.recordings.convert import ConversionSummary, remove_unfinished_copies, write_all
from adibas.recordings.mcap_reader import McapReader
from adibas.recordings.mcap_writer import McapWriter
from adibas.recordings.part_file import part_path_of
from adibas.recordings.ports import RecordingOptions, RecordingReader
from adibas.recordings.seal import SealError
from adibas.sessions.sealed_folder import (
    ENDING,
    SealedFolder,
    cannot_read,
    cannot_save,
    cannot_unseal,
)
from adibas.sessions.sealing import AesSeal

SCOPE = "adibas-recording-1"
PART_ENDING = part_path_of(Path(f"x{ENDING}")).name.removeprefix("x")


class SealedRecordingWriter(McapWriter):
    """A sealed recording in the making; each frame is handed to the system at once.

    Attributes
    ----------
    recording_id : str
        Its name in the store.
    """

    def __init__(
        self, path: Path, seal: AesSeal, info: SourceInfo, options: RecordingOptions
    ) -> None:
        self.recording_id = path.stem
        super().__init__(path, info, options, seal)

    def write(self, frame: SensorFrame) -> None:
        """Append `frame`; it is handed to the system before this returns.

        Raises
        ------
        StoreError
            The disk is full; the frames until now are kept.
        RecordingError
            No recording can hold the frame's number or time.
        """
        try:
            super().write(frame)
        except RecordingError as error:
            if isinstance(error.__cause__, OSError):
                raise _stopped(error.__cause__) from error
            raise

    def close(self) -> None:
        """Finish the recording and give it its name; a second call does nothing."""
        try:
            super().close()
        except RecordingError as error:
            if isinstance(error.__cause__, OSError):
                raise _stopped(error.__cause__) from error
            raise


class SealedRecordings(SealedFolder):
    """Recordings in a folder, each under its id."""

    def create(
        self, recording_id: str, key: bytes, info: SourceInfo, options: RecordingOptions
    ) -> SealedRecordingWriter:
        """Begin a recording under the 32-byte `key`; it is listed when it is closed.

        Raises
        ------
        StoreError
            The disk is full or cannot be written.
        """
        path = self.path_of(recording_id)
        is_new_folder = not is_there(path.parent)
        try:
            writer = SealedRecordingWriter(path, _seal(recording_id, key), info, options)
        except RecordingError as error:
            raise _not_begun(error) from error
        if is_new_folder:
            try:
                flush_folder(self.folder)
            except OSError as error:
                writer.abandon()
                raise cannot_save(error) from error
        return writer

    def open(self, recording_id: str, key: bytes) -> RecordingReader:
        """Open a recording; `notice` says what a crash took of it.

        Raises
        ------
        StoreError
            It is missing, was changed, moved or damaged, or the key is another one.
        RecordingError
            It cannot be read.
        """
        path = self.path_of(recording_id)
        return _open(path, _seal(recording_id, key))

    def export(
        self,
        recording_id: str,
        key: bytes,
        path: Path,
        progress: Progress | None = None,
        *,
        depth_only: bool = False,
    ) -> ConversionSummary:
        """Write a recording without seal as `path`; as .mcap any Foxglove reader shows it.

        What an earlier export that was killed left of it at this place is removed.

        Parameters
        ----------
        path : Path
            Its ending chooses the format, as `adibas convert` does.
        progress : callable, optional
            Called with (frames done, frames in all).
        depth_only : bool
            Leave out in what a face is seen; see `write_all`.

        Returns
        -------
        summary : ConversionSummary
            Of a file that was cut the frames that are whole are written; `notice` says so.

        Raises
        ------
        StoreError
            The recording is missing or does not open.
        RecordingError
            A frame is damaged, or `path` cannot be written. Nothing is left there.
        """
        with self.open(recording_id, key) as reader:
            remove_unfinished_copies(reader, path)
            is_mcap = path.suffix.lower() == ".mcap"
            return write_all(reader, path, plain=is_mcap, depth_only=depth_only, progress=progress)

    def unfinished(self) -> set[str]:
        """Return the ids of recordings that are being made, or that a crash left so."""
        names = (path.name for path in self._paths())
        parts = {name.removesuffix(PART_ENDING) for name in names if name.endswith(PART_ENDING)}
        return parts - self.ids()

    def written(self, recording_id: str) -> Path | None:
        """Return where a recording is, finished or not; None before its first byte."""
        path = self.path_of(recording_id)
        return next((one for one in (path, part_path_of(path)) if is_there(one)), None)

    def recover(self, recording_id: str, key: bytes) -> int | None:
        """Make a recording of what a crash left unfinished.

        Only for the one who may write: another process' recording in the making looks the same.

        Returns
        -------
        n_frames : int or None
            How many whole frames it has; with 0 nothing is kept. None where nothing is unfinished.

        Raises
        ------
        StoreError
            The key is another one, or the beginning is damaged; the file is left alone.
        """
        path = self.path_of(recording_id)
        part = part_path_of(path)
        if is_there(path) or not is_there(part):
            return None
        n_frames = _count_frames(part, _seal(recording_id, key))
        try:
            if n_frames:
                part.rename(path)
            else:
                part.unlink()
            flush_folder(path.parent)
        except OSError as error:
            raise cannot_save(error) from error
        return n_frames

    def delete(self, file_id: str) -> None:
        """Remove a recording for good, finished or not."""
        path = self.path_of(file_id)
        try:
            part_path_of(path).unlink(missing_ok=True)
        except OSError as error:
            raise cannot_save(error) from error
        super().delete(file_id)


def _seal(recording_id: str, key: bytes) -> AesSeal:
    return AesSeal(key, f"{SCOPE}/{recording_id}")


def _open(path: Path, seal: AesSeal) -> McapReader:
    try:
        return McapReader(path, seal)
    except SealError as error:
        raise cannot_unseal(path) from error
    except RecordingError as error:
        cause = error.__cause__
        if isinstance(cause, OSError):
            raise cannot_read(path, cause) from error
        raise cannot_unseal(path) from error


def _count_frames(part: Path, seal: AesSeal) -> int:
    """Return how many whole frames an unfinished file has."""
    try:
        if part.stat().st_size == 0:
            return 0  # power went before the first byte was on the disk
    except OSError as error:
        raise cannot_read(part, error) from error
    with _open(part, seal) as reader:
        return len(reader)


def _not_begun(error: RecordingError) -> StoreError:
    cause = error.__cause__
    return cannot_save(cause) if isinstance(cause, OSError) else StoreError(error.message_id)


def _stopped(cause: OSError) -> StoreError:
    """Say why a recording ends whose file the user never sees."""
    if cause.errno in FULL:
        return StoreError(
            "The recording stops: the disk is full. Its frames until now are kept. Free some space "
            "and record again."
        )
    return StoreError(
        "The recording stops: {reason}. Its frames until now are kept. Check the disk and record "
        "again.",
        reason=cause.strerror or str(cause),
    )
