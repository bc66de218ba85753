"""Lists of TUM folders that programs wrote: every line alike, so that they are read all at once.

What these functions do not take may be right nevertheless; `tum_lists` then looks at each line.
"""

import numpy as np

from adibas.arrays import IntArray, UInt8Array
from adibas.clock import NS_PER_S
from adibas.recordings.ports import MAX_TIMESTAMP_NS

N_DECIMALS, N_WHOLE = 9, 10
NINE = 9
GREATEST_S = MAX_TIMESTAMP_NS // NS_PER_S
SPACE, NEWLINE, DOT, SLASH, ZERO = b" \n./0"


def parse_regular(data: bytes) -> tuple[IntArray, list[str]] | None:
    """Return the times (ns) and the names of a list, or None.

    A regular list has comments at its top alone, and then nothing but lines of decimal seconds
    with a point, one space and a name of ASCII characters that stays inside the folder.
    """
    start = _end_of_comments(data)
    if start is None:
        return None
    text = data[start:].replace(b"\r\n", b"\n")
    text += b"" if text.endswith(b"\n") or not text else b"\n"
    if not text.isascii() or any(word in text for word in (b"\\", b":", b"..")):
        return None
    characters = np.frombuffer(text, np.uint8)
    breaks = np.flatnonzero(characters <= SPACE)
    spaces, ends = breaks[0::2], breaks[1::2]
    if (characters[spaces] != SPACE).any() or (characters[ends] != NEWLINE).any():
        return None
    words = text.decode("ascii").split()
    starts = np.concatenate([[0], ends + 1])[: len(ends)]
    if len(words) != len(breaks) or (characters[spaces + 1] == SLASH).any():
        return None
    times_ns = _times_ns(characters, starts, spaces)
    return None if times_ns is None else (times_ns, words[1::2])


def _end_of_comments(data: bytes) -> int | None:
    """Return where the first line without ``#`` begins; None where a comment hides a line."""
    start = 0
    while data.startswith(b"#", start):
        start = data.find(b"\n", start) + 1 or len(data)
    comments = data[:start].decode("utf-8", "replace")
    n_lines = comments.count("\n") + (not comments.endswith("\n"))
    return start if len(comments.splitlines()) == n_lines or not comments else None


def _times_ns(characters: UInt8Array, starts: IntArray, ends: IntArray) -> IntArray | None:
    """Return the decimal seconds between the places as ns; None where one is no plain number."""
    all_dots = np.append(np.flatnonzero(characters == DOT), len(characters))
    dots = all_dots[np.searchsorted(all_dots, starts)]
    n_whole, n_decimals = dots - starts, ends - dots - 1
    if ((n_whole < 1) | (n_whole > N_WHOLE) | (n_decimals < 0) | (n_decimals > N_DECIMALS)).any():
        return None
    whole_s = _digit_sum(characters, dots - 1, -1, n_whole)
    decimals_ns = _digit_sum(characters, dots + 1, 1, n_decimals)
    if whole_s is None or decimals_ns is None:
        return None
    return None if (whole_s >= GREATEST_S).any() else whole_s * NS_PER_S + decimals_ns


def _digit_sum(
    characters: UInt8Array, first: IntArray, step: int, n_digits: IntArray
) -> IntArray | None:
    """Return the value of the digits left (-1) or, as decimals, right (+1) of a point."""
    sums = np.zeros(len(first), np.int64)
    for k in range(int(n_digits.max(initial=0))):
        digits = characters.take(first + step * k, mode="clip").astype(np.int64) - ZERO
        digits[n_digits <= k] = 0
        if ((digits < 0) | (digits > NINE)).any():
            return None
        sums += digits * 10 ** (k if step < 0 else N_DECIMALS - 1 - k)
    return sums
