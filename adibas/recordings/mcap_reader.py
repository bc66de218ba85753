"""Reads the native recording, whole or cut by a crash, one frame at a time."""

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.recordings import mcap_sealed
from adibas.recordings.mcap_index import (
    McapIndex,
    read_frame_chunk,
    read_index,
    read_index_without_summary,
)
from adibas.recordings.mcap_records import Message
from adibas.recordings.mcap_writer import COLOR, DEPTH, INFRARED, LIBRARY
from adibas.recordings.messages import RVL_IMAGE, read_color, read_depth
from adibas.recordings.ports import RecordingReader, count_gaps
from adibas.recordings.reading import (
    DamagedError,
    cannot_read,
    damaged_frame,
    describe_loss,
    open_to_read,
)
from adibas.recordings.seal import PayloadSeal, SealError
from adibas.recordings.source_info import info_from_texts


class McapReader(RecordingReader):
    """An MCAP file that this program wrote; the file is never changed.

    Parameters
    ----------
    path : Path
        Of the file.
    seal : PayloadSeal, optional
        That a sealed recording was written with.

    Raises
    ------
    RecordingError
        It cannot be read, is no recording of ours, or is sealed and there is no `seal`.
    SealError
        The recording was sealed by another `seal`, or not at all.
    """

    def __init__(self, path: Path, seal: PayloadSeal | None = None) -> None:
        self._name = path.name
        self._seal = seal
        self._file = open_to_read(path)
        with ExitStack() as undo:
            undo.callback(self._file.close)
            self._take(self._read_index())
            undo.pop_all()

    def _read_index(self) -> McapIndex:
        try:
            index = read_index(self._file)
            return index if self._seal is None else self._unsealed(index, self._seal)
        except SealError:
            raise
        except DamagedError as error:
            raise RecordingError(
                "{file} cannot be read: its beginning is damaged. Restore it from a copy.",
                file=self._name,
            ) from error
        except OSError as error:
            raise cannot_read(self._name, error) from error

    def _unsealed(self, index: McapIndex, seal: PayloadSeal) -> McapIndex:
        """Return the index of a sealed recording; an end that does not open is not believed."""
        try:
            mcap_sealed.open_index(seal, index, self._file)
        except SealError:
            index = read_index_without_summary(self._file)
            mcap_sealed.open_index(seal, index, self._file)
        return index

    def _take(self, index: McapIndex) -> None:
        """Keep what is needed of `index`."""
        if index.library != LIBRARY:
            raise RecordingError(
                "{file} was written or changed by another program, so that its frames cannot be "
                "told apart. Choose the file as ADiBAS recorded it.",
                file=self._name,
            )
        if mcap_sealed.is_sealed(index.info_texts):
            raise RecordingError(
                "{file} is sealed. Open the store that it belongs to and export the recording "
                "from there.",
                file=self._name,
            )
        self._size = self._file.seek(0, 2)
        self._starts = index.starts
        self._schemas = index.schemas
        self.timestamps_ns = np.array(index.times_ns, np.int64)
        self.timestamps_ns.flags.writeable = False
        info = info_from_texts(index.info_texts, self._name)
        self.info: SourceInfo = replace(info, n_dropped=_count_dropped(info, index))
        self.notice = None
        if index.sequences is not None:
            self.notice = describe_loss(self._name, index.n_lost_bytes, len(self._starts))

    def read(self, index: int) -> SensorFrame:
        """Return frame `index`, counted from 0."""
        if not 0 <= index < len(self._starts):
            raise IndexError(f"no frame {index} among {len(self._starts)}")
        try:
            messages = read_frame_chunk(self._file, self._size, self._starts[index])
            if self._seal is not None:
                messages = mcap_sealed.open_chunk(self._seal, index, messages)
            return self._frame(messages)
        except OSError as error:
            raise cannot_read(self._name, error) from error
        except (ValueError, RecordingError) as error:
            raise damaged_frame(self._name, index) from error

    def _frame(self, messages: list[Message]) -> SensorFrame:
        by_channel = {message.channel: message for message in messages}
        images = [by_channel[c] for c in (DEPTH, COLOR, INFRARED) if c in by_channel]
        if not images:
            raise DamagedError("a frame without an image")
        depth, color, infrared = (by_channel.get(c) for c in (DEPTH, COLOR, INFRARED))
        return SensorFrame(
            sequence=images[0].sequence,
            timestamp_ns=images[0].log_time_ns,
            depth_raw=read_depth(self._schema(DEPTH), depth.data) if depth else None,
            color=read_color(color.data) if color else None,
            color_timestamp_ns=color.publish_time_ns if color else None,
            infrared_raw=read_depth(self._schema(INFRARED), infrared.data) if infrared else None,
        )

    def _schema(self, channel: int) -> str:
        return RVL_IMAGE.full_name if self._seal is not None else self._schemas.get(channel, "")

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()


def _count_dropped(info: SourceInfo, index: McapIndex) -> int:
    """Return what the writer counted, or in a cut file what the frames' numbers tell."""
    if index.sequences is not None:
        return max(info.n_dropped, count_gaps(np.array(index.sequences, np.int64)))
    said = index.end_texts.get("n_dropped", "")
    return int(said) if said.isdecimal() else info.n_dropped
