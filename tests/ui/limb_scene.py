"""A small recording of a wall with a box before it, and a desk on which it is labelled."""

import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.recordings import create_recording

N_FRAMES, HEIGHT, WIDTH = 3, 48, 64
CAMERA = CameraCalibration(WIDTH, HEIGHT, Intrinsics(60.0, 60.0, 31.5, 23.5))
INFO = SourceInfo(depth_unit_m=0.001, calibration=RgbdCalibration(depth=CAMERA))
BOX = np.s_[10:30, 20:40]


def record_box(path):
    """Record a box at 2 m that moves a pixel to the right from frame to frame."""
    with create_recording(path, INFO) as writer:
        for index in range(N_FRAMES):
            depth = np.full((HEIGHT, WIDTH), 3000, np.uint16)
            depth[10:30, 20 + index : 40 + index] = 2000
            writer.write(SensorFrame(index, 33_000_000 * (index + 1), depth_raw=depth))
    return path
