"""Opens the store at the start, and again after the window locked itself. Knows nothing of Qt."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.errors import AdibasError, ServerPasswordError
from adibas.sessions import KeyState, key_state
from adibas.sessions.keys import BEHIND_PASSPHRASE
from adibas.texts import describe
from adibas.texts import translate as _
from ui.ports import CancelledError, JobControl, Jobs

if TYPE_CHECKING:  # the database comes in the job that opens it
    from adibas.sessions import SessionStore

Open = Callable[[str | None], "SessionStore"]
"""Opens the store; given is the password of its server."""
NEW = (KeyState.NEW_KEYRING, KeyState.NEW_PASSPHRASE)


class UnlockView(Protocol):
    """The page before the screens, as this presenter needs it."""

    def show_busy(self) -> None:
        """Say that the store is being opened."""

    def ask_new_passphrase(self) -> None:
        """Ask for the passphrase of a new store, twice."""

    def ask_passphrase(self) -> None:
        """Ask for the passphrase of the store."""

    def ask_own_passphrase(self) -> None:
        """Ask for the passphrase of one of the people who may open the store."""

    def ask_server_password(self) -> None:
        """Ask for the password of the server that keeps the database."""

    def ask_unlock(self) -> None:
        """Ask for nothing but a button: the keyring keeps the key."""

    def ask_recovery_key(self) -> None:
        """Ask for the recovery key; what was typed of it stays, to be mended."""

    def ask_replacement(self, names: tuple[str, ...]) -> None:
        """Ask for a passphrase in place of the lost one, twice, and which administrator's it is.

        Without names the store has no people.
        """

    def show_problem(self, sentence: str) -> None:
        """Say what failed; what was asked for is still asked for."""


class UnlockPresenter:
    """Finds out what the store needs, asks for it, and hands the open store over.

    The keyring is asked in a job, too: the desktop may show a question of its own meanwhile.

    Parameters
    ----------
    view : UnlockView
        The page.
    folder : Path
        Of the store.
    operator : str
        Who works here.
    jobs : Jobs
        Opening takes half a second and more.
    opened : callable
        Told of the store, and whether it is new.
    """

    def __init__(
        self,
        view: UnlockView,
        folder: Path,
        operator: str,
        jobs: Jobs,
        opened: Callable[["SessionStore", bool], None],
    ) -> None:
        self._view = view
        self._folder = folder
        self._operator = operator
        self._jobs = jobs
        self._opened = opened
        self._ask_passphrase = view.ask_passphrase
        self._again: Open | None = None
        """How the store opens: between the passphrase and the server's password alone."""
        self._recovery_key = ""
        """Between it and the new passphrase alone."""
        self._names: tuple[str, ...] = ()

    def begin(self) -> None:
        """Open the store, or ask for what it needs."""
        self._look(lambda _state: self.open_from_keyring())

    def ask(self) -> None:
        """Ask for what the store needs, also where that is only a button: nobody may be here."""
        self._look(lambda _state: self._view.ask_unlock())

    def open_from_keyring(self) -> None:
        """Open with the key that the desktop keeps."""
        self._open(self._with(None), self._view.ask_unlock)

    def give_passphrase(self, passphrase: str) -> None:
        """Open with the passphrase of an existing store, or of one of its people."""
        self._open(self._with(passphrase), self._ask_passphrase)

    def give_server_password(self, password: str) -> None:
        """Open with the passphrase that was given, and with the password of the server."""
        again = self._again or self._with(None)
        self._open(again, self._view.ask_server_password, password)

    def give_new_passphrase(self, passphrase: str, repeated: str) -> None:
        """Make a store behind a passphrase that was typed twice alike."""
        if passphrase != repeated:
            self._view.show_problem(_("The two passphrases differ. Type the same one twice."))
            return
        self._open(self._with(passphrase), self._view.ask_new_passphrase)

    def begin_recovery(self) -> None:
        """Ask for the recovery key: the passphrase or the keyring is lost."""
        self._view.ask_recovery_key()

    def leave_recovery(self) -> None:
        """Ask again for what opens the store otherwise."""
        self._recovery_key, self._names = "", ()
        self.ask()

    def give_recovery_key(self, typed: str) -> None:
        """See whether the recovery key is right, and ask for a new passphrase."""
        self._view.show_busy()

        def work(_control: JobControl) -> tuple[str, ...]:
            from adibas.sessions.recovering import administrators

            return administrators(self._folder, typed)

        def done(names: tuple[str, ...]) -> None:
            self._recovery_key, self._names = typed, names
            self._view.ask_replacement(names)

        self._jobs.start(
            _("Trying the recovery key"),
            work,
            done,
            self._tell,
            ended=self._view.ask_recovery_key,
        )

    def give_replacement(self, name: str, passphrase: str, repeated: str) -> None:
        """Open with the recovery key; the new passphrase takes the place of the lost one."""
        if passphrase != repeated:
            self._view.show_problem(_("The two passphrases differ. Type the same one twice."))
            return
        folder, operator = self._folder, self._operator
        recovery_key, names = self._recovery_key, self._names

        def recover(server_password: str | None) -> "SessionStore":
            from adibas.sessions.recovering import RecoveryWish, recover_store

            wish = RecoveryWish(recovery_key, passphrase, name)
            return recover_store(folder, wish, operator=operator, server_password=server_password)

        self._open(recover, lambda: self._view.ask_replacement(names))

    def _with(self, passphrase: str | None) -> "Open":
        """Return how the store opens with a passphrase, or with the keyring."""
        folder, operator = self._folder, self._operator

        def open_it(server_password: str | None) -> "SessionStore":
            from adibas.sessions import open_store

            return open_store(
                folder, passphrase, operator=operator, server_password=server_password
            )

        return open_it

    def _look(self, with_keyring: Callable[[KeyState], None]) -> None:
        """Find out where the key is; ask for a passphrase where there must be one."""
        self._view.show_busy()

        def work(_control: JobControl) -> KeyState:
            return key_state(self._folder)

        def done(state: KeyState) -> None:
            if state is KeyState.NEW_PASSPHRASE:
                self._view.ask_new_passphrase()
            elif state in BEHIND_PASSPHRASE:
                has_people = state is KeyState.PEOPLE
                view = self._view
                self._ask_passphrase = (
                    view.ask_own_passphrase if has_people else view.ask_passphrase
                )
                self._ask_passphrase()
            else:
                with_keyring(state)

        self._jobs.start(
            _("Looking for the key of the patient store"),
            work,
            done,
            self._tell,
            ended=self._view.ask_unlock,
        )

    def _open(
        self,
        open_it: "Open",
        ask_again: Callable[[], None],
        server_password: str | None = None,
    ) -> None:
        self._view.show_busy()
        self._again = None

        def work(control: JobControl) -> "tuple[SessionStore, bool]":
            is_new = key_state(self._folder) in NEW
            store = open_it(server_password)
            try:
                control.progress(1, 1)
            except CancelledError:
                store.close()
                raise
            if server_password is not None:
                _remember(self._folder, server_password)
            return store, is_new

        def done(opened: "tuple[SessionStore, bool]") -> None:
            self._recovery_key, self._names = "", ()
            self._opened(*opened)

        def failed(error: AdibasError) -> None:
            if isinstance(error, ServerPasswordError):
                self._again = open_it
                self._view.ask_server_password()
                if server_password is None:
                    return  # nothing is wrong yet
            self._tell(error)

        self._jobs.start(
            _("Opening the patient store"),
            work,
            done,
            failed,
            ended=ask_again,
        )

    def _tell(self, error: AdibasError) -> None:
        self._view.show_problem(describe(error))


def _remember(folder: Path, password: str) -> None:
    """Keep a password that the server took in the desktop's keyring, where there is one."""
    from adibas.sessions.server_address import read_server_file
    from adibas.sessions.server_password import keep_password

    address = read_server_file(folder)
    if address is not None:
        keep_password(address, password)
