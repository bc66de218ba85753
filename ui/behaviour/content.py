"""What the behaviour screen shows. Knows nothing of Qt."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from adibas.data.coding import Occurrence, Section
from adibas.data.ethogram import Behaviour
from adibas.texts import decimal_mark

Layer: TypeAlias = Literal["coded", "begun", "proposed", "other", "difference"]
"""Coded by the observer; begun by him; seen by the program; coded by another observer; seen by one
of them alone."""


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the timeline: one behaviour of one subject."""

    subject: str
    behaviour: str
    color: str


@dataclass(frozen=True, slots=True)
class Bar:
    """An event in a line of the timeline; `occurrence` is None where nothing can be done to it."""

    row: int
    begin_ms: int
    end_ms: int
    layer: Layer
    occurrence: Occurrence | None = None


@dataclass(frozen=True, slots=True)
class Timeline:
    """Everything that is seen of a session over time."""

    begin_ms: int = 0
    end_ms: int = 1
    rows: tuple[Row, ...] = ()
    bars: tuple[Bar, ...] = ()
    sections: tuple[Section, ...] = ()
    chosen: Occurrence | None = None


@dataclass(frozen=True, slots=True)
class CodeKey:
    """A behaviour that can be coded now.

    Attributes
    ----------
    behaviour : Behaviour
    is_lasting : bool
        It was begun for the chosen subject.
    """

    behaviour: Behaviour
    is_lasting: bool


@dataclass(frozen=True, slots=True)
class Desk:
    """What an observer has before him.

    Attributes
    ----------
    keys : tuple of CodeKey
    subjects : tuple of (name, key)
        Besides nobody in particular.
    subject : str
        Whose behaviour is coded.
    observer : str
        Initials of a second observer who codes blind; empty for the first one.
    n_coded, n_proposed : int
    can_undo, can_redo, is_locked : bool
    """

    keys: tuple[CodeKey, ...] = ()
    subjects: tuple[tuple[str, str], ...] = ()
    subject: str = ""
    observer: str = ""
    n_coded: int = 0
    n_proposed: int = 0
    can_undo: bool = False
    can_redo: bool = False
    is_locked: bool = False


@dataclass(frozen=True, slots=True)
class Selected:
    """The event that is looked at.

    Attributes
    ----------
    occurrence : Occurrence
    layer : str
    behaviour : Behaviour or None
        As the coding scheme describes it; None where it does not know it.
    since_ms : int
        When the session begins.
    """

    occurrence: Occurrence
    layer: Layer
    behaviour: Behaviour | None
    since_ms: int


def time_text(since_ms: int) -> str:
    """Return a time of a session as m:ss.mmm, with hours where there are some."""
    sign = "-" if since_ms < 0 else ""
    seconds, ms = divmod(abs(since_ms), 1000)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    whole = f"{hours}:{minutes:02d}" if hours else f"{minutes}"
    return f"{sign}{whole}:{seconds:02d}{decimal_mark()}{ms:03d}"
