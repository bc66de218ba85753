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
        self._passphrase: str | None = None
        """Between the passphrase and the server's password alone."""

    def begin(self) -> None:
        """Open the store, or ask for what it needs."""
        self._look(lambda _state: self.open_from_keyring())

    def ask(self) -> None:
        """Ask for what the store needs, also where that is only a button: nobody may be here."""
        self._look(lambda _state: self._view.ask_unlock())

    def open_from_keyring(self) -> None:
        """Open with the key that the desktop keeps."""
        self._open(None, self._view.ask_unlock)

    def give_passphrase(self, passphrase: str) -> None:
        """Open with the passphrase of an existing store, or of one of its people."""
        self._open(passphrase, self._ask_passphrase)

    def give_server_password(self, password: str) -> None:
        """Open with the passphrase that was given, and with the password of the server."""
        self._open(self._passphrase, self._view.ask_server_password, password)

    def give_new_passphrase(self, passphrase: str, repeated: str) -> None:
        """Make a store behind a passphrase that was typed twice alike."""
        if passphrase != repeated:
            self._view.show_problem(_("The two passphrases differ. Type the same one twice."))
            return
        self._open(passphrase, self._view.ask_new_passphrase)

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
        passphrase: str | None,
        ask_again: Callable[[], None],
        server_password: str | None = None,
    ) -> None:
        self._view.show_busy()
        self._passphrase = None

        def work(control: JobControl) -> "tuple[SessionStore, bool]":
            from adibas.sessions import open_store

            is_new = key_state(self._folder) in NEW
            store = open_store(
                self._folder,
                passphrase,
                operator=self._operator,
                server_password=server_password,
            )
            try:
                control.progress(1, 1)
            except CancelledError:
                store.close()
                raise
            if server_password is not None:
                _remember(self._folder, server_password)
            return store, is_new

        def failed(error: AdibasError) -> None:
            if isinstance(error, ServerPasswordError):
                self._passphrase = passphrase
                self._view.ask_server_password()
                if server_password is None:
                    return  # nothing is wrong yet
            self._tell(error)

        self._jobs.start(
            _("Opening the patient store"),
            work,
            lambda opened: self._opened(*opened),
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
