"""Forests learn what can be learned, the same on any machine, and come back from files."""

import itertools
import math
from dataclasses import replace

import numba
import numpy as np
import pytest

from adibas.errors import FileError
from adibas.forests.candidates import draw_candidates
from adibas.forests.feature_kernels import feature_value
from adibas.forests.files import load_forest, save_forest
from adibas.forests.forest import Forest
from adibas.forests.images import join_images, prepare_image
from adibas.forests.params import DEPTH, GRADIENT, ForestParams
from adibas.forests.prediction_kernels import LINK, N_COLUMNS, predict
from adibas.forests.samples import Memory
from adibas.forests.training import (
    Tree,
    join_trees,
    node_probabilities,
    train_forest,
    train_tree,
)
from adibas.forests.training_kernels import best_splits

FOCAL_PX = 100.0
FAR_M = 10.0
LABELS = ("left", "right", "thick")
SMALL = ForestParams(
    n_trees=2,
    max_depth=6,
    n_images=None,
    n_pixels=200,
    n_candidates=12,
    n_gradient_candidates=4,
    n_thresholds=6,
    max_offset_m=0.4,
)


class Slabs:
    """A slab at 2 m whose halves are two labels, with a thick end in the middle of one."""

    labels = LABELS

    def __init__(self, n_images=6, noise_m=0.002):
        self._noise_m, self._n_images = noise_m, n_images
        self.n_reads = 0

    def __len__(self):
        return self._n_images

    def read(self, index):
        self.n_reads += 1
        rng = np.random.default_rng(index)
        depth_m = np.full((48, 64), np.nan, np.float32)
        labels = np.zeros((48, 64), np.uint8)
        top, left = rng.integers(4, 12, 2)
        body = np.s_[top : top + 28, left : left + 40]
        depth_m[body] = 2.0 + rng.normal(0, self._noise_m, (28, 40))
        labels[body] = 1 + (np.arange(40) >= 20)
        thick = np.s_[top + 8 : top + 20, left + 24 : left + 36]
        depth_m[thick] -= 0.3
        labels[thick] = 3
        return depth_m, labels, FOCAL_PX


@pytest.fixture(scope="module")
def forest():
    return train_forest(Slabs(), SMALL, seed=5)


def same(first, second):
    return all(
        np.array_equal(getattr(first, name), getattr(second, name))
        for name in ("roots", "child", "nodes", "leaves")
    )


def body_image(rng):
    mask = rng.random((20, 30)) < 0.97
    mask[3:12, 5:20] = True
    depth_m = rng.uniform(1, 3, mask.shape).astype(np.float32)
    depth_m[5, 9] = np.nan
    return depth_m, mask


def slow_value(depth_m, slopes, pixel, feature):
    """Return equations 6.16 and 6.26, from whole images, one pixel at a time."""
    kind, *offsets = (float(value) for value in feature)
    scale = FOCAL_PX / depth_m[pixel]

    def read(image, part, outside):
        row, column = (
            pixel[axis] + math.floor(np.float32(offsets[part + axis]) * np.float32(scale) + 0.5)
            for axis in range(2)
        )
        inside = 0 <= row < image.shape[0] and 0 <= column < image.shape[1]
        return image[row, column] if inside else outside

    if kind == DEPTH:
        return read(depth_m, 0, FAR_M) - read(depth_m, 2, FAR_M)
    u, v = (complex(*(read(slope, part, 0.0) for slope in slopes)) for part in (0, 2))
    return float(np.angle(v * u.conjugate())) if u and v else 0.0


def test_features_are_those_of_a_slow_version():
    rng = np.random.default_rng(0)
    params = ForestParams(
        n_candidates=20, n_gradient_candidates=20, n_thresholds=1, max_offset_m=0.15
    )
    depth_m, mask = body_image(rng)
    image = prepare_image(depth_m, mask, FOCAL_PX, FAR_M, smoothing_px=1.5)
    batch = join_images([image, image], FAR_M)
    padded = np.full(mask.shape, FAR_M, np.float32)
    padded[mask & np.isfinite(depth_m)] = depth_m[mask & np.isfinite(depth_m)]
    slopes = np.zeros((2, *mask.shape), np.float32)
    height, width = image.depth_m.shape
    box = np.s_[image.top : image.top + height, image.left : image.left + width]
    slopes[0][box], slopes[1][box] = image.slope_x, image.slope_y
    features, _ = draw_candidates(rng, 1, params)
    n_angles = 0
    for pixel in rng.permutation(np.argwhere(padded < FAR_M))[:40]:
        at = (1, pixel[0] - image.top, pixel[1] - image.left)
        scale = np.float32(FOCAL_PX / padded[tuple(pixel)])
        for number, feature in enumerate(features):
            value = feature_value(
                batch.depth_m, batch.slope_x, batch.slope_y, batch.places, at, scale, features,
                number,
            )  # fmt: skip
            expected = slow_value(padded, slopes, tuple(pixel), feature)
            assert value == pytest.approx(expected, abs=1e-5)
            n_angles += feature[0] == GRADIENT and expected != 0
    assert n_angles > 50


