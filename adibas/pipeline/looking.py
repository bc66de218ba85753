"""What is seen in one live frame: the stages in the order of a burst, for the screen."""

from dataclasses import dataclass, field, replace

from adibas.alignment.registration import register_pixels
from adibas.arrays import Float32Array, FloatArray, UInt8Array
from adibas.body.absence import why_nobody
from adibas.body.staying import Moment
from adibas.calibration.files import check_fits
from adibas.calibration.finder import as_gray, search_board
from adibas.clock import NS_PER_S
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo, depth_in_metres
from adibas.errors import CalibrationError, MarkerError, RecordingError
from adibas.geometry.planes import Plane
from adibas.markers.detection import Detections
from adibas.markers.led import LedParams
from adibas.pipeline import hints
from adibas.pipeline.acquisition import Arrival
from adibas.pipeline.live_frames import LiveFrame, Naming
from adibas.pipeline.live_joints import LiveNames, NamedNow
from adibas.pipeline.plumb import plumb_line
from adibas.pipeline.posture import (
    MarkerTarget,
    PostureParams,
    Sight,
    check_selective,
    find_markers,
    floor_below,
    see_person,
)
from adibas.pipeline.put_together import PutTogether
from adibas.recordings.decoding import decode_color
from adibas.texts import Message

BOARD_IMAGE = "live"
"""What the image of a board is called while it is not kept."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What to look for in live frames.

    Attributes
    ----------
    target : MarkerTarget or None
        None before it is learned.
    calibration : RgbdCalibration or None
        Takes the place of the source's own.
    params : PostureParams
        As in the measuring of a burst.
    board : Board or None
        To be found in place of a person; depth is given as measured then.
    naming : Naming or None
        After what markers are named; None: they have no names.
    """

    target: MarkerTarget | None = None
    calibration: RgbdCalibration | None = None
    params: PostureParams = field(default_factory=PostureParams)
    board: Board | None = None
    naming: Naming | None = None

    def calibration_of(self, info: SourceInfo) -> RgbdCalibration | None:
        """Return the calibration in use for a source."""
        return self.calibration or info.calibration


class Looker:
    """Looks at one live frame after the other; for one thread at a time."""

    def __init__(self) -> None:
        self._watch: _Watch | None = None

    @property
    def person(self) -> Moment | None:
        """Who is in the newest frame that was looked at; None where nobody is. From any thread."""
        watch = self._watch
        return None if watch is None else watch.person

    def look(self, arrival: Arrival, look: Look) -> LiveFrame:
        """Return what is seen in a frame; what cannot be seen is left out and told as a hint."""
        plain = _plain(arrival, look)
        color_rgb, depth_m = plain.color_rgb, plain.depth_m
        if look.board is not None and color_rgb is not None:
            return replace(plain, board=search_board(as_gray(color_rgb), look.board, BOARD_IMAGE))
        if color_rgb is None or depth_m is None:
            return plain
        calibration = look.calibration_of(arrival.info)
        if calibration is None or not _fits(calibration, color_rgb, depth_m):
            return replace(plain, hints=(hints.NO_CALIBRATION,))
        if self._watch is None or not self._watch.goes_on(look, calibration, plain.timestamp_ns):
            self._watch = _Watch(look, calibration)
        return self._watch.seen(plain, color_rgb, calibration.corrected_depth(depth_m))


def _plain(arrival: Arrival, look: Look) -> LiveFrame:
    """Return a frame of which nothing is known but what the sensor tells."""
    frame = arrival.frame
    color_rgb = _color(frame)
    depth_m = None
    if frame.depth_raw is not None:
        depth_m = depth_in_metres(frame.depth_raw, arrival.info.depth_unit_m)
    return LiveFrame(
        sequence=frame.sequence,
        timestamp_ns=frame.timestamp_ns,
        color_rgb=color_rgb,
        depth_m=depth_m,
        hints=() if color_rgb is not None else (hints.NO_COLOR,),
        frame_rate_hz=arrival.frame_rate_hz,
        n_dropped=arrival.n_dropped,
        rotation_deg=look.params.rotation_deg,
    )


