"""Mutated files of every kind that is imported: read, or refused in a sentence.

ADIBAS_FUZZ_CASES says how many of each kind (30 if unset). `adibas benchmark reliability files`
gives each of them 100,000, guided by what they reach.
"""

import os
import random
import signal
from contextlib import contextmanager

import cv2
import numpy as np
import pytest

from adibas.limbs.training_set import decoded_png
from benchmarks import fuzz_seeds
from benchmarks.fuzz_importers import IMPORTERS, Trial
from benchmarks.mutating import mutate

N_CASES = int(os.environ.get("ADIBAS_FUZZ_CASES", "30"))
MAX_SECONDS = 20


@contextmanager
def at_most(seconds):
    """Stop what hangs, where the system has alarms."""
    if not hasattr(signal, "alarm"):
        yield
        return

    def stop(*_told):
        raise TimeoutError(f"still at work after {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture
def trial(request):
    opened = Trial(request.param)
    yield opened
    opened.close()


def named(*names):
    chosen = [one for one in IMPORTERS if not names or one.name in names]
    return pytest.mark.parametrize(
        "trial", chosen, indirect=True, ids=[one.name.replace(" ", "-") for one in chosen]
    )


@named()
def test_whole_files_are_read_and_mutated_ones_read_or_refused(trial, capfd):
    for data in trial.whole:
        assert trial.give(data) == "read"
    for case in range(N_CASES):
        data = mutate(trial.whole[case % len(trial.whole)], random.Random(case), is_text=case % 2)
        with at_most(MAX_SECONDS):
            assert trial.give(data) in ("read", "refused")
    capfd.readouterr()  # image decoders grumble


LONG_NUMBER = b"1" * 5000
DEEP = b"[" * 100_000


@named("boris", "gesture model", "skeleton model", "core and limbs", "joint model", "ethogram",
       "calibration", "protocol", "marker colours", "servers", "key file", "tum adibas.json",
       "labelled limbs", "progress of labelling")  # fmt: skip
@pytest.mark.parametrize("data", [LONG_NUMBER, DEEP, b"\xff", b"", b"null", b"NaN"])
def test_texts_that_no_json_parser_likes_are_refused(trial, data):
    # A protocol's mistakes are told in a list, and a folder without notes is another program's.
    assert trial.give(data) in ("read", "refused")


@named("labelled limbs")
@pytest.mark.parametrize("number", [b"1" + b"0" * 400, b"Infinity", b"NaN", b"-1"])
def test_a_length_that_no_camera_has_is_refused(trial, number):
    assert trial.give(trial.whole[0].replace(b"500.0", number, 1)) == "refused"


@named("progress of labelling")
def test_a_frame_whose_number_is_without_end_is_refused(trial):
    data = trial.whole[0]
    assert b"[0]" in data
    assert trial.give(data.replace(b"[0]", b"[Infinity]")) == "refused"


def test_a_png_is_unpacked_only_if_all_its_chunks_are_there(monkeypatch):
    """Room for the promised length would be taken before anything else is looked at."""
    image = np.arange(300, dtype=np.uint16).reshape(15, 20)
    whole = cv2.imencode(".png", image)[1].ravel()
    np.testing.assert_array_equal(decoded_png(whole), image)
    monkeypatch.setattr(cv2, "imdecode", lambda *_given: pytest.fail("was unpacked"))
    for n_left in range(len(whole)):
        assert decoded_png(whole[:n_left]) is None
    at = whole.tobytes().index(b"IDAT") - 4
    promising = whole.copy()
    promising[at : at + 4] = 0x7F
    assert decoded_png(promising) is None


def test_a_long_number_among_the_details_of_a_coding_is_refused():
    trial = Trial(next(one for one in IMPORTERS if one.name == "coding csv"))
    data = trial.whole[0]
    assert b'""date""' in data
    assert trial.give(data.replace(b'""date"": """"', b'""date"": ' + LONG_NUMBER)) == "refused"
    trial.close()


@named("elan")
def test_an_encoding_that_nobody_knows_is_refused(trial):
    head = b"<?xml version='1.0' encoding='"
    assert trial.whole[0].lower().startswith(head)
    changed = head + b"true" + trial.whole[0][trial.whole[0].index(b"'", len(head)) :]
    assert trial.give(changed) == "refused"


def head_of_array(text):
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text


@named("limb model arrays")
@pytest.mark.parametrize(
    "content",
    [
        b"no array",
        head_of_array(b"{'descr': '|u1', 'fortran_order': False, 'shape': ("),
        head_of_array(b"{'descr': '|u1' 'fortran_order'}"),
        head_of_array(
            b"{'descr': '|u1', 'fortran_order': False, 'shape': (9223372036854775807,), }"
        ),
        head_of_array(b"{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000000,), }"),
    ],
)
def test_arrays_with_a_head_that_is_wrong_are_refused(trial, content):
    for name in (b"header.npy", b"roots.npy"):
        parts = fuzz_seeds.in_one({name.decode(): content})
        assert trial.give(parts + without(trial.whole[0], name)) == "refused"


def without(parts, name):
    """Return parts one after the other but for the named one."""
    at = parts.index(name) - 4
    length = int.from_bytes(parts[at + 4 + len(name) :][:4], "little")
    return parts[:at] + parts[at + 8 + len(name) + length :]


@named("limb model")
@pytest.mark.parametrize("at", [4, 8, 30, 60, 100])
def test_an_archive_of_another_version_or_packing_is_refused(trial, at):
    data = bytearray(trial.whole[0])
    data[at] ^= 0xD8
    assert trial.give(bytes(data)) in ("read", "refused")
    directory = data.rindex(b"PK\x01\x02")
    data[directory + 6] = 216  # the version that is needed to unpack the last part
    assert trial.give(bytes(data)) == "refused"


@named("backup pieces")
def test_a_name_in_a_backup_that_is_no_text_is_refused(trial):
    assert trial.give(trial.whole[0].replace(b"Fpictures/ab", b"Fpictures/\xff\xfe")) == "refused"
