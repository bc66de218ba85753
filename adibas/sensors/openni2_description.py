"""What holds for every frame of an OpenNI2 source, as far as the device tells it."""

from collections.abc import Mapping

from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.errors import SensorError
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.sensors.openni2_modes import DEPTH_UNITS_M
from adibas.sensors.openni2_streams import OpenStream
from adibas.sensors.ports import SensorDescription, StreamName

PRIMESENSE_VENDORS = ("primesense", "asus")
PRIMESENSE_COLOR_FROM_DEPTH = RigidTransform(
    IDENTITY.rotation, IDENTITY.translation_m - [0.025, 0, 0]
)
"""The colour camera sits 25 mm to the right of the depth camera (ROS openni2_launch, nominal)."""


def describe_source(
    sensor: SensorDescription, streams: Mapping[StreamName, OpenStream], *, is_registered: bool
) -> SourceInfo:
    """Return the header of a source; its calibration is nominal (`rms_px` is None).

    Raises
    ------
    SensorError
        The depth is in a format that has no unit of length.
    """
    depth_format = streams["depth"].mode.pixel_format
    unit_m = DEPTH_UNITS_M.get(depth_format)
    if unit_m is None:
        raise SensorError(
            "The depth is in the format {format}, which cannot be turned into metres. Record in "
            "units of 1 mm or 0.1 mm.",
            format=depth_format,
        )
    return SourceInfo(
        depth_unit_m=unit_m,
        frame_rate_hz=min(stream.mode.frame_rate_hz for stream in streams.values()),
        sensor_name=sensor.name,
        sensor_serial=sensor.serial,
        is_depth_registered=is_registered,
        calibration=_nominal_calibration(sensor, streams, unit_m, is_registered=is_registered),
    )


def _nominal_calibration(
    sensor: SensorDescription,
    streams: Mapping[StreamName, OpenStream],
    unit_m: float,
    *,
    is_registered: bool,
) -> RgbdCalibration | None:
    color = streams["color"].nominal_camera() if "color" in streams else None
    depth = streams["depth"].nominal_camera()
    if color is None and depth is None:
        return None
    is_primesense = sensor.vendor.lower().startswith(PRIMESENSE_VENDORS)
    is_offset = is_primesense and not is_registered and color is not None
    return RgbdCalibration(
        color=color,
        depth=depth,
        color_from_depth=PRIMESENSE_COLOR_FROM_DEPTH if is_offset else IDENTITY,
        depth_unit_m=unit_m,
        sensor_serial=sensor.serial,
    )
