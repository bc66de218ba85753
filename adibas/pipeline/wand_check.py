"""A wand with two markers, held before the sensor at the start of a session."""

from collections.abc import Callable

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.wand import WandCheck, WandParams, check_wand
from adibas.data.markers import Marker
from adibas.errors import MarkerError
from adibas.geometry.uncertainty import independent
from adibas.pipeline.session import PostureRequest, analyse_recording

Progress = Callable[[int, int], None]
N_ENDS = 2


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
            "{n} markers are seen, and a wand has two. Hold it alone before the sensor: nobody "
            "wears markers meanwhile, and nothing else has their colour.",
            n=len(markers),
        )
    positions_m, covariance_m2 = _joined(ends[0], ends[1])
    return check_wand(positions_m, covariance_m2, length_m, params)


def _joined(one: Marker, other: Marker) -> tuple[FloatArray, FloatArray]:
    """Return (2, 3) positions and their (6, 6) covariance, with what both share."""
    if one.position_m is None or other.position_m is None:
        raise ValueError("both ends need a position")
    covariance_m2 = independent(np.asarray(one.covariance_m2), np.asarray(other.covariance_m2))
    if one.shared_m is not None and other.shared_m is not None:
        shared_m2 = one.shared_m @ other.shared_m.T
        covariance_m2[:3, 3:], covariance_m2[3:, :3] = shared_m2, shared_m2.T
    return np.stack([one.position_m, other.position_m]), covariance_m2
