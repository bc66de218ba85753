"""A context network learned for a model: pixels by cells, the file, the command, and breaks."""

import json
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.cli import main
from adibas.context.training import ContextTraining, label_weights
from adibas.data.limbs import LimbLabels
from adibas.errors import FileError, LimbError
from adibas.forests.params import ForestParams
from adibas.limbs.cells import CELL_M, PersonView, person_cells, to_pixels
from adibas.limbs.context import context_example, limb_probabilities
from adibas.limbs.model import load_model, merged, model_of, save_model
from adibas.limbs.training_set import LimbFolder
from adibas.pipeline import context_training
from adibas.pipeline.context_training import ContextRequest, train_context_of
from adibas.pipeline.limb_training import TrainingRequest, train_model
from adibas.resources import resource_path
from tests.unit.limb_folders import fill

FOREST = ForestParams(n_trees=2, max_depth=3, n_images=None, n_pixels=30, n_candidates=6)
NETWORK = ContextTraining(widths=(6, 8), n_passes=12, batch_size=2, rate=5e-3)


def _silent(_step, _done, _all):
    """Take progress."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return fill(tmp_path_factory.mktemp("seen") / "seen")


@pytest.fixture(scope="module")
def forest_path(folder):
    path = folder.parent / "forest.npz"
    train_model(TrainingRequest(path, (folder,), params=FOREST), _silent)
    return path


@pytest.fixture(scope="module")
def others(folder):
    return fill(folder.parent / "others", 14, first=100)


@pytest.fixture(scope="module")
def with_context(forest_path, others):
    path = others.parent / "with-context.npz"
    train_context_of(ContextRequest(forest_path, path, (others,), params=NETWORK), _silent)
    return path


class TestCells:
    @pytest.fixture
    def view(self):
        rng = np.random.default_rng(4)
        mask = np.zeros((60, 80), bool)
        mask[7:51, 11:38] = True
        mask[20:28, 38:60] = rng.random((8, 22)) < 0.7
        depth_m = np.where(mask, rng.uniform(1.9, 2.1, mask.shape), np.nan).astype(np.float32)
        depth_m[10:14, 12:30] = np.nan
        return PersonView(depth_m, mask, mask, 300.0)

    def test_each_is_as_large_on_the_body_near_and_far(self, view):
        near = person_cells(view._replace(depth_m=view.depth_m / 2))
        far = person_cells(view)
        assert near.size_px == pytest.approx(2 * far.size_px)
        assert far.size_px == pytest.approx(CELL_M * 300.0 / far.distance_m)

    def test_each_has_the_mean_depth_and_the_measured_share_of_its_pixels(self, view):
        cells = person_cells(view)
        rows, columns = np.nonzero(view.mask)
        row = np.floor((rows - cells.top) / cells.size_px).astype(int)
        column = np.floor((columns - cells.left) / cells.size_px).astype(int)
        number = cells.numbers[row, column]
        assert set(number.tolist()) == set(range(len(cells)))
        for one in range(len(cells)):
            depths_m = view.depth_m[rows[number == one], columns[number == one]]
            known = np.isfinite(depths_m)
            assert cells.measured[one] == pytest.approx(known.mean())
            expected = depths_m[known].mean() - cells.distance_m if known.any() else 0.0
            assert cells.ahead_m[one] == pytest.approx(expected, abs=1e-5)
            assert cells.pixel[one] in rows[number == one] * 80 + columns[number == one]
            assert np.isfinite(view.depth_m.flat[cells.pixel[one]]) == known.any()

    def test_pixels_get_what_rises_evenly_over_the_cells_exactly(self):
        mask = np.zeros((60, 80), bool)
        mask[5:55, 5:70] = True
        flat = PersonView(np.full(mask.shape, 2.0, np.float32), mask, mask, 300.0)
        cells = person_cells(flat)
        rows, columns = np.nonzero(cells.occupied)
        values = np.column_stack([2.0 * rows - columns, np.ones(len(cells))]).astype(np.float32)
        found = to_pixels(cells, values, flat)
        np.testing.assert_allclose(found[:, 1], 1.0, rtol=1e-5)
        row, column = np.nonzero(mask)
        down = (row - cells.top) / cells.size_px - 0.5
        right = (column - cells.left) / cells.size_px - 0.5
        inner = (down >= 0) & (right >= 0) & (down <= rows.max()) & (right <= columns.max())
        np.testing.assert_allclose(found[inner, 0], (2 * down - right)[inner], atol=1e-4)

    @pytest.fixture
    def arm_before_torso(self):
        """Return a view whose upper half has an arm, 20 cm before the torso, half a cell aside."""
        depth_m = np.full((60, 80), 2.0, np.float32)
        depth_m[:30, 41:] = 1.8
        everywhere = np.ones((60, 80), bool)
        return PersonView(depth_m, everywhere, everywhere, 400.0)  # cells of 4 pixels

    def test_beside_a_limb_that_is_before_another_pixels_go_by_their_depth(self, arm_before_torso):
        view = arm_before_torso
        cells = person_cells(view)
        is_arm = (cells.ahead_m < -0.1).astype(np.float32)
        found = to_pixels(cells, is_arm[:, None], view).reshape(view.mask.shape)
        upper = np.s_[:26]  # a cell away from the lower half
        np.testing.assert_array_equal(found[upper] > 0.5, view.depth_m[upper] < 1.9)
        assert np.abs(found[upper] - (view.depth_m[upper] < 1.9)).max() < 0.1
        assert ((found > 0) & (found < 1)).any(), "what lies between still counts a little"

    def test_a_pixel_without_depth_takes_what_lies_between_the_cells(self, arm_before_torso):
        depth_m = arm_before_torso.depth_m.copy()
        depth_m[10, 41] = np.nan
        view = arm_before_torso._replace(depth_m=depth_m)
        cells = person_cells(view)
        rows, columns = np.nonzero(cells.occupied)
        values = np.column_stack([columns, rows]).astype(np.float32)
        found = to_pixels(cells, values, view).reshape(60, 80, 2)[10, 41]
        middle = (np.array([41 - cells.left, 10 - cells.top])) / cells.size_px - 0.5
        np.testing.assert_allclose(found, middle, atol=1e-4)

    def test_nobody_with_depth_has_none(self, view):
        assert person_cells(view._replace(depth_m=np.full_like(view.depth_m, np.nan))) is None


class TestExamples:
    def test_a_cell_has_the_label_of_most_of_its_measured_pixels(self, forest_path, others):
        depth_m, labels, focal_px = LimbFolder(others).read(2)
        example = context_example(depth_m, labels, focal_px, load_model(forest_path).forest)
        assert example.features.shape == (len(example.rows), 2 + 3)
        assert set(example.labels.tolist()) == {0, 1}
        hand = np.argwhere(labels == 2)
        share = (example.labels == 1).mean()
        assert share == pytest.approx(len(hand) / np.count_nonzero(labels), abs=0.05)

    def test_a_cell_on_a_border_has_both_labels_and_their_shares(self, forest_path):
        depth_m = np.full((40, 40), 2.0, np.float32)
        labels = np.ones((40, 40), np.uint8)
        labels[:, 23:] = 2
        depth_m[:20] = np.nan
        forest = load_model(forest_path).forest
        example = context_example(depth_m, labels, 800.0, forest)  # cells of 8 pixels
        below = example.rows >= 3
        both = below & (example.second_share > 0)
        assert set(example.columns[both].tolist()) == {2}
        assert set(example.labels[both].tolist()) == {0}
        assert set(example.seconds[both].tolist()) == {1}
        np.testing.assert_allclose(example.second_share[both], 1 / 8, atol=1e-3)
        assert set(example.labels[example.rows < 2].tolist()) == {-1}
        assert not example.second_share[example.rows < 2].any()

    def test_nobody_with_depth_gives_none(self, forest_path, others):
        depth_m, labels, focal_px = LimbFolder(others).read(2)
        forest = load_model(forest_path).forest
        assert context_example(np.full_like(depth_m, np.nan), labels, focal_px, forest) is None


class TestModel:
    def test_it_is_right_more_often_than_its_forest_on_images_of_neither_training(
        self, forest_path, with_context, tmp_path
    ):
        unseen = LimbFolder(fill(tmp_path / "unseen", 6, first=200))
        right = {}
        for path in (forest_path, with_context):
            model, shares = load_model(path), []
            for index in range(6):
                depth_m, labels, focal_px = unseen.read(index)
                view = PersonView(depth_m, labels > 0, labels > 0, focal_px)
                told = limb_probabilities(view, model)
                np.testing.assert_allclose(told.sum(axis=1), 1.0, atol=1e-4)
                shares.append((told.argmax(axis=1) == labels[labels > 0] - 1).mean())
            right[path] = np.mean(shares)
        assert right[with_context] >= right[forest_path]
        assert right[with_context] > 0.9

    def test_the_file_says_what_the_network_was_trained_on(self, forest_path, with_context):
        model = load_model(with_context)
        told = model.forest.provenance["context"]
        assert (told["images"], told["n_images"], told["seed"]) == (["others"], 14, 1)
        assert told["model_created_utc"] == load_model(forest_path).created_utc
        assert not model.is_made(told["model_created_utc"])
        assert model.context is not None

    def test_the_file_says_which_labels_the_cells_had(self, with_context, others):
        shares = load_model(with_context).forest.provenance["context"]["label_shares"]
        assert sum(shares) == pytest.approx(1.0, abs=1e-3)
        images = [LimbFolder(others).read(index)[1] for index in range(14)]
        hands = sum(np.count_nonzero(one == 2) for one in images)
        everything = sum(np.count_nonzero(one) for one in images)
        assert shares[1] == pytest.approx(hands / everything, rel=0.1)

    def test_merged_labels_are_what_training_with_them_would_have_said(self, with_context):
        """Bayes' rule with the weights of training, for ten things that may be seen."""
        rng = np.random.default_rng(8)
        shares, evenness = np.array([0.5, 0.2, 0.07, 0.2, 0.03]), 0.85
        seen_of = rng.dirichlet(np.ones(10), 5)  # how often each is seen of each label
        told = (shares * label_weights(shares, evenness))[:, None] * seen_of
        told /= told.sum(axis=0)
        columns = np.array([0, 0, 0, 1, 2])
        shares_of_sums = np.bincount(columns, weights=shares)
        wanted = np.zeros((3, 10))
        np.add.at(wanted, columns, shares[:, None] * seen_of)
        wanted *= label_weights(shares_of_sums, evenness)[:, None]
        wanted /= wanted.sum(axis=0)
        names = ("head", "neck", "torso", "left_hand", "right_hand")
        model = load_model(with_context)
        learned = {"label_shares": shares.tolist(), "params": {"evenness": evenness}}
        told_of = {**model.forest.provenance, "context": learned, "omega_2": None}
        forest = replace(
            model.forest,
            labels=names,
            leaves=np.full((len(model.forest.leaves), 5), 0.2),
            provenance=told_of,
        )
        few = LimbLabels("own", ("torso", "left_hand", "right_hand"))
        joined = merged(model_of(forest, model.context), few, {"head": "torso", "neck": "torso"})
        found = joined.onto.T @ told
        np.testing.assert_allclose(found / found.sum(axis=0), wanted, rtol=1e-5)

    def test_merged_labels_are_sums(self, with_context, others, tmp_path):
        model = load_model(with_context)
        save_model(
            merged(model, LimbLabels("own", ("all",)), {"torso": "all", "left_hand": "all"}),
            tmp_path / "all.npz",
        )
        one = load_model(tmp_path / "all.npz")
        depth_m, labels, focal_px = LimbFolder(others).read(0)
        view = PersonView(depth_m, labels > 0, labels > 0, focal_px)
        np.testing.assert_allclose(limb_probabilities(view, one), 1.0, atol=1e-4)
        assert one.names == ("all",)

    def test_a_person_without_depth_has_even_probabilities(self, with_context, others):
        depth_m, labels, focal_px = LimbFolder(others).read(0)
        nothing_m = np.full_like(depth_m, np.nan)
        view = PersonView(nothing_m, labels > 0, labels > 0, focal_px)
        np.testing.assert_allclose(limb_probabilities(view, load_model(with_context)), 0.5)

    @pytest.mark.parametrize(
        ("name", "change"),
        [
            ("context_steps", lambda steps: steps[:-3]),
            ("context_numbers", lambda numbers: numbers[:-3]),
            ("context_numbers", lambda numbers: np.full_like(numbers, np.nan)),
            ("context_shape", lambda shape: shape[:1]),
            ("context_shape", lambda shape: shape * 0),
        ],
    )
    def test_a_damaged_network_is_refused(self, with_context, tmp_path, name, change):
        arrays = dict(np.load(with_context))
        arrays[name] = change(arrays[name])
        np.savez(tmp_path / "damaged.npz", **arrays)
        with pytest.raises(FileError, match="damaged"):
            load_model(tmp_path / "damaged.npz")


