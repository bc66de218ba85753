"""Names that some points have already constrain the others."""

import numpy as np
import pytest

from adibas.cli import main
from adibas.data.joints import JOINT_NAMES, other_side
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.poses import standing
from adibas.skeleton.given_names import agrees, given_index
from adibas.skeleton.labelling import _agreeing
from adibas.skeleton.points_csv import read_points
from adibas.skeleton.prototype_search import Candidate, Found
from tests.unit.test_labelling import NAMES, namer, people, shuffled, write_csv

assert namer  # a fixture


@pytest.fixture(scope="module")
def flat_body():
    """Joints of somebody as flat as a picture: front and back look alike."""
    joints_m = (
        load_body_model().shaped(BodyShape("female", 40, 1.65, 62)).posed(standing()).joints_m
    )
    order = np.random.default_rng(1).permutation(len(joints_m))
    return (joints_m * [1.0, 1.0, 0.0])[order], tuple(JOINT_NAMES[i] for i in order)


def with_only(truth, **given):
    """Labels of which only some are known, each at the point of another name."""
    places = {at: label for label, at in given.items()}
    return tuple(places.get(name, "") for name in truth)


def mirrored(names):
    return tuple(other_side(name) if name else name for name in names)


def test_labels_are_the_models_names_once_each():
    given = given_index(("b", "", "x", "a", "b"), ("a", "b"))
    assert given.tolist() == [1, -1, -1, 0, -1]
    ways = np.array([[3, 0], [0, 3], [3, -1]])
    assert agrees(ways, given).tolist() == [True, False, False]
    assert agrees(ways, given_index(("", ""), ("a", "b"))).all()


@pytest.mark.parametrize("n_dimensions", [2, 3])
def test_one_name_of_a_side_tells_all_sides(namer, n_dimensions):
    points, truth = shuffled(people(1, seed=7)[0] * [1.0, 1.0, 0.0])
    points = points[:, :n_dimensions]
    assert None in namer.label(points).names
    for at, expected in (("left_hand", truth), ("right_hand", mirrored(truth))):
        labels = with_only(truth, left_hand=at)
        assert namer.label(points, given=labels).names == expected


def test_one_name_of_a_side_tells_all_sides_of_the_fifteen_joints(flat_body):
    points_m, truth = flat_body
    free = shipped_namer().label(points_m).names
    assert free[truth.index("left_foot")] is None
    for at, expected in (("left_knee", truth), ("right_knee", mirrored(truth))):
        labels = with_only(truth, left_knee=at)
        assert shipped_namer().label(points_m, given=labels).names == expected


def test_a_point_with_another_name_is_none_of_the_models(namer):
    points, truth = shuffled(people(1, seed=5)[0])
    found = namer.label(points, "anterior", given=with_only(truth, chin="head"))
    at = truth.index("head")
    assert found.names == (*truth[:at], None, *truth[at + 1 :])
    assert found.guesses[at] is None
    np.testing.assert_allclose(found.masses.sum(axis=1), 1.0)


def test_names_that_nothing_agrees_with_name_no_other_point(namer):
    points, truth = shuffled(people(1, seed=5)[0])
    labels = with_only(truth, head="left_foot", neck="right_foot", pelvis="left_hand")
    found = namer.label(points, "anterior", given=labels)
    assert set(found.names) <= {None, "head", "neck", "pelvis"}


def test_an_alternative_that_was_never_made_agrees_with_nothing():
    """Rows of a table that the search did not fill hold anything, and have no energy."""
    turn, moved = np.eye(2), np.zeros((2, 2))
    one = Candidate(np.array([0, 1]), 3.0, 0, turn, 1.0, moved)
    leftover = np.array([[1, 140_113_805_164_416], [1, -1], [1, 0]])
    given = given_index(("", "a"), ("a", "b"))
    unmade, made = np.array([np.inf, np.inf, np.inf]), np.array([np.inf, 4.0, np.inf])
    assert list(_agreeing(Found(one, leftover, unmade), given)) == []
    (left,) = _agreeing(Found(one, leftover, made), given)
    assert left.candidate.partners.tolist() == [1, -1]
    assert left.candidate.energy == 4.0
    assert len(left.others) == 0


def test_a_name_in_one_frame_tells_the_sides_of_a_movement(tmp_path):
    shapes = write_csv(tmp_path / "shapes.csv", people(20), labelled=True)
    model, out = tmp_path / "model.json", tmp_path / "labelled.csv"
    assert main(["skeleton", "train", str(shapes), "--out", str(model)]) == 0
    person = people(1, seed=4)[0] * [1.0, 1.0, 0.0]
    frames = [person + np.array([0.01 * number, 0.0, 0.0]) for number in range(4)]
    points = write_csv(tmp_path / "points.csv", frames, labelled=False)
    command = ["skeleton", "label", str(points), "--model", str(model), "--out", str(out)]
    command += ["--movement", "30"]
    assert main(command) == 0
    assert "left_foot" not in read_points(out)[0].labels
    points.write_text(points.read_text().replace("s2,left_hand_p,,", "s2,left_hand_p,left_hand,"))
    assert main(command) == 0
    for one in read_points(out):
        assert [f"{label}_p" for label in one.labels] == list(one.points)
        assert set(one.labels) == set(NAMES)
