"""Reports of several sessions into one folder."""

import re
from collections.abc import Collection, Sequence
from pathlib import Path

from PIL import Image

from adibas.clock import day_here
from adibas.data.report import SessionReport
from adibas.files import written_whole
from adibas.progress import Progress
from adibas.reports import write_report
from adibas.reports.facts import capture_names
from adibas.reports.pictures import draw_markers, picture_of
from adibas.texts import speaking

PICTURES = ".png"
"""The kind that writes a picture of each view."""
PICTURE_HEIGHT_PX = 1024
UNSAFE = re.compile(r"[^\w.-]+")
LONGEST_STEM = 80


def write_session_reports(
    reports: Collection[SessionReport], folder: Path, kinds: Sequence[str], progress: Progress
) -> tuple[Path, ...]:
    """Write each report in every kind, named by pseudonym and date; nothing is replaced.

    Parameters
    ----------
    reports : collection of SessionReport
        Gone through once; it may make each report when it is its turn.
    folder : Path
        Made where it is missing.
    kinds : sequence of str
        Of `adibas.reports.KINDS`, and `PICTURES` for a picture of each view.
    progress : callable
        Called with (files written, files in all); an exception it raises ends the export after
        the file that is whole.

    Returns
    -------
    paths : tuple of Path
        What was written, in its order.

    Raises
    ------
    ReportError
        A picture cannot be as its report asks.
    FileError
        The disk is full, or the folder cannot be written.
    """
    written: list[Path] = []
    total = len(reports) * len(kinds)
    for index, report in enumerate(reports):
        for number, kind in enumerate(kinds, 1):
            if kind == PICTURES:
                written += write_pictures(report, folder)
            else:
                path = free_path(folder, report_stem(report), kind)
                write_report(report, path)
                written.append(path)
            progress(index * len(kinds) + number, total)
    return tuple(written)


def write_pictures(report: SessionReport, folder: Path) -> tuple[Path, ...]:
    """Write one PNG for each view with the markers drawn; nothing is replaced.

    Raises
    ------
    ReportError
        A picture cannot be as the report asks.
    FileError
        The disk is full, or the folder cannot be written.
    """
    with speaking(report.language):
        names = capture_names(report)
    paths = []
    for name, capture in zip(names, report.captures, strict=True):
        picture = picture_of(capture.analysis, report.pictures, report.rotation_deg)
        path = free_path(folder, f"{report_stem(report)}_{_safe(name)}", PICTURES)
        with written_whole(path) as unfinished:
            Image.fromarray(draw_markers(picture, PICTURE_HEIGHT_PX)).save(unfinished)
        paths.append(path)
    return tuple(paths)


def report_stem(report: SessionReport) -> str:
    """Return the pseudonym and the session's date as the name of a file, without ending."""
    begun = report.started_utc
    parts = [report.patient or "report", "" if begun is None else day_here(begun).isoformat()]
    return "_".join(_safe(part) for part in parts if part)


def free_path(folder: Path, stem: str, kind: str) -> Path:
    """Return ``stem.kind`` in a folder, or ``stem_2.kind``, ... where that stands already."""
    path = folder / f"{stem}{kind}"
    number = 2
    while path.exists():
        path = folder / f"{stem}_{number}{kind}"
        number += 1
    return path


def _safe(text: str) -> str:
    """Return text that every file system takes as part of a name."""
    return UNSAFE.sub("-", text).strip("-.")[:LONGEST_STEM] or "report"
