"""Draw the simulated depth noise against the published curves.

``python -m benchmarks.plot_depth_noise`` writes ``docs/images/depth-noise.png``.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.data.calibration import DepthBias
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.device import draw_device

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "depth-noise.png"
DISTANCES_M = np.arange(0.8, 4.01, 0.2)
N_FRAMES = 5
SIZE_PX = (760, 1100)
PLOT_BOX = (110, 60, 1060, 670)
Z_RANGE_M = (0.6, 4.2)
SD_RANGE_MM = (0.0, 36.0)

Point = tuple[int, int]
Color = tuple[int, int, int]


def khoshelham_mm(z_m: FloatArray) -> FloatArray:
    """Return the random error of depth, mm.

    Source: Khoshelham & Elberink 2012, 1.425e-5 z^2 with both in cm.
    """
    return np.asarray(10.0 * 1.425e-5 * (100.0 * z_m) ** 2)


def nguyen_mm(z_m: FloatArray) -> FloatArray:
    """Return the axial noise at 10 to 60 degrees, mm.

    Source: Nguyen, Izadi & Lovell 2012, 0.0012 + 0.0019 (z - 0.4)^2, metres.
    """
    return np.asarray(1.2 + 1.9 * (z_m - 0.4) ** 2)


def rounding_mm(z_m: FloatArray) -> FloatArray:
    """Return what steps of 1/8 pixel alone make: step / sqrt(12), mm (f 580 px, b 75 mm)."""
    return np.asarray(1000.0 * z_m**2 / (8.0 * 0.075 * 580.0) / np.sqrt(12.0))


def plane_fit_sd_mm(noise: DepthNoise, z_m: float, seed: int = 0) -> float:
    """Return the scatter of single frames about a plane fitted to each, mm.

    The plane faces the camera at `z_m`; the sensor has no bias. Window: the middle 400 x 300.
    """
    device = draw_device(seed)
    device = replace(device, calibration=replace(device.calibration, depth_bias=DepthBias()))
    sensor = DepthSensor(device, noise, seed)
    inverse_depth = np.full((480, 640), 1.0 / z_m, np.float32)
    reflectance = np.full((480, 640), 0.6, np.float32)
    rows, columns = np.mgrid[90:390, 120:520]
    squares = []
    # Every third frame, so that the noise of one is new in the next.
    for moment in range(0, 3 * N_FRAMES, 3):
        depth_mm = sensor.measure(inverse_depth, reflectance, moment)[90:390, 120:520].astype(float)
        is_read = depth_mm > 0
        design = np.stack([rows[is_read], columns[is_read], np.ones(is_read.sum())], axis=1)
        plane, *_ = np.linalg.lstsq(design, depth_mm[is_read], rcond=None)
        squares.append(np.mean((depth_mm[is_read] - design @ plane) ** 2))
    return float(np.sqrt(np.mean(squares)))


def main() -> None:
    """Measure, draw, and write the picture."""
    measured_mm = np.array([plane_fit_sd_mm(DepthNoise(), z_m) for z_m in DISTANCES_M])
    picture = _draw(measured_mm)
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(PICTURE), picture)


def _place(z_m: float, sd_mm: float) -> Point:
    left, top, right, bottom = PLOT_BOX
    across = (z_m - Z_RANGE_M[0]) / (Z_RANGE_M[1] - Z_RANGE_M[0])
    up = (sd_mm - SD_RANGE_MM[0]) / (SD_RANGE_MM[1] - SD_RANGE_MM[0])
    return round(left + across * (right - left)), round(bottom - up * (bottom - top))


def _write(picture: UInt8Array, text: str, at: Point, scale: float = 0.6) -> None:
    font = cv2.FONT_HERSHEY_SIMPLEX
    cv2.putText(picture, text, at, font, scale, (40, 40, 40), 1, cv2.LINE_AA)


def _draw(measured_mm: FloatArray) -> UInt8Array:
    picture = np.full((*SIZE_PX, 3), 255, np.uint8)
    _draw_axes(picture)
    curves: tuple[tuple[str, Callable[[FloatArray], FloatArray], Color], ...]
    curves = (
        ("Khoshelham & Elberink 2012: 1.425e-5 z^2 (cm)", khoshelham_mm, (200, 90, 20)),
        ("Nguyen et al. 2012: 1.2 + 1.9 (z - 0.4)^2 mm", nguyen_mm, (40, 140, 40)),
        ("steps of 1/8 pixel alone", rounding_mm, (150, 150, 150)),
    )
    z_m = np.linspace(*Z_RANGE_M, 200)
    for line, (name, curve, color) in enumerate(curves):
        points = np.array([_place(z, sd) for z, sd in zip(z_m, curve(z_m), strict=True)])
        cv2.polylines(picture, [points], False, color, 2, cv2.LINE_AA)
        _legend(picture, line, name, color)
    for z, sd in zip(DISTANCES_M, measured_mm, strict=True):
        cv2.circle(picture, _place(z, sd), 5, (30, 30, 210), -1, cv2.LINE_AA)
    _legend(picture, len(curves), "simulator, default noise, one frame", (30, 30, 210))
    return picture


def _legend(picture: UInt8Array, line: int, name: str, color: Color) -> None:
    y = 95 + 32 * line
    cv2.line(picture, (140, y - 5), (180, y - 5), color, 3, cv2.LINE_AA)
    _write(picture, name, (195, y))


def _draw_axes(picture: UInt8Array) -> None:
    left, top, right, bottom = PLOT_BOX
    for z_m in np.arange(1.0, 4.01, 0.5):
        x, _ = _place(z_m, 0.0)
        cv2.line(picture, (x, top), (x, bottom), (230, 230, 230), 1)
        _write(picture, f"{z_m:.1f}", (x - 14, bottom + 28))
    for sd_mm in range(0, 36, 5):
        _, y = _place(1.0, sd_mm)
        cv2.line(picture, (left, y), (right, y), (230, 230, 230), 1)
        _write(picture, f"{sd_mm:2d}", (left - 38, y + 6))
    cv2.rectangle(picture, (left, top), (right, bottom), (90, 90, 90), 1)
    _write(picture, "distance of the plane, m", (460, bottom + 62))
    _write(picture, "scatter about the fitted plane, mm (standard deviation)", (left, top - 22))


if __name__ == "__main__":
    main()
