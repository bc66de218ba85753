"""One calibration in the making: pictures of a board, what they lack, what they give."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from adibas.calibration.comparison import Comparison, compare
from adibas.calibration.finder import TEXTS, as_gray
from adibas.calibration.guidance import Guidance, Stance, guide
from adibas.calibration.kept import KeptCalibration, KeptCalibrations, sensor_key, sizes_of
from adibas.clock import Clock, to_text, utc_now
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.calibration_report import DepthReport
from adibas.data.calibration_verdict import SENTENCES, Grade, Reason, Verdict
from adibas.data.frames import SourceInfo
from adibas.data.sentence import Sentence
from adibas.errors import AdibasError, CalibrationError
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline.calibrating import (
    CameraOutcome,
    NamedImage,
    color_calibration,
    fit_searched,
    judged,
    search_image,
)
from adibas.pipeline.calibrating_depth import DepthOutcome
from adibas.pipeline.calibrating_pictures import (
    calibrate_depth_of,
    check_scales,
    has_depth_camera,
    joined,
)
from adibas.pipeline.calibration_pictures import (
    KeptPicture,
    KeptPictures,
    NewPicture,
    PictureFolder,
)
from adibas.pipeline.calibration_report import report_of_depth_outcome
from adibas.pipeline.calibration_watch import Moment, MomentWatch, load_kernels
from adibas.pipeline.learning import PICTURE_SUFFIXES, read_picture
from adibas.pipeline.live_frames import LiveFrame
from adibas.progress import Progress
from adibas.texts import Message, message

OTHER_SIZE = message("It has {width} x {height} pixels, not {wanted_width} x {wanted_height}.")


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedSensor:
    """What is calibrated.

    Attributes
    ----------
    key : str
        As `sensor_key` tells it; '' for pictures of a sensor that nobody knows.
    color_size : (width, height)
        Of its colour image.
    info : SourceInfo
        As it was opened.
    """

    key: str
    color_size: tuple[int, int]
    info: SourceInfo

    @property
    def intrinsics(self) -> Intrinsics | None:
        """Of the colour camera, as far as they are known before; None where they are not."""
        calibration = self.info.calibration
        color = None if calibration is None else calibration.color
        if color is None or (color.width, color.height) != self.color_size:
            return None
        return color.intrinsics


def sensor_of(frame: LiveFrame, info: SourceInfo) -> CalibratedSensor | None:
    """Return the sensor that a live frame comes of; None where it has no colour."""
    if frame.color_rgb is None:
        return None
    height, width = frame.color_rgb.shape[:2]
    return CalibratedSensor(sensor_key(info), (width, height), info)


@dataclass(frozen=True, slots=True, eq=False)
class SensorOutcome:
    """What the pictures gave.

    Attributes
    ----------
    camera : CameraOutcome
        Of the colour camera, with the verdict on both cameras.
    calibration : RgbdCalibration or None
        As it would be kept; None where nothing could be fitted.
    previous : KeptCalibration or None
        The newest one before of the same sensor.
    comparison : Comparison or None
        With that.
    depth : DepthOutcome or None
        Of the depth camera; None where there is none, or no picture tells of it.
    """

    camera: CameraOutcome
    calibration: RgbdCalibration | None
    previous: KeptCalibration | None
    comparison: Comparison | None
    depth: DepthOutcome | None = None

    @property
    def is_good_enough(self) -> bool:
        """Say whether it may be used."""
        return self.calibration is not None and self.camera.verdict.grade is not Grade.REPEAT

    def depth_report(self) -> DepthReport | None:
        """Return what is told of the depth camera; None where nothing was found of it."""
        return None if self.depth is None else report_of_depth_outcome(self.depth)


@dataclass(frozen=True, slots=True)
class RefusedImage:
    """A saved image that was not taken, and why."""

    name: str
    reason: Sentence


class CalibrationSession:
    """The pictures of one board before one sensor, and all that is done with them.

    To make one reads the disk and may compile: not for the window's thread. `see`, `add` and what
    changes the pictures belong to one thread; `keep`, `read_images` and `outcome` may run in
    another meanwhile.

    Parameters
    ----------
    sensor : CalibratedSensor
        Whose pictures these are.
    kept : KeptCalibrations
        Of this computer.
    board : Board
        That is held, where none was chosen before.

    Attributes
    ----------
    board : Board
        In use.
    pictures : tuple of KeptPicture
        Taken so far.
    guidance : Guidance
        What they lack.
    n_lost : int
        Pictures of before that are damaged.
    """

    def __init__(self, sensor: CalibratedSensor, kept: KeptCalibrations, board: Board) -> None:
        self.sensor = sensor
        self._kept = kept
        self._folder = PictureFolder(kept.pictures_folder(sensor.key, sensor.color_size))
        found: KeptPictures = self._folder.read()
        load_kernels()
        self.board = found.board or board
        self.n_lost = found.n_lost
        self._watch = MomentWatch(self.board, sensor.intrinsics)
        self._take(found.pictures)

    def is_of(self, sensor: CalibratedSensor) -> bool:
        """Say whether pictures of a sensor belong here."""
        mine = self.sensor
        return (mine.key, mine.color_size) == (sensor.key, sensor.color_size)

    def see(self, frame: LiveFrame) -> Moment:
        """Say of the next live frame whether it is a new picture; none of a board is kept yet."""
        return self._watch.see(frame, self._stances)

    def picture(self, frame: LiveFrame) -> NewPicture | None:
        """Return a live frame as a picture; None where the board is not seen in it."""
        return self._watch.picture(frame)

    def keep(self, picture: NewPicture) -> KeptPicture:
        """Write a picture to the disk, where it stays whatever happens; then `add` it.

        Raises
        ------
        FileError
            The disk is full, or the folder cannot be written.
        """
        return self._folder.keep(picture, self.board)

    def add(self, *pictures: KeptPicture) -> None:
        """Count pictures that were kept."""
        self._take((*self.pictures, *pictures))

    def remove(self, number: int) -> None:
        """Take one picture away for good.

        Raises
        ------
        FileError
            The folder cannot be written.
        """
        self._folder.remove(one for one in self.pictures if one.number == number)
        self._take(tuple(one for one in self.pictures if one.number != number))

    def start_anew(self) -> None:
        """Take all pictures away for good.

        Raises
        ------
        FileError
            The folder cannot be written.
        """
        self._folder.clear()
        self.n_lost = 0
        self._take(())

    def fits(self, board: Board) -> bool:
        """Say whether the pictures taken so far can be of this board: only its size differs."""
        same = (board.columns, board.rows) == (self.board.columns, self.board.rows)
        return same or not self.pictures

    def choose_board(self, board: Board) -> None:
        """Hold another board; pictures that cannot be of it are taken away.

        Raises
        ------
        FileError
            The disk is full, or the folder cannot be written.
        """
        if not self.fits(board):
            self.start_anew()
        self._folder.choose(board)
        self.board = board
        self._watch = MomentWatch(board, self.sensor.intrinsics)
        self._take(self.pictures)

    def read_images(
        self, paths: Sequence[Path], progress: Progress
    ) -> tuple[tuple[KeptPicture, ...], tuple[RefusedImage, ...]]:
        """Keep saved images as pictures; then `add` them.

        Returns
        -------
        pictures : tuple of KeptPicture
            Those that show the board.
        refused : tuple of RefusedImage
            The others.

        Raises
        ------
        FileError
            The disk is full, or the folder cannot be written.
        """
        taken: list[KeptPicture] = []
        refused: list[RefusedImage] = []
        for done, path in enumerate(paths):
            progress(done, len(paths))
            try:
                found: NewPicture | Sentence = self._saved(path)
            except AdibasError as error:
                found = Sentence(Message(error.message_id), error.fields)
            if isinstance(found, Sentence):
                refused.append(RefusedImage(path.name, found))
            else:
                taken.append(self.keep(found))
        return tuple(taken), tuple(refused)

    def outcome(self, clock: Clock = utc_now) -> SensorOutcome:
        """Fit, judge, and compare with the calibration before.

        Raises
        ------
        CalibrationError
            There is no picture, or a calibration of this sensor is damaged.
        """
        pictures, board, info = self.pictures, self.board, self.sensor.info
        camera = self._camera(pictures, board)
        fit = camera.fit
        if fit is None or not fit.is_settled:
            return SensorOutcome(camera, None, None, None)
        color = color_calibration(fit, self.sensor.key, clock, camera.method)
        depth: DepthOutcome | Verdict | None = None
        if has_depth_camera(info) and not _is_of_wrong_scale(camera):
            depth = calibrate_depth_of(pictures, board, color, info, clock)
            verdict = depth if isinstance(depth, Verdict) else depth.verdict
            camera = replace(camera, verdict=joined(camera.verdict, verdict))
        depth = None if isinstance(depth, Verdict) else depth
        calibration = self._joined(color, depth)
        previous = self._kept.newest(self.sensor.key, sizes_of(calibration))
        comparison = None if previous is None else compare(previous.calibration, calibration)
        return SensorOutcome(camera, calibration, previous, comparison, depth)

    def _camera(self, pictures: Sequence[KeptPicture], board: Board) -> CameraOutcome:
        """Fit and judge the colour camera, and judge again with what the depth says of scale."""
        searched = tuple(one.searched for one in pictures)
        camera = fit_searched(searched, board)
        if camera.fit is None or not camera.fit.is_settled:
            return camera
        checks = check_scales(pictures, board, camera.fit.camera, self.sensor.info)
        return judged(camera, checks) if checks else camera

    def accept(self, outcome: SensorOutcome, clock: Clock = utc_now) -> Path:
        """Keep what the pictures gave, for use from now on; the pictures have served and go.

        The session is over then.

        Raises
        ------
        CalibrationError
            It is not good enough, or nobody knows of which sensor the pictures are.
        FileError
            The disk is full, or the folder cannot be written.
        """
        calibration = outcome.calibration
        if calibration is None or not outcome.is_good_enough:
            raise CalibrationError(
                "This calibration cannot be used: {reason}",
                reason=" ".join(outcome.camera.verdict.sentences()[1:]),
            )
        if not self.sensor.key:
            raise CalibrationError(
                "Nobody knows which sensor these pictures are of. Save the calibration to a file."
            )
        path = self._kept.keep(replace(calibration, created_utc=to_text(clock())))
        self._folder.clear()
        return path

    def _joined(self, color: RgbdCalibration, depth: DepthOutcome | None) -> RgbdCalibration:
        """Return what is known of the sensor, with its cameras as they are now."""
        before = self.sensor.info.calibration
        if before is None:
            return replace(color, depth_unit_m=self.sensor.info.depth_unit_m)
        known = color if depth is None else depth.calibration
        joined = replace(
            before,
            color=color.color,
            rms_px=color.rms_px,
            parameter_names=known.parameter_names,
            covariance=known.covariance,
            sensor_serial=color.sensor_serial,
            created_utc=color.created_utc,
            valid_region=color.valid_region,
            corner_method=color.corner_method,
            gravity=known.gravity,  # not that of before: the sensor stands elsewhere
            floor=known.floor,
            gravity_sd_rad=known.gravity_sd_rad,
            floor_flatness_m=known.floor_flatness_m,
        )
        if depth is None:
            return joined
        return replace(
            joined,
            depth=known.depth,
            color_from_depth=known.color_from_depth,
            depth_bias=known.depth_bias,
        )

    def _take(self, pictures: tuple[KeptPicture, ...]) -> None:
        known = [(one, self._stance(one)) for one in pictures]
        self.pictures = tuple(one for one, stance in known if stance is not None)
        self._stances = [stance for _one, stance in known if stance is not None]
        corners = [one.corners for one in self.pictures]
        has_depth = [one.depth_file is not None for one in self.pictures]
        self.guidance: Guidance = guide(
            corners,
            self._stances,
            has_depth=has_depth if has_depth_camera(self.sensor.info) else None,
        )

    def _stance(self, picture: KeptPicture) -> Stance | None:
        return self._watch.stance_of(picture.corners)

    def _saved(self, path: Path) -> NewPicture | Sentence:
        """Return the picture in a file, or why there is none of this board."""
        color_rgb = read_picture(path)
        height, width = color_rgb.shape[:2]
        if (width, height) != self.sensor.color_size:
            wanted_width, wanted_height = self.sensor.color_size
            fields = {"wanted_width": wanted_width, "wanted_height": wanted_height}
            return Sentence(OTHER_SIZE, {"width": width, "height": height, **fields})
        searched = search_image(NamedImage(path.name, as_gray(color_rgb)), self.board)
        search = searched.search
        if search.problem is not None:
            return Sentence(TEXTS[search.problem], search.fields)
        if search.corners is not None and search.corners.is_mirrored:
            return Sentence(SENTENCES[Reason.MIRRORED])
        return NewPicture(color_rgb, searched)


def _is_of_wrong_scale(camera: CameraOutcome) -> bool:
    return any(finding.reason is Reason.SCALE for finding in camera.verdict.findings)


def images_in(chosen: Sequence[Path]) -> tuple[Path, ...]:
    """Return the images among files and folders that the user chose, by name within a folder.

    Raises
    ------
    CalibrationError
        There is none.
    """
    images: list[Path] = []
    for path in chosen:
        found = sorted(path.iterdir()) if path.is_dir() else [path]
        images += [one for one in found if one.suffix.lower() in PICTURE_SUFFIXES]
    if not images:
        raise CalibrationError(
            "There is no picture among these files. Choose PNG or JPEG pictures of the board."
        )
    return tuple(images)
