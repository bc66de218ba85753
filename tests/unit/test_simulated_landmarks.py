"""Landmarks lie on the skin, stay there in any pose, and sit where their names say."""

import itertools

import numpy as np
import pytest

from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.clothing import COVERINGS, OUTFITS, Outfit, covering_fields
from adibas.simulation.gestures import perform
from adibas.simulation.landmarks import SPINE_LEVELS
from adibas.simulation.poses import standing
from adibas.simulation.surface import Ray, SurfaceAnchors, anchor_rays

PEOPLE = [
    BodyShape("male", 35, 1.78, 76),
    BodyShape("female", 30, 1.65, 58),
    BodyShape("male", 6, 1.15, 20),
    BodyShape("female", 75, 1.55, 80),
]
THIN = [BodyShape("female", 10.6, 1.357, 19.7), BodyShape("male", 7.9, 1.295, 21.2)]
"""Of 400 drawn bodies those whose rays to the axillae were the last to find skin."""
PAIRED = (
    "tragus",
    "acromion",
    "inferior_scapula",
    "scapular_spine",
    "asis",
    "psis",
    "greater_trochanter",
    "lateral_epicondyle",
    "medial_epicondyle",
    "wrist",
    "knee_joint_line",
    "patella",
    "tibial_tuberosity",
    "midleg",
    "lateral_malleolus",
    "medial_malleolus",
    "shoulder_top",
    "axilla",
    "waist",
    "anterior_shoulder_top",
    "anterior_axilla",
    "anterior_waist",
    "achilles",
    "calcaneus",
    "metatarsals",
)


@pytest.fixture(scope="module", params=PEOPLE, ids=lambda shape: f"{shape.sex}-{shape.age_years}")
def person(request):
    return load_body_model().shaped(request.param)


@pytest.fixture(scope="module")
def stood(person):
    return person.posed(standing())


def distance_to_mesh_m(point, vertices_m, triangles):
    """Least distance from a point to any triangle, by dense sampling of the near ones."""
    near = np.flatnonzero(np.linalg.norm(vertices_m[triangles].mean(1) - point, axis=1) < 0.035)
    shares = np.array([(i, j) for i in range(31) for j in range(31 - i)]) / 30.0
    weights = np.column_stack([1 - shares.sum(1), shares])
    samples = np.einsum("sk,tkd->tsd", weights, vertices_m[triangles[near]])
    return np.linalg.norm(samples - point, axis=2).min()


def test_every_landmark_has_its_name(person):
    wanted = {f"{side}_{name}" for side in ("left", "right") for name in PAIRED}
    wanted |= {"glabella", "menton", "sternal_notch", "umbilicus", "natal_cleft", *SPINE_LEVELS}
    assert set(person.landmark_anchors.names) == wanted


def test_landmarks_lie_on_the_skin(stood):
    for name, point in stood.landmarks.items():
        away_m = distance_to_mesh_m(point, stood.vertices_m, stood.body.model.triangles)
        assert away_m < 0.001, name


def test_landmarks_of_the_trunks_outline_lie_as_their_definitions_say(stood):
    places = stood.landmarks
    for seen in ("left_", "right_", "left_anterior_", "right_anterior_"):
        top, fold, waist = (places[seen + name] for name in ("shoulder_top", "axilla", "waist"))
        assert top[0] == pytest.approx(fold[0], abs=0.04)  # above the fold, arms hanging
        assert places["left_acromion"][1] - 0.06 < top[1] < fold[1]
        assert places["c7"][1] < fold[1] < waist[1] < places["natal_cleft"][1]
        assert abs(waist[0]) > 0.06
        assert (fold[2] < places["left_acromion"][2]) == ("anterior" in seen)
    assert places["natal_cleft"][1] > places["s1"][1]
    assert places["natal_cleft"][2] > 0.0 > places["umbilicus"][2]


@pytest.mark.parametrize("shape", THIN, ids=lambda shape: f"{shape.weight_kg:.0f}-kg")
def test_the_thinnest_children_have_every_landmark_too(shape):
    assert len(load_body_model().shaped(shape).landmark_anchors.names) == 2 * len(PAIRED) + 5 + len(
        SPINE_LEVELS
    )


