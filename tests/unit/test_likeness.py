"""How much like a person something is: quantities, what is learned of them, and who is asked."""

import json

import numpy as np
import pytest
from scipy import ndimage

from adibas.data.calibration import CameraCalibration
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.data.limbs import FULL_BODY, LimbParts
from adibas.data.sentence import Sentence
from adibas.errors import FileError
from adibas.geometry.pinhole import Intrinsics
from adibas.limbs.figure import FIGURES, describe_figure
from adibas.limbs.judging import UNLIKE, Judgement, judge_likeness
from adibas.limbs.likeness import (
    LOST_SHARE,
    PART_QUANTITIES,
    describe_parts,
    learn_likeness,
    likeness_from_json,
    likeness_to_json,
)
from adibas.limbs.likeness_kernels import count_borders, find_pieces
from adibas.pipeline import shipped_json
from adibas.pipeline.likeness_file import shipped_likeness
from adibas.pipeline.likeness_training import people_shown, things_shown
from adibas.pipeline.person_judge import is_of, person_judge
from adibas.pipeline.pose_following import PoseEstimator
from adibas.pipeline.pose_model import shipped_joint_model
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.trust import N_ENOUGH
from adibas.simulation.limb_frames import LimbFrames
from adibas.simulation.lone_things import KINDS, ThingFrames
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.plausibility import ABSENT_M, PLAUSIBILITIES, describe_joints
from adibas.skeleton.proportions import ORDER, PARENTS
from benchmarks.limb_things import is_refused

FOCAL_PX = 100.0
DOWN = np.array([0.0, 1.0, 0.0])


def parts_of(labels, step=1, sure=0.9):
    """Parts as a forest that is that sure would give them; -1 is nobody."""
    pixels = np.zeros(labels.shape, np.bool_)
    pixels[::step, ::step] = labels[::step, ::step] >= 0
    probabilities = np.full((int(pixels.sum()), 15), (1 - sure) / 14, np.float32)
    probabilities[np.arange(len(probabilities)), labels[pixels]] = sure
    return LimbParts(FULL_BODY, pixels, probabilities, labels.astype(np.int16))


def named(labels, step=1):
    depth_m = np.where(labels >= 0, 2.0, np.nan).astype(np.float32)
    found = describe_parts(depth_m, labels >= 0, FOCAL_PX, parts_of(labels, step))
    return dict(zip(PART_QUANTITIES, found, strict=True))


def halves(first, second):
    """Two limbs side by side, with nothing around."""
    labels = np.full((24, 32), -1)
    labels[4:20, 8:16] = BODY_PART_NAMES.index(first)
    labels[4:20, 16:24] = BODY_PART_NAMES.index(second)
    return labels


def test_quantities_are_those_that_can_be_counted_by_hand():
    found = named(halves("torso", "left_upper_arm"))
    assert found["sure"] == pytest.approx(0.9, abs=1e-6)
    assert found["likelihood"] == pytest.approx(np.log(0.9), abs=1e-6)
    assert found["unsettled"] == 0
    assert found["clutter"] == pytest.approx(0, abs=1e-6)
    assert (found["limbs"], found["pieces"], found["whole"]) == (2, 0, 1)
    n_pairs = 16 * 15 + 15 * 16
    assert found["borders"] == pytest.approx(16 / n_pairs)
    assert found["odd_borders"] == 0
    assert found["area"] == pytest.approx(np.log(16 * 16 * 0.02**2 + 1e-3))


def test_limbs_that_no_body_has_side_by_side_are_odd():
    assert named(halves("head", "left_foot"))["odd_borders"] == 1
    assert named(halves("left_foot", "left_lower_leg"))["odd_borders"] == 0
    assert named(halves("left_upper_arm", "right_lower_arm"))["odd_borders"] == 1


def test_a_limb_in_pieces_is_told():
    labels = halves("torso", "head")
    labels[10:12, 8:16] = BODY_PART_NAMES.index("head")
    found = named(labels)
    assert found["pieces"] == 1
    assert found["whole"] == pytest.approx(0.5 * (1 + 8 / 14), abs=0.1)