def test_offsets_are_drawn_evenly_over_a_square_or_over_the_logarithm_of_their_length():
    params = ForestParams(n_candidates=4000, n_gradient_candidates=400, max_offset_m=0.8)
    features, _ = draw_candidates(np.random.default_rng(1), 2, params)
    offsets_m = features[:, 1:]
    assert 0.79 < np.abs(offsets_m).max() <= 0.8
    np.testing.assert_allclose(np.quantile(offsets_m, (0.25, 0.5, 0.75)), (-0.4, 0, 0.4), atol=0.02)
    rings = replace(params, min_offset_m=0.05)
    features, _ = draw_candidates(np.random.default_rng(1), 2, rings)
    for u in (1, 3):
        lengths_m = np.hypot(features[:, u], features[:, u + 1])
        assert 0.05 <= lengths_m.min() <= lengths_m.max() < 0.8001
        np.testing.assert_allclose(np.median(lengths_m), math.sqrt(0.05 * 0.8), rtol=0.05)
        angles = np.arctan2(features[:, u], features[:, u + 1])
        np.testing.assert_allclose(np.quantile(angles, (0.25, 0.75)), (-1.57, 1.57), atol=0.1)


def test_a_share_of_the_features_compares_with_the_pixel_itself():
    params = ForestParams(n_candidates=8, n_gradient_candidates=4, pixel_share=0.5)
    features, _ = draw_candidates(np.random.default_rng(1), 3, params)
    is_own = (features.reshape(3, 12, 5)[:, :, 3:] == 0).all(axis=2)
    assert is_own.tolist() == [[True] * 4 + [False] * 4 + [True] * 2 + [False] * 2] * 3
    assert (features[:, 1:3] != 0).all()


@pytest.mark.parametrize("wrong", [{"min_offset_m": 0.5}, {"pixel_share": 1.5}])
def test_offsets_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match="offset"):
        ForestParams(**wrong)


def test_the_slope_of_a_plane_is_its_slope():
    rows, columns = np.indices((30, 40), dtype=np.float32)
    depth_m = 2 + 0.01 * columns - 0.02 * rows
    mask = np.zeros((30, 40), bool)
    mask[4:26, 5:35] = True
    image = prepare_image(depth_m, mask, FOCAL_PX, FAR_M, smoothing_px=1.0)
    inner = np.s_[5:-5, 5:-5]
    np.testing.assert_allclose(image.slope_x[inner], 0.01, atol=1e-5)
    np.testing.assert_allclose(image.slope_y[inner], -0.02, atol=1e-5)
    assert image.slope_x[0].tolist() == [0] * 30  # no neighbour on one side


def entropy(labels):
    shares = np.bincount(labels) / len(labels)
    return -sum(share * math.log2(share) for share in shares if share > 0)


def test_the_best_split_is_that_of_an_exhaustive_search():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        labels = rng.integers(0, 3, 50)
        gaps = rng.integers(0, 5, (4, 50))
        counts = np.zeros((4, 1, 5, 3), np.int32)
        for candidate in range(4):
            np.add.at(counts, (candidate, 0, gaps[candidate], labels), 1)
        gains, choices, left = best_splits(counts)
        best = 0.0
        for candidate, t in itertools.product(range(4), range(4)):
            is_left = gaps[candidate] <= t
            if is_left.any() and not is_left.all():
                parts = (labels[is_left], labels[~is_left])
                after = sum(len(part) * entropy(part) for part in parts) / 50
                if entropy(labels) - after > best + 1e-12:
                    best, chosen, is_best_left = entropy(labels) - after, (candidate, t), is_left
        assert gains[0] == pytest.approx(best)
        assert tuple(choices[0]) == chosen
        assert left[0].tolist() == np.bincount(labels[is_best_left], minlength=3).tolist()


def test_a_forest_learns_what_the_shape_tells(forest):
    images = Slabs(n_images=9)
    right = total = 0
    for index in range(6, 9):
        depth_m, labels, focal_px = images.read(index)
        found = forest.probabilities(depth_m, labels > 0, focal_px).argmax(axis=1)
        right += (found == labels[labels > 0] - 1).sum()
        total += len(found)
    assert right / total > 0.9


