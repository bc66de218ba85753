"""Against Debian's real Orthanc on loopback: what is sent arrives, what is ordered is found."""

import io
import json
from dataclasses import replace

import pydicom
import pytest
from highdicom.sr import srread

from adibas.cli import main
from adibas.errors import ExchangeError
from adibas.exchange import dicom_pictures, servers
from adibas.exchange.dicom_network import orders, verify
from adibas.exchange.servers import DicomServer
from adibas.reports import pdf
from tests.unit import orthanc_server
from tests.unit.exchange_samples import add_clinic_session, secrets_in
from tests.unit.loopback import free_port, make_certificate
from tests.unit.orthanc_server import TITLE, add_order
from tests.unit.store_samples import PASSPHRASE, open_sample

pytestmark = pytest.mark.skipif(orthanc_server.PROGRAM is None, reason=orthanc_server.MISSING)


@pytest.fixture(scope="module")
def running(tmp_path_factory):
    """A server with its folder."""
    folder = tmp_path_factory.mktemp("orthanc")
    server, process = orthanc_server.start(folder)
    add_order(folder, "A-1")
    add_order(folder, "A-2", day="20261122", name="Other^One", PatientID="HC-9")
    yield server, folder
    process.terminate()
    process.wait(30)


@pytest.fixture
def orthanc(running):
    return running[0]


@pytest.fixture
def server(orthanc):
    return DicomServer("127.0.0.1", orthanc.dicom_port, TITLE)


@pytest.fixture
def clinic(tmp_path, monkeypatch, orthanc):
    """A store with one session, and the server named `pacs`."""
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    monkeypatch.setattr(servers, "servers_file", lambda: tmp_path / "servers.json")
    monkeypatch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)
    monkeypatch.setattr(dicom_pictures, "HEIGHT_PX", 200)
    with open_sample(tmp_path / "store") as store:
        session = add_clinic_session(store)
    command = ["export", "server", "pacs", "--host", "127.0.0.1", "--title", TITLE]
    assert main([*command, "--port", str(orthanc.dicom_port), "--test"]) == 0
    return tmp_path / "store", session


def sent(clinic, *options):
    folder, session = clinic
    command = ["export", "send", session.session_id, "--store", str(folder), "--to", "pacs"]
    return main([*command, "--pictures", "as-is", *options])


def kept(orthanc, uid):
    """Return a file as the server gives it back."""
    (found,) = [
        one
        for one in orthanc.ask("/instances")
        if orthanc.ask(f"/instances/{one}/simplified-tags")["SOPInstanceUID"] == uid
    ]
    return orthanc.ask(f"/instances/{found}/file")


def test_what_is_sent_arrives_whole_and_without_a_name(clinic, orthanc, capsys):
    capsys.readouterr()
    assert sent(clinic, "--json") == 0
    captured = capsys.readouterr()
    uids = json.loads(captured.out)["sop_instance_uids"]
    assert len(uids) == 4
    assert not secrets_in((captured.out + captured.err).encode())
    files = [kept(orthanc, uid) for uid in uids]
    for content in files:
        assert not secrets_in(content)
    read = [pydicom.dcmread(io.BytesIO(content)) for content in files]
    _folder, session = clinic
    assert {one.PatientID for one in read} == {session.patient}
    assert read[0].pixel_array.shape[0] == 200
    assert read[2].EncapsulatedDocument.startswith(b"%PDF")
    groups = srread(io.BytesIO(files[3])).content.get_image_measurement_groups()
    assert len(groups[0].get_measurements()) > 3


def test_sending_twice_leaves_it_there_once(clinic, orthanc, capsys):
    assert sent(clinic) == 0
    before = sorted(orthanc.ask("/instances"))
    assert sent(clinic) == 0
    assert sorted(orthanc.ask("/instances")) == before
    assert "4 files" in capsys.readouterr().out
    with open_sample(clinic[0]) as store:
        kinds = [one.detail["kind"] for one in store.audit.entries() if one.action == "export"]
    assert kinds == ["dicom server", "dicom server"]


