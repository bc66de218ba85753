"""Shapes are laid onto one another and onto their mean."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import procrustes
from scipy.spatial.transform import Rotation

from adibas.shapes.procrustes import align_shapes
from adibas.shapes.similarity import fit_similarity


def rotation(rng, n_dimensions):
    if n_dimensions == 3:
        return Rotation.random(random_state=rng.integers(2**31)).as_matrix()
    angle = rng.uniform(-np.pi, np.pi)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@given(st.integers(0, 10_000), st.sampled_from([2, 3]))
def test_a_moved_turned_and_scaled_shape_is_brought_back(seed, n_dimensions):
    rng = np.random.default_rng(seed)
    source = rng.normal(size=(6, n_dimensions))
    turn, scale, shift = (
        rotation(rng, n_dimensions),
        rng.uniform(0.1, 9),
        rng.normal(size=n_dimensions),
    )
    found = fit_similarity(scale * source @ turn.T + shift, source)
    assert found.scale == pytest.approx(scale)
    np.testing.assert_allclose(found.rotation, turn, atol=1e-9)
    np.testing.assert_allclose(found.translation, shift, atol=1e-8)
    np.testing.assert_allclose(found.inverse().apply(found.apply(source)), source, atol=1e-9)


@pytest.mark.parametrize("n_dimensions", [2, 3])
def test_no_small_change_of_the_map_brings_noisy_points_closer(n_dimensions):
    rng = np.random.default_rng(5)
    source, target = rng.normal(size=(2, 8, n_dimensions))
    target = source + 0.2 * target
    weights = rng.uniform(0.2, 2, 8)
    found = fit_similarity(target, source, weights)

    def loss(scale, turn, shift):
        return (weights * ((target - scale * source @ turn.T - shift) ** 2).sum(axis=1)).sum()

    best = loss(found.scale, found.rotation, found.translation)
    for _ in range(50):
        small = rotation(rng, n_dimensions)
        turn = np.linalg.qr(np.eye(n_dimensions) + 1e-3 * (small - small.T))[0]
        turn = turn * np.sign(np.diag(turn)) @ found.rotation
        nudged = (
            found.scale * (1 + 1e-3 * rng.normal()),
            turn,
            found.translation + 1e-3 * rng.normal(),
        )
        assert loss(*nudged) >= best


def test_a_mirror_image_is_not_reached_by_a_rotation():
    source = np.random.default_rng(2).normal(size=(9, 3))
    found = fit_similarity(source * [-1, 1, 1], source)
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_pairs_with_a_missing_point_are_left_out():
    rng = np.random.default_rng(3)
    source = rng.normal(size=(6, 3))
    target = source + np.array([1, 2, 3])
    target[2] = np.nan
    found = fit_similarity(target, source)
    np.testing.assert_allclose(found.translation, [1, 2, 3], atol=1e-12)
    assert fit_similarity(np.where(np.arange(6)[:, None] > 1, np.nan, target), source) is None


def test_points_on_a_line_fix_no_rotation_in_space():
    line = np.outer(np.arange(5.0), [1, 2, 3])
    assert fit_similarity(line, line) is None
    assert fit_similarity(line[:, :2], line[:, :2]) is not None


def test_a_rigid_fit_keeps_the_size():
    source = np.random.default_rng(4).normal(size=(5, 2))
    assert fit_similarity(3 * source, source, has_scale=False).scale == 1.0


@pytest.mark.parametrize("n_dimensions", [2, 3])
def test_two_shapes_differ_as_much_as_scipy_says(n_dimensions):
    rng = np.random.default_rng(6)
    a = rng.normal(size=(7, n_dimensions))
    b = a @ rotation(rng, n_dimensions).T + 0.1 * rng.normal(size=a.shape)
    _, _, disparity = procrustes(a, b)
    found = fit_similarity(a - a.mean(0), b)
    rest = ((a - a.mean(0) - found.apply(b)) ** 2).sum() / ((a - a.mean(0)) ** 2).sum()
    assert rest == pytest.approx(disparity, rel=1e-9)


@pytest.mark.parametrize("n_dimensions", [2, 3])
def test_copies_of_one_shape_are_laid_onto_one_another(n_dimensions):
    rng = np.random.default_rng(7)
    one = rng.normal(size=(10, n_dimensions))
    copies = [
        rng.uniform(0.5, 4) * one @ rotation(rng, n_dimensions).T + rng.normal(size=n_dimensions)
        for _ in range(12)
    ]
    found = align_shapes(np.stack(copies))
    np.testing.assert_allclose(
        found.shapes, np.broadcast_to(found.mean, found.shapes.shape), atol=1e-9
    )
    assert np.linalg.norm(found.mean) == pytest.approx(1)
    np.testing.assert_allclose(found.mean.mean(axis=0), 0, atol=1e-12)


def test_the_mean_does_not_depend_on_where_the_shapes_stood():
    rng = np.random.default_rng(8)
    shapes = rng.normal(size=(1, 9, 3)) + 0.1 * rng.normal(size=(20, 9, 3))
    moved = np.stack([2.5 * shape @ rotation(rng, 3).T + rng.normal(size=3) for shape in shapes])
    first, second = align_shapes(shapes), align_shapes(moved)
    _, _, disparity = procrustes(first.mean, second.mean)
    assert disparity < 1e-12
    np.testing.assert_allclose(second.sizes, 2.5 * first.sizes)


def test_aligned_shapes_lie_in_the_tangent_space_of_their_mean():
    rng = np.random.default_rng(9)
    found = align_shapes(rng.normal(size=(1, 9, 2)) + 0.2 * rng.normal(size=(15, 9, 2)))
    np.testing.assert_allclose((found.shapes * found.mean).sum(axis=(1, 2)), 1, atol=1e-9)


def test_sizes_are_kept_where_they_matter():
    rng = np.random.default_rng(10)
    one = rng.normal(size=(9, 3))
    found = align_shapes(np.stack([one, 2 * one @ rotation(rng, 3).T]), has_scale=False)
    assert np.linalg.norm(found.shapes, axis=(1, 2)) == pytest.approx(found.sizes)
    assert found.sizes[1] == pytest.approx(2 * found.sizes[0])


@pytest.mark.parametrize(
    "shapes",
    [np.zeros((0, 5, 2)), np.zeros((3, 5, 2)), np.full((2, 5, 2), np.nan),
     np.broadcast_to(np.outer(np.arange(5.0), [1, 1, 1]), (2, 5, 3))],
)  # fmt: skip
def test_what_is_no_shape_is_refused(shapes):
    with pytest.raises(ValueError, match="shape"):
        align_shapes(shapes)
