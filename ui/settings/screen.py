"""Builds the settings screen: the one place where its view, its presenter and the core meet."""

from functools import partial

from PySide6.QtWidgets import QWidget

from ui.recovery.dialog import open_recovery_key
from ui.settings.audit_presenter import AuditPresenter
from ui.settings.backup_presenter import BackupPresenter
from ui.settings.names_presenter import NamesPresenter
from ui.settings.people_presenter import PeoplePresenter
from ui.settings.presenter import SettingsPresenter
from ui.settings.protocols_presenter import ProtocolsPresenter
from ui.settings.recovery_presenter import RecoveryPresenter
from ui.settings.retention_presenter import RetentionPresenter
from ui.settings.servers_presenter import ServersPresenter
from ui.settings.view import SettingsScreen
from ui.workspace import Workspace


def build_settings_screen(workspace: Workspace, parent: QWidget | None = None) -> SettingsScreen:
    """Return the settings screen, wired to `workspace`."""
    view = SettingsScreen(parent)
    view.bind(SettingsPresenter(view, workspace))
    view.audit.bind(AuditPresenter(view.audit, workspace))
    view.servers.bind(ServersPresenter(view.servers, workspace))
    protected, marks = view.protected, view.marks
    protected.people.bind(PeoplePresenter(protected.people, workspace))
    show_new = partial(open_recovery_key, workspace, protected.recovery)
    protected.recovery.bind(RecoveryPresenter(protected.recovery, workspace, show_new))
    protected.backup.bind(BackupPresenter(protected.backup, workspace))
    protected.retention.bind(RetentionPresenter(protected.retention, workspace))
    marks.protocols.bind(ProtocolsPresenter(marks.protocols, workspace))
    marks.names.bind(NamesPresenter(marks.names, workspace))
    view.keep_for_roles(workspace.store.may)
    return view
