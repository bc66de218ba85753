"""How the program looks and speaks, and how it captures."""

from functools import partial

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QWidget,
)

from adibas.texts import LANGUAGES, message, translate_plural
from adibas.texts import translate as _
from ui.preferences import FONT_SCALES, THEMES, Preferences
from ui.settings.preference_page import PreferencePage
from ui.widgets.number_fields import WholeNumberField

MOST_DAYS = 3650
THEME_NAMES = {
    "system": message("As the desktop"),
    "light": message("Light"),
    "dark": message("Dark"),
}


class GeneralPage(PreferencePage):
    """A form; every change counts at once."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._language, self._theme, self._scale = (QComboBox(self) for _ in range(3))
        self._operator, self._person = QLineEdit(self), ""
        self._countdown, self._frames, self._days = (WholeNumberField(self) for _ in range(3))
        self._countdown.setRange(0, 60)
        self._frames.setRange(1, 300)
        self._days.setRange(1, MOST_DAYS)
        self._sound = QCheckBox(self)
        self._labels = {
            widget: QLabel(self)
            for widget in (
                self._language,
                self._theme,
                self._scale,
                self._operator,
                self._countdown,
                self._frames,
                self._days,
            )
        }
        form = QFormLayout(self)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        form.setSpacing(12)
        for widget, label in self._labels.items():
            label.setBuddy(widget)
            form.addRow(label, widget)
        form.addRow("", self._sound)
        for language, own_name in LANGUAGES.items():
            self._language.addItem(own_name, language)
        for theme in THEMES:
            self._theme.addItem("", theme)
        for scale in FONT_SCALES:
            self._scale.addItem(f"{scale:.0%}", scale)
        self._connect()
        self.retranslate()

    def _connect(self) -> None:
        for name, box in (
            ("language", self._language),
            ("theme", self._theme),
            ("font_scale", self._scale),
        ):
            box.activated.connect(partial(self._send_choice, name, box))
        self._operator.editingFinished.connect(self._send_operator)
        self._countdown.valueChanged.connect(partial(self.changed.emit, "countdown_s"))
        self._frames.valueChanged.connect(partial(self.changed.emit, "burst_frames"))
        self._days.valueChanged.connect(lambda _days: self._word_days())
        self._days.valueChanged.connect(partial(self.changed.emit, "calibration_days"))
        self._sound.toggled.connect(partial(self.changed.emit, "has_sound"))

    def _send_operator(self) -> None:
        if not self._person:  # who opened the store with a passphrase of their own is who works
            self.changed.emit("operator", self._operator.text().strip())

    def _send_choice(self, name: str, box: QComboBox, index: int) -> None:
        self.changed.emit(name, box.itemData(index))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        for widget, text in (
            (self._language, _("&Language")),
            (self._theme, _("&Colours of the window")),
            (self._scale, _("Si&ze of letters")),
            (self._operator, _("Who &works here (for the audit trail)")),
            (self._countdown, _("Count&down before a capture")),
            (self._frames, _("&Frames in a capture")),
            (self._days, _("Calibrate the sensor a&gain after")),
        ):
            self._labels[widget].setText(text)
        self._countdown.setSuffix(" s")
        self._word_days()
        self._sound.setText(_("&Sound with the countdown"))
        for index, theme in enumerate(THEMES):
            self._theme.setItemText(index, _(THEME_NAMES[theme]))

    def _word_days(self) -> None:
        self._days.setSuffix(translate_plural(" day", " days", self._days.value()))

    def show_person(self, name: str) -> None:
        """Show who opened the store where it has people: nobody types another name then."""
        self._person = name
        self._operator.setReadOnly(bool(name))
        self._operator.setText(name)

    def show_preferences(self, preferences: Preferences) -> None:
        """Show what holds now."""
        self._language.setCurrentIndex(self._language.findData(preferences.language))
        self._theme.setCurrentIndex(self._theme.findData(preferences.theme))
        self._scale.setCurrentIndex(self._scale.findData(preferences.font_scale))
        self._operator.setText(self._person or preferences.operator)
        self._countdown.show_value(preferences.countdown_s)
        self._frames.show_value(preferences.burst_frames)
        self._days.show_value(preferences.calibration_days)
        self._word_days()
        with QSignalBlocker(self._sound):
            self._sound.setChecked(preferences.has_sound)
