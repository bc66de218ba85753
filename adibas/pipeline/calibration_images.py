"""Saved images of a board that are taken as pictures of a calibration."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from adibas.calibration.finder import TEXTS, as_gray
from adibas.data.board import Board
from adibas.data.calibration_verdict import SENTENCES, Reason
from adibas.data.sentence import Sentence
from adibas.errors import AdibasError, CalibrationError
from adibas.pipeline.calibrating import NamedImage, search_image
from adibas.pipeline.calibration_pictures import NewPicture
from adibas.pipeline.learning import PICTURE_SUFFIXES, read_picture
from adibas.texts import Message, message

OTHER_SIZE = message("It has {width} x {height} pixels, not {wanted_width} x {wanted_height}.")


@dataclass(frozen=True, slots=True)
class RefusedImage:
    """A saved image that was not taken, and why."""

    name: str
    reason: Sentence


def read_board_image(
    path: Path, board: Board, color_size: tuple[int, int]
) -> NewPicture | RefusedImage:
    """Return the picture in a file; or why it is none of `board`, seen by a camera of that size."""
    try:
        found = _searched(path, board, color_size)
    except AdibasError as error:
        found = Sentence(Message(error.message_id), error.fields)
    return RefusedImage(path.name, found) if isinstance(found, Sentence) else found


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


def _searched(path: Path, board: Board, color_size: tuple[int, int]) -> NewPicture | Sentence:
    """Return the picture in a file, or why there is none of this board."""
    color_rgb = read_picture(path)
    height, width = color_rgb.shape[:2]
    if (width, height) != color_size:
        wanted_width, wanted_height = color_size
        fields = {"wanted_width": wanted_width, "wanted_height": wanted_height}
        return Sentence(OTHER_SIZE, {"width": width, "height": height, **fields})
    searched = search_image(NamedImage(path.name, as_gray(color_rgb)), board)
    search = searched.search
    if search.problem is not None:
        return Sentence(TEXTS[search.problem], search.fields)
    if search.corners is not None and search.corners.is_mirrored:
        return Sentence(SENTENCES[Reason.MIRRORED])
    return NewPicture(color_rgb, searched)
