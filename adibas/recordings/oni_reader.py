"""Reads .oni files: our own, those of OpenNI2's recorder, and files cut by a crash."""

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from adibas.arrays import UInt8Array, UInt16Array
from adibas.calibration.files import read_calibration
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.files import is_there
from adibas.recordings import oni_records as oni
from adibas.recordings.decoding import decode_color
from adibas.recordings.oni_codec import decode_16z, decode_16zt
from adibas.recordings.oni_index import OniIndex, read_index
from adibas.recordings.oni_writer import NO_IMAGE, calibration_path
from adibas.recordings.ports import RecordingReader, count_gaps
from adibas.recordings.reading import (
    DamagedError,
    cannot_read,
    damaged_frame,
    describe_loss,
    open_to_read,
)
from adibas.recordings.source_info import info_from_texts


class OniReader(RecordingReader):
    """An .oni file; a calibration beside it (``NAME.calibration.json``) is read too.

    In files of others the frame number is the file's own, and mirrored images are flipped back.
    """

    def __init__(self, path: Path) -> None:
        self._name = path.name
        self._file = open_to_read(path)
        with ExitStack() as undo:
            undo.callback(self._file.close)
            self._open(path)
            undo.pop_all()

    def _open(self, path: Path) -> None:
        try:
            index = read_index(self._file)
        except DamagedError as error:
            raise RecordingError(
                "{file} cannot be read: its beginning or its table is damaged. Restore it from a "
                "copy.",
                file=self._name,
            ) from error
        except OSError as error:
            raise cannot_read(self._name, error) from error
        self._size = self._file.seek(0, 2)
        self._nodes = {node.kind: node for node in index.nodes.values()}
        self._rows = index.rows
        self.timestamps_ns = np.ascontiguousarray(index.rows[:, 1])
        self.timestamps_ns.flags.writeable = False
        self.info = self._read_info(path, index)
        self.notice = None
        if not index.has_end:
            self.notice = describe_loss(self._name, index.n_lost_bytes, len(self._rows))

    def _read_info(self, path: Path, index: OniIndex) -> SourceInfo:
        if index.texts:
            info = info_from_texts(index.texts, self._name)
        else:
            depth = self._nodes.get(oni.DEPTH_NODE)
            info = SourceInfo(
                depth_unit_m=oni.UNITS_M.get(depth.pixel_format, 0.001) if depth else 0.001,
                frame_rate_hz=float(max(_rates_hz(self._nodes), default=30)),
                n_dropped=count_gaps(index.rows[:, 0]),
            )
        beside = calibration_path(path)
        if is_there(beside):
            info = replace(info, calibration=read_calibration(beside))
        return info

    def read(self, index: int) -> SensorFrame:
        """Return frame `index`, counted from 0."""
        if not 0 <= index < len(self._rows):
            raise IndexError(f"no frame {index} among {len(self._rows)}")
        sequence, time_ns, color_ns, depth_at, color_at, infrared_at = self._rows[index].tolist()
        try:
            has_color = color_at != NO_IMAGE
            return SensorFrame(
                sequence=sequence,
                timestamp_ns=time_ns,
                depth_raw=self._read_depth(depth_at, oni.DEPTH_NODE),
                color=self._read_color(color_at, sequence) if has_color else None,
                color_timestamp_ns=color_ns if has_color else None,
                infrared_raw=self._read_depth(infrared_at, oni.INFRARED_NODE),
            )
        except OSError as error:
            raise cannot_read(self._name, error) from error
        except (ValueError, RecordingError) as error:
            raise damaged_frame(self._name, index) from error

    def _payload(self, position: int, kind: int) -> tuple[oni.Node, bytes]:
        """Return the stream and the bytes of the image record at `position`."""
        node = self._nodes.get(kind)
        self._file.seek(position)
        head = self._file.read(oni.RECORD_HEADER.size)
        header = oni.parse_header(head, position, self._size)
        if node is None or header.kind != oni.NEW_DATA:
            raise DamagedError("no image where one should be")
        self._file.seek(header.payload_start)
        return node, self._file.read(header.payload_size)

    def _read_depth(self, position: int, kind: int) -> UInt16Array | None:
        if position == NO_IMAGE:
            return None
        node, payload = self._payload(position, kind)
        shape = (node.height, node.width)
        if node.codec == oni.CODEC_16ZT:
            image = decode_16zt(payload, shape)
        elif node.codec == oni.CODEC_16Z:
            image = decode_16z(payload, shape)
        elif node.codec == oni.CODEC_NONE and len(payload) == 2 * node.height * node.width > 0:
            image = np.frombuffer(payload, "<u2").reshape(shape).astype(np.uint16)
        else:
            raise DamagedError("an image of an unknown kind")
        return np.ascontiguousarray(image[:, ::-1]) if node.is_mirrored else image

    def _read_color(self, position: int, sequence: int) -> UInt8Array | EncodedImage:
        node, payload = self._payload(position, oni.COLOR_NODE)
        if node.codec == oni.CODEC_JPEG or node.pixel_format == oni.JPEG:
            encoded = EncodedImage("jpeg", payload)
            if not node.is_mirrored:
                return encoded
            image = decode_color(encoded, sequence)
        elif node.codec == oni.CODEC_NONE:
            image = _to_rgb(node, payload)
        else:
            raise DamagedError("a colour image of an unknown kind")
        return np.ascontiguousarray(image[:, ::-1]) if node.is_mirrored else image

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()


def _rates_hz(nodes: dict[int, oni.Node]) -> list[int]:
    return [node.frame_rate_hz for node in nodes.values() if node.frame_rate_hz > 0]


def _to_rgb(node: oni.Node, payload: bytes) -> UInt8Array:
    """Return the (H, W, 3) RGB image of uncompressed `payload`."""
    shape = (node.height, node.width)
    pixels = np.frombuffer(payload, np.uint8)
    n_bytes = {oni.RGB888: 3, oni.GRAY8: 1, oni.YUV422: 2, oni.YUYV: 2}.get(node.pixel_format, 0)
    if len(pixels) != n_bytes * shape[0] * shape[1] or len(pixels) == 0:
        raise DamagedError("a colour image of the wrong size")
    if node.pixel_format == oni.RGB888:
        return pixels.reshape(*shape, 3).copy()
    if node.pixel_format == oni.GRAY8:
        return np.repeat(pixels.reshape(*shape, 1), 3, axis=2)
    import cv2

    is_yuyv = node.pixel_format == oni.YUYV
    code = cv2.COLOR_YUV2RGB_YUYV if is_yuyv else cv2.COLOR_YUV2RGB_UYVY
    try:
        return np.ascontiguousarray(cv2.cvtColor(pixels.reshape(*shape, 2), code), np.uint8)
    except cv2.error as error:
        raise DamagedError("a colour image of the wrong size") from error
