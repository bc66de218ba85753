"""Work in threads must look like a plain loop: same results, same order, same errors."""

import threading
import time

import pytest

from adibas.pipeline.in_order import in_order


def threads_in_order():
    return [t for t in threading.enumerate() if t.name.startswith("in-order")]


def slow_first(number):
    """Make early items finish last."""
    time.sleep(0.02 if number % 3 == 0 else 0)
    return number * number


@pytest.mark.parametrize("n_threads", [1, 2, 5])
@pytest.mark.parametrize("n_items", [0, 1, 2, 13])
def test_results_come_in_the_order_of_the_items(n_threads, n_items):
    with in_order(slow_first, range(n_items), n_threads) as results:
        assert list(results) == [number * number for number in range(n_items)]
    assert threads_in_order() == []


def test_items_are_worked_on_side_by_side():
    meeting = threading.Barrier(2)
    with in_order(lambda _: meeting.wait(timeout=10), range(4), 2) as results:
        assert sorted(results) == [0, 0, 1, 1]


def test_only_a_few_items_are_taken_ahead():
    n_taken = 0

    def items():
        nonlocal n_taken
        for number in range(100):
            n_taken += 1
            yield number

    with in_order(slow_first, items(), 2) as results:
        for n_given, _ in enumerate(results, 1):
            assert n_taken <= n_given + 2
    assert n_taken == 100


def test_an_error_of_the_work_comes_in_the_place_of_its_result():
    def work(number):
        if number == 3:
            raise ZeroDivisionError
        return number

    given = []
    with pytest.raises(ZeroDivisionError), in_order(work, range(10), 2) as results:
        given.extend(results)
    assert given == [0, 1, 2]
    assert threads_in_order() == []


def test_an_error_of_the_items_ends_the_threads():
    def items():
        yield 0
        raise OSError("unplugged")

    with pytest.raises(OSError, match="unplugged"), in_order(slow_first, items(), 2) as results:
        list(results)
    assert threads_in_order() == []


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, RuntimeError])
def test_an_early_end_leaves_no_thread_and_begins_no_more_work(interruption):
    begun = []

    def work(number):
        begun.append(number)
        time.sleep(0.01)
        return number

    with pytest.raises(interruption), in_order(work, range(1000), 2) as results:
        next(results)
        raise interruption
    n_begun = len(begun)
    assert threads_in_order() == []
    time.sleep(0.05)
    assert len(begun) == n_begun <= 3
