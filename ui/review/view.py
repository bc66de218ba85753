"""The review screen: captures, picture, markers, measures, notes. No decisions."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QSplitter,
    QStackedWidget,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from adibas.arrays import UInt8Array
from adibas.texts import translate as _
from ui.navigation import TITLES
from ui.review.capture_strip import CaptureStrip
from ui.review.content import CaptureItem, MeasureRow, Mode, Points, placed
from ui.review.drawing import overlays_of, refused_index
from ui.review.markers_panel import MarkersPanel
from ui.review.measures_panel import MeasuresPanel
from ui.review.notes_panel import NotesPanel
from ui.review.presenter import ReviewPresenter
from ui.review.tools import ReviewTools
from ui.review.wording import READ_ONLY_HINT, SPACE_HINT, WAIT_HINT, mode_hint
from ui.theme import Theme
from ui.widgets.first_step import FirstStep
from ui.widgets.image_view import ImageView
from ui.widgets.picture_canvas import WHEEL_STEP
from ui.widgets.screen import Screen
from ui.widgets.space import Space
from ui.widgets.space_view import SpaceView

if TYPE_CHECKING:
    from adibas.data.protocol_measures import ProtocolMeasures

NOTHING_PAGE, REVIEW_PAGE = 0, 1
PICTURE_PAGE, SPACE_PAGE = 0, 1
PANEL_WIDTH, PICTURE_WIDTH = 545, 595
MARKERS_HEIGHT, MEASURES_HEIGHT = 380, 280


class ReviewScreen(Screen):
    """The strip at the left, the picture in the middle, the numbers at the right."""

    name = "review"

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._points = Points()
        self._nothing_sentence, self._wanted_screen = "", "patients"
        self._is_read_only = False
        self._tools = ReviewTools(theme, self)
        self._hint, self._first = QLabel(self), FirstStep(self)
        self._strip = CaptureStrip(self)
        self._image, self._space = ImageView(self), SpaceView(self)
        self._markers, self._notes = MarkersPanel(theme, self), NotesPanel(self)
        self._measures, self._upper = MeasuresPanel(self), QTabWidget(self)
        self._center, self._pages = QStackedWidget(self), QStackedWidget(self)
        self._lay_out()
        escape = QShortcut(QKeySequence(Qt.Key.Key_Escape), self)
        escape.setContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        self._escape = escape
        self.retranslate()

    def _lay_out(self) -> None:
        self._hint.setWordWrap(True)
        self._hint.setProperty("kind", "quiet")
        self._upper.addTab(self._markers, "")
        self._upper.addTab(self._notes, "")
        for widget in (self._image, self._space):
            self._center.addWidget(widget)
        across = QSplitter(self)
        across.setObjectName("across")
        for part, stretch in ((self._center, 4), (self._numbers(), 1)):
            across.addWidget(part)
            across.setStretchFactor(across.indexOf(part), stretch)
        across.setSizes([PICTURE_WIDTH, PANEL_WIDTH])
        across.setChildrenCollapsible(False)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(self._strip)
        row.addWidget(across, 1)
        review = QWidget(self)
        column = QVBoxLayout(review)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._tools)
        column.addWidget(self._hint)
        column.addLayout(row, 1)
        for page in (self._first, review):
            self._pages.addWidget(page)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(self._pages)

    def _numbers(self) -> QSplitter:
        """Return markers and notes above the measures."""
        numbers = QSplitter(Qt.Orientation.Vertical, self)
        numbers.setObjectName("numbers")
        numbers.addWidget(self._upper)
        numbers.addWidget(self._measures)
        numbers.setSizes([MARKERS_HEIGHT, MEASURES_HEIGHT])
        numbers.setChildrenCollapsible(False)
        return numbers

    def bind(self, presenter: ReviewPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        points = presenter.points
        self._strip.chosen.connect(presenter.choose_capture)
        self._notes.written.connect(presenter.change_notes)
        self._first.button.clicked.connect(self._on_go)
        self._tools.mode_chosen.connect(points.choose_mode)
        self._tools.asked.connect(self._on_tool)
        self._tools.switched.connect(self._on_switch)
        self._escape.activated.connect(points.escape)
        self._image.dot_pressed.connect(self._on_dot)
        self._image.dot_dragged.connect(points.drag)
        self._image.dot_dropped.connect(
            lambda name, u, v: points.drop(name, u, v, is_free=self._is_free())
        )
        self._image.clicked.connect(lambda u, v: points.click(u, v, is_free=self._is_free()))
        self._image.nudged.connect(points.nudge)
        self._image.nudge_ended.connect(points.end_nudge)
        self._markers.chosen.connect(points.select)
        self._markers.entered.connect(points.press)
        self._markers.renamed.connect(points.rename)
        self._measures.kept.connect(points.keep_measure)
        self._measures.removed.connect(points.remove_measure)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        for part in (self._tools, self._strip, self._markers, self._measures, self._notes):
            part.retranslate()
        self._upper.setTabText(0, _("Markers"))
        self._upper.setTabText(1, _("Notes"))
        self._upper.setAccessibleName(_("Markers and notes"))
        self._measures.setAccessibleName(_("Measures"))
        self._image.setAccessibleName(_("Picture with markers"))
        self._image.set_placeholder(_("The picture is being read"))
        self._space.setAccessibleName(_("Surface in 3-D"))
        self._word_nothing()
        self.show_points(self._points)

    def entered(self) -> None:
        self._presenter.entered()

    def left(self) -> None:
        self._notes.save()
        self._presenter.left()

    def closed(self) -> None:
        self._notes.save()
        self._presenter.close()

    def unsaved(self) -> tuple[str, ...]:
        """Save the notes, and name them where they cannot be saved."""
        self._notes.save()
        return (_("The notes of the session"),) if self._notes.is_unsaved else ()

    def show_nothing(self, sentence: str, screen: str) -> None:
        self._nothing_sentence, self._wanted_screen = sentence, screen
        self._word_nothing()
        self._pages.setCurrentIndex(NOTHING_PAGE)

    def show_captures(
        self, items: tuple[CaptureItem, ...], chosen: str | None, rotation_deg: int
    ) -> None:
        self._strip.show_items(items, chosen, rotation_deg)
        self._pages.setCurrentIndex(REVIEW_PAGE)

    def show_picture(self, picture_rgb: UInt8Array | None, rotation_deg: int) -> None:
        self._image.set_rotation(rotation_deg)
        self._image.set_picture(picture_rgb)
        self._show_center(PICTURE_PAGE)

    def show_notices(self, sentences: tuple[str, ...]) -> None:
        self._notes.show_notices(sentences)

    def keep_notes(self, session_id: str, saved: str) -> None:
        self._notes.keep(session_id, saved)

    def show_notes(self, session_id: str, notes: str, *, can_edit: bool) -> None:
        self._is_read_only = not can_edit
        self._notes.show_notes(session_id, notes, can_edit=can_edit)

    def show_names(self, names: tuple[str, ...]) -> None:
        self._markers.suggest(names)

    def show_points(self, points: Points) -> None:
        self._points = points
        self._tools.show_points(points)
        self._markers.show_points(points)
        self._measures.show_chosen(points.measures, can_edit=points.can_edit)
        self._image.set_overlays(overlays_of(points))
        can_nudge = points.can_edit and points.selected is not None and not points.mode.picks
        self._image.set_nudging(is_on=can_nudge)
        is_plain = points.mode is Mode.CHOOSE
        self._image.setCursor(
            Qt.CursorShape.ArrowCursor if is_plain else Qt.CursorShape.CrossCursor
        )
        self._space.show_landmarks(placed(points.markers))
        self._hint.setText(self._hint_text(points))

    def show_measures(self, rows: tuple[MeasureRow, ...]) -> None:
        self._measures.show_all(rows)

    def show_protocol(self, measures: "ProtocolMeasures | None") -> None:
        self._measures.protocol.show_protocol(measures)

    def show_space(self, space: Space | None) -> None:
        self._space.show_space(space)
        self._show_center(SPACE_PAGE)

    def _word_nothing(self) -> None:
        way = _("Go to {screen}").format(screen=_(TITLES[self._wanted_screen]))
        self._first.say(_(self._nothing_sentence), way)

    def _hint_text(self, points: Points) -> str:
        if self._center.currentIndex() == SPACE_PAGE:
            return _(SPACE_HINT)
        if points.can_edit:
            return mode_hint(points)
        return _(READ_ONLY_HINT) if self._is_read_only else _(WAIT_HINT)

    def _is_free(self) -> bool:
        """Whether nothing is to snap: Alt, or Ctrl where the desktop keeps Alt and mouse."""
        keys = Qt.KeyboardModifier.AltModifier | Qt.KeyboardModifier.ControlModifier
        return bool(self._image.modifiers & keys)

    def _on_go(self) -> None:
        self._presenter.go_to(self._wanted_screen)

    def _on_dot(self, name: str) -> None:
        index = refused_index(name)
        if index is None:
            self._presenter.points.press(name)
        else:
            self._presenter.points.adopt(self._points.rejected[index])

    def _on_tool(self, name: str) -> None:
        points = self._presenter.points
        actions: dict[str, Callable[[], None]] = {
            "name-others": points.name_others,
            "undo": points.undo,
            "redo": points.redo,
            "delete": points.delete,
            "rename": self._on_rename,
            "zoom-in": lambda: self._seen_view().zoom_by(WHEEL_STEP**2),
            "zoom-out": lambda: self._seen_view().zoom_by(WHEEL_STEP**-2),
            "fit": lambda: self._seen_view().fit(),
        }
        actions[name]()

    def _seen_view(self) -> ImageView | SpaceView:
        return self._space if self._center.currentIndex() == SPACE_PAGE else self._image

    def _show_center(self, page: int) -> None:
        self._center.setCurrentIndex(page)
        self._tools.action_named("space").setChecked(page == SPACE_PAGE)
        self._hint.setText(self._hint_text(self._points))

    def _on_rename(self) -> None:
        self._upper.setCurrentWidget(self._markers)
        self._markers.edit_name(self._points.selected)

    def _on_switch(self, name: str, is_on: bool) -> None:
        if name == "refused":
            self._presenter.points.show_rejected(is_shown=is_on)
        elif is_on:
            self._presenter.open_space()
        else:
            self._show_center(PICTURE_PAGE)
