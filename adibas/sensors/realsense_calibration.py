"""A RealSense's factory calibration in our words."""

from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.errors import SensorError
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.sensors.ports import StreamName
from adibas.sensors.realsense_streams import Profile

GRID_STEPS = 25
LARGEST_MISFIT_PX = 0.1
"""Of the lens model that is fitted; a fish-eye lens does not come near."""


def factory_calibration(
    library: ModuleType, profiles: Mapping[StreamName, Profile], depth_unit_m: float, serial: str
) -> RgbdCalibration:
    """Return what the device says of its cameras; `rms_px` is None, for it does not say how well.

    Raises
    ------
    SensorError
        A lens is of a model that cannot be expressed, as a fish-eye is.
    """
    depth = profiles["depth"].handle
    color = profiles["color"].handle if "color" in profiles else None
    return RgbdCalibration(
        color=None if color is None else _camera(library, color),
        depth=_camera(library, depth),
        color_from_depth=IDENTITY if color is None else rigid(depth.get_extrinsics_to(color)),
        depth_unit_m=depth_unit_m,
        sensor_serial=serial,
    )


def rigid(extrinsics: Any) -> RigidTransform:
    """Turn the library's extrinsics (rotation column by column, single precision) into ours."""
    rotation = np.array(extrinsics.rotation, float).reshape(3, 3).T
    left, _, right = np.linalg.svd(rotation)
    return RigidTransform(left @ right, np.array(extrinsics.translation, float))


def _camera(library: ModuleType, handle: Any) -> CameraCalibration:
    lens = handle.as_video_stream_profile().get_intrinsics()
    pinhole = Intrinsics(lens.fx, lens.fy, lens.ppx, lens.ppy)
    return CameraCalibration(lens.width, lens.height, pinhole, distortion_of(library, lens))


def distortion_of(library: ModuleType, lens: Any) -> tuple[float, ...]:
    """Return OpenCV's k1 k2 p1 p2 k3 of a lens, or nothing where it does not distort.

    Brown-Conrady is OpenCV's model. The library's variants of it are fitted: the model is linear
    in its coefficients, and the library itself projects a grid of points.

    Raises
    ------
    SensorError
        The lens is more than 0.1 px from any lens of OpenCV's model.
    """
    if lens.model == library.distortion.none or not any(lens.coeffs):
        return ()
    if lens.model == library.distortion.brown_conrady:
        return tuple(float(coefficient) for coefficient in lens.coeffs)
    u, v = np.meshgrid(
        np.linspace(0, lens.width - 1, GRID_STEPS), np.linspace(0, lens.height - 1, GRID_STEPS)
    )
    x, y = ((u - lens.ppx) / lens.fx).ravel(), ((v - lens.ppy) / lens.fy).ravel()
    pixels = np.array(
        [
            library.rs2_project_point_to_pixel(lens, [float(a), float(b), 1.0])
            for a, b in zip(x, y, strict=True)
        ]
    )
    focal = np.array([lens.fx, lens.fy])
    shifts = (pixels - [lens.ppx, lens.ppy]) / focal - np.stack([x, y], axis=1)
    r2 = x * x + y * y
    columns_x = (x * r2, x * r2**2, 2 * x * y, r2 + 2 * x * x, x * r2**3)
    columns_y = (y * r2, y * r2**2, r2 + 2 * y * y, 2 * x * y, y * r2**3)
    system = np.concatenate([np.stack(columns_x, axis=1), np.stack(columns_y, axis=1)])
    coefficients = np.linalg.lstsq(system, shifts.T.ravel(), rcond=None)[0]
    misfit_px = np.abs(system @ coefficients - shifts.T.ravel()).max() * max(lens.fx, lens.fy)
    if not misfit_px < LARGEST_MISFIT_PX:
        raise SensorError(
            "A lens of this RealSense is of the model {model}, which is not supported. Use a "
            "sensor of the D400 family.",
            model=lens.model.name,
        )
    return tuple(float(coefficient) for coefficient in coefficients)
