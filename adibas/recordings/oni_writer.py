"""Writes .oni files that the real OpenNI2 plays."""

import json
import struct
from dataclasses import replace
from math import atan, isclose
from pathlib import Path

import numpy as np

from adibas.arrays import IntArray, UInt8Array, UInt16Array
from adibas.calibration.files import write_calibration
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.files import is_there
from adibas.recordings import oni_records as oni
from adibas.recordings.decoding import decode_color, encoded_size
from adibas.recordings.oni_codec import encode_16zt
from adibas.recordings.part_file import PartFile
from adibas.recordings.ports import DropCount, RecordingOptions, RecordingWriter, check_frame
from adibas.recordings.source_info import calibration_to_keep, info_to_texts
from adibas.texts import Message, message

DEPTH, COLOR, INFRARED = 1, 2, 3
NAMES = {DEPTH: "Depth", COLOR: "Image", INFRARED: "IR"}
HEAD_SIZE = 4096
"""Bytes kept for the descriptions of the streams, which become known with their first images."""
MAX_PAYLOAD = 20 * 1024 * 1024 - 64
"""Larger records do not fit into the buffer of the real OpenNI2."""
TRAILER_MAGIC = b"ADIBAS\x00\x01"
TRAILER_ROW = struct.Struct("<qqqqqq")
NO_IMAGE = -1
NS_PER_US = 1000


