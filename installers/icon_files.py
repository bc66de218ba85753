"""Draws the program's icon in the sizes and formats that the systems want."""

import sys
from pathlib import Path

from PIL import Image
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPainter
from PySide6.QtSvg import QSvgRenderer

from installers.bundle import ROOT

FOLDER = Path(__file__).parent / "icons"
BUILT = ROOT / "build" / "icons"
SIZES = (16, 24, 32, 48, 64, 128, 256, 512)
LARGEST_OF_WINDOWS = 256


def drawn(source: Path, size: int) -> Image.Image:
    """Return a drawing of `size` pixels on each side."""
    image = QImage(size, size, QImage.Format.Format_RGBA8888)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    QSvgRenderer(str(source)).render(painter)
    painter.end()
    return Image.frombytes("RGBA", (size, size), bytes(image.constBits()))


def icon_of_this_system() -> str | None:
    """Write the icon that goes into the program itself, and return its path; Linux has none."""
    endings = {"win32": ".ico", "darwin": ".icns"}
    if sys.platform not in endings:
        return None
    BUILT.mkdir(parents=True, exist_ok=True)
    path = BUILT / f"adibas{endings[sys.platform]}"
    write_icon(path)
    return str(path)


def write_icon(path: Path) -> None:
    """Write one file with the icon in many sizes; its ending says the format."""
    largest = max(SIZES)
    image = drawn(FOLDER / "adibas.svg", largest)
    if path.suffix == ".ico":
        image.save(path, sizes=[(size, size) for size in SIZES if size <= LARGEST_OF_WINDOWS])
    else:
        image.save(path)