def test_where_the_image_tells_nothing_leaves_hold_the_share_of_each_label_as_if_all_were_equal():
    class Noise(Slabs):
        labels = ("often", "seldom")

        def read(self, index):
            depth_m = np.full((40, 40), 2.0, np.float32)
            rng = np.random.default_rng(index)
            labels = 1 + (rng.random((40, 40)) < 0.1).astype(np.uint8)
            return depth_m, labels, FOCAL_PX

    params = ForestParams(n_trees=1, max_depth=0, n_images=None)
    stump = train_forest(Noise(), params, seed=1)
    # Equation 6.18's histograms are normalised per label: the prior is gone.
    np.testing.assert_allclose(stump.leaves, [[0.5, 0.5]])


class Companions(Slabs):
    """Loose pixels; beside three of four of one kind, and one of four of the other, is a third."""

    labels = ("sociable", "shy", "companion")

    def read(self, index):
        rng = np.random.default_rng(index)
        labels = np.zeros((60, 80), np.uint8)
        kind = rng.integers(1, 3, (12, 8))
        has_companion = rng.random((12, 8)) < np.where(kind == 1, 0.75, 0.25)
        labels[2::5, 2::10] = kind
        labels[2::5, 4::10][has_companion] = 3
        return np.where(labels, 2.0, np.nan).astype(np.float32), labels, FOCAL_PX


def test_where_bayes_rule_is_known_the_forest_gives_its_posterior():
    params = ForestParams(
        n_trees=3, n_images=None, max_offset_m=0.07, n_candidates=200, min_gain=0.02
    )
    forest = train_forest(Companions(n_images=60), params, seed=2)
    depth_m, labels, focal_px = Companions().read(100)
    found = np.full((60, 80, 3), np.nan)
    found[labels > 0] = forest.probabilities(depth_m, labels > 0, focal_px)
    has_companion = labels[2::5, 4::10] == 3
    hosts = found[2::5, 2::10]
    np.testing.assert_allclose(hosts[has_companion].mean(axis=0), [0.75, 0.25, 0], atol=0.03)
    np.testing.assert_allclose(hosts[~has_companion].mean(axis=0), [0.25, 0.75, 0], atol=0.03)


def test_the_seed_decides_and_nothing_else(forest):
    threads = numba.get_num_threads()
    try:
        for n_threads in (1, min(2, numba.config.NUMBA_NUM_THREADS)):
            numba.set_num_threads(n_threads)
            assert same(train_forest(Slabs(), SMALL, seed=5), forest)
    finally:
        numba.set_num_threads(threads)
    scarce = Memory(n_batch_images=2, image_bytes=0, count_bytes=1)
    assert same(train_forest(Slabs(), SMALL, seed=5, memory=scarce), forest)
    assert not same(train_forest(Slabs(), SMALL, seed=6), forest)


def test_trees_can_be_grown_apart_and_joined(forest):
    trees = [train_tree(Slabs(), SMALL, (5, number)) for number in (1, 0)]
    assert same(join_trees(trees[::-1], LABELS, SMALL, {}), forest)


def test_images_that_memory_holds_are_not_read_again():
    plenty, scarce = Slabs(), Slabs()
    train_tree(plenty, SMALL, (1, 0))
    train_tree(scarce, SMALL, (1, 0), Memory(image_bytes=0))
    assert plenty.n_reads == 2 * len(plenty)
    assert scarce.n_reads > plenty.n_reads


def test_progress_is_told_and_can_stop_the_training():
    told = []
    train_forest(Slabs(), SMALL, 1, progress=lambda *at: told.append(at))
    assert told[0] == (0, 0, 1)
    assert {tree for tree, _, _ in told} == {0, 1}

    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_forest(Slabs(), SMALL, 1, progress=stop)


def test_stop_conditions_are_kept():
    def deepest(tree):
        depth = np.zeros(len(tree.child), int)
        for node in np.flatnonzero(tree.child >= 0):
            depth[tree.child[node] : tree.child[node] + 2] = depth[node] + 1
        return depth.max()

    noisy = Slabs(noise_m=0.05)
    assert deepest(train_tree(noisy, SMALL, (1, 0))) == SMALL.max_depth
    shy = ForestParams(n_images=None, n_pixels=200, n_candidates=12, min_pixels=100)
    tree = train_tree(noisy, shy, (1, 0))
    assert tree.counts[tree.child >= 0].sum(axis=1).min() >= 100
    sure = ForestParams(n_images=None, n_pixels=200, n_candidates=12, min_gain=5.0)
    assert len(train_tree(noisy, sure, (1, 0)).child) == 1


