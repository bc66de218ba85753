"""The gestures that this user taught the program: one model each, kept for every later day.

And which models somebody means who wants those, or the program's own.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias
from urllib.parse import unquote

import platformdirs

from adibas.files import remove_file

if TYPE_CHECKING:  # the window lists them before anything is compiled
    from adibas.gestures.model import GestureModel

GestureChoice: TypeAlias = Literal["none", "shipped", "own"]
"""No gestures, those of the program, those that were learned on this computer."""
ENDING = ".json"
UNNAMED = "gesture"
PORTS = {f"{kind}{number}" for kind in ("COM", "LPT") for number in "123456789\u00b9\u00b2\u00b3"}
DEVICES = {"CON", "PRN", "AUX", "NUL"} | PORTS
"""No file of Windows has such a name. Source: Microsoft, Naming Files, Paths, and Namespaces."""


@dataclass(frozen=True, slots=True)
class OwnGesture:
    """A gesture, and the file of its model."""

    name: str
    path: Path


def own_gestures() -> tuple[OwnGesture, ...]:
    """Return what was learned up to now, by name; nothing where the folder cannot be read."""
    try:
        paths = sorted(_folder().glob(f"*{ENDING}"))
    except OSError:
        return ()
    return tuple(OwnGesture(unquote(path.stem), path) for path in paths)


def models_of(choice: GestureChoice) -> tuple[Path, ...]:
    """Return the models of the gestures that are to be found."""
    if choice == "none":
        return ()
    if choice == "own":
        return tuple(one.path for one in own_gestures())
    from adibas.gestures.model_file import shipped_gestures

    return (shipped_gestures(),)


def keep_gesture(name: str, model: "GestureModel") -> OwnGesture:
    """Keep the model of a gesture; it takes the place of the one of the same name.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    from adibas.gestures.model_file import write_model

    kept = name.strip() or UNNAMED
    path = _folder() / f"{_stem(kept)}{ENDING}"
    write_model(path, model)
    return OwnGesture(kept, path)


def forget_gesture(gesture: OwnGesture) -> None:
    """Remove a gesture; one that is gone already is no mistake.

    Raises
    ------
    FileError
        It cannot be removed.
    """
    remove_file(gesture.path)


def _stem(name: str) -> str:
    """Return a name that every system takes for a file; `unquote` gives back the gesture's.

    What is no letter, digit, space, hyphen or underscore is written as in web addresses, and so is
    the first letter of what Windows keeps for devices.
    """
    plain = "".join(one if one.isalnum() or one in " -_" else _in_bytes(one) for one in name)
    return _in_bytes(plain[0]) + plain[1:] if plain.upper() in DEVICES else plain


def _in_bytes(letter: str) -> str:
    return "".join(f"%{byte:02X}" for byte in letter.encode("utf-8", "replace"))


def _folder() -> Path:
    return platformdirs.user_data_path("adibas", appauthor=False) / "models" / "gestures"
