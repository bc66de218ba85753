"""The calibration screen: a board, its pictures, their result. No decisions."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QApplication,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from adibas.arrays import UInt8Array
from adibas.data.board import BoardCorners
from adibas.pipeline.calibration_watch import PASSING, Moment
from adibas.pipeline.live_frames import LiveFrame, SensorState
from adibas.pipeline.sensor_calibration import SensorOutcome
from adibas.texts import describe
from adibas.texts import translate as _
from ui.calibration.board_panel import BoardPanel
from ui.calibration.drawing import board_overlays, coverage_overlays
from ui.calibration.pictures_panel import PicturesPanel
from ui.calibration.ports import Shown
from ui.calibration.presenter import CalibrationPresenter
from ui.calibration.result_page import ResultPage
from ui.widgets.image_view import ImageView
from ui.widgets.look import show_kind
from ui.widgets.overlays import Overlay, Text
from ui.widgets.question import ask
from ui.widgets.screen import Screen
from ui.widgets.side_panel import SidePanel

PICTURES = "(*.png *.jpg *.jpeg)"
FLASH_MS = 700
STILL_HEIGHT_PX = 8


class CalibrationScreen(Screen):
    """Board, live picture, pictures taken, result."""

    name = "calibration"

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title, self._advice, self._hint, self._reminder = (QLabel(self) for _ in range(4))
        self._title.setProperty("kind", "title")
        self._reminder.setProperty("kind", "quiet")
        for label in (self._title, self._advice, self._hint, self._reminder):
            label.setWordWrap(True)
        self._picture, self._still = ImageView(self), QProgressBar(self)
        self._still.setRange(0, 100)
        self._still.setTextVisible(False)
        self._still.setMaximumHeight(STILL_HEIGHT_PX)
        self._board, self._pictures = BoardPanel(self), PicturesPanel(self)
        self._result, self._pages = ResultPage(self), QStackedWidget(self)
        self._buttons = {name: QPushButton(self) for name in _BUTTONS}
        for name in ("compute", "accept"):
            self._buttons[name].setProperty("main", "true")
        keys = QKeySequence(TAKE_KEYS)  # beside its underlined letter
        QShortcut(keys, self).activated.connect(self._buttons["take"].click)
        self._buttons["take"].setToolTip(keys.toString(QKeySequence.SequenceFormat.NativeText))
        self._shown: Shown | None = None
        self._outcome: SensorOutcome | None = None
        self._is_accepted = False
        self._flash = QTimer(self)
        self._flash.setSingleShot(True)
        self._flash.setInterval(FLASH_MS)
        self._lay_out()
        self.retranslate()

    def _lay_out(self) -> None:
        live = QWidget(self)
        column = QVBoxLayout(live)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._title)
        column.addWidget(self._advice)
        column.addWidget(self._picture, 1)
        column.addWidget(self._still)
        column.addWidget(self._hint)
        column.addWidget(self._reminder)
        self._pages.addWidget(live)
        self._pages.addWidget(self._result)
        self._panel = SidePanel(self)
        for part in (self._board, self._pictures):
            self._panel.column.addWidget(part)
        self._panel.column.addStretch()
        right = QVBoxLayout()
        right.addWidget(self._panel, 1)
        right.addStretch()
        for button in self._buttons.values():
            right.addWidget(button)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(16)
        layout.addWidget(self._pages, 1)
        layout.addLayout(right)

    def bind(self, presenter: CalibrationPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._board.board_chosen.connect(presenter.choose_board)
        self._board.print_asked.connect(self._ask_page)
        self._pictures.automatic_changed.connect(presenter.set_automatic)
        self._pictures.remove_asked.connect(presenter.remove)
        self._pictures.chosen.connect(presenter.look_at)
        self._pictures.images_asked.connect(self._ask_images)
        self._pictures.anew_asked.connect(presenter.start_anew)
        self._pictures.sensor_asked.connect(presenter.show_sensor)
        for name, action in (
            ("take", presenter.take),
            ("compute", presenter.result.compute),
            ("accept", presenter.result.accept),
            ("save", self._ask_place),
            ("report", self._ask_report),
            ("more", presenter.result.take_more),
            ("discard", presenter.start_anew),
        ):
            self._buttons[name].clicked.connect(action)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("Calibrate the sensor"))
        self._picture.setAccessibleName(_("Live picture of the board"))
        self._picture.set_placeholder(_("No picture yet"))
        self._still.setAccessibleName(_("How long the board is still"))
        for name, text in _texts().items():
            self._buttons[name].setText(text)
        for part in (self._board, self._pictures, self._result):
            part.retranslate()
        if self._shown is not None:
            self.show_session(self._shown)
        self._show_buttons()

    def entered(self) -> None:
        self._presenter.enter()

    def left(self) -> None:
        self._presenter.leave()

    def closed(self) -> None:
        self._flash.stop()
        self._presenter.close()

    def unsaved(self) -> tuple[str, ...]:
        """Name a calibration that is neither in use nor in a file."""
        is_unsaved = self._presenter.result.is_unsaved
        return (_("The calibration that was calculated"),) if is_unsaved else ()

    def open_file(self, path: Path) -> None:
        """Use a dropped picture, or a folder of them."""
        self._presenter.open_images((path,))

    def show_session(self, shown: Shown) -> None:
        self._shown = shown
        self._advice.setText(_advice(shown))
        reminder = shown.reminder
        self._reminder.setText("" if reminder is None else reminder.text)
        self._reminder.setVisible(reminder is not None)
        is_urgent = reminder is not None and reminder.is_urgent
        show_kind(self._reminder, "warning" if is_urgent else "quiet")
        self._board.setEnabled(not shown.is_busy)
        self._board.show_board(shown.board)
        self._pictures.show_pictures(shown)
        self._still.setVisible(not shown.is_offline)
        self._show_buttons()

    def show_sensor(self, state: SensorState) -> None:
        if state.kind not in ("live", "lost"):
            self._picture.set_picture(None)
            self._picture.set_overlays(())
        if state.error is not None:
            self._hint_at(describe(state.error), "bad")
        elif state.kind != "live":
            self._hint_at("", "quiet")
        self._still.setValue(0)

    def show_frame(self, frame: LiveFrame, moment: Moment) -> None:
        self._picture.set_picture(frame.color_rgb)
        self._still.setValue(round(100 * moment.still_share))
        self._hint_at(moment.text, "quiet" if moment.hindrance in PASSING else "warning")
        self._draw(moment.corners, is_ready=moment.is_ready)

    def show_kept(self, color_rgb: UInt8Array, corners: BoardCorners) -> None:
        self._picture.set_picture(color_rgb)
        self._hint_at("", "quiet")
        self._draw(corners, is_ready=True)

    def show_taken(self) -> None:
        self._flash.start()

    def show_outcome(self, outcome: SensorOutcome | None, *, is_accepted: bool) -> None:
        self._outcome, self._is_accepted = outcome, is_accepted
        if outcome is not None:
            self._result.show_outcome(outcome, is_accepted=is_accepted)
        self._pages.setCurrentIndex(int(outcome is not None))
        self._panel.setVisible(outcome is None)
        self._show_buttons()

    def confirm(self, question: str, consent: str, act: Callable[[], None]) -> None:
        ask(self, question, consent, act)

    def beep(self) -> None:
        QApplication.beep()

    def _draw(self, corners: BoardCorners | None, *, is_ready: bool) -> None:
        if self._shown is None:
            return
        overlays: list[Overlay] = []
        width, height = self._picture.placement.picture
        if self._shown.guidance is not None:
            overlays += coverage_overlays(self._shown.guidance, (height, width))
        if corners is not None and len(corners.pixels) == self._shown.board.n_corners:
            overlays += board_overlays(
                corners, self._shown.board, is_ready=is_ready or self._flash.isActive()
            )
        if self._flash.isActive():
            overlays.append(Text(width / 2, height / 12, "✓ " + _("Picture taken"), "selected"))
        self._picture.set_overlays(tuple(overlays))

    def _hint_at(self, text: str, kind: str) -> None:
        if self._hint.text() != text:
            self._hint.setText(text)
        show_kind(self._hint, kind)

    def _show_buttons(self) -> None:
        """Offer what can be done now, and nothing else."""
        shown, outcome = self._shown, self._outcome
        is_result = outcome is not None
        is_open = outcome is not None and not self._is_accepted
        is_offline = shown is not None and shown.is_offline
        for name, is_seen in (
            ("take", not is_result and not is_offline),
            ("compute", not is_result),
            ("accept", is_open),
            ("save", outcome is not None and outcome.calibration is not None),
            ("report", is_result),
            ("more", is_result),
            ("discard", is_open),
        ):
            self._buttons[name].setVisible(is_seen)
        is_free = shown is not None and not shown.is_busy
        self._buttons["compute"].setEnabled(is_free and shown is not None and shown.can_compute)
        self._buttons["accept"].setEnabled(
            is_free and outcome is not None and outcome.is_good_enough
        )
        more = _("Calibrate a&gain") if self._is_accepted else _("Take &more pictures")
        self._buttons["more"].setText(more)

    def _ask_page(self, size_name: str) -> None:
        dialog = QFileDialog(self, _("Print the board"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(_("PDF files") + " (*.pdf)")
        dialog.setDefaultSuffix("pdf")
        dialog.selectFile(f"board-{size_name}.pdf")
        dialog.fileSelected.connect(lambda name: self._presenter.print_board(size_name, Path(name)))
        _open(dialog)

    def _ask_images(self) -> None:
        dialog = QFileDialog(self, _("Pictures of the board"))
        dialog.setFileMode(QFileDialog.FileMode.ExistingFiles)
        dialog.setNameFilter(_("Pictures") + f" {PICTURES}")
        dialog.filesSelected.connect(
            lambda names: self._presenter.open_images(tuple(Path(name) for name in names))
        )
        _open(dialog)

    def _ask_place(self) -> None:
        dialog = QFileDialog(self, _("Save the calibration"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(_("Calibrations") + " (*.json)")
        dialog.setDefaultSuffix("json")
        dialog.selectFile("calibration.json")
        dialog.fileSelected.connect(lambda name: self._presenter.result.save(Path(name)))
        _open(dialog)

    def _ask_report(self) -> None:
        dialog = QFileDialog(self, _("Write a report"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilters([_("PDF files") + " (*.pdf)", _("Excel workbooks") + " (*.xlsx)"])
        dialog.setDefaultSuffix("pdf")
        dialog.filterSelected.connect(
            lambda chosen: dialog.setDefaultSuffix("xlsx" if "xlsx" in chosen else "pdf")
        )
        dialog.selectFile("calibration")
        dialog.fileSelected.connect(lambda name: self._presenter.result.report(Path(name)))
        _open(dialog)


TAKE_KEYS = "Ctrl+Return"
_BUTTONS = ("take", "compute", "more", "report", "save", "discard", "accept")


def _texts() -> dict[str, str]:
    """Return the texts of the buttons."""
    return {
        "take": _("&Take a picture now"),
        "compute": _("Cal&culate the calibration"),
        "accept": _("&Use this calibration"),
        "save": _("Save to a &file..."),
        "report": _("&Write a report..."),
        "more": _("Take &more pictures"),
        "discard": _("&Discard everything..."),
    }


def _advice(shown: Shown) -> str:
    """Return the one sentence that says what to do next."""
    if shown.guidance is None:
        return _("Choose the board that you hold, or print one. Then hold it before the sensor.")
    if shown.is_offline and not shown.pictures:
        return _("Choose pictures of the board.")
    return _(shown.guidance.next_step)


def _open(dialog: QFileDialog) -> None:
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
