"""Which terms of the lens a calibration may use.

The terms are those of thesis equations 4.1-4.5 and of OpenCV: radial (k1, k2, k3), tangential
(p1, p2), rational (k4, k5, k6) and thin prism (s1-s4).
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import IntArray
from adibas.geometry.projection import CAMERA_PARAMETERS

PINHOLE_TERMS = ("fx", "fy", "cx", "cy")
STORED_LENGTHS = (0, 4, 5, 8, 12)
"""How many coefficients a calibration may hold."""

LENS_TERMS = CAMERA_PARAMETERS[5:]


@dataclass(frozen=True, slots=True)
class LensModel:
    """A set of distortion terms, by OpenCV's names.

    Attributes
    ----------
    terms : tuple of str
        Such as ``("k1", "k2")``; all others are 0.
    """

    terms: tuple[str, ...]

    def __post_init__(self) -> None:
        unknown = [term for term in self.terms if term not in LENS_TERMS]
        if unknown or len(set(self.terms)) < len(self.terms):
            raise ValueError(f"terms must be different ones of {LENS_TERMS}, got {self.terms}")

    @property
    def name(self) -> str:
        """The terms in words; ``none`` without any."""
        return " ".join(self.terms) or "none"

    @property
    def parameters(self) -> tuple[str, ...]:
        """The pin-hole's parameters and the terms."""
        return (*PINHOLE_TERMS, *self.terms)

    def free(self) -> IntArray:
        """Return the places of `parameters` in `CAMERA_PARAMETERS`."""
        return np.array([CAMERA_PARAMETERS.index(name) for name in self.parameters], np.int64)

    @property
    def n_stored(self) -> int:
        """How many coefficients a calibration file holds for it."""
        longest = max((LENS_TERMS.index(term) + 1 for term in self.terms), default=0)
        return next(length for length in STORED_LENGTHS if length >= longest)


NO_DISTORTION = LensModel(())
RADIAL_1 = LensModel(("k1",))
RADIAL_2 = LensModel(("k1", "k2"))
BROWN_4 = LensModel(("k1", "k2", "p1", "p2"))
RADIAL_3 = LensModel(("k1", "k2", "k3"))
BROWN_5 = LensModel(("k1", "k2", "p1", "p2", "k3"))
RATIONAL = LensModel(("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"))
THIN_PRISM = LensModel(("k1", "k2", "p1", "p2", "k3", "s1", "s2", "s3", "s4"))
FULL = LensModel(LENS_TERMS)

MODELS = (NO_DISTORTION, RADIAL_1, RADIAL_2, RADIAL_3, BROWN_4, BROWN_5, THIN_PRISM, RATIONAL, FULL)
"""From the fewest terms to the most."""

CANDIDATES = (BROWN_4, BROWN_5, THIN_PRISM, RATIONAL, FULL)
"""What is chosen from where nobody says: from the fewest terms to the most.

The tangential terms are never left out. Every lens is a little off its axis; terms too small to be
seen still move the principal point by more than the interval of a model without them says (it
held the truth in 75 % of simulated calibrations in place of 95 %).
"""

FEW_VIEWS = (NO_DISTORTION, RADIAL_1, RADIAL_2)
"""What few views can tell."""


def model_named(name: str) -> LensModel:
    """Return the model with this `LensModel.name`.

    Raises
    ------
    ValueError
        There is none.
    """
    for model in MODELS:
        if model.name == name:
            return model
    raise ValueError(f"there is no lens model {name!r}")
