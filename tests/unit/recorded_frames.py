"""Frames and a calibration for the tests of the recordings, and what "the same" means for them."""

import cv2
import numpy as np

from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.recordings.decoding import decode_color

FRAME_NS = 33_333_333
START_NS = 1_700_000_000_123_456_789
CALIBRATION = RgbdCalibration(
    color=CameraCalibration(64, 48, Intrinsics(61.5, 62.5, 31.25, 23.75), (0.1, -0.2, 1e-3, 0, 0)),
    depth=CameraCalibration(32, 24, Intrinsics(29.1, 29.2, 15.5, 11.5)),
    color_from_depth=RigidTransform(np.eye(3), np.array([0.025, -0.001, 0.0])),
    depth_unit_m=0.0001,
    depth_bias=DepthBias(0.001, 1.01, 0.002),
    rms_px=0.21,
    sensor_serial="A00365",
)
INFO = SourceInfo(
    depth_unit_m=0.0001,
    frame_rate_hz=29.97,
    sensor_name="PS1080",
    sensor_serial="A00365",
    is_depth_registered=True,
    calibration=CALIBRATION,
)


def depth_image(rng, shape=(24, 32)):
    depth = rng.integers(0, 65536, shape, dtype=np.uint16)
    depth[rng.random(shape) < 0.3] = 0
    depth[0, :3] = (65535, 0, 65535)
    return depth


def color_image(rng, encoding, shape=(48, 64)):
    color = cv2.GaussianBlur(rng.integers(0, 256, (*shape, 3), dtype=np.uint8), (0, 0), 2)
    if encoding == "array":
        return color
    suffix = {"jpeg": ".jpg", "png": ".png"}[encoding]
    return EncodedImage(encoding, cv2.imencode(suffix, color)[1].tobytes())


def make_frames(n_frames=5, encoding="jpeg", *, depth=True, color=True, infrared=False, seed=1):
    """Frames with three missing numbers after the second, and colour 4 ms after the depth."""
    rng = np.random.default_rng(seed)
    frames = []
    for i in range(n_frames):
        time_ns = START_NS + i * FRAME_NS
        frames.append(
            SensorFrame(
                sequence=100 + i + (3 if i > 1 else 0),
                timestamp_ns=time_ns,
                depth_raw=depth_image(rng) if depth else None,
                color=color_image(rng, encoding) if color else None,
                color_timestamp_ns=time_ns + 4_000_001 * depth if color else None,
                infrared_raw=depth_image(rng) if infrared else None,
            )
        )
    return frames


def write_frames(writer, frames):
    with writer:
        for frame in frames:
            writer.write(frame)


def assert_same_frame(got, want):
    assert (got.sequence, got.timestamp_ns) == (want.sequence, want.timestamp_ns)
    assert got.color_timestamp_ns == want.color_timestamp_ns
    for name in ("depth_raw", "infrared_raw"):
        ours, theirs = getattr(got, name), getattr(want, name)
        assert (ours is None) == (theirs is None)
        if ours is not None:
            np.testing.assert_array_equal(ours, theirs)
    assert (got.color is None) == (want.color is None)
    if got.color is not None:
        pixels = decode_color(got.color, 0), decode_color(want.color, 0)
        np.testing.assert_array_equal(*pixels)


def assert_same_info(got, want):
    assert got.depth_unit_m == want.depth_unit_m
    assert got.frame_rate_hz == want.frame_rate_hz
    assert (got.sensor_name, got.sensor_serial) == (want.sensor_name, want.sensor_serial)
    assert got.is_depth_registered == want.is_depth_registered
    assert (got.calibration is None) == (want.calibration is None)
    if got.calibration is not None:
        assert got.calibration.color == want.calibration.color
        assert got.calibration.depth == want.calibration.depth
        ours, theirs = got.calibration.color_from_depth, want.calibration.color_from_depth
        np.testing.assert_array_equal(ours.translation_m, theirs.translation_m)
        assert got.calibration.depth_bias == want.calibration.depth_bias
