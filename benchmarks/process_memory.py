"""What a process holds in memory, and the most that it held."""

import os
import resource
import sys
from pathlib import Path


def resident_memory_mib() -> float:
    """Return what is resident; where the system does not tell, the most that ever was."""
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text("ascii").split()[1]) * os.sysconf("SC_PAGESIZE") / 2**20
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / 2**20 if sys.platform == "darwin" else most / 2**10


def peak_memory_mib() -> float:
    """Return the most that this process held; 0 where the system does not tell.

    Not `getrusage`: Linux hands its figure on to a new process, which so begins with the most that
    the process held that started it.
    """
    status = Path("/proc/self/status")
    if not status.is_file():
        return 0.0
    lines = status.read_text(encoding="ascii").splitlines()
    peak = next((line for line in lines if line.startswith("VmHWM:")), "VmHWM: 0 kB")
    return float(peak.split()[1]) / 1024
