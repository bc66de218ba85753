"""A camera library that hangs is left alone; one that answers is asked again."""

import threading

import pytest

from adibas.errors import SensorError
from adibas.sensors import openni2_library
from adibas.sensors.answering import TimeLimit
from adibas.sensors.permanent_threads import THREAD_NAME, LentThreads, PermanentThread


@pytest.fixture
def hanging():
    """What a library does that hangs, until it is let go; and the sign that lets it go."""
    let_go, has_begun = threading.Event(), threading.Event()

    def hang():
        has_begun.set()
        let_go.wait(60.0)
        return "late"

    yield hang, let_go, has_begun
    let_go.set()


def test_an_answer_and_an_error_come_as_they_are():
    limit = TimeLimit("Camera")
    assert limit.ask(lambda: 3) == 3
    for error in (SensorError("It is broken."), TimeoutError("its own")):

        def fail(error=error):
            raise error

        with pytest.raises(type(error)) as told:
            limit.ask(fail)
        assert told.value is error
    assert limit.ask(lambda: 4) == 4


def test_a_library_that_hangs_is_told_and_not_asked_again_until_it_answers(hanging):
    hang, let_go, has_begun = hanging
    given_up = []
    limit = TimeLimit("Camera", 0.05, lambda: given_up.append(True))
    for question in (hang, lambda: pytest.fail("it was asked while it hung")):
        with pytest.raises(SensorError, match="Camera does not answer") as told:
            limit.ask(question)
        assert told.value.fields == {"library": "Camera"}
    assert has_begun.is_set()
    assert given_up == [True]
    threads = [one for one in threading.enumerate() if one.name == THREAD_NAME]
    assert threads
    assert all(one.daemon for one in threads), "the program must be able to end"
    let_go.set()
    patient = TimeLimit("Camera")
    vars(patient).update(_is_free=vars(limit)["_is_free"], _thread=vars(limit)["_thread"])
    assert patient.ask(lambda: "well again") == "well again"


def test_two_who_ask_are_answered_one_after_the_other():
    limit, n_inside, most = TimeLimit("Camera"), [0], [0]

    def question():
        n_inside[0] += 1
        most[0] = max(most[0], n_inside[0])
        threading.Event().wait(0.01)
        n_inside[0] -= 1
        return True

    answers = []
    askers = [threading.Thread(target=lambda: answers.append(limit.ask(question))) for _ in "123"]
    for asker in askers:
        asker.start()
    for asker in askers:
        asker.join(60.0)
    assert (answers, most) == ([True] * 3, [1])


def test_a_library_that_hangs_while_it_is_loaded_holds_nobody_else(monkeypatch):
    monkeypatch.setattr(openni2_library, "LIMIT_S", 0.05)
    monkeypatch.setattr(openni2_library, "_loading", threading.Lock())
    with vars(openni2_library)["_loading"], pytest.raises(SensorError, match="still being loaded"):
        openni2_library.load_openni2()


def test_a_permanent_thread_does_everything_itself_and_in_order():
    thread, done = PermanentThread(), []
    for number in range(5):
        thread.begin(lambda number=number: done.append((number, threading.get_ident())))
    own = thread.call(threading.get_ident)
    assert done == [(number, own) for number in range(5)]
    assert own != threading.get_ident()
    with pytest.raises(ZeroDivisionError):
        thread.call(lambda: 1 // 0)
    assert thread.call(threading.get_ident) == own, "it goes on after an error"


def test_a_lent_thread_has_one_borrower_at_a_time_and_is_used_again():
    threads = LentThreads()
    one, other = threads.borrow(), threads.borrow()
    assert one is not other
    threads.give_back(one)
    assert threads.borrow() is one
