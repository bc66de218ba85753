"""Jobs run beside the window's thread, and everything they tell arrives in it, once."""

import threading

import pytest

from adibas.errors import StoreError
from ui.jobs import JobRunner
from ui.ports import CancelledError

PATIENCE_MS = 20_000
PATIENCE_S = PATIENCE_MS / 1000


@pytest.fixture
def problems():
    return []


@pytest.fixture
def runner(qapp, problems):  # noqa: ARG001  (signals need it)
    runner = JobRunner(problems.append)
    yield runner
    runner.close()


@pytest.fixture
def wait(qtbot, runner):
    return lambda: qtbot.waitUntil(lambda: not runner.is_busy, timeout=PATIENCE_MS)


def test_work_runs_in_another_thread_and_its_result_comes_back_into_this_one(runner, wait):
    told = []

    def work(_control):
        return threading.get_ident()

    runner.start("a", work, lambda ident: told.append((ident, threading.get_ident())))
    wait()
    ((worker, window),) = told
    assert window == threading.get_ident() != worker


def test_progress_is_told_in_order_and_the_end_last(runner, wait):
    seen, may_go_on = [], threading.Semaphore(0)

    def note(job, *numbers):
        seen.append((job.is_running, *numbers))
        may_go_on.release()

    runner.changed.subscribe(note)

    def work(control):
        may_go_on.acquire(timeout=PATIENCE_S)  # told that it starts
        for i in range(3):
            may_go_on.acquire(timeout=PATIENCE_S)
            control.progress(i, 3)

    runner.start("a", work, lambda _: None)
    wait()
    assert seen == [(True, 0, 0)] * 2 + [(True, i, 3) for i in range(3)] + [(False, 0, 0)]


def test_a_window_that_looks_late_is_told_the_last_of_a_thousand_steps_alone(runner, wait):
    seen, has_stepped = [], threading.Event()
    runner.changed.subscribe(lambda job, *numbers: seen.append((job.is_running, *numbers)))

    def work(control):
        for i in range(1000):
            control.progress(i, 1000)
        has_stepped.set()

    runner.start("a", work, lambda _: None)
    assert has_stepped.wait(PATIENCE_S)  # the window's thread has seen nothing so far
    wait()
    assert seen == [(True, 0, 0), (True, 999, 1000), (False, 0, 0)]


def test_an_error_goes_to_who_asked_or_to_the_window(runner, wait, problems):
    error, told = StoreError("no"), []

    def work(_control):
        raise error

    runner.start("a", work, told.append, told.append)
    wait()
    runner.start("b", work, told.append)
    wait()
    assert told == [error]
    assert problems == [error]


@pytest.mark.parametrize("how", ["done", "failed", "cancelled", "bug"])
def test_the_end_is_told_whatever_came_of_it(how, runner, wait, monkeypatch):
    told, bugs = [], []
    monkeypatch.setattr("sys.excepthook", lambda _kind, bug, _trace: bugs.append(str(bug)))
    is_cancelled = threading.Event()

    def work(control):
        if how == "failed":
            raise StoreError("no")
        if how == "bug":
            raise KeyError("gone")
        while how == "cancelled":
            is_cancelled.wait(0.005)
            control.progress(1, 2)

    job = runner.start(
        "a",
        work,
        lambda _: told.append("done"),
        lambda _: told.append("failed"),
        ended=lambda: told.append(("ended", job.is_running)),
    )
    if how == "cancelled":
        job.cancel()
    wait()
    assert told[0] == ("ended", False), "who is told may start anew"
    assert told[1:] == ([how] if how in ("done", "failed") else [])
    assert bugs == (["'gone'"] if how == "bug" else [])


def test_what_was_cancelled_before_it_began_never_runs(runner, wait):
    gate, ran = threading.Event(), []
    for _ in range(2):
        runner.start("busy", lambda _control: gate.wait(20), lambda _: None)
    job = runner.start("late", lambda _control: ran.append(1), lambda _: ran.append(2))
    job.cancel()
    gate.set()
    wait()
    assert ran == []
    assert job.is_cancelled


def test_a_result_that_comes_after_the_cancelling_is_not_told(runner, wait):
    began, go_on, told = threading.Event(), threading.Event(), []

    def work(_control):
        began.set()
        go_on.wait(20)
        return 1

    job = runner.start("a", work, told.append)
    assert began.wait(20)
    job.cancel()
    go_on.set()
    wait()
    assert told == []


@pytest.mark.parametrize("what", ["done", "failed"])
@pytest.mark.parametrize("stop", ["tells", "never"])
def test_what_cannot_be_undone_is_told_although_it_was_stopped(runner, wait, stop, what):
    began, go_on, told = threading.Event(), threading.Event(), []

    def work(control):
        began.set()
        go_on.wait(PATIENCE_S)
        try:
            control.progress(1, 2)
        except CancelledError:
            told.append("asked to stop")
        if what == "failed":
            raise StoreError("no")

    done, failed = (lambda _value, name=name: told.append(name) for name in ("done", "failed"))
    job = runner.start("a", work, done, failed, stop=stop)
    assert began.wait(PATIENCE_S)
    job.cancel()
    go_on.set()
    wait()
    assert told == (["asked to stop", what] if stop == "tells" else [what])


def test_closing_cancels_and_waits_and_tells_nothing(qapp, problems):
    runner, told, began = JobRunner(problems.append), [], threading.Event()

    def work(control):
        began.set()
        while True:
            control.progress(0, 0)

    runner.start("a", work, told.append, told.append, lambda: told.append("ended"))
    assert began.wait(20)
    assert runner.labels == ("a",)
    runner.close()
    qapp.processEvents()
    assert told == []
    assert not runner.is_busy


def test_the_work_of_a_cancelled_job_sees_it_at_its_next_progress(runner, wait):
    seen, began = [], threading.Event()

    def work(control):
        began.set()
        try:
            while True:
                control.progress(0, 0)
        except CancelledError:
            seen.append("cleaned up")
            raise

    job = runner.start("a", work, lambda _: None)
    assert began.wait(20)
    job.cancel()
    wait()
    assert seen == ["cleaned up"]
