"""Measures a wand before the sensor, and keeps what came of it. Knows nothing of Qt."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from typing import Protocol

from adibas.calibration.wand import WandCheck
from adibas.clock import Clock, utc_now
from adibas.data.sessions import SessionSetup
from adibas.pipeline.wand_check import (
    N_ENDS,
    SeenWand,
    compare_ends,
    is_fresh,
    see_wand,
    wand_from_document,
    wand_to_document,
)
from adibas.texts import message
from adibas.texts import translate as _
from ui.ports import Job, JobControl
from ui.workspace import Workspace

MILLIMETRES = 1000.0
NO_COLOR = message("No marker colour is learned yet. Learn it, then measure the wand.")
NO_PICTURE = message("Wait for the picture of the sensor.")
CHOOSE = message("{n} markers are seen. Choose the two at the ends of the wand.")
Ends = tuple[int, int]


def without_old_wand(setup: SessionSetup, now_utc: datetime) -> SessionSetup:
    """Return the set-up for a new session: a check of another day is not its own."""
    is_kept = setup.wand is None or is_fresh(setup.wand, now_utc)
    return setup if is_kept else replace(setup, wand=None)


class WandView(Protocol):
    """The dialog, as its presenter needs it."""

    def show_length(self, length_mm: float) -> None:
        """Show the length that was typed last."""

    def show_readiness(self, sentence: str, *, is_ready: bool) -> None:
        """Say what lacks before a wand can be measured."""

    def show_measuring(self, *, is_measuring: bool) -> None:
        """Show that frames are being taken."""

    def show_seen(self, seen: SeenWand, ends: Ends | None) -> None:
        """Show the picture and its markers; `ends` are the chosen ones, None where none are."""

    def show_check(self, check: WandCheck, when: str) -> None:
        """Show a verdict; `when` is empty for one of right now."""

    def show_problem(self, sentence: str) -> None:
        """Say why there is no verdict."""


class WandPresenter:
    """Takes a burst, finds the ends of the wand, compares them with its length.

    Parameters
    ----------
    keep : callable
        Keeps the document of a check with the session.
    earlier : mapping or None
        The check that the session has.
    """

    def __init__(
        self,
        view: WandView,
        workspace: Workspace,
        keep: Callable[[Mapping[str, object]], None],
        earlier: Mapping[str, object] | None = None,
        clock: Clock = utc_now,
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._keep = keep
        self._clock = clock
        self._seen: SeenWand | None = None
        self._ends: Ends | None = None
        self._job: Job | None = None
        self._ends_of_events = [
            workspace.live.state_changed.subscribe(lambda _state: self._show_readiness())
        ]
        view.show_length(workspace.preferences.now.wand_length_mm)
        self._show_readiness()
        if earlier is not None:
            check, checked_utc = wand_from_document(earlier)
            view.show_check(check, checked_utc.astimezone().strftime("%Y-%m-%d %H:%M"))

    def close(self) -> None:
        """Listen no more, and give up what is being taken."""
        for end in self._ends_of_events:
            end()
        if self._job is not None and self._job.is_running:
            self._job.cancel()

    def measure(self) -> None:
        """Take a burst of the wand."""
        live, target = self._workspace.live, self._workspace.target
        if self._is_busy or self._lack() or target is None:
            return
        view = live.view

        def work(control: JobControl) -> SeenWand:
            return see_wand(view, target, control.progress)

        self._view.show_measuring(is_measuring=True)
        self._job = self._workspace.jobs.start(
            _("Measuring the wand"), work, self._on_seen, ended=self._on_ended
        )

    def set_length(self, length_mm: float) -> None:
        """Compare with this length."""
        self._workspace.preferences.change(wand_length_mm=length_mm)
        self._compare()

    def choose(self, ends: Ends) -> None:
        """Take these markers for the ends of the wand."""
        self._ends = ends if ends[0] != ends[1] else None
        self._compare()

    @property
    def _is_busy(self) -> bool:
        return self._job is not None and self._job.is_running

    def _on_ended(self) -> None:
        self._job = None
        self._view.show_measuring(is_measuring=False)
        self._show_readiness()

    def _on_seen(self, seen: SeenWand) -> None:
        self._seen = seen
        self._ends = (0, 1) if len(seen.markers) == N_ENDS else None
        self._view.show_seen(seen, self._ends)
        self._compare()

    def _compare(self) -> None:
        seen = self._seen
        if seen is None:
            return
        if self._ends is None:
            self._view.show_problem(_(CHOOSE).format(n=len(seen.markers)))
            return
        one, other = (seen.markers[index] for index in self._ends)
        length_m = self._workspace.preferences.now.wand_length_mm / MILLIMETRES
        check = compare_ends(one, other, length_m)
        self._view.show_check(check, "")
        self._keep(wand_to_document(check, self._clock()))

    def _lack(self) -> str:
        if self._workspace.live.state.kind != "live":
            return _(NO_PICTURE)
        return _(NO_COLOR) if self._workspace.target is None else ""

    def _show_readiness(self) -> None:
        lack = self._lack()
        self._view.show_readiness(lack, is_ready=not lack and not self._is_busy)
