"""The program asks no network for anything, and leaves nothing of anybody outside the store.

A whole session in the window is searched by `adibas benchmark reliability privacy`.
"""

import json
import logging
import os
import subprocess
import sys
from datetime import date

import pytest

from benchmarks.cli_jobs import jobs, jobs_of_session
from benchmarks.identity_search import found_below
from benchmarks.private_home import can_be_alone, run_alone
from ui.log import start_log

needs_namespace = pytest.mark.skipif(
    not can_be_alone(), reason="user namespaces are not allowed here, so that no network can go"
)
CURIOUS = """
import socket
from contextlib import suppress
from pathlib import Path
import tempfile
with suppress(OSError):
    socket.create_connection(("192.0.2.1", 80), timeout=1)
with suppress(OSError):
    socket.getaddrinfo("example.org", 80)
path = Path(tempfile.mkdtemp()) / "draft"
path.write_text("Rosa Ibarra, 1971")
path.unlink()
with suppress(OSError):
    socket.socket(socket.AF_UNIX).connect("/nowhere")
"""


@needs_namespace
def test_the_main_jobs_ask_no_network_and_leave_no_temporary_file(tmp_path):
    work = tmp_path / "work"
    watched = run_alone(tmp_path, ["benchmarks.cli_jobs", str(work)], ["Rosa"])
    assert watched.attempts == ()
    assert watched.removed == ()
    codes = json.loads((work / "codes.json").read_text())
    assert codes == dict.fromkeys([*jobs(work), *jobs_of_session(work, "")], 0)
    assert [path.name for path in (tmp_path / "tmp").rglob("*") if path.is_file()] == []


@needs_namespace
def test_the_window_asks_no_network(tmp_path):
    (tmp_path / "work").mkdir()
    words = ["benchmarks.startup_probe", "passphrase", str(tmp_path / "work")]
    assert run_alone(tmp_path, words, ["Rosa"]).attempts == ()


@needs_namespace
def test_a_curious_program_is_noticed(tmp_path, monkeypatch):
    (tmp_path / "curious.py").write_text(CURIOUS)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{':'.join(path for path in sys.path if path)}")
    watched = run_alone(tmp_path, ["curious"], ["Rosa Ibarra"])
    told = "\n".join(watched.attempts)
    assert "socket.connect" in told
    assert "192.0.2.1" in told
    assert "example.org" in told
    assert "nowhere" not in told
    assert [line.split("/")[-1] for line in watched.removed] == ["draft"]


SAVES = """
import sys
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QFileDialog
from ui.application import note_no_folders
note_no_folders()
app = QApplication([])
def save():
    dialog = app.activeModalWidget()
    dialog.selectFile(sys.argv[1])
    dialog.accept()
QTimer.singleShot(500, save)
told, _kind = QFileDialog.getSaveFileName(
    None, "", sys.argv[1], options=QFileDialog.Option.DontUseNativeDialog
)
sys.exit(told != sys.argv[1])
"""


def test_no_folder_that_a_dialog_visited_is_written_down(tmp_path):
    home, folder = tmp_path / "home", tmp_path / "Rosa Ibarra"
    folder.mkdir()
    for name in (".config", ".cache", ".local"):
        (home / name).mkdir(parents=True)
    clean = {name: value for name, value in os.environ.items() if not name.startswith("XDG_")}
    clean |= {"HOME": str(home), "QT_QPA_PLATFORM": "offscreen"}
    code = [sys.executable, "-c", SAVES, str(folder / "report.xlsx")]
    subprocess.run(code, env=clean, check=True, timeout=60)
    assert found_below(home, ["Rosa", "Ibarra"]) == {}


def test_a_crash_and_a_log_do_not_tell_what_was_typed(tmp_path):
    end = start_log(tmp_path)
    try:
        try:
            date.fromisoformat("Rosa Ibarra was born on 1971-03-04")
        except ValueError:
            logging.getLogger("ui.test").exception("a bug")
    finally:
        end()
    assert any(path.stat().st_size for path in tmp_path.iterdir())
    assert found_below(tmp_path, ["Rosa", "Ibarra", "1971-03-04"]) == {}
