"""The capture screen: live pictures, and controls beside them. No decisions."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QApplication,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.arrays import UInt8Array
from adibas.data.sessions import SessionSetup
from adibas.pipeline.live import LiveFrame, SensorState
from adibas.texts import translate as _
from ui.capture.live_overlays import joints_of, overlays_of
from ui.capture.panel import DisplayPanel, ShutterPanel, SourcePanel, ViewsPanel
from ui.capture.people_presenter import PeoplePresenter
from ui.capture.presenter import CapturePresenter
from ui.capture.sources import SourceChoice
from ui.capture.status_line import StatusLine
from ui.capture.wand_dialog import WandDialog
from ui.widgets.depth_picture import PACKED_PALETTE, blended, depth_levels
from ui.widgets.image_view import ImageView
from ui.widgets.screen import Screen
from ui.widgets.shown_picture import Coloring
from ui.widgets.side_panel import SidePanel

if TYPE_CHECKING:  # it brings the compiler along
    from adibas.pipeline.live_people import LiveJoints

RECORDINGS = "(*.mcap *.oni)"
COUNT_PT = 96
DEPTH_COLORING = Coloring(depth_levels, PACKED_PALETTE)


class CaptureScreen(Screen):
    """Source, live picture, four views, one button."""

    name = "capture"

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._color, self._depth = ImageView(self), ImageView(self)
        self._count = QLabel(self._color)
        self._count.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._count.hide()
        self._hints, self._status = QLabel(self), StatusLine(self)
        self._followed = QLabel(self)
        self._followed.setProperty("kind", "good")
        self._followed.setWordWrap(True)
        self._followed.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._followed.hide()
        self._people: PeoplePresenter | None = None
        self._joints: tuple[LiveJoints, ...] = ()
        self._hints.setProperty("kind", "warning")
        self._hints.setWordWrap(True)
        self._source, self._display = SourcePanel(self), DisplayPanel(self)
        self._views, self._shutter = ViewsPanel(self), ShutterPanel(self)
        self._due, self._calibrate = QLabel(self), QPushButton(self)
        self._due.setProperty("kind", "warning")
        self._due.setWordWrap(True)
        self._frame: LiveFrame | None = None
        self._display.changed.connect(self._show_frame)
        self._lay_out()
        self.retranslate()

    def _lay_out(self) -> None:
        pictures = QHBoxLayout()
        pictures.addWidget(self._color, 1)
        pictures.addWidget(self._depth, 1)
        self._depth.hide()
        left = QVBoxLayout()
        left.addLayout(pictures, 1)
        left.addWidget(self._followed)
        left.addWidget(self._hints)
        due = QHBoxLayout()
        due.addWidget(self._due, 1)
        due.addWidget(self._calibrate)
        left.addLayout(due)
        self.show_calibration_due("")
        left.addWidget(self._status)
        panel = SidePanel(self)
        for part in (self._views, self._source, self._display):
            panel.column.addWidget(part)
        panel.column.addStretch()
        right = QVBoxLayout()
        right.addWidget(self._shutter)
        right.addWidget(panel, 1)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(16)
        layout.addLayout(left, 1)
        layout.addLayout(right)

    def bind(self, presenter: CapturePresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        sources = presenter.sources
        self._source.source_chosen.connect(sources.choose_source)
        self._source.size_chosen.connect(sources.choose_size)
        self._source.look_asked.connect(sources.look_for_sources)
        self._source.turn_asked.connect(sources.turn)
        self._source.recording_asked.connect(self._ask_recording)
        self._views.chosen.connect(presenter.choose_view)
        self._views.review_asked.connect(presenter.review)
        self._shutter.capture_asked.connect(presenter.capture)
        self._shutter.learn_asked.connect(presenter.learn_markers)
        self._shutter.wand_asked.connect(self._check_wand)
        self._shutter.consent_asked.connect(presenter.record_consent)
        self._calibrate.clicked.connect(presenter.calibration_age.calibrate)

    def bind_people(self, people: PeoplePresenter) -> None:
        """Send what is wanted of people without markers to a presenter, and own it."""
        self._people = people
        self._display.gestures_chosen.connect(people.choose_gestures)
        self._display.joints_wanted.connect(lambda on: people.want_joints(are_wanted=on))
        self._display.changed.connect(self._make_room_for_followed)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._color.setAccessibleName(_("Live picture"))
        self._depth.setAccessibleName(_("Live depth"))
        for part in (self._source, self._display, self._views, self._shutter, self._status):
            part.retranslate()
        for picture in (self._color, self._depth):
            picture.set_placeholder(_("No picture yet"))
        self._calibrate.setText(_("Calibrat&e..."))
        self._show_hints()

    def entered(self) -> None:
        self._presenter.enter()
        if self._people is not None:
            self._people.enter()

    def left(self) -> None:
        self._presenter.leave()
        if self._people is not None:
            self._people.leave()

    def closed(self) -> None:
        self._presenter.close()
        if self._people is not None:
            self._people.close()

    def open_file(self, path: Path) -> None:
        """Replay a dropped recording."""
        self._presenter.sources.open_recording(path)

    def show_both(self) -> None:
        """Show colour and depth side by side."""
        self._display.choose_mode("both")

    def show_sources(self, choices: tuple[SourceChoice, ...], chosen: str) -> None:
        self._source.show_sources(choices, chosen)

    def show_setup(self, setup: SessionSetup) -> None:
        self._source.show_setup(setup)
        for picture in (self._color, self._depth):
            picture.set_rotation(setup.rotation_deg)

    def show_frame(self, frame: LiveFrame) -> None:
        self._frame = frame
        self._show_frame()
        self._show_hints()
        self._status.show_frame(frame)

    def show_sensor(self, state: SensorState) -> None:
        self._status.show_state(state)
        if state.kind not in ("live", "lost"):
            self._frame, self._joints = None, ()
            for picture in (self._color, self._depth):
                picture.set_picture(None)
                picture.set_overlays(())
            self._show_hints()

    def show_calibration_due(self, sentence: str) -> None:
        self._due.setText(sentence)
        for widget in (self._due, self._calibrate):
            widget.setVisible(bool(sentence))

    def show_disk(self, minutes: float | None) -> None:
        self._status.show_disk(minutes)

    def show_views(self, view: str, taken: dict[str, UInt8Array | None]) -> None:
        self._views.show_views(view, taken)

    def show_readiness(self, sentence: str, *, is_ready: bool) -> None:
        self._shutter.show_readiness(sentence, is_ready=is_ready)

    def offer_consent(self, *, is_lacking: bool) -> None:
        self._shutter.offer_consent(is_lacking=is_lacking)

    def show_followed(self, sentence: str) -> None:
        if sentence != self._followed.text():
            self._tell_followed(sentence)

    def show_joints(self, people: "tuple[LiveJoints, ...]") -> None:
        self._joints = people

    def show_countdown(self, seconds: int | None) -> None:
        self._shutter.show_stop(can_stop=seconds is not None)
        if seconds is None:
            self._count.hide()
            return
        font = self._count.font()
        font.setPointSize(COUNT_PT)
        self._count.setFont(font)
        self._count.setStyleSheet("color: white; background: rgba(0, 0, 0, 90);")
        self._count.setText(str(seconds))
        self._count.setGeometry(self._color.rect())
        self._count.show()

    def show_capturing(self, *, is_capturing: bool) -> None:
        self._shutter.show_stop(can_stop=is_capturing)
        self._views.setEnabled(not is_capturing)
        self._source.setEnabled(not is_capturing)

    def beep(self) -> None:
        QApplication.beep()

    def call_later(self, milliseconds: int, call: Callable[[], None]) -> None:
        timer = QTimer(self)  # Python's singleShot makes one that outlives the screen
        timer.setSingleShot(True)
        timer.timeout.connect(call)
        timer.timeout.connect(timer.deleteLater)
        timer.start(milliseconds)

    def _show_frame(self) -> None:
        frame, mode = self._frame, self._display.mode
        self._color.setVisible(mode != "depth")
        self._depth.setVisible(mode in ("both", "depth"))
        if frame is None:
            return
        if mode != "depth":
            picture = frame.color_rgb
            if mode == "blended" and picture is not None and frame.depth_in_color_m is not None:
                picture = blended(picture, frame.depth_in_color_m)
            self._color.set_picture(picture)
            joints = joints_of({one.person: one.in_color for one in self._joints})
            self._color.set_overlays((*overlays_of(frame, self._display.shows), *joints))
        if self._depth.isVisible() and frame.depth_m is not None:
            self._depth.set_numbers(frame.depth_m, DEPTH_COLORING)
            self._depth.set_overlays(
                tuple(joints_of({one.person: one.in_depth for one in self._joints}))
            )

    def _show_hints(self) -> None:
        hints = self._frame.hints if self._frame is not None else ()
        text = "\n".join(_(hint) for hint in hints)
        if self._hints.text() != text:
            self._hints.setText(text)

    def _make_room_for_followed(self) -> None:
        self._tell_followed(self._followed.text())
        self._followed.setVisible(self._display.follows_people)

    def _tell_followed(self, sentence: str) -> None:
        """Keep room for two lines, so that the picture stays as large as it is, and say this."""
        self._followed.setText("\n")
        self._followed.setMinimumHeight(self._followed.sizeHint().height())
        self._followed.setText(sentence)

    def _check_wand(self) -> None:
        if not self._presenter.may_check_wand():
            return
        dialog = WandDialog(self)
        dialog.bind(self._presenter.check_wand(dialog))
        dialog.open()

    def _ask_recording(self) -> None:
        dialog = QFileDialog(self, _("Open a recording"))
        kinds = _("Recordings")
        dialog.setNameFilter(f"{kinds} {RECORDINGS}")
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.fileSelected.connect(lambda name: self._presenter.sources.open_recording(Path(name)))
        dialog.open()
