"""How likely a faint spot is a marker: by what it looks like, and by how many look nearly so."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.markers.spot_odds_learned import CROWD, OFFSET, UNITS

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

FORMS = np.linspace(0.2, 1.0, 9)
"""Short over long axis of what may be a marker."""
CROWD_ODDS = -8.0, -2.0
"""Log odds of what looks a little like a marker and is none: the crowd of a picture."""
LARGEST_CROWD = 100
"""Of a picture that is learned from; more count as many."""


@dataclass(frozen=True, slots=True)
class SpotOdds:
    """Log odds that a spot is a marker.

    By its look alone they are what a network of one layer says, offset + sum of v tanh(b + w'x).
    Where much in a picture looks a little like markers, more is likely to look much like one by
    chance: with m = log(1 + size of that crowd) and k the crowd's weights, the odds become
    k0 + k1 odds + k2 m + k3 odds m.

    Attributes
    ----------
    units : tuple of tuple of float
        Of each unit v, b, and w by feature.
    offset : float
    crowd : tuple of float
    """

    units: tuple[tuple[float, ...], ...] = UNITS
    offset: float = OFFSET
    crowd: tuple[float, float, float, float] = CROWD

    def __post_init__(self) -> None:
        if not self.units or any(len(unit) != 2 + len(FEATURES) for unit in self.units):
            raise ValueError(f"a unit must be its weight, its bias and {len(FEATURES)} weights")

    def alone(self, features: FloatArray) -> FloatArray:
        """Return the (N,) log odds of (N, 8) features by themselves."""
        check_shape("features", features, (len(features), len(FEATURES)))
        units = np.array(self.units)
        return self._out_of(features @ units[:, 2:].T + units[:, 1], units)

    def alone_in_best_form(self, looks: FloatArray) -> FloatArray:
        """Return the (N,) log odds of (N, 7) features if the form is the likeliest of `FORMS`."""
        units = np.array(self.units)
        of_looks = looks @ units[:, 2:-1].T + units[:, 1]
        of_forms = [self._out_of(of_looks + form * units[:, -1], units) for form in FORMS]
        best: FloatArray = np.max(of_forms, axis=0)
        return best

    def _out_of(self, sums: FloatArray, units: FloatArray) -> FloatArray:
        odds: FloatArray = np.tanh(sums) @ units[:, 0] + self.offset
        return odds

    def among(self, alone: FloatArray, n_crowd: int) -> FloatArray:
        """Return the (N,) log odds in a picture with such a crowd; see `crowd_size`."""
        much = float(log_crowd(n_crowd))
        base, slope, of_crowd, of_both = self.crowd
        return base + of_crowd * much + (slope + of_both * much) * alone


def log_crowd(n_crowd: FloatArray | int) -> FloatArray:
    """Return log(1 + n), of `LARGEST_CROWD` where there are more."""
    return np.asarray(np.log1p(np.minimum(n_crowd, LARGEST_CROWD)))


def crowd_size(in_best_form: FloatArray) -> int:
    """Return how many spots of a picture look a little like a marker."""
    least, most = CROWD_ODDS
    return int(((in_best_form > least) & (in_best_form < most)).sum())