def test_another_camera_sees_the_same_body(forest):
    depth_m, labels, focal_px = Slabs().read(2)
    fine = np.repeat(np.repeat(depth_m, 2, axis=0), 2, axis=1)
    mask = np.isfinite(fine)
    coarse = forest.probabilities(depth_m, labels > 0, focal_px).argmax(1)
    found = np.zeros(mask.shape, int)
    found[mask] = forest.probabilities(fine, mask, 2 * focal_px).argmax(1)
    assert (found[::2, ::2][labels > 0] == coarse).mean() > 0.9


def test_a_forest_of_depth_alone_is_walked_as_one_with_gradients_is(forest):
    """There are two loops: the one that never looks at slopes must not differ in a bit."""
    assert forest.uses_gradients
    forest = train_forest(Slabs(), replace(SMALL, n_gradient_candidates=0), seed=5)
    assert not forest.uses_gradients
    depth_m, labels, focal_px = Slabs().read(3)
    image = forest.prepare(depth_m, labels > 0, focal_px)
    batch = join_images([image], forest.far_m)
    at = np.argwhere(image.depth_m < forest.far_m).astype(np.int32)
    steps = np.zeros((len(forest.child), N_COLUMNS), np.float32)
    steps[:, :6] = forest.nodes
    links = steps.view(np.int32)
    links[:, LINK] = forest.child
    found = [
        predict(
            *(batch.depth_m, batch.slope_x, batch.slope_y, batch.places, at),
            *(np.array([focal_px, forest.far_m, uses]), forest.roots, steps, links, forest.leaves),
        )
        for uses in (0.0, 1.0)
    ]
    np.testing.assert_array_equal(found[0], found[1])
    inside = np.zeros(labels.shape, np.bool_)
    inside[at[:, 0] + image.top, at[:, 1] + image.left] = True
    asked = forest.probabilities(depth_m, labels > 0, focal_px, inside)
    np.testing.assert_array_equal(asked, found[0])
    backwards = np.flatnonzero(inside)[::-1]
    asked = forest.probabilities_at(depth_m, labels > 0, focal_px, backwards)
    np.testing.assert_array_equal(asked, found[0][::-1])


def test_pixels_without_depth_could_be_anything(forest):
    depth_m, labels, focal_px = Slabs().read(0)
    mask = labels > 0
    hole = np.argwhere(mask)[17]
    depth_m[tuple(hole)] = np.nan
    probabilities = forest.probabilities(depth_m, mask, focal_px)
    np.testing.assert_allclose(probabilities[17], 1 / 3)
    np.testing.assert_allclose(probabilities.sum(axis=1), 1, rtol=1e-5)


def test_an_empty_mask_has_no_probabilities(forest):
    empty = np.zeros((10, 10), bool)
    depth_m = np.ones((10, 10), np.float32)
    assert forest.probabilities(depth_m, empty, FOCAL_PX).shape == (0, 3)


def test_nothing_labelled_cannot_be_learned():
    class Empty(Slabs):
        def read(self, index):
            depth_m, labels, focal_px = super().read(index)
            return depth_m, labels * 0, focal_px

    with pytest.raises(ValueError, match="no image"):
        train_tree(Empty(), SMALL, (1, 0))


def test_a_forest_comes_back_from_its_file(forest, tmp_path):
    path = tmp_path / "model.npz"
    save_forest(forest, path)
    back = load_forest(path)
    assert same(back, forest)
    assert back.labels == forest.labels
    assert (back.far_m, back.smoothing_px) == (forest.far_m, forest.smoothing_px)
    assert back.provenance["params"]["n_candidates"] == 12
    assert back.provenance["seed"] == 5
    assert list(tmp_path.iterdir()) == [path]


def test_a_rounded_forest_comes_back_to_the_last_bit_from_half_the_space(forest, tmp_path):
    plain, small = tmp_path / "plain.npz", tmp_path / "small.npz"
    rounded = forest.rounded()
    arrays = {name: getattr(rounded, name) for name in ("roots", "child", "nodes", "leaves")}
    np.savez_compressed(plain, **arrays)
    save_forest(rounded, small)
    back = load_forest(small)
    assert same(back, rounded)
    assert not same(back, forest)
    with np.load(plain) as one, np.load(small) as other:
        assert set(other) == {
            *("header", "roots", "is_leaf", "split_links", "leaf_links"),
            *("node_steps", "leaf_counts"),
        }
        assert sum(other[name].nbytes for name in other if name != "header") < (
            sum(one[name].nbytes for name in one) / 2
        )


