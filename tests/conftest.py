"""What all tests share: fixed property-test examples, and the real recordings of others."""

import gc
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

import adibas  # noqa: F401  (it says how many threads numpy has, which most tests import before)

os.environ["LANGUAGE"] = "en"  # whatever this machine speaks; read when adibas is imported
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # Begun in the background of a shell: programs that the tests start would ignore Ctrl-C, too.
    signal.signal(signal.SIGINT, signal.default_int_handler)
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Note which lines run in unit tests alone: it costs a fifth of the time of Python's code."""
    for item in items:
        if "unit" not in item.path.parts:
            item.add_marker(pytest.mark.no_cover)


def pytest_collection_finish() -> None:
    """Keep what is there before the first test out of every search for garbage and lost timers.

    It is half a million objects of libraries, which stay to the end.
    """
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def nobodys_data(tmp_path_factory) -> None:
    """Keep what the user of this machine has, such as calibrations, out of the tests."""
    os.environ["XDG_DATA_HOME"] = str(tmp_path_factory.mktemp("data-home"))


@pytest.fixture
def three_hours_behind_utc(monkeypatch) -> Iterator[None]:
    """Let this computer's clock be that of São Paulo."""
    if not hasattr(time, "tzset"):
        pytest.skip("this system takes no time zone from the environment")
    with monkeypatch.context() as here:
        here.setenv("TZ", "BRT3")
        time.tzset()
        yield
    time.tzset()


@pytest.fixture(scope="session")
def real_data() -> Path:
    """Folder with the real recordings of others; they are no part of the project."""
    folder = os.environ.get("ADIBAS_REAL_DATA")
    if folder is None and os.environ.get("ADIBAS_REQUIRE_REAL_DATA") == "1":
        pytest.fail("ADIBAS_REQUIRE_REAL_DATA is set, but ADIBAS_REAL_DATA is not")
    if folder is None:
        pytest.skip("ADIBAS_REAL_DATA is unset: no real recordings on this machine")
    path = Path(folder)
    assert path.is_dir(), f"ADIBAS_REAL_DATA names no folder: {path}"
    return path
