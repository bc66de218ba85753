"""The pictures of the window in the manual: which there are, and how they are kept.

`installers.screenshots --manual` draws them, in each language. As WebP one takes some 30 KB where
the PNG of docs/screenshots takes 200.
"""

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

from PIL import Image
from PySide6.QtCore import QBuffer, QIODevice
from PySide6.QtGui import QPixmap

from installers.bundle import ROOT

MANUAL = ROOT / "docs" / "manual"
PICTURES = (
    "patients",
    "capture",
    "markers",
    "review",
    "reports",
    "comparison-1",
    "comparison-2",
    "comparison-3",
    "comparison-5",
    "behaviour",
    "calibration",
    "settings-2",
)
"""By the names that `installers.studio` gives them."""

QUALITY = 72


def picture_path(language: str, name: str) -> Path:
    """Return the file of a picture in one language."""
    return MANUAL / language / "pictures" / f"{name}.webp"


def save_picture(picture: QPixmap, language: str, name: str) -> Iterator[Path]:
    """Keep a picture of the window, if the manual shows it; yield its file."""
    if name not in PICTURES:
        return
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    picture.save(buffer, "PNG")
    path = picture_path(language, name)
    path.parent.mkdir(parents=True, exist_ok=True)
    image = Image.open(BytesIO(buffer.data().data())).convert("RGB")
    image.save(path, "WEBP", quality=QUALITY, method=6)
    yield path
