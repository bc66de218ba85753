"""No image of this program's memory is left on a disk when it crashes: patients are in it."""

import sys
from contextlib import suppress
from pathlib import Path

CORE_FILTER = Path("/proc/self/coredump_filter")
NOTHING = "0"
NO_FAULT_BOX = 0x0001 | 0x0002
"""SEM_FAILCRITICALERRORS and SEM_NOGPFAULTERRORBOX: Windows then makes no report of a crash."""


def keep_out_of_crash_dumps() -> None:
    """Ask the system for no dump of this process and of those that it starts.

    A limit of zero is kept by systems that write a file, and by the services that take dumps over;
    whoever does not ask for the limit gets a dump without any memory (Linux). The places in the
    program where it crashed are in its own log all the same.
    """
    if sys.platform == "win32":
        import ctypes

        ctypes.windll.kernel32.SetErrorMode(NO_FAULT_BOX)
        return
    import resource

    _soft, hard = resource.getrlimit(resource.RLIMIT_CORE)
    resource.setrlimit(resource.RLIMIT_CORE, (0, hard))
    with suppress(OSError):  # not Linux, or a system that hides it
        CORE_FILTER.write_text(NOTHING, encoding="ascii")
