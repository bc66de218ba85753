"""Point sets as CSV: ``shape,point,label,x_m,y_m[,z_m][,view][,diameter_m]``, a row each point."""

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.data.posture import VIEWS
from adibas.errors import FileError
from adibas.files import cannot_read, written_whole

COLUMNS = ("shape", "point", "label", "x_m", "y_m")
Z, VIEW, DIAMETER = "z_m", "view", "diameter_m"


@dataclass(frozen=True, slots=True, eq=False)
class PointSet:
    """The points of one shape.

    Attributes
    ----------
    shape : str
        Which one, as the file calls it.
    points : tuple of str
        What the file calls each of the M points.
    labels : tuple of str
        Their names; empty where one is to be found.
    positions_m : (M, D) array
        D of 2 or 3, y down.
    view : str
        One of `VIEWS`, or empty where it is not told.
    diameters_m : (M,) array or None
        Of the markers, as measured; NaN where one is not known, None where none is.
    """

    shape: str
    points: tuple[str, ...]
    labels: tuple[str, ...]
    positions_m: FloatArray
    view: str = ""
    diameters_m: FloatArray | None = None

    def __post_init__(self) -> None:
        check_shape("positions_m", self.positions_m, (len(self.points), None))
        read_only(self.positions_m)
        if self.diameters_m is not None:
            check_shape("diameters_m", self.diameters_m, (len(self.points),))
            read_only(self.diameters_m)


@dataclass(slots=True)
class _Rows:
    points: list[str] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    positions_m: list[list[float]] = field(default_factory=list)
    views: list[str] = field(default_factory=list)
    diameters_m: list[float] = field(default_factory=list)


def read_points(path: Path) -> tuple[PointSet, ...]:
    """Read point sets, in the order in which the file begins them.

    Raises
    ------
    FileError
        The file is missing, lacks a column, has no point, or holds something else than numbers.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            columns = tuple(reader.fieldnames or ())
            _check_columns(path, columns)
            shapes: dict[str, _Rows] = {}
            for row in reader:
                _add_row(path, reader.line_num, row, shapes)
    except OSError as error:
        raise cannot_read(path, error) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileError(
            "{file} is no CSV file in UTF-8. Save it as such.", file=path.name
        ) from error
    if not shapes:
        raise FileError(
            "{file} holds no point. Write a row for each: shape,point,label,x_m,y_m,z_m.",
            file=path.name,
        )
    return tuple(_point_set(path, name, rows) for name, rows in shapes.items())


def write_points(
    sets: Iterable[PointSet], path: Path, extra: Mapping[str, Sequence[Sequence[object]]]
) -> None:
    """Write point sets; `extra` has further columns: for each set a value a point.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    sets = tuple(sets)
    has_depth = any(one.positions_m.shape[1] == len("xyz") for one in sets)
    has_view = any(one.view for one in sets)
    has_size = any(one.diameters_m is not None for one in sets)
    told = {Z: has_depth, VIEW: has_view, DIAMETER: has_size}
    head = [*COLUMNS, *(name for name, is_told in told.items() if is_told), *extra]
    with written_whole(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as f:
        writer = csv.writer(f)
        writer.writerow(head)
        for number, one in enumerate(sets):
            for i, point in enumerate(one.points):
                # A point in the plane has no z, but its cell: what follows keeps its column.
                position = [*map(float, one.positions_m[i]), ""][: 3 if has_depth else 2]
                view = [one.view] if has_view else []
                size = [_size_text(one.diameters_m, i)] if has_size else []
                more = [values[number][i] for values in extra.values()]
                writer.writerow([one.shape, point, one.labels[i], *position, *view, *size, *more])


def _size_text(diameters_m: FloatArray | None, i: int) -> str:
    if diameters_m is None or math.isnan(diameters_m[i]):
        return ""
    return repr(float(diameters_m[i]))


def _check_columns(path: Path, columns: tuple[str, ...]) -> None:
    lacking = [name for name in COLUMNS if name not in columns]
    if lacking:
        raise FileError(
            "{file} has no column {column}. Its first line must be: "
            "shape,point,label,x_m,y_m,z_m (without z_m in the plane).",
            file=path.name,
            column=lacking[0],
        )


def _add_row(
    path: Path, line: int, row: Mapping[str, str | None], shapes: dict[str, _Rows]
) -> None:
    position = [_number(path, line, row.get(name)) for name in ("x_m", "y_m")]
    if row.get(Z):
        position.append(_number(path, line, row[Z]))
    view = (row.get(VIEW) or "").strip()
    if view not in ("", *VIEWS):
        raise FileError(
            "{file}, line {line}: {view} is no view. There are: {views}.",
            file=path.name,
            line=line,
            view=view,
            views=", ".join(VIEWS),
        )
    rows = shapes.setdefault(row["shape"] or "", _Rows())
    rows.points.append(row["point"] or "")
    rows.labels.append((row["label"] or "").strip())
    rows.positions_m.append(position)
    rows.views.append(view)
    rows.diameters_m.append(_diameter_m(path, line, row))


def _diameter_m(path: Path, line: int, row: Mapping[str, str | None]) -> float:
    text = (row.get(DIAMETER) or "").strip()
    if not text:
        return math.nan
    diameter_m = _number(path, line, text)
    if diameter_m <= 0.0:
        raise FileError(
            "{file}, line {line}: a marker's diameter is more than 0 metres, not {text}.",
            file=path.name,
            line=line,
            text=text,
        )
    return diameter_m


def _number(path: Path, line: int, text: str | None) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FileError(
            "{file}, line {line}: {text} is no position in metres.",
            file=path.name,
            line=line,
            text=text or '""',
        )
    return value


def _point_set(path: Path, name: str, rows: _Rows) -> PointSet:
    if len({len(position) for position in rows.positions_m}) > 1:
        raise FileError(
            "{file}: shape {shape} has points with and without z_m. Fill in all or none.",
            file=path.name,
            shape=name,
        )
    named = [label for label in rows.labels if label]
    twice = sorted({label for label in named if named.count(label) > 1})
    if twice:
        raise FileError(
            "{file}: shape {shape} has two points named {label}. A name may be given once.",
            file=path.name,
            shape=name,
            label=twice[0],
        )
    views = sorted({view for view in rows.views if view})
    if len(views) > 1:
        raise FileError(
            "{file}: shape {shape} is said to be seen from two sides: {views}. Give one view.",
            file=path.name,
            shape=name,
            views=", ".join(views),
        )
    diameters_m = np.array(rows.diameters_m)
    return PointSet(
        name,
        tuple(rows.points),
        tuple(rows.labels),
        np.array(rows.positions_m),
        "".join(views),
        None if np.isnan(diameters_m).all() else diameters_m,
    )
