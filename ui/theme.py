"""How the window looks: light, dark, and drawn colours that the colour-blind tell apart."""

from dataclasses import dataclass
from functools import cache

from PySide6.QtCore import QByteArray, QSize, Qt
from PySide6.QtGui import QColor, QFont, QGuiApplication, QIcon, QPainter, QPalette, QPixmap
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QApplication

from adibas.resources import resource_path
from ui.widgets.overlays import Role

DRAWN: dict[Role, str] = {
    "marker": "#56B4E9",
    "selected": "#F0E442",
    "rejected": "#D55E00",
    "corrected": "#CC79A7",
    "outline": "#009E73",
    "plumb": "#E69F00",
    "measure": "#F0E442",
    "focus": "#FFFFFF",
    "earlier": "#56B4E9",
    "later": "#E69F00",
    "bone": "#009E73",
    "markerless": "#CC79A7",
}
"""On pictures. Source: Okabe & Ito, Color Universal Design (2008)."""

PICTURE_GROUND = "#11161B"
"""Beside pictures and around what is drawn on them, in both themes."""
SWATCH_BORDER = "#808A94"
"""Seen on black and on white, in both themes."""


@dataclass(frozen=True, slots=True)
class Tokens:
    """The colours of one theme; text on its ground has a contrast of 7 or more."""

    ground: str
    raised: str
    sunken: str
    text: str
    quiet: str
    line: str
    accent: str
    on_accent: str
    good: str
    warning: str
    bad: str
    picture: str


LIGHT = Tokens(
    ground="#F4F6F8",
    raised="#FFFFFF",
    sunken="#E8ECF0",
    text="#16212B",
    quiet="#4A5A68",
    line="#C3CCD4",
    accent="#0B5C8A",
    on_accent="#FFFFFF",
    good="#0B6B3A",
    warning="#7A4B00",
    bad="#9B1C1C",
    picture="#1B2229",
)
DARK = Tokens(
    ground="#171C21",
    raised="#20272E",
    sunken="#12161A",
    text="#EAF0F5",
    quiet="#B3C0CB",
    line="#3B4651",
    accent="#6CC0F0",
    on_accent="#0B1620",
    good="#6FD79A",
    warning="#F2BE5C",
    bad="#FF9B93",
    picture="#0C0F12",
)


def is_dark(theme: str) -> bool:
    """Say whether `theme` (light, dark, system) means the dark one here and now."""
    if theme == "system":
        return QGuiApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark
    return theme == "dark"


DRAWN_BY_STYLE = ("check", "close", "down", "float", "right", "up")
"""Small pictures of the style sheet, one of each for each theme."""
LEAST_FONT_PT = 10.5
TITLE_SHARE = 1.6


class Theme:
    """Dresses the application; widgets ask it for what they paint themselves."""

    def __init__(self, app: QApplication) -> None:
        self._app = app
        self._font_pt = max(app.font().pointSizeF(), LEAST_FONT_PT)
        self.tokens = LIGHT
        app.setStyle("Fusion")

    def use(self, theme: str, font_scale: float) -> None:
        """Take a theme and a size of letters."""
        self.tokens = DARK if is_dark(theme) else LIGHT
        font = QFont(self._app.font())
        font.setPointSizeF(self._font_pt * font_scale)
        self._app.setFont(font)
        self._app.setPalette(_palette(self.tokens))
        self._app.setStyleSheet(_style_sheet(self.tokens, font.pointSizeF()))
        _rendered.cache_clear()

    def icon(self, name: str, color: str | None = None) -> QIcon:
        """Return an icon of ``resources/icons`` in a colour of the theme (usually the text's)."""
        icon = QIcon()
        icon.addPixmap(_rendered(name, color or self.tokens.text))
        icon.addPixmap(_rendered(name, self.tokens.line), QIcon.Mode.Disabled)
        return icon


@cache
def _rendered(name: str, color: str, size_px: int = 64) -> QPixmap:
    svg = resource_path("icons", f"{name}.svg").read_text(encoding="utf-8")
    renderer = QSvgRenderer(QByteArray(svg.replace("currentColor", color).encode()))
    pixmap = QPixmap(QSize(size_px, size_px))
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    renderer.render(painter)
    painter.end()
    return pixmap


def _palette(tokens: Tokens) -> QPalette:
    palette = QPalette()
    role = QPalette.ColorRole
    for which, color in (
        (role.Window, tokens.ground),
        (role.WindowText, tokens.text),
        (role.Base, tokens.raised),
        (role.AlternateBase, tokens.sunken),
        (role.Text, tokens.text),
        (role.PlaceholderText, tokens.quiet),
        (role.Button, tokens.raised),
        (role.ButtonText, tokens.text),
        (role.Highlight, tokens.accent),
        (role.HighlightedText, tokens.on_accent),
        (role.ToolTipBase, tokens.raised),
        (role.ToolTipText, tokens.text),
        (role.Link, tokens.accent),
        (role.Mid, tokens.line),
    ):
        palette.setColor(which, QColor(color))
    for which in (role.WindowText, role.Text, role.ButtonText):
        palette.setColor(QPalette.ColorGroup.Disabled, which, QColor(tokens.quiet))
    return palette


def _style_sheet(tokens: Tokens, font_pt: float) -> str:
    sheet = resource_path("style", "window.qss").read_text(encoding="utf-8")
    sheet = sheet.replace("@title_pt@", f"{TITLE_SHARE * font_pt:.1f}")
    theme = "dark" if tokens is DARK else "light"
    for picture in DRAWN_BY_STYLE:
        path = resource_path("style", f"{picture}-{theme}.svg")
        sheet = sheet.replace(f"@{picture}@", path.as_posix())
    for name in Tokens.__dataclass_fields__:
        sheet = sheet.replace(f"@{name}@", getattr(tokens, name))
    return sheet
