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

    def keep(self, seal: "AesSeal") -> None:
        """Keep what stands in the screens, which are about to be closed."""
        typed = self._window.drafts()
        self._sealed |= {name: seal.seal(name, text.encode()) for name, text in typed.items()}

    @property
    def are_there(self) -> bool:
        """Whether something waits to be given back."""
        return bool(self._sealed)

    def give_back(self, seal: "AesSeal") -> None:
        """Give every screen what was typed into it."""
        for name, sealed in self._sealed.items():
            text = seal.open(name, sealed).decode()
            self._window.screen_named(name).take_back(text)
        self._sealed.clear()
