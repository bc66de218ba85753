"""What the settings screen shows and changes. Knows nothing of Qt."""

from pathlib import Path
from typing import Any, Protocol

from adibas.sensors.doctor import Finding, findings
from adibas.sessions import KeyState, VerifyReport, key_state
from adibas.sessions.keys import BEHIND_PASSPHRASE
from adibas.texts import translate as _
from ui.log import log_folder
from ui.ports import JobControl
from ui.preferences import Preferences
from ui.workspace import Workspace


class SettingsView(Protocol):
    """The screen, as this presenter needs it."""

    def show_preferences(self, preferences: Preferences) -> None:
        """Show what holds now."""

    def show_person(self, name: str) -> None:
        """Show who opened the store; nobody types another name for the log then."""

    def show_protection(self, folder: str, *, has_passphrase: bool, is_read_only: bool) -> None:
        """Show where the store lies and what keeps its key."""

    def show_log(self, folder: str) -> None:
        """Show where the program's log lies."""

    def show_findings(self, found: tuple[Finding, ...]) -> None:
        """Show what this computer has and lacks."""

    def show_check(self, sentences: tuple[str, ...]) -> None:
        """Show what a check of the store found; nothing = all is well."""

    def hide_check(self) -> None:
        """Show nothing of an earlier check."""

    def clear_passphrases(self) -> None:
        """Forget what was typed."""


class SettingsPresenter:
    """Changes preferences at once; what takes time runs as a job."""

    def __init__(self, view: SettingsView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._language = workspace.preferences.now.language
        self._has_findings = False
        self._ends = (
            workspace.preferences.changed.subscribe(self._on_preferences),
            workspace.person_changed.subscribe(self._show_person),
        )
        view.show_preferences(workspace.preferences.now)
        self._show_person()
        view.show_log(str(log_folder()))

    def close(self) -> None:
        """Listen no more."""
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show what keeps the key: the keyring may have to be asked."""
        self._show_protection()

    def change(self, **changes: Any) -> None:
        """Take new values of preferences."""
        self._workspace.preferences.change(**changes)

    def examine_computer(self) -> None:
        """Look at what this computer has and lacks."""

        def work(_control: JobControl) -> tuple[Finding, ...]:
            return findings(self._workspace.store.folder)

        self._has_findings = True
        self._workspace.jobs.start(_("Looking at this computer"), work, self._view.show_findings)

    def check_store(self) -> None:
        """Check the audit trail and every file of the store."""

        def work(control: JobControl) -> VerifyReport:
            return self._workspace.store.verify(control.progress)

        self._workspace.jobs.start(
            _("Checking the patient store"),
            work,
            lambda report: self._view.show_check(tuple(one.text for one in report.findings)),
        )

    def choose_store(self, folder: Path) -> None:
        """Work with the store in another folder, such as a shared one, from the next start on."""

        def work(_control: JobControl) -> KeyState:
            return key_state(folder)

        def done(state: KeyState) -> None:
            if state in (KeyState.NEW_KEYRING, KeyState.NEW_PASSPHRASE):
                told = _("There is no patient store in {folder}. Choose the folder of one.")
                self._workspace.tell("bad", told.format(folder=folder))
                return
            self._workspace.preferences.change(store=str(folder))
            told = _("The patient store in {folder} is opened from the next start on.")
            self._workspace.tell("good", told.format(folder=folder))

        self._workspace.jobs.start(_("Looking for the key of the patient store"), work, done)

    def change_passphrase(self, old: str, new: str, repeated: str) -> None:
        """Put the store's key behind a new passphrase: the store's, or that of who has it open."""
        if new != repeated:
            self._workspace.tell("bad", _("The two passphrases differ. Type the same one twice."))
            return
        store = self._workspace.store

        def work(_control: JobControl) -> None:
            has_one = key_state(store.folder) in BEHIND_PASSPHRASE
            store.people.change_passphrase(old if has_one else None, new)

        self._workspace.jobs.start(
            _("Changing the passphrase"), work, lambda _: self._changed(), stop="never"
        )

    def _changed(self) -> None:
        self._view.clear_passphrases()
        self._show_protection()
        self._workspace.tell("good", _("From now on the new passphrase opens the patient store."))

    def _on_preferences(self, now: Preferences) -> None:
        self._view.show_preferences(now)
        if now.language == self._language:
            return
        self._language = now.language
        self._view.hide_check()  # it was said in the language before
        if self._has_findings:
            self.examine_computer()

    def _show_person(self) -> None:
        person = self._workspace.store.person
        if person is not None:
            self._view.show_person(person.name)

    def _show_protection(self) -> None:
        store = self._workspace.store

        def work(_control: JobControl) -> bool:
            return key_state(store.folder) in BEHIND_PASSPHRASE

        def done(has_passphrase: bool) -> None:
            place = str(store.folder)
            if store.server:
                place = _("{folder}, its database on {server}").format(
                    folder=place, server=store.server
                )
            self._view.show_protection(
                place, has_passphrase=has_passphrase, is_read_only=store.is_read_only
            )

        self._workspace.jobs.start(_("Looking for the key of the patient store"), work, done)
