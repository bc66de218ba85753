"""Writes the native recording: MCAP, one chunk a frame, on the disk at once."""

import struct
import zlib
from collections import Counter
from dataclasses import replace
from pathlib import Path

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.recordings import mcap_records as mcap
from adibas.recordings import mcap_sealed
from adibas.recordings.decoding import encode_color
from adibas.recordings.messages import (
    CAMERA_CALIBRATION,
    COMPRESSED_IMAGE,
    RAW_IMAGE,
    RVL_IMAGE,
    Stamp,
    camera_calibration,
    compressed_image,
    raw_image,
    rvl_image,
)
from adibas.recordings.part_file import PartFile
from adibas.recordings.ports import DropCount, RecordingOptions, RecordingWriter, check_frame
from adibas.recordings.protobuf import MessageType, file_descriptor_set
from adibas.recordings.seal import PayloadSeal
from adibas.recordings.source_info import info_to_texts

LIBRARY = "adibas 1"
DEPTH, COLOR, INFRARED, COLOR_CALIBRATION, DEPTH_CALIBRATION = 1, 2, 3, 4, 5
TOPICS = {
    DEPTH: "/depth",
    COLOR: "/color",
    INFRARED: "/infrared",
    COLOR_CALIBRATION: "/color/calibration",
    DEPTH_CALIBRATION: "/depth/calibration",
}
ZSTD_LEVEL = 1
"""JPEG and RVL leave little to find; higher levels take time and save under one percent."""


class McapWriter(RecordingWriter):
    """An MCAP file in the making.

    Parameters
    ----------
    path : Path
        Where.
    info : SourceInfo
        What holds for every frame.
    options : RecordingOptions
        A sealed recording is never plain.
    seal : PayloadSeal, optional
        Makes everything but the number and the sizes of the frames unreadable.
    """

    def __init__(
        self,
        path: Path,
        info: SourceInfo,
        options: RecordingOptions,
        seal: PayloadSeal | None = None,
    ) -> None:
        self.path = path
        self.options = options if seal is None else replace(options, is_plain=False)
        self._seal = seal
        self._registry = _registry(self.options) if seal is None else mcap_sealed.REGISTRY
        self.n_frames = 0
        self._info = info
        self._drops = DropCount(info.n_dropped)
        self._index: list[bytes] = []
        self._counts: Counter[int] = Counter()
        self._chunk_times_ns: list[int] = []
        self._heads: list[mcap_sealed.FrameHead] = []
        self._metadata: list[bytes] = []
        self._is_open = True
        head = mcap.MAGIC + mcap.record(mcap.HEADER, mcap.text("") + mcap.text(LIBRARY))
        texts = info_to_texts(info)
        if seal is not None:
            texts = mcap_sealed.seal_texts(seal, mcap_sealed.INFO, texts)
        head += self._metadata_record(mcap.INFO_NAME, texts, len(head))
        self._file = PartFile(path, head + self._registry.schemas + self._registry.channels)

    @property
    def n_dropped(self) -> int:
        """Frames that the sensor counted and that are not in the file, up to now."""
        return self._drops.total

    def count_dropped(self, n_frames: int) -> None:
        """Note frames that were lost without a gap in the sensor's count."""
        self._drops.add(n_frames)

    def write(self, frame: SensorFrame) -> None:
        """Append `frame`; it is handed to the system before this returns."""
        check_frame(frame, self.path.name)
        packed = mcap.pack_chunk(self._messages(frame), ZSTD_LEVEL)
        head = mcap_sealed.FrameHead(frame.sequence, frame.timestamp_ns)
        if self._seal is not None:
            packed = mcap_sealed.seal_chunk(self._seal, self.n_frames, head, packed)
        start = self._file.size
        self._file.append(packed.chunk + packed.message_indexes)
        self._index.append(packed.index_record(start))
        self._counts.update(channel for channel, _ in packed.index_offsets)
        self._chunk_times_ns.append(packed.time_ns)
        self._heads.append(head)
        self._drops.see(frame.sequence)
        self.n_frames += 1

    def _messages(self, frame: SensorFrame) -> list[mcap.Message]:
        """Return the images of `frame`; with the first frame also the calibration."""
        messages: list[mcap.Message] = []

        def add(channel: int, time_ns: int, data: bytes) -> None:
            messages.append(
                mcap.Message(channel, frame.sequence, frame.timestamp_ns, time_ns, data)
            )

        depth_stamp = Stamp(frame.timestamp_ns, "depth", frame.sequence)
        if frame.depth_raw is not None:
            plain = raw_image(frame.depth_raw, depth_stamp) if self.options.is_plain else None
            data = plain or rvl_image(frame.depth_raw, self._info.depth_unit_m, depth_stamp)
            add(DEPTH, frame.timestamp_ns, data)
        if frame.color is not None and frame.color_timestamp_ns is not None:
            image = encode_color(frame.color, self.options)
            stamp = Stamp(frame.color_timestamp_ns, "color", frame.sequence)
            add(COLOR, stamp.timestamp_ns, compressed_image(image, stamp))
        if frame.infrared_raw is not None:
            add(INFRARED, frame.timestamp_ns, rvl_image(frame.infrared_raw, 0.0, depth_stamp))
        calibration = self._info.calibration
        if self.n_frames == 0 and calibration is not None:
            color_stamp = replace(depth_stamp, camera="color")
            if calibration.color is not None:
                data = camera_calibration(calibration.color, color_stamp)
                add(COLOR_CALIBRATION, frame.timestamp_ns, data)
            if calibration.depth is not None:
                data = camera_calibration(calibration.depth, depth_stamp)
                add(DEPTH_CALIBRATION, frame.timestamp_ns, data)
        return messages

    def close(self) -> None:
        """Write the summary and give the file its name."""
        if not self._is_open:
            return
        self._is_open = False
        texts = {"n_frames": str(self.n_frames), "n_dropped": str(self.n_dropped)}
        if self._seal is not None:
            texts = mcap_sealed.seal_end(self._seal, texts, self._heads)
        try:
            end = self._metadata_record(mcap.END_NAME, texts, self._file.size)
            end += mcap.record(mcap.DATA_END, struct.pack("<I", 0))
            self._file.append(end + self._summary(self._file.size + len(end)))
            self._file.finish()
        finally:
            self._file.let_go()

    def abandon(self) -> None:
        """Remove everything that was written."""
        self._is_open = False
        self._file.remove()

    def _metadata_record(self, name: str, texts: dict[str, str], start: int) -> bytes:
        """Return a metadata record for position `start`, and note it for the summary."""
        encoded = mcap.record(mcap.METADATA, mcap.text(name) + mcap.text_map(texts))
        place = struct.pack("<QQ", start, len(encoded)) + mcap.text(name)
        self._metadata.append(mcap.record(mcap.METADATA_INDEX, place))
        return encoded

    def _summary(self, start: int) -> bytes:
        """Return the summary section for position `start`, and what follows it."""
        groups = (
            (mcap.SCHEMA, self._registry.schemas),
            (mcap.CHANNEL, self._registry.channels),
            (mcap.STATISTICS, self._statistics()),
            (mcap.METADATA_INDEX, b"".join(self._metadata)),
            (mcap.CHUNK_INDEX, b"".join(self._index)),
        )
        content = b""
        offsets = b""
        for opcode, group in groups:
            if group:
                place = struct.pack("<BQQ", opcode, start + len(content), len(group))
                offsets += mcap.record(mcap.SUMMARY_OFFSET, place)
            content += group
        footer = mcap.PREFIX.pack(mcap.FOOTER, mcap.FOOTER_FIELDS.size)
        footer += struct.pack("<QQ", start, start + len(content))
        summary = content + offsets + footer
        return summary + struct.pack("<I", zlib.crc32(summary)) + mcap.MAGIC

    def _statistics(self) -> bytes:
        counts = b"".join(struct.pack("<HQ", *count) for count in sorted(self._counts.items()))
        times_ns = self._chunk_times_ns or [0]
        fields = struct.pack(
            "<QHIIIIQQ",
            self._counts.total(),
            self._registry.n_schemas,
            self._registry.n_channels,
            0,
            len(self._metadata),
            self.n_frames,
            min(times_ns),
            max(times_ns),
        )
        return mcap.record(mcap.STATISTICS, fields + mcap.text(counts))


