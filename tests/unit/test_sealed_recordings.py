"""Sealed recordings: bit-exact, unreadable, unchangeable unseen, whole after a crash."""

import base64
import errno
import json
import os
import random
import struct
import time
from dataclasses import replace

import numpy as np
import pytest
import zstandard
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from mcap.reader import make_reader

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import AdibasError, RecordingError, StoreError
from adibas.recordings import RecordingOptions, create_recording, mcap_sealed, open_recording
from adibas.recordings.part_file import PartFile
from adibas.sessions.sealed_recordings import SealedRecordings
from tests.unit.recorded_frames import (
    FRAME_NS,
    INFO,
    START_NS,
    assert_same_frame,
    assert_same_info,
    make_frames,
    write_frames,
)
from tests.unit.test_fuzz_recordings import MAX_MEGABYTES, mutate, peak_megabytes

KEY = bytes(range(32))
OTHER_KEY = bytes(range(1, 33))
ID, OTHER_ID = "ab" * 16, "0c" * 16
N_FUZZED = 100


@pytest.fixture
def recordings(tmp_path):
    return SealedRecordings(tmp_path / "recordings")


def record(recordings, frames, recording_id=ID, key=KEY, info=INFO, options=None):
    writer = recordings.create(recording_id, key, info, options or RecordingOptions())
    assert writer.recording_id == recording_id
    write_frames(writer, frames)
    return recordings.path_of(recording_id)


def assert_reads(recordings, frames, recording_id=ID):
    with recordings.open(recording_id, KEY) as reader:
        assert len(reader) == len(frames)
        assert [frame.timestamp_ns for frame in frames] == reader.timestamps_ns.tolist()
        for got, want in zip(reader, frames, strict=True):
            assert_same_frame(got, want)
        return reader.notice


def chunk_starts(path):
    """Begin and end of each chunk with its message indexes, found by the independent library."""
    with path.open("rb") as file:
        indexes = make_reader(file).get_summary().chunk_indexes
    return [
        (c.chunk_start_offset, c.chunk_start_offset + c.chunk_length + c.message_index_length)
        for c in sorted(indexes, key=lambda c: c.chunk_start_offset)
    ]


@pytest.mark.parametrize("encoding", ["jpeg", "png", "array"])
def test_frames_come_back_bit_by_bit_with_infrared_and_description(recordings, encoding):
    frames = make_frames(5, encoding, infrared=True)
    record(recordings, frames)
    assert assert_reads(recordings, frames) is None
    with recordings.open(ID, KEY) as reader:
        assert_same_info(reader.info, INFO)
        assert reader.info.n_dropped == 3
        assert_same_frame(reader.read_at(START_NS + 3 * FRAME_NS + 5), frames[3])
        if encoding != "array":
            assert [f.color.payload for f in reader] == [f.color.payload for f in frames]


@pytest.mark.parametrize("missing", ["depth", "color"])
def test_frames_of_one_kind_of_image_come_back(recordings, missing):
    frames = make_frames(3, **{missing: False})
    record(recordings, frames, info=SourceInfo())
    assert_reads(recordings, frames)


def test_a_recording_without_frames_is_one(recordings):
    record(recordings, [])
    assert assert_reads(recordings, []) is None


def test_a_plain_recording_is_not_asked_of_a_seal(recordings):
    frames = make_frames(2)
    record(recordings, frames, options=RecordingOptions(is_plain=True))
    assert_reads(recordings, frames)


def test_the_documented_layout_is_opened_by_hand(recordings, tmp_path):
    frames = make_frames(3)
    path = record(recordings, frames)
    plain = tmp_path / "plain.mcap"
    write_frames(create_recording(plain, INFO), frames)

    def opened(place, sealed):
        place = f"adibas-recording-1/{ID}/{place}".encode()
        return AESGCM(KEY).decrypt(sealed[:12], sealed[12:], place)

    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        messages = list(reader.iter_messages())
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    topics = [(channel.topic, m.sequence, m.log_time) for _, channel, m in messages]
    assert topics == [(topic, i, i) for i in range(3) for topic in ("/head", "/frame")]

    info = json.loads(opened("info", base64.b64decode(metadata["adibas"]["sealed"])))
    assert info["sensor_serial"] == INFO.sensor_serial
    end = metadata["adibas.end"]
    assert json.loads(opened("end", base64.b64decode(end["sealed"])))["n_dropped"] == "3"
    table = zstandard.decompress(opened("table", base64.b64decode(end["table"])))
    rows = np.frombuffer(table, "<i8").reshape(3, 2).cumsum(axis=0)
    assert rows.tolist() == [[frame.sequence, frame.timestamp_ns] for frame in frames]

    for i, frame in enumerate(frames):
        head = opened(f"head/{i}", messages[2 * i][2].data)
        assert struct.unpack("<QQ", head) == (frame.sequence, frame.timestamp_ns)
        content = opened(f"frame/{i}", messages[2 * i + 1][2].data)
        start = chunk_starts(plain)[i][0]
        assert plain.read_bytes()[start + 9 :].startswith(content)
        size, compressed = struct.unpack_from("<Q", content, 16)[0], content[28 + 8 + 8 :]
        assert content[28:36] == b"\4\0\0\0zstd"
        assert frame.color.payload in zstandard.decompress(compressed, max_output_size=size)


