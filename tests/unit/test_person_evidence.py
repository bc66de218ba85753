"""What limbs tell of the joints is worked out once a person and frame, also of somebody new."""

import numpy as np
import pytest

from adibas.data.frames import depth_in_metres
from adibas.pipeline import person_quantities, pose_following
from adibas.pipeline.person_evidence import evidence_of
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.crowds import open_crowd


@pytest.fixture(scope="module")
def scene():
    return open_crowd("two_children_cross", 9)


@pytest.fixture(scope="module")
def depth_m(scene):
    raw = scene.frame(0).sensor_frame.depth_raw
    measured = depth_in_metres(raw, scene.info.depth_unit_m)
    return np.ascontiguousarray(scene.info.calibration.corrected_depth(measured), np.float32)


def estimator(scene, judge):
    calibration = scene.info.calibration
    segmenter = forest_segmenter(shipped_model(), calibration.depth)
    return PoseEstimator(calibration.depth, segmenter, calibration.floor, judge=judge)


def test_the_judge_says_of_what_is_known_already_what_it_says_itself(scene, depth_m):
    judge = person_judge(shipped_model(), scene.info.calibration.depth)
    said = []

    def compared(depth, pixels, parts, seen):
        assert seen is not None
        said.append((judge(depth, pixels, parts, seen), judge(depth, pixels, parts, None)))
        return said[-1][0]

    people = estimator(scene, compared).look(depth_m, 0.0).people
    assert len(said) >= len(people) == 2
    assert all(given == own for given, own in said)


def test_it_is_worked_out_once_for_each_who_is_seen(scene, depth_m, monkeypatch):
    asked = []

    def counted(where):
        def count(*given):
            asked.append(where)
            return evidence_of(*given)

        return count

    monkeypatch.setattr(pose_following, "evidence_of", counted("to follow"))
    monkeypatch.setattr(person_quantities, "evidence_of", counted("to judge"))
    judge = person_judge(shipped_model(), scene.info.calibration.depth)
    assert len(estimator(scene, judge).look(depth_m, 0.0).people) == 2
    assert asked == ["to follow", "to follow"]
