"""A patient's sessions as a list, with pictures that are read when they are seen."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import (
    QAbstractListModel,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import QImage, QPixmap

from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.patients.content import Thumbnail
from ui.view_names import VIEW_NAMES
from ui.widgets.dates import moment_text

if TYPE_CHECKING:  # patients are listed before anything is known of their sessions
    from adibas.data.sessions import Session

Index = QModelIndex | QPersistentModelIndex
Role = Qt.ItemDataRole
NO_PARENT = QModelIndex()


@dataclass(frozen=True, slots=True, eq=False)
class ShownCapture:
    """A capture as the list paints it; no picture while it is being read, or where it is lost."""

    capture_id: str
    caption: str
    pixmap: QPixmap | None


@dataclass(frozen=True, slots=True, eq=False)
class ShownSession:
    """A session as the list paints it."""

    session: "Session"
    text: str
    captures: tuple[ShownCapture, ...]
    is_current: bool


class HistoryModel(QAbstractListModel):
    """Asks for the pictures of a session when it is painted for the first time."""

    pictures_wanted = Signal(tuple)
    """Ids of sessions."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._sessions: tuple[Session, ...] = ()
        self._current: str | None = None
        self._pictures: dict[tuple[str, tuple[str, ...]], tuple[Thumbnail, ...]] = {}
        self._pixmaps: dict[str, QPixmap] = {}
        self._wanted: dict[str, None] = {}
        self._asked: set[tuple[str, tuple[str, ...]]] = set()
        self._asking = QTimer(self)  # so that what is painted together is read together
        self._asking.setSingleShot(True)
        self._asking.setInterval(0)
        self._asking.timeout.connect(self._ask)

    def show_sessions(self, sessions: "tuple[Session, ...]") -> None:
        """Show these; pictures that were read stay."""
        if sessions == self._sessions:
            return
        self.beginResetModel()
        self._sessions = sessions
        keys = {_key(session) for session in sessions}
        self._asked &= keys
        self._pictures = {key: one for key, one in self._pictures.items() if key in keys}
        ids = {capture_id for _session, captures in keys for capture_id in captures}
        self._pixmaps = {key: one for key, one in self._pixmaps.items() if key in ids}
        self.endResetModel()

    def show_current(self, session_id: str | None) -> None:
        """Mark a session."""
        self._current = session_id
        self._repaint()

    def show_thumbnails(self, thumbnails: dict[str, tuple[Thumbnail, ...]]) -> None:
        """Take pictures that were asked for."""
        for session in self._sessions:
            if session.session_id in thumbnails:
                found = thumbnails[session.session_id]
                self._pictures[_key(session)] = found
                self._pixmaps |= {one.capture_id: _pixmap(one) for one in found}
        self._repaint()

    def session(self, row: int) -> "Session":
        """Return the session of a row."""
        return self._sessions[row]

    def retranslate(self) -> None:
        """Speak the language in use."""
        self.layoutChanged.emit()

    def row_of(self, session_id: str | None) -> int | None:
        """Return the row of a session; None where it is not listed."""
        ids = [session.session_id for session in self._sessions]
        return ids.index(session_id) if session_id in ids else None

    def stop(self) -> None:
        """Ask for nothing more."""
        self._asking.stop()

    def rowCount(self, parent: Index = NO_PARENT) -> int:  # noqa: N802  (Qt's name)
        return 0 if parent.isValid() else len(self._sessions)

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        session = self._sessions[index.row()]
        if role == Role.DisplayRole:
            return session_text(session)
        if role == Role.ToolTipRole:
            return session.notes or None
        return None

    def shown(self, row: int) -> ShownSession:
        """Return a session as it is painted; pictures that are lacking will be asked for."""
        session = self._sessions[row]
        known = {one.capture_id: one for one in self._pictures.get(_key(session), ())}
        if session.capture_ids and _key(session) not in self._asked:
            self._asked.add(_key(session))
            self._wanted[session.session_id] = None
            self._asking.start()
        captures = tuple(
            ShownCapture(
                one,
                _(VIEW_NAMES[known[one].view]) if one in known else "",
                self._pixmaps.get(one),
            )
            for one in session.capture_ids
        )
        is_current = session.session_id == self._current
        return ShownSession(session, session_text(session), captures, is_current)

    def _ask(self) -> None:
        wanted, self._wanted = tuple(self._wanted), {}
        if wanted:
            self.pictures_wanted.emit(wanted)

    def _repaint(self) -> None:
        if self._sessions:
            self.dataChanged.emit(self.index(0), self.index(len(self._sessions) - 1))


def session_text(session: "Session") -> str:
    """Return what is to be known of a session at a glance."""
    count = len(session.capture_ids)
    captures = translate_plural("{count} capture", "{count} captures", count).format(count=count)
    facts = (moment_text(session.started_utc), captures, session.operator)
    return "  ·  ".join(fact for fact in facts if fact)


def _key(session: "Session") -> tuple[str, tuple[str, ...]]:
    return session.session_id, session.capture_ids


def _pixmap(thumbnail: Thumbnail) -> QPixmap:
    """Return the picture; an empty one where it cannot be read."""
    picture = thumbnail.picture_rgb
    if picture is None:
        return QPixmap()
    height, width = picture.shape[:2]
    image = QImage(picture.data, width, height, 3 * width, QImage.Format.Format_RGB888)
    return QPixmap.fromImage(image)
