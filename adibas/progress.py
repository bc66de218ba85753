"""How far a piece of work is, told to whoever waits for it."""

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""Called with the steps that are done and with all of them; 0 where all are not known."""
