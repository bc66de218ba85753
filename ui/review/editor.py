"""The corrections of one capture: each is saved before it is shown. Knows nothing of Qt."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from adibas.data.corrections import (
    LONGEST_LABEL,
    Correction,
    CorrectionHistory,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.landmark_texts import landmark_text
from adibas.data.markers import NUMBERED, Marker
from adibas.data.sessions import Capture
from adibas.errors import MarkerError

Save = Callable[[CorrectionHistory, CorrectionHistory], Capture]


class CaptureEditor:
    """One capture with its undo stack, and a drag that is in progress.

    Parameters
    ----------
    capture : Capture
        As the store has it.
    save : callable
        Takes the history that was seen and the one to be saved, and returns the capture with what
        is saved now; what it raises leaves all as it was.
    """

    def __init__(self, capture: Capture, save: Save) -> None:
        self._capture = capture
        self._save = save
        self._held: Marker | None = None

    @property
    def capture(self) -> Capture:
        """As the store has it."""
        return self._capture

    @property
    def history(self) -> CorrectionHistory:
        """The undo stack."""
        return self._capture.history

    @property
    def held(self) -> Marker | None:
        """The marker that is being dragged, where it is now."""
        return self._held

    def saved(self) -> dict[str, Marker]:
        """Return the markers as saved, by label."""
        return {marker.label: marker for marker in self._capture.markers()}

    def markers(self) -> tuple[Marker, ...]:
        """Return the markers as seen: the one that is dragged where it is now."""
        held = self._held
        return tuple(
            held if held is not None and held.label == label else marker
            for label, marker in self.saved().items()
        )

    def hold(self, marker: Marker | None) -> None:
        """Show a marker somewhere without saving that; None: where it was saved."""
        self._held = marker

    def move(self, marker: Marker) -> None:
        """Save a marker's new place; the place where it was already changes nothing."""
        self._held = None
        before = self.saved()[marker.label]
        if (before.u, before.v) != (marker.u, marker.v):
            self._correct(MarkerCorrection(before, replace(marker, named_by=before.named_by)))

    def add(self, marker: Marker) -> None:
        """Save a new marker."""
        self._correct(MarkerCorrection(None, marker))

    def delete(self, label: str) -> None:
        """Remove a marker."""
        self._correct(MarkerCorrection(self.saved()[label], None))

    def rename(self, label: str, wanted: str) -> str:
        """Give a marker another name and return it, without spaces around.

        Raises
        ------
        MarkerError
            It is empty, too long, or another marker's.
        """
        name = " ".join(wanted.split())
        if name == label:
            return name
        if not 0 < len(name) <= LONGEST_LABEL:
            raise MarkerError(
                "A marker's name has 1 to {longest} characters. Type a shorter one.",
                longest=LONGEST_LABEL,
            )
        if name in self.saved():
            raise MarkerError(
                "Another marker is named {name} already. Choose another name, or rename that one "
                "first.",
                name=landmark_text(name),
            )
        before = self.saved()[label]
        self._correct(MarkerCorrection(before, replace(before, label=name, named_by=None)))
        return name

    def take_names(self, found: Mapping[str, Marker]) -> int:
        """Give markers the names that a model found for them, and return how many got one.

        Parameters
        ----------
        found : Mapping
            Of labels, the markers with their names. One that was renamed, moved or removed
            meanwhile is passed over, and so is a name that is taken by now.
        """
        history, markers, n_named = self.history, self.saved(), 0
        for label, named in found.items():
            before = markers.get(label)
            if before is None or named.label in markers:
                continue
            if (before.u, before.v) != (named.u, named.v):
                continue
            after = replace(before, label=named.label, named_by=named.named_by)
            history = history.after(MarkerCorrection(before, after))
            markers[after.label] = markers.pop(label)
            n_named += 1
        if n_named:
            self._keep(history)
        return n_named

    def add_measure(self, labels: tuple[str, ...]) -> None:
        """Ask for a distance or an angle; one that is there already changes nothing."""
        if not any(alike(labels, one.labels) for one in self.history.measures()):
            self._correct(MeasureCorrection(None, FreeMeasure(labels)))

    def remove_measure(self, labels: tuple[str, ...]) -> None:
        """Take a free measure away."""
        for one in self.history.measures():
            if alike(labels, one.labels):
                self._correct(MeasureCorrection(one, None))

    def undo(self) -> None:
        """Take the last correction back, if there is one."""
        if self.history.can_undo:
            self._keep(self.history.undone())

    def redo(self) -> None:
        """Do again what was taken back last, if anything was."""
        if self.history.can_redo:
            self._keep(self.history.redone())

    def free_label(self) -> str:
        """Return the next number for a marker without a name."""
        taken = [NUMBERED.fullmatch(label) for label in self.saved()]
        numbers = [int(found.group(1)) for found in taken if found]
        return f"m{max(numbers, default=0) + 1:02d}"

    def _correct(self, correction: Correction) -> None:
        self._keep(self.history.after(correction))

    def _keep(self, history: CorrectionHistory) -> None:
        self._held = None
        self._capture = self._save(self._capture.history, history)


def alike(labels: tuple[str, ...], others: tuple[str, ...]) -> bool:
    """Whether two measures are the same one, whichever end was clicked first."""
    return labels in (others, others[::-1])
