"""From pairs of a colour and an infrared image of a board to both cameras and their pose."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adibas.calibration.extrinsics_infrared import (
    InfraredFit,
    InfraredPair,
    fit_infrared,
    joint_covariance,
)
from adibas.calibration.extrinsics_pose import find_pose
from adibas.clock import Clock, to_text, utc_now
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.calibration_verdict import Finding, Grade, Reason, Verdict
from adibas.data.camera_fit import CameraFit
from adibas.data.sentence import Sentence
from adibas.errors import CalibrationError
from adibas.pipeline.calibrating import (
    CalibratingParams,
    CameraOutcome,
    NamedImage,
    calibrate_camera,
    read_images,
)
from adibas.progress import Progress
from adibas.texts import message

COLOR, DEPTH = "color.", "depth."
GOOD_PAIRS = 8
LARGE_BIRGE = 25.0
SHIFTED = ("depth.cx", "depth.cy")
SHIFT_SD_PX = 5.0
"""Sensors that match windows may cut their half off: the depth image is shifted from the infrared
one by nothing, or by about 5 and 4 pixels (ROS openni2_camera, getDepthCameraInfo; Konolige &
Mihelich, Technical description of Kinect calibration, "IR camera to depth offset"). Infrared images
do not tell which."""

MOVED = message(
    "In {n} of {total} pairs the board was moved between the colour and the infrared image, and "
    "they took no part: {images}. Put the board on a stand."
)
SHAKEN = message(
    "The pairs contradict one another {ratio} times more than their corners explain, and the "
    "intervals are widened for it. Put board and sensor on stands, and take the pairs anew."
)
FEW_PAIRS = message(
    "Only {n} pairs show the board in both images, and {wanted} are needed for a good "
    "calibration. Take more."
)


@dataclass(frozen=True, slots=True, eq=False)
class InfraredOutcome:
    """What came of the pairs.

    Attributes
    ----------
    color : CameraOutcome
        Of the colour images; its fit counts where no calibration was given.
    infrared : CameraOutcome
        Of the infrared images.
    fit : InfraredFit
        Pose of the depth camera.
    calibration : RgbdCalibration
        Of both cameras, without a correction of the depth.
    n_pairs : int
        With the board in both images.
    verdict : Verdict
        Of the pairs and both cameras.
    """

    color: CameraOutcome
    infrared: CameraOutcome
    fit: InfraredFit
    calibration: RgbdCalibration
    n_pairs: int
    verdict: Verdict


def in_pairs(color: Sequence[Path], infrared: Sequence[Path]) -> list[tuple[Path, Path]]:
    """Return the images that belong together: both kinds in the order of their names.

    Raises
    ------
    CalibrationError
        One kind has more images than the other.
    """
    if len(color) != len(infrared):
        raise CalibrationError(
            "There are {n_color} colour images, but {n_infrared} infrared images. Give one "
            "infrared image for each colour image; they are paired in the order of their names.",
            n_color=len(color),
            n_infrared=len(infrared),
        )
    by_name = [sorted(kind, key=lambda path: path.name) for kind in (color, infrared)]
    return list(zip(*by_name, strict=True))


def calibrate_infrared(
    pairs: Sequence[tuple[Path, Path]],
    board: Board,
    given: RgbdCalibration | None = None,
    params: CalibratingParams | None = None,
    *,
    progress: Progress | None = None,
    clock: Clock = utc_now,
) -> InfraredOutcome:
    """Calibrate both cameras of a sensor, and how they stand to each other.

    Parameters
    ----------
    pairs : sequence of (Path, Path)
        A colour and an infrared image of a board that stood still meanwhile.
    board : Board
        That they show.
    given : RgbdCalibration or None
        Of the colour camera; None: it is calibrated by the images.
    progress : callable or None
        Told (images done, images in all).

    Raises
    ------
    CalibrationError
        An image cannot be read, the images do not determine a camera, or show too few boards.
    """
    total, done = 2 * len(pairs), [0]

    def advance(_done: int, _total: int) -> None:
        done[0] += 1
        if progress is not None:
            progress(done[0], total)

    color, infrared = (
        _searched(read_images(paths), board, params, advance) for paths in zip(*pairs, strict=True)
    )
    known = _color_of(color, given)
    depth = _fitted(infrared, "infrared")
    return _outcome((color, infrared), known, depth, board, clock)


def _searched(
    images: Iterable[NamedImage],
    board: Board,
    params: CalibratingParams | None,
    progress: Progress,
) -> CameraOutcome:
    outcome = calibrate_camera(images, board, params, progress=progress)
    if outcome is None:
        raise ValueError("nothing can stop this calibration")
    return outcome


def _color_of(outcome: CameraOutcome, given: RgbdCalibration | None) -> RgbdCalibration:
    if given is None:
        fit = _fitted(outcome, "colour")
        names = tuple(f"{COLOR}{name}" for name in fit.parameter_names)
        return RgbdCalibration(
            color=fit.camera,
            rms_px=fit.rms_px,
            parameter_names=names,
            covariance=np.array(fit.covariance),
            corner_method=outcome.method.value,
        )
    camera = given.color
    if camera is None:
        raise CalibrationError(
            "The calibration has no colour camera. Calibrate it first, from images of the board."
        )
    height, width = outcome.images[0].size
    if (camera.height, camera.width) != (height, width):
        raise CalibrationError(
            "The calibration is for {camera} images of {width}x{height}, but the recording has "
            "{recorded_width}x{recorded_height}. Give the calibration of this resolution.",
            camera=message("colour"),
            width=camera.width,
            height=camera.height,
            recorded_width=width,
            recorded_height=height,
        )
    return given


def _fitted(outcome: CameraOutcome, kind: str) -> CameraFit:
    fit = outcome.fit
    if fit is None or not fit.is_settled:
        raise CalibrationError(
            "The {kind} images do not determine a camera: {reasons}",
            kind=message("infrared") if kind == "infrared" else message("colour"),
            reasons=" ".join(finding.text for finding in outcome.verdict.findings),
        )
    return fit


def _outcome(
    outcomes: tuple[CameraOutcome, CameraOutcome],
    known: RgbdCalibration,
    depth: CameraFit,
    board: Board,
    clock: Clock,
) -> InfraredOutcome:
    color, infrared = outcomes
    if known.color is None:
        raise ValueError("the colour camera is needed")
    seen = _pairs(color, infrared, (known.color, depth.camera), board)
    fit = fit_infrared(seen)
    if fit is None:
        raise CalibrationError(
            "Only {n} pairs show the board in both images. Take eight or more, in which both "
            "cameras see all of it.",
            n=len(seen),
        )
    names, covariance = _joint(known, depth, fit)
    calibration = replace(
        known,
        depth=depth.camera,
        color_from_depth=fit.color_from_depth,
        depth_bias=DepthBias(),
        parameter_names=names,
        covariance=covariance,
        created_utc=to_text(clock()),
    )
    findings = (*_findings(fit, len(seen)), *color.verdict.findings, *infrared.verdict.findings)
    grades = list(Grade)
    worst_first = sorted(findings, key=lambda found: -grades.index(found.grade))
    return InfraredOutcome(
        color, infrared, fit, calibration, len(seen), Verdict(tuple(worst_first))
    )


def _pairs(
    color: CameraOutcome,
    infrared: CameraOutcome,
    cameras: tuple[CameraCalibration, CameraCalibration],
    board: Board,
) -> list[InfraredPair]:
    found = []
    for one, other in zip(color.images, infrared.images, strict=True):
        corners = one.search.corners, other.search.corners
        if corners[0] is None or corners[1] is None:
            continue
        poses = find_pose(corners[0], board, cameras[0]), find_pose(corners[1], board, cameras[1])
        if poses[0] is not None and poses[1] is not None:
            found.append(InfraredPair(f"{one.name}, {other.name}", poses[0], poses[1]))
    return found


def _joint(
    known: RgbdCalibration, depth: CameraFit, fit: InfraredFit
) -> tuple[tuple[str, ...], np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """Return names and covariance of everything; the colour camera's as far as it is known.

    The pose is that of the infrared camera, so that the shift of the depth image is no part of it.
    """
    chosen = [i for i, name in enumerate(known.parameter_names) if name.startswith(COLOR)]
    if known.covariance is None:
        chosen = []
    names = [known.parameter_names[i].removeprefix(COLOR) for i in chosen]
    part = (
        np.zeros((0, 0)) if known.covariance is None else known.covariance[np.ix_(chosen, chosen)]
    )
    infrared = (depth.parameter_names, np.array(depth.covariance))
    joint_names, covariance = joint_covariance(fit, (names, part), infrared)
    is_shifted = np.isin(joint_names, SHIFTED)
    return joint_names, covariance + np.diag(np.where(is_shifted, SHIFT_SD_PX**2, 0.0))


def _findings(fit: InfraredFit, n_pairs: int) -> list[Finding]:
    findings = []
    n_used = n_pairs - len(fit.outliers)
    if n_used < GOOD_PAIRS:
        few = Sentence(FEW_PAIRS, {"n": n_used, "wanted": GOOD_PAIRS})
        findings.append(Finding(Reason.DEPTH, Grade.USABLE, sentence=few))
    if fit.outliers:
        fields = {"n": len(fit.outliers), "total": n_pairs, "images": "; ".join(fit.outliers)}
        findings.append(Finding(Reason.DEPTH, Grade.USABLE, sentence=Sentence(MOVED, fields)))
    if fit.birge_ratio > LARGE_BIRGE:
        fields = {"ratio": float(np.sqrt(fit.birge_ratio))}
        findings.append(Finding(Reason.DEPTH, Grade.USABLE, sentence=Sentence(SHAKEN, fields)))
    return findings
