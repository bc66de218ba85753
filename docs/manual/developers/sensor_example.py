"""A sensor that sees a flat wall: what an adapter must do, and no more."""

import numpy as np

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.sensors import DepthCamera, SensorOptions
from adibas.sensors.ports import DEFAULT_OPTIONS, READ_TIMEOUT_S

RATE_HZ = 30.0
PERIOD_NS = round(1e9 / RATE_HZ)
SIZE = (480, 640)
WALL_MM = 2000


class WallCamera(DepthCamera):
    """Gives a wall two metres away, and a grey picture of it."""

    def __init__(self, options: SensorOptions = DEFAULT_OPTIONS) -> None:
        width, height = options.color_size
        self._color = np.full((height, width, 3), 128, np.uint8)
        self._next = 0
        self._is_open = True

    @property
    def info(self) -> SourceInfo:
        """The header of the recording; a maker's calibration would stand here, too."""
        return SourceInfo(depth_unit_m=0.001, frame_rate_hz=RATE_HZ, sensor_name="Wall")

    @property
    def is_live(self) -> bool:
        """False: this wall waits. A real sensor says True, and frames that wait are lost."""
        return False

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> SensorFrame | None:  # noqa: ARG002
        """Return the next frame, exactly as the sensor gave it: counts, and 0 for no reading."""
        if not self._is_open:
            raise SensorError("The sensor is closed. Open it again.")
        depth_raw = np.full(SIZE, WALL_MM, np.uint16)
        depth_raw[:, :8] = 0  # the projector does not reach the left edge
        time_ns = self._next * PERIOD_NS
        frame = SensorFrame(self._next, time_ns, depth_raw, self._color, time_ns)
        self._next += 1
        return frame

    def close(self) -> None:
        """Give the sensor back; a second time does no harm."""
        self._is_open = False
