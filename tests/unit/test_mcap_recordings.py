"""The native recording: readable by others, readable after a crash, never overwritten."""

import errno
import os
import signal
import subprocess
import sys
import time
import tracemalloc
import zlib

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import AdibasError, RecordingError
from adibas.recordings import RecordingOptions, create_recording, open_recording
from adibas.recordings import mcap_records as mcap
from adibas.recordings.decoding import decode_color
from adibas.recordings.reading import DamagedError
from tests.unit.recorded_frames import (
    FRAME_NS,
    INFO,
    START_NS,
    assert_same_frame,
    assert_same_info,
    make_frames,
    write_frames,
)


@pytest.fixture
def recorded(tmp_path):
    """A whole recording of six frames, and these frames."""
    frames = make_frames(6)
    write_frames(create_recording(tmp_path / "a.mcap", INFO), frames)
    return tmp_path / "a.mcap", frames


def cut(path, n_bytes):
    shortened = path.with_name("cut.mcap")
    shortened.write_bytes(path.read_bytes()[:n_bytes])
    return shortened


def chunk_ends(path):
    """Positions after each chunk and its message indexes, found by the independent library."""
    with path.open("rb") as file:
        indexes = make_reader(file).get_summary().chunk_indexes
    return [c.chunk_start_offset + c.chunk_length + c.message_index_length for c in indexes]


def test_any_frame_comes_by_number_and_by_time(recorded):
    path, frames = recorded
    with open_recording(path) as reader:
        assert len(reader) == 6
        assert_same_info(reader.info, INFO)
        for i in (5, 0, 3):
            assert_same_frame(reader.read(i), frames[i])
        nearly = START_NS + 2 * FRAME_NS + FRAME_NS // 2
        assert_same_frame(reader.read_at(nearly - 1), frames[2])
        assert_same_frame(reader.read_at(nearly + 1), frames[3])
        assert_same_frame(reader.read_at(-(2**70)), frames[0])
        assert_same_frame(reader.read_at(2**70), frames[5])
        for missing in (-1, 6):
            with pytest.raises(IndexError):
                reader.read(missing)


def test_the_independent_library_reads_every_record_and_every_sum(recorded):
    path, frames = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    assert summary.statistics.chunk_count == 6
    assert summary.statistics.message_count == len(messages) == 2 * 6 + 2
    names = {channel.topic: schema.name for schema, channel, _ in messages}
    assert names == {
        "/depth": "adibas.RvlImage",
        "/color": "foxglove.CompressedImage",
        "/color/calibration": "foxglove.CameraCalibration",
        "/depth/calibration": "foxglove.CameraCalibration",
    }
    sequences = [m.sequence for _, channel, m in messages if channel.topic == "/depth"]
    assert sequences == [frame.sequence for frame in frames]
    assert metadata["adibas.end"] == {"n_frames": "6", "n_dropped": "3"}
    assert float(metadata["adibas"]["depth_unit_m"]) == INFO.depth_unit_m


def test_every_chunk_holds_one_frame_and_reads_as_a_stream(recorded):
    path, frames = recorded
    with path.open("rb") as file:
        kinds = [type(record).__name__ for record in StreamReader(file, emit_chunks=True).records]
    assert kinds.count("Chunk") == len(frames)
    assert kinds[0] == "Header"
    assert kinds[-1] == "Footer"


@pytest.mark.parametrize("missing", [1, 40, 400, 3000])
def test_a_file_cut_anywhere_gives_every_whole_frame_and_says_what_was_lost(recorded, missing):
    path, frames = recorded
    size = path.stat().st_size
    shortened = cut(path, size - missing)
    n_whole = sum(
        end - 200 <= shortened.stat().st_size for end in chunk_ends(path)
    )  # message indexes may be cut
    with open_recording(shortened) as reader:
        assert reader.notice is not None
        assert "cut.mcap" in reader.notice
        assert len(reader) in (n_whole, n_whole - 1)
        assert_same_info(reader.info, INFO)
        assert reader.info.n_dropped == (3 if len(reader) > 2 else 0)
        for got, want in zip(reader, frames, strict=False):
            assert_same_frame(got, want)
    assert shortened.stat().st_size == size - missing


def test_a_cut_at_the_end_of_a_frame_loses_nothing(recorded):
    path, _ = recorded
    shortened = cut(path, chunk_ends(path)[3])
    with open_recording(shortened) as reader:
        assert len(reader) == 4
        assert "interrupted" in reader.notice


