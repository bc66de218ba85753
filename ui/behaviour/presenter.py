"""Which recording is looked at, and which of its frames. Knows nothing of Qt."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from adibas.behaviour.editing import History
from adibas.data.coding import MS_PER_S
from adibas.errors import AdibasError
from adibas.pipeline.recording_access import FILES
from adibas.texts import translate as _
from ui.behaviour.coding_presenter import CodingPresenter, CodingView
from ui.behaviour.counts_presenter import CountsPresenter, CountsView
from ui.behaviour.files_presenter import FilesPresenter, FilesView
from ui.behaviour.finding_presenter import FindingPresenter, FindingView
from ui.behaviour.learning_presenter import LearningPresenter, LearningView
from ui.behaviour.opening import Opened, first_draft, notices_of, open_source
from ui.behaviour.playing import SPEEDS, Playing, frame_at
from ui.behaviour.ports import FrameFeed, Keeper, Picture, Source
from ui.behaviour.sources import (
    ALL,
    StoredChoice,
    file_source,
    files_source,
    plain_title,
    stored_choices,
    stored_sources,
)
from ui.workspace import Workspace

KEEP_EVERY_S = 2.0
"""So much of a state that lasts is lost in a crash at most."""


@dataclass(frozen=True, slots=True)
class Position:
    """The frame that is seen.

    Attributes
    ----------
    index, n_frames : int
        Counted from 0.
    time_ms, begin_ms, end_ms : int
        Of the frame, and of the session.
    """

    index: int
    n_frames: int
    time_ms: int
    begin_ms: int
    end_ms: int


class BehaviourView(CodingView, FindingView, FilesView, CountsView, Protocol):
    """The screen, as this presenter needs it."""

    def show_source(self, title: str, name: str) -> None:
        """Show the recording that is open; nothing for none. Copies get its `name`."""

    def show_stored(self, choices: tuple[StoredChoice, ...]) -> None:
        """Offer the recordings of the session that is looked at."""

    def show_frame(self, picture: Picture | None, position: Position) -> None:
        """Show a frame; None where it cannot be read."""

    def show_playing(self, *, is_on: bool, speed: float) -> None:
        """Show whether the video runs, and how fast; `tick` is called while it does."""


class BehaviourPresenter:
    """Opens recordings, plays them, and has others code them.

    Parameters
    ----------
    clock_s : callable
        Seconds that only grow.
    title_of : callable
        Says what a stored recording is called.
    """

    def __init__(
        self,
        view: BehaviourView,
        workspace: Workspace,
        feed: FrameFeed,
        keeper: Keeper,
        clock_s: Callable[[], float] = time.monotonic,
        title_of: Callable[[StoredChoice], str] = plain_title,
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._feed = feed
        self._keeper = keeper
        self._clock_s = clock_s
        self._title_of = title_of
        self._source: Source | None = None
        self._wanted: Source | None = None
        self._times_ms: tuple[int, ...] = ()
        self._index = 0
        self._asked: int | None = None
        self._kept_s = 0.0
        self._playing = Playing((0,))
        self.coding = CodingPresenter(view, workspace, keeper, self.now_ms, self.go_to_ms)
        self.finding = FindingPresenter(view, workspace, self.coding)
        self.counts = CountsPresenter(view, workspace, self.coding, self.finding, self._note_export)
        self.files = FilesPresenter(
            view, workspace, self.coding, keeper, self.counts.compare, self._note_export
        )
        self._ends = [
            feed.arrived.subscribe(self._on_frame),
            feed.failed.subscribe(self._on_no_frame),
            workspace.session_changed.subscribe(self._on_session),
        ]

    @property
    def source(self) -> Source | None:
        """What is open."""
        return self._source

    def enter(self) -> None:
        """Show what there is to open."""
        self._show_stored()
        if self._source is None:
            self._view.show_source("", "")

    def refresh(self) -> None:
        """Say everything again, in the language in use."""
        self.coding.show()
        self.counts.show()

    def leave(self) -> None:
        """Stop the video; what was coded is on the disk when this returns."""
        self.stop()
        self.keep()

    def keep(self) -> bool:
        """Return whether everything that was coded is on the disk."""
        self.coding.keep()
        return self._keeper.flush()

    def close(self) -> None:
        """Let go of the recording and of threads."""
        for end in self._ends:
            end()
        self.coding.close()
        self._keeper.close()
        self._feed.close()

    def open_file(self, path: Path) -> None:
        """Open a recording from the disk."""
        self._open(file_source(path))

    def open_files(self, paths: Sequence[Path]) -> None:
        """Open recordings from the disk, one after another as one observation."""
        self._open(files_source(paths))

    def open_stored(self, recording_id: str) -> None:
        """Open a recording of the session that is looked at, or `ALL` of them as one."""
        found = stored_choices(self._workspace)
        chosen = [one for one in found if recording_id in (one.recording_id, ALL)]
        if chosen:
            title = self._title_of(chosen[0])
            self._open(stored_sources(self._workspace.store, chosen, title))

    def now_ms(self) -> int:
        """Return the time of the frame that is seen."""
        return self._times_ms[self._index] if self._times_ms else 0

    def go_to(self, index: int) -> None:
        """Show a frame; the video stands still then."""
        self.stop()
        self._ask(index)

    def go_to_end(self) -> None:
        """Show the last frame."""
        self.go_to(len(self._times_ms) - 1)

    def go_to_ms(self, time_ms: int) -> None:
        """Show the frame that is seen at a time."""
        if self._times_ms:
            self.go_to(frame_at(self._times_ms, time_ms))

    def step(self, n_frames: int) -> None:
        """Go some frames on, or back."""
        start = self._index if self._asked is None else self._asked
        self.go_to(start + n_frames)

    def skip_s(self, seconds: float) -> None:
        """Go some seconds on, or back; a running video goes on from there."""
        was_running = self._playing.is_on
        self.go_to_ms(self.now_ms() + round(MS_PER_S * seconds))
        if was_running and self._asked is not None:
            self._play_from(self._asked)

    def play_or_stop(self) -> None:
        """Run, or stand still; at the end it begins anew."""
        if self._playing.is_on:
            self.stop()
        elif self._times_ms:
            is_at_end = self._index >= len(self._times_ms) - 1
            self._play_from(0 if is_at_end else self._index)

    def stop(self) -> None:
        """Stand still."""
        if self._playing.is_on:
            self._playing.stop()
            self._show_playing()

    def set_speed(self, speed: float) -> None:
        """Run at this speed."""
        self._playing.set_speed(speed, self._clock_s())
        self._show_playing()

    def change_speed(self, step: int) -> None:
        """Run faster or slower."""
        number = SPEEDS.index(self._playing.speed) + step
        self.set_speed(SPEEDS[min(max(number, 0), len(SPEEDS) - 1)])

    def tick(self) -> None:
        """Show the frame that is due, unless the one before is still being read."""
        if not self._playing.is_on or self._asked is not None:
            return
        now_s = self._clock_s()
        if now_s - self._kept_s >= KEEP_EVERY_S:
            self._kept_s = now_s
            self.coding.keep_begun()
        due = self._playing.due(now_s)
        if due != self._index:
            self._ask(due)
        if due == len(self._times_ms) - 1:
            self.stop()

    @property
    def recording(self) -> Path | None:
        """The file that is looked at; None for none, for several, and for one in the store."""
        is_file = self._source is not None and self._source.access is FILES
        return self._source.path if self._source is not None and is_file else None

    def learn_from_marks(self, view: LearningView) -> LearningPresenter | None:
        """Return what learns a gesture in a dialog; None where nothing may be learned now."""
        if self._source is None or self.coding.is_blind:
            return None
        return LearningPresenter(
            *(view, self._workspace, self.coding, self.finding, self._source, self._note_export)
        )

    def key(self, text: str) -> bool:
        """Do what a key of the coding scheme stands for; return whether it stands for anything."""
        behaviour = self.coding.behaviour_of_key(text)
        subject = self.coding.subject_of_key(text)
        if behaviour is not None:
            self.coding.press(behaviour)
        elif subject is not None:
            self.coding.choose_subject(subject)
        return behaviour is not None or subject is not None

    def key_let_go(self, text: str) -> None:
        """End what lasts as long as a key is held."""
        behaviour = self.coding.behaviour_of_key(text)
        if behaviour is not None:
            self.coding.release(behaviour)

    def _play_from(self, index: int) -> None:
        self._playing.start(index, self._clock_s())
        self._show_playing()

    def _ask(self, index: int) -> None:
        if self._times_ms:
            self._asked = min(max(index, 0), len(self._times_ms) - 1)
            self._feed.ask(self._asked)

    def _open(self, source: Source) -> None:
        self.stop()
        self.coding.keep()
        self._keeper.flush()  # it may be the same recording, whose draft is read anew
        self._wanted = source
        label = _("Opening {name}").format(name=source.title)
        self._workspace.jobs.start(label, lambda _control: open_source(source), self._on_opened)

    def _on_opened(self, opened: Opened) -> None:
        if opened.source is not self._wanted or self._is_of_another(opened.source):
            opened.reader.close()  # it comes too late
            return
        self._source, self._times_ms = opened.source, opened.times_ms
        self._index, self._asked = 0, None
        self._playing = Playing(opened.times_ms, self._playing.speed)
        self._feed.show(opened.reader)
        self.finding.use(opened.source)
        self.counts.forget()
        self._view.show_source(opened.source.title, opened.source.name)
        self._show_playing()
        operator = self._workspace.preferences.now.operator
        new = History(first_draft(opened, operator))
        first = new if opened.first is None else opened.first.history
        second = None if opened.second is None else opened.second.history
        self.files.use(opened.source, first, opened.observer, second)
        for notice in notices_of(opened):
            self._workspace.tell("warning", notice)
        self._ask(0)

    def tell_typed_scheme(self) -> None:
        """Say where what was typed into a coding scheme goes on."""
        sentence = _(
            "What was being changed in the coding scheme is kept. Open the same recording and "
            "choose Change the coding scheme to go on."
        )
        self._workspace.tell("good", sentence)

    def _on_frame(self, index: int, picture: Picture) -> None:
        self._show_frame(index, picture)

    def _on_no_frame(self, index: int, error: AdibasError) -> None:
        self.stop()
        self._show_frame(index, None)
        self._workspace.report_problem(error)

    def _show_frame(self, index: int, picture: Picture | None) -> None:
        self._index = index
        if self._asked == index:
            self._asked = None
        times_ms = self._times_ms
        position = Position(index, len(times_ms), times_ms[index], times_ms[0], times_ms[-1])
        self._view.show_frame(picture, position)

    def _show_playing(self) -> None:
        self._view.show_playing(is_on=self._playing.is_on, speed=self._playing.speed)

    def _on_session(self) -> None:
        """Leave a recording of another patient or session."""
        if self._source is not None and self._is_of_another(self._source):
            self._leave_recording()
        self._show_stored()

    def _is_of_another(self, source: Source) -> bool:
        """Say whether a recording is of another session than the one that is looked at."""
        session = self._workspace.session
        now = "" if session is None else session.session_id
        return source.session_id not in ("", now)

    def _leave_recording(self) -> None:
        self.stop()
        self.coding.close()
        self.finding.use(None)
        self.counts.forget()
        self._feed.show(None)
        self._source, self._times_ms, self._asked = None, (), None
        self._view.show_source("", "")

    def note_map(self) -> None:
        """Log that a map leaves the store.

        Raises
        ------
        StoreError
            It cannot be logged, and nothing may leave then.
        """
        self._note_export("map")

    def _note_export(self, kind: str = "coding") -> None:
        """Log that something of a patient leaves the store.

        Raises
        ------
        StoreError
            It cannot be logged, and nothing may leave then.
        """
        source = self._source
        if source is not None and source.session_id:
            self._workspace.store.note_export(kind, source.session_id)

    def _show_stored(self) -> None:
        choices: tuple[StoredChoice, ...] = ()

        def find() -> None:
            nonlocal choices
            choices = stored_choices(self._workspace)

        self._workspace.attempt(find)
        self._view.show_stored(choices)
