"""The frames of a recording as mapping takes them: in order, with depth and colour."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.calibration.files import check_fits
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, depth_in_metres
from adibas.errors import CalibrationError
from adibas.geometry.planes import Plane
from adibas.measures.sight_plane import up_without_floor
from adibas.recordings.decoding import decode_color
from adibas.recordings.ports import RecordingReader
from adibas.texts import Message, message

NO_DEPTH = message("The frame has no depth, and a map takes depth and colour.")
NO_COLOR = message("The frame has no colour, and a map takes depth and colour.")
BACKWARD = message("The frame is not after the one before.")
NOBODY = message("Nobody is seen in the frame.")
REASONS = (NO_DEPTH, NO_COLOR, BACKWARD, NOBODY)
"""Why a frame is left out before anything is aligned."""


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """One frame.

    Attributes
    ----------
    index : int
        In the recording.
    time_ns : int
    depth_m : (H, W) float32 array
        Bias corrected; NaN where not measured, and beside the person where that is mapped alone.
    color_rgb : (H', W', 3) uint8 array
    """

    index: int
    time_ns: int
    depth_m: Float32Array
    color_rgb: UInt8Array


class MapFrames:
    """The frames that are wanted of a recording.

    Parameters
    ----------
    is_body : bool
        The person alone takes part.

    Raises
    ------
    CalibrationError
        It lacks a camera.
    """

    def __init__(
        self,
        recording: RecordingReader,
        wanted: range,
        calibration: RgbdCalibration,
        *,
        is_body: bool = False,
    ) -> None:
        if calibration.color is None or calibration.depth is None:
            raise CalibrationError(
                "A map takes the calibration of both cameras. Give one with --calibration FILE."
            )
        self._recording = recording
        self.wanted = wanted
        self.calibration = calibration
        self.depth_camera: CameraCalibration = calibration.depth
        self.is_body = is_body
        self.floor: Plane | None = None
        self.left_out: dict[int, Message] = {}

    def __len__(self) -> int:
        """Return how many there are, with those that are left out."""
        return len(self.wanted)

    def usable(self, first: int, last_ns: int | None) -> Iterator[tuple[int, SensorFrame]]:
        """Yield those with depth and colour whose time goes on, with their index, from one on."""
        for index in self.wanted:
            if index < first:
                continue
            frame = self._recording.read(index)
            # A covered sensor gives an image without a single reading.
            if frame.depth_raw is None or not frame.depth_raw.any():
                self.left_out[index] = NO_DEPTH
            elif frame.color is None:
                self.left_out[index] = NO_COLOR
            elif last_ns is not None and frame.timestamp_ns <= last_ns:
                self.left_out[index] = BACKWARD
            else:
                last_ns = frame.timestamp_ns
                yield index, frame

    def read(self, index: int) -> tuple[int, SensorFrame]:
        """Return a frame as `usable` does."""
        return index, self._recording.read(index)

    def show(self, numbered: tuple[int, SensorFrame]) -> tuple[Shown, Message | None]:
        """Decode a frame, in any thread; and say why it is left out where nobody is seen.

        Raises
        ------
        CalibrationError
            It is for another resolution.
        """
        index, frame = numbered
        if frame.depth_raw is None or frame.color is None:
            raise ValueError("a frame that is not usable")
        color_rgb = decode_color(frame.color, frame.sequence)
        depth_m = depth_in_metres(frame.depth_raw, self._recording.info.depth_unit_m)
        check_fits(self.calibration, color_rgb.shape[:2], depth_m.shape)
        depth_m = np.ascontiguousarray(self.calibration.corrected_depth(depth_m), np.float32)
        lack = None
        if self.is_body:
            person = self._person(depth_m)
            lack = NOBODY if person is None else None
            depth_m = np.where(False if person is None else person, depth_m, np.float32(np.nan))
        return Shown(index, frame.timestamp_ns, depth_m, color_rgb), lack

    def look_for_floor(self) -> None:
        """Find the floor in the first frame, where a person is to be found and none is known.

        Raises
        ------
        CalibrationError
            It is for another resolution.
        """
        calibration = self.calibration
        self.floor = calibration.floor
        if self.floor is not None or not self.is_body:
            return
        raw = self._recording.read(self.wanted[0]).depth_raw
        if raw is None:
            return
        depth_m = depth_in_metres(raw, self._recording.info.depth_unit_m)
        check_fits(calibration, None, depth_m.shape)
        depth_m = np.ascontiguousarray(calibration.corrected_depth(depth_m), np.float32)
        self.floor = find_floor(depth_m, self.depth_camera, up_without_floor(calibration))

    @property
    def level(self) -> Plane:
        """The floor; where none is known, a level plane through the camera."""
        return self.floor or Plane(up_without_floor(self.calibration), 0.0)

    def _person(self, depth_m: Float32Array) -> BoolArray | None:
        mask = find_body(depth_m, self.depth_camera, self.floor)
        return None if mask is None else mask.pixels
