"""DICOM: files that others read, with the numbers of the report, and nobody's name."""

import io
import shutil
import subprocess
from dataclasses import replace

import highdicom
import numpy as np
import pydicom
import pytest
from highdicom.sr import srread
from pypdf import PdfReader

from adibas.cli import main
from adibas.data.patients import Identity, Patient
from adibas.data.report import PictureChoice
from adibas.errors import ReportError
from adibas.exchange import dicom_pictures
from adibas.exchange.content import capture_results, hand_over
from adibas.exchange.dicom_common import line
from adibas.exchange.dicom_files import dicom_datasets, write_dicom
from adibas.exchange.orders import Order
from adibas.pipeline.stored_report import ReportWish, stored_report
from adibas.reports import pdf
from tests.unit.exchange_samples import add_clinic_session, hostile, secrets_in
from tests.unit.store_samples import IDENTITY, NAME, PASSPHRASE, START, open_sample

SESSION = "7649b93c2f594bef8ef1"
ORDER = Order("A-1", "", "HC-004711", "Ñandú^Ximena", "20140327", "F", "R-1", "Posture", "")


@pytest.fixture(autouse=True, scope="module")
def small_pictures():
    """Draw less, for speed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)
        patch.setattr(dicom_pictures, "HEIGHT_PX", 200)
        yield


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Return the report of a session in a store of its own, measured once."""
    with open_sample(tmp_path_factory.mktemp("exchange") / "store") as store:
        session = add_clinic_session(store)
        return stored_report(store, session.session_id, ReportWish("en"))


@pytest.fixture(scope="module")
def written(report, tmp_path_factory):
    """Return the folder of the files under a pseudonym."""
    folder = tmp_path_factory.mktemp("dicom")
    write_dicom(hand_over(SESSION, report), folder)
    return folder


def person(**fields):
    return Patient("P-7F3KQ2", replace(IDENTITY, **fields), "female", "", START)


def read(folder):
    return {path.stem: pydicom.dcmread(path) for path in sorted(folder.iterdir())}


def test_the_files_are_one_study_of_three_series(written):
    files = read(written)
    assert set(files) == {"picture-01", "picture-02", "report", "measures"}
    assert len({one.StudyInstanceUID for one in files.values()}) == 1
    assert len({one.SeriesInstanceUID for one in files.values()}) == 3
    assert len({one.SOPInstanceUID for one in files.values()}) == 4
    assert {one.Modality for one in files.values()} == {"XC", "DOC", "SR"}
    for one in files.values():
        assert one.StudyInstanceUID.startswith("2.25.")
        assert one.StudyInstanceUID.is_valid
        assert one.file_meta.MediaStorageSOPInstanceUID == one.SOPInstanceUID


def test_pictures_show_the_marked_patient_and_where_she_looks(written):
    pictures = read(written)
    for number, orientation in ((1, ["L", "F"]), (2, ["A", "F"])):
        one = pictures[f"picture-{number:02d}"]
        assert one.pixel_array.shape[0] == 200
        assert len(np.unique(one.pixel_array.reshape(-1, 3), axis=0)) > 2, "rings are drawn"
        assert list(one.PatientOrientation) == orientation
        assert one.BurnedInAnnotation == "NO"
        assert one.RecognizableVisualFeatures == "YES"
    assert pictures["picture-01"].ImageComments == "anterior"
    assert pictures["picture-01"].PatientIdentityRemoved == "NO", "the face is in the picture"


def test_a_view_that_was_not_told_has_no_orientation(report):
    analysis = replace(report.captures[0].analysis, view="", measures=None)
    untold = replace(report, captures=(replace(report.captures[0], analysis=analysis),))
    assert not dicom_datasets(hand_over(SESSION, untold))["picture-01"].PatientOrientation


def test_the_pdf_inside_is_the_report(written):
    one = read(written)["report"]
    encoded = one.EncapsulatedDocument[: one.EncapsulatedDocumentLength]
    assert len(one.EncapsulatedDocument) % 2 == 0
    assert "Posture report" in PdfReader(io.BytesIO(encoded)).pages[0].extract_text()
    assert one.MIMETypeOfEncapsulatedDocument == "application/pdf"


