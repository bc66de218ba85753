"""Buttons that a role may not press: seen, disabled, and with the reason as their tooltip."""

from collections.abc import Callable, Iterable

from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QWidget

from adibas.sessions.roles import Permission, who_may
from adibas.texts import translate as _


class _ForOthers(QObject):
    """Keeps one widget disabled, whatever its screen says of it."""

    def __init__(self, widget: QWidget, permission: Permission) -> None:
        super().__init__(widget)
        self._permission = permission
        self._keep(widget)
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802  (Qt's name)
        changes = (QEvent.Type.EnabledChange, QEvent.Type.ToolTipChange)
        if event.type() in changes and isinstance(watched, QWidget):
            self._keep(watched)
        return False

    def _keep(self, widget: QWidget) -> None:
        reason = only_for(self._permission)
        if widget.isEnabled():
            widget.setEnabled(False)
        if widget.toolTip() != reason:
            widget.setToolTip(reason)
            widget.setAccessibleDescription(reason)


def only_for(permission: Permission) -> str:
    """Return who may do it, as a reason why somebody else may not."""
    who = who_may(permission)
    return _("Only for {who}.").format(who=_(who))


def keep_for_roles(
    parts: Iterable[tuple[QWidget, Permission]], may: Callable[[Permission], bool]
) -> None:
    """Keep disabled what whoever has the store open may not do, as long as the widgets live."""
    for widget, permission in parts:
        if not may(permission):
            _ForOthers(widget, permission)
