"""Prints the page of a recovery key; the printer alone gets it, no file is written."""

from html import escape
from typing import TYPE_CHECKING

from PySide6.QtCore import QMarginsF, Qt
from PySide6.QtGui import QPageLayout, QPageSize, QTextDocument
from PySide6.QtPrintSupport import QPrintDialog, QPrinter
from PySide6.QtWidgets import QWidget

if TYPE_CHECKING:
    from adibas.reports.recovery_sheet import RecoverySheet

MARGIN_MM = 16.0


def print_sheet(sheet: "RecoverySheet", parent: QWidget) -> None:
    """Ask for a printer, and print when one was chosen."""
    printer = QPrinter(QPrinter.PrinterMode.HighResolution)
    printer.setDocName("ADiBAS")  # others may see what waits for the printer
    dialog = QPrintDialog(printer, parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.accepted.connect(lambda: print_on(printer, sheet))
    dialog.setModal(True)
    dialog.show()


def print_on(printer: QPrinter, sheet: "RecoverySheet") -> None:
    """Print the page on A4."""
    printer.setPageSize(QPageSize(QPageSize.PageSizeId.A4))
    margins = QMarginsF(MARGIN_MM, MARGIN_MM, MARGIN_MM, MARGIN_MM)
    printer.setPageMargins(margins, QPageLayout.Unit.Millimeter)
    document = QTextDocument()
    document.setHtml(page_html(sheet))
    document.print_(printer)


def page_html(sheet: "RecoverySheet") -> str:
    """Return what is printed, as Qt lays it out."""
    rows = "".join(
        f"<tr><td><b>{escape(name)}</b>&nbsp;&nbsp;</td><td>{escape(value)}</td></tr>"
        for name, value in sheet.facts
    )
    lines = "<br/>".join(escape(line).replace(" ", "&nbsp;") for line in sheet.lines)
    warnings = "".join(f"<p><b>{escape(sentence)}</b></p>" for sentence in sheet.warnings)
    uses = "".join(f"<p>{escape(sentence)}</p>" for sentence in sheet.uses)
    return (
        f'<div style="font-size: 11pt"><h1>{escape(sheet.heading)}</h1><table>{rows}</table>'
        f'<p align="center" style="font-size: 28pt; font-weight: bold">{lines}</p>'
        f"{warnings}{uses}</div>"
    )
