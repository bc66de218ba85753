"""The command line."""

from adibas.cli.main import main

__all__ = ["main"]