class _Watch:
    """Looks for the same things, by one calibration, in frames that follow one another.

    Who bends down is put together by the frame before, and names of markers are carried on.
    """

    def __init__(self, look: Look, calibration: RgbdCalibration) -> None:
        self._look, self._calibration = look, calibration
        self._before_ns: int | None = None
        self._together = PutTogether()
        self._names: LiveNames | None = None
        if look.naming is not None:
            self._names = LiveNames(calibration, look.naming, look.params.rotation_deg)

    @property
    def person(self) -> Moment | None:
        """Who is in the newest frame; None where nobody is seen there."""
        return self._together.newest

    def goes_on(self, look: Look, calibration: RgbdCalibration, timestamp_ns: int) -> bool:
        """Say whether a frame follows; where the clock was set back the sensor was opened anew."""
        is_same = look is self._look and calibration is self._calibration
        return is_same and (self._before_ns is None or timestamp_ns > self._before_ns)

    def seen(self, plain: LiveFrame, color_rgb: UInt8Array, depth_m: Float32Array) -> LiveFrame:
        """Return what is seen; the depth is bias corrected."""
        self._before_ns = plain.timestamp_ns
        look, calibration = self._look, self._calibration
        floor = floor_below(depth_m, calibration, look.params)
        sight = self._sight(depth_m, floor, plain.timestamp_ns)
        registration = (
            register_pixels(depth_m, calibration) if sight is None else sight.registration
        )
        detections, told = _markers(color_rgb, sight, calibration, look)
        named = self._named(detections, sight, plain.timestamp_ns)
        up = _up(floor, calibration)
        stance = _stance(depth_m, sight, floor, calibration, look.params.up if up is None else up)
        plumb = None
        if up is not None and calibration.color is not None:
            plumb = plumb_line(calibration.color_from_depth.rotation @ up, calibration.color)
        return replace(
            plain,
            depth_m=depth_m,
            depth_in_color_m=registration.depth_m,
            outline=None if sight is None else sight.outline,
            detections=detections,
            joints=named.joints,
            plumb=plumb,
            hints=stance + told + named.doubts,
        )

    def _sight(self, depth_m: Float32Array, floor: Plane | None, timestamp_ns: int) -> Sight | None:
        """Return where the person is."""
        calibration, params = self._calibration, self._look.params
        return self._together.person(
            lambda moment: see_person(depth_m, floor, calibration, params, moment), timestamp_ns
        )

    def _named(self, found: Detections | None, sight: Sight | None, timestamp_ns: int) -> NamedNow:
        if found is None or sight is None or self._names is None:
            return NamedNow()
        return self._names.among(found.blobs, sight, timestamp_ns / NS_PER_S)


def _stance(
    depth_m: Float32Array,
    sight: Sight | None,
    floor: Plane | None,
    calibration: RgbdCalibration,
    up: FloatArray,
) -> tuple[Message, ...]:
    if sight is not None:
        return hints.stance_hints(depth_m, sight.body.pixels, up)
    if calibration.depth is None:
        return (hints.NOBODY,)
    return (hints.absence_hint(why_nobody(depth_m, calibration.depth, floor)),)


def _markers(
    color_rgb: UInt8Array, sight: Sight | None, calibration: RgbdCalibration, look: Look
) -> tuple[Detections | None, tuple[Message, ...]]:
    if sight is None or look.target is None:
        return None, ()
    found = find_markers(color_rgb, sight, calibration, look.target, look.params)
    try:
        check_selective(found, look.target, look.params)
    except MarkerError:
        is_led = isinstance(look.target, LedParams)
        return None, (hints.TOO_BRIGHT if is_led else hints.COLOR_FITS_ALL,)
    return found, ()


def _up(floor: Plane | None, calibration: RgbdCalibration) -> FloatArray | None:
    """Return up in the depth camera's axes, None where nothing tells it."""
    if floor is not None:
        return floor.normal
    return None if calibration.gravity is None else -calibration.gravity


def _color(frame: SensorFrame) -> UInt8Array | None:
    """Return the colour image, None where there is none or it is damaged."""
    if frame.color is None:
        return None
    try:
        return decode_color(frame.color, frame.sequence)
    except RecordingError:
        return None


def _fits(calibration: RgbdCalibration, color_rgb: UInt8Array, depth_m: Float32Array) -> bool:
    try:
        check_fits(calibration, color_rgb.shape[:2], depth_m.shape)
    except CalibrationError:
        return False
    return True
