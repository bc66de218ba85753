"""The learner's screen: a picture to click on, and controls beside it. No decisions."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QFileDialog,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.arrays import BoolArray, UInt8Array
from adibas.markers.detection import Detections
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.markers.controls import LearnerControls
from ui.markers.ports import Mode, Shown
from ui.markers.presenter import LearnerPresenter
from ui.widgets.image_view import ImageView
from ui.widgets.overlays import Dot, Overlay, Region
from ui.widgets.screen import Screen
from ui.widgets.side_panel import SidePanel

PICTURES = "(*.png *.jpg *.jpeg *.mcap *.oni)"
COLORS = "(*.json)"


class LearnerScreen(Screen):
    """Click on a marker: its region grows, its colour is learned, the markers are found."""

    name = "markers"

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title, self._advice, self._count = QLabel(self), QLabel(self), QLabel(self)
        self._title.setProperty("kind", "title")
        self._advice.setProperty("kind", "quiet")
        for label in (self._title, self._advice, self._count):
            label.setWordWrap(True)
        self._picture = ImageView(self)
        self._controls = LearnerControls(self)
        self._buttons = {name: QPushButton(self) for name in _BUTTONS}
        self._buttons["use"].setProperty("main", "true")
        self._taken: Region | None = None
        self._found: Detections | None = None
        self._mode: Mode = "color"
        self._lay_out()
        self.retranslate()

    def _lay_out(self) -> None:
        left = QVBoxLayout()
        left.addWidget(self._title)
        left.addWidget(self._advice)
        left.addWidget(self._picture, 1)
        row = QHBoxLayout()
        for name in ("freeze", "sensor"):
            row.addWidget(self._buttons[name])
        row.addStretch()
        left.addLayout(row)
        panel = SidePanel(self)
        panel.column.addWidget(self._controls, 1)
        files = QGridLayout()
        for index, name in enumerate(("save", "load", "open", "reset")):
            files.addWidget(self._buttons[name], index // 2, index % 2)
        panel.column.addLayout(files)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(16)
        layout.addLayout(left, 1)
        right = QVBoxLayout()
        right.addWidget(panel, 1)
        right.addWidget(self._count)
        right.addWidget(self._buttons["use"])
        layout.addLayout(right)

    def bind(self, presenter: LearnerPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._picture.clicked.connect(presenter.click)
        self._controls.mode_chosen.connect(presenter.set_mode)
        self._controls.sensitivity_moved.connect(presenter.set_sensitivity)
        self._controls.clusters_chosen.connect(presenter.set_clusters)
        self._controls.brightness_moved.connect(presenter.set_brightness)
        self._controls.discard_asked.connect(presenter.discard)
        for name, action in (
            ("freeze", presenter.freeze),
            ("sensor", presenter.show_sensor),
            ("use", presenter.use),
            ("reset", presenter.reset),
            ("open", self._ask_picture),
            ("save", self._ask_place),
            ("load", self._ask_colors),
        ):
            self._buttons[name].clicked.connect(action)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("What do the markers look like?"))
        self._show_advice()
        self._picture.setAccessibleName(_("Picture to click on"))
        self._picture.set_placeholder(_("No picture yet. Show the sensor, or open a picture."))
        for name, text in (
            ("freeze", _("&Freeze")),
            ("sensor", _("Show the sens&or")),
            ("open", _("Open a &picture...")),
            ("use", _("&Use these markers")),
            ("save", _("Sa&ve...")),
            ("load", _("Lo&ad...")),
            ("reset", _("R&eset")),
        ):
            self._buttons[name].setText(text)
        self._controls.retranslate()
        self._show_count()

    def entered(self) -> None:
        self._presenter.enter()
        self._picture.setFocus()

    def left(self) -> None:
        self._presenter.leave()

    def closed(self) -> None:
        self._presenter.close()

    def draft(self) -> str:
        """Return the markers that were learned and not used yet."""
        return self._presenter.draft()

    def take_back(self, draft: str) -> None:
        """Go on with the markers that were learned."""
        self._presenter.take_back(draft)

    def unsaved(self) -> tuple[str, ...]:
        """Name the markers that were learned, unless they are in use or in a file."""
        return (_("The markers that were learned"),) if self._presenter.is_unsaved else ()

    def show_picture(self, picture_rgb: UInt8Array | None, *, is_frozen: bool) -> None:
        self._picture.set_picture(picture_rgb)
        self._buttons["freeze"].setEnabled(picture_rgb is not None and not is_frozen)

    def show_taken(self, taken: BoolArray | None) -> None:
        self._taken = None if taken is None else Region(taken, "selected", is_filled=True)
        self._show_overlays()

    def show_found(self, found: Detections | None) -> None:
        self._found = found
        self._show_overlays()
        self._show_count()

    def show_controls(self, shown: Shown) -> None:
        self._controls.show_controls(shown)
        self._buttons["use"].setEnabled(shown.has_target)
        self._buttons["save"].setEnabled(bool(shown.swatches) and shown.mode == "color")
        self._buttons["sensor"].setEnabled(shown.has_picture)
        if shown.mode != self._mode:
            self._mode = shown.mode
            self._show_advice()

    def open_file(self, path: Path) -> None:
        """Learn on a dropped picture or recording."""
        self._presenter.open_file(path)

    def _show_advice(self) -> None:
        if self._mode == "led":
            advice = _("Freeze the picture, then lower the brightness until every LED is found.")
        else:
            advice = _(
                "Freeze the picture, then click on the middle of a marker. Click on more of them."
            )
        self._advice.setText(advice)

    def _show_overlays(self) -> None:
        overlays: list[Overlay] = [] if self._taken is None else [self._taken]
        if self._found is not None:
            overlays += [Dot(b.u, b.v, b.radius_px) for b in self._found.blobs]
            overlays += [
                Dot(b.u, b.v, 4.0, role="rejected", tooltip=_(b.reason))
                for b in self._found.rejected
            ]
        self._picture.set_overlays(tuple(overlays))

    def _show_count(self) -> None:
        if self._found is None:
            self._count.setText("")
            return
        n_found, n_rejected = len(self._found.blobs), len(self._found.rejected)
        found = translate_plural("{n} marker found", "{n} markers found", n_found)
        rejected = translate_plural(
            "{n} blob of that colour is no marker",
            "{n} blobs of that colour are no markers",
            n_rejected,
        )
        lines = [found.format(n=n_found)]
        if n_rejected:
            lines.append(rejected.format(n=n_rejected))
        self._count.setText("\n".join(lines))

    def _ask_picture(self) -> None:
        dialog = QFileDialog(self, _("Open a picture or a recording"))
        kinds = _("Pictures and recordings")
        dialog.setNameFilter(f"{kinds} {PICTURES}")
        dialog.fileSelected.connect(lambda name: self._presenter.open_file(Path(name)))
        _open(dialog)

    def _ask_colors(self) -> None:
        dialog = QFileDialog(self, _("Load learned colours"))
        kinds = _("Learned colours")
        dialog.setNameFilter(f"{kinds} {COLORS}")
        dialog.fileSelected.connect(lambda name: self._presenter.load(Path(name)))
        _open(dialog)

    def _ask_place(self) -> None:
        dialog = QFileDialog(self, _("Save the learned colours"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        kinds = _("Learned colours")
        dialog.setNameFilter(f"{kinds} {COLORS}")
        dialog.setDefaultSuffix("json")
        dialog.fileSelected.connect(lambda name: self._presenter.save(Path(name)))
        _open(dialog)


_BUTTONS = ("freeze", "sensor", "open", "use", "save", "load", "reset")


def _open(dialog: QFileDialog) -> None:
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
