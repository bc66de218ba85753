"""The tables and maps of a calibration's workbook that share a sheet with others."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.quality import map_residuals
from adibas.data.calibration_report import CalibrationReport, DepthReport
from adibas.data.camera_fit import CameraFit
from adibas.reports.calibration_depth_rows import bias_rows, depth_parameter_rows, shot_rows
from adibas.reports.calibration_rows import (
    DISTANCES_M,
    LENGTH_M,
    MM_PER_M,
    SURE,
    image_rows,
    known,
    uncertainty_map,
    uncertainty_rows,
)
from adibas.reports.sheets import Block, Column, Value
from adibas.texts import decimal_text
from adibas.texts import translate as _

FINE, FINER, ONE, TWO = "0.000", "0.0000", "0.0", "0.00"
"""Number formats."""

TILT_LIMITS_DEG = (0, 12, 20, 30, 45, 90)
SIDES = 4
MAP_WIDTH, TABLE_WIDTH = 10, 13


def coverage_blocks(report: CalibrationReport, fit: CameraFit) -> Iterator[Block]:
    """Yield maps of the image, and how the boards were tilted."""
    found = map_residuals(fit)
    n_rows, n_columns = found.counts.shape
    across = np.linspace(0, fit.camera.width, n_columns + 1)
    down = np.linspace(0, fit.camera.height, n_rows + 1)
    us, vs = _ranges(across), _ranges(down)
    maps = (
        (_("Corners in each part of the image"), found.counts.astype(float), "0"),
        (_("Error in each part, rms over points [px]"), found.rms_px, FINE),
    )
    for heading, values, number_format in maps:
        yield _map(heading, (us, vs), values, number_format)
    headings = (_("Mean error to the right [px]"), _("Mean error downwards [px]"))
    for heading, values in zip(headings, np.moveaxis(found.means_px, -1, 0), strict=True):
        yield replace(_map(heading, (us, vs), values, FINE), is_signed=True)
    yield _tilts(report)


def _tilts(report: CalibrationReport) -> Block:
    """Return how many boards were tilted how much, and which way."""
    rows = [row for row in image_rows(report) if row.tilt_deg is not None]
    tilts = np.array([row.tilt_deg for row in rows], float)
    leans = np.array([row.lean_deg for row in rows], float)
    # Quarters around right, down, left and up.
    quarters = np.floor(((leans + 45.0) % 360.0) / 90.0).astype(int) % SIDES
    cells: list[tuple[Value, ...]] = []
    for low, high in pairwise(TILT_LIMITS_DEG):
        is_such = (tilts >= low) & (tilts < high)
        counts = np.bincount(quarters[is_such], minlength=SIDES).tolist()
        cells.append((f"{low} \N{EN DASH} {high}", int(is_such.sum()), *counts))
    columns = [
        Column(_("Tilt [deg]"), 14),
        *(
            Column(name, MAP_WIDTH, "0")
            for name in (_("Boards"), _("to the right"), _("down"), _("to the left"), _("up"))
        ),
    ]
    return Block(_("Tilts of the board, and where it leans away to"), columns, cells)


def uncertainty_blocks(fit: CameraFit) -> Iterator[Block]:
    """Yield a line for each distance, then the maps of the image at each."""
    length = _("length of {length} m [mm]")
    columns = [
        Column(_("Distance [m]"), 14, ONE),
        Column(_("middle of all [px]"), TABLE_WIDTH, FINE),
        Column(_("worst [px]"), TABLE_WIDTH, FINE),
        Column(_("worst [mm]"), TABLE_WIDTH, TWO),
        Column(length.format(length=decimal_text(LENGTH_M, 0)), TABLE_WIDTH, TWO),
    ]
    cells = [
        (row.distance_m, row.median_px, row.worst_px, row.worst_mm, row.length_mm)
        for row in uncertainty_rows(fit)
    ]
    yield Block(_("By distance: 95 %, plus or minus"), columns, cells)
    for distance_m in DISTANCES_M:
        found = uncertainty_map(fit, distance_m)
        us = [f"{u:.0f}" for u in found.pixels[0, :, 0] + 0.5]
        vs = [f"{v:.0f}" for v in found.pixels[:, 0, 1] + 0.5]
        where = decimal_text(distance_m, 0)
        in_px = _("Where a point at {distance} m is seen: 95 %, plus or minus [px]")
        in_mm = _("Where a point seen at {distance} m is: 95 %, plus or minus [mm]")
        yield _map(in_px.format(distance=where), (us, vs), SURE * found.sd_px, FINE)
        yield _map(in_mm.format(distance=where), (us, vs), MM_PER_M * SURE * found.sd_m, TWO)


def depth_blocks(depth: DepthReport) -> Iterator[Block]:
    """Yield pose and error of the depth camera, and its shots; the checks are in the summary."""
    yield _depth_parameters(depth)
    if depth.shots:
        yield _bias(depth)
        yield _shots(depth)


def _depth_parameters(depth: DepthReport) -> Block:
    parameters = [
        Column(_("Parameter"), 30),
        Column(_("Value"), 16, FINER),
        Column(_("95 % from"), 16, FINER),
        Column(_("95 % to"), 16, FINER),
        Column(_("Unit"), 10),
    ]
    cells = [
        (row.name, row.value, row.low, row.high, row.unit) for row in depth_parameter_rows(depth)
    ]
    return Block(_("Pose and own error of the depth camera"), parameters, cells)


def _bias(depth: DepthReport) -> Block:
    curve = [
        Column(_("Measured depth [m]"), 30, TWO),
        Column(_("Added [mm]"), 16, TWO),
        Column(_("95 % from [mm]"), 16, TWO),
        Column(_("95 % to [mm]"), 16, TWO),
    ]
    added = [(row.measured_m, row.added_mm, row.low_mm, row.high_mm) for row in bias_rows(depth)]
    return Block(_("Correction of the depth in the middle of the image"), curve, added)


def _shots(depth: DepthReport) -> Block:
    shots = [
        Column(_("Shot"), 30),
        Column(_("Shows"), 16),
        Column(_("Minute"), 16, ONE),
        Column(_("Distance [m]"), 16, FINE),
        Column(_("Error left [mm]"), 12, TWO),
        Column(_("sd by the corners' noise [mm]"), 14, TWO),
        Column(_("About its plane, rms [mm]"), 14, TWO),
        Column(_("Remark"), 40),
    ]
    lines = [
        (
            row.name,
            row.kind,
            row.minutes,
            row.distance_m,
            row.error_mm,
            row.noise_mm,
            row.rms_mm,
            _("contradicts the others and took no part") if row.is_outlier else None,
        )
        for row in shot_rows(depth)
    ]
    return Block(_("Boards and walls seen in depth"), shots, lines)


def _map(
    heading: str,
    places: tuple[list[str], list[str]],
    values: FloatArray,
    number_format: str,
) -> Block:
    """Return a map of the image; `places` name its columns (u) and its rows (v)."""
    us, vs = places
    columns = [Column("v / u [px]", 14)]
    columns += [Column(u, MAP_WIDTH, number_format) for u in us]
    rows = [(v, *map(known, line)) for v, line in zip(vs, values.tolist(), strict=True)]
    return Block(heading, columns, rows, is_map=True)


def _ranges(limits: FloatArray) -> list[str]:
    return [f"{low:.0f} \N{EN DASH} {high:.0f}" for low, high in pairwise(limits)]
