"""One short demo session, made once, that the tests of posture and of bad input share."""

import contextlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from adibas.cli import main
from adibas.pipeline import demo as demo_session

N_FRAMES = 3


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


@pytest.fixture(scope="session")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    said = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(said):
        patch.setattr(demo_session, "N_FRAMES", N_FRAMES)
        assert main(["demo", "--out", str(folder), "--json"]) == 0
    return DemoFiles(folder, N_FRAMES, json.loads(said.getvalue()))
