"""The tables of the review screen are those of the window."""

from ui.widgets.line_table import LineTable

__all__ = ["LineTable"]
