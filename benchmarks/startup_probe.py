"""Started as a process of its own: opens a window and ends; prints when it was usable.

Usage: ``python -m benchmarks.startup_probe empty|passphrase|patients FOLDER``. A store's key comes
from a keyring in memory, so that no passphrase is typed and no desktop is asked.
"""

import os
import sys
import time

STARTED_S = time.perf_counter()
KEY_VARIABLE = "ADIBAS_BENCHMARK_KEY"


def main() -> None:
    """Run one of the windows until it is usable."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    kind, folder = sys.argv[1], sys.argv[2]
    if kind == "empty":
        _empty_window()
    else:
        _program(folder, until=kind)
    sys.stdout.write(f"{time.perf_counter() - STARTED_S:.4f}\n")
    sys.stdout.flush()
    os._exit(0)


def _empty_window() -> None:
    """Show what every program of this kind begins with: a window and an empty plot."""
    import pyqtgraph
    from PySide6.QtWidgets import QApplication, QMainWindow

    app = QApplication([])
    window = QMainWindow()
    window.setCentralWidget(pyqtgraph.PlotWidget())
    window.show()
    app.processEvents()


def _program(folder: str, until: str) -> None:
    """Show our window until it asks for the passphrase, or until the patients are listed."""
    from ui.collector import put_off

    put_off()  # as `ui.main` does
    from pathlib import Path

    from PySide6.QtCore import QEventLoop
    from PySide6.QtWidgets import QApplication, QLineEdit

    from benchmarks.memory_keyring import use_memory_keyring
    from ui.application import Application
    from ui.preferences import PreferencesFile

    use_memory_keyring(os.environ.get(KEY_VARIABLE, ""))
    app = QApplication([])
    application = Application(
        app, PreferencesFile(Path(folder) / "preferences.json"), Path(folder) / "store"
    )
    application.start()
    fields = application.window.unlock_page.findChildren(QLineEdit)
    while application.window.shown != "patients":
        if until == "passphrase" and any(field.isVisible() for field in fields):
            break
        app.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents)
    app.processEvents()


if __name__ == "__main__":
    main()
