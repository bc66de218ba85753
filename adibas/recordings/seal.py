"""What a recording needs of the one who seals its payloads."""

from abc import abstractmethod
from typing import Protocol

from adibas.recordings.reading import DamagedError


class SealError(DamagedError):
    """Something was sealed under another key or for another place, or was changed since."""


class PayloadSeal(Protocol):
    """Makes pieces of one recording unreadable, and sees any change to them."""

    @abstractmethod
    def seal(self, name: str, payload: bytes) -> bytes:
        """Return `payload` sealed for the place `name`, such as ``frame/17``."""

    @abstractmethod
    def open(self, name: str, sealed: bytes) -> bytes:
        """Return what was sealed for the place `name`.

        Raises
        ------
        SealError
            It was sealed under another key or for another place, or was changed since.
        """