def test_landmarks_stay_on_the_skin_of_a_moving_body(person):
    gesture = perform("note", 1)
    posed = person.posed(gesture.pose(0.5 * gesture.duration_s))
    for name in ("left_acromion", "right_wrist", "c7", "left_lateral_epicondyle"):
        point = posed.landmarks[name]
        assert distance_to_mesh_m(point, posed.vertices_m, posed.body.model.triangles) < 0.001


def test_normals_point_out_of_the_body(stood):
    anchors = stood.body.landmark_anchors
    points, normals = stood.on_skin(anchors)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    outward = {
        "glabella": (0, 0, -1),
        "sternal_notch": (0, 0, -1),
        "t7": (0, 0, 1),
        "l4": (0, 0, 1),
        "left_greater_trochanter": (1, 0, 0),
        "right_greater_trochanter": (-1, 0, 0),
        "left_acromion": (0, -1, 0),
        "left_patella": (0, 0, -1),
        "right_calcaneus": (0, 0, 1),
    }
    for name, direction in outward.items():
        assert normals[anchors.names.index(name)] @ np.array(direction) > 0.5, name
    assert len(points) == len(anchors.names)


def test_left_and_right_mirror_each_other(stood):
    for name in PAIRED:
        left, right = stood.landmarks[f"left_{name}"], stood.landmarks[f"right_{name}"]
        assert left[0] > 0.01
        np.testing.assert_allclose(right, left * [-1, 1, 1], atol=0.001, err_msg=name)


def test_spine_goes_down_the_midline_of_the_back(stood):
    spine = np.stack([stood.landmarks[name] for name in SPINE_LEVELS])
    assert (np.diff(spine[:, 1]) > 0).all()
    assert np.abs(spine[:, 0]).max() < 0.003
    assert spine[:, 2].min() > -0.03


def test_landmarks_sit_about_their_joints(stood):
    joints = dict(zip(JOINT_NAMES, stood.joints_m, strict=True))
    scale = stood.body.stature_m / 1.75
    for side, out in (("left", 1), ("right", -1)):
        mark = {name: stood.landmarks[f"{side}_{name}"] for name in PAIRED}
        assert mark["acromion"][1] < joints[f"{side}_shoulder"][1]
        assert mark["asis"][2] < joints[f"{side}_hip"][2] < mark["psis"][2]
        assert mark["asis"][1] < joints[f"{side}_hip"][1] - 0.04 * scale
        assert (mark["greater_trochanter"] - joints[f"{side}_hip"])[0] * out > 0.02 * scale
        assert (mark["lateral_epicondyle"] - mark["medial_epicondyle"])[0] * out > 0.03 * scale
        assert (mark["lateral_malleolus"] - mark["medial_malleolus"])[0] * out > 0.03 * scale
        assert mark["lateral_malleolus"][1] > mark["medial_malleolus"][1]
        assert mark["patella"][2] < joints[f"{side}_knee"][2] - 0.02 * scale
        assert mark["tibial_tuberosity"][1] > mark["patella"][1] + 0.03 * scale
        assert mark["achilles"][2] > joints[f"{side}_foot"][2]
        assert mark["metatarsals"][2] < joints[f"{side}_foot"][2] - 0.06 * scale


def test_anthropometric_heights_are_those_of_the_tables(stood):
    """ANSUR II, shares of stature: cervicale, suprasternale, acromion, iliac crest, trochanter."""
    if stood.body.shape.age_years < 18:
        shares = {"c7": (0.82, 0.88), "left_acromion": (0.76, 0.83)}
    else:
        shares = {
            "c7": (0.83, 0.88),
            "sternal_notch": (0.80, 0.84),
            "left_acromion": (0.79, 0.84),
            "l4": (0.58, 0.63),
            "left_greater_trochanter": (0.50, 0.55),
        }
    for name, (low, high) in shares.items():
        assert low < -stood.landmarks[name][1] / stood.body.stature_m < high, name


def test_joint_anchors_lie_before_and_behind_their_joints(stood):
    for anchors, sign in (
        (stood.body.front_joint_anchors, -1),
        (stood.body.back_joint_anchors, 1),
    ):
        assert anchors.names == JOINT_NAMES
        points, normals = stood.on_skin(anchors)
        offset = points - stood.joints_m
        np.testing.assert_allclose(offset[:, :2], 0.0, atol=1e-6)
        assert (sign * offset[:, 2] > 0.005).all()
        assert (sign * normals[:, 2] > 0.0).all()


