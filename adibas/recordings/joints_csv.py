"""Joints over time as a table: `joints.csv`, one row a frame and person.

Columns: ``timestamp_s``, optionally ``person``, then ``<joint>_x_m``, ``<joint>_y_m``,
``<joint>_z_m`` and ``<joint>_confidence`` for each joint; an empty cell means not seen. ``up_x``,
``up_y``, ``up_z`` may say in every row the direction against gravity in the same axes, as a vector
of length 1. A last column ``origin`` may say where the joints come from: ``markers`` or
``markerless``.
"""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.clock import NS_PER_S
from adibas.data.joints import JOINT_NAMES
from adibas.data.movement import Origin
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import RecordingError
from adibas.files import written_whole
from adibas.recordings.clock_jumps import check_steps
from adibas.texts import message

SUFFIX = ".joints.csv"
TABLE_SUFFIX = ".csv"
ROWS_A_BLOCK = 5000
LATEST_S = 9e9
"""The year 2255: later times do not fit into 64 bits of nanoseconds."""
ORIGIN = "origin"
UP = ("up_x", "up_y", "up_z")
UP_SLACK = 1e-3
"""By which the parts of one direction may differ from row to row, and its length from 1."""
PARTS = ("x_m", "y_m", "z_m", "confidence")
COLUMNS = tuple(f"{joint}_{part}" for joint in JOINT_NAMES for part in PARTS)
MOST_MORE = 50_000
"""Rows for which room is made at once."""


@dataclass(frozen=True, slots=True)
class JointFile:
    """What a file of joints holds, one track for each person, and what was left out of it.

    `origin` is where the joints come from, and `up` (3,) the direction against gravity in their
    axes, as far as every row says the same; `up` is None where it is not known.
    """

    tracks: tuple[SkeletonTrack, ...]
    notices: tuple[Sentence, ...] = ()
    origin: Origin = "unknown"
    up: FloatArray | None = None


def is_joint_table(path: Path) -> bool:
    """Say by its name whether a file is a table of joints, and no recording."""
    return path.suffix.lower() == TABLE_SUFFIX


def recording_name(path: Path) -> str:
    """Return NAME of ``NAME.joints.csv`` or ``NAME.csv``."""
    name = path.name
    return name.removesuffix(SUFFIX) if name.endswith(SUFFIX) else path.stem