def test_the_structured_report_has_every_value_with_unit_and_interval(report, written):
    document = srread(written / "measures.dcm")
    assert isinstance(document, highdicom.sr.ComprehensiveSR)
    groups = document.content.get_image_measurement_groups()
    wanted = capture_results(report)
    assert [group.tracking_identifier for group in groups] == ["anterior-1", "right_lateral-1"]
    pictures = read(written)
    for number, (group, found) in enumerate(zip(groups, wanted, strict=True), 1):
        assert group.method.value == "sapo-1"
        (source,) = group.source_images
        picture = pictures[f"picture-{number:02d}"]
        assert source.referenced_sop_instance_uid == picture.SOPInstanceUID
        known = [one for one in found.results if one.number is not None]
        assert len(group.get_measurements()) == len(known) > 3
        for told, result in zip(group.get_measurements(), known, strict=True):
            assert told.name.value == result.code
            assert told.unit.value == result.unit
            assert told.unit.scheme_designator == "UCUM"
            assert told.value == pytest.approx(result.number.value, abs=1e-4)
            reach = {
                item.name.value: item.value
                for item in told[0].ContentSequence
                if isinstance(item, highdicom.sr.NumContentItem)
            }
            up, down = reach["371886008"], reach["371885007"]
            assert told.value + up == pytest.approx(result.number.high, abs=2e-4)
            assert told.value - down == pytest.approx(result.number.low, abs=2e-4)


def test_nothing_tells_who_it_is_unless_that_was_asked_for(written):
    for path in written.iterdir():
        assert not secrets_in(path.read_bytes())
        one = pydicom.dcmread(path)
        assert one.PatientID == str(one.PatientName).rstrip("^")
        assert one.PatientBirthDate == one.PatientSex == ""
    encoded = pydicom.dcmread(written / "report.dcm").EncapsulatedDocument
    text = "".join(page.extract_text() for page in PdfReader(io.BytesIO(encoded)).pages)
    assert not secrets_in(text.encode())


def test_who_it_is_goes_along_when_asked_for(report):
    for one in dicom_datasets(hand_over(SESSION, report, person())).values():
        assert str(one.PatientName).rstrip("^") == NAME
        assert one.PatientID == "HC-004711"
        assert one.PatientBirthDate == "20140327"
        assert one.PatientSex == "F"
        assert one.PatientIdentityRemoved == "NO"


@pytest.mark.parametrize("number", ["7" * 65, "HC\\4711", "HC^4711"])
def test_a_record_number_that_does_not_fit_is_refused_and_not_cut(report, number):
    handover = hand_over(SESSION, report, person(record_number=number))
    with pytest.raises(ReportError, match="record number") as caught:
        dicom_datasets(handover)
    assert number not in str(caught.value)


def test_a_name_with_marks_of_dicom_stays_one_name(report):
    identity = Identity("Ana\\Eva^Mª=José\nRuiz")
    patient = replace(person(), identity=identity, sex="")
    one = dicom_datasets(hand_over(SESSION, report, patient))["report"]
    assert str(one.PatientName) == "Ana Eva Mª José Ruiz^"
    assert one.PatientID == "P-7F3KQ2", "without a record number it is the pseudonym"


def test_names_of_any_script_stay_different_codes(report, tmp_path):
    write_dicom(hand_over(SESSION, hostile(report)), tmp_path)
    groups = srread(tmp_path / "measures.dcm").content.get_image_measurement_groups()
    assert [one.tracking_identifier for one in groups] == ["anterior-1", "anterior-2", "view-1"]
    for group in groups:
        codes = [one.name.value for one in group.get_measurements()]
        assert len(set(codes)) == len(codes) == 5
        assert all(code.isascii() for code in codes)