class OniWriter(RecordingWriter):
    """An .oni file in the making.

    What the format has no place for (numbers, nanoseconds, dropped frames, the sensor's name)
    follows after its end record, where OpenNI2 does not look; the calibration also beside it.
    """

    def __init__(self, path: Path, info: SourceInfo, options: RecordingOptions) -> None:
        self.path = path
        self.options = options
        self.n_frames = 0
        self._info = info
        self._drops = DropCount(info.n_dropped)
        self._nodes: dict[int, oni.Node] = {}
        self._counts = dict.fromkeys(NAMES, 0)
        self._rows: list[tuple[int, ...]] = []
        self._last_us = 0
        self._is_open = True
        self._refuse_a_foreign_calibration()
        self._file = PartFile(path, self._head(is_whole=False))

    @property
    def n_dropped(self) -> int:
        """Frames that the sensor counted and that are not in the file, up to now."""
        return self._drops.total

    def count_dropped(self, n_frames: int) -> None:
        """Note frames that were lost without a gap in the sensor's count."""
        self._drops.add(n_frames)

    def write(self, frame: SensorFrame) -> None:
        """Append `frame`."""
        check_frame(frame, self.path.name)
        n_nodes = len(self._nodes)
        images = self._images(frame)
        if len(self._nodes) > n_nodes:
            self._file.overwrite(0, self._head(is_whole=False))
        offsets = dict.fromkeys(NAMES, NO_IMAGE)
        records = b""
        for node, (time_ns, payload) in images.items():
            offsets[node] = self._file.size + len(records)
            fields = oni.NEW_DATA_FIELDS.pack(time_ns // NS_PER_US, self._counts[node] + 1)
            records += oni.record(oni.NEW_DATA, node, fields, payload)
            self._last_us = max(self._last_us, time_ns // NS_PER_US)
        self._file.append(records)
        for node in images:
            self._counts[node] += 1
        color_ns = NO_IMAGE if frame.color_timestamp_ns is None else frame.color_timestamp_ns
        self._rows.append((frame.sequence, frame.timestamp_ns, color_ns, *offsets.values()))
        self._drops.see(frame.sequence)
        self.n_frames += 1

    def _images(self, frame: SensorFrame) -> dict[int, tuple[int, bytes]]:
        """Return time (ns) and payload of each image of `frame` by its node."""
        images: dict[int, tuple[int, bytes]] = {}
        if frame.depth_raw is not None:
            images[DEPTH] = frame.timestamp_ns, self._encode_depth(frame.depth_raw)
        if frame.color is not None and frame.color_timestamp_ns is not None:
            payload = self._encode_color(frame.color, frame.sequence)
            images[COLOR] = frame.color_timestamp_ns, payload
        if frame.infrared_raw is not None:
            images[INFRARED] = frame.timestamp_ns, self._encode_infrared(frame.infrared_raw)
        if any(len(payload) > MAX_PAYLOAD for _, payload in images.values()):
            raise self._refused(message("an image is larger than 20 MB"))
        return images

    def _encode_depth(self, depth: UInt16Array) -> bytes:
        payload = encode_16zt(depth)
        if DEPTH not in self._nodes:
            pixel_format = self._depth_format()
            codec = oni.CODEC_NONE if payload is None else oni.CODEC_16ZT
            self._add_node(DEPTH, oni.DEPTH_NODE, codec, pixel_format, depth.shape)
        self._check_size(DEPTH, depth.shape)
        if self._nodes[DEPTH].codec == oni.CODEC_NONE:
            return depth.astype("<u2").tobytes()
        if payload is None:
            raise self._refused(message("a depth image has more than 32,768 different values"))
        return payload

    def _depth_format(self) -> int:
        for pixel_format, unit_m in oni.UNITS_M.items():
            if isclose(self._info.depth_unit_m, unit_m, rel_tol=1e-9):
                return pixel_format
        raise RecordingError(
            "{file} cannot hold this recording: its unit of depth is {unit_mm:g} mm, and .oni has "
            "1 mm and 0.1 mm only. Choose .mcap, which can.",
            file=self.path.name,
            unit_mm=self._info.depth_unit_m * 1000,
        )

    def _encode_color(self, image: UInt8Array | EncodedImage, sequence: int) -> bytes:
        is_jpeg = isinstance(image, EncodedImage) and image.encoding == "jpeg"
        if COLOR not in self._nodes:
            codec = oni.CODEC_JPEG if is_jpeg else oni.CODEC_NONE
            self._add_node(COLOR, oni.COLOR_NODE, codec, oni.RGB888, _color_shape(image, sequence))
        self._check_size(COLOR, _color_shape(image, sequence))
        if self._nodes[COLOR].codec == oni.CODEC_NONE:
            return decode_color(image, sequence).tobytes()
        if not (is_jpeg and isinstance(image, EncodedImage)):
            raise self._refused(message("its colour is in part JPEG and in part not"))
        return image.payload

    def _encode_infrared(self, infrared: UInt16Array) -> bytes:
        if INFRARED not in self._nodes:
            shape = infrared.shape
            self._add_node(INFRARED, oni.INFRARED_NODE, oni.CODEC_NONE, oni.GRAY16, shape)
        self._check_size(INFRARED, infrared.shape)
        return infrared.astype("<u2").tobytes()

    def _add_node(
        self, number: int, kind: int, codec: bytes, pixel_format: int, shape: tuple[int, ...]
    ) -> None:
        rate_hz = max(1, round(self._info.frame_rate_hz))
        self._nodes[number] = oni.Node(kind, codec, shape[1], shape[0], rate_hz, pixel_format)

    def _check_size(self, number: int, shape: tuple[int, ...]) -> None:
        node = self._nodes[number]
        if (node.height, node.width) != shape[:2]:
            raise self._refused(message("the size of its images changes"))

    def _refused(self, reason: Message) -> RecordingError:
        return RecordingError(
            "{file} cannot hold this recording: {reason}. Choose .mcap, which can.",
            file=self.path.name,
            reason=reason,
        )

    def _head(self, *, is_whole: bool) -> bytes:
        """Return the first `HEAD_SIZE` bytes: header, streams, padding."""
        last_us = self._last_us if is_whole else oni.UNKNOWN_TIME
        head = oni.file_header(last_us, max(NAMES))
        for number, node in self._nodes.items():
            count = self._counts[number] if is_whole else oni.UNKNOWN_COUNT
            head += _describe(number, node, count, last_us, self._fov(number))
        begin = b"".join(
            oni.record(oni.DATA_BEGIN, number, struct.pack("<IQ", self._counts[number], last_us))
            for number in self._nodes
        )
        if not self._nodes:
            return head.ljust(HEAD_SIZE, b"\0")
        first = next(iter(self._nodes))
        padding = oni.general_property(first, "padding", b"")
        free = HEAD_SIZE - len(head) - len(begin) - len(padding)
        return head + oni.general_property(first, "padding", bytes(free)) + begin

    def _fov(self, number: int) -> bytes:
        """Return the xnFOV record, where the calibration tells the field of view."""
        calibration = self._info.calibration
        camera: CameraCalibration | None = None
        if calibration is not None:
            camera = calibration.color if number == COLOR else calibration.depth
        if camera is None:
            return b""
        lens = camera.intrinsics
        horizontal_rad = 2 * atan(camera.width / 2 / lens.fx)
        vertical_rad = 2 * atan(camera.height / 2 / lens.fy)
        value = struct.pack("<dd", horizontal_rad, vertical_rad)
        return oni.general_property(number, "xnFOV", value)

    def close(self) -> None:
        """Write the end, and give the file its name."""
        if not self._is_open:
            return
        self._is_open = False
        try:
            end = b"".join(oni.record(oni.NODE_REMOVED, number) for number in self._nodes)
            end += oni.record(oni.END, 0)
            self._file.append(end + self._trailer(self._file.size + len(end)))
            self._file.overwrite(0, self._head(is_whole=True))
            self._write_calibration()
            self._file.finish()
        finally:
            self._file.let_go()

    def _trailer(self, start: int) -> bytes:
        """Return what stands behind the end record, for position `start`."""
        texts = json.dumps(info_to_texts(replace(self._info, n_dropped=self.n_dropped))).encode()
        table = b"".join(TRAILER_ROW.pack(*row) for row in self._rows)
        sizes = struct.pack("<QQ", len(texts), len(self._rows))
        return texts + table + sizes + struct.pack("<Q", start) + TRAILER_MAGIC

    def _refuse_a_foreign_calibration(self) -> None:
        """See that readers do not take an old file beside this one for its calibration."""
        beside = calibration_path(self.path)
        if calibration_to_keep(self._info) is None and is_there(beside):
            raise RecordingError(
                "{file} has no calibration, and {beside} would be taken for it. Remove that file, "
                "or choose another name.",
                file=self.path.name,
                beside=beside.name,
            )

    def _write_calibration(self) -> None:
        calibration = calibration_to_keep(self._info)
        if calibration is not None:
            write_calibration(calibration_path(self.path), calibration)

    def abandon(self) -> None:
        """Remove everything that was written."""
        self._is_open = False
        self._file.remove()


def calibration_path(path: Path) -> Path:
    """Return the file beside an .oni file that holds its calibration."""
    return path.with_name(f"{path.stem}.calibration.json")


def _color_shape(image: UInt8Array | EncodedImage, sequence: int) -> tuple[int, ...]:
    if isinstance(image, EncodedImage):
        size = encoded_size(image.payload)
        return size if 0 not in size else decode_color(image, sequence).shape
    return image.shape


def _describe(number: int, node: oni.Node, count: int, last_us: int, fov: bytes) -> bytes:
    """Return the records of one stream; the player needs each of them."""
    is_color = node.kind == oni.COLOR_NODE
    old_format = oni.RGB24_BEFORE_OPENNI2 if is_color else oni.GRAY16_BEFORE_OPENNI2
    bytes_per_pixel = 3 if is_color else 2
    mode = struct.pack("<III", node.width, node.height, node.frame_rate_hz)
    added = struct.pack("<I4sIQQQ", node.kind, node.codec, count, 0, last_us, 0)
    size = node.width * node.height * bytes_per_pixel
    records = [
        oni.record(oni.NODE_ADDED, number, oni.text(NAMES[number]) + added),
        oni.int_property(number, "oniRequiredFrameSize", size),
        oni.int_property(number, "xnIsGenerating", 1),
        oni.int_property(number, "xnSupportedMapOutputModesCount", 1),
        oni.general_property(number, "xnSupportedMapOutputModes", mode),
        oni.general_property(number, "xnMapOutputMode", mode),
        oni.int_property(number, "xnPixelFormat", old_format),
        oni.int_property(number, "oniPixelFormat", node.pixel_format),
        fov,
        oni.general_property(number, "xnCropping", struct.pack("<IHHHH", 0, 0, 0, 0, 0)),
        oni.int_property(number, "xnMirror", 0),
        oni.record(oni.STATE_READY, number),
    ]
    if node.kind == oni.DEPTH_NODE:
        records.insert(3, oni.int_property(number, "xnDeviceMaxDepth", 65536))
    return b"".join(records)


def trailer_rows(table: bytes) -> IntArray:
    """Return the (N, 6) rows: number, two times in ns, three positions (-1 = none)."""
    return np.frombuffer(table, "<i8").reshape(-1, 6).astype(np.int64)
