"""Who names the markers, and what corrected sessions could teach. Knows no Qt."""

from typing import TYPE_CHECKING, Protocol

from adibas.texts import translate as _
from ui.ports import Job, JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.pipeline.names_in_use import NamesInUse
    from adibas.pipeline.skeleton_examples import LandmarkSet
    from adibas.pipeline.skeleton_sessions import HeldOut


class NamesView(Protocol):
    """The page, as this presenter needs it."""

    def show_names(self, rows: "tuple[NamesInUse, ...]", titles: tuple[str, ...]) -> None:
        """Show who names which landmarks; the titles of their protocols, in the same order."""

    def show_learning(self, *, is_running: bool) -> None:
        """Show whether something is being learned: nothing else can be begun meanwhile."""


class NamesPresenter:
    """Counts what was corrected, learns from it beside the window, and goes back."""

    def __init__(self, view: NamesView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._job: Job | None = None
        self._learning: Job | None = None

    def enter(self) -> None:
        """Show what holds now."""
        if self._job is not None and self._job.is_running:
            self._job.cancel()
        store = self._workspace.store

        def work(_control: JobControl) -> "tuple[tuple[NamesInUse, ...], tuple[str, ...]]":
            from adibas.pipeline.names_in_use import names_in_use

            rows = names_in_use(store)
            return rows, tuple(_title_of(row.which.protocol) for row in rows)

        self._job = self._workspace.jobs.start(
            _("Counting corrected sessions"), work, lambda found: self._view.show_names(*found)
        )

    def learn(self, which: "LandmarkSet") -> None:
        """Learn a model from the corrected captures of these landmarks, and use it."""
        if self._learning is not None and self._learning.is_running:
            return
        store = self._workspace.store

        def work(control: JobControl) -> "HeldOut":
            from adibas.pipeline.names_in_use import learn_own_names

            return learn_own_names(store, which, control.progress)

        self._view.show_learning(is_running=True)
        self._learning = self._workspace.jobs.start(
            _("Learning names from corrected sessions"),
            work,
            self._tell,
            ended=lambda: self._view.show_learning(is_running=False),
        )

    def go_back(self, which: "LandmarkSet") -> None:
        """Use the own model of these landmarks no more; the sessions it learned from stay."""

        def forget() -> None:
            from adibas.pipeline.namers import forget_own_model

            forget_own_model(which)
            self._workspace.tell(
                "good",
                _("The own model is no longer used. It can be learned again from the sessions."),
            )

        self._workspace.attempt(forget)
        self.enter()

    def _tell(self, held_out: "HeldOut") -> None:
        self._workspace.tell(
            "good",
            _(
                "The own model names markers from now on. Of {n} captures that it had not seen, "
                "it named {right} right and {wrong} with a mistake."
            ).format(n=held_out.n_examples, right=held_out.right, wrong=held_out.wrong),
        )
        self.enter()


def _title_of(name: str) -> str:
    """Return what people call a protocol; its name where it is lost, nothing without one."""
    from adibas.errors import ProtocolError
    from adibas.measures.protocol_store import find_protocol

    if not name:
        return ""
    try:
        return find_protocol(name).title.text
    except ProtocolError:
        return name
