"""Whose time is over by the rules of this clinic, and their removal. Knows nothing of Qt."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from adibas.errors import AdibasError
from adibas.texts import describe, translate_plural
from adibas.texts import translate as _
from ui.ports import CancelledError, JobControl
from ui.preferences import Preferences
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions import SessionStore
    from adibas.sessions.retention import Expired, RetentionRules


class RetentionView(Protocol):
    """The page, as this presenter needs it."""

    def show_rules(self, preferences: Preferences) -> None:
        """Show how long patients are kept."""

    def show_over(self, lines: tuple[str, ...]) -> None:
        """Show whose time is over, a line each; they can be removed now."""

    def show_nobody(self, sentence: str) -> None:
        """Say that there is nobody, or what became of them."""

    def clear(self) -> None:
        """Show nothing: another list would come now."""


@dataclass(frozen=True, slots=True)
class _Removal:
    """Who is gone, who is left as a line each, and what kept them from going, if it failed."""

    gone: frozenset[str]
    left: tuple[str, ...]
    problem: AdibasError | None


class RetentionPresenter:
    """Lists first; only who was listed by the rules that hold can be removed."""

    def __init__(self, view: RetentionView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        view.show_rules(workspace.preferences.now)

    def change(self, **changes: Any) -> None:
        """Take other rules; what was listed by those before is put away."""
        self._workspace.preferences.change(**changes)
        self._view.show_rules(self._workspace.preferences.now)
        self._view.clear()

    def look(self) -> None:
        """List whose time is over."""
        store, rules = self._workspace.store, self._rules()

        def work(_control: JobControl) -> tuple[str, ...]:
            over = store.retention.expired(rules, store.audit.now_utc().date())
            return _lines(store, over)

        self._workspace.jobs.start(_("Looking whose time is over"), work, self._show)

    def remove(self) -> None:
        """Remove whose time is over, for good; a stop leaves whose turn has not come."""
        store, rules = self._workspace.store, self._rules()

        def work(control: JobControl) -> _Removal:
            today, problem = store.audit.now_utc().date(), None
            over = store.retention.expired(rules, today)
            try:
                store.retention.apply(rules, today, control.progress)
            except CancelledError:
                pass  # who is gone already is told
            except AdibasError as error:
                problem = error
            left = store.retention.expired(rules, today)
            # Who came back meanwhile is not on the second list and not gone either.
            gone = {one.pseudonym for one in over} - set(store.patients.names())
            return _Removal(frozenset(gone), _lines(store, left), problem)

        self._workspace.jobs.start(
            _("Removing patients for good"), work, self._on_removed, stop="tells"
        )

    def _rules(self) -> "RetentionRules":
        from adibas.sessions.retention import RetentionRules

        now = self._workspace.preferences.now
        return RetentionRules(now.retention_years, now.child_until_age)

    def _show(self, lines: tuple[str, ...]) -> None:
        if lines:
            self._view.show_over(lines)
        else:
            self._view.show_nobody(_("Nobody's time is over by these rules."))

    def _on_removed(self, removal: _Removal) -> None:
        patient = self._workspace.patient
        if patient is not None and patient.pseudonym in removal.gone:
            self._workspace.choose_patient(None)
        n = len(removal.gone)
        told = translate_plural(
            "{n} patient was removed for good.", "{n} patients were removed for good.", n
        ).format(n=n)
        if removal.left:
            self._view.show_over(removal.left)
        else:
            self._view.show_nobody(told)
        if removal.problem is None:
            self._workspace.tell("good", told)
        else:
            self._workspace.tell("bad", f"{told} {describe(removal.problem)}")


def _lines(store: "SessionStore", over: "tuple[Expired, ...]") -> tuple[str, ...]:
    """Say who they are and why their time is over."""
    names = store.patients.names() if over else {}
    return tuple(_line(one, names.get(one.pseudonym, "")) for one in over)


def _line(one: "Expired", name: str) -> str:
    n = one.n_sessions
    sessions = translate_plural("{n} session", "{n} sessions", n).format(n=n)
    return f"{name} ({one.pseudonym}), {sessions}: {one.text}"
