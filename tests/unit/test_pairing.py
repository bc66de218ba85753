"""Two streams of one sensor belong together by their timestamps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.sensors.pairing import FramePairer, StreamImage, join_images

PERIOD_NS = 33_333_333


def image(index, timestamp_ns, dtype=np.uint16):
    shape = (2, 2, 3) if dtype == np.uint8 else (2, 2)
    return StreamImage(index, timestamp_ns, np.full(shape, index % 250, dtype))


def pair_up(events):
    """Feed (time, stream, index) in order of arrival; return pairs of indices."""
    pairer = FramePairer(PERIOD_NS)
    pairs = []
    for timestamp_ns, stream, index in events:
        if stream == "depth":
            pairer.add_depth(image(index, timestamp_ns))
        else:
            pairer.add_second(image(index, timestamp_ns))
        while (pair := pairer.next_pair()) is not None:
            pairs.append((pair[0].index, pair[1].index))
    while (pair := pairer.next_pair(is_final=True)) is not None:
        pairs.append((pair[0].index, pair[1].index))
    return pairs


@given(offset=st.floats(-0.49, 0.49), jitter_seed=st.integers(0, 1000))
def test_every_colour_image_gets_its_nearest_depth_image(offset, jitter_seed):
    jitter = np.random.default_rng(jitter_seed).uniform(-0.02, 0.02, (2, 20))
    depths = {i: round((i + 1 + jitter[0, i]) * PERIOD_NS) for i in range(20)}
    colors = {i: round((i + 1 + offset + jitter[1, i]) * PERIOD_NS) for i in range(20)}
    events = sorted(
        [(t, "depth", i) for i, t in depths.items()] + [(t, "color", i) for i, t in colors.items()]
    )
    pairs = pair_up(events)
    assert len({depth for depth, _ in pairs}) == len(pairs), "a depth image was used twice"
    assert [color for _, color in pairs] == sorted(color for _, color in pairs)
    for depth, color in pairs:
        assert abs(depths[depth] - colors[color]) <= 0.6 * PERIOD_NS
    if abs(offset) < 0.45:
        assert pairs == [(i, i) for i in range(20)]


def test_a_slow_colour_stream_sets_the_pace():
    events = [(i * PERIOD_NS, "depth", i) for i in range(12)]
    events += [(3 * i * PERIOD_NS + 1000, "color", i) for i in range(4)]
    assert pair_up(sorted(events)) == [(0, 0), (3, 1), (6, 2), (9, 3)]


def test_a_colour_image_whose_depth_was_lost_is_left_out():
    events = [(i * PERIOD_NS, "depth", i) for i in range(6) if i != 3]
    events += [(i * PERIOD_NS, "color", i) for i in range(6)]
    assert pair_up(sorted(events)) == [(i, i) for i in range(6) if i != 3]


def test_the_order_of_arrival_does_not_matter():
    events = [(i * PERIOD_NS, stream, i) for i in range(5) for stream in ("color", "depth")]
    assert pair_up(events) == [(i, i) for i in range(5)]


def test_depth_alone_needs_no_partner():
    pairer = FramePairer(PERIOD_NS, is_depth_alone=True)
    assert pairer.next_pair() is None
    pairer.add_depth(image(7, 123))
    depth, second = pairer.next_pair()
    assert (depth.index, second) == (7, None)
    assert join_images(depth, second, is_infrared=False).sequence == 7


@pytest.mark.parametrize("is_infrared", [True, False])
def test_the_second_stream_counts_and_the_depth_gives_the_time(is_infrared):
    second = image(3, 500, np.uint16 if is_infrared else np.uint8)
    frame = join_images(image(9, 400), second, is_infrared=is_infrared)
    assert (frame.sequence, frame.timestamp_ns) == (3, 400)
    assert (frame.infrared_raw is None, frame.color is None) == (not is_infrared, is_infrared)
    assert frame.color_timestamp_ns == (None if is_infrared else 500)