def test_nothing_but_numbers_and_sizes_can_be_read(recordings):
    frames = make_frames(6)
    path = record(recordings, frames)
    data = path.read_bytes()
    for text in (INFO.sensor_name, INFO.sensor_serial, "calibration", "depth", "color", ID):
        assert text.encode() not in data
    for frame in frames:
        assert struct.pack("<Q", frame.timestamp_ns) not in data
        assert frame.color.payload[100:116] not in data
    nonces = set()
    with path.open("rb") as file:
        for _, _, message in make_reader(file).iter_messages():
            nonces.add(message.data[:12])
    assert len(nonces) == 2 * len(frames)


def test_another_key_is_told(recordings):
    record(recordings, make_frames(2))
    with pytest.raises(StoreError, match="cannot be opened"):
        recordings.open(ID, OTHER_KEY)


def test_a_recording_under_another_name_is_refused(recordings):
    path = record(recordings, make_frames(2))
    recordings.path_of(OTHER_ID).parent.mkdir()
    path.rename(recordings.path_of(OTHER_ID))
    with pytest.raises(StoreError, match="cannot be opened"):
        recordings.open(OTHER_ID, KEY)
    with pytest.raises(StoreError, match="is missing from the store"):
        recordings.open(ID, KEY)


def test_a_recording_that_is_not_sealed_does_not_pass_for_a_sealed_one(recordings):
    record(recordings, make_frames(2))
    plain = recordings.folder / "plain.mcap"
    recordings.export(ID, KEY, plain)
    plain.replace(recordings.path_of(ID))
    with pytest.raises(StoreError, match="cannot be opened"):
        recordings.open(ID, KEY)


def test_who_opens_a_sealed_file_without_the_store_is_told(recordings):
    path = record(recordings, make_frames(2))
    with pytest.raises(RecordingError, match=r"is sealed. Open the store"):
        open_recording(path)


def test_a_frame_in_the_place_of_another_is_refused(recordings):
    frames = make_frames(4, encoding="png", depth=False)
    frames[2] = SensorFrame(102, frames[2].timestamp_ns, None, frames[1].color, 0)
    path = record(recordings, frames)
    data = path.read_bytes()
    chunks = chunk_starts(path)
    (a, b), (c, d) = chunks[1], chunks[2]
    swapped = data[:a] + data[c:d] + data[a:b] + data[d:]
    assert len(swapped) == len(data)
    path.write_bytes(swapped)
    with recordings.open(ID, KEY) as reader:
        assert_same_frame(reader.read(0), frames[0])
        for index in (1, 2):
            with pytest.raises(RecordingError, match=f"Frame {index} .* damaged"):
                reader.read(index)
        assert_same_frame(reader.read(3), frames[3])


def test_a_frame_taken_out_of_the_middle_is_missed(recordings):
    frames = make_frames(5)
    path = record(recordings, frames)
    data = path.read_bytes()
    start, end = chunk_starts(path)[2]
    path.write_bytes(data[:start] + data[end:])
    notice = assert_reads(recordings, frames[:2])
    assert "is cut" in notice


def test_the_true_end_does_not_fit_frames_that_were_cut_off(recordings, monkeypatch):
    """Who cuts frames off and mends every sum and number still cannot forge the sealed end."""
    ends = []
    genuine = mcap_sealed.seal_end

    def keep(*values):
        ends.append(genuine(*values))
        return ends[0] | {"n_frames": ends[-1]["n_frames"]}

    monkeypatch.setattr(mcap_sealed, "seal_end", keep)
    frames = make_frames(5)
    record(recordings, frames)
    assert assert_reads(recordings, frames) is None
    record(recordings, frames[:3])
    assert "is cut" in assert_reads(recordings, frames[:3])


def outcome(recordings, frames):
    """Read everything; wrong data must not come out. Return whether anything was refused."""
    try:
        reader = recordings.open(ID, KEY)
    except AdibasError as error:
        str(error)
        return True
    refused = reader.notice is not None
    with reader:
        assert len(reader) <= len(frames)
        for index in range(len(reader)):
            try:
                got = reader.read(index)
            except AdibasError as error:
                str(error)
                refused = True
                continue
            assert_same_frame(got, frames[index])
            assert reader.timestamps_ns[index] == frames[index].timestamp_ns
    return refused


