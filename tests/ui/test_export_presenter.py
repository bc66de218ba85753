"""What leaves the clinic and how, decided without Qt, over a real store."""

import json
from dataclasses import replace
from unittest.mock import create_autospec

import pydicom
import pytest

from adibas.cli import main
from adibas.data.patients import Consent
from adibas.data.report import PictureChoice
from adibas.exchange.orders import Order
from adibas.exchange.servers import DicomServer, write_servers
from tests.ui import export_scene
from tests.ui.conftest import PASSPHRASE
from tests.ui.export_scene import exports
from tests.unit.exchange_samples import secrets_in
from tests.unit.loopback import free_port
from tests.unit.store_samples import NAME, START
from ui.export.presenter import ExportPresenter, ExportView

named_servers, clinic_session = export_scene.named_servers, export_scene.clinic_session
AS_IS = PictureChoice.AS_IS
PACS = DicomServer("pacs.clinic", 104, "PACS")
ORDER = Order(
    *("A-1", "1.2.826.0.1.3680043.2.1", "HC-004711", "Quetzal^Ximena", "20140327", "F"),
    *("R-1", "Posture", "20261121090000"),
)


@pytest.fixture
def view():
    return create_autospec(ExportView, instance=True)


@pytest.fixture
def presenter(view, workspace, clinic_session, named_servers):  # noqa: ARG001  (it is there)
    presenter = ExportPresenter(view, workspace)
    assert presenter.open(clinic_session.session_id)
    return presenter


def shown(view):
    return view.show_choice.call_args.args[0]


def test_at_first_nobody_is_told_and_the_head_is_hidden(presenter, view, clinic_session):
    who, started_utc, n_views = view.show_session.call_args.args
    assert (who, started_utc, n_views) == (NAME, clinic_session.started_utc, 2)
    assert not shown(view).choice.with_identity
    assert shown(view).pictures is PictureChoice.BLURRED
    assert any("pseudonym" in one for one in shown(view).content)
    day = f"{clinic_session.started_utc:%Y-%m-%d}"
    assert presenter.proposed_name == f"{clinic_session.patient}_{day}.json"
    assert not secrets_in(presenter.proposed_name.encode())


def test_the_identity_is_a_tick_of_its_own_and_pictures_follow_it(presenter, view):
    presenter.choose(with_identity=True)
    assert shown(view).pictures is AS_IS
    assert any("Name, birth date" in one for one in shown(view).warnings)
    presenter.choose(with_identity=False)
    assert shown(view).pictures is PictureChoice.BLURRED
    presenter.choose(pictures=PictureChoice.DEPTH)
    presenter.choose(with_identity=True)
    assert shown(view).pictures is PictureChoice.DEPTH


def test_a_face_that_is_seen_under_a_pseudonym_is_told(presenter, view):
    assert not any("face" in one for one in shown(view).warnings)
    presenter.choose(pictures=AS_IS)
    assert any("face" in one for one in shown(view).warnings)


def test_a_patient_whose_consent_stands_no_more_is_told_and_not_refused(
    presenter, view, workspace, clinic_session
):
    assert not any("no consent" in one for one in shown(view).warnings)
    patients = workspace.store.patients
    patients.withdraw_consent(clinic_session.patient, 0)
    assert presenter.open(clinic_session.session_id)
    assert any("no consent" in one for one in shown(view).warnings)
    patients.give_consent(clinic_session.patient, Consent(("treatment",), NAME, False, START))
    assert presenter.open(clinic_session.session_id)
    assert not any("no consent" in one for one in shown(view).warnings)


def test_the_bundle_is_the_one_that_the_command_writes(
    presenter, store, clinic_session, tmp_path, monkeypatch
):
    presenter.choose(pictures=AS_IS)
    presenter.export_to(tmp_path / "window.json")
    assert not secrets_in((tmp_path / "window.json").read_bytes())
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    command = ["export", "fhir", clinic_session.session_id, "--store", str(store.folder)]
    options = ["--pictures", "as-is", "--language", "en", "--out", str(tmp_path / "command.json")]
    assert main([*command, *options]) == 0
    assert without_pdf(tmp_path / "window.json") == without_pdf(tmp_path / "command.json")
    assert exports(store) == ["fhir", "fhir"]


