"""The tab of protection: the keys, the people, backups, and how long patients are kept."""

from collections.abc import Callable

from PySide6.QtWidgets import QLabel, QWidget

from adibas.sessions.roles import Permission
from adibas.texts import translate as _
from ui.settings.backup_page import BackupPage
from ui.settings.people_page import PeoplePage
from ui.settings.protection_page import ProtectionPage
from ui.settings.recovery_page import RecoveryPage
from ui.settings.retention_page import RetentionPage
from ui.settings.tab_pages import ScrolledParts
from ui.widgets.for_roles import keep_for_roles


class ProtectionTab(ScrolledParts):
    """Five pages below each other; above them, whom some of them are for.

    Attributes
    ----------
    protection, recovery, people, backup, retention : QWidget
        The pages.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._kept = QLabel(self)
        self._kept.setWordWrap(True)
        self._kept.setContentsMargins(9, 4, 9, 4)
        self._kept.setProperty("kind", "quiet")
        self._kept.hide()
        self.protection, self.people = ProtectionPage(self), PeoplePage(self)
        self.backup, self.retention = BackupPage(self), RetentionPage(self)
        self.recovery = RecoveryPage(self)
        self._pages = (self.protection, self.recovery, self.people, self.backup, self.retention)
        self.add(self._kept, *self._pages)

    def keep_for_roles(self, may: Callable[[Permission], bool]) -> None:
        """Offer to whoever has the store open what they may do."""
        parts = (
            (self.recovery.make, Permission.PROTECT),
            (self.backup, Permission.BACK_UP),
            (self.retention, Permission.RETAIN),
        )
        keep_for_roles(parts, may)
        self._kept.setVisible(not may(Permission.BACK_UP))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._kept.setText(
            _(
                "Backups, how long patients are kept, the audit log, protocols and who may open "
                "the store are for administrators."
            )
        )
        for page in self._pages:
            page.retranslate()

    def entered(self) -> None:
        """Show what is so now."""
        self.recovery.entered()
        self.backup.entered()
