"""The page on which a recovery key is kept: what it says, and as a PDF of one A4 page."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from reportlab.lib.enums import TA_CENTER
from reportlab.lib.styles import ParagraphStyle
from reportlab.platypus import Flowable, Spacer, Table, TableStyle

from adibas import __version__
from adibas.clock import day_here
from adibas.reports.fonts import BOLD
from adibas.reports.pdf_document import write_document
from adibas.reports.pdf_layout import BLUE, TEXT, WIDTH, facts_table, paragraph, title
from adibas.texts import message, spoken_language
from adibas.texts import translate as _

HEADING = message("Recovery key of the patient store")
GROUPS_IN_A_LINE = 4
KEY = ParagraphStyle("key", fontName=BOLD, fontSize=30, leading=46, alignment=TA_CENTER)
BODY = ParagraphStyle("body", parent=TEXT, fontSize=11, leading=16, spaceBefore=8)
WARNING = ParagraphStyle("warning", parent=BODY, fontName=BOLD)


@dataclass(frozen=True, slots=True)
class RecoverySheet:
    """What stands on the page, in the language that was spoken when it was made.

    Attributes
    ----------
    heading : str
    facts : tuple of (name, value)
        Program, number of the store, day.
    lines : tuple of str
        The key in groups, to be read from afar.
    warnings, uses : tuple of str
        Sentences: what the key can do and where the page belongs; how it is used.
    """

    heading: str
    facts: tuple[tuple[str, str], ...]
    lines: tuple[str, ...]
    warnings: tuple[str, ...]
    uses: tuple[str, ...]


def recovery_sheet(recovery_key: str, store_id: str, made_utc: datetime) -> RecoverySheet:
    """Return what the page says of a key, in the language in use; nothing of patients.

    Parameters
    ----------
    recovery_key : str
        In groups, as it was made.
    store_id : str
        The store's number.
    """
    return RecoverySheet(
        heading=_(HEADING),
        facts=(
            (_("Program"), f"ADiBAS {__version__}"),
            (_("Number of the patient store"), store_id),
            (_("Day"), day_here(made_utc).isoformat()),
        ),
        lines=key_lines(recovery_key),
        warnings=(
            _(
                "Whoever has this page and the files of the store or a backup can read everything "
                "in them, and can choose a new passphrase."
            ),
            _("Keep it away from the computer: in a locked place, best in another building."),
        ),
        uses=(
            _(
                "It is needed when the passphrase is forgotten or the desktop's keyring is lost: "
                'on the first page of ADiBAS press "Passphrase or keyring lost?", type the key and '
                "choose a new passphrase. Or use the command: adibas sessions recover"
            ),
            _(
                "Spaces, dashes and capitals do not matter. There is no letter O, I or L in it: "
                "they are zero and one."
            ),
            _(
                "It also opens backups that were made while it held. When a new recovery key is "
                "made, this one opens the store no more; older backups still open with it."
            ),
        ),
    )


def key_lines(recovery_key: str) -> tuple[str, ...]:
    """Return the groups of a key in lines of a few each."""
    groups = recovery_key.split("-")
    starts = range(0, len(groups), GROUPS_IN_A_LINE)
    return tuple("  ".join(groups[at : at + GROUPS_IN_A_LINE]) for at in starts)


def write_recovery_pdf(path: Path, sheet: RecoverySheet) -> None:
    """Write the page in the language in use, whole or not at all.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    footer = (sheet.heading, f"ADiBAS {__version__}")
    write_document(path, spoken_language(), __version__, HEADING, lambda: (_story(sheet), footer))


def _story(sheet: RecoverySheet) -> Iterator[Flowable]:
    yield title(sheet.heading)
    yield facts_table(sheet.facts)
    yield Spacer(1, 24)
    cells = [[paragraph(line.replace("  ", "\N{NO-BREAK SPACE}" * 2), KEY)] for line in sheet.lines]
    frame = [
        ("BOX", (0, 0), (-1, -1), 1.5, BLUE),
        ("TOPPADDING", (0, 0), (-1, -1), 6),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 14),
    ]
    yield Table(cells, [WIDTH], style=TableStyle(frame))
    yield Spacer(1, 16)
    for sentence in sheet.warnings:
        yield paragraph(sentence, WARNING)
    for sentence in sheet.uses:
        yield paragraph(sentence, BODY)
