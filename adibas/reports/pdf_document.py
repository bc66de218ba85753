"""One PDF document: A4 pages with a footer, written whole."""

import io
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from reportlab.lib.pagesizes import A4
from reportlab.platypus import BaseDocTemplate, Flowable, Frame, PageTemplate

from adibas.files import written_whole
from adibas.reports.pdf_layout import MARGIN, WIDTH, FooterCanvas, prepare_fonts
from adibas.texts import Message, speaking, translate
from adibas.texts import translate as _

FOOTER_HEIGHT = 34


def write_document(
    path: Path,
    language: str,
    version: str,
    heading: Message,
    content: Callable[[], tuple[Iterable[Flowable], tuple[str, str]]],
) -> None:
    """Write a document in a language.

    Parameters
    ----------
    language : str
        Two letters.
    version : str
        Of the program.
    heading : Message
        The document's title.
    content : callable
        Gives what stands on the pages and the two lines of their footer, in the language that is
        spoken then.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    encoded = encoded_document(language, version, heading, content)
    with written_whole(path) as unfinished:
        unfinished.write_bytes(encoded)


def encoded_document(
    language: str,
    version: str,
    heading: Message,
    content: Callable[[], tuple[Iterable[Flowable], tuple[str, str]]],
) -> bytes:
    """Return the bytes that `write_document` writes."""
    prepare_fonts()
    encoded = io.BytesIO()
    with speaking(language):
        document = BaseDocTemplate(
            encoded,
            pagesize=A4,
            title=translate(heading),
            author="ADiBAS",
            creator=f"ADiBAS {version}",
            lang=language,
        )
        document.addPageTemplates(PageTemplate(frames=[_space()]))
        story, footer = content()
        canvas = partial(FooterCanvas, lines=footer, page_text=_("Page {page} of {total}"))
        document.build(list(story), canvasmaker=canvas)
    return encoded.getvalue()


def _space() -> Frame:
    return Frame(
        MARGIN,
        MARGIN + FOOTER_HEIGHT,
        WIDTH,
        A4[1] - 2 * MARGIN - FOOTER_HEIGHT,
        leftPadding=0,
        rightPadding=0,
        topPadding=0,
        bottomPadding=0,
    )
