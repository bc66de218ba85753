"""One standing view of a patient as a surface: the mean depth of a burst, and the person in it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array
from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.body.rays import viewing_rays
from adibas.calibration.files import check_fits
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.surface import BurstDisparity
from adibas.errors import BodyError, CalibrationError, RecordingError
from adibas.geometry.planes import Plane
from adibas.markers.disparity import DisparitySum
from adibas.measures.sight_plane import up_without_floor
from adibas.pipeline.session import calibration_of, wanted_frames
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.decoding import decode_color
from adibas.recordings.ports import RecordingReader

LEAST_SHARE, GREATEST_SD_PER_M = 0.3, 0.02
"""Of `adibas.pipeline.posture.PostureParams`."""


@dataclass(frozen=True, slots=True)
class ViewRequest:
    """One view.

    Attributes
    ----------
    view : str
        One of `VIEWS`.
    recording : Path
    calibration : Path or None
        In place of the recording's own.
    frames : (first, one past the last or None)
    rotation_deg : int
        How far the picture is turned clockwise to be upright: where the floor is looked for, if
        neither it nor gravity is known.
    """

    view: str
    recording: Path
    calibration: Path | None = None
    frames: tuple[int, int | None] = (0, None)
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class BodyView:
    """The person in one view.

    Attributes
    ----------
    view : str
    surface : BurstDisparity
        Of the depth camera, bias corrected.
    body : (H, W) bool array
        The person's measured pixels.
    floor : Plane
        In the depth camera's axes, normal up.
    calibration : RgbdCalibration
    n_frames : int
    is_cut_above : bool
        The picture ends before the person does.
    notice : str or None
        What was lost of the recording.
    picture_rgb : (H', W', 3) uint8 array or None
        Of the colour camera, from the middle of the burst; None where there is none.
    """

    view: str
    surface: BurstDisparity
    body: BoolArray
    floor: Plane
    calibration: RgbdCalibration
    n_frames: int
    is_cut_above: bool
    notice: str | None
    picture_rgb: UInt8Array | None = None

    @property
    def camera(self) -> CameraCalibration:
        """The depth camera."""
        if self.calibration.depth is None:
            raise ValueError("a view has a depth camera")
        return self.calibration.depth

    def points_m(self) -> FloatArray:
        """Return the (N, 3) points of the person, depth camera's axes."""
        depth_m = 1.0 / self.surface.mean_per_m[self.body].astype(float)
        return np.asarray(viewing_rays(self.camera)[self.body] * depth_m[:, None], float)


def see_view(request: ViewRequest, progress: Progress) -> BodyView:
    """Read a burst and find the person.

    Raises
    ------
    RecordingError
        It is missing, broken, or has no such frames, or no depth.
    CalibrationError
        There is none of the depth camera, or one for another resolution.
    BodyError
        Nobody is seen, or no floor.
    """
    with open_recording(request.recording) as recording:
        wanted = wanted_frames(recording, request.frames, request.recording.name)
        calibration = calibration_of(recording, request.calibration)
        camera = depth_camera_of(calibration)
        total = DisparitySum(calibration.depth_bias, camera)
        n_frames = 0
        for done, index in enumerate(wanted, 1):
            raw = recording.read(index).depth_raw
            if raw is not None:
                check_fits(calibration, None, raw.shape)
                total.add(depth_in_metres(raw, recording.info.depth_unit_m))
                n_frames += 1
            progress(done, len(wanted))
        notice = recording.notice
        if not n_frames:
            raise no_depth(request.recording.name)
        picture_rgb = picture_of(recording, wanted[len(wanted) // 2], calibration)
    view = person_in(
        request.view,
        total.result(LEAST_SHARE, GREATEST_SD_PER_M),
        calibration,
        notice,
        name=request.recording.name,
        rotation_deg=request.rotation_deg,
    )
    return replace(view, picture_rgb=picture_rgb)


def person_in(
    view: str,
    surface: BurstDisparity,
    calibration: RgbdCalibration,
    notice: str | None = None,
    name: str = "",
    rotation_deg: int = 0,
) -> BodyView:
    """Find the person in the mean depth of a burst.

    `rotation_deg` is how far the picture is turned clockwise to be upright.

    Raises
    ------
    BodyError
        Nobody is seen, or no floor.
    """
    camera = calibration.depth
    if camera is None:
        raise ValueError("a surface takes the calibration of a depth camera")
    with np.errstate(divide="ignore"):
        depth_m = np.asarray(1.0 / surface.mean_per_m, np.float32)
    floor = floor_in(depth_m, calibration, name, rotation_deg)
    mask = find_body(depth_m, camera, floor)
    if mask is None:
        raise nobody(name)
    body = mask.pixels & np.isfinite(depth_m)
    return BodyView(
        view,
        surface,
        body,
        floor,
        calibration,
        surface.n_frames,
        is_cut_above=touches_top(body, floor),
        notice=notice,
    )


def depth_camera_of(calibration: RgbdCalibration) -> CameraCalibration:
    """Return the depth camera.

    Raises
    ------
    CalibrationError
        It is not calibrated.
    """
    if calibration.depth is None:
        raise CalibrationError(
            "The calibration lacks the depth camera. Give one of both cameras with "
            "--calibration FILE."
        )
    return calibration.depth


def floor_in(
    depth_m: Float32Array, calibration: RgbdCalibration, name: str, rotation_deg: int = 0
) -> Plane:
    """Return the floor that the calibration knows, else the one in an (H, W) depth image.

    Raises
    ------
    BodyError
        There is none in the recording `name`.
    """
    if calibration.floor is not None:
        return calibration.floor
    up = up_without_floor(calibration, rotation_deg)
    floor = find_floor(depth_m, depth_camera_of(calibration), up)
    if floor is None:
        raise BodyError(
            "No floor is seen in {file}, and heights are measured from it. Turn the sensor down, "
            "or give a calibration that knows the floor.",
            file=name,
        )
    return floor


def no_depth(name: str) -> RecordingError:
    """Return what is told of a recording without depth."""
    return RecordingError(
        "{file} holds no depth, and a surface takes depth. Record both streams.", file=name
    )


def nobody(name: str) -> BodyError:
    """Return what is told of a recording without a person."""
    return BodyError(
        "Nobody is seen in {file}. The patient stands alone, 0.8 to 4 m in front of the sensor.",
        file=name,
    )


def picture_of(
    recording: RecordingReader, index: int, calibration: RgbdCalibration
) -> UInt8Array | None:
    """Return the colour picture of a frame, where the calibration tells where it belongs."""
    frame = recording.read(index)
    if frame.color is None or calibration.color is None:
        return None
    picture_rgb = decode_color(frame.color, frame.sequence)
    check_fits(calibration, picture_rgb.shape[:2], None)
    return picture_rgb


def touches_top(body: BoolArray, floor: Plane) -> bool:
    """Say whether the person goes on beyond the side of the picture where up is."""
    up_u, up_v = floor.normal[:2]
    if abs(up_v) >= abs(up_u):
        return bool((body[:2] if up_v < 0 else body[-2:]).any())
    return bool((body[:, :2] if up_u < 0 else body[:, -2:]).any())