def read_joints_csv(path: Path) -> JointFile:
    """Read joints over time.

    Rows whose time is not after the row before (of the same person) are left out, and a notice
    says how many.

    Raises
    ------
    RecordingError
        The file is missing, has no time or joints, or a cell is no number; or a frame comes more
        than a day after all before it.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            people, origin, up = _read(path, file)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(
            "{file} cannot be read: {reason}. Check that it is a table of joints (CSV).",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error
    tracks, notices = [], []
    for person, rows in sorted(people.items()):
        kept, said = _forward(path, rows.times_s)
        notices += said
        tracks.append(rows.track(kept, int(person)))
    check_steps(path.name, np.sort(np.concatenate([track.times_s for track in tracks])))
    return JointFile(tuple(tracks), tuple(notices), origin, up)


class _Rows:
    """What a file tells of one person, in arrays that grow in their places: hours fit once only."""

    def __init__(self) -> None:
        self._n = 0
        self._times_s = np.empty(0)
        self._joints_m = np.empty((0, len(JOINT_NAMES), 3))
        self._confidence = np.empty((0, len(JOINT_NAMES)))

    @property
    def times_s(self) -> FloatArray:
        """Return when each row was."""
        return self._times_s[: self._n]

    def add(self, rows: FloatArray) -> None:
        """Take rows (n, 2 + 60): time, person, and the cells in the order of `COLUMNS`."""
        end = self._n + len(rows)
        if end > len(self._times_s):
            self._make_room(end + min(end, MOST_MORE))
        here = slice(self._n, end)
        cells = rows[:, 2:].reshape(len(rows), len(JOINT_NAMES), len(PARTS))
        is_unseen = np.asarray(np.isnan(cells[:, :, :3]).any(axis=2))
        self._times_s[here] = rows[:, 0]
        self._joints_m[here] = np.where(is_unseen[:, :, None], np.nan, cells[:, :, :3])
        self._confidence[here] = np.where(is_unseen, np.nan, cells[:, :, 3])
        self._n = end

    def track(self, kept: BoolArray, person: int) -> SkeletonTrack:
        """Return the kept rows; nothing can be added any more."""
        timestamps_ns = np.round(self.times_s * NS_PER_S).astype(np.int64)
        self._make_room(self._n)
        joints_m, confidence = self._joints_m, self._confidence
        if not kept.all():
            timestamps_ns, joints_m, confidence = (
                timestamps_ns[kept], joints_m[kept], confidence[kept],
            )  # fmt: skip
        return SkeletonTrack(timestamps_ns, joints_m, confidence, person)

    def _make_room(self, n_rows: int) -> None:
        for array in (self._times_s, self._joints_m, self._confidence):
            array.resize((n_rows, *array.shape[1:]), refcheck=False)


def write_joints_csv(
    path: Path,
    tracks: Sequence[SkeletonTrack],
    origin: Origin = "unknown",
    up: FloatArray | None = None,
) -> None:
    """Write joints over time, frames of all persons in the order of their times.

    Where `up` is known, three columns say it in every row; where `origin` is, a last one does.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    with written_whole(path) as unfinished, unfinished.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        names = (*(UP if up is not None else ()), *((ORIGIN,) if origin != "unknown" else ()))
        vertical = [] if up is None else [f"{value:.6f}" for value in up.tolist()]
        told = [*vertical, *([origin] if origin != "unknown" else [])]
        writer.writerow(("timestamp_s", "person", *COLUMNS, *names))
        writer.writerows([*row, *told] for row in _rows(tracks))


def _rows(tracks: Sequence[SkeletonTrack]) -> Iterator[list[str]]:
    order = sorted(
        (int(when), track.person, index, number)
        for number, track in enumerate(tracks)
        for index, when in enumerate(track.timestamps_ns)
    )
    for when, person, index, number in order:
        track = tracks[number]
        values = np.column_stack([track.joints_m[index], track.confidence[index]])
        seconds, rest = divmod(when, NS_PER_S)
        texts = ["" if np.isnan(value) else f"{value:.6g}" for value in values.ravel()]
        yield [f"{seconds}.{rest:09d}", str(person), *texts]


def _read(path: Path, file: TextIO) -> tuple[dict[float, _Rows], Origin, FloatArray | None]:
    """Return everybody's rows, the origin, and the direction against gravity."""
    reader = csv.reader(file)
    header = [name.strip() for name in next(reader, [])]
    if "timestamp_s" not in header or not set(header) & set(COLUMNS):
        raise RecordingError(
            "{file} is no table of joints: its first line must name timestamp_s and columns such "
            "as head_x_m. Give a file that `adibas pose` wrote.",
            file=path.name,
        )
    wanted = ("timestamp_s", "person", *COLUMNS)
    places = [(k, header.index(name)) for k, name in enumerate(wanted) if name in header]
    found: dict[float, _Rows] = {}
    origins: set[str] = set()
    vertical = _Vertical()
    while rows := list(islice(reader, ROWS_A_BLOCK)):
        begin = reader.line_num - len(rows) + 1
        lines = [line for line, row in enumerate(rows, begin) if row]
        rows = [row for row in rows if row]
        block = np.full((len(rows), len(wanted)), np.nan)
        for into, column in places:
            block[:, into] = _numbers(path, rows, column, lines)
        if ORIGIN in header:
            at = header.index(ORIGIN)
            origins |= {row[at].strip() if at < len(row) else "" for row in rows}
        if set(UP) <= set(header):
            told = [_numbers(path, rows, header.index(name), lines) for name in UP]
            vertical.add(np.array(told))
        _check(path, block)
        for person in np.unique(block[:, 1]):
            found.setdefault(float(person), _Rows()).add(block[block[:, 1] == person])
    if not found:
        raise RecordingError("{file} has no frames. Record again.", file=path.name)
    return found, _origin_of(origins), vertical.up


