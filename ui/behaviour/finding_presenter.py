"""What the program finds in the recording, for the observer to decide. Knows nothing of Qt."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.behaviour.editing import with_detected
from adibas.pipeline.behaviour import ESTIMATED
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.behaviour.coding_presenter import CodingPresenter
from ui.behaviour.ports import Source
from ui.events import Event
from ui.ports import Job, JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.pipeline.behaviour import BehaviourAnalysis
    from adibas.pipeline.found_joints import FoundJoints

SAID_IN_THE_HELP = (ESTIMATED,)


class FindingView(Protocol):
    """The screen, as this presenter needs it."""

    def show_finding(self, *, is_on: bool) -> None:
        """Show whether the program looks right now."""


class FindingPresenter:
    """Lets the program look at a recording, beside the window.

    Attributes
    ----------
    analysis : BehaviourAnalysis or None
        Of the recording that is open; None before it was looked at.
    joints : FoundJoints or None
        Of everybody in it: found once, since that takes longest.
    found : Event
        The recording was looked at.
    """

    def __init__(self, view: FindingView, workspace: Workspace, coding: CodingPresenter) -> None:
        self._view = view
        self._workspace = workspace
        self._coding = coding
        self._source: Source | None = None
        self._job: Job | None = None
        self.analysis: BehaviourAnalysis | None = None
        self.joints: FoundJoints | None = None
        self.found: Event[[]] = Event()

    def use(self, source: Source | None) -> None:
        """Look at this recording, or at none, from now on.

        What is still sought in another one is not told.
        """
        if self._job is not None:
            self._job.cancel()
        self._source, self.analysis, self.joints = source, None, None

    def keep_joints(self, source: Source, joints: "FoundJoints") -> None:
        """Keep joints that were found elsewhere, unless that recording was left."""
        if source is self._source:
            self.joints = joints

    def find(self, models: tuple[Path, ...]) -> None:
        """Look for posture changes, times out of view and the gestures of models.

        A second call while the program looks does nothing.
        """
        source, joints = self._source, self.joints
        if source is None or self._coding.is_blind or (self._job and self._job.is_running):
            return

        def work(control: JobControl) -> "BehaviourAnalysis":
            from adibas.pipeline.behaviour import BehaviourRequest, analyse_behaviour

            request = BehaviourRequest(
                *(source.path, models),
                access=source.access, joints=joints, name=source.name, parts=source.parts,
                rotation_deg=source.rotation_deg,
            )  # fmt: skip
            return analyse_behaviour(request, control.progress)

        self._view.show_finding(is_on=True)
        label = _("Finding events in {name}").format(name=source.title)
        self._job = self._workspace.jobs.start(
            label, work, lambda found: self._on_found(source, found), ended=self._on_ended
        )

    def _on_ended(self) -> None:
        self._view.show_finding(is_on=False)

    def _on_found(self, source: Source, analysis: "BehaviourAnalysis") -> None:
        draft = self._coding.draft
        if source is not self._source or draft is None:
            return
        self.analysis, self.joints = analysis, analysis.joints
        found = replace(analysis.detected, name=draft.coding.name)
        self._coding.edit(lambda old: with_detected(old, found))
        now = self._coding.draft
        n = 0 if now is None else len(now.proposed)
        sentence = translate_plural(
            "{n} event found. Enter takes it, Delete rejects it.",
            "{n} events found. Enter takes one, Delete rejects it.",
            n,
        ).format(n=n)
        notices = [one.text for one in analysis.notices if one.message not in SAID_IN_THE_HELP]
        self._workspace.tell("warning" if notices else "good", " ".join((sentence, *notices)))
        if n:
            self._coding.select_next_proposed()
        self.found.emit()