def test_an_export_that_was_done_when_stop_was_pressed_is_told(
    presenter, tmp_path, told, inline_jobs
):
    inline_jobs.is_stopped_late = True
    presenter.choose(pictures=AS_IS)
    presenter.export_to(tmp_path / "window.json")
    assert [kind for kind, _sentence in told] == ["good"]


def test_the_dialog_gives_way_to_a_job_whose_end_is_told(
    presenter, view, workspace, tmp_path, told
):
    presenter.choose(pictures=AS_IS)
    presenter.export_to(tmp_path / "window.json")
    view.close_dialog.assert_called_once_with()
    assert workspace.jobs.labels == ["Exporting the session"]
    assert told == [("good", told[0][1])]
    assert told[0][1].startswith("window.json: ")


def without_pdf(path):
    """Return a bundle without its PDF, which says when it was made."""
    bundle = json.loads(path.read_text("utf-8"))
    for entry in bundle["entry"]:
        for form in entry["resource"].get("presentedForm", ()):
            form.clear()
    return bundle


def test_files_go_into_a_new_folder_each_time(presenter, store, clinic_session, tmp_path, told):
    presenter.choose(kind="dicom", with_identity=True)
    for _time in range(2):
        presenter.export_to(tmp_path / "out")
    folders = sorted((tmp_path / "out").iterdir())
    assert len(folders) == 2
    assert all(folder.name.startswith(clinic_session.patient) for folder in folders)
    files = [sorted(path.name for path in folder.iterdir()) for folder in folders]
    assert files == [["measures.dcm", "picture-01.dcm", "picture-02.dcm", "report.dcm"]] * 2
    assert str(pydicom.dcmread(folders[0] / "report.dcm").PatientName) == f"{NAME}^"
    assert exports(store) == ["dicom, with identity"] * 2
    assert told[-1] == ("good", f"4 files are written into {folders[1].name}.")


def test_a_head_that_cannot_be_hidden_is_told_and_nothing_leaves(
    presenter, store, workspace, tmp_path
):
    presenter.export_to(tmp_path / "out.json")
    assert "No depth was kept" in str(workspace.jobs.problems[0])
    assert not (tmp_path / "out.json").exists()
    assert exports(store) == []


def test_what_is_stopped_writes_nothing(presenter, store, workspace, tmp_path):
    workspace.jobs.is_stopped = True
    presenter.choose(kind="dicom", pictures=AS_IS)
    presenter.export_to(tmp_path / "out")
    assert not (tmp_path / "out").exists()
    assert exports(store) == []


def test_servers_that_are_named_are_offered_and_listeners_told_of(
    view, workspace, clinic_session, named_servers
):
    write_servers(named_servers, {"pacs": PACS, "ris": replace(PACS, is_encrypted=True)})
    presenter = ExportPresenter(view, workspace)
    presenter.open(clinic_session.session_id)
    view.show_servers.assert_called_once_with(("pacs", "ris"))
    assert not any("encrypted" in one for one in shown(view).warnings)
    presenter.choose(kind="server")
    assert any("pacs is not encrypted" in one for one in shown(view).warnings)
    presenter.choose(server="ris")
    assert not any("encrypted" in one for one in shown(view).warnings)


def test_a_server_that_is_not_there_is_told(view, workspace, store, clinic_session, named_servers):
    write_servers(named_servers, {"pacs": DicomServer("127.0.0.1", free_port(), "PACS")})
    presenter = ExportPresenter(view, workspace)
    presenter.open(clinic_session.session_id)
    presenter.choose(kind="server", pictures=AS_IS)
    presenter.send()
    assert "pacs does not answer" in str(workspace.jobs.problems[0])
    assert exports(store) == ["dicom server"]


