"""A bug that nobody caught: it is written down without any patient, and the user is told."""

import logging
import sys
from collections.abc import Callable
from types import TracebackType

from adibas.texts import translate as _

logger = logging.getLogger(__name__)


def install_crash_report(tell: Callable[[str], None]) -> Callable[[], None]:
    """Log what nobody caught and tell the user; return what takes the hook away again."""
    before = sys.excepthook

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

    sys.excepthook = report

    def take_away() -> None:
        if sys.excepthook is report:
            sys.excepthook = before

    return take_away