class _Vertical:
    """The direction against gravity, as far as all rows agree."""

    def __init__(self) -> None:
        self._least, self._greatest = np.full(3, np.inf), np.full(3, -np.inf)

    def add(self, told: FloatArray) -> None:
        """Take what (3, n) rows say."""
        self._least = np.minimum(self._least, told.min(axis=1))
        self._greatest = np.maximum(self._greatest, told.max(axis=1))

    @property
    def up(self) -> FloatArray | None:
        """Return the (3,) direction; None where rows say none, or not the same one."""
        if not np.isfinite(self._least).all() or not np.isfinite(self._greatest).all():
            return None
        up = 0.5 * (self._least + self._greatest)
        length = float(np.linalg.norm(up))
        is_one = bool((self._greatest - self._least <= UP_SLACK).all())
        return up / length if is_one and abs(length - 1.0) <= UP_SLACK else None


def _origin_of(found: set[str]) -> Origin:
    if found == {"markers"}:
        return "markers"
    return "markerless" if found == {"markerless"} else "unknown"


def _numbers(path: Path, rows: list[list[str]], column: int, lines: list[int]) -> list[float]:
    try:
        return [float(row[column] or "nan") for row in rows]
    except (ValueError, IndexError) as error:
        at = next(k for k, row in enumerate(rows) if not _is_number(row, column))
        raise RecordingError(
            "{file}, line {line}: a cell is missing or no number. Leave a cell empty where a "
            "joint was not seen.",
            file=path.name,
            line=lines[at],
        ) from error


def _is_number(row: list[str], column: int) -> bool:
    try:
        float(row[column] or "nan")
    except (ValueError, IndexError):
        return False
    return True


def _check(path: Path, cells: FloatArray) -> None:
    """See that there are times and no infinite numbers; who is not told is person 1."""
    cells[np.isnan(cells[:, 1]), 1] = 1.0
    if not np.isfinite(cells[:, :2]).all() or np.isinf(cells).any():
        raise RecordingError(
            "{file} has a frame without a time, or an infinite number in it. Every row needs its "
            "timestamp_s.",
            file=path.name,
        )
    is_late = np.abs(cells[:, 0]) > LATEST_S
    if is_late.any():
        raise RecordingError(
            "{file} has a frame at {at} s, which is no time. timestamp_s is in seconds, not in "
            "milliseconds.",
            file=path.name,
            at=float(cells[is_late, 0][0]),
        )


def _forward(path: Path, times_s: FloatArray) -> tuple[BoolArray, list[Sentence]]:
    """Return which rows come after all before them, and what is to be said of the others."""
    times_ns = np.round(times_s * NS_PER_S)
    latest = np.maximum.accumulate(np.concatenate([[-np.inf], times_ns[:-1]]))
    kept = times_ns > latest
    notices = []
    if n_same := int((times_ns == latest).sum()):
        notices.append(
            Sentence(
                message(
                    "{file}: frames that repeat the time of the frame before are left out: {n}."
                ),
                {"file": path.name, "n": n_same},
            )
        )
    if n_back := int((times_ns < latest).sum()):
        notices.append(
            Sentence(
                message(
                    "{file}: frames that go back in time are left out: {n}, the first at {at} s. "
                    "The clock was set or files were joined."
                ),
                {"file": path.name, "n": n_back, "at": float(times_s[times_ns < latest][0])},
                decimals=3,
            )
        )
    return kept, notices
