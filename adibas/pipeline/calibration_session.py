"""One calibration in the making: pictures of a board, what they lack, what they give."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from adibas.calibration.guidance import Guidance, Stance, guide
from adibas.calibration.kept import KeptCalibrations
from adibas.clock import Clock, to_text, utc_now
from adibas.data.board import Board
from adibas.errors import CalibrationError
from adibas.pipeline.calibrating_pictures import has_depth_camera
from adibas.pipeline.calibration_images import RefusedImage, read_board_image
from adibas.pipeline.calibration_pictures import (
    KeptPicture,
    KeptPictures,
    NewPicture,
    PictureFolder,
)
from adibas.pipeline.calibration_watch import Moment, MomentWatch, load_kernels
from adibas.pipeline.live_frames import LiveFrame
from adibas.pipeline.sensor_calibration import CalibratedSensor, SensorOutcome, calibrate_sensor
from adibas.progress import Progress


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
        return (mine.key, mine.color_size, mine.rotation_deg) == (
            *(sensor.key, sensor.color_size, sensor.rotation_deg),
        )

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
            found = read_board_image(path, self.board, self.sensor.color_size)
            if isinstance(found, RefusedImage):
                refused.append(found)
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
        return calibrate_sensor(self.pictures, self.board, self.sensor, self._kept, clock)

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
