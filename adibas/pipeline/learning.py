"""From a click on a picture to learned colours on the disk."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import cv2

from adibas.arrays import BoolArray, UInt8Array
from adibas.data.frames import EncodedImage
from adibas.errors import FileError, RecordingError
from adibas.files import check_place, written_whole
from adibas.markers.color_files import preview, read_colors, write_colors
from adibas.markers.color_model import ColorModel, LearningParams
from adibas.markers.led import LedParams
from adibas.pipeline.learning_board import LearningBoard
from adibas.pipeline.posture import MarkerTarget
from adibas.recordings import open_recording
from adibas.recordings.decoding import decode_color

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg")
LED = "led"


@dataclass(frozen=True, slots=True)
class LearningRequest:
    """What to learn from.

    Attributes
    ----------
    image : Path
        A picture, or a recording.
    seeds : tuple of (u, v)
        Clicked pixels.
    frame : int
        Of a recording.
    sensitivity, n_clusters : float, int or None
        None: the defaults of `LearningParams`.
    """

    image: Path
    seeds: tuple[tuple[float, float], ...]
    frame: int = 0
    sensitivity: float | None = None
    n_clusters: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """The colours, the (H, W) pixels they come from, and the picture that shows these."""

    model: ColorModel
    taken: BoolArray
    preview_path: Path

    @property
    def n_pixels(self) -> int:
        """Return how many pixels were taken."""
        return int(self.taken.sum())

    @property
    def taken_share(self) -> float:
        """Return the share of the picture that was taken."""
        return float(self.taken.mean())


def read_target(text: str) -> MarkerTarget:
    """Return what ``--markers`` names: ``led``, or a file of learned colours.

    Raises
    ------
    MarkerError
        The file is missing or holds no colours.
    """
    return LedParams() if text == LED else read_colors(Path(text))


def learn_from_file(request: LearningRequest, out: Path) -> Learned:
    """Learn the colours of the clicked regions, and write them and a preview beside them.

    Raises
    ------
    FileError, RecordingError
        The picture cannot be read, or the colours cannot be written.
    MarkerError
        A click lies outside the picture.
    """
    preview_path = out.with_suffix(".preview.png")
    _check_out(request.image, out, preview_path)
    color_rgb = read_picture(request.image, request.frame)
    model, taken = learn_from_picture(color_rgb, request)
    _write_png(preview_path, preview(color_rgb, taken))
    write_colors(out, model)
    return Learned(model, taken, preview_path)


def learn_from_picture(
    color_rgb: UInt8Array, request: LearningRequest
) -> tuple[ColorModel, BoolArray]:
    """Grow a region from every click and learn their colours; also the (H, W) pixels taken."""
    params = LearningParams()
    if request.sensitivity is not None:
        params = replace(params, sensitivity=request.sensitivity)
    if request.n_clusters is not None:
        params = replace(params, n_clusters=request.n_clusters)
    board = LearningBoard(color_rgb, params)
    for u, v in request.seeds:
        board.click(u, v)
    model = board.model()
    if model is None:
        raise ValueError("learning needs a click")
    return model, board.taken()


def _check_out(image: Path, out: Path, preview_path: Path) -> None:
    """See that nothing else is overwritten than colours and their preview."""
    if out.suffix.lower() != ".json":
        raise FileError(
            "{file} is no name for learned colours. Give --out a name that ends in .json.",
            file=out.name or str(out),
        )
    if preview_path.exists() and image.exists() and preview_path.samefile(image):
        raise FileError(
            "The preview of {file} would overwrite the picture itself. Give --out another name.",
            file=out.name,
        )
    check_place(out)


def read_picture(path: Path, frame: int = 0) -> UInt8Array:
    """Read a PNG or JPEG picture, or the colour of one frame of a recording, (H, W, 3) RGB.

    Raises
    ------
    FileError, RecordingError
        The picture or the frame cannot be read.
    """
    if path.suffix.lower() not in PICTURE_SUFFIXES:
        return _read_frame(path, frame)
    try:
        payload = path.read_bytes()
    except OSError as error:
        raise FileError(
            "{file} cannot be read: {reason}. Check the name of the picture.",
            file=path.name,
            reason=error.strerror or str(error),
        ) from error
    encoding: Literal["png", "jpeg"] = "png" if path.suffix.lower() == ".png" else "jpeg"
    try:
        return decode_color(EncodedImage(encoding, payload), sequence=0)
    except RecordingError as error:
        raise FileError(
            "{file} is no whole PNG or JPEG picture. Choose another one.", file=path.name
        ) from error


def _read_frame(path: Path, frame: int) -> UInt8Array:
    with open_recording(path) as recording:
        if not 0 <= frame < len(recording):
            raise RecordingError(
                "{file} has {n_frames} frames, and none with the number {frame}. Choose another "
                "with --frame.",
                file=path.name,
                n_frames=len(recording),
                frame=frame,
            )
        found = recording.read(frame)
    if found.color is None:
        raise RecordingError(
            "{file} has no colour in frame {frame}. Choose another frame.",
            file=path.name,
            frame=frame,
        )
    return decode_color(found.color, found.sequence)


def _write_png(path: Path, picture_rgb: UInt8Array) -> None:
    payload = cv2.imencode(".png", cv2.cvtColor(picture_rgb, cv2.COLOR_RGB2BGR))[1].tobytes()
    with written_whole(path) as unfinished:
        unfinished.write_bytes(payload)
