"""Where the frozen program begins."""

import os
import sys
from multiprocessing import freeze_support
from pathlib import Path
from types import ModuleType

COMPILE = "--compile-kernels"
"""Said by `installers.freezing` to what it has just built, with a folder for the note."""


LIBRARIES = "LD_LIBRARY_PATH"


def give_libraries_back() -> None:
    """Let a browser that this program starts load its own libraries, and not ours.

    PyInstaller's loader leads to ours by this variable, which the linker read before; what it was
    stands beside it.
    """
    before = os.environ.pop(f"{LIBRARIES}_ORIG", None)
    if before is not None:
        os.environ[LIBRARIES] = before
    elif getattr(sys, "frozen", False):
        os.environ.pop(LIBRARIES, None)


def leave_out_open_gl() -> None:
    """Give pyqtgraph an empty module in the place of one that is 9 MB.

    It imports that always, and uses it where a plot is to be drawn with OpenGL; none of ours is.
    """
    if getattr(sys, "frozen", False):
        sys.modules["PySide6.QtOpenGL"] = ModuleType("PySide6.QtOpenGL")


def main() -> int:
    """Run the program, or compile what it is shipped with."""
    give_libraries_back()
    leave_out_open_gl()
    if sys.argv[1:2] == [COMPILE]:
        from adibas.pipeline.warming import warm_kernels

        warm_kernels(Path(sys.argv[2]) / "compiled")
        return 0
    from ui.main import main as run

    return run()


if __name__ == "__main__":
    freeze_support()  # a process that another one starts begins here, too
    sys.exit(main())
