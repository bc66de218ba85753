"""The pictures of a calibration in the making: each on the disk before the next one is taken.

A picture is there as soon as its document is: colour and depth are written before it, and it says
what they must be. So whatever ends the program, and whenever, costs no picture that was told of.
"""

import hashlib
import io
import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from adibas.arrays import UInt8Array
from adibas.data.board import Board, BoardCorners
from adibas.data.surface import BurstDisparity
from adibas.errors import FileError
from adibas.files import (
    DAMAGED_ARRAYS,
    DAMAGED_JSON,
    cannot_write,
    is_there,
    remove_unfinished,
    written_whole,
)
from adibas.pipeline.calibrating import SearchedImage
from adibas.pipeline.calibration_documents import (
    board_from_json,
    board_to_json,
    corners_to_json,
    searched_from_json,
    searched_to_json,
    still_from_json,
)

BOARD_FILE = "board.json"
PNG_EFFORT = 2
"""Of 0 to 9: lossless in any case; more costs time and saves little of a noisy picture."""

PREVIEW_WIDTH_PX = 160
_DAMAGED = (OSError, *DAMAGED_ARRAYS, *DAMAGED_JSON)
"""What reading a file raises that somebody or something has changed."""


@dataclass(frozen=True, slots=True, eq=False)
class NewPicture:
    """A picture before it is kept.

    Attributes
    ----------
    color_rgb : (H, W, 3) uint8 array
        As the camera gave it.
    searched : SearchedImage
        What was found in it; without a name it is called by its number.
    taken_ns : int
        By the sensor's clock.
    disparity : BurstDisparity or None
        Of the depth camera at that time, as measured; None where nothing says that board and
        camera stood still, or there is none.
    still_corners : BoardCorners or None
        Their mean over the time of that depth.
    """

    color_rgb: UInt8Array
    searched: SearchedImage
    taken_ns: int = 0
    disparity: BurstDisparity | None = None
    still_corners: BoardCorners | None = None


@dataclass(frozen=True, slots=True, eq=False)
class KeptPicture:
    """A picture on the disk.

    Attributes
    ----------
    number : int
        Counts up; its name for the reader.
    searched : SearchedImage
        What was found in it.
    taken_ns : int
        By the sensor's clock.
    color_file : Path
        PNG.
    depth_file : Path or None
        Where there is depth; see `read_disparity`.
    preview_rgb : (H', W', 3) uint8 array
        The same picture, small.
    still_corners : BoardCorners or None
        Their mean over the time of that depth.
    """

    number: int
    searched: SearchedImage
    taken_ns: int
    color_file: Path
    depth_file: Path | None
    preview_rgb: UInt8Array
    still_corners: BoardCorners | None = None

    @property
    def corners(self) -> BoardCorners:
        """Of the board."""
        corners = self.searched.search.corners
        if corners is None:
            raise ValueError("only pictures of a board are kept")
        return corners


@dataclass(frozen=True, slots=True, eq=False)
class KeptPictures:
    """What a folder holds.

    Attributes
    ----------
    board : Board or None
        That was chosen last; None where nothing was begun.
    pictures : tuple of KeptPicture
        In the order in which they were taken.
    n_lost : int
        Pictures that are damaged, and left out.
    """

    board: Board | None
    pictures: tuple[KeptPicture, ...]
    n_lost: int = 0


