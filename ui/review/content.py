"""What the review screen shows; without Qt."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from adibas.arrays import FloatArray, UInt8Array
from adibas.data.markers import Marker, RejectedBlob, is_numbered

N_OF_DISTANCE, N_OF_ANGLE = 2, 3


class Mode(Enum):
    """What a click on the picture does; of measures, the value counts the markers they take."""

    CHOOSE = 0
    ADD = 1
    DISTANCE = N_OF_DISTANCE
    ANGLE = N_OF_ANGLE
    NAME = 4

    @property
    def measures(self) -> bool:
        """Whether clicks choose the markers of a measure."""
        return self in (Mode.DISTANCE, Mode.ANGLE)

    @property
    def picks(self) -> bool:
        """Whether a press on a marker means it, and does not move it."""
        return self.measures or self is Mode.NAME


@dataclass(frozen=True, slots=True)
class MeasureRow:
    """A distance (two labels; mm) or an angle (three, the vertex second; degrees).

    `value` and `interval` (of 95 %) are None where a marker has no position.
    """

    labels: tuple[str, ...]
    value: float | None = None
    interval: tuple[float, float] | None = None

    @property
    def is_angle(self) -> bool:
        """Whether it is measured in degrees."""
        return len(self.labels) == N_OF_ANGLE


@dataclass(frozen=True, slots=True, eq=False)
class CaptureItem:
    """One picture of the strip; None where its picture cannot be read."""

    capture_id: str
    view: str
    thumbnail_rgb: UInt8Array | None
    n_markers: int
    is_corrected: bool


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """The markers of the capture that is seen, and what is being done to them.

    Attributes
    ----------
    markers : tuple of Marker
        As corrected, a drag in progress included.
    by_hand : frozenset of str
        Labels of those that were added or moved.
    selected : str or None
        The chosen marker.
    picked : tuple of str
        Markers of the measure that is being clicked.
    measures : tuple of MeasureRow
        The free ones.
    rejected : tuple of RejectedBlob
        That are to be shown.
    n_rejected : int
        That could be shown.
    mode : Mode
        What a click does.
    can_edit, can_undo, can_redo : bool
        What is possible now.
    unnamed : tuple of str
        Labels of the landmarks of this view that no marker has yet, the next one first; None where
        the session has no protocol.
    """

    markers: tuple[Marker, ...] = ()
    by_hand: frozenset[str] = frozenset()
    selected: str | None = None
    picked: tuple[str, ...] = ()
    measures: tuple[MeasureRow, ...] = ()
    rejected: tuple[RejectedBlob, ...] = ()
    n_rejected: int = 0
    mode: Mode = Mode.CHOOSE
    can_edit: bool = False
    can_undo: bool = False
    can_redo: bool = False
    unnamed: tuple[str, ...] | None = None

    @property
    def can_name_others(self) -> bool:
        """Whether there are landmarks without a marker, and markers that have only a number."""
        return (
            self.can_edit
            and bool(self.unnamed)
            and any(is_numbered(one.label) for one in self.markers)
        )


def placed(markers: Iterable[Marker]) -> dict[str, FloatArray]:
    """Return the places of those markers that have one, by name, colour camera's axes."""
    return {one.label: one.position_m for one in markers if one.position_m is not None}
