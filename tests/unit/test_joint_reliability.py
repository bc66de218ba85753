"""Confidences that are shares of right joints: the curves, who they hold for, and their file."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.isotonic import IsotonicRegression

from adibas.data.calibration import CameraCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.errors import FileError
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline import shipped_json
from adibas.pipeline.pose_model import joint_model_for
from adibas.pipeline.reliability_file import shipped_reliability
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.picture import Picture
from adibas.skeleton.reliability import (
    LEAST_SHARE,
    PRIOR_JOINTS,
    Curve,
    Reliability,
    all_situations,
    fit_curve,
    pooled,
    reliability_from_json,
    reliability_to_json,
    situations,
)

FAR_M, CLOSE_TO_ALL_M = np.full(4, 1.0), np.full(4, 0.1)
UNCUT = (False, False, False, False)
TOP, BOTTOM, LEFT, RIGHT = (tuple(k == edge for k in range(4)) for edge in range(4))


def number(name):
    return JOINT_NAMES.index(name)


def picture(is_cut):
    camera = CameraCalibration(640, 480, Intrinsics(600.0, 600.0, 320.0, 240.0))
    return Picture(camera, (0, 480, 0, 640), is_cut)


def made(**shares):
    """Curves that are flat: of each situation the share given here, else 0.9."""
    names = {one.replace("_", " "): share for one, share in shares.items()}
    return Reliability(
        {
            name: Curve(np.array([0.5]), np.array([names.get(name, 0.9)]))
            for name in all_situations()
        }
    )


@given(st.lists(st.tuples(st.floats(0, 1), st.floats(0.1, 10)), min_size=1, max_size=20))
def test_pooling_is_isotonic_regression(pairs):
    shares, weights = np.array(pairs).T
    places = np.arange(len(shares))
    expected = IsotonicRegression().fit(places, shares, weights).predict(places)
    np.testing.assert_allclose(pooled(shares, weights), expected, atol=1e-9)


def test_a_curve_tells_the_share_that_was_counted():
    rng = np.random.default_rng(0)
    confidences = rng.uniform(0, 1, 60_000)
    curve = fit_curve(confidences, rng.uniform(0, 1, 60_000) < confidences**2, 0.5)
    for confidence in (0.3, 0.5, 0.8):
        assert curve(confidence) == pytest.approx(confidence**2, abs=0.04)
    assert curve(0.0) <= curve(0.2) <= curve(1.0)


def test_where_nothing_was_counted_the_whole_situation_speaks():
    curve = fit_curve(np.empty(0), np.empty(0, np.bool_), 0.3)
    assert curve(0.1) == curve(0.9) == pytest.approx(0.3)
    few = fit_curve(np.array([0.9]), np.array([True]), 0.3)
    assert few(0.9) == pytest.approx((1 + 0.3 * PRIOR_JOINTS) / (1 + PRIOR_JOINTS))


def test_sides_that_lie_at_the_cut_edge_are_told_from_the_others():
    left, right = number("left_hand"), number("right_hand")
    assert situations(left, UNCUT, FAR_M, is_front=True) == ["whole hand"]
    assert situations(right, LEFT, FAR_M, is_front=True) == ["side near hand"]
    assert situations(left, LEFT, FAR_M, is_front=True) == ["side far hand"]
    assert situations(left, LEFT, FAR_M, is_front=False) == ["side near hand"]
    assert situations(left, RIGHT, FAR_M, is_front=True) == ["side near hand"]
    assert situations(number("head"), RIGHT, FAR_M, is_front=True) == ["side head"]
    both = situations(left, (False, True, False, True), FAR_M, is_front=True)
    assert both == ["bottom hand", "side near hand"]


def test_joints_close_to_the_edge_above_or_below_are_told_from_the_others():
    knee = number("left_knee")
    assert situations(knee, BOTTOM, CLOSE_TO_ALL_M, is_front=True) == ["bottom close knee"]
    assert situations(knee, BOTTOM, FAR_M, is_front=True) == ["bottom knee"]
    assert situations(knee, UNCUT, CLOSE_TO_ALL_M, is_front=True) == ["whole knee"]
    at_bottom = np.array([1.0, 0.1, 1.0, 1.0])
    both = situations(knee, (True, True, False, False), at_bottom, is_front=True)
    assert both == ["top knee", "bottom close knee"]


def test_joints_of_somebody_cut_off_that_are_mostly_wrong_are_not_seen():
    reliability = made(bottom_foot=LEAST_SHARE - 0.01, bottom_head=0.7, whole_hand=0.3)
    joints = ChosenJoints(np.tile([0.0, 0.0, 2.0], (15, 1)), np.full(15, 0.8), 0.9)
    cut = reliability.applied(joints, picture(BOTTOM))
    feet = [number("left_foot"), number("right_foot")]
    assert np.isnan(cut.joints_m[feet]).all()
    assert np.isnan(cut.confidence[feet]).all()
    assert cut.n_seen == 13
    assert cut.confidence[number("head")] == pytest.approx(0.7)
    whole = reliability.applied(joints, picture(UNCUT))
    assert whole.n_seen == 15, "of somebody seen whole all are given, with what they are worth"
    assert whole.confidence[number("left_hand")] == pytest.approx(0.3)


def test_how_far_inside_of_the_edge_a_joint_lies_decides_which_curve_holds():
    reliability = made(bottom_close_knee=0.1)
    heights_m = np.tile([0.0, 0.0, 2.0], (15, 1))
    left, right = number("left_knee"), number("right_knee")
    heights_m[left, 1], heights_m[right, 1] = 0.6, 0.4  # the edge is 0.8 m below the axis
    cut = reliability.applied(ChosenJoints(heights_m, np.full(15, 0.8), 0.9), picture(BOTTOM))
    assert np.isnan(cut.confidence[left])
    assert cut.confidence[right] == pytest.approx(0.9)


def test_joints_that_were_not_seen_stay_so():
    joints = ChosenJoints(np.full((15, 3), np.nan), np.full(15, np.nan), 0.5)
    assert made().applied(joints, picture(TOP)).n_seen == 0


def test_curves_come_back_out_of_their_file():
    document = reliability_to_json(made(top_head=0.25))
    again = reliability_from_json(json.loads(json.dumps(document)))
    assert again.curves["top head"](0.3) == 0.25
    for wrong in ({"format": "other"}, {"curves": {}}):
        with pytest.raises(ValueError, match="document"):
            reliability_from_json({**document, **wrong})
    falling = {"confidences": [0.1, 0.2], "shares": [0.9, 0.1]}
    document["curves"]["top head"] = falling
    with pytest.raises(ValueError, match="falls"):
        reliability_from_json(document)


def test_the_shipped_curves_are_of_the_shipped_model():
    """Else confidences would stay raw: ``python -m adibas.pipeline.reliability_training``."""
    assert joint_model_for(shipped_model()).reliability is shipped_reliability()


@pytest.mark.parametrize("content", [None, "{", "{}", '{"format": "adibas-joint-reliability"}'])
def test_a_broken_file_is_told(tmp_path, monkeypatch, content):
    if content is not None:
        (tmp_path / "reliability.json").write_text(content)
    monkeypatch.setattr(shipped_json, "resource_path", lambda *parts: tmp_path / parts[-1])
    with pytest.raises(FileError, match=r"reliability\.json is broken or missing"):
        shipped_reliability.__wrapped__()
