"""Which gestures are looked for in live pictures, and what was seen. Knows nothing of Qt."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, get_args

from adibas.errors import AdibasError
from adibas.pipeline.own_gestures import GestureChoice, models_of
from adibas.texts import translate as _
from ui.events import Event
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.pipeline.live_frames import LiveFrame

CHOICES: tuple[GestureChoice, ...] = get_args(GestureChoice)
SHOWN_MS = 4000


class GestureView(Protocol):
    """The screen, as this presenter needs it."""

    def show_gesture(self, sentence: str) -> None:
        """Say what was recognised; nothing for nothing."""

    def call_later(self, milliseconds: int, call: Callable[[], None]) -> None:
        """Call in the window's thread, later."""


class GestureWatch(Protocol):
    """Looks at frames beside the window; what it tells arrives in its thread.

    Attributes
    ----------
    seen : Event
        (label): a gesture has just been done.
    unseen : Event
        (reason): nobody can be watched, in words; empty: somebody is again.
    failed : Event
        (error): nothing more is looked for.
    """

    seen: Event[[str]]
    unseen: Event[[str]]
    failed: Event[[AdibasError]]

    def use(self, models: tuple[Path, ...]) -> None:
        """Look for the gestures of these models from now on; none: for nothing."""

    def put(self, frame: "LiveFrame") -> None:
        """Look at a frame as soon as there is time."""

    def close(self) -> None:
        """End, and wait until no thread is left."""


class GesturePresenter:
    """Chooses models, and says what is recognised for some seconds."""

    def __init__(self, view: GestureView, workspace: Workspace, watch: GestureWatch) -> None:
        self._view = view
        self._workspace = workspace
        self._watch = watch
        self._choice: GestureChoice = "none"
        self._n_told = 0
        self._is_seen = False
        watch.seen.subscribe(self._on_seen)
        watch.unseen.subscribe(self._on_unseen)
        watch.failed.subscribe(self._on_failed)
        self._end = workspace.live.frame_arrived.subscribe(self._on_frame)

    def choose(self, choice: GestureChoice) -> None:
        """Look for these gestures from now on."""
        self._choice = choice
        models = self._begin()
        if choice == "own" and not models:
            self._workspace.tell(
                "warning",
                _("No gesture was learned on this computer yet. Learn one under Observe."),
            )

    def enter(self) -> None:
        """Go on: gestures may have been learned meanwhile."""
        self._is_seen = True
        self._begin()

    def leave(self) -> None:
        """Rest: nobody would see it."""
        self._is_seen = False
        self._watch.use(())
        self._view.show_gesture("")

    def close(self) -> None:
        """End, and wait until no thread is left."""
        self._end()
        self._watch.close()

    def _on_frame(self, frame: "LiveFrame") -> None:
        if self._is_seen and self._choice != "none":
            self._watch.put(frame)

    def _begin(self) -> tuple[Path, ...]:
        models = models_of(self._choice)
        self._watch.use(models)
        self._view.show_gesture("")
        return models

    def _on_seen(self, label: str) -> None:
        self._n_told += 1
        number = self._n_told
        self._view.show_gesture(_("Gesture: {name}").format(name=label))

        def end() -> None:
            if number == self._n_told:
                self._view.show_gesture("")

        self._view.call_later(SHOWN_MS, end)

    def _on_unseen(self, reason: str) -> None:
        self._n_told += 1
        told = _("No gesture is looked for. {reason}").format(reason=reason) if reason else ""
        self._view.show_gesture(told)

    def _on_failed(self, error: AdibasError) -> None:
        self._workspace.report_problem(error)
