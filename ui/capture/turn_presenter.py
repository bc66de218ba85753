"""A slow turn of the patient: recorded, and noted in the session. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from adibas.pipeline.live import SensorState
from adibas.pipeline.turn_taking import TakenTurn, take_turn
from adibas.texts import describe
from adibas.texts import translate as _
from ui.capture.source_presenter import SourcePresenter
from ui.ports import Job, JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions.conflicts import Decision


class TurnPresenter:
    """Takes one turn at a time.

    A recording and the simulator begin anew with the turn, which has to begin with the back.

    Parameters
    ----------
    taken : callable
        Told when a turn is in the store and noted.
    ended : callable
        Told whenever nothing is being taken any more.
    """

    def __init__(
        self,
        workspace: Workspace,
        sources: SourcePresenter,
        taken: Callable[[], None],
        ended: Callable[[], None],
    ) -> None:
        self._workspace = workspace
        self._sources = sources
        self._taken, self._ended = taken, ended
        self._waiting_for: str | None = None
        self._is_opening = False
        self._job: Job | None = None

    @property
    def is_running(self) -> bool:
        """Whether a turn is being taken."""
        return self._waiting_for is not None or (self._job is not None and self._job.is_running)

    def take(self, session_id: str) -> None:
        """Record a turn of a session's patient."""
        self._waiting_for, self._is_opening = session_id, False
        if not self._sources.begin_anew():
            self._record(session_id)

    def cancel(self) -> None:
        """Give up the turn, if there is one."""
        self.stop_waiting()
        if self._job is not None and self._job.is_running:
            self._job.cancel()

    def stop_waiting(self) -> None:
        """Give up a turn that has not begun; one that is being recorded goes on."""
        if self._waiting_for is not None:
            self._waiting_for = None
            self._ended()

    def note_state(self, state: SensorState) -> None:
        """Begin as soon as the source that was opened anew gives pictures."""
        if self._waiting_for is None:
            return
        if state.kind == "live":
            self._record(self._waiting_for)
        elif state.kind == "opening":
            self._is_opening = True
        elif state.kind != "closed" or self._is_opening:  # before: what was open is closed
            if state.error is not None:
                self._workspace.tell("bad", describe(state.error))
            self.stop_waiting()

    def _record(self, session_id: str) -> None:
        self._waiting_for = None
        store, live = self._workspace.store, self._workspace.live.view

        def work(control: JobControl) -> TakenTurn:
            return take_turn(store, live, session_id, control.progress)

        self._job = self._workspace.jobs.start(
            _("Recording the turn"), work, self._on_taken, ended=self._ended
        )

    def _on_taken(self, turn: TakenTurn) -> None:
        if not self._workspace.save_shared(lambda decisions: self._note(turn, decisions)):
            return
        sentence = _("The turn is recorded. Under Compare, it becomes the whole body.")
        told = " ".join((sentence, *(_(notice) for notice in turn.notices)))
        self._workspace.tell_here("warning" if turn.notices else "good", told)
        self._taken()

    def _note(self, turn: TakenTurn, decisions: "tuple[Decision, ...]") -> None:
        """Keep the recording's name with the session that the turn was taken in."""
        sessions = self._workspace.store.sessions
        session = sessions.get(turn.session_id)
        changed = sessions.change(
            session.session_id,
            setup=replace(session.setup, turn=turn.recording_id),
            seen=session,
            decisions=decisions,
        )
        self._workspace.renew_session(changed)
