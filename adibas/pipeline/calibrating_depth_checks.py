"""What is looked at after the depth is calibrated: edges, time, the floor, and what is lacking."""

from collections.abc import Sequence

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.body.floor import find_floor
from adibas.calibration.board_scale import BoardScale
from adibas.calibration.depth_bias import weak_directions
from adibas.calibration.drift import Drift, fit_drift
from adibas.calibration.extrinsics import DepthFit
from adibas.calibration.registration_check import (
    RegistrationCheck,
    RegistrationResult,
    check_registration,
)
from adibas.calibration.shots import cells_near_plane
from adibas.calibration.vertical import Vertical, vertical_from_floor
from adibas.calibration.vertical_uncertainty import with_depth_error
from adibas.data.calibration import RgbdCalibration
from adibas.data.calibration_verdict import Finding, Grade, Reason, Verdict
from adibas.data.sentence import Sentence
from adibas.measures.sight_plane import up_without_floor
from adibas.pipeline.calibrating_depth_moments import Seen
from adibas.pipeline.calibrating_depth_types import DepthCalibratingParams
from adibas.texts import message

N_CHECKED = 3
"""Bursts at which edges are compared, and the floor is looked for."""

FAR_M = 2.5
"""Patients stand as far away as that."""

FAR_BOARD = message(
    "The farthest board stood at {farthest_m} m. Beyond it the depth is corrected by guess: hold "
    "the board farther away as well."
)
OUTLIERS = message(
    "{n} of {total} boards contradict the others and were left out: the board or the sensor moved, "
    "or something stood before it."
)
FEW_BOARDS = message(
    "Only {n} boards could be used, and {wanted} are needed for a good calibration. Hold the board "
    "still for two seconds at each place, in view of both cameras."
)


def vertical_of(
    seen: Sequence[Seen], calibration: RgbdCalibration, rotation_deg: int = 0
) -> Vertical | None:
    """Return the vertical of the burst whose floor is known best; None where no floor is seen.

    `rotation_deg` is how far the pictures are turned clockwise to be upright.
    """
    depth = calibration.depth
    if depth is None:
        raise ValueError("the depth camera is needed")
    best: Vertical | None = None
    for moment in _spread(seen):
        depth_m = _corrected_m(moment, calibration)
        floor = find_floor(depth_m, depth, up_without_floor(calibration, rotation_deg))
        if floor is None:
            continue
        blocks_m = cells_near_plane(depth_m, depth, floor)
        found = vertical_from_floor(blocks_m, floor)
        if found is not None:
            found = with_depth_error(found, blocks_m, calibration)
        if found is not None and (best is None or found.sd_rad < best.sd_rad):
            best = found
    return best


def registration_of(seen: Sequence[Seen], calibration: RgbdCalibration) -> RegistrationCheck | None:
    """Return the check of the burst whose edges say most; None where none has colour."""
    best: RegistrationCheck | None = None
    for moment in _spread([moment for moment in seen if moment.gray is not None]):
        if moment.gray is None:
            continue
        found = check_registration(moment.gray, _corrected_m(moment, calibration), calibration)
        if best is None or _says_more(found, best):
            best = found
    return best


def drift_of(fit: DepthFit) -> Drift | None:
    """Return how the depth of the boards changed with time."""
    shots = [shot for shot in fit.shots if not shot.is_outlier]
    sigmas = np.array([np.hypot(shot.sigma_per_m, fit.sigma_per_m) for shot in shots])
    return fit_drift(
        np.array([shot.time_s for shot in shots]),
        np.array([shot.error_per_m for shot in shots]),
        np.nan_to_num(sigmas),
    )


def verdict_of(
    fit: DepthFit,
    covariance: FloatArray,
    checks: tuple[BoardScale | None, RegistrationCheck | None, Drift | None],
    params: DepthCalibratingParams,
) -> Verdict:
    """Return what the calibration is worth, and why it is not better."""
    scale, registration, drift = checks
    boards = [shot for shot in fit.shots if np.isfinite(shot.error_per_m)]
    findings: list[Finding] = []
    if scale is not None and scale.is_wrong:
        findings.append(_finding(Grade.REPEAT, scale.sentence))
    if boards:
        n_used = sum(not shot.is_outlier for shot in boards)
        if n_used < params.good_boards:
            few = Sentence(FEW_BOARDS, {"n": n_used, "wanted": params.good_boards})
            grade = Grade.REPEAT if n_used < params.least_boards else Grade.USABLE
            findings.append(_finding(grade, few))
        others = [*_about_boards(fit), *weak_directions(fit, covariance)]
        findings += [_finding(Grade.USABLE, sentence) for sentence in others]
    if registration is not None and registration.result is RegistrationResult.SHIFTED:
        findings.append(_finding(Grade.USABLE, registration.sentence))
    drifts = None if drift is None else drift.notice()
    findings += [] if drifts is None else [_finding(Grade.USABLE, drifts)]
    return Verdict(tuple(findings))


def _finding(grade: Grade, sentence: Sentence) -> Finding:
    return Finding(Reason.DEPTH, grade, sentence=sentence)


def _about_boards(fit: DepthFit) -> list[Sentence]:
    boards = [shot for shot in fit.shots if np.isfinite(shot.error_per_m)]
    used = [shot for shot in boards if not shot.is_outlier]
    sentences = []
    if len(used) < len(boards):
        fields = {"n": len(boards) - len(used), "total": len(boards)}
        sentences.append(Sentence(OUTLIERS, fields))
    farthest_m = max((shot.distance_m for shot in used), default=0.0)
    if farthest_m < FAR_M:
        sentences.append(Sentence(FAR_BOARD, {"farthest_m": float(farthest_m)}))
    return sentences


def _corrected_m(moment: Seen, calibration: RgbdCalibration) -> Float32Array:
    with np.errstate(divide="ignore"):
        return calibration.corrected_depth((1.0 / moment.disparity.mean_per_m).astype(np.float32))


def _says_more(one: RegistrationCheck, other: RegistrationCheck) -> bool:
    if RegistrationResult.UNSURE in (one.result, other.result):
        return other.result is RegistrationResult.UNSURE
    return float(np.hypot(*one.standard_error_px)) < float(np.hypot(*other.standard_error_px))


def _spread(seen: Sequence[Seen]) -> list[Seen]:
    """Return a few moments from all over the recording."""
    chosen = np.unique(np.linspace(0, len(seen) - 1, N_CHECKED).round().astype(int))
    return [seen[index] for index in chosen] if seen else []
