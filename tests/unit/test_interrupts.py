"""Ctrl-C reaches a command wherever it falls."""

import signal
import sys
import threading
import time

import pytest

from adibas.cli.interrupts import no_interrupt_lost


@pytest.fixture(autouse=True)
def ctrl_c_raises():
    """As in a command: a window that was closed in this process before may have left its own."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


class PressedWhileFreed:
    """Ctrl-C falls into its finalizer, where Python ignores exceptions."""

    def __del__(self):
        signal.raise_signal(signal.SIGINT)


class BrokenFinalizer:
    def __del__(self):
        raise ValueError("of a fault")


def test_ctrl_c_in_a_finalizer_is_not_lost():
    with pytest.raises(KeyboardInterrupt), no_interrupt_lost():
        freed = PressedWhileFreed()
        del freed
        time.sleep(10)


def test_it_wakes_a_command_that_waits_for_a_thread():
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt), no_interrupt_lost():
        freed = PressedWhileFreed()
        del freed
        threading.Event().wait(10)
    assert time.monotonic() - begin < 5


def test_other_faults_of_finalizers_are_told_as_before(monkeypatch):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", told.append)
    with no_interrupt_lost():
        freed = BrokenFinalizer()
        del freed
    assert [one.exc_type for one in told] == [ValueError]
    assert sys.unraisablehook == told.append
