"""The program as it is started from a terminal, with a real window on a virtual screen."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from adibas.texts import LANGUAGES

SECONDS = 120
SCREEN = "1280x800x24"
PROGRAM = Path(sys.executable).with_name("adibas")
LOOK = """
import sys, time
from PySide6.QtGui import QColor, QGuiApplication

app = QGuiApplication([])
assert app.platformName() == "xcb", app.platformName()
wanted = {QColor(name).rgb() for name in sys.argv[2:]}
end = time.monotonic() + float(sys.argv[1])
seen = set()
while not wanted <= seen and time.monotonic() < end:
    time.sleep(0.2)
    image = app.primaryScreen().grabWindow(0).toImage()
    seen = {image.pixel(x, y) for x in range(0, image.width(), 3) for y in range(image.height())}
print(wanted <= seen)
"""
"""Another program on the same screen that waits for the colours of the window."""


@pytest.fixture
def home(tmp_path):
    """The environment of somebody new, without a keyring."""
    (tmp_path / "run").mkdir(mode=0o700)
    folders = {
        "HOME": tmp_path,
        "XDG_CONFIG_HOME": tmp_path / "config",
        "XDG_DATA_HOME": tmp_path / "data",
        "XDG_STATE_HOME": tmp_path / "state",
        "XDG_CACHE_HOME": tmp_path / "cache",
        "XDG_RUNTIME_DIR": tmp_path / "run",
    }
    others = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("QT_", "DBUS_", "WAYLAND_", "XDG_")) and name != "DISPLAY"
    }
    return others | {
        "PYTHON_KEYRING_BACKEND": "keyring.backends.fail.Keyring",
        "QT_QPA_PLATFORM": "xcb",
        **{name: str(path) for name, path in folders.items()},
    }


@pytest.fixture
def screen(home):
    """A virtual screen; the environment to use it."""
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", SCREEN, "-nolisten", "tcp"],
        pass_fds=[writing],
        stderr=subprocess.DEVNULL,
        env=home,
    )
    os.close(writing)
    with os.fdopen(reading) as told:
        number = told.readline().strip()
    yield home | {"DISPLAY": f":{number}"}
    server.terminate()
    server.wait(SECONDS)


def colors_are_seen(environment, *colors):
    words = [sys.executable, "-c", LOOK, str(SECONDS), *colors]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    return done.stdout.strip() == "True"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_window_is_seen_and_a_signal_ends_it_in_good_order(screen, tmp_path, number):
    from ui.theme import LIGHT

    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([PROGRAM], env=screen, **pipes) as program:
        try:
            assert colors_are_seen(screen, LIGHT.ground, LIGHT.accent, LIGHT.text)
            program.send_signal(number)
            said = program.communicate(timeout=SECONDS)
        finally:
            program.kill()  # or the end of this block would wait for it, and another test fail
    assert (program.returncode, *said) == (0, "", "")
    assert (tmp_path / "config" / "adibas" / "preferences.json").exists()
    assert (tmp_path / "state" / "adibas" / "log" / "adibas.log").read_text() == ""
    assert not (tmp_path / "data" / "adibas" / "store" / "key.json").exists()


def test_the_program_speaks_the_language_of_the_desktop(screen, tmp_path):
    from ui.theme import LIGHT

    for language in LANGUAGES:
        with subprocess.Popen(
            [PROGRAM], env=screen | {"LANGUAGE": language}, stderr=subprocess.PIPE
        ) as program:
            try:
                assert colors_are_seen(screen, LIGHT.accent)
                program.terminate()
                assert program.communicate(timeout=SECONDS)[1] == b""
            finally:
                program.kill()
        preferences = tmp_path / "config" / "adibas" / "preferences.json"
        assert f'"language": "{language}"' in preferences.read_text()
        preferences.unlink()
