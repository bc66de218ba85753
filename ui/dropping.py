"""Which screen takes a file that was dropped onto the window. Knows nothing of Qt."""

from pathlib import Path

from adibas.errors import FileError

RECORDINGS = (".mcap", ".oni")
PICTURES = (".png", ".jpg", ".jpeg")


def screen_for(dropped: tuple[Path, ...], shown: str = "") -> str:
    """Return the name of the screen that opens what was dropped onto the one that is `shown`.

    Raises
    ------
    FileError
        It is more than one file, or of a kind that no screen opens.
    """
    if len(dropped) != 1:
        raise FileError("Only one file can be opened at a time. Drop one recording or one picture.")
    (path,) = dropped
    kind = path.suffix.lower()
    if kind in RECORDINGS or path.is_dir():
        return "behaviour" if shown == "behaviour" else "capture"
    if kind in PICTURES:
        return "markers"
    raise FileError(
        "{file} is neither a recording nor a picture. Drop an .mcap or .oni file, a folder with "
        "rgb.txt or depth.txt, or a PNG or JPEG picture.",
        file=path.name,
    )
