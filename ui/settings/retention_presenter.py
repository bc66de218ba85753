"""Whose time is over by the rules of this clinic, and their removal. Knows nothing of Qt."""

from typing import TYPE_CHECKING, Any, Protocol

from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.ports import JobControl
from ui.preferences import Preferences
from ui.workspace import Workspace

if TYPE_CHECKING:
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
            names = store.patients.names() if over else {}
            return tuple(_line(one, names.get(one.pseudonym, "")) for one in over)

        self._workspace.jobs.start(_("Looking whose time is over"), work, self._show)

    def remove(self) -> None:
        """Remove whose time is over, for good."""
        store, rules = self._workspace.store, self._rules()

        def work(control: JobControl) -> "tuple[Expired, ...]":
            today = store.audit.now_utc().date()
            return store.retention.apply(rules, today, control.progress)

        self._workspace.jobs.start(_("Removing patients for good"), work, self._on_removed)

    def _rules(self) -> "RetentionRules":
        from adibas.sessions.retention import RetentionRules

        now = self._workspace.preferences.now
        return RetentionRules(now.retention_years, now.child_until_age)

    def _show(self, lines: tuple[str, ...]) -> None:
        if lines:
            self._view.show_over(lines)
        else:
            self._view.show_nobody(_("Nobody's time is over by these rules."))

    def _on_removed(self, removed: "tuple[Expired, ...]") -> None:
        patient = self._workspace.patient
        if patient is not None and patient.pseudonym in {one.pseudonym for one in removed}:
            self._workspace.choose_patient(None)
        n = len(removed)
        told = translate_plural(
            "{n} patient was removed for good.", "{n} patients were removed for good.", n
        ).format(n=n)
        self._view.show_nobody(told)
        self._workspace.tell("good", told)


def _line(one: "Expired", name: str) -> str:
    n = one.n_sessions
    sessions = translate_plural("{n} session", "{n} sessions", n).format(n=n)
    return f"{name} ({one.pseudonym}), {sessions}: {one.text}"
