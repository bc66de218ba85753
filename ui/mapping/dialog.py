"""The dialog in which a map grows, is stopped, and is saved. No decisions."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QFileDialog,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.mapping.content import RecordingToMap, Standing
from ui.mapping.presenter import MapPresenter
from ui.widgets.flow import in_a_flow
from ui.widgets.look import show_kind
from ui.widgets.scrolled import SHARE_OF_WINDOW, Scrolled, window_room
from ui.widgets.space import Space
from ui.widgets.space_view import SpaceView
from ui.workspace import Workspace

USUAL_LETTERS, USUAL_LINES = 110, 42
SURFACE_LINES = 8
LOOK_EVERY_MS = 200


class MapDialog(QDialog):
    """The surface above, what is told of it below, then what can be done."""

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(_("Map in 3-D"))
        self._title, self._told = QLabel(title, self), QLabel(self)
        self._title.setProperty("kind", "title")
        for label in (self._title, self._told):
            label.setTextFormat(Qt.TextFormat.PlainText)
            label.setWordWrap(True)
        self._space = SpaceView(self)
        self._space.setAccessibleName(_("Surface of the map"))
        self._space.setToolTip(_("Drag or arrows: turn. Wheel or + and -: nearer. 0: from ahead."))
        self._space.set_empty_text(_("The surface grows here while it is computed."))
        self._bar = QProgressBar(self)
        self._bar.setAccessibleName(_("Progress"))
        self._body = QCheckBox(_("The &person alone, who turns before a still camera"), self)
        self._run = QPushButton(self)
        self._run.setProperty("main", "true")
        self._run.setDefault(True)
        self._surface = QPushButton(_("Save the &surface..."), self)
        self._path = QPushButton(_("Save the p&ath..."), self)
        self._close = QPushButton(_("Cl&ose"), self)
        for button in (self._surface, self._path, self._close):
            button.setAutoDefault(False)
        self._is_running = False
        self._timer = QTimer(self)
        self._timer.setInterval(LOOK_EVERY_MS)
        self._lay_out()
        self.show_standing(Standing())

    def _lay_out(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 20)
        column.setSpacing(12)
        inside = Scrolled(self)
        inside.keep_lines(self._space, SURFACE_LINES)
        inside.column.setSpacing(column.spacing())
        inside.column.addWidget(self._title)
        inside.column.addWidget(self._space, 1)
        for part in (self._bar, self._told, self._body):
            inside.column.addWidget(part)
        column.addWidget(inside, 1)
        column.addLayout(in_a_flow(self._run, self._surface, self._path, self._close))
        letters, room = self.fontMetrics(), window_room(self)
        wanted = QSize(USUAL_LETTERS * letters.averageCharWidth(), USUAL_LINES * letters.height())
        self.resize(wanted.boundedTo(room))
        buttons = (self._run, self._surface, self._path, self._close)
        row_px = sum(button.sizeHint().width() + column.spacing() for button in buttons)
        least_px = min(row_px, round(SHARE_OF_WINDOW * room.width()))
        inside.setMinimumSize(least_px, SURFACE_LINES * letters.height())
        self._run.setFocus()

    def bind(self, presenter: MapPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._timer.timeout.connect(presenter.look)
        self._run.clicked.connect(self._on_run)
        self._surface.clicked.connect(
            lambda: self._ask(_("Save the surface"), "PLY (*.ply)", "ply", presenter.save_surface)
        )
        self._path.clicked.connect(
            lambda: self._ask(_("Save the path"), "TUM (*.txt)", "txt", presenter.save_path)
        )
        self._close.clicked.connect(self.reject)
        self.finished.connect(self._on_finished)

    def show_standing(self, standing: Standing) -> None:
        self._is_running = standing.is_running
        texts = (_("&Go on"),) if standing.has_begun else (_("&Map"),)
        self._run.setText(_("S&top") if standing.is_running else texts[0])
        self._body.setEnabled(not standing.is_running)
        for button in (self._surface, self._path):
            button.setEnabled(standing.has_map)
        self._bar.setVisible(standing.is_running)
        if standing.is_running:
            self._timer.start()
        else:
            self._timer.stop()

    def show_progress(self, done: int, total: int) -> None:
        self._bar.setRange(0, total)
        self._bar.setValue(done)

    def show_growing(self, space: Space) -> None:
        self._space.renew_space(space)

    def show_told(self, sentences: tuple[str, ...], *, is_problem: bool) -> None:
        self._told.setText("\n".join(sentences))
        show_kind(self._told, "warning" if is_problem else "quiet")

    def _on_run(self) -> None:
        if self._is_running:
            self._presenter.stop()
        else:
            self._presenter.start(is_body=self._body.isChecked())

    def _ask(self, title: str, name_filter: str, ending: str, then: Callable[[Path], None]) -> None:
        dialog = QFileDialog(self, title)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(name_filter)
        dialog.setDefaultSuffix(ending)
        dialog.selectFile(f"{self._presenter.name}-map.{ending}")
        dialog.fileSelected.connect(lambda name: then(Path(name)))
        dialog.open()

    def _on_finished(self, _code: int) -> None:
        self._timer.stop()
        self._presenter.close()


def open_map(workspace: Workspace, parent: QWidget, recording: RecordingToMap) -> MapDialog:
    """Show the dialog before its parent."""
    dialog = MapDialog(recording.title, parent)
    dialog.bind(MapPresenter(dialog, workspace, recording))
    dialog.open()
    return dialog
