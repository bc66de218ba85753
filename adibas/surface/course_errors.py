"""What errors that go along the spine make of a root mean square and of a greatest value.

Neighbouring heights err alike: errors are drawn as a Gaussian process, and the measure is taken of
each drawn course (parametric bootstrap; Efron & Tibshirani, An introduction to the bootstrap,
1993, sections 6.5 and 13.3). Of a straight spine the greatest value may lie to either side: the
interval of its percentiles then holds both.
"""

import numpy as np

from adibas.arrays import FloatArray
from adibas.surface.sagittal import Estimate

N_DRAWS = 400
PERCENTILES = 2.5, 97.5
REACH_M = 0.1
"""Matern's length: errors 45 mm apart are alike by 0.8, 90 mm apart by 0.5 (63 simulated backs)."""


def drawn_errors(y_m: FloatArray, sd: float) -> FloatArray:
    """Return (M, N) errors at (M,) heights, with Matern's correlation of order 3/2.

    Source: Rasmussen & Williams, Gaussian processes for machine learning (2006), equation 4.17.
    """
    apart = np.sqrt(3.0) * np.abs(y_m[:, None] - y_m[None, :]) / REACH_M
    alike = (1.0 + apart) * np.exp(-apart)
    root = np.linalg.cholesky(alike + 1e-9 * np.eye(len(y_m)))
    return np.asarray(sd * root @ np.random.default_rng(0).normal(size=(len(y_m), N_DRAWS)))


def rms(course: FloatArray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(course**2)))


def rms_interval(course: FloatArray, drawn: FloatArray) -> tuple[float, float]:
    """Return the 95 % interval of the root mean square of a course, of (M, N) drawn ones."""
    sd = float(np.std(np.sqrt(np.mean(drawn**2, axis=0))))
    low, high = Estimate(rms(course), sd).interval
    return max(low, 0.0), high


def greatest(course: FloatArray) -> float:
    """Return the value farthest from 0, with its sign."""
    return float(course[np.abs(course).argmax()])


def greatest_interval(drawn: FloatArray) -> tuple[float, float]:
    """Return the 95 % interval of the greatest value, of (M, N) drawn courses."""
    farthest = drawn[np.abs(drawn).argmax(axis=0), np.arange(drawn.shape[1])]
    low, high = np.percentile(farthest, PERCENTILES)
    return float(low), float(high)