def test_zeros_at_the_end_of_a_cut_file_are_no_frame(recorded):
    path, frames = recorded
    shortened = cut(path, chunk_ends(path)[2])
    with shortened.open("ab") as file:
        file.write(bytes(5000))
    with open_recording(shortened) as reader:
        assert len(reader) == 3
        assert "5000 bytes" in reader.notice
        assert_same_frame(reader.read(2), frames[2])


def test_a_frame_of_zeros_before_the_cut_ends_the_recording(recorded):
    path, _ = recorded
    ends = chunk_ends(path)
    shortened = cut(path, ends[4])
    with shortened.open("r+b") as file:
        file.seek(ends[2] + 200)
        file.write(bytes(2000))
    with open_recording(shortened) as reader:
        assert len(reader) == 3


def test_a_damaged_frame_in_the_middle_is_named_and_the_others_are_read(recorded):
    path, frames = recorded
    ends = chunk_ends(path)
    with path.open("r+b") as file:
        file.seek(ends[1] + 300)
        file.write(b"\xff\xff\xff\xff")
    with open_recording(path) as reader:
        with pytest.raises(RecordingError, match=r"Frame 2 of a.mcap is damaged"):
            reader.read(2)
        assert_same_frame(reader.read(3), frames[3])


RECORD_FOR_EVER = """
import sys
from pathlib import Path
from adibas.data.frames import SourceInfo
from adibas.recordings import create_recording
from adibas.recordings.decoding import decode_color
from adibas.recordings.reading import DamagedError
from tests.unit.recorded_frames import make_frames
frames = make_frames(30)
with create_recording(Path(sys.argv[1]), SourceInfo()) as writer:
    for frame in frames:
        writer.write(frame)
        print(frame.sequence, flush=True)
    input()
"""


def test_a_killed_recording_keeps_every_frame_that_was_written(tmp_path):
    command = [sys.executable, "-c", RECORD_FOR_EVER, str(tmp_path / "a.mcap")]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as program:
        last = [program.stdout.readline() for _ in range(30)][-1]
        os.kill(program.pid, signal.SIGKILL)
    assert [item.name for item in tmp_path.iterdir()] == ["a.part.mcap"]
    with open_recording(tmp_path / "a.part.mcap") as reader:
        assert len(reader) == 30
        assert reader.read(29).sequence == int(last)


def test_who_asks_for_an_unfinished_recording_is_told_where_its_frames_are(tmp_path):
    (tmp_path / "a.part.mcap").write_bytes(b"frames of yesterday")
    with pytest.raises(RecordingError, match=r"a.mcap was never finished.*a.part.mcap"):
        open_recording(tmp_path / "a.mcap")


def test_the_part_file_of_a_crash_is_never_overwritten(tmp_path):
    (tmp_path / "a.part.mcap").write_bytes(b"frames of yesterday")
    write_frames(create_recording(tmp_path / "a.mcap", INFO), make_frames(1))
    assert (tmp_path / "a.part.mcap").read_bytes() == b"frames of yesterday"
    with open_recording(tmp_path / "a.mcap") as reader:
        assert len(reader) == 1


def test_what_stood_there_before_stays_until_the_recording_is_whole(recorded):
    path, _ = recorded
    before = path.read_bytes()
    writer = create_recording(path, INFO)
    writer.write(make_frames(1)[0])
    assert path.read_bytes() == before
    writer.abandon()
    assert path.read_bytes() == before
    assert not path.with_name("a.part.mcap").exists()


def test_an_exception_keeps_a_live_recording_and_removes_any_other(tmp_path):
    for is_live in (True, False):
        writer = create_recording(
            tmp_path / f"{is_live}.mcap", INFO, RecordingOptions(is_live=is_live)
        )
        with pytest.raises(KeyboardInterrupt), writer:
            writer.write(make_frames(1)[0])
            raise KeyboardInterrupt
    assert [item.name for item in tmp_path.iterdir()] == ["True.mcap"]


def full_disk_after(monkeypatch, n_bytes):
    """Let the part file fail like a full disk, within a write, after `n_bytes` more bytes."""
    from adibas.recordings.part_file import PartFile

    left = n_bytes
    genuine = PartFile._write

    def write(self, data):
        nonlocal left
        genuine(self, data[:left])
        left -= len(data)
        if left < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(PartFile, "_write", write)