def tiny_frames(n_frames=3):
    rng = np.random.default_rng(5)
    return [
        SensorFrame(i, START_NS + i * FRAME_NS, rng.integers(0, 9, (3, 4), dtype=np.uint16))
        for i in range(n_frames)
    ]


@pytest.mark.parametrize("is_sum_removed", [False, True])
def test_every_changed_bit_of_a_frame_is_refused(recordings, is_sum_removed):
    frames = tiny_frames()
    path = record(recordings, frames, info=SourceInfo())
    whole = bytearray(path.read_bytes())
    start = chunk_starts(path)[1][0]
    end = start + 9 + struct.unpack_from("<Q", whole, start + 1)[0]
    if is_sum_removed:
        whole[start + 9 + 24 : start + 9 + 28] = bytes(4)  # MCAP: there is no sum
        path.write_bytes(whole)
        assert not outcome(recordings, frames)
    head_size = 9 + 22 + 12 + 16 + 16
    first = start + 9 + 28 + 4 + 8 + head_size + 9 + 22 if is_sum_removed else start + 9 + 28 + 12
    for bit in range(8 * first, 8 * end):
        changed = whole.copy()
        changed[bit // 8] ^= 1 << bit % 8
        path.write_bytes(changed)
        assert outcome(recordings, frames), f"bit {bit - 8 * start} of the chunk"


def test_no_changed_byte_gives_a_wrong_frame(recordings):
    frames = tiny_frames(2)
    path = record(recordings, frames, info=SourceInfo())
    whole = path.read_bytes()
    refused = 0
    for at in range(len(whole)):
        changed = bytearray(whole)
        changed[at] ^= 1 << at % 8
        path.write_bytes(changed)
        refused += outcome(recordings, frames)
    assert refused > len(whole) // 2


def test_a_hundred_mutated_recordings_are_read_or_refused(recordings):
    frames = make_frames(3)
    path = record(recordings, frames)
    whole = path.read_bytes()
    limit_megabytes = peak_megabytes() + MAX_MEGABYTES
    refused = 0
    for case in range(N_FUZZED):
        path.write_bytes(mutate(whole, random.Random(case)))
        start_s = time.process_time()
        refused += outcome(recordings, frames)
        assert time.process_time() - start_s < 10, f"case {case} hangs"
        assert peak_megabytes() < limit_megabytes, f"case {case} takes too much memory"
    assert 0 < refused <= N_FUZZED


@pytest.mark.parametrize("n_kept", [0, 1, 3, 5])
def test_what_a_crash_left_becomes_a_recording_of_its_whole_frames(recordings, n_kept):
    frames = make_frames(5)
    path = record(recordings, frames)
    starts = chunk_starts(path)
    n_bytes = starts[n_kept][0] + 50 if n_kept < 5 else starts[4][1]
    part = path.with_name(f"{ID}.part.sealed")
    part.write_bytes(path.read_bytes()[:n_bytes])
    path.unlink()
    assert recordings.ids() == set()
    assert recordings.unfinished() == {ID}
    with pytest.raises(StoreError, match="cannot be opened"):
        recordings.recover(ID, OTHER_KEY)
    assert part.exists()
    assert recordings.recover(ID, KEY) == n_kept
    assert recordings.unfinished() == set()
    assert recordings.recover(ID, KEY) is None
    if n_kept:
        notice = assert_reads(recordings, frames[:n_kept])
        assert ("is cut" if n_kept < 5 else "interrupted") in notice
    else:
        assert recordings.ids() == set()


def test_an_empty_file_that_a_power_cut_left_is_removed(recordings):
    part = recordings.path_of(ID).with_name(f"{ID}.part.sealed")
    part.parent.mkdir(parents=True)
    part.touch()
    assert recordings.recover(ID, KEY) == 0
    assert not part.exists()


def test_the_rest_of_a_file_with_a_damaged_beginning_is_left_alone(recordings):
    part = recordings.path_of(ID).with_name(f"{ID}.part.sealed")
    part.parent.mkdir(parents=True)
    part.write_bytes(bytes(500))
    with pytest.raises(StoreError, match="cannot be opened"):
        recordings.recover(ID, KEY)
    assert part.exists()


def test_recordings_are_listed_when_they_are_closed(recordings):
    writer = recordings.create(ID, KEY, INFO, RecordingOptions())
    writer.write(make_frames(1)[0])
    assert recordings.ids() == set()
    assert recordings.unfinished() == {ID}
    writer.close()
    writer.close()
    assert recordings.ids() == {ID}
    assert recordings.unfinished() == set()


def test_a_deleted_recording_is_gone_finished_or_not(recordings):
    record(recordings, make_frames(1))
    other = recordings.create(OTHER_ID, KEY, INFO, RecordingOptions())
    other.write(make_frames(1)[0])
    recordings.delete(ID)
    recordings.delete(OTHER_ID)
    assert not list(recordings.folder.rglob("*.sealed"))
    other.abandon()


def test_an_export_is_plain_and_shown_by_any_reader(recordings, tmp_path):
    frames = make_frames(4, infrared=True)
    record(recordings, frames)
    seen = []
    path = tmp_path / "out" / "session.mcap"
    recordings.export(ID, KEY, path, lambda done, total: seen.append((done, total)))
    assert seen == [(i, 4) for i in range(1, 5)]
    with path.open("rb") as file:
        schemas = {
            channel.topic: schema.name for schema, channel, _ in make_reader(file).iter_messages()
        }
    assert schemas["/depth"] == "foxglove.RawImage"
    assert schemas["/color"] == "foxglove.CompressedImage"
    with open_recording(path) as reader:
        assert_same_info(reader.info, INFO)
        for got, want in zip(reader, frames, strict=True):
            assert_same_frame(got, want)


def test_an_export_of_a_damaged_recording_leaves_nothing(recordings, tmp_path):
    path = record(recordings, make_frames(3))
    start, _ = chunk_starts(path)[1]
    with path.open("r+b") as file:
        file.seek(start + 500)
        file.write(b"\xff\xff\xff\xff")
    with pytest.raises(RecordingError, match="Frame 1"):
        recordings.export(ID, KEY, tmp_path / "out.mcap")
    assert not list(tmp_path.glob("*.mcap"))


def test_what_a_killed_export_left_goes_with_the_next_one(recordings, tmp_path):
    record(recordings, make_frames(6))
    path = tmp_path / "out.mcap"
    recordings.export(ID, KEY, path)
    whole = path.read_bytes()
    left = [tmp_path / "out.part.mcap", tmp_path / "out.part2.mcap"]
    for number, part in enumerate(left, 1):
        part.write_bytes(whole[: number * len(whole) // 3])
    recordings.export(ID, KEY, path)
    assert [item.name for item in tmp_path.glob("*.mcap")] == ["out.mcap"]


def test_what_was_left_of_another_recording_is_not_touched_by_an_export(recordings, tmp_path):
    record(recordings, make_frames(3))
    other = [replace(frame, timestamp_ns=frame.timestamp_ns + 1) for frame in make_frames(3)]
    part = tmp_path / "out.part.mcap"
    with create_recording(part, INFO) as writer:
        for frame in other:
            writer.write(frame)
    (tmp_path / "out.part2.mcap").write_bytes(b"no recording")
    recordings.export(ID, KEY, tmp_path / "out.mcap")
    names = {"out.mcap", "out.part.mcap", "out.part2.mcap"}
    assert {item.name for item in tmp_path.glob("*.mcap")} == names


def test_a_full_disk_is_told_and_keeps_the_frames(recordings, monkeypatch):
    frames = make_frames(4)
    writer = recordings.create(ID, KEY, INFO, RecordingOptions())
    writer.write(frames[0])
    writer.write(frames[1])
    genuine = PartFile._write

    def write(self, data):
        genuine(self, data[:1000])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(PartFile, "_write", write)
    with pytest.raises(StoreError, match=r"disk is full. Its frames until now are kept"), writer:
        writer.write(frames[2])
    with pytest.raises(StoreError, match="cannot be saved: the disk is full"):
        recordings.create(OTHER_ID, KEY, INFO, RecordingOptions())
    monkeypatch.undo()
    assert recordings.unfinished() == {ID}
    assert recordings.recover(ID, KEY) == 2
    assert_reads(recordings, frames[:2])


def test_a_frame_that_no_recording_holds_is_told_as_such(recordings):
    writer = recordings.create(ID, KEY, INFO, RecordingOptions())
    with pytest.raises(RecordingError, match="cannot hold frame"):
        writer.write(SensorFrame(-1, 0, np.ones((2, 2), np.uint16)))
    writer.abandon()
    assert recordings.unfinished() == set()


def test_frames_reach_the_disk_within_a_second(recordings, monkeypatch):
    now_s = [time.monotonic()]
    synced = []
    writer = recordings.create(ID, KEY, SourceInfo(), RecordingOptions())
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])
    monkeypatch.setattr(os, "fsync", lambda _: synced.append(now_s[0]))
    start_s = now_s[0]
    with writer:
        for frame in tiny_frames(90):
            now_s[0] += 1 / 30
            writer.write(frame)
    assert np.diff([start_s, *synced]).max() <= 1.0 + 1 / 30 + 1e-9
