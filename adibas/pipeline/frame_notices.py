"""What was said of single frames, counted for the whole recording."""

from collections.abc import Iterable

from adibas.data.sentence import Sentence
from adibas.texts import message

IN_FRAMES = message("{notice} (In {n} of {total} frames.)")


def counted(said: Iterable[tuple[str, int]], total: int) -> tuple[Sentence, ...]:
    """Return a sentence for each text with the number of frames, out of `total`, it holds for."""
    return tuple(Sentence(IN_FRAMES, {"notice": text, "n": n, "total": total}) for text, n in said)