@pytest.mark.usefixtures("clinic")
def test_a_work_list_tells_orders_and_names_only_when_asked(capsys):
    capsys.readouterr()
    assert main(["export", "worklist", "pacs", "--json"]) == 0
    told = capsys.readouterr().out
    assert [one["accession_number"] for one in json.loads(told)["orders"]] == ["A-1", "A-2"]
    assert not secrets_in(told.encode())
    assert main(["export", "worklist", "pacs", "--date", "2026-11-21", "--names"]) == 0
    told = capsys.readouterr().out
    assert told.split("  ") == ["20261121090000", "A-1", "Posture", "Ñandú^Ximena\n"]
    assert main(["export", "worklist", "pacs", "--date", "2026-01-01"]) == 0
    assert "Nothing is ordered" in capsys.readouterr().out


def test_files_that_answer_an_order_belong_to_its_study_and_patient(clinic, orthanc, capsys):
    capsys.readouterr()
    assert sent(clinic, "--order", "A-1", "--work-list", "pacs", "--json") == 0
    uids = json.loads(capsys.readouterr().out)["sop_instance_uids"]
    for uid in uids:
        one = pydicom.dcmread(io.BytesIO(kept(orthanc, uid)))
        assert one.AccessionNumber == "A-1"
        assert one.PatientID == "HC-004711"
        assert str(one.PatientName) == "Ñandú^Ximena"
        assert one.StudyInstanceUID == orthanc_server.stable_uid("test order", "A-1")
    assert one.ReferencedRequestSequence[0].RequestedProcedureID == "R-A-1"
    with open_sample(clinic[0]) as store:
        (entry,) = [one for one in store.audit.entries() if one.action == "export"]
    assert entry.detail["kind"] == "dicom server, with identity"


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--order", "A-2", "--work-list", "pacs"], "another patient"),
        (["--order", "A-9", "--work-list", "pacs"], "has 0 orders A-9"),
        (["--order", "A-1"], "--work-list"),
        (["--order", "A-1", "--work-list", "ris"], "no DICOM server called ris"),
    ],
)
def test_an_order_that_does_not_fit_sends_nothing(clinic, orthanc, capsys, options, told):
    before = orthanc.ask("/statistics")["CountInstances"]
    assert sent(clinic, *options) == 1
    captured = capsys.readouterr().err
    assert told in captured
    assert not secrets_in(captured.encode())
    assert orthanc.ask("/statistics")["CountInstances"] == before


def test_a_server_that_refuses_or_is_not_there_is_one_sentence(server):
    verify(server, "pacs")
    with pytest.raises(ExchangeError, match="refuses the connection"):
        verify(DicomServer(server.host, server.port, "WRONG"), "pacs")
    with pytest.raises(ExchangeError, match="does not answer"):
        verify(DicomServer(server.host, free_port(), TITLE), "pacs")
    with pytest.raises(ExchangeError, match="does not answer"):
        verify(DicomServer(server.host, server.port, TITLE, is_encrypted=True), "pacs")


def test_a_client_that_the_server_does_not_know_gets_no_work_list(server):
    stranger = DicomServer(server.host, server.port, TITLE, own_title="STRANGER")
    with pytest.raises(ExchangeError):
        orders(stranger, "pacs")


def test_an_encrypted_server_must_prove_who_it_is(tmp_path):
    certificate = tmp_path / "certificate.pem"
    make_certificate("127.0.0.1", tmp_path / "key.pem", certificate)
    settings = {
        "DicomTlsEnabled": True,
        "DicomTlsCertificate": str(certificate),
        "DicomTlsPrivateKey": str(tmp_path / "key.pem"),
        "DicomTlsTrustedCertificates": str(certificate),
        "DicomTlsRemoteCertificateRequired": False,
    }
    running, process = orthanc_server.start(tmp_path / "orthanc", **settings)
    try:
        encrypted = DicomServer("127.0.0.1", running.dicom_port, TITLE, is_encrypted=True)
        with pytest.raises(ExchangeError, match="cannot prove who it is"):
            verify(encrypted, "pacs")
        verify(replace(encrypted, certificates=str(certificate)), "pacs")
        with pytest.raises(ExchangeError, match="certificates for pacs cannot be read"):
            verify(replace(encrypted, certificates=str(tmp_path / "gone")), "pacs")
    finally:
        process.terminate()
        process.wait(30)
