"""Who was taken for a person is followed on, but nothing else in that person's name."""

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration
from adibas.data.limbs import FULL_BODY, LimbParts
from adibas.data.sentence import Sentence
from adibas.geometry.pinhole import Intrinsics
from adibas.limbs.judging import CLEARLY, UNLIKE, Judgement, judge_likeness
from adibas.pipeline.pose_following import PoseEstimator
from adibas.pipeline.trust import CALM_S, DOUBT_S, N_ENOUGH, N_VERDICTS

CAMERA = CameraCalibration(64, 48, Intrinsics(60.0, 60.0, 31.5, 23.5))
DEPTH_M = np.full((48, 64), 2.0, np.float32)
HERE, NEAR, BESIDE, AT_EDGE = 20, 26, 33, 0
"""First columns of bodies: at 2 m a column is 33 mm wide."""
PERSON = Judgement(True, ())
CLEAR = Judgement(False, (Sentence(UNLIKE),), is_clear=True)
DOUBTFUL = Judgement(False, (Sentence(UNLIKE),))


def body(column):
    pixels = np.zeros(DEPTH_M.shape, np.bool_)
    pixels[8:40, column : column + 12] = True
    return pixels


def limbs(_depth_m, pixels):
    """So many limbs, one over the other, that these alone speak for a person."""
    rows = np.arange(len(pixels))[:, None]
    chosen = np.where(pixels, rows // 4 - 2, -1).astype(np.int16)
    sure = np.eye(len(FULL_BODY), dtype=np.float32)[chosen[pixels]]
    return LimbParts(FULL_BODY, pixels.copy(), sure, chosen)


def watched(columns_of, says, seconds, rate_hz=10):
    """Where people are found in each frame, and how often a judge was asked who says this."""
    asked = []
    now_s = 0.0

    def judge(_depth_m, pixels, *_told):
        asked.append(now_s)
        return says(int(pixels.any(axis=0).argmax()), now_s)

    estimator = PoseEstimator(CAMERA, limbs, judge=judge)
    found = []
    for number in range(round(seconds * rate_hz)):
        now_s = number / rate_hz
        people = estimator.look_at(DEPTH_M, [body(one) for one in columns_of(now_s)], now_s).people
        found.append([int(one.pixels.any(axis=0).argmax()) for one in people])
    return found, len(asked)


def test_a_thing_beside_a_trusted_person_is_judged_for_itself():
    found, _ = watched(
        lambda now_s: [HERE] if now_s < 1 else [BESIDE, HERE],
        lambda column, _now_s: PERSON if column == HERE else CLEAR,
        seconds=3,
    )
    assert found == [[HERE]] * len(found)


def test_a_thing_where_somebody_was_a_moment_ago_is_refused_before_long():
    found, _ = watched(
        lambda now_s: [HERE] if now_s < 1 else [NEAR],
        lambda column, _now_s: PERSON if column == HERE else CLEAR,
        seconds=15,
    )
    n_most = round(10 * (1 + CALM_S + (DOUBT_S + 0.1) * N_VERDICTS))
    assert found[:10] == [[HERE]] * 10
    assert found[n_most:] == [[]] * (len(found) - n_most)


def test_who_is_trusted_is_asked_about_in_less_than_one_of_a_hundred_frames():
    found, n_asked = watched(lambda _now_s: [HERE], lambda *_seen: PERSON, 20, rate_hz=30)
    assert all(found)
    assert 0 < n_asked - N_ENOUGH < len(found) / 100


@pytest.mark.parametrize(
    ("column", "later"),
    [
        (HERE, lambda now_s: CLEAR if now_s < CALM_S + DOUBT_S * (N_VERDICTS - 2) else PERSON),
        (HERE, lambda now_s: CLEAR if round(10 * now_s) % 4 else PERSON),
        (HERE, lambda _now_s: DOUBTFUL),
        (AT_EDGE, lambda _now_s: CLEAR),
    ],
    ids=["refused for two seconds", "refused now and then", "half hidden", "cut off"],
)
def test_a_trusted_person_who_is_badly_seen_is_followed_on(column, later):
    found, n_asked = watched(
        lambda _now_s: [column],
        lambda _column, now_s: PERSON if now_s < 1 else later(now_s),
        seconds=20,
    )
    assert all(found)
    assert (n_asked > N_ENOUGH) == (column != AT_EDGE)


def test_only_what_is_far_below_the_threshold_is_clearly_no_person():
    assert judge_likeness(-CLEARLY - 0.1, 0.0).is_clear
    assert not judge_likeness(-CLEARLY + 0.1, 0.0).is_clear
    assert not judge_likeness(1.0, 0.0).is_clear