def test_pieces_are_those_that_scipy_finds_label_by_label():
    for seed in range(20):
        labels = np.random.default_rng(seed).integers(-1, 3, (13, 17)).astype(np.int16)
        wanted = []
        for label in range(3):
            numbered, _ = ndimage.label(labels == label, np.ones((3, 3)))
            wanted += [(label, size) for size in np.bincount(numbered.ravel())[1:]]
        assert sorted(zip(*find_pieces(labels), strict=True)) == sorted(wanted)


def test_borders_are_counted_pair_by_pair():
    is_usual = np.array([[1, 1, 0], [1, 1, 1], [0, 1, 1]], np.bool_)
    for seed in range(20):
        labels = np.random.default_rng(seed).integers(-1, 3, (7, 9)).astype(np.int16)
        pairs = [*zip(labels[1:].flat, labels[:-1].flat, strict=True)]
        pairs += zip(labels[:, 1:].flat, labels[:, :-1].flat, strict=True)
        pairs = [(a, b) for a, b in pairs if min(a, b) >= 0]
        n_odd = sum({a, b} == {0, 2} for a, b in pairs)
        wanted = len(pairs), sum(a != b for a, b in pairs), n_odd
        assert count_borders(labels, is_usual) == wanted


def test_every_second_pixel_tells_nearly_the_same():
    one, two = (named(halves("torso", "left_upper_arm"), step) for step in (1, 2))
    for name in ("sure", "entropy", "clutter", "unsettled", "likelihood", "limbs", "whole", "area"):
        assert two[name] == pytest.approx(one[name], abs=1e-5)


def test_what_lies_apart_is_told_apart_and_the_threshold_loses_few_people():
    rng = np.random.default_rng(0)
    names = ("sure", "width", "stature")
    people, spared = (rng.normal(1.5, 1.0, (400, 3)) for _ in range(2))
    things = rng.normal(-1.5, 1.0, (60, 3))
    found = learn_likeness(names, (people, things), spared, {"a": 1})
    lost = np.mean([found.score(one) < found.threshold for one in spared])
    assert lost == pytest.approx(LOST_SHARE, abs=1 / 400)
    assert np.mean([found.score(one) < found.threshold for one in things]) > 0.95
    assert all(found.weights > 0)
    again = likeness_from_json(json.loads(json.dumps(likeness_to_json(found))), names)
    assert again.score(things[0]) == pytest.approx(found.score(things[0]))
    assert dict(again.provenance) == {"a": 1}
    for wrong in ({"format": "other"}, {"quantities": ["sure"]}):
        with pytest.raises(ValueError, match="document"):
            likeness_from_json({**likeness_to_json(found), **wrong}, names)


def test_the_shipped_likeness_is_of_the_shipped_model():
    """Else nobody would be judged by it: ``python -m adibas.pipeline.likeness_training``."""
    assert is_of(shipped_likeness(), shipped_model())


@pytest.mark.parametrize("content", [None, "{", "{}", '{"format": "adibas-person-likeness"}'])
def test_a_broken_likeness_is_told(tmp_path, monkeypatch, content):
    if content is not None:
        (tmp_path / "likeness.json").write_text(content)
    monkeypatch.setattr(shipped_json, "resource_path", lambda *parts: tmp_path / parts[-1])
    with pytest.raises(FileError, match=r"likeness\.json is broken or missing"):
        shipped_likeness.__wrapped__()


def test_most_things_alone_are_refused_and_hardly_a_person_is():
    model = shipped_model()
    refused = {}
    for name, frames, shown in (
        ("things", ThingFrames(77), things_shown(77, 2 * len(KINDS), 1)),
        ("people", LimbFrames(77), people_shown(77, 20, 5)),
    ):
        camera = frames.camera
        judge = person_judge(model, camera)
        refused[name] = np.mean(
            [
                is_refused(
                    np.where(depth_mm > 0, depth_mm / np.float32(1000), np.nan).astype(np.float32),
                    *(mask, camera.intrinsics.fx, model, judge),
                )
                for depth_mm, mask in shown
            ]
        )
    assert refused["things"] > 0.75
    assert refused["people"] < 0.25, "some are hardly seen: cut off, torn, behind furniture"


def test_below_the_threshold_a_word_is_said():
    refused = judge_likeness(-1.0, 0.0)
    assert not refused.is_person
    assert [one.message for one in refused.notices] == [UNLIKE]
    assert judge_likeness(0.0, 0.0) == Judgement(True, ())


