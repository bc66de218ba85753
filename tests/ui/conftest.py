"""What the tests of the window share. They run without a display, and leave nothing behind."""

import gc
import os
import threading
from collections.abc import Iterator

import pytest

os.environ["QT_QPA_PLATFORM"] = "offscreen"  # read when the QApplication is made

import shiboken6
from keyring.backends import fail
from PySide6.QtCore import QCoreApplication, QEvent, QLocale, QTimer

from adibas.errors import AdibasError
from adibas.pipeline.live import SensorState
from adibas.sensors.permanent_threads import THREAD_NAME
from adibas.sessions import SessionStore, open_store
from adibas.sessions.key_wrapping import Argon2Params
from tests.unit.store_samples import use_keyring
from ui.events import Event
from ui.ports import CancelledError
from ui.preferences import PreferencesFile
from ui.theme import Theme
from ui.workspace import Workspace

PASSPHRASE = "four words are enough"
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)
SECONDS_FOR_THREADS = 5.0


def running_timers() -> set[QTimer]:
    """Return the timers of Python code that still tick."""
    timers = (thing for thing in gc.get_objects() if issubclass(type(thing), QTimer))
    return {timer for timer in timers if shiboken6.isValid(timer) and timer.isActive()}


@pytest.fixture(autouse=True)
def nothing_left_behind(qapp) -> Iterator[None]:
    """Fail when a test leaves a window, a thread or a timer."""
    windows_before = set(qapp.topLevelWidgets())
    threads_before, timers_before = set(threading.enumerate()), running_timers()
    yield
    qapp.processEvents()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    threads = {one for one in threading.enumerate() if one.name != THREAD_NAME} - threads_before
    for thread in threads:
        thread.join(SECONDS_FOR_THREADS)
    windows = [w for w in qapp.topLevelWidgets() if w not in windows_before and w.isVisible()]
    assert not windows, f"windows left open: {windows}"
    assert not [thread for thread in threads if thread.is_alive()], f"threads left: {threads}"
    timers = running_timers() - timers_before
    assert not timers, f"timers left: {[(timer, timer.parent()) for timer in timers]}"


@pytest.fixture(autouse=True)
def english_numbers_and_dates() -> Iterator[None]:
    """Write them as in English, whatever language this machine or another test's window has."""
    QLocale.setDefault(QLocale("en"))
    yield
    QLocale.setDefault(QLocale("en"))


@pytest.fixture(autouse=True)
def no_keyring(monkeypatch) -> None:
    """Let stores ask for a passphrase, whatever keyring this machine or another test's class has.

    The library takes every class of a keyring that was ever imported for one of the desktop's.
    """
    use_keyring(monkeypatch, fail.Keyring())


@pytest.fixture
def store(tmp_path) -> Iterator[SessionStore]:
    """An empty store behind `PASSPHRASE`; guessing it would be cheap."""
    opened = open_store(tmp_path / "store", PASSPHRASE, operator="tester", key_params=CHEAP)
    with opened:
        yield opened


@pytest.fixture
def read_only_store(store) -> Iterator[SessionStore]:
    """The same store as a second window sees it."""
    with open_store(store.folder, PASSPHRASE, operator="second") as second:
        yield second


class InlineJobs:
    """Does the work of a job at once, in the thread of the test."""

    def __init__(self) -> None:
        self.labels: list[str] = []
        self.problems: list[AdibasError] = []
        self.is_stopped = False
        self.is_stopped_late = False
        """The user stops each job after its last progress."""

    def start(self, label, work, done, failed=None, ended=None, *, stop="drops"):
        self.labels.append(label)
        job = InlineJob(is_stopped=self.is_stopped and stop != "never")
        ended = ended or (lambda: None)
        try:
            result = work(job)
        except CancelledError:
            ended()
            return job
        except AdibasError as error:
            ended()
            (failed or self.problems.append)(error)
            return job
        ended()
        if not self.is_stopped_late or stop != "drops":
            done(result)
        return job


class InlineJob:
    """A job that is over; its work sees that the user stopped it where `is_stopped`."""

    is_running = False

    def __init__(self, is_stopped: bool) -> None:
        self.is_stopped = is_stopped

    def progress(self, done: int, total: int) -> None:
        assert 0 <= done <= total or total == 0
        if self.is_stopped:
            raise CancelledError

    def cancel(self) -> None:
        self.is_stopped = True


@pytest.fixture
def inline_jobs() -> InlineJobs:
    """Jobs that are done when `start` returns."""
    return InlineJobs()


@pytest.fixture
def preferences(tmp_path) -> PreferencesFile:
    """The usual preferences, in English, in a file of this test."""
    file = PreferencesFile(tmp_path / "preferences.json")
    file.change(language="en")
    return file


class NoSensor:
    """A live source that gives nothing and notes what it was told; for screens without a sensor."""

    def __init__(self) -> None:
        self.frame_arrived = Event()
        self.state_changed = Event()
        self.newest = None
        self.state = SensorState("closed")
        self.view = None
        self.target = None
        self.naming = None
        self.rotation_deg = 0
        self.board = None
        self.orders = []

    @property
    def opened(self):
        return next((order for order in reversed(self.orders) if order), None)

    def open(self, source, options) -> None:
        self.orders.append((source, options))

    def set_target(self, target) -> None:
        self.target = target

    def set_naming(self, naming) -> None:
        self.naming = naming

    def set_rotation(self, rotation_deg) -> None:
        self.rotation_deg = rotation_deg

    def set_board(self, board) -> None:
        self.board = board

    def close(self) -> None:
        self.orders.append(None)

    def end(self) -> None:
        self.close()


@pytest.fixture
def workspace(store, inline_jobs, preferences) -> Workspace:
    """What screens share, over a real store, without a sensor."""
    return Workspace(store, inline_jobs, preferences, NoSensor())


@pytest.fixture
def second_window(read_only_store, inline_jobs, preferences) -> Workspace:
    """What the screens of a second window share, which may only read."""
    return Workspace(read_only_store, inline_jobs, preferences, NoSensor())


@pytest.fixture
def told(workspace) -> list[tuple[str, str]]:
    """What the workspace says from now on: kind and sentence of each notice."""
    notices: list[tuple[str, str]] = []
    workspace.noticed.subscribe(lambda kind, sentence: notices.append((kind, sentence)))
    return notices


@pytest.fixture
def theme(qapp) -> Theme:
    """The light theme."""
    theme = Theme(qapp)
    theme.use("light", 1.0)
    return theme


@pytest.fixture
def large_letters(theme) -> Iterator[None]:
    """Letters of twice the size, until the test is over."""
    theme.use("light", 2.0)
    yield
    theme.use("light", 1.0)
