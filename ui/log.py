"""The program's log: what happened and where in the program, never of whom."""

import faulthandler
import logging
from collections.abc import Callable
from logging.handlers import RotatingFileHandler
from pathlib import Path
from types import TracebackType
from typing import TextIO

import platformdirs

LOG_FILE = "adibas.log"
FAULTS_FILE = "faults.log"
"""Frames of a crash outside Python, which has no time for anything else."""

MOST_BYTES, N_OLD_FILES = 1_000_000, 3
OURS = ("adibas", "ui")
"""Loggers that are written; a library's might tell a statement with its values."""

SysExcInfo = (
    tuple[type[BaseException], BaseException, TracebackType | None] | tuple[None, None, None]
)


def log_folder() -> Path:
    """Return where this user's log lies."""
    return platformdirs.user_log_path("adibas", appauthor=False)


class NamelessFormatter(logging.Formatter):
    """Writes of an error its kind and its way through the program.

    What the error says is left out, for it may quote what somebody typed: a patient's name.
    """

    def formatException(self, ei: SysExcInfo) -> str:  # noqa: N802  (logging's name)
        error = ei[1]
        lines: list[str] = []
        while error is not None:
            lines.append(type(error).__qualname__)
            lines += _way_of(error.__traceback__)
            error = error.__cause__ or error.__context__
        return "\n".join(lines)


def start_log(folder: Path) -> Callable[[], None]:
    """Write a log into `folder` from now on; return what ends that.

    A folder that cannot be written means that there is no log: no reason not to work.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handler = RotatingFileHandler(
            folder / LOG_FILE, maxBytes=MOST_BYTES, backupCount=N_OLD_FILES, encoding="utf-8"
        )
        faults = (folder / FAULTS_FILE).open("w", encoding="utf-8")
    except OSError:
        return _end_nothing
    handler.setFormatter(NamelessFormatter("%(asctime)s %(levelname)s %(name)s %(message)s"))
    for name in OURS:
        logging.getLogger(name).addHandler(handler)
        logging.getLogger(name).setLevel(logging.INFO)
    faulthandler.enable(faults)
    return lambda: _end(handler, faults)


def _end(handler: logging.Handler, faults: TextIO) -> None:
    faulthandler.disable()
    faults.close()
    for name in OURS:
        logging.getLogger(name).removeHandler(handler)
    handler.close()


def _end_nothing() -> None:
    """End a log that was never begun."""


def _way_of(traceback: TracebackType | None) -> list[str]:
    """Return module, line and function of each frame; no path, for it has the user's name."""
    way = []
    while traceback is not None:
        code = traceback.tb_frame.f_code
        module = traceback.tb_frame.f_globals.get("__name__", "?")
        way.append(f"  {module}:{traceback.tb_lineno} in {code.co_name}")
        traceback = traceback.tb_next
    return way
