"""How often a pixel has the right label, class by class."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import AnyArray, FloatArray, IntArray, check_shape, read_only


@dataclass(frozen=True, slots=True, eq=False)
class Confusion:
    """Pixels by true label (row) and found label (column).

    Attributes
    ----------
    labels : tuple of str
    counts : (L, L) int64 array
    """

    labels: tuple[str, ...]
    counts: IntArray

    def __post_init__(self) -> None:
        check_shape("counts", self.counts, (len(self.labels), len(self.labels)))
        read_only(self.counts)

    def __add__(self, other: "Confusion") -> "Confusion":
        return Confusion(self.labels, self.counts + other.counts)

    @property
    def per_class(self) -> FloatArray:
        """Return (L,) shares of right pixels of each label; NaN where a label never occurs."""
        totals = self.counts.sum(axis=1)
        with np.errstate(invalid="ignore"):
            return np.asarray(np.diag(self.counts) / np.where(totals > 0, totals, np.nan))

    @property
    def mean_per_class(self) -> float:
        """Return the mean of `per_class`, as the thesis' tables have it; NaN without pixels."""
        shares = self.per_class
        known = shares[np.isfinite(shares)]
        return float(known.mean()) if known.size else float("nan")

    @property
    def overall(self) -> float:
        """Return the share of right pixels; NaN without pixels."""
        total = self.counts.sum()
        return float(np.trace(self.counts) / total) if total else float("nan")


def no_confusion(labels: tuple[str, ...]) -> Confusion:
    """Return one without pixels, to begin with."""
    return Confusion(labels, np.zeros((len(labels), len(labels)), np.int64))


def confusion_of(labels: tuple[str, ...], truth: AnyArray, found: AnyArray) -> Confusion:
    """Count (N,) true labels against (N,) found ones, both 0 to L - 1."""
    n_labels = len(labels)
    pairs = truth.astype(np.int64) * n_labels + found
    counts = np.bincount(pairs, minlength=n_labels**2).reshape(n_labels, n_labels)
    return Confusion(labels, counts.astype(np.int64))
