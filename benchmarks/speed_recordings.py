"""How fast recordings are written, opened and read, plain and sealed, beside goals and PNG."""

import os
import tempfile
import time
import uuid
from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from adibas.arrays import UInt8Array, UInt16Array
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.recordings import (
    RecordingOptions,
    RecordingReader,
    RecordingWriter,
    create_recording,
    open_recording,
)
from adibas.recordings.decoding import encode_png
from adibas.recordings.rvl import decode_rvl, encode_rvl
from adibas.recordings.tum_writer import NOTES_FILE
from adibas.sessions.sealed_recordings import SealedRecordings
from adibas.sessions.sealing import KEY_SIZE
from benchmarks.table import Row
from benchmarks.works import Work, median_ms

FRAME_RATE_HZ = 30
N_LONG = 18_000
SEED = 3


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` fewer frames are recorded."""
    rng = np.random.default_rng(SEED)
    depth, color = _depth_image(rng), _color_image(rng)
    yield from _codec_rows(depth)
    with tempfile.TemporaryDirectory() as folder:
        yield from _recording_rows(Path(folder), depth, color, n_frames=60 if quick else 300)
        yield from _opening_rows(Path(folder), n_frames=2000 if quick else N_LONG)
        yield from _folder_rows(Path(folder) / "long", n_frames=2000 if quick else N_LONG)
        store = SealedRecordings(Path(folder) / "sealed")
        yield from _sealed_rows(store, depth, color, n_frames=60 if quick else 300)
        yield from _sealed_opening_rows(store, n_frames=2000 if quick else N_LONG)


def _depth_image(rng: np.random.Generator) -> UInt16Array:
    """Return a 640x480 scene in mm: a person before a wall on a floor, noise, 15 % holes."""
    v, u = np.indices((480, 640))
    depth_mm = np.minimum(3500.0, 900_000.0 / np.maximum(v - 40, 1))
    is_person = ((u - 320) / 90) ** 2 + ((v - 250) / 210) ** 2 < 1
    depth_mm[is_person] = 2000 + 0.8 * np.abs(u - 320)[is_person]
    depth_mm += rng.normal(0, 1, depth_mm.shape) * 1.4e-6 * depth_mm**2
    depth_mm[rng.random(depth_mm.shape) < 0.02] = 0
    depth_mm[:, :80] = 0
    return depth_mm.astype(np.uint16)


def _color_image(rng: np.random.Generator) -> UInt8Array:
    noise = cv2.GaussianBlur(rng.integers(0, 256, (480, 640, 3), dtype=np.uint8), (0, 0), 12)
    smooth = noise.astype(float)
    stretched = (smooth - smooth.min()) / np.ptp(smooth) * 255
    noisy: UInt8Array = np.clip(stretched + rng.normal(0, 2, smooth.shape), 0, 255).astype(np.uint8)
    return noisy


def _clock_ms(work: Work, n_rounds: int = 30) -> float:
    return median_ms(work, n_rounds, time.perf_counter)


def _codec_rows(depth: UInt16Array) -> Iterable[Row]:
    png = encode_png(depth)
    png_array = np.frombuffer(png, np.uint8)
    rvl = encode_rvl(depth)
    ours_ms = _clock_ms(lambda: encode_rvl(depth))
    png_ms = _clock_ms(lambda: encode_png(depth))
    yield Row("compress 640x480 depth (RVL)", ours_ms, "ms", png_ms, "PNG 16 bit, fastest")
    ours_ms = _clock_ms(lambda: decode_rvl(rvl, depth.shape))
    png_ms = _clock_ms(lambda: cv2.imdecode(png_array, cv2.IMREAD_UNCHANGED))
    yield Row("decompress 640x480 depth (RVL)", ours_ms, "ms", png_ms, "PNG 16 bit")
    yield Row("size of 640x480 depth", len(rvl) / 1024, "KiB", len(png) / 1024, "PNG 16 bit")


def _recording_rows(
    folder: Path, depth: UInt16Array, color: UInt8Array, n_frames: int
) -> Iterable[Row]:
    """Share of one core that recording at 30 frames/s takes: CPU time of the whole process."""
    for choice, goal in (("jpeg", 0.5), ("png", None)):
        options = RecordingOptions(color="jpeg" if choice == "jpeg" else "png")
        path = folder / f"{choice}.mcap"
        writer = create_recording(path, SourceInfo(), options)
        cpu_s = _record(writer, depth, color, n_frames)
        name = f"record 640x480 depth + {choice.upper()} colour at 30 frames/s"
        share = cpu_s / n_frames * FRAME_RATE_HZ
        yield Row(name, share, "cores", goal, "" if goal is None else "goal <")
        mebibytes = path.stat().st_size / 2**20 / n_frames * FRAME_RATE_HZ * 60
        yield Row(f"size of a minute with {choice.upper()} colour", mebibytes, "MiB")


def _record(writer: RecordingWriter, depth: UInt16Array, color: UInt8Array, n_frames: int) -> float:
    """Return the CPU seconds of `n_frames` frames."""
    with writer:
        writer.write(SensorFrame(0, 0, depth, color, 0))
        start_s = time.process_time()
        for i in range(1, n_frames + 1):
            time_ns = i * 33_333_333
            writer.write(SensorFrame(i, time_ns, depth, color, time_ns))
        return time.process_time() - start_s


def _opening_rows(folder: Path, n_frames: int) -> Iterable[Row]:
    """Open and read a long recording of small frames; then the same file without its end."""
    path = folder / "long.mcap"
    small = np.full((48, 64), 2000, np.uint16)
    with create_recording(path, SourceInfo(), RecordingOptions(color="jpeg")) as writer:
        for i in range(n_frames):
            writer.write(SensorFrame(i, i * 33_333_333, depth_raw=small))
    name = f"open a recording of {n_frames:,} frames"
    yield Row(name, _clock_ms(lambda: open_recording(path).close(), 10), "ms", 50, "goal <")
    with path.open("r+b") as file:
        file.truncate(path.stat().st_size - 100)
    ours_ms = _clock_ms(lambda: open_recording(path).close(), 3)
    yield Row(f"{name}, cut by a crash", ours_ms, "ms")
    with open_recording(folder / "jpeg.mcap") as reader:
        yield from _reading_rows(reader, "read any 640x480 frame")


def _reading_rows(reader: RecordingReader, name: str) -> Iterable[Row]:
    """Read frames in a random order."""
    numbers = np.random.default_rng(SEED).integers(0, len(reader), 100)
    times = iter(np.tile(reader.timestamps_ns[numbers], 2))
    indexes = iter(np.tile(numbers, 2))
    ours_ms = _clock_ms(lambda: reader.read(int(next(indexes))), 100)
    yield Row(f"{name} by its number", ours_ms, "ms", 10, "goal <")
    ours_ms = _clock_ms(lambda: reader.read_at(int(next(times))), 100)
    yield Row(f"{name} by its time", ours_ms, "ms", 10, "goal <")


def _sealed_rows(
    store: SealedRecordings, depth: UInt16Array, color: UInt8Array, n_frames: int
) -> Iterable[Row]:
    """Record and read what the session store keeps."""
    recording_id, key = uuid.uuid4().hex, os.urandom(KEY_SIZE)
    writer = store.create(recording_id, key, SourceInfo(), RecordingOptions(color="jpeg"))
    share = _record(writer, depth, color, n_frames) / n_frames * FRAME_RATE_HZ
    name = "record 640x480 depth + JPEG colour at 30 frames/s, sealed"
    yield Row(name, share, "cores", 0.5, "goal <")
    with store.open(recording_id, key) as reader:
        yield from _reading_rows(reader, "read any sealed 640x480 frame")


def _sealed_opening_rows(store: SealedRecordings, n_frames: int) -> Iterable[Row]:
    """Open a long sealed recording of small frames; then the same file without its end."""
    recording_id, key = uuid.uuid4().hex, os.urandom(KEY_SIZE)
    small = np.full((48, 64), 2000, np.uint16)
    with store.create(recording_id, key, SourceInfo(), RecordingOptions()) as writer:
        for i in range(n_frames):
            writer.write(SensorFrame(i, i * 33_333_333, depth_raw=small))
    name = f"open a sealed recording of {n_frames:,} frames"
    ours_ms = _clock_ms(lambda: store.open(recording_id, key).close(), 10)
    yield Row(name, ours_ms, "ms", 50, "goal <")
    with store.path_of(recording_id).open("r+b") as file:
        file.truncate(store.size(recording_id) - 100)
    ours_ms = _clock_ms(lambda: store.open(recording_id, key).close(), 3)
    yield Row(f"{name}, cut by a crash", ours_ms, "ms")


def _folder_rows(path: Path, n_frames: int) -> Iterable[Row]:
    """Open a long TUM folder of depth and colour; then the same as others write it."""
    depth, color = np.full((48, 64), 2000, np.uint16), np.full((48, 64, 3), 90, np.uint8)
    with create_recording(path, SourceInfo(), RecordingOptions(color="jpeg")) as writer:
        for i in range(n_frames):
            time_ns = i * 33_333_333
            writer.write(SensorFrame(i, time_ns, depth, color, time_ns + 4_000_000))
    name = f"open a TUM folder of {n_frames:,} frames"
    yield Row(name, _clock_ms(lambda: open_recording(path).close(), 10), "ms", 50, "goal <")
    (path / NOTES_FILE).unlink()
    ours_ms = _clock_ms(lambda: open_recording(path).close(), 10)
    yield Row(f"{name} of others", ours_ms, "ms", 50, "goal <")
