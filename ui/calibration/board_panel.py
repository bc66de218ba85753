"""Which board is held: one of the printed sizes, or an own one. No decisions."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QWidget,
)

from adibas.data.board import LARGEST_SIDE, SMALLEST_SIDE, Board
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.texts import translate as _
from ui.widgets.number_fields import DecimalField, WholeNumberField

OWN = ""
LEAST_MM, MOST_MM = 2.0, 500.0


class BoardPanel(QGroupBox):
    """A list of sizes, three numbers for a board of one's own, and a button that prints."""

    board_chosen = Signal(object)
    print_asked = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._sizes = QComboBox(self)
        self._columns, self._rows = (WholeNumberField(self) for _ in range(2))
        self._square = DecimalField(self)
        self._print = QPushButton(self)
        self._labels = [QLabel(self) for _ in range(4)]
        self._note = QLabel(self)
        self._note.setWordWrap(True)
        self._note.setProperty("kind", "quiet")
        for spin in (self._columns, self._rows):
            spin.setRange(SMALLEST_SIDE, LARGEST_SIDE)
        self._square.setRange(LEAST_MM, MOST_MM)
        self._square.setDecimals(2)
        for name in (*PRINTED_BOARDS, OWN):
            self._sizes.addItem(name, name)
        self._sizes.activated.connect(self._on_size)
        for box in (self._columns, self._rows, self._square):
            box.editingFinished.connect(self._on_own)
        self._print.clicked.connect(lambda: self.print_asked.emit(self._sizes.currentData()))
        self._lay_out()

    def _lay_out(self) -> None:
        size, columns, rows, square = self._labels
        layout = QGridLayout(self)
        size.setBuddy(self._sizes)
        # Beside the longest label there is no room for "own board" in every language.
        choice = QHBoxLayout()
        choice.addWidget(size)
        choice.addWidget(self._sizes, 1)
        layout.addLayout(choice, 0, 0, 1, 2)
        own = ((columns, self._columns), (rows, self._rows), (square, self._square))
        for line, (label, box) in enumerate(own, 1):
            label.setBuddy(box)
            layout.addWidget(label, line, 0)
            layout.addWidget(box, line, 1)
        layout.addWidget(self._note, 4, 0, 1, 2)
        layout.addWidget(self._print, 5, 0, 1, 2)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setTitle(_("Board"))
        texts = (_("Si&ze"), _("C&orners across"), _("Corners &down"), _("S&quare"))
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        self._square.setSuffix(_(" mm"))
        self._sizes.setItemText(self._sizes.findData(OWN), _("Own board"))
        self._note.setText(_("Count the corners inside, where four squares meet."))
        self._print.setText(_("&Print the board..."))

    def show_board(self, board: Board) -> None:
        """Show the board in use, whatever was being typed."""
        name = next((one.name for one in PRINTED_BOARDS.values() if one.board == board), OWN)
        if name == OWN or self._sizes.currentData() != OWN:
            self._sizes.setCurrentIndex(self._sizes.findData(name))
        values = ((self._columns, board.columns), (self._rows, board.rows))
        for box, value in values:
            if not box.hasFocus():
                box.setValue(value)
        if not self._square.hasFocus():
            self._square.setValue(1000.0 * board.square_m)
        self._show_own()

    def _show_own(self) -> None:
        is_own = self._sizes.currentData() == OWN
        for widget in (*self._labels[1:], self._columns, self._rows, self._square, self._note):
            widget.setVisible(is_own)
        self._print.setVisible(not is_own)

    def _on_size(self, _index: int) -> None:
        name = self._sizes.currentData()
        self._show_own()
        if name != OWN:
            self.board_chosen.emit(PRINTED_BOARDS[name].board)
        else:
            self._columns.setFocus()

    def _on_own(self) -> None:
        if self._sizes.currentData() == OWN:
            square_m = self._square.value() / 1000.0
            self.board_chosen.emit(Board(self._columns.value(), self._rows.value(), square_m))
