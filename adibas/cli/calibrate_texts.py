"""What `adibas calibrate` says of a calibration, as lines and as a JSON document."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from adibas.calibration.quality import (
    board_errors,
    map_residuals,
    mean_board_error_m,
    tilts_rad,
)
from adibas.data.camera_fit import CameraFit
from adibas.pipeline.calibrating import CameraOutcome, SearchedImage, parameter_intervals
from adibas.reports.calibration_facts import DEFINITIONS
from adibas.reports.calibration_rows import LENGTH_M, SURE, UncertaintyRow, uncertainty_rows
from adibas.texts import SpokenNumber
from adibas.texts import translate as _


def describe_outcome(outcome: CameraOutcome) -> Iterator[str]:
    """Give the lines for a reader: images, parameters, what they are worth, and what to do."""
    yield from describe_camera(outcome)
    yield from outcome.verdict.sentences()


def describe_camera(outcome: CameraOutcome) -> Iterator[str]:
    """Give the lines without the verdict."""
    from adibas.calibration.finder import TEXTS

    for image in outcome.images:
        if image.search.problem is not None:
            text = _(TEXTS[image.search.problem]).format(**image.search.fields)
            yield f"{image.name}: {text}"
    fit = outcome.fit
    if fit is not None and fit.is_settled:
        yield from _describe_fit(fit)
        yield _("Corners: {definition}.").format(definition=_(DEFINITIONS[outcome.method.value]))
        yield _(
            "Distances rest on squares of {side:g} mm: measure one with a ruler. Images alone do "
            "not show a wrong size."
        ).format(side=1000.0 * fit.board.square_m)


def document(outcome: CameraOutcome, out: Path | None) -> dict[str, object]:
    """Return everything as plain values."""
    fit = outcome.fit if outcome.fit is not None and outcome.fit.is_settled else None
    found: dict[str, object] = {
        "out": None if out is None else str(out),
        "verdict": {
            "grade": outcome.verdict.grade.value,
            "sentences": list(outcome.verdict.sentences()),
            "findings": [
                {
                    "reason": finding.reason.value,
                    "grade": finding.grade.value,
                    "text": finding.text,
                }
                for finding in outcome.verdict.findings
            ],
        },
        "images": _images(outcome),
        "corners": outcome.method.value,
    }
    return found | (_fit_document(fit) if fit is not None else {})


def _describe_fit(fit: CameraFit) -> Iterator[str]:
    yield _("Lens model: {model}. {n} images, error {rms:.3f} pixels (rms over points).").format(
        model=fit.model, n=len(fit.used_views), rms=SpokenNumber(fit.rms_px)
    )
    for name, value, sd in zip(
        fit.parameter_names, fit.values, fit.standard_deviations, strict=True
    ):
        yield f"  {name:3} {value:12.6g} ± {SURE * sd:.2g}"
    q_m = mean_board_error_m(board_errors(fit))
    if not math.isnan(q_m):
        yield _("Mean error on the board (Q): {q:.3f} mm.").format(q=SpokenNumber(1000.0 * q_m))
    outliers = sum(len(view.outlier_corners) for view in fit.used_views)
    if outliers:
        yield _("Corners that contradict the rest and took no part: {n}.").format(n=outliers)


def _fit_document(fit: CameraFit) -> dict[str, object]:
    parameters = {
        name: {"value": value, "sd": sd, "ci95": interval}
        for name, value, sd, interval in zip(
            fit.parameter_names,
            fit.values.tolist(),
            fit.standard_deviations.tolist(),
            parameter_intervals(fit).tolist(),
            strict=True,
        )
    }
    return {
        "model": fit.model,
        "parameters": parameters,
        "rms_px": fit.rms_px,
        "rms_convention": "points",
        "sigma_px": fit.sigma_px,
        "birge_ratio": _finite(fit.birge_ratio),
        "skew_px": {"value": _finite(fit.skew_px), "sd": _finite(fit.skew_sd_px)},
        "covered_share": map_residuals(fit).covered_share,
        "tilts_deg": np.degrees(tilts_rad(fit)).round(1).tolist(),
        "q_mm": _finite(1000.0 * mean_board_error_m(board_errors(fit))),
        "uncertainty": [_uncertainty(row) for row in uncertainty_rows(fit)],
    }


def _uncertainty(row: UncertaintyRow) -> dict[str, object]:
    return {
        "distance_m": row.distance_m,
        "median_ci95_px": row.median_px,
        "worst_ci95_px": row.worst_px,
        "worst_ci95_mm": row.worst_mm,
        "length_m": LENGTH_M,
        "length_ci95_mm": row.length_mm,
    }


def _images(outcome: CameraOutcome) -> list[dict[str, object]]:
    fit = outcome.fit
    views = {view.image: view for view in fit.views} if fit is not None else {}
    errors = {error.image: error for error in board_errors(fit)} if fit is not None else {}
    rows = []
    for image in outcome.images:
        row = _image(image)
        view, error = views.get(image.name), errors.get(image.name)
        if view is not None:
            row |= {
                "rms_px": _finite(view.rms_px),
                "is_outlier": view.is_outlier,
                "n_outlier_corners": len(view.outlier_corners),
            }
        if error is not None:
            row |= {"distance_m": error.distance_m, "q_mm": 1000.0 * error.q_m}
        rows.append(row)
    return rows


def _image(image: SearchedImage) -> dict[str, object]:
    problem = image.search.problem
    corners = image.search.corners
    return {
        "name": image.name,
        "problem": None if problem is None else problem.value,
        "n_corners": 0 if corners is None else corners.n_seen,
        "blur_px": _finite(image.blur_px),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
