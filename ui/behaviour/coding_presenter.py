"""What the observer notes down, and how he takes it back. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from adibas.behaviour.editing import (
    Draft,
    History,
    accepted,
    begun_of,
    changed,
    pressed,
    released,
    removed,
    with_ethogram,
    with_section,
    without_section,
)
from adibas.behaviour.matching import Difference
from adibas.data.coding import Coding, Occurrence, Section
from adibas.data.ethogram import Ethogram
from adibas.pipeline.coding_drafts import DraftPlace
from adibas.texts import translate as _
from ui.behaviour.content import CodeKey, Desk, Layer, Selected, Timeline
from ui.behaviour.ports import Keeper
from ui.behaviour.rows import in_order, timeline_of
from ui.events import Event
from ui.workspace import Workspace


class CodingView(Protocol):
    """The screen, as this presenter needs it."""

    def show_desk(self, desk: Desk) -> None:
        """Show what can be coded, and by which keys."""

    def show_timeline(self, timeline: Timeline) -> None:
        """Show all events over time."""

    def show_selected(self, selected: Selected | None) -> None:
        """Show the event that is looked at."""


class CodingPresenter:
    """Turns keys and drags into steps of a draft; each is kept at once.

    Parameters
    ----------
    now : callable
        Gives the time of the frame that is seen, milliseconds.
    go_to : callable
        Shows the frame at a time.

    Attributes
    ----------
    changed : Event
        The coding is another one.
    is_holding : bool
        A state lasts as long as its key is held, not from one press to the next.
    """

    def __init__(
        self,
        view: CodingView,
        workspace: Workspace,
        keeper: Keeper,
        now: Callable[[], int],
        go_to: Callable[[int], None],
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._keeper = keeper
        self._now = now
        self._go_to = go_to
        self.changed: Event[[]] = Event()
        self.is_holding = False
        self._history: History[Draft] | None = None
        self._place: DraftPlace | None = None
        self._observer = ""
        self._subject = ""
        self._selected: Occurrence | None = None
        self._other: Coding | None = None
        self._differences: tuple[Difference, ...] = ()

    @property
    def draft(self) -> Draft | None:
        """What was coded up to now; None before a recording is open."""
        return None if self._history is None else self._history.now

    @property
    def is_blind(self) -> bool:
        """Whether a second observer codes, who sees nothing of the first one."""
        return bool(self._observer)

    def coding(self) -> Coding | None:
        """Return the coding as it would be if everything ended now."""
        return None if self._history is None else self._history.now.settled(self._now())

    @property
    def history(self) -> History[Draft] | None:
        """Return every step up to now; None before a recording is open."""
        return self._history

    def open(self, history: History[Draft], place: DraftPlace, observer: str) -> None:
        """Go on with a draft; `observer` is one who codes blind, from the beginning on."""
        self.keep()
        self._history, self._place, self._observer = history, place, observer
        draft = history.now
        subjects = draft.coding.ethogram.subjects
        self._subject = subjects[0].name if subjects else ""
        self._selected, self._other, self._differences = None, None, ()
        if observer:
            self._go_to(draft.coding.begin_ms)
        self.show()
        self.changed.emit()

    def close(self) -> None:
        """Keep everything, and be done."""
        self.keep()
        self._history, self._place = None, None

    def keep(self) -> None:
        """Write the draft where it is kept."""
        if self._history is not None and self._place is not None:
            self._keeper.keep(self._place, self._history, self._now())

    def keep_begun(self) -> None:
        """Write how long states last by now, if any was begun."""
        if self.draft is not None and self.draft.begun:
            self.keep()

    def press(self, behaviour: str) -> None:
        """Code a behaviour at the frame that is seen."""
        draft = self.draft
        if draft is not None:
            is_running = begun_of(draft, behaviour, self._subject) is not None
            if not (self.is_holding and is_running):  # a key that repeats
                self._step(lambda old: pressed(old, behaviour, self._subject, self._now()))

    def release(self, behaviour: str) -> None:
        """End a state, where it lasts as long as its key is held."""
        if self.is_holding:
            self._step(lambda old: released(old, behaviour, self._subject, self._now()))

    def behaviour_of_key(self, key: str) -> str | None:
        """Return the behaviour that a key codes; None where it codes none."""
        keys = {} if self.draft is None else _keys(self.draft.coding.ethogram)
        return keys.get(key) or keys.get(key.lower())

    def subject_of_key(self, key: str) -> str | None:
        """Return the subject that a key chooses; None where it chooses none."""
        subjects = () if self.draft is None else self.draft.coding.ethogram.subjects
        return next((one.name for one in subjects if one.key and one.key == key), None)

    def choose_subject(self, name: str) -> None:
        """Code the behaviour of this one from now on."""
        self._subject = name
        self.show()

    def select(self, occurrence: Occurrence | None) -> None:
        """Look at an event."""
        self._selected = occurrence
        self.show()

    def select_next(self, step: int) -> None:
        """Look at the event after the one that is looked at, or before it, and at its beginning."""
        events = in_order(self._events())
        if not events:
            return
        if self._selected in events:
            number = events.index(self._selected) + step
        else:
            n_before = sum(one.begin_ms < self._now() for one in events)
            number = n_before if step > 0 else n_before - 1
        self._look_at(events[min(max(number, 0), len(events) - 1)])

    def select_next_proposed(self) -> None:
        """Look at the first detected event that is not decided, from the frame that is seen on."""
        proposed = () if self.draft is None else self.draft.proposed
        if proposed:
            self._look_at(_from(in_order(proposed), self._now()))

    def accept(self) -> None:
        """Take the detected event that is looked at into the coding, and look at the next one."""
        one = self._selected
        if self.draft is not None and one is not None and one in self.draft.proposed:
            self._decide(one, lambda old: accepted(old, one, self._subject))

    def remove(self) -> None:
        """Delete the event that is looked at; a detected one is rejected."""
        one = self._selected
        if self.draft is None or one is None:
            return
        if one in self.draft.proposed:
            self._decide(one, lambda old: removed(old, one))
        else:
            self._step(lambda old: removed(old, one))

    def change(self, old: Occurrence, new: Occurrence) -> None:
        """Put another event in the place of one; what does not fit is told and shown as it was."""
        is_changed = new != old and self._step(lambda draft: changed(draft, old, new))
        self._selected = new if is_changed else old
        self.show()

    def set_begin(self) -> None:
        """Let the event that is looked at begin at the frame that is seen."""
        one = self._selected
        if one is not None:
            at_ms = self._now()
            self.change(one, replace(one, begin_ms=at_ms, end_ms=_end(one, at_ms)))

    def set_end(self) -> None:
        """Let it end there."""
        one = self._selected
        if one is not None:
            at_ms = self._now()
            begin_ms = one.begin_ms if one.duration_ms else at_ms
            self.change(one, replace(one, begin_ms=begin_ms, end_ms=at_ms))

    def use_ethogram(self, ethogram: Ethogram) -> None:
        """Code by another scheme from now on."""
        self._step(lambda old: with_ethogram(old, ethogram))

    def edit(self, step: Callable[[Draft], Draft]) -> bool:
        """Do any other step of the core; return whether it was done."""
        return self._step(step)

    def mark_section(self, section: Section) -> None:
        """Tag a part of the session with a condition."""
        self._step(lambda old: with_section(old, section))

    def remove_section(self, section: Section) -> None:
        """Take a condition's tag away."""
        self._step(lambda old: without_section(old, section))

    def undo(self) -> None:
        """Take the last step back."""
        if self._history is not None:
            self._take(self._history.undone())

    def redo(self) -> None:
        """Do again what was taken back last."""
        if self._history is not None:
            self._take(self._history.redone())

    def compare_with(self, other: Coding | None, differences: tuple[Difference, ...]) -> None:
        """Show the coding of another observer beside, and where they differ."""
        self._other, self._differences = other, differences
        self.show()

    def show(self) -> None:
        """Show everything as it is now."""
        history = self._history
        if history is None:
            return
        draft = history.now
        if self._selected is not None and self._selected not in self._events():
            self._selected = None
        ethogram = draft.coding.ethogram
        keys = tuple(
            CodeKey(one, begun_of(draft, one.name, self._subject) is not None)
            for one in ethogram.behaviours
        )
        desk = Desk(
            keys,
            tuple((one.name, one.key) for one in ethogram.subjects),
            self._subject,
            self._observer,
            len(draft.coding.occurrences) + len(draft.begun),
            len(draft.proposed),
            bool(history.before),
            bool(history.after),
            ethogram.is_locked,
        )
        self._view.show_desk(desk)
        self._view.show_timeline(
            timeline_of(draft, self._subject, self._selected, self._other, self._differences)
        )
        self._view.show_selected(self._shown(draft))

    def _shown(self, draft: Draft) -> Selected | None:
        one = self._selected
        if one is None:
            return None
        layer: Layer = "coded"
        if one in draft.begun:
            layer = "begun"
        elif one in draft.proposed:
            layer = "proposed"
        behaviour = draft.coding.ethogram.behaviour(one.behaviour)
        return Selected(one, layer, behaviour, draft.coding.begin_ms)

    def _events(self) -> tuple[Occurrence, ...]:
        draft = self.draft
        if draft is None:
            return ()
        return (*draft.coding.occurrences, *draft.begun, *draft.proposed)

    def _look_at(self, one: Occurrence) -> None:
        self._selected = one
        self._go_to(one.begin_ms)
        self.show()

    def _decide(self, one: Occurrence, step: Callable[[Draft], Draft]) -> None:
        if not self._step(step) or self.draft is None:
            return
        left = in_order(self.draft.proposed)
        if left:
            self._look_at(_from(left, one.begin_ms))
        else:
            self._workspace.tell("good", _("Every detected event is decided."))

    def _step(self, step: Callable[[Draft], Draft]) -> bool:
        """Do a step; what does not fit is told, and nothing changes."""
        history = self._history
        if history is None:
            return False

        def take() -> None:
            draft = step(history.now)
            if draft != history.now:
                self._take(history.changed(draft))

        return self._workspace.attempt(take)

    def _take(self, history: History[Draft]) -> None:
        self._history = history
        self.keep()
        self.show()
        self.changed.emit()


def _from(events: list[Occurrence], time_ms: int) -> Occurrence:
    """Return the first event from a time on, or the first of all."""
    return next((one for one in events if one.begin_ms >= time_ms), events[0])


def _keys(ethogram: Ethogram) -> dict[str, str]:
    return {one.key: one.name for one in reversed(ethogram.behaviours) if one.key}


def _end(one: Occurrence, begin_ms: int) -> int:
    return one.end_ms if one.duration_ms else begin_ms
