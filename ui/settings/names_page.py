"""The page of names: who gives them to markers, and what corrected sessions could teach."""

from collections.abc import Mapping
from datetime import datetime
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QEvent, QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QHeaderView,
    QLabel,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.settings.names_presenter import NamesPresenter
from ui.view_names import VIEW_NAMES
from ui.widgets.dates import day_text
from ui.widgets.flow import FlowLayout
from ui.widgets.line_table import TEXTS

if TYPE_CHECKING:
    from adibas.pipeline.names_in_use import NamesInUse

LINE_HEIGHT = 1.7
"""Of a row, in letters."""


class NamesPage(QWidget):
    """A table above; below it what can be done for its current line, and why not."""

    learned = Signal(object)
    """From the captures of a `LandmarkSet`."""
    left = Signal(object)
    """The own model of a `LandmarkSet`."""
    closed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: tuple[NamesInUse, ...] = ()
        self._titles: tuple[str, ...] = ()
        self._is_learning = False
        self._hint, self._told = QLabel(self), QLabel(self)
        self._table = QTableWidget(0, 4, self)
        self._learn, self._back, self._close = (QPushButton(self) for _ in range(3))
        self._lay_out()
        self._table.itemSelectionChanged.connect(self._show_current)
        self._learn.clicked.connect(lambda: self._send(self.learned))
        self._close.clicked.connect(self.closed)
        self._back.clicked.connect(lambda: self._send(self.left))
        self.retranslate()

    def _lay_out(self) -> None:
        for label in (self._hint, self._told):
            label.setWordWrap(True)
        self._hint.setProperty("kind", "quiet")
        self._table.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
        self._table.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        self._table.setSelectionMode(QTableWidget.SelectionMode.SingleSelection)
        self._table.setTabKeyNavigation(False)
        self._table.setWordWrap(False)
        self._table.verticalHeader().hide()
        self._learn.setProperty("main", "true")
        below = FlowLayout()
        for button in (self._learn, self._back, self._close):
            below.addWidget(button)
        column = QVBoxLayout(self)
        column.addWidget(self._hint)
        column.addWidget(self._table, 1)
        column.addWidget(self._told)
        column.addLayout(below)

    def bind(self, presenter: NamesPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.learned.connect(presenter.learn)
        self.left.connect(presenter.go_back)

    def entered(self) -> None:
        """Show what is so now."""
        self._presenter.enter()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._hint.setText(
            _(
                "Names that you correct in the review can be learned from: markers then get their "
                "names from a model of your own. It holds nothing that tells who a patient is."
            )
        )
        self._table.setAccessibleName(_("Who names the markers"))
        self._table.setHorizontalHeaderLabels(
            [_("Landmarks"), _("Named by"), _("Corrected sessions"), _("New ones")]
        )
        self._close.setText(_("Back to the &protocols"))
        self._learn.setText(_("&Learn from these sessions"))
        self._show_rows()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Give the lines the height of the letters."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._fit()

    def show_names(self, rows: "tuple[NamesInUse, ...]", titles: tuple[str, ...]) -> None:
        """Show who names which landmarks; the line that was chosen stays chosen."""
        self._rows, self._titles = rows, titles
        self._show_rows()

    def show_learning(self, *, is_running: bool) -> None:
        """Allow nothing else meanwhile."""
        self._is_learning = is_running
        self._show_current()

    def _show_rows(self) -> None:
        chosen = max(self._table.currentRow(), 0)
        with QSignalBlocker(self._table):
            self._table.setRowCount(len(self._rows))
            for line, (row, title) in enumerate(zip(self._rows, self._titles, strict=True)):
                for column, text in enumerate(_cells(row, title)):
                    self._table.setItem(line, column, QTableWidgetItem(text))
            self._table.setCurrentCell(min(chosen, len(self._rows) - 1), 0)
        self._table.setVisible(bool(self._rows))
        self.setFocusProxy(self._table if self._rows else self._close)
        self._fit()
        self._show_current()

    def _fit(self) -> None:
        height = round(self.fontMetrics().height() * LINE_HEIGHT)
        self._table.verticalHeader().setDefaultSectionSize(height)
        header = self._table.horizontalHeader()
        header.setDefaultAlignment(TEXTS)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)

    @property
    def _current(self) -> "NamesInUse | None":
        line = self._table.currentRow()
        return self._rows[line] if 0 <= line < len(self._rows) else None

    def _show_current(self) -> None:
        row = self._current
        has_own = row is not None and row.learned is not None
        is_rich = row is not None and row.n_captures >= row.n_needed
        self._told.setText(_state(row))
        self._learn.setVisible(row is not None)
        self._learn.setEnabled(is_rich and not self._is_learning)
        self._back.setVisible(has_own)
        self._back.setEnabled(not self._is_learning)
        self._back.setText(
            _("Go &back to the shipped model")
            if row is not None and row.is_shipped_known
            else _("&Use the own model no more")
        )

    def _send(self, signal: Any) -> None:
        if self._current is not None:
            signal.emit(self._current.which)


