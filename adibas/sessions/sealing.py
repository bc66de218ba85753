"""AES-256-GCM: bytes that nobody reads, moves or changes without the key.

Source: NIST SP 800-38D. The nonce is random, 96 bits, new for each piece (section 8.2.2): one key
seals at most the frames of one recording, far below the 2^32 pieces that the standard allows.
"""

import hmac
import os

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM

from adibas.recordings.seal import PayloadSeal, SealError

KEY_SIZE = 32
NONCE_SIZE = 12
TAG_SIZE = 16


def key_for(purpose: str, key: bytes) -> bytes:
    """Return the key for one purpose that is made of another key, and tells nothing of it.

    Source: NIST SP 800-108r1, a pseudorandom function (HMAC-SHA256) of the purpose.
    """
    return hmac.digest(key, purpose.encode(), "sha256")


class AesSeal(PayloadSeal):
    """Seals pieces for places in one scope; a piece opens at its own place only.

    Parameters
    ----------
    key : bytes
        32 bytes.
    scope : str
        What the places are in, such as ``adibas-recording-1/ID``.
    """

    def __init__(self, key: bytes, scope: str) -> None:
        if len(key) != KEY_SIZE:
            raise ValueError(f"a key has {KEY_SIZE} bytes, not {len(key)}")
        self._cipher = AESGCM(key)
        self._scope = scope

    def seal(self, name: str, payload: bytes) -> bytes:
        """Return nonce, ciphertext and tag of `payload` at the place `name`."""
        nonce = os.urandom(NONCE_SIZE)
        return nonce + self._cipher.encrypt(nonce, payload, self._place(name))

    def open(self, name: str, sealed: bytes) -> bytes:
        """Return what was sealed for the place `name`."""
        if len(sealed) < NONCE_SIZE + TAG_SIZE:
            raise SealError("too short to be sealed")
        try:
            return self._cipher.decrypt(sealed[:NONCE_SIZE], sealed[NONCE_SIZE:], self._place(name))
        except InvalidTag as error:
            raise SealError("another key or place, or changed") from error

    def _place(self, name: str) -> bytes:
        return f"{self._scope}/{name}".encode()
