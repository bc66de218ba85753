"""RVL: without loss for any image, and harmless for any bytes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adibas.errors import RecordingError
from adibas.recordings.rvl import MAX_PIXELS, decode_rvl, encode_rvl

any_value = st.sampled_from([0, 0, 1, 2, 800, 801, 32767, 32768, 65534, 65535]) | st.integers(
    0, 65535
)
images = arrays(
    np.uint16, st.tuples(st.integers(1, 9), st.integers(1, 17)), elements=any_value, fill=any_value
)


def words_by_the_paper(depth):
    """The published C code, word for word: pieces into 32-bit words, high bits first."""
    pieces = []

    def put(value):
        while True:
            piece, value = value & 7, value >> 3
            pieces.append(piece | (8 if value else 0))
            if not value:
                return

    flat = [int(value) for value in depth.ravel()]
    i, previous = 0, 0
    while i < len(flat):
        start = i
        while i < len(flat) and flat[i] == 0:
            i += 1
        put(i - start)
        start = i
        while i < len(flat) and flat[i] != 0:
            i += 1
        put(i - start)
        for value in flat[start:i]:
            delta = value - previous
            put(2 * delta if delta >= 0 else -2 * delta - 1)
            previous = value
    pieces += [0] * (-len(pieces) % 8)
    words = [
        sum(piece << (28 - 4 * k) for k, piece in enumerate(pieces[j : j + 8]))
        for j in range(0, len(pieces), 8)
    ]
    return np.array(words, "<u4").tobytes()


@given(images)
def test_every_image_comes_back_bit_by_bit(depth):
    np.testing.assert_array_equal(decode_rvl(encode_rvl(depth), depth.shape), depth)


@given(images)
def test_the_bytes_are_those_of_the_published_code(depth):
    assert encode_rvl(depth) == words_by_the_paper(depth)


def test_every_depth_value_and_the_largest_steps_survive():
    depth = np.empty((256, 512), np.uint16)
    depth[:, ::2] = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    depth[:, 1::2] = 65535 - depth[:, ::2]
    np.testing.assert_array_equal(decode_rvl(encode_rvl(depth), depth.shape), depth)


@given(st.binary(max_size=64), st.integers(0, 40), st.integers(0, 40))
def test_any_bytes_give_an_image_or_a_recording_error(data, height, width):
    try:
        image = decode_rvl(data, (height, width))
    except RecordingError:
        return
    assert image.shape == (height, width)


@given(images, st.data())
def test_a_cut_or_longer_image_is_refused(depth, data):
    encoded = encode_rvl(depth)
    n_bytes = data.draw(st.integers(0, len(encoded) - 1))
    with pytest.raises(RecordingError):
        decode_rvl(encoded[:n_bytes], depth.shape)
    with pytest.raises(RecordingError):
        decode_rvl(encoded + b"\0\0\0\0", depth.shape)


def test_a_size_beyond_reason_is_refused_before_memory_is_taken():
    with pytest.raises(RecordingError):
        decode_rvl(encode_rvl(np.zeros((1, 8), np.uint16)), (MAX_PIXELS, 1024))
