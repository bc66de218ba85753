"""The back in both sessions: maps, the line and the curves of the spine, and a table."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QWidget,
)

from adibas.texts import message
from adibas.texts import translate as _
from ui.comparison.back_content import Backs
from ui.comparison.back_plots import LARGEST_MM, AsymmetryMap, Curve, SpinePlot
from ui.comparison.surface_page import SurfacePage
from ui.theme import Theme

NO_BACKS = message("Neither session shows a back.")
CURVES: tuple[tuple[Curve, str], ...] = (
    ("profile_mm", message("Profile of the spine")),
    ("aside_mm", message("Line of the spine")),
    ("rotation_deg", message("Surface rotation")),
)


class BackPage(SurfacePage):
    """Two maps and a plot above, the measures below."""

    report_asked = Signal()
    """The report on the later back is wanted."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._backs = Backs()
        self._maps = (AsymmetryMap(theme, self), AsymmetryMap(theme, self))
        self._plot, self._curve = SpinePlot(theme, self), QComboBox(self)
        self._legend, self._report = QLabel(self), QPushButton(self)
        for curve, title in CURVES:
            self._curve.addItem(title, curve)
        pictures = QWidget(self)
        grid = QGridLayout(pictures)
        grid.setContentsMargins(0, 0, 0, 0)
        heads, pages = (*self.titles, self._curve), (*self._maps, self._plot)
        for column, (head, page) in enumerate(zip(heads, pages, strict=True)):
            grid.addWidget(head, 0, column)
            grid.addWidget(page, 1, column)
            grid.setColumnStretch(column, 1)
        grid.setRowStretch(1, 1)
        below = QHBoxLayout()
        below.addWidget(self._legend, 1)
        below.addWidget(self._report)
        grid.addLayout(below, 2, 0, 1, len(heads))
        self._legend.setWordWrap(True)
        self._legend.setProperty("kind", "quiet")
        self.lay_out(pictures)
        self._report.clicked.connect(self.report_asked)
        self._curve.currentIndexChanged.connect(lambda _index: self._show_curve())

    def retranslate(self) -> None:
        super().retranslate()
        self._maps[0].setAccessibleName(_("Asymmetry of the back, earlier session"))
        self._maps[1].setAccessibleName(_("Asymmetry of the back, later session"))
        self._plot.setAccessibleName(_("Plot of the spine in both sessions"))
        self._curve.setAccessibleName(_("What of the spine is drawn"))
        for index, (_curve, title) in enumerate(CURVES):
            self._curve.setItemText(index, _(title))
        self.table.retranslate(_("Measures of the back"))
        self._report.setText(_("Re&port on the back..."))
        self._legend.setText(
            _(
                "Maps, seen from behind: red lies further back than the other side, blue further "
                "forward; the colours end at {mm} mm. Plot: dashed before, solid now."
            ).format(mm=round(LARGEST_MM))
        )
        self.show_backs(self._backs)

    def show_backs(self, backs: Backs) -> None:
        """Show what was found in both sessions."""
        self._backs = backs
        both = (backs.earlier, backs.later)
        has_any = any(one is not None for one in both)
        self.show_sentences(backs.sentences, "" if has_any else _(NO_BACKS))
        for picture, back in zip(self._maps, both, strict=True):
            picture.show_back(back)
            picture.setVisible(back is not None)
        self._report.setEnabled(backs.later is not None)
        self._show_curve()
        self.show_measures(*(() if one is None else one.measures for one in both))

    def _show_curve(self) -> None:
        self._plot.show_backs(self._backs, self._curve.currentData())
