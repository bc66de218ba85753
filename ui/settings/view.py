"""The settings screen: six pages, one of them with a page behind it. No decisions."""

from collections.abc import Callable

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import (
    QLabel,
    QScrollArea,
    QStackedWidget,
    QTabWidget,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from adibas import __version__
from adibas.resources import resource_path
from adibas.sensors.doctor import Finding
from adibas.sessions.roles import Permission
from adibas.texts import spoken_language
from adibas.texts import translate as _
from ui.preferences import Preferences
from ui.settings.audit_page import AuditPage
from ui.settings.audit_presenter import AuditPresenter
from ui.settings.backup_page import BackupPage
from ui.settings.backup_presenter import BackupPresenter
from ui.settings.computer_page import ComputerPage
from ui.settings.general_page import GeneralPage
from ui.settings.names_page import NamesPage
from ui.settings.names_presenter import NamesPresenter
from ui.settings.people_page import PeoplePage
from ui.settings.people_presenter import PeoplePresenter
from ui.settings.presenter import SettingsPresenter
from ui.settings.protection_page import ProtectionPage
from ui.settings.protocols_page import ProtocolsPage
from ui.settings.protocols_presenter import ProtocolsPresenter
from ui.settings.retention_page import RetentionPage
from ui.settings.retention_presenter import RetentionPresenter
from ui.settings.servers_page import ServersPage
from ui.settings.servers_presenter import ServersPresenter
from ui.widgets.for_roles import keep_for_roles, only_for
from ui.widgets.screen import Screen

PROTECTION_TAB, AUDIT_TAB, COMPUTER_TAB, PROTOCOLS_TAB = 1, 2, 3, 4


class SettingsScreen(Screen):
    """General, protection with backups, audit, this computer, protocols with names, about."""

    name = "settings"

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title = QLabel(self)
        self._title.setProperty("kind", "title")
        self._tabs = QTabWidget(self)
        self._general, self._protection = GeneralPage(self), ProtectionPage(self)
        self._audit, self._computer = AuditPage(self), ComputerPage(self)
        self._protocols, self._names = ProtocolsPage(self), NamesPage(self)
        self._backup, self._retention = BackupPage(self), RetentionPage(self)
        self._about = QTextBrowser(self)
        self._about.setOpenLinks(False)
        self._people, self._kept = PeoplePage(self), QLabel(self)
        self._kept.setWordWrap(True)
        self._kept.setContentsMargins(9, 4, 9, 4)
        self._kept.setProperty("kind", "quiet")
        self._kept.hide()
        parts = (self._kept, self._protection, self._people, self._backup, self._retention)
        protection = _below_each_other(*parts)
        self._servers = ServersPage(self)
        general = _below_each_other(self._general, self._servers)
        for page in (_scrolled(general), _scrolled(protection)):
            self._tabs.addTab(page, "")
        self._marks = QStackedWidget(self)
        self._marks.addWidget(self._protocols)
        self._marks.addWidget(self._names)
        for whole_page in (self._audit, self._computer, self._marks, self._about):
            self._tabs.addTab(whole_page, "")
        layout = QVBoxLayout(self)
        layout.addWidget(self._title)
        layout.addWidget(self._tabs)
        self.retranslate()

    @property
    def audit(self) -> AuditPage:
        """The page of the audit log."""
        return self._audit

    @property
    def protocols(self) -> ProtocolsPage:
        """The page of protocols."""
        return self._protocols

    @property
    def names(self) -> NamesPage:
        """The page of names for markers."""
        return self._names

    @property
    def backup(self) -> BackupPage:
        """The page of backups."""
        return self._backup

    @property
    def retention(self) -> RetentionPage:
        """The page of how long patients are kept."""
        return self._retention

    @property
    def servers(self) -> ServersPage:
        """The page of DICOM servers."""
        return self._servers

    def bind_servers(self, presenter: ServersPresenter) -> None:
        """Send what is wanted of servers to the presenter, and own it."""
        self._servers_presenter = presenter
        self._servers.chosen.connect(presenter.choose)
        self._servers.saved.connect(presenter.save)
        self._servers.tested.connect(presenter.test)
        self._servers.removed.connect(presenter.remove)

    @property
    def people(self) -> PeoplePage:
        """The page of who may open the store."""
        return self._people

    def bind_people(self, presenter: PeoplePresenter) -> None:
        """Send what is wanted of people to the presenter, and own it."""
        self._people_presenter = presenter
        self._people.chosen.connect(presenter.choose)
        self._people.saved.connect(presenter.save)
        self._people.removed.connect(presenter.remove)

    def keep_for_roles(self, may: Callable[[Permission], bool]) -> None:
        """Offer to whoever has the store open what they may do."""
        parts = ((self._backup, Permission.BACK_UP), (self._retention, Permission.RETAIN))
        keep_for_roles(parts, may)
        for index, permission in (
            (AUDIT_TAB, Permission.READ_LOG),
            (PROTOCOLS_TAB, Permission.CHANGE_PROTOCOLS),
        ):
            self._tabs.setTabEnabled(index, may(permission))
            self._tabs.setTabToolTip(index, "" if may(permission) else only_for(permission))
        self._kept.setVisible(not may(Permission.BACK_UP))

    def bind_retention(self, presenter: RetentionPresenter) -> None:
        """Send what is wanted of retention to the presenter, and own it."""
        self._retention_presenter = presenter
        self._retention.changed.connect(lambda name, value: presenter.change(**{name: value}))
        self._retention.looked.connect(presenter.look)
        self._retention.removed.connect(presenter.remove)

    def bind_backup(self, presenter: BackupPresenter) -> None:
        """Send what is wanted of backups to the presenter, and own it."""
        self._backup_presenter = presenter
        self._backup.changed.connect(lambda name, value: presenter.change(**{name: value}))
        self._backup.made.connect(presenter.back_up)
        self._backup.checked.connect(presenter.check)
        self._backup.restored.connect(presenter.restore)

    def bind(
        self,
        presenter: SettingsPresenter,
        audit: AuditPresenter,
        protocols: ProtocolsPresenter,
        names: NamesPresenter,
    ) -> None:
        """Send changes to the presenters, and own them."""
        self._presenter, self._audit_presenter = presenter, audit
        self._protocols_presenter, self._names_presenter = protocols, names
        self._protocols.opened.connect(protocols.open)
        self._protocols.begun.connect(protocols.begin)
        self._protocols.typed.connect(protocols.check)
        self._protocols.saved.connect(protocols.save)
        self._protocols.delete_asked.connect(protocols.ask_delete)
        self._protocols.landmark_asked.connect(protocols.ask_landmark)
        self._protocols.measure_asked.connect(protocols.ask_measure)
        self._protocols.names_asked.connect(self._show_names)
        self._names.closed.connect(self._show_protocols)
        self._names.learned.connect(names.learn)
        self._names.left.connect(names.go_back)
        self._audit.searched.connect(audit.search)
        self._audit.exported.connect(audit.export)
        for page in (self._general, self._protection):
            page.changed.connect(lambda name, value: presenter.change(**{name: value}))
        self._protection.check_asked.connect(presenter.check_store)
        self._protection.passphrase_given.connect(presenter.change_passphrase)
        self._protection.store_chosen.connect(presenter.choose_store)
        self._computer.asked.connect(presenter.examine_computer)
        self._tabs.currentChanged.connect(self._on_tab)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("Settings"))
        titles = (
            _("General"),
            _("Protection"),
            _("Audit log"),
            _("This computer"),
            _("Protocols"),
            _("About"),
        )
        for index, title in enumerate(titles):
            self._tabs.setTabText(index, title)
        for page in (self._general, self._protection, self._audit, self._computer):
            page.retranslate()
        self._protocols.retranslate()
        self._names.retranslate()
        self._people.retranslate()
        self._kept.setText(
            _(
                "Backups, how long patients are kept, the audit log, protocols and who may open "
                "the store are for administrators."
            )
        )
        self._backup.retranslate()
        self._retention.retranslate()
        self._servers.retranslate()
        self._about.setMarkdown(_about_text())
        self._about.setAccessibleName(_("About"))

    def entered(self) -> None:
        self._presenter.enter()
        self._people_presenter.enter()
        self._servers_presenter.enter()
        if self._tabs.currentIndex() == AUDIT_TAB:
            self._audit_presenter.enter()
        elif self._tabs.currentIndex() == PROTOCOLS_TAB:
            self._enter_marks()
        elif self._tabs.currentIndex() == PROTECTION_TAB:
            self._backup_presenter.enter()

    def closed(self) -> None:
        self._protocols.stop()
        self._presenter.close()

    def draft(self) -> str:
        text = self._protocols.changed_text
        return f"{self._protocols_presenter.chosen}\n{text}" if text else ""

    def take_back(self, draft: str) -> None:
        chosen, text = draft.split("\n", 1)
        self._tabs.setCurrentIndex(PROTOCOLS_TAB)
        self._marks.setCurrentWidget(self._protocols)
        self._protocols_presenter.take_back(chosen, text)

    def show_preferences(self, preferences: Preferences) -> None:
        self._general.show_preferences(preferences)
        self._protection.show_preferences(preferences)

    def show_person(self, name: str) -> None:
        self._general.show_person(name)

    def show_protection(self, folder: str, *, has_passphrase: bool, is_read_only: bool) -> None:
        self._retention.show_read_only(is_read_only=is_read_only)
        self._protection.show_protection(
            folder, has_passphrase=has_passphrase, is_read_only=is_read_only
        )

    def show_log(self, folder: str) -> None:
        self._computer.show_log(folder)

    def show_findings(self, found: tuple[Finding, ...]) -> None:
        self._computer.show_findings(found)

    def show_check(self, sentences: tuple[str, ...]) -> None:
        self._protection.show_check(sentences)

    def hide_check(self) -> None:
        self._protection.hide_check()

    def clear_passphrases(self) -> None:
        self._protection.clear_passphrases()

    def _on_tab(self, index: int) -> None:
        if index == COMPUTER_TAB:
            self._presenter.examine_computer()
        elif index == AUDIT_TAB:
            self._audit_presenter.enter()
        elif index == PROTOCOLS_TAB:
            self._enter_marks()
        elif index == PROTECTION_TAB:
            self._backup_presenter.enter()

    def _enter_marks(self) -> None:
        if self._marks.currentWidget() is self._names:
            self._names_presenter.enter()
        else:
            self._protocols_presenter.enter()

    def _show_names(self) -> None:
        self._marks.setCurrentWidget(self._names)
        self._names.setFocus()
        self._enter_marks()

    def _show_protocols(self) -> None:
        self._marks.setCurrentWidget(self._protocols)
        self._protocols.setFocus()
        self._enter_marks()


class _Page(QWidget):
    """As high as it needs at its width; Qt would ask for the height of its narrowest shape."""

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        return QSize(super().minimumSizeHint().width(), 0)


def _below_each_other(*parts: QWidget) -> QWidget:
    """Return one page of several; a seventh tab has no room with large letters."""
    page = _Page()
    column = QVBoxLayout(page)
    column.setContentsMargins(0, 0, 0, 0)
    for part in parts:
        column.addWidget(part)
    column.addStretch()
    return page


def _scrolled(page: QWidget) -> QScrollArea:
    """Let a page be scrolled where large letters need more room than there is."""
    area = QScrollArea()
    area.setWidgetResizable(True)
    area.setWidget(page)
    area.setFrameShape(QScrollArea.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # it follows the fields in it
    for part in (area.viewport(), page):
        part.setAutoFillBackground(False)  # the frame of the tabs shines through
    return area


def _about_text() -> str:
    page = resource_path("about", f"{spoken_language()}.md")
    told = page.read_text(encoding="utf-8") if page.is_file() else ""
    return f"# ADiBAS {__version__}\n\n{told}"
