"""Where a recording stands still."""

import numpy as np
import pytest

from adibas.pipeline.still_moments import ChangeMeter, Moment, StillParams, still_moments

PARAMS = StillParams()
NOISE = 0.001


def shares(*parts):
    """Return the shares of (n frames, share of one) parts."""
    return np.concatenate([np.full(n, share) for n, share in parts])


def test_a_rest_between_two_ways_is_one_burst_in_its_middle():
    found = still_moments(shares((10, 0.2), (50, NOISE), (10, 0.2)), PARAMS)
    assert len(found) == 1
    assert found[0].last - found[0].first == PARAMS.n_frames
    assert found[0].middle == pytest.approx(9 + 51 / 2, abs=1)


def test_a_rest_shorter_than_20_frames_is_none():
    assert still_moments(shares((30, 0.2), (15, NOISE), (30, 0.2)), PARAMS) == ()
    found = still_moments(shares((30, 0.2), (21, NOISE), (30, 0.2)), PARAMS)
    assert [moment.last - moment.first for moment in found] == [22]


def test_a_long_rest_gives_several_bursts():
    found = still_moments(shares((300, NOISE)), PARAMS)
    assert [moment.first for moment in found] == [0, 90, 180, 270]
    assert found[-1] == Moment(270, 300)


def test_a_frame_without_depth_ends_a_rest():
    values = shares((25, NOISE), (1, np.nan), (25, NOISE))
    found = still_moments(values, PARAMS)
    assert len(found) == 2
    assert all(not moment.first < 25 < moment.last - 1 for moment in found)


def test_without_any_depth_nothing_is_still():
    assert still_moments(shares((40, np.nan)), PARAMS) == ()


def test_noise_is_no_change_and_another_surface_is():
    rng = np.random.default_rng(1)
    meter = ChangeMeter(0.001, PARAMS)

    def image(z_mm):
        depth = np.full((40, 40), z_mm) + rng.normal(0.0, 5.0, (40, 40))
        return depth.round().astype(np.uint16)

    assert meter.share(image(2000)) == 1.0
    assert meter.share(image(2000)) == 0.0
    half = image(2000)
    half[:, :20] = 1500
    assert meter.share(half) == pytest.approx(0.5)


def test_nothing_measured_or_another_size_counts_as_change():
    meter = ChangeMeter(0.001, PARAMS)
    assert meter.share(np.full((20, 20), 900, np.uint16)) == 1.0
    assert meter.share(np.zeros((20, 20), np.uint16)) == 1.0
    assert meter.share(np.full((24, 24), 900, np.uint16)) == 1.0