def _cells(row: "NamesInUse", title: str) -> tuple[str, ...]:
    view = f" · {_(VIEW_NAMES[row.which.view])}" if row.which.view else ""
    return (
        (title or _("Sessions without a protocol")) + view,
        _namer(row),
        str(row.n_sessions),
        str(row.n_sessions_since),
    )


def _namer(row: "NamesInUse") -> str:
    if row.learned is not None:
        return _("Own model")
    return _("Shipped model") if row.is_shipped_known else _("Nobody")


def _state(row: "NamesInUse | None") -> str:
    """Return what is known of a line: its model, and what could be learned."""
    if row is None:
        return _(
            "No session has corrected names yet. Name or correct the markers of a capture in the "
            "review."
        )
    told = [] if row.learned is None else [_learned(row.learned, row.learned_utc)]
    if row.n_captures < row.n_needed:
        told.append(
            _(
                "{n} captures are corrected, and a model needs {least}. Name the markers of more "
                "captures in the review."
            ).format(n=row.n_captures, least=row.n_needed)
        )
    elif row.n_sessions_since:
        told.append(_corrected(row))
    else:
        told.append(_("Nothing was corrected since."))
    return "\n".join(told)


def _corrected(row: "NamesInUse") -> str:
    n = row.n_sessions_since
    if row.learned is None:
        text = translate_plural(
            "Names were corrected in {n} session: it can be learned from.",
            "Names were corrected in {n} sessions: they can be learned from.",
            n,
        )
    else:
        text = translate_plural(
            "Names were corrected in {n} session since: it can be learned from.",
            "Names were corrected in {n} sessions since: they can be learned from.",
            n,
        )
    return text.format(n=n)


def _learned(learned: Mapping[str, Any], learned_utc: datetime | None) -> str:
    """Return what an own model was learned from, and how good it was found."""
    when = day_text(None if learned_utc is None else learned_utc.astimezone().date())
    found = learned.get("held_out")
    if found is None:
        return _("Learned on {day} from {file}.").format(day=when, file=learned.get("source", ""))
    told = translate_plural(
        "Learned on {day} from {n_captures} captures of {n} patient.",
        "Learned on {day} from {n_captures} captures of {n} patients.",
        learned["n_patients"],
    ).format(day=when, n_captures=learned["n_captures"], n=learned["n_patients"])
    n, right, wrong = found["n_examples"], found["right"], found["wrong"]
    if found["shipped_right"] is None:
        tested = _(
            "Of {n} captures that it had not seen, it named {right} right and {wrong} with a "
            "mistake."
        ).format(n=n, right=right, wrong=wrong)
    else:
        tested = _(
            "Of {n} captures that it had not seen, it named {right} right and {wrong} with a "
            "mistake; the shipped model {shipped_right} and {shipped_wrong}."
        ).format(
            n=n,
            right=right,
            wrong=wrong,
            shipped_right=found["shipped_right"],
            shipped_wrong=found["shipped_wrong"],
        )
    return f"{told} {tested}"