def watched(verdicts, n_frames, step_m=0.0):
    """How many people are found in each frame while a judge gives these verdicts."""
    camera = CameraCalibration(32, 24, Intrinsics(30.0, 30.0, 15.5, 11.5))
    labels = halves("torso", "head")
    labels[4:20, 8:24] = np.arange(16) // 2  # so many limbs that these alone speak for a person
    depth_m = np.where(labels >= 0, 2.0, np.nan).astype(np.float32)
    asked = iter(verdicts)

    def judge(*_seen):
        is_person = next(asked)
        return Judgement(is_person, () if is_person else (Sentence(UNLIKE),))

    estimator = PoseEstimator(camera, lambda *_seen: parts_of(labels), judge=judge)
    found = [
        estimator.look_at(depth_m + np.float32(step_m * number), [labels >= 0], 0.1 * number)
        for number in range(n_frames)
    ]
    return [len(now.people) for now in found], found[-1].notices, list(asked)


def test_somebody_taken_for_a_person_often_enough_is_not_judged_anew():
    found, _, left = watched([True] * N_ENOUGH + [False], N_ENOUGH + 3)
    assert found == [1] * (N_ENOUGH + 3)
    assert left == [False], "nobody asked any more"


def test_a_thing_that_is_taken_for_a_person_now_and_then_is_none():
    found, notices, _ = watched([False, False, True, False, True, False], 6)
    assert found == [0] * 6
    assert [one.message for one in notices][-1] == UNLIKE


def test_somebody_who_was_badly_seen_at_first_is_found():
    found, _, _ = watched([False, False, *[True] * 8], 10)
    assert found[0] == 0
    assert found[-1] == 1


def test_whoever_stands_elsewhere_is_judged_anew():
    found, _, left = watched([*[True] * 3, False, False], 5, step_m=0.6)
    assert found == [1, 1, 1, 0, 0]
    assert not left


def test_figures_are_those_that_can_be_measured_by_hand():
    labels = halves("torso", "left_upper_arm")
    labels[4:8, 8:16] = BODY_PART_NAMES.index("head")
    rows, columns = np.indices(labels.shape)
    rays = np.dstack([columns / FOCAL_PX, rows / FOCAL_PX, np.ones(labels.shape)])
    depth_m = np.where(labels >= 0, 2.0, np.nan).astype(np.float32)
    parts = parts_of(labels)
    found = dict(zip(FIGURES, describe_figure(depth_m, labels >= 0, rays, parts), strict=True))
    assert found["torso_squared"] == pytest.approx((96 / 256) ** 2)
    assert found["head_squared"] == pytest.approx((32 / 256) ** 2)
    assert found["upper_arms"] == pytest.approx(0.5)
    assert found["least_forearm"] == 0
    assert found["head_over_torso"] == pytest.approx((13.5 - 5.5) * 0.02)
    assert found["width"] == pytest.approx(15 * 0.02, abs=0.011)
    assert found["thickness"] == pytest.approx(0, abs=1e-6)
    assert found["legs_width"] == 0, "the figure is 0.3 m tall"


def test_joints_say_how_far_shoulders_and_hips_are_apart_and_how_tall_somebody_is():
    proportions = shipped_joint_model().proportions
    stature_m = 1.7
    joints_m = np.full((15, 3), np.nan)
    for joint in ORDER:
        parent = PARENTS[joint]
        origin_m = np.zeros(3) if parent < 0 else joints_m[parent]
        joints_m[joint] = origin_m + stature_m * proportions.lengths[joint] * DOWN
    joints_m[JOINT_NAMES.index("right_hip")] = np.nan
    confidence = np.where(np.isfinite(joints_m[:, 0]), 0.6, np.nan)
    found = describe_joints(ChosenJoints(joints_m, confidence, 0.5), proportions)
    named_found = dict(zip(PLAUSIBILITIES, found, strict=True))
    assert named_found["confidence"] == pytest.approx(0.6 * 14 / 15)
    assert named_found["hips"] == ABSENT_M
    assert named_found["stature"] == pytest.approx(stature_m)
    left_m, right_m = (
        joints_m[JOINT_NAMES.index(f"{side}_shoulder")] for side in ("left", "right")
    )
    assert named_found["shoulders"] == pytest.approx(np.linalg.norm(left_m - right_m))
