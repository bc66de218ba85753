"""A workbook that is put together in memory.

openpyxl keeps each sheet in a temporary file meanwhile, where a crash would leave what was measured
on a patient.
"""

import io
from collections.abc import Callable, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

from openpyxl import Workbook
from openpyxl.drawing.spreadsheet_drawing import SpreadsheetDrawing
from openpyxl.worksheet._write_only import WriteOnlyWorksheet
from openpyxl.worksheet._writer import WorksheetWriter
from openpyxl.writer.excel import ExcelWriter

from adibas.files import written_whole
from adibas.texts import speaking


def write_in_memory(path: Path, language: str, add_sheets: Callable[[Workbook], None]) -> None:
    """Write the workbook that `add_sheets` fills, in a language; `path` gets it whole or not.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    workbook = _MemoryWorkbook()
    with written_whole(path) as unfinished:
        try:
            with speaking(language):
                add_sheets(workbook)
            encoded = workbook.encoded()
        finally:
            workbook.discard_unsaved()
        unfinished.write_bytes(encoded)


class _MemorySheet(WriteOnlyWorksheet):
    """Keeps its rows in memory."""

    def _get_writer(self) -> None:
        if self._writer is None:
            self._writer: Any = WorksheetWriter(self, out=io.BytesIO())
            self._writer.write_top()


class _MemoryWorkbook(Workbook):
    """Write-only, which takes two thirds of the time."""

    def __init__(self) -> None:
        super().__init__(write_only=True)

    def create_sheet(self, title: Any = None, index: int | None = None) -> Any:
        """Add a sheet."""
        sheet = _MemorySheet(self, title)
        self._add_sheet(sheet, index)  # type: ignore[attr-defined]  # the types lack it
        return sheet

    def encoded(self) -> bytes:
        """Return the whole file; nothing can be added afterwards."""
        self.properties.modified = datetime.now(UTC).replace(tzinfo=None)  # as the format wants it
        file = io.BytesIO()
        _MemoryWriter(self, ZipFile(file, "w", ZIP_DEFLATED)).save()
        return file.getvalue()

    def discard_unsaved(self) -> None:
        """End the sheets of a workbook whose writing failed, in the order that they can bear."""
        sheets: Sequence[Any] = self.worksheets
        for sheet in sheets:
            if sheet._writer is not None:  # noqa: SLF001  (nothing public)
                for unfinished in (sheet._rows, sheet._writer.xf):  # noqa: SLF001
                    with suppress(AttributeError):  # no row was written
                        unfinished.close()


class _MemoryWriter(ExcelWriter):
    """Takes the sheets from memory."""

    def write_worksheet(self, ws: Any) -> None:
        """Add a sheet to the file."""
        ws._drawing = SpreadsheetDrawing()  # noqa: SLF001  (as its base does)
        ws._drawing.charts = ws._charts  # noqa: SLF001
        ws._drawing.images = ws._images  # noqa: SLF001
        ws.close()
        ws._rels = ws._writer._rels  # noqa: SLF001
        archive: ZipFile = self._archive  # type: ignore[attr-defined]  # the types lack it
        archive.writestr(ws.path[1:], ws._writer.out.getvalue())  # noqa: SLF001
        self.manifest.append(ws)
