"""Forms for a new landmark and a new measure of a protocol, for whoever does not write JSON."""

from collections.abc import Mapping
from itertools import pairwise

from PySide6.QtCore import Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from adibas.data.posture import VIEWS
from adibas.data.protocols import KINDS, axes_of
from adibas.measures.protocol_edits import NewEntry, NewMeasure
from adibas.texts import message, spoken_language
from adibas.texts import translate as _
from ui.view_names import VIEW_NAMES
from ui.widgets.flow import in_a_flow
from ui.widgets.scrolled import Scrolled, window_room

KIND_TEXTS = {
    "line_to_horizontal": message("line against the horizontal"),
    "line_to_vertical": message("line against the vertical"),
    "line_to_line": message("one line against another"),
    "deviation_from_straight": message("deviation from a straight line"),
    "angle": message("angle at the second point"),
    "distance": message("distance"),
    "distance_difference": message("difference of two distances"),
    "offset": message("how far a point lies beside another"),
    "offset_share": message("the same, as a share of another way"),
    "asymmetry_index": message("asymmetry index of two ways"),
    "side_share": message("difference of two ways, as a share of their sum"),
    "trunk_symmetry": message("symmetry index of the trunk (middle below and above, three pairs)"),
}
DIRECTIONS = {
    "left": message("to the left"),
    "right": message("to the right"),
    "anterior": message("to the front"),
    "posterior": message("to the back"),
    "up": message("upwards"),
}
"""Of the patient."""
MOST_POINTS = max(rule.n_points for rule in KINDS.values())
FIELD_LETTERS = 36
Ok = QDialogButtonBox.StandardButton.Ok
Cancel = QDialogButtonBox.StandardButton.Cancel


class LandmarkForm(QDialog):
    """A name, and the views in which the landmark is seen."""

    made = Signal(object)
    """A `NewEntry`."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._name = QLineEdit(self)
        self._name.setMinimumWidth(FIELD_LETTERS * self.fontMetrics().averageCharWidth())
        self._views = {view: QCheckBox(self) for view in VIEWS}
        self._box = QDialogButtonBox(Ok | Cancel, self)
        self._form = QFormLayout()
        self._form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        self._name_label = self._row(self._name)
        self._form.addRow(_("Seen in"), in_a_flow(*self._views.values()))
        self._inside = Scrolled(self)
        self._inside.column.addLayout(self._form)
        self._inside.column.addStretch()
        self._column = QVBoxLayout(self)
        self._column.addWidget(self._inside, 1)
        self._column.addWidget(self._box)
        self._box.accepted.connect(self._on_accepted)
        self._box.rejected.connect(self.reject)
        self._name.textChanged.connect(lambda _text: self._allow())
        for box in self._views.values():
            box.toggled.connect(lambda _is_on: self._on_changed())
        self._name_label.setText(_("&Name"))
        self.setWindowTitle(_("New landmark"))
        for view, box in self._views.items():
            box.setText(_(VIEW_NAMES[view]))
        self._box.button(Ok).setText(_("&Add to the protocol"))
        self._box.button(Ok).setEnabled(False)
        self._box.button(Cancel).setText(_("Cancel"))

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802  (Qt's name)
        self._make_room()
        super().showEvent(event)

    def _make_room(self) -> None:
        """Be as large as all fields need, within the window."""
        margins, inside = self.contentsMargins() + self._column.contentsMargins(), self._inside
        inside.column.invalidate()  # a row may have come or gone
        width = inside.column.minimumSize().width() + inside.verticalScrollBar().sizeHint().width()
        width = min(width + margins.left() + margins.right(), window_room(self).width())
        height = inside.height_in(self, width, self._box.sizeHint().height())
        self.setMinimumSize(width, height)

    def _row(self, field: QWidget) -> QLabel:
        label = QLabel(self)
        label.setBuddy(field)
        self._form.addRow(label, field)
        return label

    def _chosen_views(self) -> tuple[str, ...]:
        return tuple(view for view, box in self._views.items() if box.isChecked())

    def _on_changed(self) -> None:
        self._allow()

    def _is_whole(self) -> bool:
        return bool(self._name.text().strip() and self._chosen_views())

    def _allow(self) -> None:
        self._box.button(Ok).setEnabled(self._is_whole())

    def _entry(self) -> NewEntry:
        return NewEntry(self._name.text().strip(), spoken_language(), self._chosen_views())

    def _on_accepted(self) -> None:
        self.made.emit(self._entry())
        self.accept()


class MeasureForm(LandmarkForm):
    """A name, the views, what is measured between which landmarks, and what its sign means.

    Parameters
    ----------
    landmarks : Mapping
        Names by id.
    """

    measured = Signal(object, object)
    """A `NewEntry` and its `NewMeasure`."""

    def __init__(self, landmarks: Mapping[str, str], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(_("New measure"))
        self._kind, self._axis, self._positive = QComboBox(self), QComboBox(self), QLineEdit(self)
        self._points = [QComboBox(self) for _number in range(MOST_POINTS)]
        self._row(self._kind).setText(_("&What is measured"))
        for number, box in enumerate(self._points, 1):
            self._row(box).setText(_("Landmark &{number}").format(number=number))
            for landmark_id, name in landmarks.items():
                box.addItem(name, landmark_id)
            box.setCurrentIndex(min(number, box.count()) - 1)
        self._row(self._axis).setText(_("Positive &direction"))
        self._row(self._positive).setText(_("A positive value &means"))
        for kind, told in KIND_TEXTS.items():
            self._kind.addItem(_(told), kind)
        self._kind.currentIndexChanged.connect(lambda _index: self._on_changed())
        self._positive.textChanged.connect(lambda _text: self._allow())
        fields = [*self._views.values(), self._kind, *self._points, self._axis, self._positive]
        for before, after in pairwise([self._name, *fields, self._box]):
            self.setTabOrder(before, after)
        self._on_changed()

    def _on_changed(self) -> None:
        """Show as many landmarks as the kind takes, and the directions that the views show."""
        kind = self._kind.currentData()
        rule, views = KINDS[kind], self._chosen_views() or VIEWS
        for number, box in enumerate(self._points):
            self._form.setRowVisible(box, number < rule.n_points)
        for field in (self._axis, self._positive):
            self._form.setRowVisible(field, rule.has_axis)
        before = self._axis.currentData()
        self._axis.clear()
        for axis, told in DIRECTIONS.items():
            if any(axis in axes_of(kind, view) for view in views):
                self._axis.addItem(_(told), axis)
        self._axis.setCurrentIndex(max(self._axis.findData(before), 0))
        self._allow()
        self._make_room()

    def _is_whole(self) -> bool:
        has_sign = KINDS[self._kind.currentData()].has_axis
        return super()._is_whole() and bool(self._positive.text().strip() or not has_sign)

    def _on_accepted(self) -> None:
        kind = str(self._kind.currentData())
        rule = KINDS[kind]
        points = tuple(str(box.currentData()) for box in self._points[: rule.n_points])
        sign = (str(self._axis.currentData()), self._positive.text()) if rule.has_axis else ("", "")
        self.measured.emit(self._entry(), NewMeasure(kind, points, *sign))
        self.accept()
