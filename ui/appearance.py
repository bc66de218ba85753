"""Language, colours and letters of everything that is seen, as the user prefers them."""

from PySide6.QtCore import QLibraryInfo, QLocale, Qt, QTranslator
from PySide6.QtWidgets import QApplication

from adibas.resources import resource_path
from adibas.texts import spoken_language, use_language
from ui.preferences import Preferences, PreferencesFile
from ui.theme import Theme
from ui.window import MainWindow


class Appearance:
    """Follows the preferences and, where the user wants that, the desktop."""

    def __init__(
        self, app: QApplication, theme: Theme, window: MainWindow, preferences: PreferencesFile
    ) -> None:
        self._app = app
        self._theme = theme
        self._window = window
        self._preferences = preferences
        self._translator, self._lacking = QTranslator(), QTranslator()
        self._used = preferences.now
        self._end = preferences.changed.subscribe(self._on_preferences)
        app.styleHints().colorSchemeChanged.connect(self._on_desktop)
        self._speak()

    def close(self) -> None:
        """Follow nothing any more."""
        self._end()
        self._app.styleHints().colorSchemeChanged.disconnect(self._on_desktop)
        for translator in (self._translator, self._lacking):
            self._app.removeTranslator(translator)

    def _on_preferences(self, now: Preferences) -> None:
        before, self._used = self._used, now
        if now.language != before.language:
            use_language(now.language)
            self._speak()
        if (now.theme, now.font_scale) != (before.theme, before.font_scale):
            self._dress()

    def _on_desktop(self, _scheme: Qt.ColorScheme) -> None:
        if self._preferences.now.theme == "system":
            self._dress()

    def _dress(self) -> None:
        self._theme.use(self._preferences.now.theme, self._preferences.now.font_scale)
        self._window.dress()

    def _speak(self) -> None:
        """Let Qt's own texts and numbers speak, too; every widget is told of the change.

        What Qt has not in a language, as two labels of each dialog for files, we have.
        """
        locale = QLocale(self._preferences.now.language)
        QLocale.setDefault(locale)
        self._window.setLocale(locale)
        for translator in (self._translator, self._lacking):
            self._app.removeTranslator(translator)
        folder = QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        self._translator.load(locale, "qtbase", "_", folder)  # of Portuguese Qt has qtbase_pt_BR
        self._app.installTranslator(self._translator)
        if self._lacking.load(str(resource_path("translations", spoken_language(), "qt.qm"))):
            self._app.installTranslator(self._lacking)
