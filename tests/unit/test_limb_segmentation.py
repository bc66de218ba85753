"""Limbs by forest and cut: on simulated people, and where there is nobody to segment."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.data.limbs import FULL_BODY, UPPER_BODY, LimbLabels
from adibas.errors import FileError, LimbError
from adibas.forests.params import ForestParams
from adibas.forests.training import train_forest
from adibas.limbs.evaluation import confusion_of, no_confusion
from adibas.limbs.filling_kernels import filled_between
from adibas.limbs.judging import judge_mask, judge_parts
from adibas.limbs.model import CLUTTER, load_model, merged, model_of, save_model
from adibas.limbs.penalties import omega_2
from adibas.limbs.segmentation import FrameBefore, LimbParams, segment
from adibas.limbs.training_set import TO_TORSO, Relabelled

FOCAL_PX = 100.0
LABELS = ("left_hand", "torso", "right_hand")


class Bars:
    """A trunk with a hand on either side, nearer and farther, higher and lower."""

    def __init__(self, n_images, labels=LABELS):
        self.labels = labels
        self._n_images = n_images

    def __len__(self):
        return self._n_images

    def read(self, index):
        rng = np.random.default_rng(index)
        labels = np.zeros((60, 80), np.uint8)
        top, left = rng.integers(5, 20), rng.integers(20, 35)
        labels[top : top + 30, left : left + 16] = 2
        labels[top + 8 : top + 14, left - 8 : left] = 3
        labels[top + 8 : top + 14, left + 16 : left + 24] = 1
        depth_m = np.full(labels.shape, np.nan, np.float32)
        depth_m[labels > 0] = 2.0 + rng.normal(0, 0.002, np.count_nonzero(labels))
        depth_m[labels == 1] -= 0.1
        depth_m[labels == 3] -= 0.1
        return depth_m, labels, FOCAL_PX


PARAMS = ForestParams(n_trees=2, max_depth=6, n_images=None, n_pixels=80, n_candidates=30)


@pytest.fixture(scope="module")
def model():
    return model_of(train_forest(Bars(12), PARAMS, seed=1))


@pytest.fixture
def person():
    depth_m, labels, _ = Bars(1).read(99)
    return depth_m, labels > 0, labels.astype(int) - 1


def test_limbs_are_found_on_an_image_that_was_not_trained_on(model, person):
    depth_m, mask, truth = person
    parts = segment(depth_m, mask, FOCAL_PX, model, LimbParams(step=1))
    assert parts.labels == LimbLabels("own", LABELS)
    assert (parts.chosen[mask] == truth[mask]).mean() > 0.95
    np.testing.assert_array_equal(parts.chosen[~mask], -1)
    np.testing.assert_allclose(parts.probabilities.sum(axis=1), 1.0, atol=1e-5)


def test_every_second_pixel_tells_the_same_as_all(model, person):
    depth_m, mask, _ = person
    whole = segment(depth_m, mask, FOCAL_PX, model, LimbParams(step=1, cut="none"))
    half = segment(depth_m, mask, FOCAL_PX, model, LimbParams(step=2, cut="none"))
    assert half.pixels.sum() < 0.3 * mask.sum()
    np.testing.assert_array_equal(half.probabilities, whole.probabilities[half.pixels[mask]])
    np.testing.assert_array_equal(half.chosen[half.pixels], whole.chosen[half.pixels])
    np.testing.assert_array_equal(half.chosen >= 0, mask)


def test_a_back_has_its_sides_swapped(model, person):
    depth_m, mask, _ = person
    front = segment(depth_m, mask, FOCAL_PX, model)
    back = segment(depth_m, mask, FOCAL_PX, model, LimbParams(is_from_behind=True))
    np.testing.assert_array_equal(back.of("left_hand"), front.of("right_hand"))
    np.testing.assert_array_equal(back.of("torso"), front.of("torso"))


@pytest.mark.parametrize("is_from_behind", [False, True])
def test_ties_to_the_frame_before_hold_its_labels_as_strongly_as_asked(
    model, person, is_from_behind
):
    """The frame before says left where the depth says right: a strong tie believes it."""
    depth_m, mask, _truth = person
    free = LimbParams(step=1, is_from_behind=is_from_behind)
    alone = segment(depth_m, mask, FOCAL_PX, model, free)
    other = alone.with_sides_swapped()
    before = FrameBefore(depth_m, other)
    tied = [
        segment(depth_m, mask, FOCAL_PX, model, replace(free, over_time=weight), before)
        for weight in (0.0, 0.5, 1000.0)
    ]
    known = other.chosen >= 0
    np.testing.assert_array_equal(tied[0].chosen, alone.chosen)
    np.testing.assert_array_equal(tied[2].chosen[known], other.chosen[known])
    assert (alone.chosen != other.chosen).any()
    untied = segment(depth_m, mask, FOCAL_PX, model, replace(free, over_time=1000.0), None)
    np.testing.assert_array_equal(untied.chosen, alone.chosen)


def test_a_frame_before_without_depth_or_labels_ties_nothing(model, person):
    depth_m, mask, _truth = person
    params = LimbParams(step=1, over_time=1000.0)
    alone = segment(depth_m, mask, FOCAL_PX, model, replace(params, over_time=0.0))
    blind = FrameBefore(np.full_like(depth_m, np.nan), alone.with_sides_swapped())
    nobody = segment(depth_m, np.zeros_like(mask), FOCAL_PX, model)
    for before in (blind, FrameBefore(depth_m, nobody)):
        found = segment(depth_m, mask, FOCAL_PX, model, params, before)
        np.testing.assert_array_equal(found.chosen, alone.chosen)


def test_a_negative_tie_is_refused():
    with pytest.raises(ValueError, match="over_time"):
        LimbParams(over_time=-1.0)


@pytest.mark.parametrize("cut", ["omega_1", "omega_2", "none"])
def test_an_empty_mask_has_no_limbs(model, cut):
    depth_m = np.full((20, 30), np.nan, np.float32)
    parts = segment(depth_m, np.zeros((20, 30), bool), FOCAL_PX, model, LimbParams(cut))
    assert parts.probabilities.shape == (0, 3)
    assert (parts.chosen == -1).all()


def test_holes_take_the_label_around_them(model, person):
    depth_m, mask, truth = person
    rows, columns = np.nonzero(truth == 1)
    hole = (slice(rows[0] + 10, rows[0] + 13), slice(columns[0] + 6, columns[0] + 9))
    depth_m = depth_m.copy()
    depth_m[hole] = np.nan
    parts = segment(depth_m, mask, FOCAL_PX, model, LimbParams(step=1))
    assert (parts.chosen[hole] == 1).all()


def test_what_is_no_limb_is_left_out(person):
    model = model_of(train_forest(Bars(12, ("left_hand", "torso", CLUTTER)), PARAMS, seed=1))
    depth_m, mask, truth = person
    parts = segment(depth_m, mask, FOCAL_PX, model, LimbParams(step=1))
    assert parts.labels.names == ("left_hand", "torso")
    assert (parts.chosen[truth == 2] == -1).mean() > 0.9
    shown = truth[parts.pixels] == 2
    assert parts.probabilities[shown].sum(axis=1).mean() < 0.2


def test_a_step_must_be_positive():
    with pytest.raises(ValueError, match="step"):
        LimbParams(step=0)


def test_a_model_comes_back_from_its_file(model, tmp_path, person):
    depth_m, mask, _ = person
    save_model(model, tmp_path / "model.npz")
    again = load_model(tmp_path / "model.npz")
    np.testing.assert_array_equal(again.omega_2, model.omega_2)
    np.testing.assert_array_equal(
        segment(depth_m, mask, FOCAL_PX, again).chosen,
        segment(depth_m, mask, FOCAL_PX, model).chosen,
    )
    with pytest.raises(FileError, match="cannot be read"):
        load_model(tmp_path / "none.npz")


def test_a_model_of_other_limbs_is_refused(model):
    with pytest.raises(LimbError, match="full-body-15"):
        model.require(FULL_BODY)
    model.require(model.labels)


def test_rounding_hardly_changes_what_a_forest_says(model, person):
    depth_m, mask, _ = person
    before = model.forest.probabilities(depth_m, mask, FOCAL_PX)
    rounded = model.forest.rounded()
    np.testing.assert_allclose(rounded.leaves.sum(axis=1), 1.0, atol=1e-5)
    after = rounded.probabilities(depth_m, mask, FOCAL_PX)
    assert np.abs(after - before).mean() < 0.01


def test_merged_labels_are_what_training_with_them_would_have_counted(model):
    """One tree that was trained with both hands apart, its leaves joined by hand."""
    onto = {"left_hand": "hand", "right_hand": "hand"}
    wanted = LimbLabels("own", ("hand", "torso"))
    joined = merged(model, wanted, onto)
    pixels = np.array(model.forest.provenance["label_pixels"], float)
    first_leaf = 0
    counts = model.forest.leaves[first_leaf] * pixels[0]
    shares = np.array([counts[[0, 2]].sum(), counts[1]])
    shares /= np.array([pixels[0, [0, 2]].sum(), pixels[0, 1]])
    np.testing.assert_allclose(joined.forest.leaves[0], shares / shares.sum(), rtol=1e-4)
    np.testing.assert_array_equal(
        np.array(joined.forest.provenance["label_pixels"]).sum(axis=1), pixels.sum(axis=1)
    )


def test_fewer_labels_are_read_as_such():
    images = Bars(1)
    _, labels, _ = images.read(0)
    fewer = Relabelled(images, ("torso", "hand"), {"left_hand": "hand", "right_hand": "hand"})
    _, merged_labels, _ = fewer.read(0)
    np.testing.assert_array_equal(merged_labels == 2, (labels == 1) | (labels == 3))
    np.testing.assert_array_equal(merged_labels == 1, labels == 2)
    assert len(fewer) == 1
    assert set(TO_TORSO) | set(UPPER_BODY.names) == set(FULL_BODY.names)


def test_the_seven_labels_have_the_table_of_the_thesis():
    table = omega_2(UPPER_BODY.names)
    price = {
        (first, second): table[UPPER_BODY.names.index(first), UPPER_BODY.names.index(second)]
        for first in UPPER_BODY.names
        for second in UPPER_BODY.names
    }
    assert price["left_upper_arm", "right_upper_arm"] == price["right_hand", "left_hand"] == 10
    assert price["left_lower_arm", "right_hand"] == price["right_lower_arm", "left_hand"] == 5
    assert price["left_lower_arm", "right_lower_arm"] == price["torso", "left_hand"] == 1
    assert (np.diag(table) == 0).all()


def test_the_full_body_goes_on_with_its_idea():
    names = FULL_BODY.names
    table = omega_2((*names, CLUTTER))
    at = {name: number for number, name in enumerate((*names, CLUTTER))}
    assert table[at["left_lower_leg"], at["right_lower_leg"]] == 10
    assert table[at["left_foot"], at["right_lower_leg"]] == 5
    assert table[at["left_lower_arm"], at["right_lower_arm"]] == 10
    assert table[at["head"], at[CLUTTER]] == 1


def test_confusion_counts_by_class():
    truth, found = np.array([0, 0, 0, 1, 1, 2]), np.array([0, 0, 1, 1, 0, 2])
    confusion = confusion_of(("a", "b", "c", "d"), truth, found)
    np.testing.assert_allclose(confusion.per_class, [2 / 3, 1 / 2, 1, np.nan])
    assert confusion.mean_per_class == pytest.approx((2 / 3 + 1 / 2 + 1) / 3)
    assert confusion.overall == pytest.approx(4 / 6)
    assert (confusion + confusion).counts.sum() == 12
    assert np.isnan(no_confusion(("a",)).mean_per_class)
    assert np.isnan(no_confusion(("a",)).overall)


def standing(distance_m=2.0, shape=(100, 80)):
    depth_m = np.full(shape, np.nan, np.float32)
    depth_m[10:90, 30:50] = distance_m
    return depth_m, np.isfinite(depth_m)


def said(judgement):
    return " ".join(notice.text for notice in judgement.notices)


def test_a_whole_person_gives_no_word():
    judgement = judge_mask(*standing())
    assert judgement.is_person
    assert not judgement.notices


@pytest.mark.parametrize("mask", [None, np.zeros((100, 80), bool)])
def test_nobody_is_said_to_be_nobody(mask):
    judgement = judge_mask(standing()[0], mask)
    assert not judgement.is_person
    assert "Nobody" in said(judgement)


def test_who_is_too_near_is_told_how_near():
    judgement = judge_mask(*standing(0.62))
    assert not judgement.is_person
    assert "0.6 m" in said(judgement)


def test_who_is_full_of_holes_is_told_so():
    depth_m, mask = standing()
    depth_m[10:60, 30:50] = np.nan
    judgement = judge_mask(depth_m, mask)
    assert not judgement.is_person
    assert "62 %" in said(judgement)


def test_who_has_no_depth_at_all_is_nothing_but_holes():
    depth_m, mask = standing()
    judgement = judge_mask(np.full_like(depth_m, np.nan), mask)
    assert not judgement.is_person
    assert "100 %" in said(judgement)


def test_half_a_person_is_told_to_step_back():
    depth_m, mask = standing()
    judgement = judge_mask(depth_m[:60], mask[:60])
    assert judgement.is_person
    assert "part of the person" in said(judgement)


def parts_of(chosen_share):
    """Parts of 4 limbs and clutter in 100 pixels."""
    from adibas.data.limbs import LimbParts

    labels = LimbLabels("own", ("a", "b", "c", "d"))
    chosen = np.full((10, 10), -1, np.int16)
    chosen.ravel()[: sum(chosen_share)] = np.repeat(np.arange(4), chosen_share)
    probabilities = np.full((100, 4), 0.25, np.float32)
    return LimbParts(labels, np.ones((10, 10), bool), probabilities, chosen)


def test_furniture_is_no_person():
    mask = np.ones((10, 10), bool)
    judgement = judge_parts(parts_of((20, 10, 10, 10)), mask)
    assert not judgement.is_person
    assert "50 %" in said(judgement)


def test_one_limb_alone_is_no_person():
    mask = np.ones((10, 10), bool)
    judgement = judge_parts(parts_of((100, 0, 0, 0)), mask)
    assert not judgement.is_person
    assert "1 of 4" in said(judgement)
    assert judge_parts(parts_of((50, 50, 0, 0)), mask).is_person


def test_the_table_of_a_model_is_that_of_its_provenance(model):
    table = 3 * np.asarray(model.omega_2)
    forest = replace(model.forest, provenance={"omega_2": table.tolist()})
    np.testing.assert_array_equal(model_of(forest).omega_2, table)


@pytest.mark.parametrize("step", [2, 3, 4])
def test_pixels_between_have_the_label_of_the_nearest_sample_the_upper_left_of_equals(step):
    rng = np.random.default_rng(step)
    mask = cv2.GaussianBlur(rng.standard_normal((36, 47)), (0, 0), 1.5) > 0
    every = np.s_[::step, ::step]
    thin = np.full(mask[every].shape, -1, np.int16)
    known = mask[every] & (rng.random(mask[every].shape) < 0.7)
    thin[known] = rng.integers(0, 7, np.count_nonzero(known))
    labels = filled_between(thin, mask, step)
    samples = np.argwhere(known)
    for row, column in np.argwhere(mask):
        gaps = ((samples * step - (row, column)) ** 2).sum(axis=1)
        assert labels[row, column] == thin[tuple(samples[gaps.argmin()])]
    assert (labels[~mask] == -1).all()


def test_without_a_labelled_sample_no_pixel_has_a_label():
    labels = filled_between(np.full((3, 4), -1, np.int16), np.ones((6, 8), np.bool_), 2)
    assert (labels == -1).all()


@pytest.mark.parametrize("step", [1, 2, 3])
def test_limbs_do_not_depend_on_how_much_is_around_the_person(model, person, step):
    depth_m, mask, _ = person
    around = ((6, 18), (12, 30))
    wide_m = np.pad(depth_m, around, constant_values=3.0)
    params = LimbParams(step=step)
    alone = segment(depth_m, mask, FOCAL_PX, model, params)
    within = segment(wide_m, np.pad(mask, around), FOCAL_PX, model, params)
    np.testing.assert_array_equal(within.probabilities, alone.probabilities)
    np.testing.assert_array_equal(within.pixels, np.pad(alone.pixels, around))
    np.testing.assert_array_equal(within.chosen, np.pad(alone.chosen, around, constant_values=-1))
