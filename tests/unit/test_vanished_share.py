"""A network share that is gone: everything that is asked of it says so in a sentence.

The errors are those of Linux for a share whose server or connection is gone. The real thing, a
file system whose server is killed, is in `tests/end_to_end/test_faults.py`.
"""

import builtins
import errno
import io
import os
from pathlib import Path

import pytest

from adibas.calibration.files import read_calibration, write_calibration
from adibas.data.frames import SourceInfo
from adibas.errors import AdibasError
from adibas.files import is_there
from adibas.measures.protocol_file import load_protocol
from adibas.pipeline.calibration_pictures import PictureFolder
from adibas.pipeline.disk_forecast import free_bytes
from adibas.recordings import RecordingOptions, create_recording, open_recording
from adibas.recordings.codings import read_codings
from adibas.sessions import open_store
from adibas.sessions.backup_format import BackupReader
from adibas.sessions.restoring import restore_into
from adibas.sessions.sealed_files import SealedFiles
from tests.unit.recorded_frames import CALIBRATION
from tests.unit.store_samples import CHEAP, PASSPHRASE

ERRORS = (errno.ENOTCONN, errno.ESTALE, errno.EIO, errno.EHOSTDOWN, errno.ETIMEDOUT)
CALLS = ("stat", "lstat", "open", "mkdir", "listdir", "scandir", "unlink", "rename", "replace")


@pytest.fixture(params=ERRORS, ids=[errno.errorcode[one] for one in ERRORS])
def share(request, tmp_path, monkeypatch):
    """A folder that was there a moment ago."""
    folder = tmp_path / "share"
    folder.mkdir()

    def gone_on_share(call):
        def called(path, *more, **named):
            if isinstance(path, (str, os.PathLike)) and str(path).startswith(str(folder)):
                raise OSError(request.param, os.strerror(request.param), str(path))
            return call(path, *more, **named)

        return called

    for name in CALLS:
        monkeypatch.setattr(os, name, gone_on_share(getattr(os, name)))
    monkeypatch.setattr(builtins, "open", gone_on_share(open))
    monkeypatch.setattr(io, "open", gone_on_share(io.open))
    return folder


def recorded(name):
    def record(share):
        with create_recording(share / name, SourceInfo(), RecordingOptions()):
            pass

    return record


ASKED = {
    "is there": lambda share: is_there(share / "a"),
    "recording mcap": lambda share: open_recording(share / "a.mcap"),
    "recording oni": lambda share: open_recording(share / "a.oni"),
    "recording tum": lambda share: open_recording(share / "a"),
    "record mcap": recorded("a.mcap"),
    "record oni": recorded("a.oni"),
    "record tum": recorded("a"),
    "calibration": lambda share: read_calibration(share / "a.json"),
    "write calibration": lambda share: write_calibration(share / "a.json", CALIBRATION),
    "codings": lambda share: read_codings(share / "a.boris"),
    "protocol": lambda share: load_protocol(share / "a.json"),
    "pictures of a calibration": lambda share: PictureFolder(share / "a").read(),
    "free": lambda share: free_bytes(share / "a"),
    "store": lambda share: open_store(share / "a", PASSPHRASE, key_params=CHEAP),
    "backup": lambda share: BackupReader(share / "a.backup"),
    "restore": lambda share: restore_into(share / "a.backup", share / "b", PASSPHRASE),
    "sealed file": lambda share: SealedFiles(share).write("ab" * 16, bytes(32), b"content"),
    "read a sealed file": lambda share: SealedFiles(share).read("ab" * 16, bytes(32)),
}


@pytest.mark.parametrize("ask", ASKED.values(), ids=ASKED)
def test_what_a_vanished_share_is_asked_for_is_refused_in_a_sentence(share, ask):
    with pytest.raises(AdibasError) as told:
        ask(share)
    assert str(told.value).endswith(".")
    assert str(share) not in str(told.value)


def test_the_other_disk_is_still_there(share, tmp_path):
    assert share.name == "share"
    (tmp_path / "beside").write_bytes(b"1")
    assert is_there(tmp_path / "beside")
    assert not is_there(Path(tmp_path / "nothing"))