def test_a_damaged_list_of_servers_leaves_the_files(
    view, workspace, clinic_session, named_servers, told
):
    named_servers.parent.mkdir()
    named_servers.write_text("[]", "utf-8")
    presenter = ExportPresenter(view, workspace)
    assert presenter.open(clinic_session.session_id)
    view.show_servers.assert_called_once_with(())
    assert "no list of DICOM servers" in told[-1][1]


def test_a_session_that_is_gone_asks_nothing(view, workspace, named_servers, told):  # noqa: ARG001
    assert not ExportPresenter(view, workspace).open("nothing")
    assert told[-1][0] == "bad"
    view.show_choice.assert_not_called()


@pytest.mark.usefixtures("presenter")
def test_at_first_it_is_measured_by_what_the_session_says(view):
    (titles,) = view.show_protocols.call_args.args
    assert dict(titles)["upper-quadrant"] == "Upper quadrant"
    assert shown(view).choice.protocol == ""


def test_another_protocol_is_measured_as_the_command_does(
    presenter, store, clinic_session, tmp_path, monkeypatch
):
    presenter.choose(pictures=AS_IS)
    presenter.export_to(tmp_path / "usual.json")
    presenter.choose(protocol="upper-quadrant")
    presenter.export_to(tmp_path / "window.json")
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    command = ["export", "fhir", clinic_session.session_id, "--store", str(store.folder)]
    options = ["--pictures", "as-is", "--language", "en", "--protocol", "upper-quadrant"]
    assert main([*command, *options, "--out", str(tmp_path / "command.json")]) == 0
    assert without_pdf(tmp_path / "window.json") == without_pdf(tmp_path / "command.json")
    assert without_pdf(tmp_path / "window.json") != without_pdf(tmp_path / "usual.json")


def test_a_protocol_that_is_gone_is_told_and_nothing_leaves(presenter, store, tmp_path, told):
    presenter.choose(protocol="removed", pictures=AS_IS)
    presenter.export_to(tmp_path / "out.json")
    assert "removed" in told[-1][1]
    assert not (tmp_path / "out.json").exists()
    assert exports(store) == []


def test_files_answer_an_order_and_carry_its_patient(presenter, view, store, tmp_path):
    presenter.choose(kind="dicom")
    presenter.take_order(ORDER)
    assert shown(view).pictures is AS_IS
    assert any("answer the order A-1" in one for one in shown(view).warnings)
    assert not any("no name" in one for one in shown(view).content)
    presenter.export_to(tmp_path / "out")
    for path in (tmp_path / "out").rglob("*.dcm"):
        dataset = pydicom.dcmread(path)
        assert (dataset.AccessionNumber, dataset.StudyInstanceUID) == ("A-1", ORDER.study_uid)
        assert str(dataset.PatientName) == ORDER.patient_name
    assert exports(store) == ["dicom, with identity"]


def test_a_bundle_answers_no_order_and_tells_nobody(presenter, view, store, tmp_path):
    presenter.choose(kind="dicom")
    presenter.take_order(ORDER)
    presenter.choose(kind="fhir", pictures=AS_IS)
    assert any("pseudonym" in one for one in shown(view).content)
    presenter.export_to(tmp_path / "out.json")
    assert not secrets_in((tmp_path / "out.json").read_bytes())
    assert exports(store) == ["fhir"]


def test_an_order_of_somebody_else_is_told_and_not_taken(presenter, view):
    presenter.choose(kind="dicom")
    presenter.take_order(replace(ORDER, patient_id="HC-1"))
    assert any("of another patient" in one for one in shown(view).warnings)
    assert shown(view).choice.order is None
    presenter.take_order(ORDER)
    assert not any("of another patient" in one for one in shown(view).warnings)
    presenter.choose(order=None)
    assert any("pseudonym" in one for one in shown(view).content)
