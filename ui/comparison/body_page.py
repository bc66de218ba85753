"""The whole body in both sessions: surfaces that can be turned, girths and volumes."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QSizePolicy, QWidget

from adibas.data.landmark_texts import landmark_text
from adibas.texts import decimal_text, message
from adibas.texts import translate as _
from ui.comparison.body_content import Bodies, SeenBody
from ui.comparison.surface_page import SurfacePage
from ui.view_names import VIEW_NAMES
from ui.widgets.space_view import SpaceView

NO_BODIES = message("Neither session shows a body.")


class BodyPage(SurfacePage):
    """Two surfaces above, the measures below."""

    report_asked = Signal()
    """The report on the later body is wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bodies = Bodies()
        self._spaces = (SpaceView(self), SpaceView(self))
        self._facts = (QLabel(self), QLabel(self))
        self._report = QPushButton(self)
        pictures = QWidget(self)
        grid = QGridLayout(pictures)
        grid.setContentsMargins(0, 0, 0, 0)
        columns = zip(self.titles, self._spaces, self._facts, strict=True)
        for column, parts in enumerate(columns):
            for row, part in enumerate(parts):
                grid.addWidget(part, row, column)
            grid.setColumnStretch(column, 1)
        grid.setRowStretch(1, 1)
        grid.addWidget(self._report, grid.rowCount(), 1, Qt.AlignmentFlag.AlignRight)
        for space in self._spaces:  # it takes the room there is, and asks for none
            space.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)
        for label in self._facts:
            label.setWordWrap(True)
            label.setProperty("kind", "quiet")
        self.lay_out(pictures)
        self._report.clicked.connect(self.report_asked)

    def retranslate(self) -> None:
        super().retranslate()
        self._spaces[0].setAccessibleName(_("Surface of the body, earlier session"))
        self._spaces[1].setAccessibleName(_("Surface of the body, later session"))
        for space in self._spaces:
            space.setToolTip(_("Drag or arrows: turn. Wheel or + and -: nearer. 0: from behind."))
        self.table.retranslate(_("Girths and volumes"))
        self._report.setText(_("Re&port on the body..."))
        self.show_bodies(self._bodies)

    def show_bodies(self, bodies: Bodies) -> None:
        """Show what was joined of both sessions."""
        self._bodies = bodies
        both = (bodies.earlier, bodies.later)
        has_any = any(one is not None for one in both)
        self._report.setEnabled(bodies.later is not None)
        self.show_sentences(bodies.sentences, "" if has_any else _(NO_BODIES))
        for body, space, facts in zip(both, self._spaces, self._facts, strict=True):
            space.setVisible(body is not None)
            space.show_space(None if body is None else body.space)
            facts.setText("" if body is None else _facts_of(body))
        self.show_measures(*(() if one is None else one.measures for one in both))


def _facts_of(body: SeenBody) -> str:
    """Say what a surface is made of, and how well the views agree."""
    told = [_("Views: {views}.").format(views=", ".join(_(VIEW_NAMES[v]) for v in body.views))]
    if body.stature_mm is not None:
        told.append(_("Stature: {mm} mm.").format(mm=decimal_text(body.stature_mm, 0)))
    if body.apart_mm is not None:
        apart = decimal_text(body.apart_mm, 1)
        told.append(_("The views lie {mm} mm apart.").format(mm=apart))
    if body.landmarks_apart_mm:
        marks = ", ".join(
            f"{landmark_text(name)} {decimal_text(mm, 1)} mm"
            for name, mm in body.landmarks_apart_mm.items()
        )
        told.append(_("From the mean of several views: {landmarks}.").format(landmarks=marks))
    return " ".join(told)
