"""The most that a process held."""

from pathlib import Path


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
