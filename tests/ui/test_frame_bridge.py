"""What worker threads publish arrives in the window's thread: frames the newest, calls all."""

import threading

import pytest

from ui.frame_bridge import CallBridge, NewestBridge

N_PUBLISHED = 1000
PATIENCE_MS = 20_000


def publish_from_a_thread(bridge):
    thread = threading.Thread(target=lambda: [bridge.publish(i) for i in range(N_PUBLISHED)])
    thread.start()
    return thread


@pytest.mark.parametrize("attempt", range(3))
def test_of_a_thousand_frames_the_last_is_shown_always_in_the_window_s_thread(attempt, qtbot):  # noqa: ARG001
    shown = []
    bridge = NewestBridge(lambda thing: shown.append((thing, threading.get_ident())))
    thread = publish_from_a_thread(bridge)
    qtbot.waitUntil(lambda: bool(shown) and shown[-1][0] == N_PUBLISHED - 1, timeout=PATIENCE_MS)
    thread.join()
    assert {ident for _, ident in shown} == {threading.get_ident()}
    numbers = [number for number, _ in shown]
    assert numbers == sorted(set(numbers)), "none twice, none out of order"


def test_a_window_that_is_busy_gets_only_the_newest(qapp):
    shown = []
    bridge = NewestBridge(shown.append)
    publish_from_a_thread(bridge).join()
    qapp.processEvents()
    assert shown == [N_PUBLISHED - 1]


def test_every_call_arrives_in_order(qtbot):
    told = []
    bridge = CallBridge(lambda thing: told.append((thing, threading.get_ident())))
    thread = publish_from_a_thread(bridge)
    qtbot.waitUntil(lambda: len(told) == N_PUBLISHED, timeout=PATIENCE_MS)
    thread.join()
    assert told == [(i, threading.get_ident()) for i in range(N_PUBLISHED)]


def test_showing_may_publish_again(qapp):
    shown = []

    def show(thing):
        shown.append(thing)
        if thing < 3:
            bridge.publish(thing + 1)

    bridge = NewestBridge(show)
    bridge.publish(1)
    for _ in range(4):
        qapp.processEvents()
    assert shown == [1, 2, 3]
