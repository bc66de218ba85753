"""What stays in view below a form however long it is: what is wrong, and the buttons."""

from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget


def lay_out_footer(
    footer: QWidget, problem: QLabel, cancel: QPushButton, save: QPushButton
) -> None:
    """Put a problem's line and the two buttons into `footer`; Enter presses a button."""
    problem.setProperty("kind", "bad")
    problem.setWordWrap(True)
    problem.hide()
    save.setProperty("main", "true")
    column, buttons = QVBoxLayout(footer), QHBoxLayout()
    column.setContentsMargins(12, 8, 8, 0)
    column.setSpacing(8)
    column.addWidget(problem)
    column.addLayout(buttons)
    buttons.addStretch(1)
    for button in (cancel, save):
        button.setAutoDefault(True)
        buttons.addWidget(button)
