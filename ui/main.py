"""The console script `adibas`: opens the window, or hands over to the command line without Qt."""

import os
import signal
import sys
from pathlib import Path
from types import FrameType

from adibas.crash_memory import keep_out_of_crash_dumps

WORLD_FAILED = 1
INTERRUPTED = 130
"""As shells count an end by Ctrl-C: 128 + SIGINT."""


def main() -> int:
    """Run the command on the command line; without one, or of a recording, open the window.

    Where there is no display the demo runs instead.
    """
    while_it_runs = signal.getsignal(signal.SIGINT)
    _end_on_ctrl_c()  # before the imports: there is nothing yet that could be left unfinished
    keep_out_of_crash_dumps()
    try:
        if all(map(names_recording, sys.argv[1:])):
            if has_display():
                # Ctrl-C in the terminal closes it like any other program.
                return _open_window(sys.argv[1:])
            if sys.argv[1:]:
                return _tell_no_display(sys.argv[1])
        from adibas.cli import main as run_command

        signal.signal(signal.SIGINT, while_it_runs)
        return run_command(sys.argv[1:] or ["demo", "--out", "adibas-demo"])
    except KeyboardInterrupt:  # before or after the part that has a sentence for it
        return INTERRUPTED
    finally:
        _end_on_ctrl_c()  # while libraries unload


def has_display() -> bool:
    """Say whether a window can be shown to somebody."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def names_recording(argument: str) -> bool:
    """Say whether an argument is a recording that a desktop opens with the program."""
    from adibas.recordings import is_named_like_recording

    return is_named_like_recording(Path(argument))


def _open_window(recordings: list[str]) -> int:
    from ui.collector import put_off

    put_off()  # before the imports: they are most of the start
    from ui.application import run

    return run(recordings)


def _tell_no_display(recording: str) -> int:
    from adibas.texts import translate as _

    text = _(
        "There is no display to show {file} on. The commands measure it without one: "
        "see adibas posture --help"
    )
    sys.stderr.write(text.format(file=Path(recording).name) + "\n")
    return WORLD_FAILED


def _end_on_ctrl_c() -> None:
    """Let Ctrl-C end the program at once and without a word, unless it is ignored altogether."""
    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:
        signal.signal(signal.SIGINT, _end)


def _end(_signal: int, _frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)
