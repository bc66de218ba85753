"""Compiles the hot loops before somebody waits for them: once after an installation.

Compiling takes half a minute and holds Python's lock all the while, so the window leaves it to a
process of its own; the machine code comes to everybody through numba's cache.
"""

import importlib.metadata
import logging
import os
import tempfile
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path

import platformdirs

from adibas import __version__
from adibas.errors import FileError
from adibas.files import written_whole

logger = logging.getLogger(__name__)

N_FRAMES = 2
NICENESS = 10
"""Of the process: whoever waits for the computer goes first."""


def start_warming(folder: Path | None = None) -> BaseProcess | None:
    """Compile in a process of its own; None where that was done before.

    Parameters
    ----------
    folder : Path or None
        For the note that it was done; None: the user's cache folder.
    """
    note = _note(folder or platformdirs.user_cache_path("adibas"))
    if note.exists():
        return None
    process = get_context("spawn").Process(target=warm_kernels, args=(note,), daemon=True)
    process.start()
    return process


def warm_kernels(note: Path) -> None:
    """Take a tiny demo session, which runs every hot loop, and note that it was done."""
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    from adibas.pipeline.demo import run_demo

    with tempfile.TemporaryDirectory() as name:
        run_demo(Path(name), _say_nothing, n_frames=N_FRAMES)
    try:
        with written_whole(note) as unfinished:
            unfinished.touch()
    except FileError:
        logger.info("the note of the compiled kernels cannot be written; next time once more")


def _note(folder: Path) -> Path:
    """Return the note's place: other versions of program or compiler need another one."""
    compiler = importlib.metadata.version("numba")
    return folder / f"compiled-{__version__}-numba-{compiler}"


def _say_nothing(_done: int, _total: int) -> None:
    """Report to nobody."""
