"""One burst of frames to markers in space: the order of the stages."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from adibas.alignment.registration import Registration, register_pixels
from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array
from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.body.people import find_people
from adibas.body.staying import Moment, shows_less
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.data.markers import Marker, RejectedBlob, pixels_uv
from adibas.data.masks import BodyMask
from adibas.data.sessions import ROTATIONS_DEG
from adibas.data.surface import BurstDisparity
from adibas.errors import MarkerError
from adibas.geometry.planes import Plane
from adibas.markers.blobs import Blob, long_radius_px
from adibas.markers.burst import BurstMarker, BurstParams, BurstTracker
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import (
    DetectionParams,
    Detections,
    find_color_markers,
    without_found,
)
from adibas.markers.disparity import DisparitySum
from adibas.markers.led import LedParams, find_led_markers
from adibas.markers.mean_picture import MeanPicture
from adibas.markers.position import PositionFinder, PositionParams
from adibas.measures.sight_plane import up_of_picture, up_without_floor
from adibas.pipeline.in_order import in_order
from adibas.pipeline.outline import body_in_color
from adibas.pipeline.posture_checks import (
    apart_from_others,
    are_gaps,
    count_people,
    refuse_beside,
)
from adibas.texts import Message, message

MarkerTarget: TypeAlias = ColorModel | LedParams
"""What to look for: learned colours, or LEDs in a dark image."""

LEAST_WIDTH_PX = 3.0
"""Of a marker: at two pixels a third of what is found may be false (docs/benchmarks.md)."""

TOO_FEW_PIXELS = message(
    "The markers are fewer than three pixels wide in the picture: some may be missed, and others "
    "false. Take larger markers, or the larger colour picture."
)

SEVERAL_PEOPLE = message(
    "Several people are seen: markers were looked for on the largest of them alone. Let the "
    "patient stand alone, and capture again."
)

N_THREADS = 2
"""Frames in work side by side: more than two hardly gain, and memory grows with them."""


@dataclass(frozen=True, slots=True)
class PostureParams:
    """Settings of all stages.

    Attributes
    ----------
    least_rise_of_mean, least_log_odds_of_mean : float
        Of a faint spot in the mean picture, where it is no noise.
    least_pixel_share : float
        A depth pixel takes part if this share of the burst's frames measured it: 0.3.
    greatest_scatter_per_m : float
        And if its readings scatter less (standard deviation of 1/z, 1/m): 0.02, ten times the
        sensor's noise; more is an outline that flickers.
    greatest_matched_share : float
        Of the body that may have the marker's colour: 0.3. More, and the model fits everything.
    margin_m : float
        The body in the colour image is closed and widened by this, so that LEDs (holes in the
        depth) and markers on the outline are inside: 10 mm.
    rotation_deg : int
        How far the picture is turned clockwise for showing: tells where up is until a floor is
        seen. 0, 90, 180 or 270; 0 for a sensor that stands upright.
    """

    detection: DetectionParams = field(default_factory=DetectionParams)
    least_rise_of_mean: float = 1.5
    least_log_odds_of_mean: float = 0.0
    burst: BurstParams = field(default_factory=BurstParams)
    position: PositionParams = field(default_factory=PositionParams)
    least_pixel_share: float = 0.3
    greatest_scatter_per_m: float = 0.02
    greatest_matched_share: float = 0.3
    margin_m: float = 0.01
    rotation_deg: int = 0

    def __post_init__(self) -> None:
        if self.rotation_deg not in ROTATIONS_DEG:
            raise ValueError(f"rotation_deg must be one of {ROTATIONS_DEG}")

    @property
    def up(self) -> FloatArray:
        """Unit vector in the depth camera's axes that points up, as far as the mounting says."""
        return up_of_picture(self.rotation_deg)


@dataclass(frozen=True, slots=True, eq=False)
class MarkerFindings:
    """Markers of a burst, and the surface that their positions were measured on.

    Attributes
    ----------
    markers : tuple of Marker
        From top to bottom.
    rejected : tuple of RejectedBlob
        What was refused in the last frame that showed somebody, on the patient and beside.
    surface : BurstDisparity
        Of the depth camera, bias corrected.
    n_people : int
        Seen in that frame.
    width_px : float
        Of the discs with the areas of all spots found, the median; NaN without any.
    put_together : (H, W) bool array or None
        The person in the depth image, where only the moment before the burst tells which surfaces
        belong together; None: the depth tells it by itself.
    """

    markers: tuple[Marker, ...]
    rejected: tuple[RejectedBlob, ...]
    surface: BurstDisparity
    n_people: int = 1
    width_px: float = math.nan
    put_together: BoolArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """The person in one frame.

    Attributes
    ----------
    depth_m : (H, W) float32 array
        Of the depth camera, bias corrected, metres; NaN where not measured.
    floor : Plane or None
        In the depth camera's axes, normal up.
    body : BodyMask
        In the depth image.
    registration : Registration
        Of `depth_m`.
    outline : (H', W') bool array
        The person in the colour image.
    """

    depth_m: Float32Array
    floor: Plane | None
    body: BodyMask
    registration: Registration
    outline: BoolArray


