"""The window: a rail of screens, what is told to the user, and the help beside them."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QByteArray, QEvent, QMargins, Qt, QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QHBoxLayout,
    QMainWindow,
    QSplitter,
    QStackedWidget,
    QStyle,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.events import Event
from ui.jobs import JobRunner
from ui.navigation import NavigationRail
from ui.preferences import PreferencesFile
from ui.theme import Theme
from ui.unlock_page import UnlockPage
from ui.widgets.elided_label import ElidedLabel
from ui.widgets.help_page import HelpDock
from ui.widgets.least_sizes import renew_least_sizes
from ui.widgets.message_bar import MessageBar
from ui.widgets.progress_strip import ProgressStrip
from ui.widgets.screen import Screen

if TYPE_CHECKING:
    from ui.disputes import Dispute

USUAL_SIZE = (1280, 800)
STATUS_MARGIN_PX = 10


class MainWindow(QMainWindow):
    """Shows one screen at a time, and the unlock page before them.

    Events
    ------
    closing()
        The window closes; whoever owns threads ends them.
    dropped(paths)
        Files or folders were dropped onto the window.
    shown_changed(name)
        Another screen is seen; no name: the window is locked.
    lock_wanted()
        The user leaves and wants nothing of patients to be seen.

    Attributes
    ----------
    may_close : callable
        Asked before the window closes; who says no closes it later.
    while_building : callable
        Gives what is entered while widgets are put together, and nobody can touch anything.
    """

    def __init__(self, theme: Theme, jobs: JobRunner, preferences: PreferencesFile) -> None:
        super().__init__()
        self.closing: Event[[]] = Event()
        self.dropped: Event[[tuple[Path, ...]]] = Event()
        self.shown_changed: Event[[str]] = Event()
        self.lock_wanted: Event[[]] = Event()
        self.may_close: Callable[[], bool] = _yes
        self.while_building: Callable[[], AbstractContextManager[None]] = nullcontext
        self._theme = theme
        self._preferences = preferences
        self._screens: dict[str, Screen] = {}
        self._builders: dict[str, Callable[[], Screen]] = {}
        self.unlock_page = UnlockPage(theme, self)
        self._rail = NavigationRail(theme, self._on_rail, self)
        self._pages, self._outer = QStackedWidget(self), QStackedWidget(self)
        self._messages, self._progress = MessageBar(self), ProgressStrip(self)
        self._patient, self._read_only = ElidedLabel(self), ElidedLabel(self)
        self._person = ElidedLabel(self)
        self._help = HelpDock(self)
        self._lay_out()
        jobs.changed.subscribe(self._progress.show_job)
        self._help_key = QShortcut(QKeySequence(Qt.Key.Key_F1), self.unlock_page, self.show_help)
        QShortcut(QKeySequence("Ctrl+Q"), self, self.close)
        self.setAcceptDrops(True)
        self.resize(*USUAL_SIZE)
        self.restoreGeometry(_bytes(preferences.now.geometry))
        self.restoreState(_bytes(preferences.now.docks))
        self.retranslate()

    def _lay_out(self) -> None:
        content = QWidget(self)
        column = QVBoxLayout(content)
        column.setContentsMargins(16, 12, 16, 8)
        column.addWidget(self._messages)
        column.addWidget(self._pages, 1)
        work = QWidget(self)
        row = QHBoxLayout(work)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addWidget(self._rail)
        row.addWidget(content, 1)
        self._outer.addWidget(self.unlock_page)
        self._outer.addWidget(work)
        self.setCentralWidget(self._outer)
        self.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, self._help)
        self._read_only.setProperty("kind", "warning")
        self._read_only.hide()
        self.statusBar().setContentsMargins(STATUS_MARGIN_PX, 0, STATUS_MARGIN_PX, 0)
        self.statusBar().addWidget(self._patient, 1)
        self._person.hide()
        self.statusBar().addPermanentWidget(self._person)
        self.statusBar().addPermanentWidget(self._read_only)
        self.statusBar().addPermanentWidget(self._progress)

    def keep_on_screen(self) -> None:
        """Be no larger than the screen has room for, the title above the window included."""
        title_px = self.style().pixelMetric(QStyle.PixelMetric.PM_TitleBarHeight)
        room = self.screen().availableSize().shrunkBy(QMargins(0, title_px, 0, 0))
        self.resize(self.size().boundedTo(room))

    def retranslate(self) -> None:
        """Set the window's own texts in the language in use."""
        self.setWindowTitle("ADiBAS")
        self._read_only.setText(_("Read only: another window has this store open"))
        self._messages.put_away()  # a sentence in the language before
        for part in (self._rail, self._messages, self._progress, self._help):
            part.retranslate()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Speak the new language."""
        if event.type() == QEvent.Type.LanguageChange:
            self.retranslate()
            # What stands in the window hears of it later.
            QTimer.singleShot(0, self, lambda: renew_least_sizes(self))
        super().changeEvent(event)

    def dress(self) -> None:
        """Draw what is drawn in the theme in use; its letters may have another size."""
        self._rail.dress()
        self.unlock_page.dress()
        if not self._help.isHidden():  # before larger letters widen the window
            self._help.stand_beside(self, 0)
            QTimer.singleShot(0, self, self._find_room_for_help)
        renew_least_sizes(self)
        self.setWindowIcon(self._theme.icon("adibas", self._theme.tokens.accent))

    def offer_screen(self, name: str, build: Callable[[], Screen]) -> None:
        """Offer one of the rail's screens; it is built when it is first asked for."""
        self._builders[name] = build
        self._rail.show_button(name)

    def keep_screen(self, name: str, reason: str) -> None:
        """Offer a screen no more where there is a reason, which its button tells."""
        self._rail.keep_button(name, reason)

    def remove_screens(self) -> None:
        """Close all screens and forget them."""
        self._keep_layout()
        for screen in self._screens.values():
            screen.closed()
            self._pages.removeWidget(screen)
            screen.deleteLater()
        self._screens.clear()
        self._builders.clear()

    @property
    def shown(self) -> str:
        """Name of the screen that is seen; empty while the window is locked."""
        page = self._pages.currentWidget()
        is_open = self._outer.currentWidget() is not self.unlock_page
        return page.name if is_open and isinstance(page, Screen) else ""

    def screen_named(self, name: str) -> Screen:
        """Return a screen by its name, built now if it was not asked for before."""
        if name not in self._screens:
            screen = self._builders[name]()
            self._screens[name] = screen
            self._pages.addWidget(screen)
            for splitter_name, splitter in _splitters(screen):
                state = self._preferences.now.splitters.get(splitter_name, "")
                splitter.restoreState(_bytes(state))
        return self._screens[name]

    @property
    def built_screens(self) -> tuple[Screen, ...]:
        """The screens that were asked for up to now."""
        return tuple(self._screens.values())

    def drafts(self) -> dict[str, str]:
        """Return by the name of the screen what was typed and is not saved."""
        drafts = {name: screen.draft() for name, screen in self._screens.items()}
        return {name: draft for name, draft in drafts.items() if draft}

    def show_screen(self, name: str) -> None:
        """Show a screen; the one that was seen is told."""
        before = self._pages.currentWidget()
        with self.while_building():
            wanted = self.screen_named(name)
            self._find_room_for_help()
        if isinstance(before, Screen) and before is not wanted:
            before.left()
        with self.while_building():
            self._pages.setCurrentWidget(wanted)
            self._outer.setCurrentIndex(1)
        self._rail.show_chosen(name)
        self._help.follow(name)
        wanted.entered()
        self.shown_changed.emit(name)

    def show_first_screen(self) -> None:
        """Show the screen that was offered first."""
        self.show_screen(next(iter(self._builders)))

    def show_unlock(self) -> None:
        """Hide everything of patients behind the unlock page."""
        page = self._pages.currentWidget()
        if isinstance(page, Screen):
            page.left()
        self._outer.setCurrentWidget(self.unlock_page)
        self._messages.put_away()
        self.show_patient("")
        self.show_person("")
        self._help.follow(self.unlock_page.name)
        self.shown_changed.emit("")

    def show_patient(self, text: str) -> None:
        """Say at the bottom who is being looked at."""
        self._patient.setText(text)

    def show_person(self, text: str) -> None:
        """Say at the bottom who has the store open; nothing where it has no people."""
        self._person.setText(text)
        self._person.setVisible(bool(text))

    def show_read_only(self, *, is_read_only: bool) -> None:
        """Say whether another window has the store."""
        self._read_only.setVisible(is_read_only)

    def tell(self, kind: str, sentence: str) -> None:
        """Tell the user something."""
        self._messages.tell(kind, sentence)

    def withdraw(self, sentence: str) -> None:
        """Tell this no more; anything else that is told stays."""
        if self.told == sentence:
            self._messages.put_away()

    def offer_again(self, sentence: str, again: Callable[[], object]) -> None:
        """Tell the user what failed, and offer to try it again."""
        self._messages.offer_again(sentence, again)

    def withdraw_retry(self) -> None:
        """Offer no more to try something again."""
        self._messages.withdraw_retry()

    def ask_which_holds(self, dispute: "Dispute") -> None:
        """Show what somebody else saved meanwhile, and let the user choose."""
        from ui.widgets.dispute_dialog import DisputeDialog

        DisputeDialog(dispute, self).open()

    def tell_of_bug(self, sentence: str) -> None:
        """Tell the user that the program failed, on whatever page he is."""
        if self._outer.currentWidget() is self.unlock_page:
            self.unlock_page.show_bug(sentence)
        else:
            self.tell("bad", sentence)

    @property
    def told(self) -> str:
        """What the user is being told."""
        return self._messages.text

    def show_help(self) -> None:
        """Open the help of the screen that is seen."""
        self._place_help()  # before it is seen: the window would grow for it
        self._help.show_page(self.shown or self.unlock_page.name)

    def _find_room_for_help(self) -> None:
        if not self._help.isHidden():
            self._place_help()

    def _place_help(self) -> None:
        """Let the help float where it would push the screen out of the window."""
        screen_px = self._outer.minimumSizeHint().width()
        self._help.stand_beside(self, self.width() - screen_px)

    def _on_rail(self, name: str) -> None:
        if name == "help":
            self.show_help()
        elif name == "lock":
            self.lock_wanted.emit()
        else:
            self.show_screen(name)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802  (Qt's name)
        if self.shown and _files(event):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802  (Qt's name)
        event.acceptProposedAction()
        self.dropped.emit(_files(event))

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802  (Qt's name)
        if not self.may_close():
            event.ignore()
            return
        self._keep_layout()
        self.closing.emit()
        super().closeEvent(event)

    def _keep_layout(self) -> None:
        """Write down where everything is, for the next start."""
        splitters = dict(self._preferences.now.splitters)
        for screen in self._screens.values():
            for name, splitter in _splitters(screen):
                splitters[name] = _text(splitter.saveState())
        self._preferences.change(
            geometry=_text(self.saveGeometry()),
            docks=_text(self.saveState()),
            splitters=splitters,
        )


def _yes() -> bool:
    """Let the window close: nobody says otherwise."""
    return True


def _files(event: QDropEvent) -> tuple[Path, ...]:
    """Return the files and folders of this computer that are being dropped."""
    urls = event.mimeData().urls()
    return tuple(Path(url.toLocalFile()) for url in urls if url.isLocalFile())


def _splitters(screen: Screen) -> tuple[tuple[str, QSplitter], ...]:
    """Return them by the names that their places are kept under, whatever else a screen gets."""
    found = screen.findChildren(QSplitter)
    return tuple((f"{screen.name}-{one.objectName()}", one) for one in found)


def _bytes(packed: str) -> QByteArray:
    return QByteArray.fromHex(QByteArray(packed.encode()))


def _text(state: QByteArray) -> str:
    return bytes(state.toHex().data()).decode()
