"""What stays in view below a form however long it is: what is wrong, and the buttons."""

from PySide6.QtWidgets import QLabel, QPushButton, QVBoxLayout, QWidget

from ui.widgets.flow import in_a_flow


def lay_out_footer(
    footer: QWidget, problem: QLabel, cancel: QPushButton, save: QPushButton
) -> None:
    """Put a problem's line and the two buttons into `footer`; Enter presses a button."""
    problem.setProperty("kind", "bad")
    problem.setWordWrap(True)
    problem.hide()
    save.setProperty("main", "true")
    column = QVBoxLayout(footer)
    column.setContentsMargins(12, 8, 8, 0)
    column.setSpacing(8)
    column.addWidget(problem)
    column.addLayout(in_a_flow(cancel, save, at_right=True))
    for button in (cancel, save):
        button.setAutoDefault(True)