def analyse_burst(
    frames: Iterable[RgbdFrame],
    calibration: RgbdCalibration,
    target: MarkerTarget,
    params: PostureParams,
    before: Moment | None = None,
) -> MarkerFindings:
    """Find the markers in every frame and in their mean, and measure each in space once.

    `before`: the person a moment before the burst; whoever bends down falls apart in the depth, and
    is put together by it.

    Raises
    ------
    MarkerError
        Nobody is seen, or the colour model fits everything.
    """
    burst = _Burst(calibration, target, params)

    def work(frame: RgbdFrame) -> tuple[RgbdFrame, tuple[Sight, Detections] | None]:
        sight = _person_in_burst(frame, calibration, params, before)
        if sight is None:
            return frame, None
        detections = find_markers(frame.color_rgb, sight, calibration, target, params)
        return frame, (sight, detections)

    with in_order(work, frames, N_THREADS) as results:
        for frame, seen in results:
            burst.add(frame, seen)
    return burst.findings()


class _Burst:
    """Collects what the frames of a burst show, and measures it when all are there."""

    def __init__(
        self, calibration: RgbdCalibration, target: MarkerTarget, params: PostureParams
    ) -> None:
        self._calibration, self._target, self._params = calibration, target, params
        self._tracker = BurstTracker(params.burst)
        self._depth = DisparitySum(calibration.depth_bias, calibration.depth)
        self._mean = MeanPicture()
        self._newest: tuple[UInt8Array, Sight, Detections] | None = None

    def add(self, frame: RgbdFrame, seen: tuple[Sight, Detections] | None) -> None:
        """Add the next frame; None where nobody is seen in it."""
        self._depth.add(frame.depth_m)
        if seen is None:
            self._tracker.add(())
            return
        sight, detections = seen
        check_selective(detections, self._target, self._params)
        self._newest = frame.color_rgb, sight, detections
        self._mean.add(frame.color_rgb)
        self._tracker.add(detections.blobs)

    def findings(self) -> MarkerFindings:
        """Measure each marker once; see `analyse_burst`."""
        if self._newest is None:
            raise MarkerError(
                "Nobody is seen in the depth image. The patient stands alone, 0.8 to 4 m in front "
                "of the sensor."
            )
        params, calibration = self._params, self._calibration
        color_rgb, sight, detections = self._newest
        found = self._tracker.markers(self._markers_of_mean(sight))
        disparity = self._depth.result(params.least_pixel_share, params.greatest_scatter_per_m)
        finder = PositionFinder(disparity, calibration, params.position, pixels_uv(found))
        measured = tuple(_measured(one, finder) for one in found)
        focal_px = cameras_of(calibration)[0].intrinsics.fx
        is_gap = are_gaps(found, measured, finder)
        single, others = apart_from_others(found, measured, is_gap, focal_px)
        markers = tuple(replace(one, label=f"m{i:02d}") for i, one in enumerate(single, 1))
        n_people, beside = _look_about(
            color_rgb, sight, calibration, self._target, params, measured
        )
        refused = (*without_found(detections.rejected, found), *others, *beside)
        width_px = 2.0 * float(np.median([one.radius_px for one in found])) if found else math.nan
        body = sight.body
        apart = body.pixels if body.is_put_together else None
        return MarkerFindings(markers, refused, disparity, n_people, width_px, apart)

    def _markers_of_mean(self, sight: Sight) -> tuple[Blob, ...]:
        """Return what the mean picture shows; there is time to measure every spot of one picture.

        LEDs outshine the noise of every frame.
        """
        if isinstance(self._target, LedParams):
            return ()
        params, detection = self._params, self._params.detection
        faint = replace(
            detection.faint,
            least_rise=params.least_rise_of_mean,
            least_log_odds=params.least_log_odds_of_mean,
        )
        params = replace(params, detection=replace(detection, faint=faint))
        mean_rgb = self._mean.result()
        return find_markers(mean_rgb, sight, self._calibration, self._target, params).blobs


def _look_about(
    color_rgb: UInt8Array,
    sight: Sight,
    calibration: RgbdCalibration,
    target: MarkerTarget,
    params: PostureParams,
    markers: tuple[Marker, ...],
) -> tuple[int, tuple[RejectedBlob, ...]]:
    """Return how many people a frame shows, and what looks like a marker and is on nobody."""
    _, depth = cameras_of(calibration)
    n_people = count_people(sight.depth_m, depth, sight.floor, sight.body)
    beside = replace(sight, outline=~sight.outline)
    seen = find_markers(color_rgb, beside, calibration, target, params)
    return n_people, refuse_beside(seen, markers, _greatest_share(target, params))