def test_the_same_session_is_the_same_to_the_byte_and_a_corrected_one_is_not(
    report, written, tmp_path
):
    handover = hand_over(SESSION, report)
    write_dicom(handover, tmp_path / "again")
    for path in written.iterdir():
        again = tmp_path / "again" / path.name
        if path.stem == "report":  # it says when it was made
            assert pydicom.dcmread(path).SOPInstanceUID == pydicom.dcmread(again).SOPInstanceUID
        else:
            assert path.read_bytes() == again.read_bytes()
    markers = report.captures[0].analysis.markers
    analysis = replace(report.captures[0].analysis, markers=markers[1:])
    captures = (replace(report.captures[0], analysis=analysis), report.captures[1])
    corrected = dicom_datasets(hand_over(SESSION, replace(report, captures=captures)))
    for name, one in read(written).items():
        assert one.StudyInstanceUID == corrected[name].StudyInstanceUID
        assert one.SeriesInstanceUID == corrected[name].SeriesInstanceUID
        assert one.SOPInstanceUID != corrected[name].SOPInstanceUID


def test_long_texts_are_cut_where_a_reader_counts_bytes():
    cut = line("ángulo craneovertebral: " + "ñ" * 60)
    assert len(cut.encode()) <= 64
    assert cut.endswith("\N{HORIZONTAL ELLIPSIS}")
    assert line("a\\b\n c") == "a b c"


@pytest.mark.skipif(
    shutil.which("dciodvfy") is None, reason="dciodvfy is missing: apt-get install dicom3tools"
)
@pytest.mark.parametrize(
    ("language", "who", "order", "changed"),
    [
        ("en", None, None, hostile),
        ("es", None, None, lambda report: report),
        ("ca", person(), None, lambda report: report),
        ("en", None, ORDER, lambda report: report),
    ],
)
def test_a_validator_of_others_finds_no_error(report, tmp_path, language, who, order, changed):
    spoken = replace(changed(report), language=language)
    write_dicom(hand_over(SESSION, spoken, who, order), tmp_path)
    for path in tmp_path.iterdir():
        checked = subprocess.run(
            ["dciodvfy", str(path)], check=False, capture_output=True, text=True
        )
        errors = [told for told in checked.stderr.splitlines() if told.startswith("Error")]
        assert (checked.returncode, errors) == (0, []), path.name


def test_the_command_line_writes_them_and_the_log_tells(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    folder, out = tmp_path / "store", tmp_path / "out"
    with open_sample(folder) as store:
        session = add_clinic_session(store)
    command = ["export", "dicom", session.session_id, "--store", str(folder), "--out", str(out)]
    assert main([*command, "--pictures", "as-is"]) == 0
    captured = capsys.readouterr()
    assert not secrets_in((captured.out + captured.err).encode())
    files = read(out)
    assert len(files) == 4
    assert {one.PatientID for one in files.values()} == {session.patient}
    assert files["report"].StudyID == session.session_id[:16]
    with open_sample(folder) as store:
        (entry,) = [one for one in store.audit.entries() if one.action == "export"]
    assert entry.detail["kind"] == "dicom"
    assert report_pictures(files) == {"YES"}
    assert main([*command, "--pictures", "as-is"]) == 1
    assert "--overwrite" in capsys.readouterr().err
    assert main([*command, "--pictures", "as-is", "--overwrite"]) == 0


def report_pictures(files):
    return {one.RecognizableVisualFeatures for one in files.values() if one.Modality == "XC"}


def test_hidden_heads_are_told(report, monkeypatch):
    monkeypatch.setattr("adibas.reports.pictures.blurred", lambda analysis, _: analysis.picture_rgb)
    blurred = replace(report, pictures=PictureChoice.BLURRED)
    monkeypatch.setattr("adibas.exchange.dicom_document.encoded_pdf", lambda _report: b"%PDF")
    for one in dicom_datasets(hand_over(SESSION, blurred)).values():
        assert one.PatientIdentityRemoved == "YES"
        assert "hidden" in one.DeidentificationMethod
