"""One short demo session, made once, that the tests of posture and of bad input share."""

import contextlib
import io
import json
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from adibas.cli import main
from adibas.pipeline import demo as demo_session
from adibas.sessions.lock import StoreLock

N_FRAMES = 3
SECONDS_BETWEEN_LOOKS = 0.05


@dataclass(frozen=True)
class DemoFiles:
    """What `adibas demo --json` left and said."""

    folder: Path
    n_frames: int
    said: dict[str, Any]

    @property
    def recording(self) -> Path:
        return self.folder / "recording.mcap"

    @property
    def colors(self) -> Path:
        return self.folder / "colours.json"

    @property
    def report(self) -> Path:
        return self.folder / "report.xlsx"


def make_demo(folder):
    """Run `adibas demo --json`; return what it prints."""
    said = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(said):
        patch.setattr(demo_session, "N_FRAMES", N_FRAMES)
        assert main(["demo", "--out", str(folder), "--json"]) == 0
    return said.getvalue()


@contextlib.contextmanager
def alone(folder):
    """Wait until no other process is within this block."""
    folder.mkdir(exist_ok=True)
    while not (lock := StoreLock(folder)).is_held:
        lock.release()
        time.sleep(SECONDS_BETWEEN_LOOKS)
    try:
        yield
    finally:
        lock.release()


@pytest.fixture(scope="session")
def demo(tmp_path_factory):
    """The demo's files; where several processes test, the first that wants them makes them."""
    shared = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        shared = shared.parent
    folder, said = shared / "shared-demo", shared / "shared-demo.json"
    with alone(shared / "shared-demo.lock"):
        if not said.exists():
            said.write_text(make_demo(folder), encoding="utf-8")
    return DemoFiles(folder, N_FRAMES, json.loads(said.read_text(encoding="utf-8")))
