"""A burst of a recording begins with who was seen in the frames before it."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from adibas.data.markers import is_numbered
from adibas.errors import MarkerError, RecordingError
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.pose_following import LONGEST_APART_S, SOON_S
from adibas.pipeline.posture import PostureParams
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.pipeline.seen_before import _few_before, seen_before
from adibas.pipeline.session import PostureRequest, find_in_recording
from adibas.recordings import open_recording
from tests.unit.films import BENT, filmed

DEEPEST = len(BENT) // 2


@pytest.fixture(scope="module")
def bending(tmp_path_factory):
    path = tmp_path_factory.mktemp("bend") / "bend.mcap"
    return path, filmed(path, BENT, seed=7, gesture="bend")


def found(path, frames):
    wish = ProtocolWish(find_protocol("joints-15"))
    request = PostureRequest(path, "led", frames=frames, view="anterior", protocol=wish)
    return find_in_recording(request, lambda _done, _all: None)


@pytest.mark.parametrize("seed", [1, 7])
def test_a_burst_of_who_bends_down_has_the_markers_by_the_frames_before(seed, tmp_path):
    """Trunk level, hips out of sight: knees lie as far from the shoulders as hips do upright."""
    path = tmp_path / "bend.mcap"
    truth = filmed(path, BENT, seed=seed, gesture="bend")
    for deep in (DEEPEST, DEEPEST + 3):
        visible = {name: one for name, one in truth[deep].items() if one.is_visible}
        seen = found(path, (deep, deep + 1))
        named = {one.label: one for one in seen.markers if not is_numbered(one.label)}
        assert len(named.keys() & visible.keys()) >= len(visible) - 1
        for name, one in named.items():
            at = truth[deep][name]
            assert np.hypot(one.u - at.u, one.v - at.v) < 3.0
        assert seen.namer.knows_body


def test_without_frames_before_nobody_is_seen(tmp_path):
    path = tmp_path / "bent.mcap"
    filmed(path, BENT[DEEPEST : DEEPEST + 1], seed=7, gesture="bend")
    with pytest.raises(MarkerError, match="Nobody is seen"):
        found(path, (0, 1))


def test_a_frame_before_that_cannot_be_read_is_left_out(bending):
    path, _truth = bending
    with open_recording(path) as recording:
        calibration, read = recording.info.calibration, recording.read
        *_, cut = _few_before(recording, DEEPEST)

        def torn(index):
            if index == cut:
                raise RecordingError("torn")
            return read(index)

        reader = SimpleNamespace(
            info=recording.info, timestamps_ns=recording.timestamps_ns, read=torn
        )
        assert seen_before(reader, DEEPEST, calibration, PostureParams()) is not None
        assert seen_before(recording, 0, calibration, PostureParams()) is None


@given(
    st.lists(st.integers(0, 400), min_size=1, max_size=400),
    st.integers(0, 399),
)
@example([45] * 400, 350)
def test_frames_before_follow_closely_and_reach_ten_seconds_back(gaps_ms, first):
    times_ms = np.cumsum(gaps_ms)
    first = min(first, len(times_ms) - 1)
    chosen = _few_before(SimpleNamespace(timestamps_ns=times_ms * 10**6), first)
    assert chosen == sorted(set(chosen))
    followed = [*chosen, first]
    for one, after in pairwise(followed):
        is_soon = times_ms[after] - times_ms[one] <= 1000 * SOON_S
        assert is_soon or after == one + 1, "no frame between them would be soon enough"
        assert one == 0 or after == one + 1 or times_ms[after] - times_ms[one - 1] > 1000 * SOON_S
    earliest_ms = times_ms[first] - 1000 * LONGEST_APART_S
    assert all(times_ms[index] >= earliest_ms for index in chosen)
    in_reach = [index for index in range(first) if times_ms[index] >= earliest_ms]
    assert not in_reach or chosen


def test_a_clock_that_was_set_back_stands_still_meanwhile():
    times_ms = 45 * np.arange(100)
    times_ms[60:] -= 2700
    chosen = _few_before(SimpleNamespace(timestamps_ns=times_ms * 10**6), 99)
    assert chosen == [0, *range(3, 56, 4)]
