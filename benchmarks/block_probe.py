"""Started as a process of its own: goes through all screens, prints when the window did not answer.

Usage: ``python -m benchmarks.block_probe FOLDER ROUNDS``. Prints JSON: of each screen the longest
block in milliseconds, and the longest work of the window's own thread between two beats.
"""

import json
import os
import sys
from pathlib import Path

START_S, SECONDS_A_SCREEN = 5.0, 4.0


def main() -> None:
    """Live through all screens with the simulator as sensor."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from ui.collector import put_off

    put_off()  # as `ui.main` does
    from PySide6.QtWidgets import QApplication

    from benchmarks.heartbeat import Heartbeat
    from benchmarks.memory_keyring import use_memory_keyring
    from benchmarks.startup_probe import KEY_VARIABLE
    from ui.application import Application
    from ui.navigation import TITLES
    from ui.preferences import PreferencesFile
    from ui.screens import preload

    use_memory_keyring(os.environ.get(KEY_VARIABLE, ""))
    folder = Path(sys.argv[1])
    app = QApplication([])
    application = Application(app, PreferencesFile(folder / "preferences.json"), folder / "store")
    heartbeat = Heartbeat(app)
    application.start()
    preload()  # as `ui.application.run` does
    heartbeat.live_through("start", START_S)
    for _round in range(int(sys.argv[2])):
        for name in TITLES:
            application.window.show_screen(name)
            heartbeat.live_through(name, SECONDS_A_SCREEN)
    heartbeat.stop()
    application.close()
    sys.stdout.write(json.dumps(heartbeat.blocks_ms()) + "\n")


if __name__ == "__main__":
    main()
