"""Nothing that leaves under a pseudonym says who it is, in any byte of it, however packed.

That nobody is recognised in pictures is seen in `test_report_pictures.py`.
"""

import base64
import gzip
import io
import json
import zipfile
import zlib
from dataclasses import replace

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from PIL import Image
from PIL.PngImagePlugin import PngInfo
from pydicom import Dataset
from reportlab.pdfgen.canvas import Canvas

from adibas.cli import main
from adibas.errors import RecordingError
from adibas.recordings import create_recording, open_recording
from adibas.recordings.convert import write_all
from adibas.reports import pdf
from benchmarks.fuzz_seeds import recording
from benchmarks.identity_search import found_below, found_in, secrets_of
from tests.ui.review_scene import saved_session
from tests.unit.exchange_samples import add_clinic_session
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import IDENTITY, NAME, open_sample

SECRETS = secrets_of(IDENTITY)
PLAIN = "Rosa Quetzal"
PACKINGS = (
    *("plain", "utf16", "zip", "pdf", "dicom", "nested"),
    *("png", "exif", "zlib", "zstd", "base64"),
)


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    """Draw less, for speed."""
    monkeypatch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)


@pytest.fixture
def session(folder):
    """A session with a recording, two views and notes that name nobody."""
    with open_sample(folder, operator="op") as store:
        session = add_clinic_session(store)
        writer = store.recordings.create(session.session_id, INFO)
        with writer:
            for frame in make_frames(2):
                writer.write(frame)
        return session