class PictureFolder:
    """Keeps pictures of one board before one sensor.

    Parameters
    ----------
    folder : Path
        Made when something is kept.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def read(self) -> KeptPictures:
        """Return what is there; what is damaged is left out and counted."""
        if not is_there(self.folder):
            return KeptPictures(None, ())
        documents = sorted(self.folder.glob("[0-9]*.json"))
        read = [_read_picture(path) for path in documents]
        known = [one for one in read if one is not None]
        board = self._board() or next((board for board, _picture in known), None)
        fitting = tuple(picture for one, picture in known if _is_like(one, board))
        return KeptPictures(board, fitting, len(documents) - len(fitting))

    def choose(self, board: Board) -> None:
        """Note which board is held.

        Raises
        ------
        FileError
            The disk is full, or the folder cannot be written.
        """
        _write_json(self.folder / BOARD_FILE, board_to_json(board))

    def keep(self, picture: NewPicture, board: Board) -> KeptPicture:
        """Write a picture of a board.

        Raises
        ------
        FileError
            The disk is full, or the folder cannot be written.
        """
        number = self._next_number()
        color = _png(picture.color_rgb)
        color_file = self.folder / f"{number:04d}.png"
        depth_file = None
        searched = _named(picture.searched, str(number))
        document = searched_to_json(searched, board) | {
            "taken_ns": picture.taken_ns,
            "color_sha256": hashlib.sha256(color).hexdigest(),
        }
        with written_whole(color_file) as unfinished:
            unfinished.write_bytes(color)
        if picture.disparity is not None:
            depth_file = self.folder / f"{number:04d}.npz"
            with written_whole(depth_file) as unfinished:
                _write_disparity(unfinished, picture.disparity)
            document["depth_sha256"] = _digest(depth_file)
        if picture.still_corners is not None:
            document["still"] = corners_to_json(picture.still_corners)
        _write_json(_document_of(color_file), document)
        return KeptPicture(
            number,
            searched,
            picture.taken_ns,
            color_file,
            depth_file,
            _preview(picture.color_rgb),
            picture.still_corners,
        )

    def remove(self, pictures: Iterable[KeptPicture]) -> None:
        """Take pictures away for good.

        Raises
        ------
        FileError
            The folder cannot be written.
        """
        for picture in pictures:
            try:
                _document_of(picture.color_file).unlink(missing_ok=True)
                picture.color_file.unlink(missing_ok=True)
                if picture.depth_file is not None:
                    picture.depth_file.unlink(missing_ok=True)
            except OSError as error:
                raise cannot_write(picture.color_file, error) from error

    def clear(self) -> None:
        """Take everything away, what a crash left half done and what is damaged, too.

        Raises
        ------
        FileError
            The folder cannot be written.
        """
        if not is_there(self.folder):
            return
        try:
            for pattern in ("[0-9]*.json", "[0-9]*.png", "[0-9]*.npz"):
                for path in sorted(self.folder.glob(pattern)):
                    path.unlink(missing_ok=True)
            remove_unfinished(self.folder)
        except OSError as error:
            raise cannot_write(self.folder, error) from error

    def _next_number(self) -> int:
        """Return a number that no file has, of a damaged picture neither."""
        stems = (path.stem for path in self.folder.glob("[0-9]*.*"))
        return max((int(stem) for stem in stems if stem.isdecimal()), default=0) + 1

    def _board(self) -> Board | None:
        try:
            return board_from_json(_read_json(self.folder / BOARD_FILE))
        except _DAMAGED:
            return None


def read_disparity(picture: KeptPicture) -> BurstDisparity | None:
    """Return the depth of a picture, as measured; None where it has none.

    Raises
    ------
    FileError
        The file is gone or damaged.
    """
    if picture.depth_file is None:
        return None
    try:
        data = io.BytesIO(picture.depth_file.read_bytes())  # np.load leaves a damaged file open
        with np.load(data, allow_pickle=False) as arrays:
            return BurstDisparity(
                arrays["mean_per_m"],
                arrays["n_readings"].astype(np.int64),
                int(arrays["n_frames"]),
            )
    except _DAMAGED as error:
        raise FileError(
            "The depth of picture {number} cannot be read. Remove the picture and take another.",
            number=picture.number,
        ) from error


def _read_picture(path: Path) -> tuple[Board, KeptPicture] | None:
    """Return a picture and the board that it is of; None where anything of it is damaged."""
    color_file, depth_file = path.with_suffix(".png"), path.with_suffix(".npz")
    try:
        document = _read_json(path)
        color = color_file.read_bytes()
        has_depth = "depth_sha256" in document
        is_whole = hashlib.sha256(color).hexdigest() == document["color_sha256"] and (
            not has_depth or _digest(depth_file) == document["depth_sha256"]
        )
        if not is_whole:
            return None
        board, searched = board_from_json(document["board"]), searched_from_json(document)
        color_bgr = cv2.imdecode(np.frombuffer(color, np.uint8), cv2.IMREAD_COLOR)
        if color_bgr is None or color_bgr.shape[:2] != searched.size:
            return None
        preview = _preview(cv2.cvtColor(color_bgr, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False))
        return board, KeptPicture(
            int(path.stem),
            searched,
            int(document["taken_ns"]),
            color_file,
            depth_file if has_depth else None,
            preview,
            still_from_json(document),
        )
    except (*_DAMAGED, cv2.error):
        return None


def _named(searched: SearchedImage, name: str) -> SearchedImage:
    """Return the same with a name, if it has none."""
    corners = searched.search.corners
    if searched.name or corners is None:
        return searched
    return replace(
        searched, name=name, search=replace(searched.search, corners=replace(corners, image=name))
    )


def _is_like(one: Board, other: Board | None) -> bool:
    return other is not None and (one.columns, one.rows) == (other.columns, other.rows)


def _document_of(color_file: Path) -> Path:
    return color_file.with_suffix(".json")


def _png(color_rgb: UInt8Array) -> bytes:
    bgr = cv2.cvtColor(color_rgb, cv2.COLOR_RGB2BGR)
    _is_written, data = cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, PNG_EFFORT])
    return data.tobytes()


def _write_disparity(path: Path, disparity: BurstDisparity) -> None:
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            mean_per_m=disparity.mean_per_m,
            n_readings=disparity.n_readings.astype(np.int32),
            n_frames=np.int64(disparity.n_frames),
        )


def _preview(color_rgb: UInt8Array) -> UInt8Array:
    height, width = color_rgb.shape[:2]
    size = (PREVIEW_WIDTH_PX, max(1, round(height * PREVIEW_WIDTH_PX / width)))
    small = cv2.resize(color_rgb, size, interpolation=cv2.INTER_AREA)
    return small.astype(np.uint8, copy=False)


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _write_json(path: Path, document: dict[str, Any]) -> None:
    with written_whole(path) as unfinished:
        unfinished.write_text(json.dumps(document), encoding="utf-8")


def _read_json(path: Path) -> dict[str, Any]:
    document = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(document, dict):
        raise ValueError(f"{path.name} holds no document")  # noqa: TRY004  (a damaged file)
    return document
