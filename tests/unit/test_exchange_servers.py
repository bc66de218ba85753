"""The list of DICOM servers: what was named is found again, and nothing else is a server."""

import json
from dataclasses import replace

import pytest
from pydicom import Dataset
from pydicom.dataset import FileMetaDataset
from pydicom.uid import (
    EncapsulatedPDFStorage,
    ExplicitVRLittleEndian,
    SecondaryCaptureImageStorage,
)
from pynetdicom import AE, evt

from adibas.cli import main
from adibas.data.patients import Identity
from adibas.errors import ExchangeError
from adibas.exchange import servers
from adibas.exchange.dicom_network import send
from adibas.exchange.identifiers import stable_uid
from adibas.exchange.orders import Order, check_same_patient
from adibas.exchange.servers import DicomServer, find_server, read_servers, write_servers
from tests.unit.loopback import free_port
from tests.unit.store_samples import IDENTITY, NAME

PACS = DicomServer("pacs.clinic", 11112, "PACS", "ADIBAS2", is_encrypted=True)
ORDER = Order("A-1", "", "HC-004711", "Ñandú^Ximena", "20140327", "F", "R-1", "Posture", "")


@pytest.fixture
def file(tmp_path, monkeypatch):
    path = tmp_path / "data" / "servers.json"
    monkeypatch.setattr(servers, "servers_file", lambda: path)
    return path


def named(*options):
    return main(["export", "server", *options])


def test_what_is_written_is_read(file):
    assert read_servers(file) == {}
    write_servers(file, {"pacs": PACS, "ris": replace(PACS, title="RIS")})
    assert find_server(file, "pacs") == PACS
    with pytest.raises(ExchangeError, match="no DICOM server called other"):
        find_server(file, "other")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"servers": [1]}',
        '{"servers": {"a": {"host": "x"}}}',
        '{"servers": {"a": {"host": "x", "port": "1", "title": "T"}}}',
        '{"servers": {"a": {"host": "x", "port": 1, "title": "much too long a title"}}}',
        '{"servers": {"a": {"host": "x", "port": 70000, "title": "T"}}}',
        "\udcff",
    ],
)
def test_a_damaged_list_is_one_sentence(file, text):
    file.parent.mkdir()
    file.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(ExchangeError, match="no list of DICOM servers"):
        read_servers(file)


def test_servers_are_named_listed_and_forgotten(file, capsys):
    assert named() == 0
    assert "No DICOM server" in capsys.readouterr().out
    options = ["--host", "pacs.clinic", "--port", "104", "--title", "PACS"]
    assert named("pacs", *options, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["servers"]["pacs"]["own_title"] == "ADIBAS"
    assert read_servers(file)["pacs"].is_open_to_listeners
    assert named("pacs", "--remove") == 0
    assert read_servers(file) == {}
    assert named("pacs", "--remove") == 1
    assert named("pacs", "--test") == 1


@pytest.mark.parametrize(
    "options",
    [
        ["--host", "pacs"],
        ["--host", "pacs", "--port", "104"],
        ["--host", "pacs", "--port", "70000", "--title", "PACS"],
        ["--host", "pacs", "--port", "104", "--title", "SEVENTEEN LETTERS"],
        ["--host", "pacs", "--port", "104", "--title", "PACS", "--own-title", "Ñ"],
        ["--host", " ", "--port", "104", "--title", "PACS"],
        ["--port", "104", "--title", "PACS"],
    ],
)
def test_a_server_that_cannot_be_is_refused(file, capsys, options):
    assert named("pacs", *options) == 1
    assert "--port from 1 to 65535" in capsys.readouterr().err
    assert not file.exists()


def test_only_loopback_and_encryption_keep_listeners_off():
    assert not PACS.is_open_to_listeners
    assert replace(PACS, is_encrypted=False).is_open_to_listeners
    assert not replace(PACS, host="127.0.0.1", is_encrypted=False).is_open_to_listeners


def test_an_order_is_of_the_same_patient_as_far_as_both_tell():
    check_same_patient(ORDER, IDENTITY)
    check_same_patient(ORDER, Identity(NAME))
    check_same_patient(replace(ORDER, patient_id="", birth_date=""), IDENTITY)
    for field in ("patient_id", "birth_date"):
        with pytest.raises(ExchangeError, match="another patient") as caught:
            check_same_patient(replace(ORDER, **{field: "20010101"}), IDENTITY)
        assert "2014" not in str(caught.value)
        assert "HC-" not in str(caught.value)
    assert "Ximena" not in repr(ORDER)


@pytest.mark.parametrize(
    ("taken", "told"),
    [
        ([0x0000, 0x0000], None),
        ([0xB000, 0x0000], None),
        ([0xA700, 0x0000], "0xA700"),
        ([None, 0x0000], "does not answer"),
        ([0x0000], "does not keep files such as report"),
    ],
)
def test_a_server_that_does_not_take_a_file_is_told(taken, told):
    """A server on loopback that answers as it is told, and ends the connection at None."""
    answers = list(taken)

    def store(event):
        status = answers.pop(0)
        if status is None:
            event.assoc.abort()
            return 0x0000
        return status

    entity = AE("PACS")
    entity.add_supported_context(SecondaryCaptureImageStorage)
    if len(taken) > 1:
        entity.add_supported_context(EncapsulatedPDFStorage)
    port = free_port()
    handlers = [(evt.EVT_C_STORE, store)]
    listening = entity.start_server(("127.0.0.1", port), block=False, evt_handlers=handlers)
    files = {
        "picture-01": empty_file(SecondaryCaptureImageStorage),
        "report": empty_file(EncapsulatedPDFStorage),
    }
    steps = []
    try:
        server = DicomServer("127.0.0.1", port, "PACS")
        if told is None:
            send(server, "pacs", files, lambda done, total: steps.append((done, total)))
            assert steps == [(1, 2), (2, 2)]
        else:
            with pytest.raises(ExchangeError, match=told):
                send(server, "pacs", files)
    finally:
        listening.shutdown()


def empty_file(kind):
    dataset = Dataset()
    dataset.SOPClassUID = kind
    dataset.SOPInstanceUID = stable_uid("test", kind)
    dataset.file_meta = FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    return dataset


def test_a_day_is_a_day(capsys):
    with pytest.raises(SystemExit):
        main(["export", "worklist", "pacs", "--date", "tomorrow"])
    assert "2026-03-27" in capsys.readouterr().err