def _types(options: RecordingOptions) -> dict[int, MessageType]:
    """Return the message type of each channel."""
    return {
        DEPTH: RAW_IMAGE if options.is_plain else RVL_IMAGE,
        COLOR: COMPRESSED_IMAGE,
        INFRARED: RVL_IMAGE,
        COLOR_CALIBRATION: CAMERA_CALIBRATION,
        DEPTH_CALIBRATION: CAMERA_CALIBRATION,
    }


def _schema_numbers(options: RecordingOptions) -> dict[MessageType, int]:
    return {kind: 1 + i for i, kind in enumerate(dict.fromkeys(_types(options).values()))}


def _schemas(options: RecordingOptions) -> bytes:
    return b"".join(
        mcap.record(
            mcap.SCHEMA,
            struct.pack("<H", number)
            + mcap.text(kind.full_name)
            + mcap.text("protobuf")
            + mcap.text(file_descriptor_set(kind)),
        )
        for kind, number in _schema_numbers(options).items()
    )


def _channels(options: RecordingOptions) -> bytes:
    numbers = _schema_numbers(options)
    return b"".join(
        mcap.record(
            mcap.CHANNEL,
            struct.pack("<HH", channel, numbers[kind])
            + mcap.text(TOPICS[channel])
            + mcap.text("protobuf")
            + mcap.text_map({}),
        )
        for channel, kind in _types(options).items()
    )


def _registry(options: RecordingOptions) -> mcap.Registry:
    n_schemas = len(_schema_numbers(options))
    return mcap.Registry(_schemas(options), _channels(options), n_schemas, len(TOPICS))
