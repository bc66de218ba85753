"""A session as DICOM files: pictures, the PDF report, and the numbers."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.errors import FileError
from adibas.exchange.content import Handover
from adibas.files import remove_file, written_whole
from adibas.texts import speaking

if TYPE_CHECKING:
    from pydicom import Dataset

ENDING = ".dcm"
OURS = re.compile(r"(picture-\d+|report|measures)\.dcm")
"""The names of the files of a session."""
N_DOCUMENTS = 2
"""Files beside the pictures: report and measures."""


def dicom_datasets(handover: Handover) -> "dict[str, Dataset]":
    """Return the files of a session by the beginning of their names, which tell of nobody.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks, or the record number does not fit.
    """
    from adibas.exchange.dicom_document import encapsulated_pdf
    from adibas.exchange.dicom_measures import measurement_report
    from adibas.exchange.dicom_pictures import secondary_captures

    with speaking(handover.report.language):
        pictures = secondary_captures(handover)
        made: dict[str, Dataset] = {
            **{f"picture-{number:02d}": picture for number, picture in enumerate(pictures, 1)},
            "report": encapsulated_pdf(handover),
            "measures": measurement_report(handover, pictures),
        }
    return {name: _with_header(dataset) for name, dataset in made.items()}


def dicom_paths(handover: Handover, folder: Path) -> list[Path]:
    """Return where `write_dicom` writes."""
    pictures = [f"picture-{number:02d}" for number in range(1, len(handover.report.captures) + 1)]
    return [folder / f"{name}{ENDING}" for name in (*pictures, "report", "measures")]


def check_unmixed(folder: Path) -> None:
    """See that a folder holds no DICOM files yet, so that sessions never mix.

    Raises
    ------
    FileError
        It does.
    """
    if list(folder.glob(f"*{ENDING}")):
        raise FileError(
            "{folder} holds DICOM files already, and the files of two sessions are not mixed. "
            "Choose another folder, or add --overwrite to replace those of an earlier export.",
            folder=folder.name or str(folder),
        )


def remove_dicom(folder: Path) -> None:
    """Remove all files that an earlier export left in a folder; those of others stay.

    Raises
    ------
    FileError
        One cannot be removed.
    """
    for path in list(folder.glob(f"*{ENDING}")):
        if OURS.fullmatch(path.name):
            remove_file(path)


def write_dicom(handover: Handover, folder: Path) -> list[Path]:
    """Write the files of a session into a folder and return their paths.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks, or the record number does not fit.
    FileError
        The disk is full, or the folder cannot be written.
    """
    return write_datasets(dicom_datasets(handover), folder)


def write_datasets(
    datasets: "Mapping[str, Dataset]", folder: Path, written: Callable[[], None] | None = None
) -> list[Path]:
    """Write `dicom_datasets` into a folder and return their paths; `written` is told of each.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    paths = []
    for name, dataset in datasets.items():
        path = folder / f"{name}{ENDING}"
        with written_whole(path) as unfinished:
            save(dataset, unfinished)
        paths.append(path)
        if written is not None:
            written()
    return paths


def save(dataset: "Dataset", path: Path) -> None:
    """Write one of `dicom_datasets`.

    Raises
    ------
    OSError
        It cannot be written.
    """
    dataset.preamble = bytes(128)
    dataset.save_as(path, enforce_file_format=True)


def _with_header(dataset: "Dataset") -> "Dataset":
    """Say beside the content how it is encoded."""
    from pydicom.dataset import FileMetaDataset
    from pydicom.uid import ExplicitVRLittleEndian

    meta = FileMetaDataset()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    meta.MediaStorageSOPClassUID = dataset.SOPClassUID
    meta.MediaStorageSOPInstanceUID = dataset.SOPInstanceUID
    dataset.file_meta = meta
    return dataset
