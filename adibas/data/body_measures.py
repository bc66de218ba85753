"""Named numbers of the body's surface, each with its definition's source."""

from dataclasses import dataclass
from typing import Literal

from adibas.texts import Message

Quantity = Literal["angle", "length", "volume"]


@dataclass(frozen=True, slots=True)
class Definition:
    """What is measured, and who says so.

    Attributes
    ----------
    measure_id : str
        Such as ``BACK.KYPHOSIS``.
    name, meaning : Message
        For people; `meaning` says between what, and what a positive value means.
    quantity : "angle", "length" or "volume"
    source : str
        Where the definition can be read.
    """

    measure_id: str
    name: Message
    meaning: Message
    quantity: Quantity
    source: str


@dataclass(frozen=True, slots=True)
class BodyMeasure:
    """One number.

    Attributes
    ----------
    definition : Definition
    value : float or None
        Radians, metres or cubic metres; None where it could not be measured.
    interval : (low, high) or None
        Holds the truth in 95 % of cases as far as the instrument goes; None where it is not known.
    reason : Message or None
        Why there is no value.
    """

    definition: Definition
    value: float | None
    interval: tuple[float, float] | None = None
    reason: Message | None = None
