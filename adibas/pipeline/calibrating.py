"""From images of a board to a calibrated colour camera, with a verdict."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.calibration.camera_fitting import FittingParams, fit_camera
from adibas.calibration.corners import CornerMethod, FitParams
from adibas.calibration.finder import BoardSearch, FinderParams, search_board
from adibas.calibration.lens_models import LensModel
from adibas.calibration.quality import map_residuals
from adibas.calibration.sharpness import blur_px
from adibas.calibration.verdict import Evidence, ScaleCheck, VerdictParams, judge
from adibas.clock import Clock, to_text, utc_now
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.calibration_verdict import Verdict
from adibas.data.camera_fit import CameraFit
from adibas.errors import CalibrationError
from adibas.pipeline.in_order import in_order
from adibas.progress import Progress

N_THREADS = 2
MAX_BYTES = 256 * 1024 * 1024
"""No image of a camera is that large: the file is something else."""


@dataclass(frozen=True, slots=True)
class CalibratingParams:
    """Settings of all steps."""

    finder: FinderParams = field(default_factory=FinderParams)
    fitting: FittingParams = field(default_factory=FittingParams)
    verdict: VerdictParams = field(default_factory=VerdictParams)


def params_by(method: CornerMethod, model: LensModel | None = None) -> CalibratingParams:
    """Return settings for corners placed in a way, and a lens model; None chooses one."""
    return CalibratingParams(
        finder=FinderParams(fit=FitParams(method=method)), fitting=FittingParams(model=model)
    )


@dataclass(frozen=True, slots=True, eq=False)
class NamedImage:
    """One picture of the board.

    Attributes
    ----------
    name : str
        For the reader.
    gray : (H, W) array
        Brightness, 0-255.
    """

    name: str
    gray: UInt8Array


@dataclass(frozen=True, slots=True, eq=False)
class SearchedImage:
    """What was found in one picture.

    Attributes
    ----------
    name : str
        Of the picture.
    size : (height, width)
        Of it.
    search : BoardSearch
        Corners, or why there are none.
    blur_px : float
        Of the board; NaN without corners.
    """

    name: str
    size: tuple[int, int]
    search: BoardSearch
    blur_px: float


@dataclass(frozen=True, slots=True, eq=False)
class CameraOutcome:
    """What came of a calibration.

    Attributes
    ----------
    board : Board
        That was said to be shown.
    images : tuple of SearchedImage
        In the order given.
    fit : CameraFit or None
        None where nothing could be fitted.
    verdict : Verdict
        What it is worth.
    method : CornerMethod
        What counted as a corner.
    """

    board: Board
    images: tuple[SearchedImage, ...]
    fit: CameraFit | None
    verdict: Verdict
    method: CornerMethod = CornerMethod.EDGES


def read_images(paths: Iterable[Path]) -> Iterable[NamedImage]:
    """Read pictures one by one, as the sensor's pixels stand: no turning by what a file says.

    Raises
    ------
    CalibrationError
        A file is missing or no image.
    """
    for path in paths:
        yield NamedImage(path.name, _read_gray(path))


def calibrate_camera(
    images: Iterable[NamedImage],
    board: Board,
    params: CalibratingParams | None = None,
    *,
    n_images: int = 0,
    progress: Progress | None = None,
    stop: Event | None = None,
) -> CameraOutcome | None:
    """Find the board in every image, fit the camera, and judge it.

    Parameters
    ----------
    images : iterable of NamedImage
        All of one size.
    board : Board
        That they show.
    params : CalibratingParams or None
        How.
    n_images : int
        For `progress`; 0 where it is not known.
    progress : callable or None
        Called with (done, total).
    stop : Event or None
        Ends the work early.

    Returns
    -------
    outcome : CameraOutcome or None
        None where `stop` was set.

    Raises
    ------
    CalibrationError
        There are no images, or they have different sizes.
    """
    params = params or CalibratingParams()

    def work(image: NamedImage) -> SearchedImage:
        return search_image(image, board, params.finder)

    searched: list[SearchedImage] = []
    with in_order(work, images, N_THREADS) as results:
        for result in results:
            searched.append(result)
            _check_size(searched)
            if progress is not None:
                progress(len(searched), n_images)
            if stop is not None and stop.is_set():
                return None
    return fit_searched(searched, board, params)


def search_image(
    image: NamedImage, board: Board, params: FinderParams | None = None
) -> SearchedImage:
    """Find the board in one image."""
    search = search_board(image.gray, board, image.name, params)
    blur = math.nan if search.corners is None else blur_px(image.gray, board, search.corners)
    height, width = image.gray.shape
    return SearchedImage(image.name, (height, width), search, blur)


def fit_searched(
    images: Iterable[SearchedImage],
    board: Board,
    params: CalibratingParams | None = None,
) -> CameraOutcome:
    """Fit and judge a camera from images that were searched already.

    Parameters
    ----------
    images : iterable of SearchedImage
        All of one size.
    board : Board
        That they show.
    params : CalibratingParams or None
        How.

    Raises
    ------
    CalibrationError
        There are no images.
    """
    params = params or CalibratingParams()
    images = tuple(images)
    if not images:
        raise CalibrationError("There are no images to calibrate from. Give some of the board.")
    corners = [image.search.corners for image in images if image.search.corners is not None]
    fit = fit_camera(board, corners, params.fitting) if corners else None
    outcome = CameraOutcome(board, images, fit, Verdict(), params.finder.fit.method)
    return judged(outcome, params=params.verdict)


def judged(
    outcome: CameraOutcome,
    scale_checks: tuple[ScaleCheck, ...] = (),
    params: VerdictParams | None = None,
) -> CameraOutcome:
    """Return the same with the verdict that its images, its fit and the depth give.

    Parameters
    ----------
    outcome : CameraOutcome
        Whose verdict is left aside.
    scale_checks : tuple of ScaleCheck
        Distances of boards by a depth sensor: they show a wrong size of the squares.
    """
    searched = [image for image in outcome.images if image.search.corners is not None]
    evidence = Evidence(
        outcome.board,
        [image.search for image in outcome.images],
        outcome.fit,
        [image.blur_px for image in searched],
        scale_checks,
    )
    return replace(outcome, verdict=judge(evidence, params))


def color_calibration(
    fit: CameraFit,
    sensor_serial: str = "",
    clock: Clock = utc_now,
    method: CornerMethod = CornerMethod.EDGES,
) -> RgbdCalibration:
    """Return the calibration of a colour camera alone, as it is stored."""
    return RgbdCalibration(
        color=fit.camera,
        rms_px=fit.rms_px,
        parameter_names=tuple(f"color.{name}" for name in fit.parameter_names),
        covariance=np.array(fit.covariance),
        sensor_serial=sensor_serial,
        created_utc=to_text(clock()),
        valid_region={"color": covered_cells(fit)},
        corner_method=method.value,
    )


def covered_cells(fit: CameraFit) -> Mapping[str, object]:
    """Return where the images had corners: 1 or 0 for each cell, row by row."""
    counts = map_residuals(fit).counts
    return {
        "rows": counts.shape[0],
        "columns": counts.shape[1],
        "covered": (counts > 0).astype(int).tolist(),
    }


def parameter_intervals(fit: CameraFit) -> FloatArray:
    """Return the (n, 2) intervals that hold each parameter's truth in 95 % of cases."""
    half = 1.959964 * fit.standard_deviations
    return np.stack([fit.values - half, fit.values + half], axis=-1)


def _read_gray(path: Path) -> UInt8Array:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise CalibrationError(
                "{file} is too large for an image. Choose another file.", file=path.name
            )
        data = np.fromfile(path, np.uint8)
    except OSError as error:
        raise CalibrationError(
            "{file} cannot be read: {reason}. Check the name of the image.",
            file=path.name,
            reason=error.strerror or str(error),
        ) from error
    flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        gray = cv2.imdecode(data, flags) if data.size else None
    except cv2.error:
        gray = None
    if gray is None:
        raise CalibrationError(
            "{file} is no image that can be read. Give PNG, JPEG or TIFF images of the board.",
            file=path.name,
        )
    return np.ascontiguousarray(gray, np.uint8)


def _check_size(searched: list[SearchedImage]) -> None:
    first, last = searched[0], searched[-1]
    if first.size != last.size:
        raise CalibrationError(
            "{first} has {first_width}x{first_height} pixels, but {last} has "
            "{last_width}x{last_height}. Give images of one camera in one mode.",
            first=first.name,
            first_width=first.size[1],
            first_height=first.size[0],
            last=last.name,
            last_width=last.size[1],
            last_height=last.size[0],
        )
