"""Properties that the style sheet asks for."""

from PySide6.QtWidgets import QWidget


def show_kind(widget: QWidget, kind: str) -> None:
    """Colour a widget as good, warning, bad or quiet; "": as usual."""
    set_look(widget, "kind", kind)


def set_look(widget: QWidget, name: str, value: str) -> None:
    """Set a property; only where that changes it is the widget dressed anew, which costs more."""
    if (widget.property(name) or "") != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
