"""Debian's real Orthanc, on loopback alone and for one test module, with a work list."""

import json
import os
import shutil
import subprocess
import time
import urllib.request
from dataclasses import dataclass
from pathlib import Path

from pydicom import Dataset
from pydicom.dataset import FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian

from adibas.exchange.identifiers import stable_uid
from tests.unit.loopback import free_port

PROGRAM = shutil.which("Orthanc") or shutil.which("Orthanc", path="/usr/sbin")
PLUGINS = Path("/usr/share/orthanc/plugins")
WORK_LISTS = PLUGINS / "libModalityWorklists.so"
MISSING = "Orthanc is missing: apt-get install orthanc"
TITLE = "ORTHANC"
STARTS_WITHIN_S = 60.0


@dataclass(frozen=True)
class Orthanc:
    """A running server."""

    dicom_port: int
    http_port: int

    def ask(self, path):
        """Return what it says over HTTP: parsed, or the bytes of a file."""
        url = f"http://127.0.0.1:{self.http_port}{path}"
        with urllib.request.urlopen(url, timeout=10) as answer:
            content = answer.read()
        return content if path.endswith("/file") else json.loads(content)


def start(folder, **settings):
    """Start it in a folder of its own; returns the server and its process."""
    server = Orthanc(free_port(), free_port())
    work_lists = folder / "worklists"
    work_lists.mkdir(parents=True)
    configuration = {
        "Name": "test",
        "StorageDirectory": str(folder / "storage"),
        "IndexDirectory": str(folder / "index"),
        "Plugins": [str(WORK_LISTS)],
        "Worklists": {"Enable": True, "Database": str(work_lists)},
        "HttpPort": server.http_port,
        "RemoteAccessAllowed": False,
        "AuthenticationEnabled": False,
        "DicomPort": server.dicom_port,
        "DicomAet": TITLE,
        "DicomCheckCalledAet": True,
        "DicomCheckModalityHost": True,
        "DicomModalities": {
            "adibas": {"AET": "ADIBAS", "Host": "127.0.0.1", "Port": 4, "AllowFindWorklist": True}
        },
        **settings,
    }
    path = folder / "orthanc.json"
    path.write_text(json.dumps(configuration))
    log = (folder / "orthanc.log").open("wb")
    process = subprocess.Popen(
        [PROGRAM, str(path)], stdout=log, stderr=log, cwd=folder, env={**os.environ, "LANG": "C"}
    )
    log.close()
    _wait(server, process, folder / "orthanc.log")
    return server, process


def _wait(server, process, log):
    until = time.monotonic() + STARTS_WITHIN_S
    while time.monotonic() < until and process.poll() is None:
        try:
            server.ask("/system")
        except OSError:
            time.sleep(0.1)
        else:
            return
    process.kill()
    process.wait()
    raise AssertionError(log.read_text(errors="replace"))


def add_order(folder, number, *, day="20261121", name="Ñandú^Ximena", **fields):
    """Put an order into the work list, as a clinic's records do."""
    step = Dataset()
    step.ScheduledStationAETitle = "ADIBAS"
    step.ScheduledProcedureStepStartDate = day
    step.ScheduledProcedureStepStartTime = "090000"
    step.Modality = "XC"
    step.ScheduledProcedureStepDescription = "Four views"
    order = Dataset()
    order.SpecificCharacterSet = "ISO_IR 100"
    order.AccessionNumber = number
    order.PatientName = name
    order.PatientID = "HC-004711"
    order.PatientBirthDate = "20140327"
    order.PatientSex = "F"
    order.StudyInstanceUID = stable_uid("test order", number)
    order.RequestedProcedureID = f"R-{number}"
    order.RequestedProcedureDescription = "Posture"
    order.ScheduledProcedureStepSequence = [step]
    for field, value in fields.items():
        setattr(order, field, value)
    meta = FileMetaDataset()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.31"
    meta.MediaStorageSOPInstanceUID = stable_uid("test list", number)
    order.file_meta = meta
    order.preamble = bytes(128)
    order.save_as(folder / "worklists" / f"{number}.wl", enforce_file_format=True)
    return order
