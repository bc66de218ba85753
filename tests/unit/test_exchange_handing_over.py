"""Every way out of the store: noted first, stopped in time, and nothing told that was not asked."""

import pytest
from pydicom import dcmread

from adibas.data.report import PictureChoice
from adibas.errors import AdibasError, ExchangeError, FileError, StoreError
from adibas.exchange import dicom_pictures
from adibas.exchange.handing_over import (
    HandoverWish,
    export_dicom,
    export_fhir,
    export_to_server,
)
from adibas.exchange.orders import Order
from adibas.exchange.servers import DicomServer
from adibas.reports import pdf
from tests.unit.exchange_samples import add_clinic_session
from tests.unit.loopback import free_port
from tests.unit.store_samples import all_bytes, open_sample

AS_IS = PictureChoice.AS_IS
ORDER = Order("A-1", "", "HC-9", "Other^One", "", "", "R-1", "Posture", "")


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    monkeypatch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)
    monkeypatch.setattr(dicom_pictures, "HEIGHT_PX", 200)


@pytest.fixture
def store(tmp_path):
    with open_sample(tmp_path / "store") as store:
        yield store


@pytest.fixture
def session(store):
    return add_clinic_session(store)


def exports(store):
    """Return what left, newest first."""
    return [one.detail["kind"] for one in store.audit.entries() if one.action == "export"]


def wish(session, **changes):
    return HandoverWish(session.session_id, "en", **{"pictures": AS_IS, **changes})


def test_pictures_hide_the_head_until_somebody_wants_the_identity_or_says_otherwise():
    assert HandoverWish("s", "en").shown is PictureChoice.BLURRED
    assert HandoverWish("s", "en", with_identity=True).shown is AS_IS
    assert HandoverWish("s", "en", order=ORDER).shown is AS_IS
    hidden = HandoverWish("s", "en", with_identity=True, pictures=PictureChoice.DEPTH)
    assert hidden.shown is PictureChoice.DEPTH


def test_what_the_log_does_not_take_does_not_leave(store, session, tmp_path, monkeypatch):
    def full(*_args, **_detail):
        raise StoreError("The disk is full.")

    monkeypatch.setattr(store.audit, "append", full)
    nobody = DicomServer("127.0.0.1", free_port(), "PACS")
    with pytest.raises(StoreError):
        export_fhir(store, wish(session), tmp_path / "out.json")
    with pytest.raises(StoreError):
        export_dicom(store, wish(session), tmp_path / "out")
    with pytest.raises(StoreError):
        export_to_server(store, wish(session), nobody, "pacs")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["store"]


def test_a_window_that_only_reads_may_hand_over_and_leaves_its_line(store, session, tmp_path):
    with open_sample(store.folder) as second:
        assert second.is_read_only
        export_fhir(second, wish(session), tmp_path / "out.json")
    assert exports(store) == ["fhir"]


def test_what_cannot_be_made_is_neither_written_nor_noted(store, session, tmp_path):
    with pytest.raises(AdibasError, match="No depth was kept"):
        export_fhir(store, wish(session, pictures=None), tmp_path / "out.json")
    with pytest.raises(ExchangeError, match="another patient"):
        export_dicom(store, wish(session, order=ORDER), tmp_path / "out")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["store"]
    assert exports(store) == []


def test_each_way_out_is_one_line_that_says_whether_the_person_went_along(store, session, tmp_path):
    export_fhir(store, wish(session), tmp_path / "a.json")
    export_dicom(store, wish(session, with_identity=True), tmp_path / "dicom")
    nobody = DicomServer("127.0.0.1", free_port(), "PACS")
    with pytest.raises(ExchangeError, match="does not answer"):
        export_to_server(store, wish(session), nobody, "pacs")
    assert exports(store) == ["dicom server", "dicom, with identity", "fhir"]


def test_every_step_is_told_and_whoever_stops_before_the_writing_writes_nothing(
    store, session, tmp_path
):
    steps = []
    export_dicom(store, wish(session), tmp_path / "a", lambda *step: steps.append(step))
    assert steps == [(done, 6) for done in range(1, 7)]
    assert len(list((tmp_path / "a").iterdir())) == 4

    def stop(_done, _total):
        raise KeyboardInterrupt

    for export, place in ((export_fhir, tmp_path / "b.json"), (export_dicom, tmp_path / "b")):
        with pytest.raises(KeyboardInterrupt):
            export(store, wish(session), place, stop)
        assert not place.exists()
    assert exports(store) == ["dicom"]


def test_sessions_never_mix_in_one_folder_of_dicom_files(store, session, tmp_path):
    out, other = tmp_path / "out", add_clinic_session(store)
    store.captures.delete(other.capture_ids[1])
    export_dicom(store, wish(session), out)
    before = all_bytes(out)
    with pytest.raises(FileError, match="not mixed"):
        export_dicom(store, wish(other), out)
    assert all_bytes(out) == before
    assert exports(store) == ["dicom"]
    (out / "of-others.dcm").write_bytes(b"")
    written = export_dicom(store, wish(other), out, can_replace=True)
    assert {path.name for path in written} == {"picture-01.dcm", "report.dcm", "measures.dcm"}
    assert set(out.iterdir()) == {*written, out / "of-others.dcm"}
    assert {dcmread(path).PatientID for path in written} == {other.patient}


def test_files_that_are_no_dicom_keep_nobody_out_of_a_folder(store, session, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "read me.txt").write_text("for the archive")
    assert len(export_dicom(store, wish(session), tmp_path / "out")) == 4


def test_a_place_that_cannot_be_is_refused_before_anything_is_noted(store, session, tmp_path):
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(FileError, match="is a folder"):
        export_fhir(store, wish(session), tmp_path / "folder.json")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="no folder"):
        export_dicom(store, wish(session), tmp_path / "file" / "inside")
    assert exports(store) == []
