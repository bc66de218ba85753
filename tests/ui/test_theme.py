"""Colours that everybody can read and tell apart, letters of every size, and icons."""

import re
from dataclasses import fields

import numpy as np
import pytest
from PySide6.QtGui import QColor, QGuiApplication
from PySide6.QtWidgets import QApplication, QCheckBox, QMenu, QPushButton

from adibas.markers.lab import rgb_to_lab
from adibas.resources import resource_path
from ui.preferences import FONT_SCALES
from ui.theme import DARK, DRAWN, LIGHT, Theme, is_dark

CONTRAST_OF_TEXT, CONTRAST_OF_SIGNS = 7.0, 4.5
LEAST_DIFFERENCE = 12.0
"""CIE76; a step of 2.3 is just noticed."""

MACHADO = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
"""Linear RGB as seen. Source: Machado, Oliveira & Fernandes, IEEE TVCG 15(6), 2009, table 1."""

SEEN_TOGETHER = ("marker", "selected", "rejected", "corrected", "outline", "plumb")


def linear(color):
    rgb = np.array(QColor(color).getRgb()[:3]) / 255
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def contrast(one, other):
    """Return the ratio of WCAG 2.2, section 1.4.3."""
    brighter, darker = sorted(
        (linear(color) @ [0.2126, 0.7152, 0.0722] for color in (one, other)), reverse=True
    )
    return (brighter + 0.05) / (darker + 0.05)


def seen(color, matrix):
    """Return (L, a, b) of a colour as somebody sees it."""
    rgb = np.clip(np.array(matrix) @ linear(color), 0, 1)
    encoded = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)
    return rgb_to_lab(np.round(255 * encoded).astype(np.uint8).reshape(1, 1, 3))[0, 0]


@pytest.mark.parametrize("tokens", [LIGHT, DARK], ids=["light", "dark"])
def test_everything_written_can_be_read(tokens):
    for ground in (tokens.ground, tokens.raised, tokens.sunken):
        assert contrast(tokens.text, ground) >= CONTRAST_OF_TEXT
        for sign in (tokens.quiet, tokens.good, tokens.warning, tokens.bad, tokens.accent):
            assert contrast(sign, ground) >= CONTRAST_OF_SIGNS, (sign, ground)
    assert contrast(tokens.on_accent, tokens.accent) >= CONTRAST_OF_TEXT


@pytest.mark.parametrize("kind", MACHADO)
def test_the_colour_blind_tell_what_is_drawn_apart(kind):
    colors = [seen(DRAWN[role], MACHADO[kind]) for role in SEEN_TOGETHER]
    for index, one in enumerate(colors):
        for other, role in zip(colors[:index], SEEN_TOGETHER, strict=False):
            difference = np.linalg.norm(one - other)
            assert difference >= LEAST_DIFFERENCE, (kind, SEEN_TOGETHER[index], role, difference)


@pytest.fixture
def theme(qapp):
    theme = Theme(qapp)
    theme.use("light", 1.0)
    yield theme
    theme.use("light", 1.0)


@pytest.mark.parametrize("scale", FONT_SCALES)
def test_letters_grow_as_asked_and_from_the_same_size(theme, qapp, scale):
    before = qapp.font().pointSizeF()
    theme.use("dark", 2.0)
    theme.use("dark", scale)
    assert qapp.font().pointSizeF() == pytest.approx(before * scale)


def test_every_token_of_the_style_sheet_is_filled_in(theme, qapp, qtbot):
    for name, tokens in (("light", LIGHT), ("dark", DARK)):
        theme.use(name, 1.0)
        assert not re.search(r"@\w+@", qapp.styleSheet())
        assert all(
            getattr(tokens, one.name) in qapp.styleSheet()
            for one in fields(tokens)
            if one.name != "picture"
        )
    box = QCheckBox("word")
    qtbot.addWidget(box)
    box.setChecked(True)
    box.show()
    picture = box.grab().toImage()
    colors = {picture.pixelColor(x, y).name().upper() for x in range(20) for y in range(20)}
    assert DARK.accent in colors


def test_the_desktop_decides_where_the_user_leaves_it(monkeypatch):
    class Hints:
        def __init__(self, scheme):
            self.scheme = scheme

        def colorScheme(self):
            return self.scheme

    from PySide6.QtCore import Qt

    for scheme, told in ((Qt.ColorScheme.Dark, True), (Qt.ColorScheme.Light, False)):
        hints = Hints(scheme)
        monkeypatch.setattr(QGuiApplication, "styleHints", lambda hints=hints: hints)
        assert is_dark("system") is told
        assert is_dark("dark")
        assert not is_dark("light")


def height_of_arrow(theme, qtbot, scale):
    theme.use("light", scale)
    button = QPushButton()
    qtbot.addWidget(button)
    button.setMenu(QMenu(button))
    button.show()
    image = button.grab().toImage().copy(*ARROW_EDGES_PX, button.width() - 12, button.height() - 12)
    ground = QColor(LIGHT.raised)
    rows = [
        any(image.pixelColor(x, y) != ground for x in range(image.width()))
        for y in range(image.height())
    ]
    return sum(rows)


ARROW_EDGES_PX = (6, 6)
"""Within the border of a button that has the focus."""


def test_the_arrow_of_a_button_with_a_menu_grows_with_the_letters(theme, qtbot):
    usual, large = (height_of_arrow(theme, qtbot, scale) for scale in (1.0, 2.0))
    assert usual >= 4
    assert large >= 1.6 * usual


def test_icons_take_the_colour_of_the_theme(theme):
    names = [path.stem for path in resource_path("icons").glob("*.svg")]
    assert len(names) > 10
    for name in names:
        for kind, tokens in (("light", LIGHT), ("dark", DARK)):
            theme.use(kind, 1.0)
            image = theme.icon(name).pixmap(64, 64).toImage()
            colors = {
                image.pixelColor(x, y).name().upper()
                for x in range(64)
                for y in range(64)
                if image.pixelColor(x, y).alpha() == 255
            }
            assert tokens.text.upper() in colors, name
    assert QApplication.instance() is not None
