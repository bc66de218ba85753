"""The command line."""

from adibas.cli.command_line import main

__all__ = ["main"]
