"""Builds the patients screen: the one place where view, presenters and core meet."""

from functools import partial

from PySide6.QtWidgets import QWidget

from ui.patients.form_presenter import FormPresenter
from ui.patients.history_presenter import HistoryPresenter
from ui.patients.presenter import PatientsPresenter
from ui.patients.undo import Undo
from ui.patients.view import PatientsScreen
from ui.widgets.for_roles import keep_for_roles
from ui.workspace import Workspace


def build_patients_screen(workspace: Workspace, parent: QWidget | None = None) -> PatientsScreen:
    """Return the patients screen, wired to `workspace`."""
    view = PatientsScreen(parent)
    undo = Undo(view.list, workspace)
    patients = PatientsPresenter((view.list, view.pages), workspace, undo)
    history = HistoryPresenter(view.pages.history, workspace, undo)

    def show_held() -> None:
        _show_held(workspace, view, patients, form)

    form = FormPresenter(view.pages, workspace, patients.refresh, withdrawn=show_held)
    view.pages.consents.holdings_asked.connect(show_held)
    view.bind((patients, history, form), undo)
    view.pages.form.work_list_asked.connect(partial(_take_over, workspace, view, form))
    keep_for_roles(view.pages.patient.for_roles(), workspace.store.may)
    keep_for_roles(view.pages.history.for_roles(), workspace.store.may)
    view.pages.history.export_asked.connect(partial(_export, workspace, view))
    return view


def _show_held(
    workspace: Workspace, view: PatientsScreen, patients: PatientsPresenter, form: FormPresenter
) -> None:
    """List what is held of the patient; what is done from there is done on this screen."""
    from ui.patients.holdings_dialog import open_holdings
    from ui.patients.holdings_presenter import Actions

    def hide() -> None:
        form.cancel()
        patients.delete()

    def ask_removal() -> None:
        form.cancel()
        patients.ask_removal()

    open_holdings(workspace, view, Actions(hide, ask_removal))


def _export(workspace: Workspace, view: PatientsScreen, session_id: str) -> None:
    """Ask how a session is handed over; what that needs is read when somebody asks."""
    from ui.export.dialog import open_export

    open_export(workspace, view, session_id)


def _take_over(workspace: Workspace, view: PatientsScreen, form: FormPresenter) -> None:
    """Ask which order a new patient is taken from."""
    from ui.orders.dialog import open_orders

    open_orders(workspace, view, form.take_over)
