"""The settings screen: six tabs. No decisions."""

from collections.abc import Callable

from PySide6.QtWidgets import QLabel, QTabWidget, QTextBrowser, QVBoxLayout, QWidget

from adibas import __version__
from adibas.resources import resource_path
from adibas.sensors.doctor import Finding
from adibas.sessions.roles import Permission
from adibas.texts import spoken_language
from adibas.texts import translate as _
from ui.preferences import Preferences
from ui.settings.audit_page import AuditPage
from ui.settings.computer_page import ComputerPage
from ui.settings.general_page import GeneralPage
from ui.settings.marks_tab import MarksTab
from ui.settings.presenter import SettingsPresenter
from ui.settings.protection_tab import ProtectionTab
from ui.settings.servers_page import ServersPage
from ui.settings.tab_pages import ScrolledParts
from ui.widgets.for_roles import only_for
from ui.widgets.screen import Screen

AUDIT_TAB, PROTOCOLS_TAB = 2, 4


class SettingsScreen(Screen):
    """General, protection with backups, audit, this computer, protocols with names, about.

    Attributes
    ----------
    protected, marks : QWidget
        Tabs of several pages, each with a presenter.
    audit, servers : QWidget
        Pages with a presenter.
    """

    name = "settings"

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title = QLabel(self)
        self._title.setProperty("kind", "title")
        self._general, self.servers = GeneralPage(self), ServersPage(self)
        general = ScrolledParts(self)
        general.add(self._general, self.servers)
        self.protected, self.marks = ProtectionTab(self), MarksTab(self)
        self.audit, self._computer = AuditPage(self), ComputerPage(self)
        self._about = QTextBrowser(self)
        self._about.setOpenLinks(False)
        self._tabs = QTabWidget(self)
        pages = (general, self.protected, self.audit, self._computer, self.marks, self._about)
        for page in pages:
            self._tabs.addTab(page, "")
        layout = QVBoxLayout(self)
        layout.addWidget(self._title)
        layout.addWidget(self._tabs)
        self.retranslate()

    def bind(self, presenter: SettingsPresenter) -> None:
        """Send changes to the presenter, and own it."""
        self._presenter = presenter
        for page in (self._general, self.protected.protection):
            page.changed.connect(lambda name, value: presenter.change(**{name: value}))
        self.protected.protection.check_asked.connect(presenter.check_store)
        self.protected.protection.passphrase_given.connect(presenter.change_passphrase)
        self.protected.protection.store_chosen.connect(presenter.choose_store)
        self._computer.asked.connect(presenter.examine_computer)
        self._tabs.currentChanged.connect(lambda _index: self._enter_tab())

    def keep_for_roles(self, may: Callable[[Permission], bool]) -> None:
        """Offer to whoever has the store open what they may do."""
        self.protected.keep_for_roles(may)
        for index, permission in (
            (AUDIT_TAB, Permission.READ_LOG),
            (PROTOCOLS_TAB, Permission.CHANGE_PROTOCOLS),
        ):
            self._tabs.setTabEnabled(index, may(permission))
            self._tabs.setTabToolTip(index, "" if may(permission) else only_for(permission))

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
        for page in (self._general, self.servers, self.protected, self.audit, self._computer):
            page.retranslate()
        self.marks.retranslate()
        self._about.setMarkdown(_about_text())
        self._about.setAccessibleName(_("About"))

    def entered(self) -> None:
        self._presenter.enter()
        self.protected.people.entered()
        self.servers.entered()
        if self._tabs.currentWidget() is not self._computer:  # it was looked at when it was chosen
            self._enter_tab()

    def closed(self) -> None:
        self.marks.protocols.stop()
        self._presenter.close()

    def draft(self) -> str:
        return self.marks.protocols.draft()

    def take_back(self, draft: str) -> None:
        self._tabs.setCurrentIndex(PROTOCOLS_TAB)
        self.marks.take_back(draft)

    def unsaved(self) -> tuple[str, ...]:
        """Name the protocol, the server and the person of whom something was typed."""
        return tuple(
            name
            for name, is_unsaved in (
                (_("The protocol that was changed"), bool(self.marks.protocols.changed_text)),
                (_("What was typed of a DICOM server"), self.servers.is_unsaved),
                (_("What was typed of a person"), self.protected.people.is_unsaved),
            )
            if is_unsaved
        )

    def show_preferences(self, preferences: Preferences) -> None:
        self._general.show_preferences(preferences)
        self.protected.protection.show_preferences(preferences)

    def show_person(self, name: str) -> None:
        self._general.show_person(name)

    def show_protection(self, folder: str, *, has_passphrase: bool, is_read_only: bool) -> None:
        self.protected.retention.show_read_only(is_read_only=is_read_only)
        self.protected.protection.show_protection(
            folder, has_passphrase=has_passphrase, is_read_only=is_read_only
        )

    def show_log(self, folder: str) -> None:
        self._computer.show_log(folder)

    def show_findings(self, found: tuple[Finding, ...]) -> None:
        self._computer.show_findings(found)

    def show_check(self, sentences: tuple[str, ...]) -> None:
        self.protected.protection.show_check(sentences)

    def hide_check(self) -> None:
        self.protected.protection.hide_check()

    def clear_passphrases(self) -> None:
        self.protected.protection.clear_passphrases()

    def _enter_tab(self) -> None:
        """Show what is so now on the tab that is seen."""
        page = self._tabs.currentWidget()
        if page is self._computer:
            self._presenter.examine_computer()
        elif isinstance(page, AuditPage | MarksTab | ProtectionTab):
            page.entered()


def _about_text() -> str:
    page = resource_path("about", f"{spoken_language()}.md")
    told = page.read_text(encoding="utf-8") if page.is_file() else ""
    return f"# ADiBAS {__version__}\n\n{told}"
