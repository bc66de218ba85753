"""A bug that nobody caught: it is written down without any patient, and the user is told."""

import logging
import sys
import threading
from collections.abc import Callable
from types import TracebackType

from adibas.texts import translate as _

logger = logging.getLogger(__name__)


def install_crash_report(tell: Callable[[str], None]) -> Callable[[], None]:
    """Log what nobody caught, in any thread, and tell the user.

    Parameters
    ----------
    tell : callable
        Given a sentence, in the thread of the bug.

    Returns
    -------
    take_away : callable
        Takes the hooks away again.
    """
    before, before_in_threads = sys.excepthook, threading.excepthook

    def report(
        kind: type[BaseException], error: BaseException, traceback: TracebackType | None
    ) -> None:
        if issubclass(kind, KeyboardInterrupt):
            before(kind, error, traceback)
            return
        logger.critical("a bug", exc_info=(kind, error, traceback))
        tell(
            _(
                "Something in the program went wrong that should not. What was saved is safe. "
                "Restart the program, and send its log to who maintains it."
            )
        )

    def report_of_thread(ended: threading.ExceptHookArgs) -> None:
        if ended.exc_value is not None:  # nothing is left of it while the program ends
            report(ended.exc_type, ended.exc_value, ended.exc_traceback)

    sys.excepthook, threading.excepthook = report, report_of_thread

    def take_away() -> None:
        if sys.excepthook is report:
            sys.excepthook = before
        if threading.excepthook is report_of_thread:
            threading.excepthook = before_in_threads

    return take_away
