"""The simulated sensor before anybody calibrated it.

It is the sensor of the clinic's scenes of that seed, with a depth error that depends on the place
in the image as well. It hands out the maker's calibration, the same for all sensors of its kind:
no lens distortion, no turn between the cameras, no correction of the depth. The truth of every
frame carries the exact one.
"""

from dataclasses import replace

import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.device import COLOR_SIZES, DEPTH_UNIT_M, Device, DeviceSpread, draw_device
from adibas.simulation.frame_times import FRAME_RATE_HZ
from adibas.simulation.studio import DepthView
from adibas.simulation.truth import BoardTruth, FrameTruth

BIAS_OF_BORDER_M = 0.004
FACTORY_FOCAL_PX = (580.0, 1055.0)
"""Of depth at 640x480 and colour at 1280x1024: the middle of what devices have."""
FACTORY_BASELINE_M = 0.025


def uncalibrated_device(seed: int, color_size: tuple[int, int]) -> Device:
    """Return sensor number `seed`, with an image term in its depth error."""
    return draw_device(seed, color_size, DeviceSpread(bias_of_border_m=BIAS_OF_BORDER_M))


def factory_info(device: Device) -> SourceInfo:
    """Return the header with the maker's calibration, which is slightly wrong."""
    return SourceInfo(
        depth_unit_m=DEPTH_UNIT_M,
        frame_rate_hz=FRAME_RATE_HZ,
        sensor_name="ADiBAS simulator",
        sensor_serial=device.calibration.sensor_serial,
        calibration=factory_calibration(device),
    )


def factory_calibration(device: Device) -> RgbdCalibration:
    """Return what the maker says of all sensors of this kind."""
    depth_px, color_px = FACTORY_FOCAL_PX
    color = device.color
    if (color.height, color.width) != COLOR_SIZES[0]:
        color_px /= 2.0
    return RgbdCalibration(
        color=_nominal(color, color_px),
        depth=_nominal(device.depth, depth_px),
        color_from_depth=RigidTransform(np.eye(3), np.array([-FACTORY_BASELINE_M, 0.0, 0.0])),
        depth_unit_m=DEPTH_UNIT_M,
        sensor_serial=device.calibration.sensor_serial,
    )


def true_calibration(device: Device, depth_from_world: RigidTransform) -> RgbdCalibration:
    """Return the exact calibration, with the floor y = 0 of the world."""
    up = -depth_from_world.rotation[:, 1]
    floor = Plane(up, -float(up @ depth_from_world.translation_m))
    return replace(device.calibration, gravity=-up, floor=floor)


def truth_without_person(
    view: DepthView,
    calibration: RgbdCalibration,
    *,
    board: BoardTruth | None = None,
    wall: Plane | None = None,
) -> FrameTruth:
    """Return the truth of a frame that nobody is in whose joints matter."""
    nobody = np.full((15, 3), np.nan)
    return FrameTruth(
        joints_m=nobody,
        joints_color_m=nobody.copy(),
        markers=(),
        labels=view.labels,
        depth_m=1.0 / view.inverse_depth,
        calibration=calibration,
        board=board,
        wall=wall,
    )


def _nominal(camera: CameraCalibration, focal_px: float) -> CameraCalibration:
    middle = Intrinsics(focal_px, focal_px, 0.5 * (camera.width - 1), 0.5 * (camera.height - 1))
    return CameraCalibration(camera.width, camera.height, middle)
