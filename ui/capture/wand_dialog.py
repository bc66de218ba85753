"""The dialog that measures a wand: picture, ends, length, verdict. No decisions."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.calibration.wand import WandCheck, WandResult
from adibas.data.landmark_texts import landmark_text
from adibas.pipeline.wand_check import SeenWand
from adibas.texts import translate as _
from ui.capture.wand_presenter import Ends, WandPresenter
from ui.widgets.image_view import ImageView
from ui.widgets.look import show_kind
from ui.widgets.number_fields import DecimalField
from ui.widgets.overlays import Dot, Line, Overlay

KINDS = {WandResult.PASSED: "good", WandResult.UNSURE: "warning", WandResult.FAILED: "bad"}
SHORTEST_MM, LONGEST_MM = 50.0, 3000.0
LETTERS_IN_A_LINE = 72
PICTURE_LINES, LEAST_PICTURE_LINES = 13, 3


class WandDialog(QDialog):
    """Stays open until it is closed: a wand is measured as often as one likes."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(_("Check with a wand"))
        self._advice, self._verdict, self._lack = (QLabel(self) for _number in range(3))
        for label in (self._advice, self._verdict, self._lack):
            label.setWordWrap(True)
        self._lack.setProperty("kind", "warning")
        self._picture = ImageView(self)
        self._picture.setAccessibleName(_("Picture of the wand"))
        self._picture.set_placeholder(_("No picture yet"))
        self._length = DecimalField(self)
        self._length.setRange(SHORTEST_MM, LONGEST_MM)
        self._length.setDecimals(1)
        self._length.setSuffix(_(" mm"))
        self._length.setKeyboardTracking(False)
        self._ends = (QComboBox(self), QComboBox(self))
        self._measure = QPushButton(_("&Measure"), self)
        self._measure.setProperty("main", "true")
        self._close = QPushButton(_("Cl&ose"), self)
        self._seen: SeenWand | None = None
        self._behind = parent.window()
        self._lay_out()

    def _lay_out(self) -> None:
        self._advice.setText(
            _(
                "Hold a stick with two markers of the learned colour before the sensor, across "
                "the line of sight, where patients stand. Nobody wears markers meanwhile. Its "
                "length is that between the middles of the markers, measured with a ruler."
            )
        )
        form = QFormLayout()
        form.addRow(_("&Length of the wand"), self._length)
        form.addRow(_("&First end"), self._ends[0])
        form.addRow(_("&Second end"), self._ends[1])
        buttons = QHBoxLayout()
        buttons.addStretch(1)
        buttons.addWidget(self._close)
        buttons.addWidget(self._measure)
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 20)
        column.setSpacing(12)
        column.addWidget(self._advice)
        column.addWidget(self._picture, 1)
        column.addLayout(form)
        column.addWidget(self._verdict)
        column.addWidget(self._lack)
        column.addLayout(buttons)
        self._column = column
        self._show_ends(None)
        self._make_room()

    def bind(self, presenter: WandPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._measure.clicked.connect(presenter.measure)
        self._length.valueChanged.connect(presenter.set_length)
        for box in self._ends:
            box.activated.connect(self._on_chosen)
        self._close.clicked.connect(self.reject)
        self.finished.connect(lambda _result: presenter.close())

    def show_length(self, length_mm: float) -> None:
        self._length.setValue(length_mm)

    def show_readiness(self, sentence: str, *, is_ready: bool) -> None:
        self._lack.setText(sentence)
        self._lack.setVisible(bool(sentence))
        self._make_room()
        self._measure.setEnabled(is_ready)

    def show_measuring(self, *, is_measuring: bool) -> None:
        self._measure.setEnabled(not is_measuring)
        if is_measuring:
            self._say(_("Hold still..."), "quiet")

    def show_seen(self, seen: SeenWand, ends: Ends | None) -> None:
        self._seen = seen
        self._picture.set_picture(seen.picture_rgb)
        for box in self._ends:
            box.clear()
            box.addItems([landmark_text(marker.label) for marker in seen.markers])
        self._show_ends(ends)

    def show_check(self, check: WandCheck, when: str) -> None:
        text = check.sentence.text
        self._say(f"{when}: {text}" if when else text, KINDS[check.result])

    def show_problem(self, sentence: str) -> None:
        self._say(sentence, "warning")

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802  (Qt's name)
        """Close as by the button: `finished` is told then."""
        self.reject()
        event.accept()

    def _on_chosen(self, _index: int) -> None:
        first, second = (box.currentIndex() for box in self._ends)
        if min(first, second) >= 0:
            self._draw((first, second))
            self._presenter.choose((first, second))

    def _show_ends(self, ends: Ends | None) -> None:
        n = 0 if self._seen is None else len(self._seen.markers)
        for box, index in zip(self._ends, ends or (-1, -1), strict=True):
            box.setCurrentIndex(index)
            box.setEnabled(n > 0)
        self._draw(ends)

    def _draw(self, ends: Ends | None) -> None:
        if self._seen is None:
            return
        chosen = () if ends is None else ends
        overlays: list[Overlay] = [
            Dot(one.u, one.v, one.radius_px, one.label, "selected" if i in chosen else "marker")
            for i, one in enumerate(self._seen.markers)
        ]
        if ends is not None and ends[0] != ends[1]:
            one, other = (self._seen.markers[i] for i in ends)
            overlays.append(Line(one.u, one.v, other.u, other.v))
        self._picture.set_overlays(tuple(overlays))

    def _make_room(self) -> None:
        """Grow with the sentences, a layout alone does not count their lines; the picture yields.

        It is smaller where all together would be higher than the window behind.
        """
        metrics, room_px = self.fontMetrics(), self._behind.height()
        width = metrics.averageCharWidth() * LETTERS_IN_A_LINE
        picture_px = PICTURE_LINES * metrics.lineSpacing()
        self._picture.setMinimumHeight(picture_px)
        excess_px = max(self._column.totalHeightForWidth(width) - room_px, 0)
        least_px = LEAST_PICTURE_LINES * metrics.lineSpacing()
        self._picture.setMinimumHeight(max(picture_px - excess_px, least_px))
        self.setMinimumSize(width, self._column.totalHeightForWidth(width))

    def _say(self, text: str, kind: str) -> None:
        self._verdict.setText(text)
        show_kind(self._verdict, kind)
        self._make_room()