def test_numbers_too_large_for_small_integers_are_kept_as_they_are(forest, tmp_path):
    nodes = forest.rounded().nodes.copy()
    nodes[forest.child >= 0, -1] = 1000.0
    far = replace(forest.rounded(), nodes=nodes)
    save_forest(far, tmp_path / "far.npz")
    assert same(load_forest(tmp_path / "far.npz"), far)


def test_files_of_the_first_version_are_read(forest, tmp_path):
    path = tmp_path / "model.npz"
    save_forest(forest, path)
    with np.load(path) as file:
        header = file["header"].tobytes().replace(b'"version": 2', b'"version": 1')
    arrays = {name: getattr(forest, name) for name in ("roots", "child", "nodes", "leaves")}
    np.savez(path, header=np.frombuffer(header, np.uint8), **arrays)
    assert same(load_forest(path), forest)


def test_files_of_another_format_are_refused_in_words(tmp_path):
    path = tmp_path / "model.npz"
    for content in (b"", b"not a forest", b"PK\x03\x04 cut"):
        path.write_bytes(content)
        with pytest.raises(FileError, match=r"model\.npz is no forest"):
            load_forest(path)
    np.savez(path, header=np.frombuffer(b'{"format": "other"}', np.uint8))
    with pytest.raises(FileError, match="is no forest"):
        load_forest(path)
    np.savez(path, header=np.array([object()]))
    with pytest.raises(FileError, match="is no forest"):
        load_forest(path)
    with pytest.raises(FileError, match="cannot be read"):
        load_forest(tmp_path / "missing.npz")


def test_a_damaged_or_later_forest_is_refused_in_words(forest, tmp_path):
    path = tmp_path / "model.npz"
    save_forest(forest, path)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **{**arrays, "split_links": arrays["split_links"] + 10_000})
    with pytest.raises(FileError, match="is no forest"):
        load_forest(path)
    header = arrays["header"].tobytes().replace(b'"version": 2', b'"version": 9')
    np.savez(path, **{**arrays, "header": np.frombuffer(header, np.uint8)})
    with pytest.raises(FileError, match="later ADiBAS"):
        load_forest(path)


@pytest.mark.parametrize(
    "wrong", [{"n_trees": 0}, {"n_images": 0}, {"max_depth": -1}, {"far_m": 0.0}, {"min_gain": -1}]
)
def test_senseless_parameters_are_refused(wrong):
    with pytest.raises(ValueError, match="must"):
        ForestParams(**wrong)


def test_nodes_that_lead_back_are_refused():
    with pytest.raises(ValueError, match="fit together"):
        Forest(
            ("a",),
            np.zeros(1, np.int32),
            np.zeros(1, np.int32),
            np.zeros((1, 6), np.float32),
            np.ones((1, 1), np.float32),
            FAR_M,
            1.0,
        )


def test_leaves_are_drawn_to_the_node_above_by_as_many_pixels_as_asked():
    """A root with two leaves, worked out by hand; both labels are as frequent."""
    counts = np.array([[50, 50], [40, 10], [10, 40]], np.int64)
    tree = Tree(np.array([1, -1, -1], np.int32), np.zeros((3, 6), np.float32), counts)
    plain = node_probabilities(tree, 0.0)
    np.testing.assert_allclose(plain, [[0.5, 0.5], [0.8, 0.2], [0.2, 0.8]])
    drawn = node_probabilities(tree, 50.0)
    np.testing.assert_allclose(drawn[1], [(40 + 25) / 100, (10 + 25) / 100], rtol=1e-6)
    np.testing.assert_allclose(drawn.sum(axis=1), 1.0, rtol=1e-6)
    with pytest.raises(ValueError, match="shrinkage"):
        ForestParams(shrinkage=-1.0)


class OneImage:
    """A large label beside a small one."""

    labels = ("large", "small")

    def __len__(self):
        return 1

    def read(self, _index):
        labels = np.ones((40, 40), np.uint8)
        labels[:4, :10] = 2
        return np.full(labels.shape, 2.0, np.float32), labels, FOCAL_PX


@pytest.mark.parametrize(("evenness", "low", "high"), [(0.0, 0, 8), (0.5, 8, 22), (1.0, 22, 40)])
def test_small_labels_are_drawn_as_often_as_asked(evenness, low, high):
    params = ForestParams(n_trees=1, max_depth=0, n_images=None, n_pixels=80, evenness=evenness)
    counts = train_tree(OneImage(), params, (3, 0)).counts[0]
    assert counts.sum() == 80
    assert low <= counts[1] < high
