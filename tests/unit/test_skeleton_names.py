"""Markers of a posture analysis get the joints' names where their protocol marks joints."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.data.joints import JOINT_NAMES, other_side
from adibas.data.markers import AutomaticName, Marker
from adibas.data.posture import Provenance
from adibas.geometry.distortion import FoldWarning, project_distorted
from adibas.geometry.pinhole import Intrinsics
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline import skeleton_names, view_check
from adibas.pipeline.namers import namer_of
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import with_namer, with_names
from adibas.pipeline.view_check import LOOKS_ASIDE, LOOKS_OTHERWISE, doubts_about_view
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.poses import standing
from adibas.skeleton.namer import Namer
from adibas.skeleton.side_odds import side_factor

COVARIANCE = np.eye(3) * 1e-6
CAMERA = CameraCalibration(1280, 1024, Intrinsics(1050.0, 1050.0, 639.5, 511.5))
CALIBRATION = RgbdCalibration(color=CAMERA)


@pytest.fixture(scope="module")
def joints_m():
    body = load_body_model().shaped(BodyShape("male", 35, 1.78, 75))
    return body.posed(standing()).joints_m + np.array([0.0, 0.8, 2.2])


def markers_at(positions_m):
    return tuple(
        Marker(f"m{i:02d}", 0.0, 0.0, 4.0, np.eye(2), position_m.copy(), COVARIANCE.copy())
        for i, position_m in enumerate(positions_m, 1)
    )


@pytest.fixture
def tilted_by(monkeypatch):
    def tilt(up):
        vertical = SimpleNamespace(up=np.array(up))
        monkeypatch.setattr(skeleton_names, "vertical_of", lambda *_seen: vertical)

    return tilt


def test_only_a_protocol_of_joints_names_joints():
    assert namer_of(find_protocol("joints-15")) is shipped_namer()
    assert namer_of(find_protocol("sapo-1")) is None


@pytest.mark.parametrize("angle_deg", [0, 90, 180])
def test_markers_get_names_however_the_sensor_is_mounted(joints_m, tilted_by, angle_deg):
    angle = np.radians(angle_deg)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    tilted_by(turn @ [0.0, -1.0, 0.0])
    named = with_names(shipped_namer(), markers_at(joints_m @ turn.T), "anterior", CALIBRATION)
    assert tuple(marker.label for marker in named) == JOINT_NAMES


def test_a_name_tells_which_model_gave_it_and_how_sure_it_is(joints_m, tilted_by):
    tilted_by([0.0, -1.0, 0.0])
    namer = shipped_namer()
    markers = list(markers_at(joints_m))
    markers[0] = replace(markers[0], label="neck")
    by_hand, *others = with_names(
        namer, tuple(markers), "anterior", CALIBRATION, frozenset(["neck"])
    )
    assert by_hand.named_by is None
    named = [one for one in others if one.label in JOINT_NAMES]
    assert len(named) >= 12
    assert {one.named_by.model for one in named} == {namer.identity}
    assert all(0.5 <= one.named_by.confidence <= 1.0 for one in named)
    assert all(one.named_by is None for one in others if one.label not in JOINT_NAMES)


def test_the_provenance_tells_which_model_named():
    plain = Provenance("", "", "0.1.0", "2026-11-22T10:00:00+00:00", {"detection": {}})
    assert with_namer(plain, None) is plain
    told = with_namer(plain, shipped_namer()).parameters
    assert told["detection"] == {}
    assert told["names"]["model"] == shipped_namer().identity
    assert told["names"]["created_utc"] in shipped_namer().identity
    assert not told["names"]["knew_body"]


def test_a_name_that_a_hand_changes_is_the_model_s_no_more():
    by_model = AutomaticName("a model", 0.9)
    found = replace(markers_at(np.zeros((1, 3)))[0], label="neck", named_by=by_model)
    moved = MarkerCorrection(found, replace(found, u=5.0, named_by=None))
    renamed = MarkerCorrection(found, replace(found, label="head"))
    (one,) = CorrectionHistory().after(moved).markers((found,))
    assert (one.u, one.named_by) == (5.0, by_model)
    (one,) = CorrectionHistory().after(renamed).markers((found,))
    assert (one.label, one.named_by) == ("head", None)


def test_markers_are_named_as_of_somebody_who_holds_still(joints_m, tilted_by, monkeypatch):
    tilted_by([0.0, -1.0, 0.0])
    asked = []
    still = shipped_namer().holding_still()
    monkeypatch.setattr(Namer, "holding_still", lambda namer: asked.append(namer) or still)
    named = with_names(shipped_namer(), markers_at(joints_m), "anterior", CALIBRATION)
    assert asked == [shipped_namer()]
    assert tuple(one.label for one in named) == JOINT_NAMES


def test_a_spot_of_another_size_does_not_take_the_name_of_a_hidden_marker(joints_m, tilted_by):
    tilted_by([0.0, -1.0, 0.0])
    hidden = JOINT_NAMES.index("left_hand")
    markers = list(markers_at(joints_m))
    # A forearm of 42 cm: places alone leave a doubt.
    markers[hidden] = replace(markers[hidden], position_m=joints_m[hidden] + [0.1, 0.05, -0.1])
    as_large = with_names(shipped_namer(), tuple(markers), "anterior", CALIBRATION)
    assert as_large[hidden].label == "left_hand"
    markers[hidden] = replace(markers[hidden], radius_px=12.0)
    larger = with_names(shipped_namer(), tuple(markers), "anterior", CALIBRATION)
    assert larger[hidden].label == markers[hidden].label
    others = [one.label for i, one in enumerate(larger) if i != hidden]
    assert others == [name for name in JOINT_NAMES if name != "left_hand"]


def test_names_by_hand_stay_and_are_not_given_twice(joints_m, tilted_by):
    tilted_by([0.0, -1.0, 0.0])
    markers = list(markers_at(joints_m))
    markers[0] = Marker("neck", 0.0, 0.0, 4.0, np.eye(2), joints_m[0].copy(), COVARIANCE.copy())
    named = with_names(
        shipped_namer(), tuple(markers), "anterior", CALIBRATION, frozenset(["neck"])
    )
    assert [marker.label for marker in named][:3] == ["neck", "m02", "left_shoulder"]


@pytest.fixture
def seen_flat(joints_m):
    """The joints, of which those that are asked for are seen by the colour camera alone."""
    lens = (0.05, -0.1, 0.0, 0.0)
    camera = CameraCalibration(1280, 1024, Intrinsics(1050.0, 1050.0, 639.5, 511.5), lens)
    calibration = RgbdCalibration(color=camera)

    def see(*names, places_m=joints_m):
        pixels = project_distorted(places_m, camera.intrinsics, camera.distortion)
        markers = [
            replace(marker, u=float(u), v=float(v))
            for marker, (u, v) in zip(markers_at(places_m), pixels, strict=True)
        ]
        for name in names:
            index = JOINT_NAMES.index(name)
            markers[index] = replace(markers[index], position_m=None, covariance_m2=None)
        return tuple(markers), calibration

    return see


def test_markers_below_the_depth_image_are_named_by_their_pixels(seen_flat):
    markers, calibration = seen_flat("left_foot", "right_foot", "right_hand")
    named = with_names(shipped_namer(), markers, "anterior", calibration)
    assert tuple(marker.label for marker in named) == JOINT_NAMES
    assert [marker.position_m is None for marker in named].count(True) == 3


def test_markers_without_a_position_are_named_by_their_rough_depth(joints_m, seen_flat):
    """An arm that reaches for the camera: in the picture, hand and elbow are not as they are."""
    places_m = joints_m.copy()
    arm = [JOINT_NAMES.index(f"right_{joint}") for joint in ("shoulder", "elbow", "hand")]
    shoulder_m, elbow_m, hand_m = joints_m[arm]
    upper_m, lower_m = np.linalg.norm(elbow_m - shoulder_m), np.linalg.norm(hand_m - elbow_m)
    places_m[arm[1]] = shoulder_m + upper_m * np.array([0.0, 0.5, -np.sqrt(0.75)])
    places_m[arm[2]] = places_m[arm[1]] + lower_m * np.array([0.0, -0.3, -np.sqrt(0.91)])
    names = [JOINT_NAMES[index] for index in arm]
    markers, calibration = seen_flat(*names, places_m=places_m)
    rough = tuple(
        replace(marker, rough_depth_m=place_m[2] + 0.03) if name in names else marker
        for name, place_m, marker in zip(JOINT_NAMES, places_m, markers, strict=True)
    )
    named = with_names(shipped_namer(), rough, "anterior", calibration)
    assert tuple(marker.label for marker in named) == JOINT_NAMES
    unknown = with_names(shipped_namer(), markers, "anterior", calibration)
    assert tuple(marker.label for marker in unknown) != JOINT_NAMES


def test_a_name_by_hand_is_not_given_to_a_marker_without_a_position(seen_flat):
    markers, calibration = seen_flat("left_foot")
    last = replace(markers[0], label="left_foot")
    named = with_names(
        shipped_namer(), (last, *markers[1:]), "anterior", calibration, frozenset(["left_foot"])
    )
    assert [marker.label for marker in named].count("left_foot") == 1


@pytest.fixture
def says():
    """A namer that is told what to say: (names, guesses, confidences) by the number of points."""

    def namer(words):
        def label(points_m, _view, _diameters_m, *, seen):
            assert len(seen.normals) in (4, 8)
            names, guesses, confidences = words[len(points_m)]
            return SimpleNamespace(
                names=names, guesses=guesses, confidences=np.array(confidences, float)
            )

        two_ways = SimpleNamespace(identity="two ways", label=label)
        two_ways.holding_still = lambda: two_ways
        return two_ways

    return namer


def test_markers_that_can_be_read_in_two_ways_get_no_name(seen_flat, says):
    markers, calibration = seen_flat("left_foot", "head")
    n_placed = len(JOINT_NAMES) - 2
    alone = ("left_hand", None, *(None,) * (n_placed - 2))
    together = ("right_hand", "left_knee", *(None,) * (n_placed - 2), "left_foot", "head")
    sure, surely = [1.0] * n_placed, [1.0] * len(markers)
    words = {n_placed: (alone, alone, sure), len(markers): (together, together, surely)}
    labels = [marker.label for marker in markers]
    named = with_names(says(words), markers, "anterior", calibration)
    assert [marker.label for marker in named] == labels
    alone = ("right_hand", *alone[1:])
    words[n_placed] = (alone, alone, sure)
    named = with_names(says(words), markers, "anterior", calibration)
    given = {marker.label for marker in named} - set(labels)
    assert given == {"right_hand", "left_foot", "head"}


@pytest.mark.parametrize(
    ("guess", "confidence", "given"),
    [("left_knee", 0.95, True), ("left_knee", 0.85, False), ("left_foot", 0.95, False)],
)
def test_a_doubtful_name_is_given_where_all_markers_together_are_sure_of_it(
    seen_flat, says, guess, confidence, given
):
    markers, calibration = seen_flat("head")
    n_placed = len(JOINT_NAMES) - 1
    nobody = (None,) * n_placed
    alone = (nobody, (guess, *nobody[1:]), [0.1] * n_placed)
    names = ("left_knee", *nobody[1:], "head")
    together = (names, names, [confidence, *[1.0] * n_placed])
    words = {n_placed: alone, len(markers): together}
    _head, first, *_others = with_names(says(words), markers, "anterior", calibration)
    assert (first.label == "left_knee") is given
    if given:
        assert first.named_by.confidence == confidence


def test_a_patient_so_near_that_head_hands_and_feet_are_out_of_sight_gets_names(seen_flat):
    markers, calibration = seen_flat("left_shoulder", "right_shoulder")
    unseen = ("head", "neck", "left_hand", "right_hand", "left_foot", "right_foot")
    kept = [i for i, name in enumerate(JOINT_NAMES) if name not in unseen]
    named = with_names(shipped_namer(), tuple(markers[i] for i in kept), "anterior", calibration)
    assert [marker.label for marker in named] == [JOINT_NAMES[i] for i in kept]


def test_a_marker_where_the_lens_is_not_known_keeps_its_label_and_harms_no_other(seen_flat):
    markers, calibration = seen_flat("left_foot")
    folding = replace(calibration.color, distortion=(-0.5, 0.0, 0.0, 0.0))
    index = JOINT_NAMES.index("left_foot")
    corner = replace(markers[index], u=1279.0, v=1023.0)
    markers = (*markers[:index], corner, *markers[index + 1 :])
    with pytest.warns(FoldWarning):
        named = with_names(
            shipped_namer(), markers, "anterior", replace(calibration, color=folding)
        )
    wanted = (*JOINT_NAMES[:index], corner.label, *JOINT_NAMES[index + 1 :])
    assert tuple(marker.label for marker in named) == wanted


def test_a_place_that_is_not_known_is_a_bug_and_no_endless_search(joints_m):
    joints_m = joints_m.copy()
    joints_m[3, 1] = np.nan
    with pytest.raises(ValueError, match="places that are known"):
        shipped_namer().label(joints_m, "anterior")


def test_a_marker_without_a_position_keeps_its_label_where_no_other_has_one(tilted_by):
    tilted_by([0.0, -1.0, 0.0])
    flat = (Marker("m01", 3.0, 4.0, 4.0, np.eye(2)),)
    assert with_names(shipped_namer(), flat, "anterior", CALIBRATION) == flat


def test_a_view_that_the_shape_contradicts_is_told_and_the_right_one_is_not(
    joints_m, tilted_by, monkeypatch
):
    tilted_by([0.0, -1.0, 0.0])
    monkeypatch.setattr(view_check, "vertical_of", skeleton_names.vertical_of)
    namer, markers = shipped_namer(), markers_at(joints_m)
    for view, told in (
        ("anterior", ()),
        ("posterior", (LOOKS_OTHERWISE,)),
        ("left_lateral", (LOOKS_ASIDE,)),
        ("right_lateral", (LOOKS_ASIDE,)),
        ("", ()),
    ):
        named = with_names(namer, markers, view, CALIBRATION)
        assert doubts_about_view(namer, named, view, CALIBRATION) == told
    nowhere = tuple(replace(one, position_m=None, covariance_m2=None) for one in markers)
    assert doubts_about_view(namer, nowhere, "posterior", CALIBRATION) == ()


def test_the_log_odds_of_the_other_way_are_divided_however_many_names_share_them():
    one_way, other_way = 1.0, 1e-3
    assert side_factor(one_way, other_way, 7.0) * other_way == pytest.approx(1e-3 ** (1 / 7))
    assert side_factor(one_way, other_way, 1.0) == 1.0
    assert side_factor(one_way, 0.0, 7.0) == 1.0


def test_one_name_by_hand_tells_all_sides_where_the_shape_tells_none(joints_m, tilted_by):
    """Somebody as flat as a picture, of whom nobody said whether the front or the back is seen."""
    tilted_by([0.0, -1.0, 0.0])
    flat_m = joints_m * [1.0, 1.0, 0.0] + [0.0, 0.0, 2.2]
    markers = list(markers_at(flat_m))
    named = with_names(shipped_namer(), tuple(markers), "", CALIBRATION)
    assert {one.label for one in named} & set(JOINT_NAMES) == {"head", "neck", "torso"}
    hand = JOINT_NAMES.index("left_hand")
    for label, expected in (
        ("left_hand", JOINT_NAMES),
        ("right_hand", tuple(map(other_side, JOINT_NAMES))),
    ):
        markers[hand] = replace(markers[hand], label=label)
        by_hand = frozenset([label])
        named = with_names(shipped_namer(), tuple(markers), "", CALIBRATION, by_hand)
        assert tuple(one.label for one in named) == expected


def test_an_error_of_the_hand_does_not_become_a_second_one(joints_m, tilted_by):
    tilted_by([0.0, -1.0, 0.0])
    markers = list(markers_at(joints_m))
    left, right = (JOINT_NAMES.index(f"{side}_shoulder") for side in ("left", "right"))
    markers[left] = replace(markers[left], label="right_shoulder")
    by_hand = frozenset(["right_shoulder"])
    named = with_names(shipped_namer(), tuple(markers), "anterior", CALIBRATION, by_hand)
    assert named[right].label == markers[right].label
    others = [one.label for i, one in enumerate(named) if i not in (left, right)]
    assert others == [name for i, name in enumerate(JOINT_NAMES) if i not in (left, right)]
