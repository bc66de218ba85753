"""The only place that finds files of ``resources/``: source tree, wheel, frozen program."""

import sys
from functools import cache
from pathlib import Path


@cache  # asked for every text that is translated
def _root() -> Path:
    frozen = getattr(sys, "_MEIPASS", None)
    if frozen is not None:
        return Path(frozen) / "resources"
    package = Path(__file__).parent
    installed = package / "_resources"
    return installed if installed.is_dir() else package.parent / "resources"


def resource_path(*parts: str) -> Path:
    """Return the path of a file or folder of ``resources/``; it need not exist."""
    return _root().joinpath(*parts)
