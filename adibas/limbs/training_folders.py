"""Several folders of labelled depth images as one set: a clinic labels one recording a folder."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path

from adibas.arrays import Float32Array, UInt8Array
from adibas.errors import LimbError
from adibas.limbs.training_set import LimbFolder


class LimbFolders:
    """The images of folders, one folder behind the other, read when they are needed.

    Parameters
    ----------
    folders : sequence of Path
        One at least. Who is named alike in two of them is the same person.

    Attributes
    ----------
    titles : tuple of str
        What each folder is called, without where it lies.

    Raises
    ------
    LimbError
        There is no such folder, no image in it, or its header is broken; one has other labels than
        the first, or is named twice.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self._parts = tuple(LimbFolder(one) for one in folders)
        self._ends = tuple(accumulate(len(one) for one in self._parts))
        self.titles = tuple(one.name for one in folders)
        for folder, part in zip(folders, self._parts, strict=True):
            if part.labels != self.labels:
                raise LimbError(
                    "{folder} has other labels than {first}. Choose folders with the same labels.",
                    folder=folder.name,
                    first=folders[0].name,
                )
        places = [one.resolve() for one in folders]
        for folder, place in zip(folders, places, strict=True):
            if places.count(place) > 1:
                raise LimbError(
                    "{folder} is named twice. Name each folder once.", folder=folder.name
                )

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the names of the labels."""
        return self._parts[0].labels

    @property
    def names(self) -> tuple[str, ...]:
        """Return a name for each image, of several folders with the folder's place and name."""
        if len(self._parts) == 1:
            return self._parts[0].names
        parts = enumerate(zip(self.titles, self._parts, strict=True), 1)
        return tuple(f"{i}-{title}-{name}" for i, (title, part) in parts for name in part.names)

    @property
    def people(self) -> tuple[str, ...]:
        """Return who is in each image.

        Raises
        ------
        LimbError
            Of an image its folder does not say it.
        """
        return tuple(who for part in self._parts for who in part.people)

    def sha256s(self) -> tuple[str, ...]:
        """Return the fingerprint of each folder's images.

        Raises
        ------
        LimbError
            A file cannot be read.
        """
        return tuple(part.sha256() for part in self._parts)

    def __len__(self) -> int:
        return self._ends[-1]

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return (H, W) metres with NaN, (H, W) labels 1 to L or 0, and focal_px.

        Raises
        ------
        LimbError
            An image is missing or damaged, or has labels that the header does not name.
        """
        part = bisect_right(self._ends, index)
        before = self._ends[part - 1] if part else 0
        return self._parts[part].read(index - before)


def folders_of(folders: Sequence[Path]) -> LimbFolders | None:
    """Return the images of folders; None where there are none, and images are simulated."""
    return LimbFolders(folders) if folders else None
