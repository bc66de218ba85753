"""What the pages have in common that show preferences."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget


class PreferencePage(QWidget):
    """Tells which preference the user changes, as soon as it is changed."""

    changed = Signal(str, object)
    """Its name and its new value."""
