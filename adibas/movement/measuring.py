"""Joints over time -> smoothed angles, their extremes, and both sides beside each other."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.movement import AngleCurve, AngleRange, Movement, Origin, Symmetry
from adibas.data.posture import Provenance
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.movement.joint_angles import ANGLES, joint_angles
from adibas.texts import message
from adibas.timeseries.lowpass import LowpassParams, even_times, lowpass, noise_share, resample
from adibas.timeseries.speeds import SpeedNoise, speed_noise, speeds

CAMERA_UP = (0.0, -1.0, 0.0)

SLOW = message(
    "The recording has {rate} frames a second: movements are not smoothed, and fast ones are cut. "
    "Record with 30 frames a second."
)
NO_VERTICAL = message(
    "The trunk's angles against the vertical are left out: the vertical is not measured. It is "
    "known of recordings with a calibration that saw the floor, and of tables of joints that were "
    "made of these."
)
OFTEN_HIDDEN = message(
    "In {percent} % of the time not one joint angle is known. Let the whole body be seen."
)


@dataclass(frozen=True, slots=True)
class MovementParams:
    """How ranges of movement are measured.

    Attributes
    ----------
    lowpass : LowpassParams
        Of the joints' positions.
    least_range_deg : float
        Where the mean range of both sides is smaller, their symmetry means nothing: 5.
    hidden_share : float
        Of the time without any angle, from which on the reader is told: 0.2.
    takes_upright : bool
        The picture's upper side stands for the vertical, known or not. No: angles against a
        vertical that is not known are left out. Yes where two movements before one camera are
        compared, of which one may know it and the other not.
    """

    lowpass: LowpassParams = field(default_factory=LowpassParams)
    least_range_deg: float = 5.0
    hidden_share: float = 0.2
    takes_upright: bool = False


@dataclass(frozen=True, slots=True)
class MovementSource:
    """Where joints come from, for the report.

    Attributes
    ----------
    origin : str
        Markers, markerless, or unknown.
    provenance : Provenance
        Of the joints.
    patient : str
        A pseudonym, never a name.
    up : (3,) array or None
        Against gravity in the joints' axes; None where nobody measured it.
    picture_up : (3,) array
        Upper side of the picture as it is shown, which stands for it then.
    notices : tuple of Sentence
        Of the stages before.
    """

    origin: Origin
    provenance: Provenance
    patient: str = ""
    up: FloatArray | None = None
    picture_up: FloatArray = field(default_factory=lambda: np.array(CAMERA_UP))
    notices: tuple[Sentence, ...] = ()


def measure_movement(
    track: SkeletonTrack, source: MovementSource, params: MovementParams | None = None
) -> Movement:
    """Return the angles of every joint over time, and how far each went.

    Times are even and begin with 0 at the first frame. Positions are smoothed before angles are
    taken of them, so that a hidden joint hides no other.

    Where the vertical is not known, angles against it are NaN.
    """
    params = params or MovementParams()
    times_s = even_times(track.times_s - track.times_s[0])
    measured_m = resample(
        track.times_s - track.times_s[0], track.joints_m, times_s, params.lowpass.longest_gap_s
    )
    rate_hz = _rate_hz(times_s)
    joints_m = lowpass(measured_m, rate_hz, params.lowpass)
    measured_up = None if params.takes_upright else source.up
    up = np.asarray(source.picture_up if measured_up is None else measured_up, float)
    is_up_missing = measured_up is None and not params.takes_upright
    against = np.full(3, np.nan) if is_up_missing else up
    curves = tuple(_curves(measured_m, joints_m, against, times_s, params.lowpass))
    noise = speed_noise(rate_hz, params.lowpass)
    each = (range_of(curve, times_s, noise) for curve in curves)
    ranges = tuple(found for found in each if found is not None)
    return Movement(
        times_s,
        joints_m,
        up,
        measured_up is not None,
        curves,
        ranges,
        tuple(symmetries(ranges, params.least_range_deg)),
        source.origin,
        source.patient,
        source.provenance,
        asdict(params.lowpass),
        (
            *source.notices,
            *((Sentence(NO_VERTICAL),) if is_up_missing else ()),
            *_notices(curves, rate_hz, params),
        ),
    )


def range_of(
    curve: AngleCurve, times_s: FloatArray, noise: SpeedNoise | None = None
) -> AngleRange | None:
    """Return the extremes of a curve; None where it is known nowhere."""
    seen = np.isfinite(curve.deg)
    if not seen.any():
        return None
    least, greatest = int(np.nanargmin(curve.deg)), int(np.nanargmax(curve.deg))
    known_deg_s = np.abs(curve.speed_deg_s[np.isfinite(curve.speed_deg_s)])
    peak_deg_s = float("nan")
    if noise is not None and len(known_deg_s):
        known_s = len(known_deg_s) * float(times_s[1] - times_s[0])
        peak_deg_s = noise.peak(curve.speed_sd_deg_s, known_s)
    return AngleRange(
        curve.name,
        float(curve.deg[least]),
        float(curve.deg[greatest]),
        float(times_s[least]),
        float(times_s[greatest]),
        float(known_deg_s.max()) if len(known_deg_s) else float("nan"),
        float(seen.mean()),
        curve.sd_deg,
        curve.speed_sd_deg_s,
        peak_deg_s,
    )


def symmetries(ranges: tuple[AngleRange, ...], least_range_deg: float) -> Iterator[Symmetry]:
    """Yield what both sides moved, for every joint of which both are known.

    Source: Robinson, Herzog & Nigg, Use of force platform variables to quantify the effects of
    chiropractic manipulation on gait symmetry (1987): the difference over the mean.
    """
    by_name = {found.name: found for found in ranges}
    for name, left in by_name.items():
        joint = name.removeprefix("left_")
        right = by_name.get(f"right_{joint}")
        if joint == name or right is None:
            continue
        mean_deg = (left.range_deg + right.range_deg) / 2
        index = None
        if mean_deg >= least_range_deg:
            index = 100.0 * (right.range_deg - left.range_deg) / mean_deg
        yield Symmetry(joint, left.range_deg, right.range_deg, index)


def _curves(
    measured_m: FloatArray,
    joints_m: FloatArray,
    up: FloatArray,
    times_s: FloatArray,
    params: LowpassParams,
) -> Iterator[AngleCurve]:
    smooth, raw = joint_angles(joints_m, up), joint_angles(measured_m, up)
    rate_hz = _rate_hz(times_s)
    noise = speed_noise(rate_hz, params)
    shares = (float("inf"), float("inf"))
    if noise is not None:
        shares = (noise_share(rate_hz, params), noise.share_hz)
    # Half a period of the cutoff: closer to an end the filter's slope is not to be trusted.
    edge_s = 0.0 if noise is None else 0.5 / params.cutoff_hz
    for name in ANGLES:
        smooth_deg = np.degrees(unwrapped(smooth[name]))
        taken_rad = np.angle(np.exp(1j * (raw[name] - smooth[name])))
        speed_deg_s = speeds(smooth_deg, times_s, edge_s)
        sd_deg, speed_sd_deg_s = (_sd_deg(taken_rad, share) for share in shares)
        yield AngleCurve(name, smooth_deg, speed_deg_s, sd_deg, speed_sd_deg_s)


def unwrapped(angles_rad: FloatArray) -> FloatArray:
    """Return (T,) angles without jumps of a whole turn, also across what was not seen.

    The value seen first stays as it is.
    """
    seen = np.isfinite(angles_rad)
    whole = np.array(angles_rad, float)
    whole[seen] = np.unwrap(whole[seen])
    return whole


def _sd_deg(taken_rad: FloatArray, share: float) -> float:
    taken = taken_rad[np.isfinite(taken_rad)]
    if not len(taken) or not np.isfinite(share):
        return float("nan")
    return float(np.degrees(np.sqrt((taken**2).mean())) * share)


def _rate_hz(times_s: FloatArray) -> float:
    return float(1.0 / (times_s[1] - times_s[0])) if len(times_s) > 1 else float("nan")


def _notices(
    curves: tuple[AngleCurve, ...], rate_hz: float, params: MovementParams
) -> Iterator[Sentence]:
    if np.isfinite(rate_hz) and not np.isfinite(noise_share(rate_hz, params.lowpass)):
        yield Sentence(SLOW, {"rate": rate_hz})
    hidden = ~np.isfinite([curve.deg for curve in curves]).any(axis=0)
    if hidden.mean() > params.hidden_share:
        yield Sentence(OFTEN_HIDDEN, {"percent": float(100 * hidden.mean())}, decimals=0)
