"""Opens the store at the start, and again after the window locked itself. Knows nothing of Qt."""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from adibas.errors import AdibasError
from adibas.sessions import KeyState, SessionStore, key_state, open_store
from adibas.texts import describe
from adibas.texts import translate as _
from ui.ports import JobControl, Jobs


class UnlockView(Protocol):
    """The page before the screens, as this presenter needs it."""

    def show_busy(self) -> None:
        """Say that the store is being opened."""

    def ask_new_passphrase(self) -> None:
        """Ask for the passphrase of a new store, twice."""

    def ask_passphrase(self) -> None:
        """Ask for the passphrase of the store."""

    def ask_unlock(self) -> None:
        """Ask for nothing but a button: the keyring keeps the key."""

    def show_problem(self, sentence: str) -> None:
        """Say what failed; what was asked for is still asked for."""


class UnlockPresenter:
    """Finds out what the store needs, asks for it, and hands the open store over.

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
        opened: Callable[[SessionStore, bool], None],
    ) -> None:
        self._view = view
        self._folder = folder
        self._operator = operator
        self._jobs = jobs
        self._opened = opened
        self._is_new = False

    def begin(self) -> None:
        """Open the store, or ask for what it needs."""
        try:
            state = key_state(self._folder)
        except AdibasError as error:
            self._view.ask_unlock()
            self._view.show_problem(describe(error))
            return
        self._is_new = state in (KeyState.NEW_KEYRING, KeyState.NEW_PASSPHRASE)
        if state is KeyState.NEW_PASSPHRASE:
            self._view.ask_new_passphrase()
        elif state is KeyState.PASSPHRASE:
            self._view.ask_passphrase()
        else:
            self._open(None, self._view.ask_unlock)

    def give_passphrase(self, passphrase: str) -> None:
        """Open with the passphrase of an existing store."""
        self._open(passphrase, self._view.ask_passphrase)

    def give_new_passphrase(self, passphrase: str, repeated: str) -> None:
        """Make a store behind a passphrase that was typed twice alike."""
        if passphrase != repeated:
            self._view.show_problem(_("The two passphrases differ. Type the same one twice."))
            return
        self._open(passphrase, self._view.ask_new_passphrase)

    def _open(self, passphrase: str | None, ask_again: Callable[[], None]) -> None:
        self._view.show_busy()
        is_new = self._is_new

        def work(_control: JobControl) -> SessionStore:
            return open_store(self._folder, passphrase, operator=self._operator)

        def failed(error: AdibasError) -> None:
            ask_again()
            self._view.show_problem(describe(error))

        self._jobs.start(
            _("Opening the patient store"), work, lambda store: self._opened(store, is_new), failed
        )
