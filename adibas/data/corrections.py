"""What a clinician changed in the markers of a capture: a history that can be undone.

Every correction holds what was there before and what is there after it, with the position that
was measured then. So it can be undone, done again, and read as an audit trail, on a machine that
has neither the recording nor the sensor.
"""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, TypeVar

from adibas.data.markers import Marker

LONGEST_LABEL = 40


@dataclass(frozen=True, slots=True, eq=False)
class MarkerCorrection:
    """A marker was added (no `before`), deleted (no `after`), moved or renamed (both)."""

    before: Marker | None
    after: Marker | None

    def __post_init__(self) -> None:
        if self.before is None and self.after is None:
            raise ValueError("a correction needs a marker before or after it")
        if self.after is not None and not 0 < len(self.after.label.strip()) <= LONGEST_LABEL:
            raise ValueError(f"a label has 1 to {LONGEST_LABEL} characters")

    @property
    def kind(self) -> Literal["add", "delete", "rename", "move"]:
        """What was done."""
        if self.before is None:
            return "add"
        if self.after is None:
            return "delete"
        return "move" if self.before.label == self.after.label else "rename"

    @property
    def is_by_program(self) -> bool:
        """Whether a model gave the name; who renames by hand leaves the model's word as it was."""
        if self.before is None or self.after is None or self.kind != "rename":
            return False
        return self.after.named_by not in (None, self.before.named_by)


@dataclass(frozen=True, slots=True)
class FreeMeasure:
    """A distance (two labels) or an angle (three, the vertex second) that the user asked for."""

    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        if len(self.labels) not in (2, 3) or len(set(self.labels)) != len(self.labels):
            raise ValueError(f"a measure needs two or three markers, got {self.labels}")

    def renamed(self, before: str, after: str) -> "FreeMeasure":
        """Return the same measure after one of the markers got another name."""
        return FreeMeasure(tuple(after if label == before else label for label in self.labels))


@dataclass(frozen=True, slots=True)
class MeasureCorrection:
    """A free measure was added (no `before`) or removed (no `after`)."""

    before: FreeMeasure | None
    after: FreeMeasure | None

    def __post_init__(self) -> None:
        if (self.before is None) == (self.after is None):
            raise ValueError("a measure is either added or removed")

    @property
    def kind(self) -> Literal["add-measure", "remove-measure"]:
        """What was done."""
        return "add-measure" if self.before is None else "remove-measure"


Correction: TypeAlias = MarkerCorrection | MeasureCorrection
AnyCorrection = TypeVar("AnyCorrection", MarkerCorrection, MeasureCorrection)


@dataclass(frozen=True, slots=True, eq=False)
class CorrectionHistory:
    """One undo stack: the first `n_done` of `corrections` are in force, the rest can be redone.

    Names that a model gave one after the other are undone, and done again, in one step.
    """

    corrections: tuple[Correction, ...] = ()
    n_done: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.n_done <= len(self.corrections):
            raise ValueError(f"n_done {self.n_done} of {len(self.corrections)} corrections")

    @property
    def can_undo(self) -> bool:
        """Whether something is in force."""
        return self.n_done > 0

    @property
    def can_redo(self) -> bool:
        """Whether something was undone."""
        return self.n_done < len(self.corrections)

    def after(self, correction: Correction) -> "CorrectionHistory":
        """Return the history with one more correction; what was undone is forgotten."""
        done = self.corrections[: self.n_done]
        return CorrectionHistory((*done, correction), self.n_done + 1)

    def undone(self) -> "CorrectionHistory":
        """Return the history with the last step out of force."""
        if not self.can_undo:
            raise ValueError("nothing to undo")
        n_done = self.n_done - 1
        while n_done and self._is_one_step(n_done):
            n_done -= 1
        return CorrectionHistory(self.corrections, n_done)

    def redone(self) -> "CorrectionHistory":
        """Return the history with the next step in force again."""
        if not self.can_redo:
            raise ValueError("nothing to redo")
        n_done = self.n_done + 1
        while n_done < len(self.corrections) and self._is_one_step(n_done):
            n_done += 1
        return CorrectionHistory(self.corrections, n_done)

    def markers(self, detected: tuple[Marker, ...]) -> tuple[Marker, ...]:
        """Return the markers as corrected, in the order of the detection, added ones last.

        Raises
        ------
        ValueError
            The history does not fit: a marker that it changes is missing, or a label comes twice.
        """
        markers = {marker.label: marker for marker in detected}
        for correction in self._in_force(MarkerCorrection):
            markers = _with_correction(markers, correction)
        return tuple(markers.values())

    def placed_by_hand(self) -> frozenset[str]:
        """Return the labels of the markers that were added or moved; a new name moves nothing."""
        labels: set[str] = set()
        for correction in self._in_force(MarkerCorrection):
            before, after = correction.before, correction.after
            is_placed = before is None or before.label in labels
            if before is not None:
                labels.discard(before.label)
                is_placed |= after is not None and (before.u, before.v) != (after.u, after.v)
            if after is not None and is_placed:
                labels.add(after.label)
        return frozenset(labels)

    def measures(self) -> tuple[FreeMeasure, ...]:
        """Return the free measures in the order in which they were asked for.

        They follow the names of their markers, and go with a marker that is deleted.
        """
        measures: list[FreeMeasure] = []
        for correction in self.corrections[: self.n_done]:
            if isinstance(correction, MarkerCorrection):
                measures = _following(measures, correction)
                continue
            if correction.before is not None:
                measures.remove(correction.before)
            if correction.after is not None:
                measures.append(correction.after)
        return tuple(measures)

    def _is_one_step(self, index: int) -> bool:
        """Say whether a correction and the one before it are names that a model gave."""
        pair = self.corrections[index - 1 : index + 1]
        return all(isinstance(one, MarkerCorrection) and one.is_by_program for one in pair)

    def _in_force(self, kind: type[AnyCorrection]) -> list[AnyCorrection]:
        return [one for one in self.corrections[: self.n_done] if isinstance(one, kind)]


def _following(measures: list[FreeMeasure], correction: MarkerCorrection) -> list[FreeMeasure]:
    """Return the measures after a marker was corrected."""
    before, after = correction.before, correction.after
    if before is None:
        return measures
    if after is None:
        return [measure for measure in measures if before.label not in measure.labels]
    return [measure.renamed(before.label, after.label) for measure in measures]


def _with_correction(markers: dict[str, Marker], correction: MarkerCorrection) -> dict[str, Marker]:
    before, after = correction.before, correction.after
    if before is not None and before.label not in markers:
        raise ValueError(f"no marker {before.label!r} to correct")
    others = [label for label in markers if before is None or label != before.label]
    if after is not None and after.label in others:
        raise ValueError(f"two markers would be named {after.label!r}")
    if before is None and after is not None:
        return {**markers, after.label: after}
    corrected: dict[str, Marker] = {}
    for label, marker in markers.items():
        if before is not None and label == before.label:
            if after is not None:  # a marker that is only moved keeps who named it
                named_by = marker.named_by if after.label == label else None
                if correction.is_by_program:
                    named_by = after.named_by
                corrected[after.label] = replace(after, named_by=named_by)
        else:
            corrected[label] = marker
    return corrected
