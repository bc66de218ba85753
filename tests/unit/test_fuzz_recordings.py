"""Mutated recordings: a recording or a clear error, never a crash, a hang or a memory bomb.

ADIBAS_FUZZ_CASES says how many of each format (100 if unset).
"""

import os
import random
import resource
import shutil
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from adibas.data.frames import SourceInfo
from adibas.errors import AdibasError
from adibas.recordings import RecordingOptions, create_recording, mcap_records, open_recording
from adibas.recordings.decoding import to_rgbd
from tests.unit.recorded_frames import INFO, make_frames, write_frames

N_CASES = int(os.environ.get("ADIBAS_FUZZ_CASES", "100"))
MAX_SECONDS = 10.0
MAX_MEGABYTES = 512
NUMBERS = (0, 1, 0x7F, 0x80, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1)


def mutate(data, rng):
    """Change bytes, numbers and lengths, cut, repeat or move pieces."""
    mutated = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        at = rng.randrange(max(1, len(mutated)))
        other = rng.randrange(max(1, len(mutated)))
        length = min(rng.choice((1, 4, 8, 40, 400)), len(mutated) - at)
        size = rng.choice((1, 2, 4, 8))
        number = (rng.choice(NUMBERS) % 2 ** (8 * size)).to_bytes(size, "little")
        piece = mutated[other : other + length]
        end, new = rng.choice(
            (
                (at + 1, rng.randbytes(1)),
                (at + size, number),
                (len(mutated), b""),
                (at + length, b""),
                (at, piece),
                (at + length, rng.randbytes(length)),
                (at + length, piece),
            )
        )
        mutated[at:end] = new
    return bytes(mutated)


def read_everything(path):
    """Open and read every frame; return whether anything was refused."""
    refused = False
    try:
        reader = open_recording(path)
    except AdibasError as error:
        str(error)  # its fields are all there
        return True
    with reader:
        assert len(reader) == len(reader.timestamps_ns)
        for index in range(min(len(reader), 50)):
            try:
                frame = reader.read(index)
                to_rgbd(frame, reader.info)
            except AdibasError as error:
                str(error)
                refused = True
    return refused


def peak_megabytes():
    factor = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * factor / 2**20


def small_frames(encoding):
    """Frames small enough that mutations hit lengths and heads as often as pixels."""
    rng = np.random.default_rng(4)
    smooth = np.cumsum(rng.integers(-1, 2, (12, 16)), axis=1).astype(np.uint16)
    return [
        replace(frame, depth_raw=smooth.copy(), infrared_raw=smooth.copy())
        for frame in make_frames(3, encoding)
    ]


@pytest.fixture
def seeds(tmp_path):
    """Two valid recordings of each format."""
    made = {}
    for kind, name in (("mcap", ".mcap"), ("oni", ".oni"), ("tum", "")):
        for encoding in ("jpeg", "array"):
            path = tmp_path / "seeds" / f"{encoding}{name}"
            info = INFO if encoding == "jpeg" else SourceInfo()
            options = RecordingOptions(is_plain=encoding == "array")
            write_frames(create_recording(path, info, options), small_frames(encoding))
            assert not read_everything(path)
            made.setdefault(kind, []).append(path)
    return made


def count_refused(make_case):
    """Read `N_CASES` mutations, none of which may hang or take memory; return how many failed."""
    n_refused = 0
    limit_megabytes = peak_megabytes() + MAX_MEGABYTES
    for case in range(N_CASES):
        path = make_case(case, random.Random(case))
        start_s = time.process_time()
        n_refused += read_everything(path)
        assert time.process_time() - start_s < MAX_SECONDS, f"case {case} hangs"
        assert peak_megabytes() < limit_megabytes, f"case {case} takes too much memory"
    return n_refused


@pytest.mark.parametrize("kind", ["mcap", "oni"])
def test_mutated_files_are_read_or_refused(kind, seeds, tmp_path, capfd):
    originals = [path.read_bytes() for path in seeds[kind]]

    def make_case(case, rng):
        path = tmp_path / f"mutated.{kind}"
        path.write_bytes(mutate(originals[case % 2], rng))
        return path

    assert 0 < count_refused(make_case) < N_CASES
    capfd.readouterr()  # the image decoder grumbles


def test_mutated_images_behind_right_sums_are_read_or_refused(tmp_path, monkeypatch, capfd):
    genuine = mcap_records.pack_chunk

    def make_case(case, rng):
        def pack_mutated(messages, level):
            data = [
                mutate(message.data, rng) if rng.random() < 0.2 else message.data
                for message in messages
            ]
            return genuine([replace(m, data=d) for m, d in zip(messages, data, strict=True)], level)

        monkeypatch.setattr(mcap_records, "pack_chunk", pack_mutated)
        path = tmp_path / f"{case}.mcap"
        options = RecordingOptions(is_plain=case % 2 == 0)
        frames = small_frames("jpeg")[: rng.choice((1, 1, 3))]
        write_frames(create_recording(path, SourceInfo(), options), frames)
        return path

    assert 0 < count_refused(make_case) < N_CASES
    capfd.readouterr()


def test_mutated_folders_are_read_or_refused(seeds, tmp_path, capfd):
    def make_case(case, rng):
        folder = tmp_path / "mutated"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(seeds["tum"][case % 2], folder)
        texts = sorted(path for path in folder.iterdir() if path.is_file())
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        victim = rng.choice(texts if rng.random() < 0.6 else files)
        victim.write_bytes(mutate(victim.read_bytes(), rng))
        return folder

    assert 0 < count_refused(make_case) < N_CASES
    capfd.readouterr()
