"""What is found of people without markers in live pictures: joints and gestures. No Qt."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, get_args

from adibas.data.joints import JOINT_NAMES
from adibas.errors import AdibasError
from adibas.pipeline.own_gestures import GestureChoice, models_of
from adibas.texts import translate as _
from ui.events import Event
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.pipeline.live_frames import LiveFrame
    from adibas.pipeline.live_people import LiveJoints

CHOICES: tuple[GestureChoice, ...] = get_args(GestureChoice)
SHOWN_MS = 4000


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is looked for.

    Attributes
    ----------
    gestures : tuple of Path
        Models of gestures.
    joints : bool
        Whether joints are to be drawn.
    """

    gestures: tuple[Path, ...] = ()
    joints: bool = False


class PeopleView(Protocol):
    """The screen, as this presenter needs it."""

    def show_followed(self, sentence: str) -> None:
        """Say what was found; nothing for nothing."""

    def show_joints(self, people: "tuple[LiveJoints, ...]") -> None:
        """Draw joints over the pictures from now on."""

    def call_later(self, milliseconds: int, call: Callable[[], None]) -> None:
        """Call in the window's thread, later."""


class PeopleWatch(Protocol):
    """Looks at frames beside the window; what it tells arrives in its thread.

    Attributes
    ----------
    gesture_seen : Event
        (label): a gesture has just been done.
    joints_seen : Event
        (people): joints of everybody in the newest frame.
    unseen : Event
        (reason): nobody can be followed, in words; empty: somebody is again.
    failed : Event
        (error): nothing more is looked for.
    """

    gesture_seen: Event[[str]]
    joints_seen: "Event[[tuple[LiveJoints, ...]]]"
    unseen: Event[[str]]
    failed: Event[[AdibasError]]

    def use(self, wanted: Wanted) -> None:
        """Look for this from now on."""

    def put(self, frame: "LiveFrame") -> None:
        """Look at a frame as soon as there is time."""

    def close(self) -> None:
        """End, and wait until no thread is left."""


class PeoplePresenter:
    """Chooses what is looked for; says what is recognised for some seconds, and who is followed."""

    def __init__(self, view: PeopleView, workspace: Workspace, watch: PeopleWatch) -> None:
        self._view = view
        self._workspace = workspace
        self._watch = watch
        self._choice: GestureChoice = "none"
        self._wants_joints = False
        self._followed = ""
        self._n_told = 0
        self._is_telling = self._is_seen = False
        watch.gesture_seen.subscribe(self._on_gesture)
        watch.joints_seen.subscribe(self._on_joints)
        watch.unseen.subscribe(self._on_unseen)
        watch.failed.subscribe(self._on_failed)
        self._end = workspace.live.frame_arrived.subscribe(self._on_frame)

    def choose_gestures(self, choice: GestureChoice) -> None:
        """Look for these gestures from now on."""
        self._choice = choice
        self._begin()
        if choice == "own" and not models_of(choice):
            self._workspace.tell(
                "warning",
                _("No gesture was learned on this computer yet. Learn one under Observe."),
            )

    def want_joints(self, *, are_wanted: bool) -> None:
        """Draw joints from now on, or no more."""
        self._wants_joints = are_wanted
        self._begin()

    def enter(self) -> None:
        """Go on: gestures may have been learned meanwhile."""
        self._is_seen = True
        self._begin()

    def leave(self) -> None:
        """Rest: nobody would see it."""
        self._is_seen = False
        self._watch.use(Wanted())
        self._forget()

    def close(self) -> None:
        """End, and wait until no thread is left."""
        self._end()
        self._watch.close()

    def _on_frame(self, frame: "LiveFrame") -> None:
        if self._is_seen and (self._wants_joints or self._choice != "none"):
            self._watch.put(frame)

    def _begin(self) -> None:
        self._watch.use(Wanted(models_of(self._choice), self._wants_joints))
        self._forget()

    def _forget(self) -> None:
        self._followed, self._is_telling = "", False
        self._view.show_joints(())
        self._view.show_followed("")

    def _on_gesture(self, label: str) -> None:
        self._n_told += 1
        number, self._is_telling = self._n_told, True
        self._view.show_followed(_("Gesture: {name}").format(name=label))

        def end() -> None:
            if number == self._n_told and self._is_telling:
                self._is_telling = False
                self._view.show_followed(self._followed)

        self._view.call_later(SHOWN_MS, end)

    def _on_joints(self, people: "tuple[LiveJoints, ...]") -> None:
        self._view.show_joints(people)
        if people:
            self._follow(_told_of(people))

    def _on_unseen(self, reason: str) -> None:
        self._is_telling = False
        told = _("Nobody is followed without markers. {reason}").format(reason=reason)
        self._follow(told if reason else "")

    def _follow(self, sentence: str) -> None:
        """Say who is followed, once no gesture is told any more."""
        self._followed = sentence
        if not self._is_telling:
            self._view.show_followed(sentence)

    def _on_failed(self, error: AdibasError) -> None:
        self._workspace.report_problem(error)


def _told_of(people: "tuple[LiveJoints, ...]") -> str:
    """Say how many joints there are, and that they are no markers' values."""
    if len(people) > 1:
        told = _("Found without markers, less exact than with them: {n} people.")
        return told.format(n=len(people))
    told = _("Found without markers, less exact than with them: {n} of {all} joints.")
    found = told.format(n=people[0].n_seen, all=len(JOINT_NAMES))
    if people[0].is_view_sure:
        return found
    return " ".join([found, _("It is not sure yet whether the front or the back is seen.")])
