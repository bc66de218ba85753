"""The captures that a session has of its views. Knows nothing of Qt."""

from adibas.arrays import UInt8Array
from adibas.data.posture import VIEWS
from adibas.data.sessions import Capture, Session
from adibas.sessions import SessionStore


class TakenViews:
    """The last capture of each view of one session; small pictures are fetched once.

    Attributes
    ----------
    captures : dict
        By view.
    pictures : dict
        (h, w, 3) uint8 RGB, by view.
    """

    def __init__(self, store: SessionStore) -> None:
        self._store = store
        self._pictures: dict[str, UInt8Array] = {}
        self.captures: dict[str, Capture] = {}
        self.pictures: dict[str, UInt8Array] = {}

    def read(self, session: Session | None) -> None:
        """Ask the store what the session has.

        Raises
        ------
        StoreError
            It cannot be asked; what was known stays.
        """
        found = () if session is None else self._store.captures.of_session(session.session_id)
        captures = {capture.view: capture for capture in found}
        known = {}
        for capture in captures.values():
            name = capture.capture_id
            picture = self._pictures.get(name)
            known[name] = self._store.captures.thumbnail(name) if picture is None else picture
        self._pictures, self.captures = known, captures
        self.pictures = {view: known[one.capture_id] for view, one in captures.items()}

    @property
    def first_left(self) -> str | None:
        """The first view that was not taken yet."""
        return next((view for view in VIEWS if view not in self.captures), None)
