"""Where the frozen program begins."""

import sys
from multiprocessing import freeze_support
from pathlib import Path

COMPILE = "--compile-kernels"
"""Said by `installers.freezing` to what it has just built, with a folder for the note."""


def main() -> int:
    """Run the program, or compile what it is shipped with."""
    if sys.argv[1:2] == [COMPILE]:
        from adibas.pipeline.warming import warm_kernels

        warm_kernels(Path(sys.argv[2]) / "compiled")
        return 0
    from ui.main import main as run

    return run()


if __name__ == "__main__":
    freeze_support()  # a process that another one starts begins here, too
    sys.exit(main())
