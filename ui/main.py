"""The console script `adibas`: opens the window, or hands over to the command line without Qt."""

import sys

from adibas.cli import main as run_command


def main() -> int:
    """Run the command on the command line; without one, the demo (there is no window yet)."""
    arguments = sys.argv[1:] or ["demo", "--out", "adibas-demo"]
    return run_command(arguments)
