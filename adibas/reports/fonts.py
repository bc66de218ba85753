"""The font of pictures and PDF reports: DejaVu Sans, which matplotlib brings.

It covers Latin, Greek and Cyrillic. What it lacks is shown as an empty box.
"""

import importlib.util
from functools import cache
from pathlib import Path

from PIL import ImageFont

REGULAR = "DejaVuSans"
BOLD = "DejaVuSans-Bold"


@cache
def font_path(name: str) -> Path:
    """Return the TrueType file of `REGULAR` or `BOLD`, without importing matplotlib."""
    spec = importlib.util.find_spec("matplotlib")
    if spec is None or not spec.submodule_search_locations:
        raise RuntimeError("matplotlib, which brings the font, is not installed")
    return Path(spec.submodule_search_locations[0], "mpl-data", "fonts", "ttf", f"{name}.ttf")


@cache
def picture_font(size_px: int) -> ImageFont.FreeTypeFont:
    """Return the regular font for text of that height in a picture."""
    return ImageFont.truetype(font_path(REGULAR), size_px)
