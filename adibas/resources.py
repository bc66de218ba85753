"""The only place that finds files of ``resources/``: source tree, wheel, frozen program."""

import sys
from functools import cache
from pathlib import Path


@cache
def _root() -> Path:
    frozen = getattr(sys, "_MEIPASS", None)
    if frozen is not None:
        return Path(frozen) / "resources"
    package = Path(__file__).parent
    installed = package / "_resources"
    return installed if installed.is_dir() else package.parent / "resources"


@cache
def resource_path(*parts: str) -> Path:
    """Return the path of a file or folder of ``resources/``; it need not exist.

    It is kept: every text that is translated asks for the folder of its catalogue.
    """
    return _root().joinpath(*parts)
