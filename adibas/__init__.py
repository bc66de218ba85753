"""Posture and movement of people, measured with an inexpensive depth camera."""

from importlib.metadata import version

__version__ = version("adibas")