@pytest.mark.parametrize(
    "words",
    [
        ("export", "fhir", "--out", "out/a.json", "--pictures", "as-is"),
        ("export", "dicom", "--out", "out", "--pictures", "as-is"),
        ("export", "fhir", "--out", "out/a.json", "--pictures", "as-is", "--language", "ca"),
    ],
    ids=["fhir", "dicom", "catalan"],
)
def test_nothing_that_is_handed_over_says_who_it_is(folder, session, tmp_path, words, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    action, kind, *options = words
    assert main([action, kind, session.session_id, "--store", str(folder), *options]) == 0
    assert any((tmp_path / "out").iterdir())
    assert found_below(tmp_path / "out", SECRETS) == {}


def test_reports_and_recordings_of_a_session_bear_the_pseudonym_alone(folder, session, tmp_path):
    with open_sample(folder) as store:
        store.sessions.change(session.session_id, notes="asked about the back")
    out = tmp_path / "out"
    command = ["sessions", "export", session.session_id, "--store", str(folder), "--out", str(out)]
    assert main(command) == 0
    assert {path.suffix for path in out.iterdir()} == {".mcap", ".xlsx", ".pdf", ".json"}
    assert found_below(out, SECRETS) == {}
    assert found_below(out, [session.patient]) != {}


def test_a_name_in_the_notes_stays_here_where_the_pictures_hide_who_it_is(folder, tmp_path, capsys):
    with open_sample(folder) as store:
        _patient, session, _captures = saved_session(store)  # with depth, to be shown
        store.sessions.change(session.session_id, notes=f"{NAME} came with her mother")
    command = ["sessions", "export", session.session_id, "--store", str(folder)]
    hidden = ["--pictures", "depth", "--out"]
    assert main([*command, *hidden, str(tmp_path / "hidden")]) == 0
    assert found_below(tmp_path / "hidden", SECRETS) == {}
    assert "notes on the session are left out" in capsys.readouterr().out
    assert main([*command, "--with-notes", *hidden, str(tmp_path / "told")]) == 0
    assert {"report.pdf", "report.xlsx", "posture.json"} <= found_below(
        tmp_path / "told", [NAME]
    ).keys()


@pytest.mark.parametrize("pictures", ["depth", "blurred"])
def test_a_recording_that_leaves_where_the_face_is_hidden_holds_the_depth_alone(
    folder, session, tmp_path, monkeypatch, pictures
):
    monkeypatch.setattr("adibas.cli.sessions._export_reports", lambda *_: ())
    command = ["sessions", "export", session.session_id, "--store", str(folder)]
    assert main([*command, "--pictures", pictures, "--out", str(tmp_path)]) == 0
    whole = make_frames(2)
    assert all(frame.color is not None for frame in whole)
    with (tmp_path / "recording-01.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    counts = summary.statistics.channel_message_counts
    topics = {summary.channels[number].topic for number, n_messages in counts.items() if n_messages}
    assert "/depth" in topics
    assert not topics & {"/color", "/infrared"}
    with open_recording(tmp_path / "recording-01.mcap") as reader:
        for frame, was in zip(reader, whole, strict=True):
            assert (frame.depth_raw == was.depth_raw).all()
            assert frame.timestamp_ns == was.timestamp_ns
            assert frame.color is None
            assert frame.infrared_raw is None
    with open_sample(folder) as store:
        lines = [one for one in store.audit.entries() if one.action == "export"]
        assert [one.detail["pictures"] for one in lines if "pictures" in one.detail] == ["depth"]


def test_a_recording_without_depth_does_not_leave_where_the_face_is_hidden(tmp_path):
    colored = [replace(one, depth_raw=None, infrared_raw=None) for one in make_frames(2)]
    with create_recording(tmp_path / "a.mcap", INFO) as writer:
        for frame in colored:
            writer.write(frame)
    with (
        open_recording(tmp_path / "a.mcap") as reader,
        pytest.raises(RecordingError, match="there is no depth"),
    ):
        write_all(reader, tmp_path / "b.mcap", depth_only=True)
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"]


def test_the_store_itself_shows_nobody(folder, session):
    assert session.patient
    assert found_below(folder, [*SECRETS, session.patient]) == {}


def test_what_was_asked_for_is_found_by_the_same_search(folder, session, tmp_path):
    words = ("--pictures", "as-is", "--with-identity")
    for kind, out in (("fhir", tmp_path / "a.json"), ("dicom", tmp_path / "dicom")):
        command = ["export", kind, session.session_id, "--store", str(folder), "--out", str(out)]
        assert main([*command, *words]) == 0
    assert {NAME, "HC-004711"} <= found_below(tmp_path, SECRETS)["a.json"]
    assert "HC-004711" in found_below(tmp_path / "dicom", SECRETS)["report.dcm"]


def zipped(text):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/sheet.xml", f"<v>{text}</v>" * 9)
    return file.getvalue()


def picture(text, kind):
    image, file = Image.new("RGB", (8, 8)), io.BytesIO()
    if kind == "PNG":
        told = PngInfo()
        told.add_text("Author", text, zip=True)
        image.save(file, kind, pnginfo=told)
    else:
        exif = image.getexif()
        exif[0x9C9D] = text.encode("utf-16-le")  # the author, as Windows writes it
        image.save(file, kind, exif=exif)
    return file.getvalue()


def pdf_with(text):
    file = io.BytesIO()
    canvas = Canvas(file, pageCompression=1)
    canvas.drawString(100, 100, text)
    canvas.save()
    return file.getvalue()


def dicom_with(text):
    dataset, file = Dataset(), io.BytesIO()
    dataset.PatientName = text
    dataset.save_as(file, implicit_vr=False, little_endian=True)
    return file.getvalue()


def workbook_with_pdf(text):
    """A PDF within base64 within JSON within an archive."""
    return zipped(json.dumps({"data": base64.b64encode(pdf_with(text)).decode()}))


@pytest.mark.parametrize(
    "pack",
    [
        str.encode,
        lambda text: text.upper().encode("utf-16-be"),
        zipped,
        pdf_with,
        dicom_with,
        workbook_with_pdf,
        lambda text: picture(text, "PNG"),
        lambda text: picture(text, "JPEG"),
        lambda text: b"x" * 99 + zlib.compress(text.encode()),
        lambda text: b"x" * 99 + zstandard.compress(text.encode()),
        lambda text: b'{"x": "' + base64.b64encode(b"-" * 50 + text.encode()) + b'"}',
    ],
    ids=PACKINGS,
)  # fmt: skip
def test_the_search_finds_what_is_packed(pack):
    assert found_in(pack(PLAIN), [PLAIN, "Somebody"]) == {PLAIN}


def test_the_search_finds_accents_as_json_writes_them():
    assert NAME in found_in(json.dumps({"name": NAME}).encode(), SECRETS)


def test_the_search_finds_a_name_in_the_header_of_a_recording_and_of_a_file(tmp_path):
    recording(tmp_path / "a.mcap", "jpeg")
    assert found_below(tmp_path, ["Quetzal"]) == {}
    info = INFO.__class__(sensor_name="of Quetzal")
    with create_recording(tmp_path / "b.mcap", info) as writer:
        writer.write(make_frames(1)[0])
    (tmp_path / "Quetzal.txt").write_bytes(np.zeros(4).tobytes())
    assert found_below(tmp_path, ["Quetzal"]).keys() == {"b.mcap", "Quetzal.txt"}


def test_birth_dates_are_searched_as_people_write_them():
    for text in ("2014-03-27", "20140327", "27/03/2014", "3/27/2014", "27.03.2014"):
        assert found_in(b"born " + text.encode(), SECRETS) == {text}
    assert found_in(gzip.compress(b"2014-03-28"), SECRETS) == set()
