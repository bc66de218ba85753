"""How likely a faint spot is a marker: log odds, quadratic in what the spot looks like."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape

FEATURES = (
    "unexplained",
    "aside",
    "log_separation",
    "log_contrast",
    "middle",
    "against",
    "log_share",
    "axis_ratio",
)
"""What the odds go by, in their order; the form comes last.

Of its contrast the share that no colour beside it explains; how far its colour is beside the way to
the marker's, CIELAB units; the logarithm of its contrast in standard deviations of the surround;
that of its contrast, CIELAB units; how much of it the nine pixels in the middle have (noise is no
disc); the root of how far its ring goes the other way, as a share of it (dots that the mosaic makes
of a seam have the opposite colour beside them); the logarithm of how far its colour is on the way
to the marker's (what is wide and full is the marker itself, or none); short over long axis.
"""

LEARNED = (
    (-3.4291, -7.1638, 0.016095, 2.8011, -2.8604, 4.2237, -2.7819, 3.7074, 0.72992),
    (-1.0197, -0.71789, -1.3323, 6.5008, -4.9201, -10.236, -4.0047, 14.066),
    (0.017803, -0.00020486, 0.10406, -0.038634, 0.27687, 0.21718, -0.80859),
    (-0.28182, 0.00030522, 0.15958, -0.39611, 0.16091, -1.0186),
    (-0.65801, 0.027007, 0.54005, -0.27327, 6.2168),
    (-1.3517, 0.11787, -0.59683, 3.5007),
    (0.26428, -0.2718, 1.8306),
    (0.092648, -1.0367),
    (-13.876,),
)
"""Of 1 and the features: what each product counts, from the diagonal on.

Learned by logistic regression from 383,795 spots in 408 simulated scenes, of which 2,783 were
markers (`python -m benchmarks.train_spots`).
"""


@dataclass(frozen=True, slots=True)
class SpotOdds:
    """Log odds that a spot is a marker: x'Wx, where x is 1 and its features.

    Attributes
    ----------
    weights : tuple of tuple of float
        The upper triangle of W, row by row.
    """

    weights: tuple[tuple[float, ...], ...] = LEARNED

    def __post_init__(self) -> None:
        n_terms = 1 + len(FEATURES)
        if tuple(len(row) for row in self.weights) != tuple(range(n_terms, 0, -1)):
            raise ValueError(f"weights must be the upper triangle of {n_terms} rows")

    @property
    def matrix(self) -> FloatArray:
        """Return W, zero below its diagonal."""
        n_terms = len(self.weights)
        matrix = np.zeros((n_terms, n_terms))
        for index, row in enumerate(self.weights):
            matrix[index, index:] = row
        return matrix

    def of(self, features: FloatArray) -> FloatArray:
        """Return the (N,) log odds of (N, 8) features."""
        check_shape("features", features, (len(features), len(FEATURES)))
        terms = np.column_stack([np.ones(len(features)), features])
        odds: FloatArray = np.einsum("ni,ij,nj->n", terms, self.matrix, terms)
        return odds

    def in_best_form(self, looks: FloatArray) -> FloatArray:
        """Return the (N,) log odds of (N, 7) features if the form is the likeliest there is."""
        rest = np.column_stack([looks, np.zeros(len(looks))])
        terms = np.column_stack([np.ones(len(looks)), looks])
        slope, bend = terms @ self.matrix[:-1, -1], self.matrix[-1, -1]
        forms = np.zeros((2, len(looks)))
        forms[1] = 1.0
        if bend < 0.0:
            forms[0] = np.clip(-0.5 * slope / bend, 0.0, 1.0)
        odds: FloatArray = self.of(rest) + (forms * slope + bend * forms**2).max(axis=0)
        return odds
