"""The recovery key: made at random, told once, and typed again when a passphrase is lost.

Its letters are Crockford's base32, which has no I, L, O or U: who reads one from paper cannot take
it for a digit. Two of the letters are a check: a Reed-Solomon code over the 32 letters, so that one
or two wrong letters, and two that changed places, are always noticed.

Source: Crockford, Base 32, 2019 (https://www.crockford.com/base32.html); MacWilliams & Sloane, The
Theory of Error-Correcting Codes, chapter 10.
"""

import itertools
import secrets
from collections.abc import Mapping, Sequence

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF

from adibas.errors import RecoveryKeyTypedError
from adibas.sessions.bytes_as_text import bytes_of, text_of

LETTERS = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
N_RANDOM, N_CHECK = 26, 2
"""Letters of five bits each: 130 random bits."""
GROUP = 4
SCOPE = "adibas-recovery-1"
KEY_BYTES, SALT_BYTES, NONCE_BYTES, TAG_BYTES = 32, 16, 12, 16

_MISREAD = str.maketrans({"O": "0", "I": "1", "L": "1"})
_N_POWERS = 31


def _powers() -> tuple[int, ...]:
    """Return the powers of the field's element 2: x^5 + x^2 + 1 is primitive over GF(2)."""
    powers, value = [], 1
    for _power in range(_N_POWERS):
        powers.append(value)
        value <<= 1
        if value > _N_POWERS:
            value ^= 0b100101
    return tuple(powers)


_EXP = _powers()
_LOG = {value: power for power, value in enumerate(_EXP)}


def make_recovery_key() -> str:
    """Return a new key, its letters in groups of four."""
    drawn = [secrets.randbelow(len(LETTERS)) for _letter in range(N_RANDOM)]
    checks = itertools.product(range(len(LETTERS)), repeat=N_CHECK)
    check = next(check for check in checks if _is_consistent((*drawn, *check)))
    return grouped("".join(LETTERS[value] for value in (*drawn, *check)))


def grouped(letters: str) -> str:
    """Return the letters of a key in groups of four."""
    return "-".join(letters[at : at + GROUP] for at in range(0, len(letters), GROUP))


def read_recovery_key(typed: str) -> str:
    """Return the key as it was made; spaces, dashes, small letters, O, I and L are all right.

    Raises
    ------
    RecoveryKeyTypedError
        Its length or its check says that it is mistyped.
    """
    letters = "".join(one for one in typed.upper() if one.isalnum()).translate(_MISREAD)
    if any(one not in LETTERS for one in letters):
        raise RecoveryKeyTypedError(
            "The recovery key has a letter that none has: {letter}. It is mistyped; nothing was "
            "changed. Compare it with the paper, group by group.",
            letter=next(one for one in letters if one not in LETTERS),
        )
    if len(letters) != N_RANDOM + N_CHECK:
        raise RecoveryKeyTypedError(
            "A recovery key has {wanted} letters and digits, and {n} were given. Nothing was "
            "changed. Compare it with the paper, group by group.",
            wanted=N_RANDOM + N_CHECK,
            n=len(letters),
        )
    if not _is_consistent([LETTERS.index(one) for one in letters]):
        raise RecoveryKeyTypedError(
            "The recovery key is mistyped: its letters do not belong together. Nothing was "
            "changed. Compare it with the paper, group by group."
        )
    return grouped(letters)


def seal_for_recovery(
    key: bytes, recovery_key: str, store_id: str, made_utc: str
) -> dict[str, object]:
    """Return `key` sealed by a recovery key, as plain values for a JSON document.

    Parameters
    ----------
    key : bytes
        Of the store.
    store_id : str
        The copy opens for this store only.
    made_utc : str
        ISO 8601; it is bound to the copy.
    """
    salt, nonce = secrets.token_bytes(SALT_BYTES), secrets.token_bytes(NONCE_BYTES)
    cipher = _cipher(recovery_key, salt, store_id)
    sealed = cipher.encrypt(nonce, key, _place(store_id, made_utc))
    texts = {"salt": salt, "nonce": nonce, "sealed_key": sealed}
    told = {name: text_of(data) for name, data in texts.items()}
    return {"made_utc": made_utc, **told}


def open_for_recovery(
    document: Mapping[str, object], recovery_key: str, store_id: str
) -> bytes | None:
    """Return the store's key; None where the recovery key is another one.

    Raises
    ------
    ValueError
        The document is damaged.
    """
    made_utc = document.get("made_utc")
    if not isinstance(made_utc, str):
        raise ValueError("the date of the recovery key is missing")  # noqa: TRY004
    salt, nonce, sealed = (bytes_of(document, name) for name in ("salt", "nonce", "sealed_key"))
    lengths = (len(salt), len(nonce), len(sealed))
    if lengths != (SALT_BYTES, NONCE_BYTES, KEY_BYTES + TAG_BYTES):
        raise ValueError("the copy for the recovery key is cut short")
    cipher = _cipher(recovery_key, salt, store_id)
    try:
        return cipher.decrypt(nonce, sealed, _place(store_id, made_utc))
    except InvalidTag:
        return None


def _is_consistent(values: Sequence[int]) -> bool:
    """Say whether both sums of the code are zero: of value times 2^place, and times 4^place."""
    sums = [0] * N_CHECK
    for place, value in enumerate(values):
        if value:
            for order in range(N_CHECK):
                sums[order] ^= _EXP[(_LOG[value] + (order + 1) * place) % _N_POWERS]
    return not any(sums)


def _cipher(recovery_key: str, salt: bytes, store_id: str) -> AESGCM:
    """Return the cipher of a key; a random one of 130 bits needs no costly derivation.

    Source: RFC 5869.
    """
    derivation = HKDF(SHA256(), KEY_BYTES, salt, f"{SCOPE}/{store_id}".encode())
    return AESGCM(derivation.derive(recovery_key.encode()))


def _place(store_id: str, made_utc: str) -> bytes:
    return f"{SCOPE}/{store_id}/{made_utc}".encode()
