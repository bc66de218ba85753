"""SAPO's measures against a hand-made patient: signs, mirror, planes, intervals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adibas.data.calibration import RgbdCalibration
from adibas.data.protocol_measures import PlaneChoice, VerticalOrigin
from adibas.data.protocols import MeasureDefinition, Wording
from adibas.data.views import VIEWS
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.measures.protocol_measures import UNKNOWN_LABEL, Capturing, measure_protocol
from adibas.measures.protocol_sides import patient_axis
from adibas.measures.protocol_store import find_protocol
from adibas.measures.sight_plane import Vertical, up_of_picture, vertical_of
from tests.unit.standing_points import CAMERA_FROM_BODY, LEVEL, mirrored, seen_from, standing

SAPO = find_protocol("sapo-1")


def results(view, places, protocol=SAPO, capturing=None, **options):
    markers = seen_from(view, places, **options)
    found = measure_protocol(protocol, markers, capturing or Capturing(view, LEVEL))
    return {one.definition.measure_id: one for one in found.results}


def values(view, places, **options):
    """Main values in the unit of each measure."""
    return {
        name: one.main.value / one.definition.per_unit
        for name, one in results(view, places, **options).items()
        if one.main is not None
    }


def moved(places, **moves):
    """Move some places by (left, up, ahead)."""
    return places | {name: places[name] + move for name, move in moves.items()}


def turned(places, name, about, angle_deg, axes):
    """Turn one place about another in the plane of two body axes, the first towards the second."""
    first, second = axes
    angle = math.radians(angle_deg)
    arm = places[name] - places[about]
    new = arm.copy()
    new[first] = arm[first] * math.cos(angle) - arm[second] * math.sin(angle)
    new[second] = arm[first] * math.sin(angle) + arm[second] * math.cos(angle)
    return places | {name: places[about] + new}


@pytest.mark.parametrize("rotation_deg", [0, 90, 180, 270])
@pytest.mark.parametrize("view", VIEWS)
def test_a_turned_sensor_without_a_vertical_exchanges_nobody_s_sides(view, rotation_deg):
    up = up_of_picture(rotation_deg)
    camera_from_upright = np.stack([np.cross(-up, [0.0, 0.0, 1.0]), -up, [0.0, 0.0, 1.0]], axis=1)
    markers = [
        replace(one, position_m=camera_from_upright @ one.position_m)
        for one in seen_from(view, standing())
    ]
    vertical = vertical_of(RgbdCalibration(), rotation_deg)
    found = measure_protocol(SAPO, markers, Capturing(view, vertical))
    assert vertical.origin is VerticalOrigin.UNKNOWN
    assert {one.message for one in found.notices} <= {UNKNOWN_LABEL}
    expected = results(view, standing(), capturing=Capturing(view, vertical_of(RgbdCalibration())))
    for one in found.results:
        spatial = expected[one.definition.measure_id].spatial
        assert (one.spatial is None) == (spatial is None)
        if spatial is not None:
            assert one.spatial.value == pytest.approx(spatial.value, abs=1e-9)


def test_a_straight_patient_measures_nothing_where_nothing_is_bent():
    front, back = values("anterior", standing()), values("posterior", standing())
    for name in ("HEAD.H", "ACR.H", "ASIS.H", "ACR_ASIS", "LL.R", "LL.L", "LLD", "TT.H"):
        assert front[f"ANT.{name}"] == pytest.approx(0.0, abs=1e-9), name
    assert front["ANT.COG"] == pytest.approx(0.0, abs=1e-9)
    for name in ("SCAP.ASYM", "REAR.R", "REAR.L"):
        assert back[f"POS.{name}"] == pytest.approx(0.0, abs=1e-9), name
    for view, letter in (("right_lateral", "R"), ("left_lateral", "L")):
        side = values(view, standing())
        for name in ("HEAD.V", "TRUNK.V", "HIP", "BODY.V", "PELVIS.H", "KNEE"):
            assert side[f"LAT{letter}.{name}"] == pytest.approx(0.0, abs=1e-9), name
        assert side[f"LAT{letter}.ANKLE"] == pytest.approx(90.0)
        assert side[f"LAT{letter}.CVA"] == pytest.approx(math.degrees(math.atan2(0.10, 0.08)))


LEFT, UP, AHEAD = 0, 1, 2


@pytest.mark.parametrize(
    ("measure", "raised"),
    [
        ("HEAD.H", "tragus"),
        ("ACR.H", "acromion"),
        ("ASIS.H", "asis"),
        ("TT.H", "tibial_tuberosity"),
    ],
)
def test_the_left_side_higher_is_positive(measure, raised):
    places = standing()
    width = 2 * places[f"left_{raised}"][LEFT]
    places = moved(places, **{f"left_{raised}": (0, width * math.tan(math.radians(3)), 0)})
    assert values("anterior", places)[f"ANT.{measure}"] == pytest.approx(3.0)


def test_the_pelvis_is_measured_against_the_shoulders():
    places = moved(standing(), left_acromion=(0, 0.36 * math.tan(math.radians(2)), 0))
    places = moved(places, left_asis=(0, 0.24 * math.tan(math.radians(5)), 0))
    assert values("anterior", places)["ANT.ACR_ASIS"] == pytest.approx(3.0)


@pytest.mark.parametrize(("side", "inward"), [("right", 1), ("left", -1)])
def test_varus_of_the_knee_and_a_lateral_tuberosity_are_positive_on_both_sides(side, inward):
    letter = side[0].upper()
    places = turned(
        standing(),
        f"{side}_lateral_malleolus",
        f"{side}_knee_joint_line",
        inward * 4.0,
        (LEFT, UP),
    )
    assert values("anterior", places)[f"ANT.LL.{letter}"] == pytest.approx(4.0)
    places = turned(
        standing(), f"{side}_tibial_tuberosity", f"{side}_patella", -inward * 12.0, (LEFT, UP)
    )
    assert values("anterior", places)[f"ANT.Q.{letter}"] == pytest.approx(12.0)
    places = turned(standing(), f"{side}_calcaneus", f"{side}_achilles", -inward * 7.0, (LEFT, UP))
    assert values("posterior", places)[f"POS.REAR.{letter}"] == pytest.approx(7.0)


def test_the_right_leg_longer_is_positive_in_centimetres():
    places = moved(standing(), left_medial_malleolus=(0.04, 0, 0))  # straight under the ASIS
    places = moved(places, right_medial_malleolus=(-0.04, -0.012, 0))
    assert values("anterior", places)["ANT.LLD"] == pytest.approx(1.2)


def test_the_right_scapula_further_out_is_positive():
    places = moved(standing(), right_inferior_scapula=(-0.02, 0, 0))
    assert values("posterior", places)["POS.SCAP.ASYM"] == pytest.approx(100 * 0.02 / 0.10)


@pytest.mark.parametrize(("side", "letter"), [("right", "R"), ("left", "L")])
def test_anterior_and_flexion_are_positive_on_both_sides(side, letter):
    view = f"{side}_lateral"

    def measured(name, bent):
        return values(view, bent)[f"LAT{letter}.{name}"]

    def ahead(name, height_m, angle_deg):
        return moved(
            standing(), **{f"{side}_{name}": (0, 0, height_m * math.tan(math.radians(angle_deg)))}
        )

    assert measured("HEAD.V", ahead("tragus", 0.18, 6)) == pytest.approx(6)
    assert measured("TRUNK.V", ahead("acromion", 0.52, 2)) == pytest.approx(2)
    assert measured("BODY.V", ahead("acromion", 1.34, 1.5)) == pytest.approx(1.5)
    higher = moved(standing(), **{f"{side}_asis": (0, 0.18 * math.tan(math.radians(10)), 0)})
    assert measured("PELVIS.H", higher) == pytest.approx(10)
    thigh = turned(
        standing(), f"{side}_knee_joint_line", f"{side}_greater_trochanter", 8, (AHEAD, UP)
    )
    assert measured("HIP", thigh) == pytest.approx(8)
    shank = turned(
        standing(), f"{side}_lateral_malleolus", f"{side}_knee_joint_line", -9, (AHEAD, UP)
    )
    assert measured("KNEE", shank) == pytest.approx(9)
    assert measured("ANKLE", shank) == pytest.approx(81)


def test_the_centre_of_gravity_moves_with_the_masses():
    """SAPO: 0.5245 of the mass is trunk and arms, of which 0.4395 stands at the acromia."""
    share = 0.5245 * 0.4395
    places = moved(standing(), left_acromion=(-0.05, 0, 0), right_acromion=(-0.05, 0, 0))
    assert values("anterior", places)["ANT.COG"] == pytest.approx(100 * share * 0.05 / 0.16)
    places = moved(standing(), right_acromion=(0, 0, 0.05))
    before, after = (values("right_lateral", one)["LATR.COG"] for one in (standing(), places))
    assert after - before == pytest.approx(100 * share * 0.05 / 0.15)
    assert before == pytest.approx(100 * 2 * 0.0133 * 0.4215)


@pytest.mark.parametrize("view", VIEWS)
@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_mirrored_patient_gives_mirrored_measures(view, seed):
    rng = np.random.default_rng(seed)
    places = {name: place + rng.normal(0, 0.02, 3) for name, place in standing().items()}
    other = {"right_lateral": "left_lateral", "left_lateral": "right_lateral"}
    before, after = values(view, places), values(other.get(view, view), mirrored(places))
    sides = {".R": ".L", ".L": ".R"}
    assert before
    for name, value in before.items():
        twin = name[:-2] + sides[name[-2:]] if name[-2:] in sides else name
        twin = {"LATR": "LATL", "LATL": "LATR"}.get(twin[:4], twin[:4]) + twin[4:]
        is_signed_by_side = name == twin
        assert after[twin] == pytest.approx(-value if is_signed_by_side else value, abs=1e-9)


@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_mount_of_the_sensor_changes_nothing(seed):
    """Rolled by a quarter turn and tilted: with the vertical known, the same values."""
    places = {
        name: place + np.random.default_rng(seed).normal(0, 0.02, 3)
        for name, place in standing().items()
    }
    roll = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    tilt = math.radians(8)
    pitch = np.array(
        [[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]]
    )
    mount = roll @ pitch
    up = mount @ LEVEL.up
    mounted = Capturing("anterior", Vertical(up, 0.0, VerticalOrigin.FLOOR, is_sd_known=True))
    before = values("anterior", places)
    after = values("anterior", places, rotation=mount, capturing=mounted)
    assert after == pytest.approx(before, abs=1e-9)


def test_the_patient_s_own_plane_undoes_a_turn_that_the_sensor_s_does_not():
    angle = math.radians(20)
    turn = np.array(
        [[math.cos(angle), 0, math.sin(angle)], [0, 1, 0], [-math.sin(angle), 0, math.cos(angle)]]
    )
    tilted = moved(standing(), left_asis=(0, 0.02, 0), left_acromion=(0, 0.01, 0))
    away = {name: turn @ place for name, place in tilted.items()}
    straight, from_sensor = values("anterior", tilted), values("anterior", away)
    assert from_sensor["ANT.ASIS.H"] > straight["ANT.ASIS.H"] + 0.2
    away |= {"template_right": turn @ (-0.2, 0, 0), "template_left": turn @ (0.2, 0, 0)}
    for plane in (PlaneChoice.ACROMIA, PlaneChoice.ASIS, PlaneChoice.TEMPLATE):
        own = values("anterior", away, capturing=Capturing("anterior", LEVEL, plane))
        assert own == pytest.approx(straight, abs=1e-9)
    side = {"template_back": turn @ (0.0, 0, -0.2), "template_front": turn @ (0.0, 0, 0.2)}
    template = Capturing("right_lateral", LEVEL, PlaneChoice.TEMPLATE)
    own = values("right_lateral", away | side, capturing=template)
    assert own == pytest.approx(values("right_lateral", tilted), abs=1e-9)


def test_a_plane_that_is_not_seen_gives_no_projected_value():
    places = standing()
    del places["right_asis"]
    one = results("anterior", places, capturing=Capturing("anterior", LEVEL, PlaneChoice.ASIS))
    acromia = one["ANT.ACR.H"]
    assert acromia.main is None
    assert acromia.reason.text.endswith("ASIS, right; ASIS, left")
    assert one["ANT.LL.R"].spatial is not None


def test_without_a_measured_vertical_nothing_that_rests_on_it_has_a_number():
    unknown = vertical_of(RgbdCalibration())
    one = results("anterior", standing(), capturing=Capturing("anterior", unknown))
    assert {result.projected for result in one.values()} == {None}
    assert one["ANT.ACR.H"].spatial is None
    assert "vertical" in one["ANT.ACR.H"].reason.text
    assert one["ANT.Q.R"].spatial is not None


def test_exchanged_sides_are_refused_and_not_measured():
    exchanged = {name: place * (-1, 1, 1) for name, place in standing().items()}
    markers = seen_from("anterior", exchanged)
    found = measure_protocol(SAPO, markers, Capturing("anterior", LEVEL))
    assert {result.main for result in found.results} == {None}
    assert any("exchanged" in notice.text for notice in found.notices)
    behind = measure_protocol(SAPO, markers, Capturing("posterior", LEVEL))
    assert not any("exchanged" in notice.text for notice in behind.notices)


def exchanged_pair(places, name):
    left, right = f"left_{name}", f"right_{name}"
    return places | {left: places[right], right: places[left]}


@pytest.mark.parametrize("view", ["anterior", "posterior"])
@pytest.mark.parametrize("name", ["acromion", "greater_trochanter", "lateral_malleolus"])
def test_one_exchanged_pair_is_left_out_of_what_is_measured(view, name):
    right, wrong = standing(), exchanged_pair(standing(), name)
    found = measure_protocol(SAPO, seen_from(view, wrong), Capturing(view, LEVEL))
    true = results(view, right)
    for result in found.results:
        needed = SAPO.marked_for(result.definition.points)
        if f"left_{name}" in needed or f"right_{name}" in needed:
            assert result.main is None
            assert "exchanged" in result.reason.text
        else:
            of_true = true[result.definition.measure_id]
            assert (result.main is None) == (of_true.main is None)
    assert sum("exchanged" in notice.text for notice in found.notices) == 1


@pytest.mark.parametrize("view", ["anterior", "posterior"])
@pytest.mark.parametrize("plane", [PlaneChoice.ACROMIA, PlaneChoice.ASIS])
def test_an_exchanged_pair_does_not_turn_the_plane_that_it_spans(view, plane):
    wrong = exchanged_pair(standing(), plane.value.replace("acromia", "acromion"))
    one = results(view, wrong, capturing=Capturing(view, LEVEL, plane))
    assert {result.projected for result in one.values()} == {None}
    assert all(result.reason for result in one.values())


def test_a_template_that_lies_the_wrong_way_round_is_no_plane():
    places = standing()
    places |= {"template_left": places["right_metatarsals"]}
    places |= {"template_right": places["left_metatarsals"]}
    capturing = Capturing("anterior", LEVEL, PlaneChoice.TEMPLATE)
    one = results("anterior", places, capturing=capturing)
    assert "exchanged" in one["ANT.ACR.H"].reason.text


@pytest.mark.parametrize("side", ["right", "left"])
def test_a_side_view_of_the_other_side_is_refused(side):
    other = {"right": "left", "left": "right"}[side]
    places = {
        name.replace(side, other): place for name, place in standing().items() if other not in name
    }
    markers = seen_from(f"{side}_lateral", places)
    declared = Capturing(f"{other}_lateral", LEVEL)
    found = measure_protocol(SAPO, markers, declared)
    assert {result.main for result in found.results} == {None}
    assert any("exchanged" in notice.text for notice in found.notices)


def test_crossed_limbs_are_measured_and_told():
    joints = find_protocol("joints-15")
    places = {
        "left_shoulder": np.array([0.18, 1.4, 0.0]),
        "right_shoulder": np.array([-0.18, 1.4, 0.0]),
        "left_hand": np.array([-0.1, 1.0, 0.2]),
        "right_hand": np.array([0.1, 1.0, 0.25]),
    }
    found = measure_protocol(joints, seen_from("anterior", places), Capturing("anterior", LEVEL))
    assert any("crossed" in notice.text for notice in found.notices)
    assert any(result.main is not None for result in found.results)


@pytest.mark.parametrize("view", VIEWS)
def test_the_patients_directions_are_right_handed_in_every_view(view):
    up = np.array([0.1, -1.0, 0.05])
    up /= np.linalg.norm(up)
    left, ahead = (patient_axis(axis, view, up) for axis in ("left", "anterior"))
    np.testing.assert_allclose(np.cross(left, up), ahead, atol=1e-12)
    np.testing.assert_allclose(patient_axis("right", view, up), -left)
    np.testing.assert_allclose(patient_axis("posterior", view, up), -ahead)
    body = CAMERA_FROM_BODY[view]
    assert body[:, 0] @ left > 0.9
    assert body[:, 2] @ ahead > 0.9


def test_missing_hidden_and_doubled_landmarks_are_told():
    markers = [m for m in seen_from("anterior", standing()) if m.label != "left_tragus"]
    hidden = markers[0].__class__("right_patella", 0.0, 0.0, 5.0, np.eye(2))
    markers = [hidden if m.label == "right_patella" else m for m in markers]
    twice = seen_from("anterior", {"Acromion, right": standing()["right_acromion"]})
    stranger = seen_from("anterior", {"scar": standing()["left_asis"]})
    numbered = seen_from("anterior", {"m07": standing()["left_asis"]})
    capturing = Capturing("anterior", LEVEL, by_hand=("left_asis",))
    found = measure_protocol(SAPO, markers + twice + stranger + numbered, capturing)
    one = {result.definition.measure_id: result for result in found.results}
    assert one["ANT.HEAD.H"].reason.text == "not marked: Tragus, left"
    assert one["ANT.Q.R"].reason.text == "the depth gives no position of: Patella, right"
    assert "Acromion, right" in one["ANT.ACR.H"].reason.text
    assert one["ANT.ASIS.H"].by_hand == ("left_asis",)
    told = " ".join(notice.text for notice in found.notices)
    assert "Acromion, right is named twice" in told
    assert "scar" in told
    assert "m07" not in told


def test_points_in_one_place_have_no_angle():
    places = standing()
    places["left_acromion"] = places["right_acromion"]
    one = results("anterior", places)["ANT.ACR.H"]
    assert one.main is None
    assert one.reason.text == "two of its points coincide"


def test_the_15_joints_give_105_distances_and_1365_angles():
    joints = find_protocol("joints-15")
    rng = np.random.default_rng(1)
    places = {one.landmark_id: rng.normal(0, 0.5, 3) for one in joints.landmarks}
    for name in [name for name in places if name.startswith("left_")]:
        places[name][0] = 0.3 + rng.random()
        places[name.replace("left", "right")][0] = -0.3 - rng.random()
    one = results("anterior", places, protocol=joints)
    kinds = [result.definition.kind for result in one.values()]
    assert (kinds.count("distance"), kinds.count("angle")) == (105, 1365)
    assert None not in {result.main for result in one.values()}
    straight = np.linalg.norm(places["head"] - places["neck"])
    assert one["D.head.neck"].main.value == pytest.approx(straight)
    flat = (places["head"] - places["neck"])[:2]
    assert one["D.head.neck"].projected.value == pytest.approx(np.linalg.norm(flat))
    for a, vertex, c in (("head", "neck", "torso"), ("left_hip", "left_knee", "left_foot")):
        result = next(
            result
            for result in one.values()
            if result.definition.kind == "angle"
            and result.definition.points[1] == vertex
            and {a, c} == {*result.definition.points[::2]}
        )
        first, second = ((places[name] - places[vertex])[:2] for name in (a, c))
        cosine = first @ second / np.linalg.norm(first) / np.linalg.norm(second)
        assert result.projected.value == pytest.approx(math.acos(cosine))
        low, high = result.projected.interval
        assert 0 <= low <= result.projected.value <= high <= math.pi


def test_values_in_space_grow_with_what_leaves_the_plane():
    places = moved(standing(), right_lateral_malleolus=(0, 0, -0.1))
    bent = results("anterior", places)["ANT.LL.R"]
    assert bent.projected.value == pytest.approx(0.0, abs=1e-9)
    assert bent.spatial.value == pytest.approx(math.atan2(0.1, 0.4))
    tilted = results("right_lateral", moved(standing(), right_acromion=(0.1, 0, 0.05)))
    vertical = tilted["LATR.TRUNK.V"].spatial.value
    assert vertical == pytest.approx(math.atan2(math.hypot(0.08, 0.05), 0.52))
    longer = moved(standing(), right_inferior_scapula=(0, 0, -0.09))
    index = results("posterior", longer)["POS.SCAP.ASYM"]
    assert index.projected.value == pytest.approx(0.0, abs=1e-9)
    m, n = math.hypot(0.09, 0.11), math.hypot(0.09, 0.02)
    assert index.spatial.value == pytest.approx(2 * (m - n) / (m + n))


def test_intervals_hold_the_truth_in_95_of_100_cases():
    """Markers, an error that all share, and the vertical vary together."""
    rng = np.random.default_rng(4)
    n_cases, hits = 120, []
    truth = results("anterior", standing())
    for _case in range(n_cases):
        causes = rng.normal(0, 1, 2)
        tilts = rng.normal(0, 0.005, 2)
        markers = []
        for marker in seen_from("anterior", standing()):
            shared = np.stack([marker.position_m * 0.002, marker.position_m * (0.001, 0, 0)], 1)
            own = rng.normal(0, 1, 3) * (0.001, 0.001, 0.003)
            covariance = np.diag([1e-6, 1e-6, 9e-6]) + shared @ shared.T
            markers.append(
                type(marker)(
                    *(marker.label, 0.0, 0.0, 5.0, np.eye(2)),
                    marker.position_m + own + shared @ causes,
                    covariance,
                    shared,
                )
            )
        tilted = LEVEL.tilted(tilts)
        vertical = Vertical(tilted, 0.005, VerticalOrigin.GRAVITY, is_sd_known=True)
        for one in measure_protocol(SAPO, markers, Capturing("anterior", vertical)).results:
            true = truth[one.definition.measure_id]
            for found, right in ((one.projected, true.projected), (one.spatial, true.spatial)):
                if found is not None and right is not None:
                    hits.append(found.interval[0] <= right.value <= found.interval[1])
    assert len(hits) > 2000
    assert 0.93 <= np.mean(hits) <= 0.97


def test_an_error_that_tilts_all_alike_is_no_difference_between_lines():
    vertical = Vertical(LEVEL.up, 0.02, VerticalOrigin.GRAVITY, is_sd_known=True)
    one = results("anterior", standing(), capturing=Capturing("anterior", vertical), sigma_m=1e-6)
    low, high = one["ANT.ACR.H"].projected.interval
    assert (high - low) / 2 == pytest.approx(1.96 * 0.02, rel=1e-3)
    low, high = one["ANT.ACR_ASIS"].projected.interval
    assert (high - low) / 2 < 1e-4


def test_a_vertical_of_unknown_certainty_is_told():
    vague = Vertical(LEVEL.up, 0.0, VerticalOrigin.FLOOR, is_sd_known=False)
    found = measure_protocol(SAPO, seen_from("anterior", standing()), Capturing("anterior", vague))
    assert "not known" in found.notices[-1].text


def test_the_vertical_is_that_of_gravity_else_of_the_floor():
    """A depth camera that is turned by a quarter against the colour camera."""
    turn = RigidTransform(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.zeros(3))
    floor = Plane(np.array([-1.0, 0, 0]), 1.0)
    by_floor = vertical_of(RgbdCalibration(color_from_depth=turn, floor=floor))
    assert by_floor.up == pytest.approx([0.0, -1.0, 0.0])
    assert (by_floor.origin, by_floor.is_sd_known) == (VerticalOrigin.FLOOR, False)
    by_gravity = vertical_of(
        RgbdCalibration(
            color_from_depth=turn,
            floor=floor,
            gravity=np.array([0.0, 1.0, 0.0]),
            gravity_sd_rad=0.01,
        )
    )
    assert by_gravity.up == pytest.approx([1.0, 0.0, 0.0])
    assert (by_gravity.origin, by_gravity.sd_rad) == (VerticalOrigin.GRAVITY, 0.01)


def test_a_height_may_be_measured_as_an_offset_upwards():
    up = MeasureDefinition(
        *("UP", Wording({"en": "up"}), ("anterior",), "offset"),
        *(("left_acromion", "right_acromion"), "mm", "up"),
    )
    protocol = replace(SAPO, measures=(up,))
    places = moved(standing(), left_acromion=(0, 0.012, 0))
    assert values("anterior", places, protocol=protocol)["UP"] == pytest.approx(12.0)


def test_markers_without_names_are_measured_by_nothing():
    unnamed = seen_from("anterior", {"m01": standing()["left_asis"]})
    for markers in ([], unnamed):
        found = measure_protocol(SAPO, markers, Capturing("anterior", LEVEL))
        assert {one.main for one in found.results} == {None}
        assert found.notices == ()
