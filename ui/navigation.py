"""The rail at the left: one button a screen."""

from collections.abc import Callable

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QKeySequence, QResizeEvent
from PySide6.QtWidgets import QButtonGroup, QToolButton, QVBoxLayout, QWidget

from adibas.texts import message
from adibas.texts import translate as _
from ui.theme import Theme
from ui.widgets.look import set_look

TITLES = {
    "patients": message("Patients"),
    "capture": message("Capture"),
    "markers": message("Markers"),
    "review": message("Review"),
    "reports": message("Reports"),
    "comparison": message("Compare"),
    "behaviour": message("Observe"),
    "calibration": message("Calibration"),
    "settings": message("Settings"),
}
FIRST_BELOW = "calibration"
"""From here on at the bottom: what is seldom needed."""

OTHERS = {"help": (message("Help"), "F1"), "lock": (message("Lock"), "Ctrl+L")}
"""Buttons that show no screen, and their keys."""

ICON_PX, LOW_ICON_PX = 24, 20
LARGE_LETTERS_PX = 26
"""Letters that high stand alone, or the rail is higher than the window."""

LEAST_WIDTH_PX = 86
SPACING_PX = 3
MARGIN_PX = 8
LOW_MARGIN_PX = 4
PADDING_PX = 20
"""Left and right of a name together, as the style sheet sets it, and some air."""


class NavigationRail(QWidget):
    """Buttons with icon and name: Ctrl+1 to Ctrl+9, F1, Ctrl+L.

    Where the window is too low for them they move together, so that it may be as low as the
    screens allow.
    """

    def __init__(self, theme: Theme, choose: Callable[[str], None], parent: QWidget | None) -> None:
        super().__init__(parent)
        self.setObjectName("rail")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._theme = theme
        self._group = QButtonGroup(self)
        self._buttons: dict[str, QToolButton] = {}
        self._reasons: dict[str, str] = {}
        self._is_low = self._is_tight = False
        self._button_px = dict.fromkeys((False, True), 0)
        layout = self._column = QVBoxLayout(self)
        layout.setSizeConstraint(QVBoxLayout.SizeConstraint.SetNoConstraint)
        for number, name in enumerate(TITLES, 1):
            button = self._button(name)
            button.setShortcut(QKeySequence(f"Ctrl+{number}"))
            button.setCheckable(True)
            button.clicked.connect(lambda _checked, name=name: choose(name))
            self._group.addButton(button)
            if name == FIRST_BELOW:
                layout.addStretch()
            button.hide()
            layout.addWidget(button)
            self._buttons[name] = button
        self._others = {name: self._button(name) for name in OTHERS}
        for name, button in self._others.items():
            button.setShortcut(QKeySequence(OTHERS[name][1]))
            button.clicked.connect(lambda _checked, name=name: choose(name))
            layout.addWidget(button)
        self.retranslate()
        self.dress()

    def _button(self, name: str) -> QToolButton:
        button = QToolButton(self)
        button.setObjectName(f"go-{name}")
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        return button

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        titles = TITLES | {name: title for name, (title, _key) in OTHERS.items()}
        for name, button in self._all():
            title = _(titles[name])
            shortcut = button.shortcut()
            button.setText(title)
            button.setShortcut(shortcut)  # a new text takes the shortcut away
            keys = shortcut.toString(QKeySequence.SequenceFormat.NativeText)
            reason = self._reasons.get(name, "")
            button.setToolTip(reason or f"{title} ({keys})")
            button.setAccessibleDescription(reason)
            button.setAccessibleName(title)
        self._fit()

    def dress(self) -> None:
        """Draw the icons in the theme in use."""
        for name, button in self._all():
            button.setIcon(self._theme.icon(name))
        self._fit()

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        """Return the size with the buttons together."""
        return QSize(self._column.minimumSize().width(), self._height_px(is_low=True))

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        """Move the buttons together, or apart."""
        super().resizeEvent(event)
        self._stand()

    def _stand(self) -> None:
        if self._lacks_height() != self._is_low:
            self._space()

    def _lacks_height(self) -> bool:
        return self.height() < self._height_px(is_low=False)

    def _space(self) -> None:
        """Set what lies about names and icons, as the height allows."""
        self._is_low = self._lacks_height()
        margin_px, spacing_px = self._air_px(is_low=self._is_low)
        self._column.setContentsMargins(MARGIN_PX, margin_px, MARGIN_PX, margin_px)
        self._column.setSpacing(spacing_px)
        for _name, button in self._all():
            _give_room(button, is_low=self._is_low)

    def _air_px(self, *, is_low: bool) -> tuple[int, int]:
        """Return what is above and below all buttons, and between two of them."""
        return (LOW_MARGIN_PX, 0) if is_low or self._is_tight else (MARGIN_PX, SPACING_PX)

    def _height_px(self, *, is_low: bool) -> int:
        """Return how high the rail is with the buttons that are offered."""
        n_buttons = sum(not button.isHidden() for _name, button in self._all())
        margin_px, spacing_px = self._air_px(is_low=is_low)
        return 2 * margin_px + n_buttons * (self._button_px[is_low] + spacing_px) - spacing_px

    def _fit(self) -> None:
        """Make room for the longest name in the language and letters in use."""
        buttons = [button for _name, button in self._all()]
        width_px = LEAST_WIDTH_PX
        for button in buttons:
            button.ensurePolished()
            text_px = button.fontMetrics().horizontalAdvance(button.text())
            width_px = max(width_px, text_px + PADDING_PX)
        letters_px = max(button.fontMetrics().height() for button in buttons)
        self._is_tight = letters_px > LARGE_LETTERS_PX
        style = Qt.ToolButtonStyle
        for button in buttons:
            button.setMinimumWidth(width_px)
            button.setToolButtonStyle(
                style.ToolButtonTextOnly if self._is_tight else style.ToolButtonTextUnderIcon
            )
        for is_low in (False, True):
            _give_room(buttons[0], is_low=is_low)
            self._button_px[is_low] = buttons[0].sizeHint().height()
        self._space()
        self.updateGeometry()

    def _all(self) -> tuple[tuple[str, QToolButton], ...]:
        return (*self._buttons.items(), *self._others.items())

    def show_button(self, name: str) -> None:
        """Offer a screen."""
        self._buttons[name].show()
        self._stand()
        self.updateGeometry()

    def keep_button(self, name: str, reason: str) -> None:
        """Disable a button for a reason, or enable it where there is none."""
        self._reasons[name] = reason
        self._buttons[name].setEnabled(not reason)
        self.retranslate()

    def show_chosen(self, name: str) -> None:
        """Mark the screen that is seen."""
        self._buttons[name].setChecked(True)


def _give_room(button: QToolButton, *, is_low: bool) -> None:
    icon_px = LOW_ICON_PX if is_low else ICON_PX
    button.setIconSize(QSize(icon_px, icon_px))
    set_look(button, "room", "little" if is_low else "")
