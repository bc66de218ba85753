"""Asks for a file; the window goes on meanwhile."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QWidget

from adibas.texts import translate as _

Then = Callable[[Path], None]
CODING_ENDINGS = ("csv", "xlsx", "boris", "eaf", "tsv")


def coding_filter() -> str:
    """Return the filter of files that hold codings."""
    return _("Codings") + f" ({' '.join(f'*.{ending}' for ending in CODING_ENDINGS)})"


def workbook_filter() -> str:
    """Return the filter of workbooks."""
    return _("Excel workbooks") + " (*.xlsx)"


def ask_open(parent: QWidget, title: str, name_filter: str, then: Then) -> None:
    """Ask which file is opened."""
    dialog = QFileDialog(parent, title)
    dialog.setNameFilter(name_filter)
    _ask(dialog, then)


def ask_open_several(
    parent: QWidget, title: str, name_filter: str, then: Callable[[list[Path]], None]
) -> None:
    """Ask which files are opened together."""
    dialog = QFileDialog(parent, title)
    dialog.setNameFilter(name_filter)
    dialog.setFileMode(QFileDialog.FileMode.ExistingFiles)
    dialog.filesSelected.connect(lambda names: then([Path(name) for name in names]))
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()


def ask_save(parent: QWidget, title: str, filters: tuple[str, ...], file: str, then: Then) -> None:
    """Ask where a file goes; `file` is proposed, and the ending follows the chosen filter."""
    dialog = QFileDialog(parent, title)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setNameFilters(filters)
    dialog.setDefaultSuffix(_ending(filters[0]))
    dialog.filterSelected.connect(lambda chosen: dialog.setDefaultSuffix(_ending(chosen)))
    dialog.selectFile(file)
    _ask(dialog, then)


def named_after(recording: str, what: str) -> str:
    """Return the proposed name of a file: two recordings' files do not meet."""
    return f"{recording}-{what}" if recording else what


def _ending(name_filter: str) -> str:
    return name_filter.rpartition("*.")[2].rstrip(")")


def _ask(dialog: QFileDialog, then: Then) -> None:
    dialog.fileSelected.connect(lambda name: then(Path(name)))
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
