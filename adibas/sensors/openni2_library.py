"""Finds and loads the OpenNI2 library, once for the whole process."""

import atexit
import os
import sys
import sysconfig
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import platformdirs

from adibas.errors import SensorError
from adibas.sensors.answering import LIMIT_S

LIBRARY_NAMES = {"win32": "OpenNI2.dll", "darwin": "libOpenNI2.dylib"}
LIBRARY_NAME = LIBRARY_NAMES.get(sys.platform, "libOpenNI2.so")
REDIST_VARIABLES = ("OPENNI2_REDIST64", "OPENNI2_REDIST")
ERRORS_ONLY = 3

_loading = threading.Lock()


def system_folders() -> tuple[Path, ...]:
    """Return where Linux distributions put shared libraries, this machine's kind first."""
    architecture = sysconfig.get_config_var("MULTIARCH") or ""
    return tuple(
        dict.fromkeys(
            Path(root, part)
            for root in ("/usr/lib", "/usr/local/lib", "/usr/lib64")
            for part in (architecture, "")
        )
    )


def find_library_folder(folders: tuple[Path, ...] | None = None) -> Path:
    """Return a folder with the OpenNI2 library under the name that its Python binding opens.

    The variables OPENNI2_REDIST64 and OPENNI2_REDIST name such a folder before all others. Debian
    ships that name in the development package only: without it a private folder in the user's
    cache links to the library and to its drivers.

    Parameters
    ----------
    folders : tuple of Path, optional
        Where to look; the system's library folders by default.

    Raises
    ------
    SensorError
        The library is not installed.
    """
    named = [Path(os.environ[name]) for name in REDIST_VARIABLES if os.environ.get(name)]
    searched = (*named, *(system_folders() if folders is None else folders))
    for folder in searched:
        if (folder / LIBRARY_NAME).is_file():
            return folder.resolve()
        versioned = folder / f"{LIBRARY_NAME}.0"
        if versioned.is_file():
            return _private_folder(versioned)
    raise SensorError(
        "OpenNI2 is not installed, so that its sensors cannot be used. Install it (Debian, Ubuntu: "
        "sudo apt-get install libopenni2-0), or set OPENNI2_REDIST to its folder."
    )


def _private_folder(library: Path) -> Path:
    folder = platformdirs.user_cache_path("adibas") / "openni2"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _link(folder / LIBRARY_NAME, library)
        _link(folder / "OpenNI2", library.parent / "OpenNI2")
    except OSError as error:
        raise SensorError(
            "OpenNI2 cannot be prepared in {folder}: {reason}. Make this folder writable, or "
            "install OpenNI2's development package (Debian, Ubuntu: libopenni2-dev).",
            folder=folder,
            reason=error.strerror or str(error),
        ) from error
    return folder


def _link(link: Path, target: Path) -> None:
    if link.is_symlink() and link.readlink() == target:
        return
    link.unlink(missing_ok=True)
    link.symlink_to(target)


def load_openni2() -> ModuleType:
    """Return the module ``openni.openni2``, initialised.

    It is loaded once and kept until the process ends: cameras are opened and closed at will, and
    sensors that are plugged in later are found as well.

    Raises
    ------
    SensorError
        The library or its Python binding is missing or broken.
    """
    try:
        from openni import openni2
    except ImportError as error:
        raise SensorError(
            "The Python package openni is missing. Install it: pip install openni."
        ) from error
    if not _loading.acquire(timeout=LIMIT_S):
        raise SensorError(
            "OpenNI2 is still being loaded and does not answer. Unplug its sensors and try again."
        )
    try:
        if not openni2.is_initialized():
            _initialise(openni2, find_library_folder())
    finally:
        _loading.release()
    loaded: ModuleType = openni2
    return loaded


def _initialise(openni2: ModuleType, folder: Path) -> None:
    from openni.utils import InitializationError

    try:
        openni2.initialize(str(folder))
    except InitializationError as error:
        raise SensorError(
            "OpenNI2 in {folder} cannot be loaded. Install it anew (Debian, Ubuntu: "
            "sudo apt-get install --reinstall libopenni2-0).",
            folder=folder,
        ) from error
    openni2.configure_logging(severity=ERRORS_ONLY, console=False)


def leave_running() -> None:
    """Do not shut the library down when the program ends: one that hangs would hold it for ever."""
    from openni import openni2

    atexit.unregister(openni2.unload)


@contextmanager
def openni2_errors(message_id: str, **fields: object) -> Iterator[None]:
    """Turn an error of the library into a SensorError with this sentence; {reason} is its own."""
    from openni.utils import OpenNIError

    try:
        yield
    except OpenNIError as error:
        raise SensorError(message_id, **fields, reason=_reason(error)) from error


def _reason(error: Exception) -> str:
    message = error.args[1] if len(error.args) > 1 else str(error)
    text = message.decode(errors="replace") if isinstance(message, bytes) else str(message)
    return " ".join(text.split()).rstrip(".") or "no reason given"
