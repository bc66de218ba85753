"""The behaviour screen: video, timeline, what is coded and counted. No decisions."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import QKeyEvent, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QHBoxLayout,
    QSplitter,
    QStackedWidget,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.behaviour.agreement_page import AgreementPage
from ui.behaviour.code_panel import CodePanel
from ui.behaviour.content import Desk, Selected, Timeline
from ui.behaviour.counts_page import CountsPage
from ui.behaviour.counts_presenter import CountsPresenter
from ui.behaviour.file_dialogs import ask_open_several
from ui.behaviour.learn_dialog import LearnDialog
from ui.behaviour.measured import HeatMap, People, Raster
from ui.behaviour.ports import Picture
from ui.behaviour.presenter import BehaviourPresenter, Position
from ui.behaviour.scheme import TypedScheme
from ui.behaviour.scheme_dialog import SchemeDialog
from ui.behaviour.section_dialog import SectionDialog
from ui.behaviour.selected_panel import SelectedPanel
from ui.behaviour.sources import StoredChoice
from ui.behaviour.tables import TextTable
from ui.behaviour.timeline import ZOOM_STEP, TimelineView
from ui.behaviour.tools import KEYS, BehaviourTools, fill_stored
from ui.behaviour.transport import LONG_STEP_S, Transport
from ui.behaviour.video_view import VideoView
from ui.theme import Theme
from ui.widgets.first_step import FirstStep
from ui.widgets.screen import Screen
from ui.widgets.side_panel import SidePanel

TICK_MS = 10
VIDEO_WIDTH, PANEL_WIDTH = 700, 440
VIDEO_HEIGHT, TIMELINE_HEIGHT = 430, 220
RECORDINGS = "(*.mcap *.oni)"
Key = Qt.Key
COMMANDS = (
    Qt.KeyboardModifier.ControlModifier
    | Qt.KeyboardModifier.AltModifier
    | Qt.KeyboardModifier.MetaModifier
)
"""A letter with one of these is no code."""


class BehaviourScreen(Screen):
    """What happens in a recording, when it begins, and when it ends."""

    name = "behaviour"

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._first = FirstStep(self)
        self._chooser = QComboBox(self)
        self._stored: tuple[StoredChoice, ...] = ()
        self._typed_scheme: TypedScheme | None = None
        self._is_bound = False
        self._tools = BehaviourTools(self)
        self._video, self._transport = VideoView(self), Transport(self)
        self._timeline = TimelineView(theme, self)
        self._code, self._selected = CodePanel(self), SelectedPanel(self)
        self._counts, self._agreement = CountsPage(theme, self), AgreementPage(self)
        self._tabs, self._pages = _Pages(self), QStackedWidget(self)
        self._ticking = QTimer(self)
        self._ticking.setInterval(TICK_MS)
        self._lay_out()
        self.retranslate()

    def _lay_out(self) -> None:
        coding = SidePanel(self)
        for part in (self._code, self._selected):
            coding.column.addWidget(part)
        coding.column.setContentsMargins(8, 8, 8, 8)
        coding.column.addStretch()
        for tab in (coding, self._counts, self._agreement):
            self._tabs.addTab(tab, "")
        left = QWidget(self)
        column = QVBoxLayout(left)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._video, 1)
        column.addWidget(self._transport)
        across = QSplitter(self)
        across.setObjectName("across")
        across.addWidget(left)
        across.addWidget(self._tabs)
        across.setSizes([VIDEO_WIDTH, PANEL_WIDTH])
        down = QSplitter(Qt.Orientation.Vertical, self)
        down.setObjectName("down")
        down.addWidget(across)
        down.addWidget(self._timeline)
        down.setSizes([VIDEO_HEIGHT, TIMELINE_HEIGHT])
        self._transport.height_changed.connect(across.updateGeometry)  # Qt does not tell `down`
        for splitter in (across, down):
            splitter.setChildrenCollapsible(False)
            splitter.setStretchFactor(0, 1)
        self._first.add(self._chooser)
        for page in (self._first, self._work_page(down)):
            self._pages.addWidget(page)
        outer = QHBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(self._pages)

    def _work_page(self, parts: QSplitter) -> QWidget:
        page = QWidget(self)
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._tools)
        column.addWidget(parts, 1)
        return page

    def bind(self, presenter: BehaviourPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._is_bound = True
        coding = presenter.coding
        self._ticking.timeout.connect(presenter.tick)
        self._first.button.clicked.connect(self._ask_recording)
        self._chooser.activated.connect(
            lambda index: self._on_stored(self._chooser.itemData(index))
        )
        self._transport.played.connect(presenter.play_or_stop)
        self._transport.stepped.connect(presenter.step)
        self._transport.speed_chosen.connect(self._on_speed)
        self._timeline.time_chosen.connect(presenter.go_to_ms)
        self._timeline.event_chosen.connect(coding.select)
        self._timeline.event_moved.connect(coding.change)
        self._code.pressed.connect(coding.press)
        self._code.released.connect(coding.release)
        self._code.subject_chosen.connect(self._on_subject)
        self._code.holding_changed.connect(self._on_holding)
        self._selected.changed.connect(coding.change)
        self._selected.accepted.connect(coding.accept)
        self._selected.removed.connect(coding.remove)
        self._bind_tools(presenter)
        self._bind_pages(presenter.counts)
        self._bind_keys()

    def _bind_tools(self, presenter: BehaviourPresenter) -> None:
        tools, coding, files = self._tools, presenter.coding, presenter.files
        tools.open_asked.connect(self._ask_recording)
        tools.stored_chosen.connect(self._on_stored)
        tools.finding_asked.connect(presenter.finding.find)
        tools.learning_asked.connect(self._learn)
        tools.coding_opened.connect(files.open_coding)
        tools.coding_saved.connect(files.save_as)
        tools.scheme_edited.connect(self._edit_scheme)
        tools.section_asked.connect(self._ask_section)
        tools.scheme_opened.connect(files.open_scheme)
        tools.scheme_saved.connect(files.save_scheme)
        tools.second_began.connect(files.begin_blind)
        tools.second_ended.connect(files.end_blind)
        tools.undone.connect(coding.undo)
        tools.redone.connect(coding.redo)

    def offer_labelling(self, label: Callable[[], object]) -> None:
        """Call this when limbs are to be labelled."""
        self._tools.labelling_asked.connect(label)

    def offer_map(self, show: Callable[[], object]) -> None:
        """Call this when the recording is to become a surface."""
        self._tools.map_asked.connect(show)

    def _bind_pages(self, counts: CountsPresenter) -> None:
        self._tabs.currentChanged.connect(
            lambda _index: counts.set_seen(is_seen=self._tabs.currentWidget() is self._counts)
        )
        self._counts.table_chosen.connect(counts.choose_table)
        self._counts.person_chosen.connect(counts.choose_person)
        self._counts.bin_changed.connect(counts.set_bin)
        self._counts.file_chosen.connect(counts.write)
        self._agreement.other_chosen.connect(counts.compare_file)
        self._agreement.params_changed.connect(counts.set_params)
        self._agreement.file_chosen.connect(counts.write_agreement)

    def _bind_keys(self) -> None:
        """Keys with Ctrl work wherever the focus is; the others where nobody types."""
        coding, presenter = self._presenter.coding, self._presenter
        for keys, action in (
            (KEYS["undo"], coding.undo),
            (KEYS["redo"], coding.redo),
            ("Ctrl+B", coding.set_begin),
            ("Ctrl+E", coding.set_end),
            ("Ctrl+Right", lambda: coding.select_next(1)),
            ("Ctrl+Left", lambda: coding.select_next(-1)),
            ("Ctrl+Up", lambda: presenter.change_speed(1)),
            ("Ctrl+Down", lambda: presenter.change_speed(-1)),
            ("Ctrl++", lambda: self._timeline.zoom_by(ZOOM_STEP)),
            ("Ctrl+-", lambda: self._timeline.zoom_by(1 / ZOOM_STEP)),
            ("Ctrl+0", self._timeline.show_all),
        ):
            shortcut = QShortcut(QKeySequence(keys), self)
            shortcut.setContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
            shortcut.activated.connect(action)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._first.say(
            _("Open a recording, or drop one here, to note what happens in it and when."),
            _("&Open a recording..."),
        )
        self._chooser.setAccessibleName(_("Recordings of the session"))
        self._video.setAccessibleName(_("Video"))
        self._timeline.setAccessibleName(_("Timeline of events"))
        titles = (_("Cod&e"), _("Cou&nts"), _("A&greement"))
        for index, title in enumerate(titles):
            self._tabs.setTabText(index, title)
        for part in (
            *(self._tools, self._transport, self._code, self._selected),
            *(self._counts, self._agreement),
        ):
            part.retranslate()
        self.show_stored(self._stored)
        if self._is_bound:
            self._presenter.refresh()

    def entered(self) -> None:
        self._presenter.enter()
        self._take_keys()

    def left(self) -> None:
        self._presenter.leave()

    def closed(self) -> None:
        self._ticking.stop()
        self._presenter.close()

    def draft(self) -> str:
        """Return what was typed into the coding scheme when the window locked."""
        return "" if self._typed_scheme is None else self._typed_scheme.to_text()

    def take_back(self, draft: str) -> None:
        """Keep what was typed for when this scheme is changed again, and say so."""
        self._typed_scheme = TypedScheme.from_text(draft)
        self._presenter.tell_typed_scheme()

    def unsaved(self) -> tuple[str, ...]:
        """Keep what was coded, and name it where it cannot be kept."""
        lost = () if self._presenter.keep() else (_("What was coded in the recording"),)
        return lost if self._typed_scheme is None else (*lost, _("The coding scheme"))

    def open_file(self, path: Path) -> None:
        """Open a dropped recording."""
        self._presenter.open_file(path)

    def open_files(self, paths: tuple[Path, ...]) -> None:
        """Open dropped recordings as one."""
        self._presenter.open_files(paths)

    def show_source(self, title: str, name: str) -> None:
        self._tools.show_source(title, name)
        for page in (self._counts, self._agreement):
            page.show_name(name)
        self._pages.setCurrentIndex(int(bool(title)))
        if title:
            self._take_keys()

    def show_stored(self, choices: tuple[StoredChoice, ...]) -> None:
        self._stored = choices
        fill_stored(self._chooser, choices)
        self._tools.show_stored(choices)

    def show_frame(self, picture: Picture | None, position: Position) -> None:
        self._video.show_frame(picture)
        self._transport.show_position(position)
        self._timeline.show_time(position.time_ms)

    def show_playing(self, *, is_on: bool, speed: float) -> None:
        self._transport.show_playing(is_on=is_on, speed=speed)
        if is_on:
            self._ticking.start()
        else:
            self._ticking.stop()

    def show_desk(self, desk: Desk) -> None:
        self._code.show_desk(desk)
        self._tools.show_desk(desk)

    def show_timeline(self, timeline: Timeline) -> None:
        self._timeline.show_content(timeline)

    def show_selected(self, selected: Selected | None) -> None:
        self._selected.show_selected(selected)

    def show_finding(self, *, is_on: bool) -> None:
        self._tools.show_finding(is_on=is_on)

    def show_blind(self, observer: str) -> None:
        self._tools.show_blind(observer)

    def show_counts(self, table: TextTable) -> None:
        self._counts.show_counts(table)

    def show_plot(self, content: Raster | HeatMap | None) -> None:
        self._counts.show_plot(content)

    def show_people(self, people: People, chosen: int) -> None:
        self._counts.show_people(people, chosen)

    def show_unmeasured(self, *, is_unmeasured: bool) -> None:
        self._counts.show_unmeasured(is_unmeasured=is_unmeasured)

    def show_agreement(self, table: TextTable, sentence: str) -> None:
        self._agreement.show_agreement(table, sentence)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        if self._pages.currentIndex() == 0 or not self._did(event):
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        if event.isAutoRepeat() or not event.text():
            super().keyReleaseEvent(event)
        else:
            self._presenter.key_let_go(event.text())

    def _did(self, event: QKeyEvent) -> bool:
        """Do what a key stands for; return whether it stands for anything."""
        presenter, coding = self._presenter, self._presenter.coding
        is_long = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        actions: dict[Qt.Key, Callable[[], None]] = {
            Key.Key_Space: presenter.play_or_stop,
            Key.Key_Right: lambda: presenter.skip_s(LONG_STEP_S) if is_long else presenter.step(1),
            Key.Key_Left: lambda: presenter.skip_s(-LONG_STEP_S) if is_long else presenter.step(-1),
            Key.Key_Home: lambda: presenter.go_to(0),
            Key.Key_End: presenter.go_to_end,
            Key.Key_Return: coding.accept,
            Key.Key_Enter: coding.accept,
            Key.Key_Delete: coding.remove,
            Key.Key_Backspace: coding.remove,
            Key.Key_Escape: lambda: coding.select(None),
        }
        found = next((action for key, action in actions.items() if key == event.key()), None)
        if found is not None:
            found()
            return True
        if event.isAutoRepeat() or not event.text() or event.modifiers() & COMMANDS:
            return False
        return presenter.key(event.text())

    def _edit_scheme(self) -> None:
        draft = self._presenter.coding.draft
        if draft is not None:
            scheme, change = draft.coding.ethogram, self._presenter.files.change_scheme
            dialog = SchemeDialog(scheme, change, self, self._typed_scheme)
            dialog.finished.connect(lambda _code: self._on_scheme_closed(dialog))
            _open(dialog)

    def _on_scheme_closed(self, dialog: SchemeDialog) -> None:
        self._typed_scheme = dialog.left_behind

    def _ask_section(self) -> None:
        draft = self._presenter.coding.draft
        if draft is not None:
            coding = draft.coding
            observed_ms = (coding.begin_ms, coding.end_ms)
            now_ms = self._presenter.now_ms()
            dialog = SectionDialog(coding.sections, observed_ms, now_ms, self)
            dialog.marked.connect(self._presenter.coding.mark_section)
            dialog.removed.connect(self._presenter.coding.remove_section)
            _open(dialog)

    def _learn(self) -> None:
        dialog = LearnDialog(self._theme, self)
        presenter = self._presenter.learn_from_marks(dialog)
        if presenter is not None:
            dialog.bind(presenter)
            _open(dialog)

    def _take_keys(self) -> None:
        """Let keys code: no field and no list takes them."""
        if self._pages.currentIndex():
            self._timeline.setFocus()

    def _on_speed(self, speed: float) -> None:
        self._presenter.set_speed(speed)
        self._take_keys()

    def _on_subject(self, name: str) -> None:
        self._presenter.coding.choose_subject(name)
        self._take_keys()

    def _on_holding(self, is_on: bool) -> None:
        self._presenter.coding.is_holding = is_on

    def _on_stored(self, recording_id: str) -> None:
        if recording_id:
            self._presenter.open_stored(recording_id)

    def _ask_recording(self) -> None:
        name_filter = _("Recordings") + f" {RECORDINGS}"
        title = _("Open a recording, or several that follow one another")
        ask_open_several(self, title, name_filter, self._presenter.open_files)


class _Pages(QTabWidget):
    """Never so narrow that a title is cut."""

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        least = super().minimumSizeHint()
        return least.expandedTo(QSize(self.tabBar().sizeHint().width(), 0))


def _open(dialog: QDialog) -> None:
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
