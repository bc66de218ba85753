"""The same work on one thing after the other, several at a time, with the results in order.

The loops of the stages leave Python's lock, so that threads do them side by side.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


@contextmanager
def in_order(
    work: Callable[[Item], Result], items: Iterable[Item], n_threads: int
) -> Iterator[Iterator[Result]]:
    """Give the results of `work` on each of `items`, in order, done by `n_threads` threads.

    The caller's thread takes the items, one more than there are threads: never all at once. What
    `work` raises is raised where its result would have come; what `items` raise, at once. Leaving
    the block, also by an exception or Ctrl-C, waits for the work that has begun and ends the
    threads.

    Parameters
    ----------
    work : callable
        Safe to run in several threads.
    items : iterable
        May be longer than memory holds.
    n_threads : int
        At least 1.
    """
    pool = ThreadPoolExecutor(n_threads, thread_name_prefix="in-order")
    try:
        yield _results(pool, work, items, n_threads + 1)
    finally:
        pool.shutdown(cancel_futures=True)


def _results(
    pool: ThreadPoolExecutor, work: Callable[[Item], Result], items: Iterable[Item], n_ahead: int
) -> Iterator[Result]:
    waiting: deque[Future[Result]] = deque()
    for item in items:
        waiting.append(pool.submit(work, item))
        if len(waiting) == n_ahead:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()
