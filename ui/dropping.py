"""Which screen takes a file that was dropped onto the window. Knows nothing of Qt."""

from pathlib import Path

from adibas.errors import FileError
from adibas.recordings import is_named_like_recording

PICTURES = (".png", ".jpg", ".jpeg")


def screen_for(dropped: tuple[Path, ...], shown: str = "") -> str:
    """Return the name of the screen that opens what was dropped onto the one that is `shown`.

    Several recordings are watched one after another where behaviour is observed.

    Raises
    ------
    FileError
        It is more than one file, or of a kind that no screen opens.
    """
    if shown == "behaviour" and dropped and all(map(_is_recording, dropped)):
        return "behaviour"
    if len(dropped) != 1:
        raise FileError("Only one file can be opened at a time. Drop one recording or one picture.")
    (path,) = dropped
    if _is_recording(path):
        return "capture"
    if path.suffix.lower() in PICTURES:
        return "markers"
    raise FileError(
        "{file} is neither a recording nor a picture. Drop an .mcap or .oni file, a folder with "
        "rgb.txt or depth.txt, or a PNG or JPEG picture.",
        file=path.name,
    )


def _is_recording(path: Path) -> bool:
    return is_named_like_recording(path) or path.is_dir()