def look_for_person(
    frame: RgbdFrame,
    calibration: RgbdCalibration,
    params: PostureParams,
    before: Moment | None = None,
) -> Sight | None:
    """Return the person in one frame; None where nobody is seen; `before`: see `see_person`."""
    depth_m = calibration.corrected_depth(frame.depth_m)
    floor = floor_below(depth_m, calibration, params)
    return see_person(depth_m, floor, calibration, params, before)


def _person_in_burst(
    frame: RgbdFrame, calibration: RgbdCalibration, params: PostureParams, before: Moment | None
) -> Sight | None:
    """Return the person, put together by a moment before where less is seen by itself."""
    sight = look_for_person(frame, calibration, params)
    if before is None or not shows_less(None if sight is None else sight.body.pixels, before):
        return sight
    return look_for_person(frame, calibration, params, before)


def floor_below(
    depth_m: Float32Array, calibration: RgbdCalibration, params: PostureParams
) -> Plane | None:
    """Return the floor that the calibration knows, else the one in an (H, W) depth image."""
    if calibration.floor is not None or calibration.depth is None:
        return calibration.floor
    return find_floor(
        depth_m, calibration.depth, up_without_floor(calibration, params.rotation_deg)
    )


def see_person(
    depth_m: Float32Array,
    floor: Plane | None,
    calibration: RgbdCalibration,
    params: PostureParams,
    before: Moment | None = None,
) -> Sight | None:
    """Return where the person is; None where nobody is seen.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Of the depth camera, bias corrected, metres; NaN where not measured.
    floor : Plane or None
        In the depth camera's axes; None where no floor is seen.
    before : Moment or None
        The person a moment ago, who stays whole: who bends down falls apart, and is not tall.
    """
    color, depth = cameras_of(calibration)
    body = find_body(depth_m, depth, floor)
    if before is not None:
        body = _who_stays(find_people(depth_m, depth, floor, before=before), before) or body
    if body is None:
        return None
    registration = register_pixels(depth_m, calibration)
    outline = body_in_color(body.pixels, registration, color, params.margin_m)
    return Sight(depth_m, floor, body, registration, outline)


def _who_stays(people: Sequence[BodyMask], before: Moment) -> BodyMask | None:
    """Return who was there before; None where nobody is."""
    (pixels,) = before.people
    shared_px = [int(np.count_nonzero(one.pixels & pixels)) for one in people]
    return people[int(np.argmax(shared_px))] if any(shared_px) else None


def find_markers(
    color_rgb: UInt8Array,
    sight: Sight,
    calibration: RgbdCalibration,
    target: MarkerTarget,
    params: PostureParams,
) -> Detections:
    """Return the blobs on the person in the (H', W', 3) colour image of the same moment."""
    focal_px = cameras_of(calibration)[0].intrinsics.fx
    registered_m = sight.registration.depth_m
    if isinstance(target, LedParams):
        return find_led_markers(color_rgb, sight.outline, registered_m, focal_px, target)
    return find_color_markers(
        color_rgb, sight.outline, registered_m, focal_px, target, params.detection
    )


def check_selective(detections: Detections, target: MarkerTarget, params: PostureParams) -> None:
    """Raise MarkerError where what to look for fits most of the body."""
    if detections.matched_share <= _greatest_share(target, params):
        return
    if isinstance(target, LedParams):
        raise MarkerError(
            "The picture is too bright for LED markers. Put the infrared filter on, or darken "
            "the room."
        )
    raise MarkerError(
        "The learned colour fits too much of the body. Learn it again with a lower "
        "sensitivity, or take markers of a colour that neither skin nor clothes have."
    )


def _greatest_share(target: MarkerTarget, params: PostureParams) -> float:
    if isinstance(target, LedParams):
        return target.greatest_share
    return params.greatest_matched_share


def cameras_of(calibration: RgbdCalibration) -> tuple[CameraCalibration, CameraCalibration]:
    """Return the colour and the depth camera."""
    if calibration.color is None or calibration.depth is None:
        raise ValueError("posture needs both cameras")
    return calibration.color, calibration.depth


def _measured(found: BurstMarker, finder: PositionFinder) -> Marker:
    radius_px = long_radius_px(found.radius_px, found.axis_ratio)
    return finder.placed(Marker("m", found.u, found.v, radius_px, found.covariance_px2))


def doubts_about(found: MarkerFindings) -> tuple[Message, ...]:
    """Return what the reader should know of the markers that were found."""
    if not found.markers:
        return ()
    is_small, is_crowd = found.width_px < LEAST_WIDTH_PX, found.n_people > 1
    return (TOO_FEW_PIXELS,) * is_small + (SEVERAL_PEOPLE,) * is_crowd
