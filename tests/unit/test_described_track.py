"""Descriptors made piece by piece are those of the whole track."""

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import track_of
from adibas.gestures.described_track import BLOCK, describe, described_in_pieces
from adibas.gestures.descriptor import NECK, DescriptorParams
from tests.unit.gesture_examples import body

RATE_HZ = 20.0


@pytest.fixture(scope="module")
def track():
    """Somebody who turns and wanders about, with hidden joints, a hidden neck and a break."""
    rng = np.random.default_rng(3)
    n_frames = round(2.2 * BLOCK * RATE_HZ / 15.0)
    angles = np.cumsum(rng.normal(0.0, 0.02, n_frames))
    x, y, z = np.moveaxis(np.tile(body(0, 0), (n_frames, 1, 1)), -1, 0)
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    joints_m = np.stack([cosine * x - sine * z, y, sine * x + cosine * z], axis=-1)
    joints_m += rng.normal(0.0, 0.01, joints_m.shape)
    for joint in range(len(JOINT_NAMES)):
        for begin in rng.integers(0, n_frames, 6):
            joints_m[begin : begin + rng.integers(1, 90), joint] = np.nan
    joints_m[3000:3040, NECK] = np.nan
    times_s = 7.0 + np.arange(n_frames) / RATE_HZ
    times_s[4000:] += 11.3
    return track_of(times_s, joints_m)


@pytest.mark.parametrize(
    "params", [DescriptorParams(), DescriptorParams(facing_s=0.0, velocity_s=0.0)]
)
def test_pieces_are_those_of_the_whole(track, params):
    whole, pieces = describe(track, params), described_in_pieces(track, params)
    n_frames = len(whole.frames)
    assert n_frames > 2 * BLOCK
    assert len(pieces.frames) == n_frames
    assert np.isnan(whole.frames).any()
    places = [0, 1, 2, 40, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK, n_frames - 1, n_frames]
    for begin in places:
        for end in (one for one in places if one > begin):
            piece = pieces.frames[begin:end]
            np.testing.assert_allclose(piece, whole.frames[begin:end], rtol=0, atol=1e-9)
    assert pieces.time_s(40) == whole.time_s(40)


def test_a_piece_beyond_the_end_is_cut_off(track):
    frames = described_in_pieces(track, DescriptorParams()).frames
    assert len(frames[len(frames) - 3 : len(frames) + 5]) == 3
    assert len(frames[5:5]) == 0
    assert len(frames[BLOCK:BLOCK]) == 0


def test_a_track_without_frames_is_refused():
    nothing = track_of(np.empty(0), np.empty((0, len(JOINT_NAMES), 3)))
    with pytest.raises(ValueError, match="without frames"):
        describe(nothing, DescriptorParams())