def test_anchors_can_be_chosen_by_name(stood):
    anchors = stood.body.landmark_anchors
    two = anchors.chosen(("right_asis", "c7"))
    points, _ = stood.on_skin(two)
    np.testing.assert_array_equal(points[1], stood.landmarks["c7"])
    assert two.names == ("right_asis", "c7")


def test_a_ray_finds_the_outermost_surface_and_misses_in_words():
    corners = np.array([[0, 0, z] for z in (1.0, 2.0)])[:, None] + np.array(
        [[-1, -1, 0], [3, -1, 0], [-1, 3, 0]]
    )
    mesh = np.arange(6, dtype=np.int32).reshape(2, 3)
    ahead = np.array([0.0, 0.0, 1.0])
    both = np.ones(2, bool)
    found = anchor_rays({"a": Ray(np.zeros(3), ahead, both)}, corners.reshape(-1, 3), mesh)
    np.testing.assert_allclose(found.on(corners.reshape(-1, 3), mesh), [[0, 0, 2.0]], atol=1e-12)
    with pytest.raises(ValueError, match="no skin found for b"):
        anchor_rays({"b": Ray(np.zeros(3), -ahead, both)}, corners.reshape(-1, 3), mesh)


def test_anchors_check_their_shapes():
    with pytest.raises(ValueError, match="barycentric"):
        SurfaceAnchors(("a",), np.array([0]), np.zeros((2, 3)))


@pytest.mark.parametrize("name", OUTFITS)
def test_faces_and_hands_are_never_dressed(person, name):
    fields = covering_fields(person, OUTFITS[name])
    cloth = fields[:, [COVERINGS.index(kind) for kind in ("top", "bottom", "shoes")]].max(1)
    weights = person.model.part_weights
    for part in ("head", "left_hand", "right_hand"):
        alone = weights[:, BODY_PART_NAMES.index(part)] > 0.999
        assert (cloth[alone] <= 0).all(), part


def test_clothes_cover_what_they_are_named_for(person):
    parts = person.model.part_weights.argmax(1)

    def covered(outfit, kind, part):
        field = covering_fields(person, outfit)[:, COVERINGS.index(kind)]
        return (field[parts == BODY_PART_NAMES.index(part)] > 0).mean()

    long_clothes = Outfit(sleeve=1.9, leg=1.95, shoes=True)
    assert covered(long_clothes, "top", "left_upper_arm") == 1.0
    assert covered(long_clothes, "bottom", "right_upper_leg") == 1.0
    assert covered(long_clothes, "bottom", "right_lower_leg") > 0.9
    assert covered(long_clothes, "shoes", "left_foot") > 0.7
    lengths = [covered(Outfit(leg=leg), "bottom", "left_upper_leg") for leg in (0.1, 0.4, 0.7)]
    assert all(a < b for a, b in itertools.pairwise(lengths))
    assert (covering_fields(person, OUTFITS["bare"]) < 0).all()


def test_hair_covers_the_crown_and_leaves_the_face(person):
    hair = covering_fields(person, Outfit())[:, [COVERINGS.index("hair")]].astype(float)
    assert hair[person.rest_vertices_m[:, 1].argmin()] > 0.02
    anchors = person.landmark_anchors
    at = dict(zip(anchors.names, anchors.on(hair, person.model.triangles)[:, 0], strict=True))
    for name in ("glabella", "menton", "left_tragus", "c7", "sternal_notch"):
        assert at[name] < 0, name


def test_sleeves_end_alike_on_both_arms(person):
    field = covering_fields(person, Outfit(sleeve=0.6))[:, COVERINGS.index("top")] > 0
    x = person.rest_vertices_m[:, 0]
    assert field[x > 0.2].sum() == pytest.approx(field[x < -0.2].sum(), rel=0.03)


def test_a_ray_along_a_triangle_meets_the_one_behind_it():
    vertices_m = np.array([[0, 0, 0], [1, -1, 0], [2, -1, 0], [3, -1, -1], [3, 2, -1], [3, 0, 2.0]])
    mesh = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    ray = Ray(np.array([0.0, 0.2, 0.1]), np.array([1.0, 0.0, 0.0]), np.ones(2, bool))
    anchors = anchor_rays({"ahead": ray}, vertices_m, mesh)
    assert anchors.triangles.tolist() == [1]
    np.testing.assert_allclose(anchors.on(vertices_m, mesh), [[3.0, 0.2, 0.1]], atol=1e-12)
