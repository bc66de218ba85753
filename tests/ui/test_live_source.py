"""The sensor of the window: orders return at once, and what was left is told no more."""

import threading
import time

import pytest

from adibas.data.board import Board
from adibas.pipeline import acquisition
from adibas.sensors import SensorOptions
from tests.unit.live_rig import UNPLUGGED, DrivenCamera, Sources, frame
from ui.live_source import QtLiveSource

PATIENCE_MS = 30_000
OPTIONS = SensorOptions(color_size=(640, 480))


class SlowCamera(DrivenCamera):
    """A sensor whose reading lasts until the gate opens."""

    def __init__(self, gate):
        super().__init__([frame(1)])
        self._gate = gate

    def read(self, timeout_s=5.0):
        if self.n_asked:
            assert self._gate.wait(30)
            raise UNPLUGGED
        return super().read(timeout_s)


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(acquisition, "RETRY_S", 0.01)


@pytest.fixture
def live_on(qapp):  # noqa: ARG001  (signals need it)
    """Makes a live source on cameras, and ends it."""
    sources, cameras = [], []

    def make(*things):
        cameras.extend(thing for thing in things if isinstance(thing, DrivenCamera))
        opener = Sources(*things)
        live = QtLiveSource(opener=opener)
        live.opener = opener
        sources.append(live)
        return live

    yield make
    for camera in cameras:
        camera.push(*[UNPLUGGED] * 3)
    for live in sources:
        live.end()


def shown_frames(live):
    numbers = []
    live.frame_arrived.subscribe(lambda one: numbers.append(one.sequence))
    return numbers


def test_frames_and_states_arrive_in_the_window_s_thread(live_on, qtbot):
    threads = set()
    live = live_on(DrivenCamera([frame(1)]))
    live.frame_arrived.subscribe(lambda _: threads.add(threading.get_ident()))
    live.state_changed.subscribe(lambda _: threads.add(threading.get_ident()))
    live.open("a", OPTIONS)
    assert live.state.kind == "opening", "from the order on, not from the thread's word"
    qtbot.waitUntil(lambda: live.newest is not None, timeout=PATIENCE_MS)
    qtbot.waitUntil(lambda: live.state.kind == "live", timeout=PATIENCE_MS)
    assert threads == {threading.get_ident()}
    assert live.opened == ("a", OPTIONS)


def test_a_silent_sensor_does_not_block_who_opens_another(live_on, qtbot):
    gate = threading.Event()
    live = live_on(SlowCamera(gate), DrivenCamera([frame(7)]))
    live.open("slow", OPTIONS)
    qtbot.waitUntil(lambda: live.newest is not None, timeout=PATIENCE_MS)
    numbers = shown_frames(live)
    live.open("other", OPTIONS)  # would wait for ever: the gate opens below
    assert live.newest is None
    gate.set()
    qtbot.waitUntil(lambda: numbers == [7], timeout=PATIENCE_MS)
    assert live.state.kind == "live"


def test_of_orders_that_wait_only_the_newest_is_followed(live_on, qtbot):
    gate = threading.Event()
    live = live_on(SlowCamera(gate), DrivenCamera([frame(7)]))
    live.open("slow", OPTIONS)
    qtbot.waitUntil(lambda: live.newest is not None, timeout=PATIENCE_MS)
    for name in ("b", "c", "d"):
        live.open(name, OPTIONS)
    live.close()
    live.open("last", OPTIONS)
    gate.set()
    qtbot.waitUntil(lambda: live.newest is not None, timeout=PATIENCE_MS)
    assert live.opener.opened[0] == "slow"
    assert live.opener.opened[-1] == "last"
    assert not {"c", "d"} & set(live.opener.opened)


def test_what_still_comes_of_a_source_that_was_left_is_not_told(live_on, qtbot, qapp):
    first = DrivenCamera([frame(1)])
    live = live_on(first, DrivenCamera([]))
    live.open("a", OPTIONS)
    qtbot.waitUntil(lambda: live.newest is not None, timeout=PATIENCE_MS)
    numbers, kinds = shown_frames(live), []
    live.state_changed.subscribe(lambda state: kinds.append(state.kind))
    first.push(frame(2))
    deadline_s = time.monotonic() + 30
    while first.n_asked < 3:  # 2 was read, and waits to be told
        assert time.monotonic() < deadline_s
    live.close()
    for _ in range(5):
        qapp.processEvents()
    assert numbers == []
    assert kinds == ["closed"]
    first.push(UNPLUGGED)
    live.end()
    qapp.processEvents()
    assert set(kinds) == {"closed"}
    assert first.is_closed


def test_an_unplugged_sensor_is_told_and_comes_back(live_on, qtbot):
    first, second = DrivenCamera([frame(1)]), DrivenCamera([frame(9)])
    live = live_on(first, second)
    kinds = []
    live.state_changed.subscribe(lambda state: kinds.append(state.kind))
    live.open("a", OPTIONS)
    qtbot.waitUntil(lambda: live.newest is not None, timeout=PATIENCE_MS)
    first.push(UNPLUGGED)
    qtbot.waitUntil(lambda: live.newest.sequence == 9, timeout=PATIENCE_MS)
    assert kinds[:2] == ["opening", "opening"]
    assert kinds[2:] == ["live", "lost", "live"]


def test_a_board_is_looked_for_from_the_first_frame_on(live_on, qtbot):
    board = Board(9, 6, 0.025)
    live = live_on(DrivenCamera([frame(1, (480, 640))]))
    live.set_board(board)
    live.open("sensor", OPTIONS)
    qtbot.waitUntil(lambda: live.newest is not None, timeout=PATIENCE_MS)
    assert live.newest.board.corners is None
    assert live.newest.board.problem is not None
