"""What happened in a recording, from when to when."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TimedEvent:
    """One gesture or behaviour of one person.

    Attributes
    ----------
    recording : str
        Name of the recording, without folder and endings.
    label : str
    begin_s, end_s : float
        On the recording's clock, both included; equal for a point event.
    subject : str
        Who acts: recordings of one subject are never split between training and test. Empty: the
        recording is its own subject.
    person : int
        Which track of the recording.
    kind : str
        ``state`` or ``point``.
    cost : float or None
        Of a detection, as a share of its threshold; None where a human said it.
    """

    recording: str
    label: str
    begin_s: float
    end_s: float
    subject: str = ""
    person: int = 1
    kind: str = "state"
    cost: float | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.begin_s) and math.isfinite(self.end_s)):
            raise ValueError(f"an event needs finite times: {self.begin_s}, {self.end_s}")
        if self.end_s < self.begin_s:
            raise ValueError(f"an event ends before it begins: {self.begin_s}, {self.end_s}")
        if self.kind not in ("state", "point"):
            raise ValueError(f"kind must be state or point, got {self.kind}")

    @property
    def who(self) -> str:
        """Return the subject, or the recording where none is named."""
        return self.subject or self.recording

    def overlap(self, other: "TimedEvent") -> float:
        """Return the temporal overlap with `other`: intersection over union, 0 to 1."""
        shared_s = min(self.end_s, other.end_s) - max(self.begin_s, other.begin_s)
        spanned_s = max(self.end_s, other.end_s) - min(self.begin_s, other.begin_s)
        if spanned_s == 0.0:
            return 1.0
        return max(0.0, shared_s) / spanned_s