class TestTraining:
    def test_what_broke_off_goes_on_to_the_same_network(
        self, forest_path, others, with_context, tmp_path
    ):
        request = ContextRequest(forest_path, tmp_path / "model.npz", (others,), params=NETWORK)
        passes = []

        def stop(step, done, _all):
            passes.append(step)
            if step == "training" and done == 10:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            train_context_of(request, stop)
        assert not request.out.exists()
        done = []
        train_context_of(request, lambda step, at, _all: done.append((step, at)))
        assert min(at for step, at in done if step == "training") == 8
        one, other = load_model(with_context).context, load_model(request.out).context
        for first, second in zip(one.weights, other.weights, strict=True):
            np.testing.assert_array_equal(first, second)
        assert [path.name for path in tmp_path.iterdir()] == ["model.npz"]

    def test_a_network_that_a_model_has_already_goes_on_learning(self, with_context, tmp_path):
        more = fill(tmp_path / "more", 14, first=400)
        passes = replace(NETWORK, widths=(4,), n_passes=1, rate=0.0)  # its own widths stay
        request = ContextRequest(with_context, tmp_path / "model.npz", (more,), params=passes)
        train_context_of(request, _silent)
        before, behind = load_model(with_context), load_model(request.out)
        assert behind.context.shape == before.context.shape
        told = behind.forest.provenance["context"]
        assert (told["images"], told["params"]["widths"]) == (["more"], [6, 8])
        assert told["before"] == before.forest.provenance["context"]
        depth_m, labels, focal_px = LimbFolder(more).read(2)
        view = PersonView(depth_m, labels > 0, labels > 0, focal_px)
        np.testing.assert_allclose(
            limb_probabilities(view, behind), limb_probabilities(view, before), atol=0.1
        )

    @pytest.mark.parametrize("seed", [0, 7])
    @pytest.mark.parametrize("name", ["seen", "renamed"])
    def test_the_forest_s_own_images_are_refused(self, forest_path, folder, tmp_path, seed, name):
        images = shutil.copytree(folder, tmp_path / name)
        request = ContextRequest(forest_path, tmp_path / "model.npz", (images,), seed=seed)
        with pytest.raises(LimbError, match="trained on these images"):
            train_context_of(request, _silent)

    def test_other_images_are_taken_whatever_name_and_seed(self, forest_path, folder, tmp_path):
        others = fill(tmp_path / folder.name, first=100)
        params = replace(NETWORK, n_passes=1)
        request = ContextRequest(forest_path, tmp_path / "m.npz", (others,), seed=0, params=params)
        assert train_context_of(request, _silent).context is not None

    def test_a_simulated_forest_s_own_people_are_refused(self, tmp_path):
        shipped = resource_path("models", "limbs-15.npz")
        seed = int(load_model(shipped).forest.provenance["seed"])
        request = ContextRequest(shipped, tmp_path / "model.npz", n_frames=12, seed=seed)
        with pytest.raises(LimbError, match="or another seed"):
            train_context_of(request, _silent)

    def test_what_broke_off_goes_on_with_no_other_folder_of_the_same_name(
        self, forest_path, others, tmp_path
    ):
        def stop(step, *_told):
            if step == "training":
                raise KeyboardInterrupt

        out = tmp_path / "model.npz"
        with pytest.raises(KeyboardInterrupt):
            train_context_of(ContextRequest(forest_path, out, (others,), params=NETWORK), stop)
        changed = fill(tmp_path / others.name, 14, first=200)
        with pytest.raises(LimbError, match="other settings or images"):
            train_context_of(ContextRequest(forest_path, out, (changed,), params=NETWORK), _silent)

    def test_images_with_other_labels_are_refused(self, forest_path, tmp_path):
        images = fill(tmp_path / "sided", 2, ("left_hand", "right_hand"))
        request = ContextRequest(forest_path, tmp_path / "model.npz", (images,))
        with pytest.raises(LimbError, match="other labels"):
            train_context_of(request, _silent)
        assert [path.name for path in tmp_path.iterdir()] == ["sided"]

    def test_images_without_depth_are_refused(self, forest_path, others, tmp_path, monkeypatch):
        monkeypatch.setattr(context_training, "_LEAST_PIXELS", 10_000)
        request = ContextRequest(forest_path, tmp_path / "model.npz", (others,))
        with pytest.raises(LimbError, match="Nobody with depth"):
            train_context_of(request, _silent)
        assert not list(tmp_path.iterdir())

    def test_the_command_trains_and_says_what_it_made(
        self, forest_path, others, tmp_path, capsys, monkeypatch
    ):
        small = replace(ContextRequest(forest_path, tmp_path), params=NETWORK).params
        monkeypatch.setattr(context_training.ContextRequest, "__init__", _with(small), raising=True)
        out = tmp_path / "model.npz"
        command = ["limbs", "train", str(others), "--context", str(forest_path)]
        assert main([*command, "--out", str(out), "--json"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert told["provenance"]["context"]["images"] == ["others"]
        assert load_model(out).context is not None


class TestEvaluation:
    @pytest.fixture
    def unseen(self, tmp_path):
        return fill(tmp_path / "unseen", 4, first=300)

    def test_forest_network_and_cut_are_told_apart(
        self, forest_path, with_context, unseen, tmp_path, capsys
    ):
        told = {}
        for path in (forest_path, with_context):
            command = ["limbs", "evaluate", str(unseen), "--model", str(path)]
            assert main([*command, "--pictures", str(tmp_path / path.stem), "--json"]) == 0
            told[path] = json.loads(capsys.readouterr().out)
        assert told[with_context]["forest"] == told[forest_path]["forest"]
        assert told[forest_path]["network"] is None
        right, counts = np.zeros(2), np.zeros(2)
        for index in range(4):
            depth_m, labels, focal_px = LimbFolder(unseen).read(index)
            view = PersonView(depth_m, labels > 0, labels > 0, focal_px)
            truth = labels[labels > 0] - 1
            found = limb_probabilities(view, load_model(with_context)).argmax(axis=1)
            right += np.bincount(truth[found == truth], minlength=2)
            counts += np.bincount(truth, minlength=2)
        network = told[with_context]["network"]
        assert network["mean_per_class"] == pytest.approx((right / counts).mean())
        pictures = [
            cv2.imread(str(next((tmp_path / path.stem).glob("*.png")))).shape
            for path in (forest_path, with_context)
        ]
        assert pictures[1][1] * 3 == pictures[0][1] * 4  # one step more, side by side

    def test_the_table_has_a_column_for_each(self, with_context, unseen, capsys):
        assert main(["limbs", "evaluate", str(unseen), "--model", str(with_context)]) == 0
        told = capsys.readouterr().out
        assert "with its network" in told
        assert next(line for line in told.splitlines() if line[:5] == "torso").count("%") == 3


def _with(params):
    whole = ContextRequest.__init__

    def made(self, *values, **names):
        whole(self, *values, **{"params": params, **names})

    return made
