"""Sets of limbs, and the parts that a segmentation finds."""

import numpy as np
import pytest

from adibas.data.joints import BODY_PART_NAMES
from adibas.data.limbs import (
    FULL_BODY,
    LABEL_SETS,
    UPPER_BODY,
    LimbLabels,
    LimbParts,
    labels_named,
)


def parts(chosen, labels=UPPER_BODY, probabilities=None):
    chosen = np.array(chosen, np.int16)
    pixels = chosen >= 0
    if probabilities is None:
        probabilities = np.eye(len(labels), dtype=np.float32)[chosen[pixels]]
    return LimbParts(labels, pixels, probabilities, chosen)


def test_the_sets_have_the_names_of_the_interface():
    assert " ".join(UPPER_BODY.names) == (
        "left_upper_arm left_lower_arm left_hand right_upper_arm right_lower_arm right_hand torso"
    )
    assert FULL_BODY.names == BODY_PART_NAMES
    assert {name: len(labels) for name, labels in LABEL_SETS.items()} == {
        "upper-body-7": 7,
        "full-body-15": 15,
        "hand-6": 6,
    }


def test_names_find_their_set():
    assert labels_named(BODY_PART_NAMES) is FULL_BODY
    assert labels_named(("paw", "tail")) == LimbLabels("own", ("paw", "tail"))


def test_a_set_needs_names_and_no_name_twice():
    with pytest.raises(ValueError, match="1 to 120"):
        LimbLabels("own", ())
    with pytest.raises(ValueError, match="same name"):
        LimbLabels("own", ("torso", "torso"))


def test_each_side_has_its_mirror_image_and_the_middle_itself():
    mirrored = FULL_BODY.mirrored
    assert mirrored[FULL_BODY.names.index("left_hand")] == FULL_BODY.names.index("right_hand")
    assert mirrored[FULL_BODY.names.index("right_foot")] == FULL_BODY.names.index("left_foot")
    assert mirrored[FULL_BODY.names.index("torso")] == FULL_BODY.names.index("torso")
    assert [mirrored[k] for k in mirrored] == list(range(len(FULL_BODY)))


def test_a_side_without_the_other_is_its_own_mirror_image():
    assert LimbLabels("own", ("left_hand", "torso")).mirrored == (0, 1)


def test_parts_cannot_be_written_and_tell_where_a_limb_is():
    found = parts([[-1, 6], [2, 6]])
    np.testing.assert_array_equal(found.of("torso"), [[False, True], [False, True]])
    with pytest.raises(ValueError, match="read-only"):
        found.chosen[0, 0] = 1


def test_swapped_sides_swap_back():
    found = parts([[-1, 6], [2, 3]])
    swapped = found.with_sides_swapped()
    np.testing.assert_array_equal(swapped.chosen, [[-1, 6], [5, 0]])
    np.testing.assert_array_equal(swapped.probabilities.argmax(axis=1), [6, 5, 0])
    back = swapped.with_sides_swapped()
    np.testing.assert_array_equal(back.chosen, found.chosen)
    np.testing.assert_array_equal(back.probabilities, found.probabilities)


def test_probabilities_must_fit_the_pixels_and_chosen_labels_be_small_integers():
    with pytest.raises(ValueError, match="probabilities"):
        parts([[0, 1]], probabilities=np.ones((1, 7), np.float32))
    pixels = np.ones((1, 1), bool)
    with pytest.raises(ValueError, match="int16"):
        LimbParts(UPPER_BODY, pixels, np.ones((1, 7), np.float32), np.zeros((1, 1), int))
