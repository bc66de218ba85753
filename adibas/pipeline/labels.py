"""Names of markers out of a file: which marker, or which place in the picture, is what.

A CSV table with a column ``label`` and either a column ``marker`` (or ``point``) with the marker's
present name, or the columns ``u`` and ``v`` with a pixel of it.
"""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from adibas.data.corrections import LONGEST_LABEL
from adibas.data.markers import Marker
from adibas.errors import FileError, MarkerError
from adibas.files import cannot_read

REACH_PX = 15.0
"""How far from a marker's centre a pixel may be to mean it, as a click in the window."""
MOST_LINES = 10_000


@dataclass(frozen=True, slots=True)
class LabelLine:
    """One marker's name: of the marker called `marker`, or of the one at pixel (u, v)."""

    label: str
    marker: str
    u: float
    v: float
    line: int


def read_labels(path: Path) -> tuple[LabelLine, ...]:
    """Return the lines of a file of labels; those with an empty label are left out.

    Raises
    ------
    FileError
        It cannot be read, or a line of it makes no sense.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            columns = reader.fieldnames or []
            key = next((name for name in ("marker", "point") if name in columns), "")
            if "label" not in columns or not (key or {"u", "v"} <= set(columns)):
                raise FileError(
                    "{file} names no markers. Its first line must be marker,label or u,v,label.",
                    file=path.name,
                )
            return tuple(
                _line(path, key, row, reader.line_num)
                for row in islice(reader, MOST_LINES)
                if (row["label"] or "").strip()
            )
    except OSError as error:
        raise cannot_read(path, error) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileError(
            "{file} is no table in UTF-8. Save it as CSV in UTF-8.", file=path.name
        ) from error


def with_labels(
    markers: tuple[Marker, ...], labels: Sequence[LabelLine], reach_px: float = REACH_PX
) -> tuple[Marker, ...]:
    """Return the markers with their names, in their order.

    Raises
    ------
    MarkerError
        A line means no marker, two lines mean the same one, or two markers get one name.
    """
    names: dict[str, str] = {}
    for line in labels:
        found = _meant(markers, line, reach_px)
        if found is None or found.label in names:
            raise MarkerError(
                "Line {line} of the labels, {label}, means no marker of its own. Correct the line, "
                "or leave it out.",
                line=line.line,
                label=line.label,
            )
        names[found.label] = line.label
    renamed = tuple(
        replace(marker, label=names.get(marker.label, marker.label)) for marker in markers
    )
    if len({marker.label for marker in renamed}) < len(renamed):
        raise MarkerError("Two markers would have the same name. Give each label once.")
    return renamed


def _line(path: Path, key: str, row: dict[str, str | None], line: int) -> LabelLine:
    label = (row["label"] or "").strip()
    marker = (row.get(key) or "").strip() if key else ""
    u, v = (math.nan, math.nan) if key else (_number(row["u"]), _number(row["v"]))
    is_meant = bool(marker) if key else math.isfinite(u) and math.isfinite(v)
    if len(label) > LONGEST_LABEL or not is_meant:
        raise FileError(
            "{file}, line {line}: this is no marker with a label of up to {most} characters. "
            "Correct it.",
            file=path.name,
            line=line,
            most=LONGEST_LABEL,
        )
    return LabelLine(label, marker, u, v, line)


def _number(text: str | None) -> float:
    try:
        return float(text or "")
    except ValueError:
        return math.nan


def _meant(markers: tuple[Marker, ...], line: LabelLine, reach_px: float) -> Marker | None:
    if line.marker:
        return next((marker for marker in markers if marker.label == line.marker), None)
    distances = [math.hypot(marker.u - line.u, marker.v - line.v) for marker in markers]
    nearest = min(range(len(markers)), key=distances.__getitem__, default=None)
    return None if nearest is None or distances[nearest] > reach_px else markers[nearest]
