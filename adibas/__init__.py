"""Posture and movement of people, measured with an inexpensive depth camera."""

__version__ = "0.1.0"
