"""A wand with two markers, held before the sensor at the start of a session."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.calibration.files import check_fits
from adibas.calibration.wand import WandCheck, WandParams, check_wand
from adibas.data.frames import SensorFrame
from adibas.data.markers import Marker
from adibas.errors import MarkerError
from adibas.geometry.uncertainty import independent
from adibas.pipeline.capturing import calibration_in_use, counted, record_burst
from adibas.pipeline.live import LiveView
from adibas.pipeline.posture import MarkerTarget, analyse_burst
from adibas.pipeline.session import PostureRequest, analyse_recording
from adibas.progress import Progress
from adibas.recordings import RecordingWriter
from adibas.recordings.ports import RecordingOptions

N_ENDS = 2
N_FRAMES = 30
"""Of a live check: a second."""

FORMAT = "adibas-wand"
FRESH = timedelta(hours=12)
"""A check serves the patients of one day."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenWand:
    """What a burst shows of a wand.

    Attributes
    ----------
    markers : tuple of Marker
        With a position, from top to bottom; two at least.
    picture_rgb : (H, W, 3) uint8 array
        Of the middle frame.
    """

    markers: tuple[Marker, ...]
    picture_rgb: UInt8Array


def measure_wand(
    request: PostureRequest,
    length_m: float,
    progress: Progress,
    params: WandParams | None = None,
) -> WandCheck:
    """Measure a wand as markers of a patient are measured, and compare it with its length.

    Parameters
    ----------
    request : PostureRequest
        A burst of somebody who holds the wand and wears no markers.
    length_m : float
        Between the centres of its markers, as measured with a ruler.
    progress : callable
        Told (frames done, frames in all).

    Raises
    ------
    MarkerError
        Not two markers are seen.
    RecordingError, CalibrationError
        As for a posture.
    """
    markers = analyse_recording(request, progress).markers
    ends = [marker for marker in markers if marker.position_m is not None]
    if len(ends) != N_ENDS or len(markers) != N_ENDS:
        raise MarkerError(
            "Markers that are seen: {n}, and a wand has two. Hold it alone before the sensor: "
            "nobody wears markers meanwhile, and nothing else has their colour.",
            n=len(markers),
        )
    return compare_ends(ends[0], ends[1], length_m, params)


def see_wand(
    live: LiveView, target: MarkerTarget, progress: Progress, n_frames: int = N_FRAMES
) -> SeenWand:
    """Take a burst of a live sensor and find the wand's markers; nothing is written.

    Parameters
    ----------
    live : LiveView
        With a live sensor; its settings and calibration are used.
    target : MarkerTarget
        What the markers look like.
    progress : callable
        Told (steps done, steps in all). What it raises cancels and is raised again.

    Raises
    ------
    SensorError
        No sensor is live, or it was lost meanwhile.
    CalibrationError
        There is no calibration, or it does not fit.
    MarkerError
        Nobody is seen, or fewer than two markers have a position.
    """
    calibration = calibration_in_use(live)
    burst = record_burst(live, _NothingKept(), n_frames, progress)
    middle = burst.frame(len(burst) // 2)
    check_fits(calibration, middle.color_rgb.shape[:2], middle.depth_m.shape)
    found = analyse_burst(counted(burst, progress), calibration, target, live.params)
    markers = tuple(marker for marker in found.markers if marker.position_m is not None)
    if len(markers) < N_ENDS:
        raise MarkerError(
            "Markers that are seen in colour and depth: {n}, and a wand has two. Hold it so that "
            "both of its ends face the sensor, at one to three metres.",
            n=len(markers),
        )
    return SeenWand(markers, middle.color_rgb)


def compare_ends(
    one: Marker, other: Marker, length_m: float, params: WandParams | None = None
) -> WandCheck:
    """Compare two markers that have positions with the length of the wand."""
    positions_m, covariance_m2 = _joined(one, other)
    return check_wand(positions_m, covariance_m2, length_m, params)


def wand_to_document(check: WandCheck, checked_utc: datetime) -> dict[str, object]:
    """Return a check as a session keeps it; lengths in metres."""
    return {
        "format": FORMAT,
        "checked_utc": checked_utc.isoformat(),
        "length_m": check.length_m,
        "measured_m": check.measured_m,
        "interval_m": list(check.interval_m),
        "tolerance_m": check.tolerance_m,
        "result": check.result.value,
    }


def wand_from_document(document: Mapping[str, object]) -> tuple[WandCheck, datetime]:
    """Return a check that was kept, and when it was made."""
    interval_m = document["interval_m"]
    if not isinstance(interval_m, list | tuple):
        raise ValueError("interval_m is no list")  # noqa: TRY004  (the document's fault)
    low_m, high_m = (float(value) for value in interval_m)
    lengths_m = (float(str(document[name])) for name in ("length_m", "measured_m", "tolerance_m"))
    length_m, measured_m, tolerance_m = lengths_m
    check = WandCheck(length_m, measured_m, (low_m, high_m), tolerance_m)
    return check, datetime.fromisoformat(str(document["checked_utc"]))


def is_fresh(document: Mapping[str, object], now_utc: datetime) -> bool:
    """Say whether a check that was kept is of this day, so that a new session may have it."""
    return timedelta() <= now_utc - wand_from_document(document)[1] <= FRESH


class _NothingKept(RecordingWriter):
    """Takes the frames of a burst that nobody wants on the disk."""

    def __init__(self) -> None:
        self.path, self.options, self.n_frames = Path(), RecordingOptions(), 0

    @property
    def n_dropped(self) -> int:
        return 0

    def write(self, frame: SensorFrame) -> None:  # noqa: ARG002  (it is in the burst)
        self.n_frames += 1

    def count_dropped(self, n_frames: int) -> None:
        """Nothing is told of a recording that does not exist."""

    def close(self) -> None:
        """There is nothing to finish."""

    def abandon(self) -> None:
        """There is nothing to remove."""


def _joined(one: Marker, other: Marker) -> tuple[FloatArray, FloatArray]:
    """Return (2, 3) positions and their (6, 6) covariance, with what both share."""
    if one.position_m is None or other.position_m is None:
        raise ValueError("both ends need a position")
    covariance_m2 = independent(np.asarray(one.covariance_m2), np.asarray(other.covariance_m2))
    if one.shared_m is not None and other.shared_m is not None:
        shared_m2 = one.shared_m @ other.shared_m.T
        covariance_m2[:3, 3:], covariance_m2[3:, :3] = shared_m2, shared_m2.T
    return np.stack([one.position_m, other.position_m]), covariance_m2