def test_a_full_disk_is_told_and_the_frames_until_then_are_kept(tmp_path, monkeypatch):
    frames = make_frames(6)
    writer = create_recording(tmp_path / "a.mcap", INFO)
    writer.write(frames[0])
    writer.write(frames[1])
    full_disk_after(monkeypatch, 1500)
    with pytest.raises(RecordingError, match=r"disk is full.*a.part.mcap") as caught, writer:
        writer.write(frames[2])
    assert "a.part.mcap" in "".join(caught.value.__notes__)
    with open_recording(tmp_path / "a.part.mcap") as reader:
        assert len(reader) == 2
        assert_same_frame(reader.read(1), frames[1])


def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match=r"a.mcap cannot be recorded"):
        create_recording(tmp_path / "file" / "a.mcap", INFO)


def test_frames_reach_the_disk_within_a_second(tmp_path, monkeypatch):
    now_s = [time.monotonic()]
    synced = []
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])
    monkeypatch.setattr(os, "fsync", lambda _: synced.append(now_s[0]))
    start_s = now_s[0]
    with create_recording(tmp_path / "a.mcap", SourceInfo()) as writer:
        for i in range(150):
            now_s[0] += 1 / 30
            image = np.full((2, 2), i, np.uint16)
            writer.write(SensorFrame(i, i, depth_raw=image))
    times_s = np.array([start_s, *synced])
    assert np.diff(times_s).max() <= 1.0 + 1 / 30 + 1e-9


@pytest.mark.parametrize(("sequence", "time_ns"), [(2**32, 0), (-1, 0), (0, -1), (0, 2**63)])
@pytest.mark.parametrize("name", ["a.mcap", "a.oni", "a"])
def test_numbers_that_no_format_holds_are_refused(tmp_path, sequence, time_ns, name):
    frame = SensorFrame(sequence, time_ns, depth_raw=np.ones((2, 2), np.uint16))
    writer = create_recording(tmp_path / name, SourceInfo())
    with pytest.raises(RecordingError, match="cannot hold frame"):
        writer.write(frame)
    writer.abandon()
    assert list(tmp_path.iterdir()) == []


def chunk_content(packed, size, crc=0):
    content = mcap.CHUNK_FIELDS.pack(0, 0, size, crc) + mcap.text("zstd")
    return content + len(packed).to_bytes(8, "little") + packed


@pytest.mark.parametrize("claimed", [1000, 2**40])
def test_a_bomb_in_a_chunk_is_refused_before_memory_is_taken(claimed):
    bomb = zstandard.ZstdCompressor().compress(bytes(100_000_000))
    tracemalloc.start()
    with pytest.raises(DamagedError):
        mcap.unpack_chunk(chunk_content(bomb, claimed))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1_000_000


def test_a_chunk_whose_sum_is_wrong_is_refused():
    plain = b"0123456789" * 20
    packed = zstandard.ZstdCompressor().compress(plain)
    right = zlib.crc32(plain)
    assert mcap.unpack_chunk(chunk_content(packed, len(plain), right)) == plain
    with pytest.raises(DamagedError, match="sum is wrong"):
        mcap.unpack_chunk(chunk_content(packed, len(plain), right ^ 1))


def test_a_file_of_another_program_is_refused_in_words(tmp_path):
    from mcap.writer import Writer

    with (tmp_path / "other.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    with pytest.raises(AdibasError, match="written or changed by another program"):
        open_recording(tmp_path / "other.mcap")


def test_a_recording_of_a_later_version_is_refused_in_words(recorded):
    path, _ = recorded
    data = path.read_bytes()
    old, new = (mcap.text("version") + mcap.text(number) for number in "12")
    path.write_bytes(data.replace(old, new))
    with pytest.raises(RecordingError, match="Update the program"):
        open_recording(path)


def test_jpeg_is_a_choice_and_close_to_the_original(tmp_path):
    frame = make_frames(1, "array")[0]
    with create_recording(tmp_path / "a.mcap", INFO, RecordingOptions(color="jpeg")) as writer:
        writer.write(frame)
    with open_recording(tmp_path / "a.mcap") as reader:
        image = reader.read(0).color
    assert isinstance(image, EncodedImage)
    assert image.encoding == "jpeg"
    difference = decode_color(image, 0).astype(int) - frame.color
    assert np.abs(difference).mean() < 2
