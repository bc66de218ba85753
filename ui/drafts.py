"""What was typed and not saved when the window locked: kept sealed until it is unlocked."""

from typing import TYPE_CHECKING

from ui.window import MainWindow

if TYPE_CHECKING:  # the database comes in the job that opens it
    from adibas.sessions.sealing import AesSeal


class Drafts:
    """Nobody reads it meanwhile, not even in this computer's memory, without the store's key."""

    def __init__(self, window: MainWindow) -> None:
        self._window = window
        self._sealed: dict[str, bytes] = {}
        self._owner = ""

    def keep(self, seal: "AesSeal", owner: str = "") -> None:
        """Keep what stands in the screens, which are about to be closed.

        Parameters
        ----------
        owner : str
            Who typed it; it waits for them, until somebody else leaves something typed.
        """
        typed = self._window.drafts()
        if typed and owner != self._owner:
            self._sealed.clear()
        if typed:
            self._owner = owner
        self._sealed |= {name: seal.seal(name, text.encode()) for name, text in typed.items()}

    @property
    def are_there(self) -> bool:
        """Whether something waits to be given back."""
        return bool(self._sealed)

    def give_back(self, seal: "AesSeal", owner: str = "") -> None:
        """Give every screen what was typed into it, to whoever typed it."""
        if owner != self._owner:
            return
        for name, sealed in self._sealed.items():
            text = seal.open(name, sealed).decode()
            self._window.screen_named(name).take_back(text)
        self._sealed.clear()
