"""Limbs as labels of pixels: the sets of names, and what a segmentation found in a depth image."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, check_shape, read_only
from adibas.data.joints import BODY_PART_NAMES, mirror_order

NO_LABEL = -1
MOST_LABELS = 120
"""One byte of an image holds them, 0 for none, and something that is no limb besides."""


@dataclass(frozen=True, slots=True)
class LimbLabels:
    """A set of limbs; left and right are the patient's.

    Attributes
    ----------
    name : str
        Of the set: ``upper-body-7``, ``full-body-15``, ``hand-6``, or ``own`` for any other.
    names : tuple of str
        The L labels; label k is value k + 1 in an image of labels.
    """

    name: str
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        if not 0 < len(self.names) <= MOST_LABELS:
            raise ValueError(f"there can be 1 to {MOST_LABELS} labels, got {len(self.names)}")
        if len(set(self.names)) < len(self.names):
            raise ValueError("two labels have the same name")

    def __len__(self) -> int:
        return len(self.names)

    @property
    def mirrored(self) -> tuple[int, ...]:
        """Return for each label that of the other side; its own where there is none."""
        return tuple(mirror_order(self.names))


UPPER_BODY = LimbLabels(
    "upper-body-7",
    (
        *(
            f"{side}_{part}"
            for side in ("left", "right")
            for part in ("upper_arm", "lower_arm", "hand")
        ),
        "torso",
    ),
)
FULL_BODY = LimbLabels("full-body-15", BODY_PART_NAMES)
HAND = LimbLabels("hand-6", ("palm", "thumb", "index", "middle", "ring", "little"))
LABEL_SETS = {labels.name: labels for labels in (UPPER_BODY, FULL_BODY, HAND)}


def labels_named(names: tuple[str, ...]) -> LimbLabels:
    """Return the set of these names in this order; called ``own`` where it is none of ours.

    Raises
    ------
    ValueError
        There are none, too many, or two of the same name.
    """
    known = (labels for labels in LABEL_SETS.values() if labels.names == names)
    return next(known, None) or LimbLabels("own", names)


@dataclass(frozen=True, slots=True, eq=False)
class LimbParts:
    """The limbs of one person in one depth image.

    Attributes
    ----------
    labels : LimbLabels
    pixels : (H, W) bool array
        N pixels whose probabilities are known: the person's, or every second of them and so on.
    probabilities : (N, L) float32 array
        In the row-major order of `pixels`. Rows sum to 1, or to less: the rest is the probability
        that the pixel shows something else (furniture).
    chosen : (H, W) int16 array
        The label of every pixel of the person; -1 outside, and where something else is seen.
    """

    labels: LimbLabels
    pixels: BoolArray
    probabilities: Float32Array
    chosen: AnyArray

    def __post_init__(self) -> None:
        check_shape("pixels", self.pixels, (None, None))
        n_pixels = int(np.count_nonzero(self.pixels))
        check_shape("probabilities", self.probabilities, (n_pixels, len(self.labels)))
        check_shape("chosen", self.chosen, self.pixels.shape)
        if self.pixels.dtype != np.bool_ or self.chosen.dtype != np.int16:
            raise ValueError("pixels must be bool, and chosen int16")
        for array in (self.pixels, self.probabilities, self.chosen):
            read_only(array)

    def of(self, name: str) -> BoolArray:
        """Return the (H, W) pixels of the limb of that name."""
        return np.asarray(self.chosen == self.labels.names.index(name))

    def with_sides_swapped(self) -> "LimbParts":
        """Return the parts of a person who turns the back to the camera.

        A model that knows people from the front takes the right arm of such a person for the
        left one.
        """
        other = np.array((*self.labels.mirrored, NO_LABEL), np.int16)
        return LimbParts(
            self.labels,
            self.pixels,
            np.ascontiguousarray(self.probabilities[:, self.labels.mirrored]),
            other[self.chosen],
        )
