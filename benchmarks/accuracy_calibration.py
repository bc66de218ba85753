"""Calibration: corners, fits and depth beside the truth and beside OpenCV; real boards."""

from collections.abc import Iterable

from benchmarks import (
    calibration_chain,
    calibration_coma,
    calibration_corners,
    calibration_depth,
    calibration_real,
    calibration_scene,
)
from benchmarks import calibration_fitting as fitting
from benchmarks.table import Row


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure one part after the other; errors of corners count as rms over points."""
    yield from calibration_corners.rows(quick=quick)
    yield from fitting.rows(quick=quick)
    yield from calibration_real.rows()
    yield from calibration_coma.rows(quick=quick)
    yield from calibration_chain.rows(quick=quick)
    yield from calibration_depth.rows(quick=quick)
    yield from calibration_scene.rows(quick=quick)
