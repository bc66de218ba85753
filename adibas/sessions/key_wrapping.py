"""A key behind a passphrase: Argon2id makes a second key, which seals the first one."""

import secrets
import threading
import unicodedata
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.kdf.argon2 import Argon2id

from adibas.sessions.bytes_as_text import bytes_of, text_of

KEY_BYTES = 32
SALT_BYTES = 16
NONCE_BYTES = 12
SHORTEST_PASSPHRASE = 8
MOST_ITERATIONS = 100
MOST_LANES = 64
MOST_MEMORY_KIB = 4 * 1024 * 1024

Derived = dict[tuple[object, ...], bytes]
"""Keys that a passphrase gave, by the numbers and the salt of the derivation."""

_ONE_AT_A_TIME = threading.Lock()
"""OpenSSL has one pool of threads for the lanes; a second derivation finds it taken and fails."""


@dataclass(frozen=True, slots=True)
class Argon2Params:
    """How costly one guess of a passphrase is.

    Source: RFC 9106, section 4, the second recommended choice (for less memory than 2 GiB).

    Attributes
    ----------
    iterations : int
        Passes over the memory: 3.
    lanes : int
        Computed side by side: 4.
    memory_kib : int
        64 MiB.
    """

    iterations: int = 3
    lanes: int = 4
    memory_kib: int = 64 * 1024

    def __post_init__(self) -> None:
        is_sane = (
            1 <= self.iterations <= MOST_ITERATIONS
            and 1 <= self.lanes <= MOST_LANES
            and 8 * self.lanes <= self.memory_kib <= MOST_MEMORY_KIB
        )
        if not is_sane:
            raise ValueError(f"no use for Argon2id: {self}")


def wrap_key(
    key: bytes, passphrase: str, bound_to: str, params: Argon2Params, salt: bytes | None = None
) -> dict[str, object]:
    """Return `key` sealed by `passphrase`, as plain values for a JSON document.

    Parameters
    ----------
    key : bytes
        What is sealed.
    bound_to : str
        The sealed key opens only together with this text.
    salt : bytes, optional
        Of the derivation; a new random one if not given.
    """
    salt = secrets.token_bytes(SALT_BYTES) if salt is None else salt
    nonce = secrets.token_bytes(NONCE_BYTES)
    sealed = AESGCM(_derive(passphrase, salt, params)).encrypt(nonce, key, bound_to.encode())
    return {
        "argon2id": asdict(params),
        "salt": text_of(salt),
        "nonce": text_of(nonce),
        "sealed_key": text_of(sealed),
    }


def unwrap_key(
    document: Mapping[str, object],
    passphrase: str,
    bound_to: str,
    derived: Derived | None = None,
) -> bytes | None:
    """Return the key; None where the passphrase is another one.

    Parameters
    ----------
    derived : dict, optional
        What this passphrase gave before; what it gives now is added.

    Raises
    ------
    ValueError
        The document is damaged.
    """
    params, salt = derivation_of(document)
    nonce, sealed = (bytes_of(document, name) for name in ("nonce", "sealed_key"))
    if (len(nonce), len(sealed)) != (NONCE_BYTES, KEY_BYTES + 16):
        raise ValueError("the sealed key is cut short")
    derived = {} if derived is None else derived
    if (params, salt) not in derived:
        derived[params, salt] = _derive(passphrase, salt, params)
    try:
        return AESGCM(derived[params, salt]).decrypt(nonce, sealed, bound_to.encode())
    except InvalidTag:
        return None


def derivation_of(document: Mapping[str, object]) -> tuple[Argon2Params, bytes]:
    """Return the numbers and the salt with which a passphrase becomes a key.

    Raises
    ------
    ValueError
        The document is damaged.
    """
    numbers = document.get("argon2id")
    if not isinstance(numbers, Mapping):
        raise ValueError("argon2id is missing")  # noqa: TRY004  (the file's fault)
    names = ("iterations", "lanes", "memory_kib")
    if not all(type(numbers.get(name)) is int for name in names):
        raise ValueError("the numbers of argon2id are missing")
    salt = bytes_of(document, "salt")
    if len(salt) != SALT_BYTES:
        raise ValueError("the sealed key is cut short")
    return Argon2Params(*(numbers[name] for name in names)), salt


def _derive(passphrase: str, salt: bytes, params: Argon2Params) -> bytes:
    # Keyboards of different systems compose accents differently.
    # Bytes of the environment that are no text stand in it as lone surrogates.
    secret = unicodedata.normalize("NFC", passphrase).encode("utf-8", "surrogatepass")
    derivation = Argon2id(
        salt=salt,
        length=KEY_BYTES,
        iterations=params.iterations,
        lanes=params.lanes,
        memory_cost=params.memory_kib,
    )
    with _ONE_AT_A_TIME:
        return derivation.derive(secret)
