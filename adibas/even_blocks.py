"""How a loop over many things is parted between the cores."""

from adibas.kernels import compiled


@compiled
def even_blocks(n_all: int, most: int) -> tuple[int, int]:
    """Return into how many blocks of which size to part work; `most` is the largest one's size.

    Two cores get as many blocks each, all of one size but for what the last ones lack: where the
    second of two blocks is small, one core waits for the other.
    """
    n_blocks = (n_all + most - 1) // most
    if n_blocks > 1:
        n_blocks += n_blocks % 2
    return n_blocks, (n_all + n_blocks - 1) // max(n_blocks, 1)
