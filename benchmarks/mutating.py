"""Files that somebody changed: bytes, numbers, lengths, words; cut, repeated or moved."""

import random

NUMBERS = (0, 1, 0x7F, 0x80, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1)
WORDS = (
    b"NaN", b"Infinity", b"-1", b"0", b"1e999", b"1" + b"0" * 30, b"null", b"true", b"{}", b"[]",
    b'""', b"[" * 100_000, b"\xef\xbb\xbf", b"\xff", b"\x00", b"\r", b'"', b",", b"-",
    b"\xed\xa0\x80", b"\\ud800", b"1" * 5_000,
)  # fmt: skip
"""What parsers of texts stumble over."""


def mutate(data: bytes, rng: random.Random, *, is_text: bool = False) -> bytes:
    """Return `data` with a few changes; of a text also with values put in place of others."""
    mutated = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        begin, end, new = _change(mutated, rng, is_text=is_text)
        mutated[begin:end] = new
    return bytes(mutated)


def _change(data: bytearray, rng: random.Random, *, is_text: bool) -> tuple[int, int, bytes]:
    at, other = (rng.randrange(max(1, len(data))) for _ in range(2))
    length = min(rng.choice((1, 4, 8, 40, 400)), len(data) - at)
    size = rng.choice((1, 2, 4, 8))
    number = (rng.choice(NUMBERS) % 2 ** (8 * size)).to_bytes(size, "little")
    piece = bytes(data[other : other + length])
    changes = [
        (at, at + 1, rng.randbytes(1)),
        (at, at + size, number),
        (at, len(data), b""),
        (at, at + length, b""),
        (at, at, piece),
        (at, at + length, rng.randbytes(length)),
        (at, at + length, piece),
    ]
    if is_text:
        begin, end = _value(data, at)
        changes += [(begin, end, rng.choice(WORDS))] * 5
    return rng.choice(changes)


def _value(data: bytearray, at: int) -> tuple[int, int]:
    """Return where the number or word about `at` begins and ends."""
    begin = end = at
    while begin and _is_of_value(data[begin - 1]):
        begin -= 1
    while end < len(data) and _is_of_value(data[end]):
        end += 1
    return begin, max(end, min(at + 1, len(data)))


def _is_of_value(byte: int) -> bool:
    return chr(byte).isalnum() or byte in b"+-._"
