"""Least sizes of what is hidden: Qt works them out anew only when it is shown."""

from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtWidgets import QComboBox, QWidget


def renew_least_sizes(outermost: QWidget) -> None:
    """Work out how small a widget and all in it may be, with the words and letters in use."""
    for box in outermost.findChildren(QComboBox):  # Qt keeps the width of words it had before
        QCoreApplication.sendEvent(box, QEvent(QEvent.Type.StyleChange))
    for widget in reversed((outermost, *outermost.findChildren(QWidget))):  # parents come last
        widget.ensurePolished()
        layout = widget.layout()
        if layout is not None:
            layout.invalidate()
            layout.activate()
        QCoreApplication.sendEvent(widget, QEvent(QEvent.Type.LayoutRequest))
        widget.updateGeometry()
