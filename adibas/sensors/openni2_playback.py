"""Which images of a played .oni file are the next ones; OpenNI2's player loses some now and then.

The player goes on by one image each time it is asked, but OpenNI2 may ask twice and then keeps
the later image only. A file that knows its length is therefore played round after round, and an
image out of order is left for the next round.
"""

from collections.abc import Mapping

from adibas.errors import SensorError
from adibas.sensors.ports import StreamName

MAX_ROUNDS = 4
"""More than one lost image in a file was never seen, even on a busy machine."""


class Playback:
    """Keeps count of a file's images.

    Parameters
    ----------
    file : str
        Name for messages.
    n_images : mapping
        Of every stream, as the file says; 0 where it was cut by a crash and does not know.
    """

    def __init__(self, file: str, n_images: Mapping[StreamName, int]) -> None:
        self._file = file
        self._n_images = dict(n_images)
        self._n_taken = dict.fromkeys(n_images, 0)
        self._n_refused = 0
        self._is_silent = False
        self.knows_its_length = all(n > 0 for n in n_images.values())

    @property
    def is_over(self) -> bool:
        """True when every image was taken, or when no more came from a cut file."""
        return self._is_silent or (self.knows_its_length and self._n_missing() <= 0)

    def accepts(self, name: StreamName, index: int) -> bool:
        """Tell whether image `index` (as counted in the file, from 1) is the next of its stream.

        Raises
        ------
        SensorError
            The next image does not come, round after round: the file is damaged.
        """
        is_numbered = 1 <= index <= self._n_images[name]
        if self.knows_its_length and is_numbered and index != self._n_taken[name] + 1:
            self._n_refused += 1
            if self._n_refused > MAX_ROUNDS * sum(self._n_images.values()):
                raise self._damage()
            return False
        self._n_taken[name] += 1
        return True

    def give_up(self) -> None:
        """Take silence for the end of a cut file; of any other it is damage."""
        if self.knows_its_length:
            raise self._damage()
        self._is_silent = True

    def _n_missing(self) -> int:
        return sum(self._n_images.values()) - sum(self._n_taken.values())

    def _damage(self) -> SensorError:
        return SensorError(
            "{file} is damaged: {n_missing} of its images are not found. Convert it with "
            "adibas convert, which keeps every whole frame.",
            file=self._file,
            n_missing=self._n_missing(),
        )
