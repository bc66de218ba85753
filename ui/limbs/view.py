"""The page on which limbs are labelled: picture, tools, labels, frames. No decisions."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColor, QIcon, QKeySequence, QPixmap, QShortcut
from PySide6.QtWidgets import (
    QAbstractItemView,
    QButtonGroup,
    QCheckBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QProgressBar,
    QPushButton,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from adibas.arrays import BoolArray, UInt8Array
from adibas.texts import translate as _
from ui.limbs.drawing import USUAL_RADIUS_PX
from ui.limbs.paint_view import PaintView
from ui.limbs.ports import Allowed, Corners, Tool
from ui.limbs.presenter import LimbsPresenter
from ui.widgets.elided_label import ElidedLabel
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import WholeNumberField
from ui.widgets.overlays import Curve, Dot, Overlay, Region
from ui.widgets.side_panel import SidePanel

if TYPE_CHECKING:
    from adibas.pipeline.limb_label_files import LabellingProgress

TOOLS: tuple[Tool, ...] = ("brush", "fill", "polygon")
ABOVE = ("open", "undo", "redo", "propose", "carry", "finish")
KEYS = {"undo": "Ctrl+Z", "redo": "Ctrl+Shift+Z"}
NEXT, PREVIOUS = "PgDown", "PgUp"
NATIVE = QKeySequence.SequenceFormat.NativeText
MOST_RADIUS_PX = 100
LINES_OF_LABELS = 5
SWATCH = 16
RECORDINGS = "(*.mcap *.oni)"


class LimbsPage(QWidget):
    """Tools at the right; keys as in every picture of the program."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title, self._under = ElidedLabel(self), QLabel(self)
        self._title.setProperty("kind", "title")
        self._buttons = {name: QPushButton(self) for name in ABOVE}
        self._buttons["finish"].setProperty("main", "true")
        self._picture = PaintView(self)
        self._tools = {tool: QRadioButton(self) for tool in TOOLS}
        self._chosen_tool = QButtonGroup(self)
        self._tool_label, self._radius_label, self._labels_label = (QLabel(self) for _n in range(3))
        self._radius, self._labels = WholeNumberField(self), QListWidget(self)
        self._beyond, self._enclose = QCheckBox(self), QPushButton(self)
        self._previous, self._next = QPushButton(self), QPushButton(self)
        self._number, self._number_label = WholeNumberField(self), QLabel(self)
        self._bar, self._told = QProgressBar(self), QLabel(self)
        self._names: tuple[str, ...] = ()
        self._overlays: tuple[Overlay, ...] = ()
        self._corners: tuple[Overlay, ...] = ()
        self._lay_out()
        self.setFocusProxy(self._picture)

    def _lay_out(self) -> None:
        for tool, button in self._tools.items():
            self._chosen_tool.addButton(button)
            button.setChecked(tool == TOOLS[0])
        self._radius.setRange(1, MOST_RADIUS_PX)
        self._radius.setValue(USUAL_RADIUS_PX)
        self._radius_label.setBuddy(self._radius)
        self._labels_label.setBuddy(self._labels)
        self._number_label.setBuddy(self._number)
        self._number.setKeyboardTracking(False)
        self._labels.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self._labels.setIconSize(QSize(SWATCH, SWATCH))
        panel = SidePanel(self)
        for part in (self._tool_label, *self._tools.values()):
            panel.column.addWidget(part)
        panel.column.addLayout(in_a_flow(self._radius_label, self._radius))
        for part in (self._enclose, self._beyond, self._labels_label, self._labels, self._under):
            panel.column.addWidget(part)
        panel.column.setStretch(panel.column.indexOf(self._labels), 1)
        across = QHBoxLayout()
        across.addWidget(self._picture, 1)
        across.addWidget(panel)
        column = QVBoxLayout(self)
        column.addWidget(self._title)
        column.addLayout(in_a_flow(*self._buttons.values()))
        column.addLayout(across, 1)
        column.addLayout(
            in_a_flow(self._previous, self._next, self._number_label, self._number, self._told)
        )
        column.addWidget(self._bar)

    def bind(self, presenter: LimbsPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self.presenter = presenter
        clicks = {
            "open": self._ask,
            "undo": presenter.undo,
            "redo": presenter.redo,
            "propose": presenter.propose,
            "carry": presenter.carry,
            "finish": presenter.finish,
        }
        for name, action in clicks.items():
            self._buttons[name].clicked.connect(lambda _on=False, action=action: action())
        for name, keys in KEYS.items():
            self._shortcut(keys, self._buttons[name].click)
        self._shortcut(PREVIOUS, self._previous.click)
        self._shortcut(NEXT, self._next.click)
        for tool, button in self._tools.items():
            button.clicked.connect(lambda _on=False, tool=tool: self._on_tool(tool))
        self._radius.valueChanged.connect(presenter.set_radius)
        self._beyond.toggled.connect(lambda on: presenter.set_beyond(is_on=on))
        self._labels.currentRowChanged.connect(presenter.choose_label)
        self._enclose.clicked.connect(presenter.enclose)
        self._previous.clicked.connect(lambda: presenter.go_by(-1))
        self._next.clicked.connect(lambda: presenter.go_by(1))
        self._number.valueChanged.connect(lambda number: presenter.go(number - 1))
        self._picture.painted.connect(presenter.drag)
        self._picture.paint_ended.connect(presenter.drop)
        self._picture.clicked.connect(presenter.click)
        self._picture.closed.connect(presenter.enclose)
        self._picture.pointed.connect(presenter.point)

    def _shortcut(self, keys: str, action: Callable[[], object]) -> None:
        shortcut = QShortcut(QKeySequence(keys), self)
        shortcut.setContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        shortcut.activated.connect(action)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        for name, text in _texts().items():
            self._buttons[name].setText(text)
        for name, keys in KEYS.items():
            self._buttons[name].setToolTip(QKeySequence(keys).toString(NATIVE))
        self._tool_label.setText(_("Tool"))
        tools = (_("&Brush"), _("F&ill"), _("Pol&ygon"))
        for tool, text in zip(self._tools.values(), tools, strict=True):
            tool.setText(text)
        self._radius_label.setText(_("Bru&sh radius"))
        self._radius.setSuffix(_(" px"))
        self._enclose.setText(_("Fill the polygon"))
        self._beyond.setText(_("Paint beside the person, too"))
        self._labels_label.setText(_("&Limb"))
        self._labels.setAccessibleName(_("Limb"))
        self._number_label.setText(_("Fra&me"))
        self._previous.setText(_("Previous"))
        self._next.setText(_("Next"))
        for button, keys in ((self._previous, PREVIOUS), (self._next, NEXT)):
            button.setToolTip(QKeySequence(keys).toString(NATIVE))
        self._picture.setAccessibleName(_("Labelled frame"))
        self._picture.set_placeholder(_("Open a recording with depth to label the limbs in it."))
        self._bar.setAccessibleName(_("Frames that are done"))
        self._word_labels()

    def ask_folder(self, title: str) -> None:
        heading = _("Folder for labelled images of {recording}; they are not sealed there")
        dialog = QFileDialog(self, heading.format(recording=title))
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.fileSelected.connect(lambda name: self.presenter.choose_folder(Path(name)))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.open()

    def show_recording(self, name: str, folder: str) -> None:
        self._title.setText(name)
        self._title.setToolTip(folder)

    def show_labels(self, names: tuple[str, ...], colors: UInt8Array) -> None:
        self._names = names
        self._labels.clear()
        for color in colors:
            swatch = QPixmap(SWATCH, SWATCH)
            swatch.fill(QColor(*map(int, color)))
            self._labels.addItem(QListWidgetItem(QIcon(swatch), ""))
        self._word_labels()
        self._labels.setCurrentRow(1)

    def show_picture(self, picture: UInt8Array, person: BoolArray) -> None:
        self._picture.set_picture(picture)
        self._overlays = (Region(person),)
        self._show_overlays()

    def show_corners(self, corners: Corners) -> None:
        curve = (Curve((*corners, corners[0]), "selected"),) if corners else ()
        dots = tuple(Dot(u, v, 2.0, role="selected") for u, v in corners)
        self._corners = (*curve, *dots)
        self._show_overlays()

    def show_under(self, name: str) -> None:
        from adibas.pipeline.limb_names import limb_text

        self._under.setText(_("Here: {limb}").format(limb=limb_text(name)) if name else "")

    def show_progress(self, index: int, progress: "LabellingProgress") -> None:
        self._number.blockSignals(True)
        self._number.setRange(1, progress.n_frames)
        self._number.setValue(index + 1)
        self._number.blockSignals(False)
        self._bar.setRange(0, progress.n_frames)
        self._bar.setValue(len(progress.done))
        state = _("not labelled")
        if index in progress.done:
            state = _("done")
        elif index in progress.begun:
            state = _("begun")
        self._told.setText(
            _("of {total}: {state}. {done} done, {begun} begun.").format(
                total=progress.n_frames,
                state=state,
                done=len(progress.done),
                begun=len(progress.begun),
            )
        )

    def show_allowed(self, allowed: Allowed) -> None:
        self._buttons["open"].setEnabled(not allowed.is_busy)
        for name in ("propose", "finish"):
            self._buttons[name].setEnabled(allowed.can_edit)
        self._buttons["carry"].setEnabled(allowed.can_edit and not allowed.is_last)
        self._buttons["undo"].setEnabled(allowed.can_edit and allowed.can_undo)
        self._buttons["redo"].setEnabled(allowed.can_edit and allowed.can_redo)
        self._enclose.setEnabled(allowed.can_edit and allowed.can_enclose)
        for part in (self._picture, self._previous, self._next, self._number):
            part.setEnabled(allowed.can_edit)

    def _show_overlays(self) -> None:
        self._picture.set_overlays((*self._overlays, *self._corners))

    def _on_tool(self, tool: Tool) -> None:
        self.presenter.choose_tool(tool)
        self._picture.set_painting(is_on=self.presenter.draws_by_dragging)

    def _word_labels(self) -> None:
        from adibas.pipeline.limb_names import limb_text

        texts = (_("Nothing (rub out)"), *map(limb_text, self._names))
        for row, text in enumerate(texts[: self._labels.count()]):
            self._labels.item(row).setText(text)
        self._labels.setMinimumHeight(LINES_OF_LABELS * self.fontMetrics().height())

    def _ask(self) -> None:
        dialog = QFileDialog(self, _("Open a recording"))
        dialog.setNameFilter(_("Recordings") + f" {RECORDINGS}")
        dialog.fileSelected.connect(lambda name: self.presenter.open(Path(name)))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.open()


def _texts() -> dict[str, str]:
    return {
        "open": _("&Open..."),
        "undo": _("&Undo"),
        "redo": _("&Redo"),
        "propose": _("&Propose"),
        "carry": _("&Carry to the next frame"),
        "finish": _("Frame is don&e"),
    }
