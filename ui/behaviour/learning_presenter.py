"""Learns a gesture from events that are coded in the open recording. Knows nothing of Qt."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

from adibas.data.coding import MS_PER_S, Occurrence
from adibas.pipeline.own_gestures import OwnGesture, forget_gesture, keep_gesture, own_gestures
from adibas.reports.behaviour_texts import behaviour_text, subject_text
from adibas.texts import decimal_text, translate_plural
from adibas.texts import translate as _
from ui.behaviour.coding_presenter import CodingPresenter
from ui.behaviour.content import time_text
from ui.behaviour.finding_presenter import SAID_IN_THE_HELP, FindingPresenter
from ui.behaviour.ports import Source
from ui.behaviour.tables import TextTable
from ui.ports import Job, JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.pipeline.found_joints import FoundJoints
    from adibas.pipeline.gesture_learning import Trained


@dataclass(frozen=True, slots=True)
class Marked:
    """A behaviour that is coded, and how often."""

    behaviour: str
    n_examples: int


class LearningView(Protocol):
    """The dialog, as this presenter needs it."""

    def show_marked(self, marked: tuple[Marked, ...], chosen: str) -> None:
        """Offer what can be learned from."""

    def show_examples(self, table: TextTable) -> None:
        """Show the examples of what is chosen."""

    def show_learning(self, *, is_on: bool) -> None:
        """Show whether the program learns right now."""

    def show_result(self, sentence: str, shares: Mapping[str, float]) -> None:
        """Show how well the gesture is known, and by which joints; nothing before it is learned."""

    def show_own(self, names: tuple[str, ...]) -> None:
        """Show what was learned up to now."""

    def finish(self) -> None:
        """Close."""


class LearningPresenter:
    """One gesture at a time: choose its examples, learn it, look how well it is known, keep it.

    Parameters
    ----------
    note_export : callable
        Called before a model leaves the store: it holds how somebody moved.
    """

    def __init__(
        self,
        view: LearningView,
        workspace: Workspace,
        coding: CodingPresenter,
        finding: FindingPresenter,
        source: Source,
        note_export: Callable[[], None],
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._coding = coding
        self._finding = finding
        self._source = source
        self._note_export = note_export
        self._behaviour = ""
        self._job: Job | None = None
        self._trained: Trained | None = None
        self._own: tuple[OwnGesture, ...] = ()
        self._show_marked()
        self._show_own()

    def choose(self, behaviour: str) -> None:
        """Learn from the events of this behaviour; what is learned from another one is left."""
        self.close()
        self._behaviour = behaviour
        self._forget_result()
        since_ms = 0 if self._coding.draft is None else self._coding.draft.coding.begin_ms
        lines = tuple(
            (
                *(time_text(at - since_ms) for at in (one.begin_ms, one.end_ms)),
                decimal_text(one.duration_ms / MS_PER_S, 1),
                subject_text(one.subject),
            )
            for one in self._examples()
        )
        titles = (_("From"), _("To"), _("Duration [s]"), _("Who"))
        self._view.show_examples(TextTable(titles, lines, frozenset({2})))

    def learn(self, name: str) -> None:
        """Learn the gesture, beside the window; a second call meanwhile does nothing."""
        if self._job is not None and self._job.is_running:
            return
        self._forget_result()
        source, known, examples = self._source, self._finding.joints, self._examples()

        def work(control: JobControl) -> "tuple[FoundJoints, Trained]":
            from adibas.gestures.training import TrainingParams
            from adibas.pipeline.found_joints import JointSource, find_joints
            from adibas.pipeline.gesture_learning import learn, marked_lesson

            asked = JointSource(source.path, source.access, source.rotation_deg)
            joints = known or find_joints(asked, control.progress)
            lesson = marked_lesson(name, examples, joints.tracks, source.name)
            return joints, learn(lesson, TrainingParams(), control.progress, is_tested=True)

        self._view.show_learning(is_on=True)
        self._job = self._workspace.jobs.start(
            _("Learning {name}").format(name=name),
            work,
            lambda told: self._on_learned(*told),
            ended=lambda: self._view.show_learning(is_on=False),
        )

    def keep(self, name: str) -> None:
        """Keep what was learned, and look for it in the recording at once."""
        trained = self._trained
        if trained is None:
            return

        def keep() -> None:
            self._note_export()
            kept = keep_gesture(name, replace(trained.model, labels=(name,)))
            self._show_own()
            self._view.finish()
            self._finding.find((kept.path,))

        self._workspace.attempt(keep)

    def forget(self, index: int) -> None:
        """Remove one of the gestures that are shown."""
        self._workspace.attempt(lambda: forget_gesture(self._own[index]))
        self._show_own()

    def close(self) -> None:
        """Learn no more: nobody waits for what comes of it."""
        if self._job is not None and self._job.is_running:
            self._job.cancel()

    def _examples(self) -> tuple[Occurrence, ...]:
        draft = self._coding.draft
        some = () if draft is None else draft.coding.occurrences
        return tuple(one for one in some if one.behaviour == self._behaviour)

    def _show_marked(self) -> None:
        draft = self._coding.draft
        some = () if draft is None else draft.coding.occurrences
        counts = Counter(one.behaviour for one in some if one.duration_ms)
        marked = tuple(Marked(name, n) for name, n in counts.most_common())
        chosen = marked[0].behaviour if marked else ""
        self._view.show_marked(marked, chosen)
        self.choose(chosen)

    def _show_own(self) -> None:
        self._own = own_gestures()
        self._view.show_own(tuple(one.name for one in self._own))

    def _forget_result(self) -> None:
        self._trained = None
        self._view.show_result("", {})

    def _on_learned(self, joints: "FoundJoints", trained: "Trained") -> None:
        from adibas.gestures.descriptor import DESCRIBED_JOINTS

        self._finding.keep_joints(self._source, joints)
        self._trained = trained
        (row,) = trained.weights
        shares = dict(zip(DESCRIBED_JOINTS, map(float, row), strict=True))
        notices = [one for one in (*joints.notices, *trained.notices)
                   if one.message not in SAID_IN_THE_HELP]  # fmt: skip
        sentences = (*_tested(trained), *(one.text for one in notices))
        self._view.show_result(" ".join(sentences), shares)


def marked_text(one: Marked) -> str:
    """Return a behaviour and how many examples it has."""
    n_told = translate_plural("{n} example", "{n} examples", one.n_examples)
    return f"{behaviour_text(one.behaviour)}: {n_told.format(n=one.n_examples)}"


def _tested(trained: "Trained") -> list[str]:
    tested = trained.tested
    if tested is None:
        return [_("Learned.")]
    n_done, alarms = int(tested.n_done.sum()), tested.false_alarms
    found = _("Left out in turn, {right} of {n} examples are recognised ({percent} %).").format(
        right=tested.best_right, n=n_done, percent=decimal_text(100 * tested.accuracy, 0)
    )
    told = translate_plural(
        "{n} time something else was taken for it.", "{n} times something else was taken for it.",
        alarms,
    ).format(n=alarms)  # fmt: skip
    return [found, told]
