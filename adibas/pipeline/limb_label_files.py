"""The labels of a recording's frames in a folder: images to train on, and work to go on with.

Frames that are done are images as `adibas limbs train` reads them; what is still being worked on
lies beside them under another name, so that training never sees it. `progress.json` says whose
frames they are and which are done: work goes on after a restart, also in a folder that `adibas
limbs segment` has written.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from adibas.arrays import AnyArray, UInt8Array, UInt16Array
from adibas.data.limbs import labels_named
from adibas.errors import LimbError
from adibas.files import DAMAGED_JSON, check_document, is_there, remove_file, written_whole
from adibas.limbs.training_set import (
    DEPTH,
    HEADER,
    LABELS,
    FolderHeader,
    decoded_png,
    read_header,
    write_header,
    write_image,
)

PROGRESS, DRAFT = "progress.json", ".draft.png"
FORMAT, VERSION = "adibas-limb-labelling", 1


@dataclass(frozen=True, slots=True)
class LabellingProgress:
    """How far the work is.

    Attributes
    ----------
    n_frames : int
        Of the recording.
    done, begun : frozenset of int
        Frames that are ready to train on; frames with labels that are not.
    """

    n_frames: int
    done: frozenset[int] = frozenset()
    begun: frozenset[int] = frozenset()

    def next_open(self, index: int) -> int | None:
        """Return the next frame after `index`, then from the first on, that is not done."""
        order = (*range(index + 1, self.n_frames), *range(index + 1))
        return next((one for one in order if one not in self.done), None)


class LabelFiles:
    """The folder of one recording; every file in it appears whole.

    Parameters
    ----------
    folder : Path
        It may exist.
    recording : str
        Name of the recording: a folder belongs to one.
    n_frames : int
    size : (height, width)
        Of its depth images.
    header : FolderHeader
        Of a new folder; a folder that exists keeps its own labels.

    Raises
    ------
    LimbError
        The folder is of another recording or another camera, or cannot be read.
    """

    def __init__(
        self,
        folder: Path,
        recording: str,
        n_frames: int,
        size: tuple[int, int],
        header: FolderHeader,
    ) -> None:
        self.folder = folder
        self.recording = recording
        self._n_frames = n_frames
        self._size = size
        self._header = _header_of(folder, header)
        self.labels = labels_named(self._header.labels)
        self._done = _read_done(folder, recording)

    @property
    def progress(self) -> LabellingProgress:
        """Return how far the work is, by the files that are there."""
        labelled = _numbers(self.folder, LABELS)
        done = self._done & labelled
        begun = (labelled | _numbers(self.folder, DRAFT)) - done
        return LabellingProgress(self._n_frames, done, begun)

    def kept(self, index: int) -> UInt8Array | None:
        """Return the (H, W) labels that are kept of a frame; None where there are none.

        Raises
        ------
        LimbError
            The image is damaged or of another size.
        """
        for ending in (DRAFT, LABELS):
            path = self.folder / f"{_name_of(index)}{ending}"
            if is_there(path):
                return self._read(path)
        return None

    def _read(self, path: Path) -> UInt8Array:
        image = decoded_png(np.fromfile(path, np.uint8))
        if image is None or image.shape != self._size or image.dtype != np.uint8:
            raise LimbError(
                "{file} in {folder} is damaged, or of another size than the recording. Remove it.",
                file=path.name,
                folder=self.folder.name,
            )
        labels: UInt8Array = np.asarray(image, np.uint8)
        labels[labels > len(self.labels)] = 0
        return labels

    def keep(
        self, index: int, depth_raw: UInt16Array, labels: UInt8Array, *, is_done: bool
    ) -> None:
        """Keep the labels of a frame: as an image to train on, or as work to go on with.

        What was kept before is removed last: a crash leaves one of the two.

        Raises
        ------
        FileError
            The folder cannot be written.
        """
        name = _name_of(index)
        self._begin()
        if is_done:
            write_image(self.folder, name, depth_raw, labels)
        else:
            payload: AnyArray = cv2.imencode(".png", labels)[1]
            with written_whole(self.folder / f"{name}{DRAFT}") as unfinished:
                unfinished.write_bytes(payload.tobytes())
        self._note_done(self._done | {index} if is_done else self._done - {index})
        for ending in (DRAFT,) if is_done else (LABELS, DEPTH):
            remove_file(self.folder / f"{name}{ending}")

    def is_labelled(self, index: int) -> bool:
        """Say whether a frame has labels, done or begun."""
        name = _name_of(index)
        return any(is_there(self.folder / f"{name}{ending}") for ending in (DRAFT, LABELS))

    def add_found(self, index: int, depth_raw: UInt16Array, labels: UInt8Array) -> None:
        """Write labels that nobody has looked at: an image to train on, and a frame begun.

        Raises
        ------
        FileError
            The folder cannot be written.
        """
        self._begin()
        # What is done stays in the hands of who labels there at the same time.
        if not is_there(self.folder / PROGRESS):
            self._note_done(self._done)
        write_image(self.folder, _name_of(index), depth_raw, labels)

    def _begin(self) -> None:
        if not is_there(self.folder / HEADER):
            write_header(self.folder, self._header)

    def _note_done(self, done: frozenset[int]) -> None:
        document = {
            "format": FORMAT,
            "version": VERSION,
            "recording": self.recording,
            "n_frames": self._n_frames,
            "done": sorted(done),
        }
        with written_whole(self.folder / PROGRESS) as unfinished:
            unfinished.write_text(json.dumps(document), "utf-8")
        self._done = done


def _header_of(folder: Path, wanted: FolderHeader) -> FolderHeader:
    if not is_there(folder / HEADER):
        return wanted
    found = read_header(folder)
    if not np.allclose(_optics(found), _optics(wanted), rtol=1e-6):
        raise LimbError(
            "{folder} holds images of another camera. Choose another folder.",
            folder=folder.name,
        )
    return found


def _optics(header: FolderHeader) -> tuple[float, ...]:
    return header.depth_unit_m, header.fx, header.fy, header.cx, header.cy


def _name_of(index: int) -> str:
    return f"{index:05d}"


def _numbers(folder: Path, ending: str) -> frozenset[int]:
    names = (path.name.removesuffix(ending) for path in folder.glob(f"*{ending}"))
    return frozenset(int(name) for name in names if name.isdecimal())


def _read_done(folder: Path, name: str) -> frozenset[int]:
    """Return the frames that are done."""
    path = folder / PROGRESS
    if not is_there(path):
        return frozenset()
    try:
        document: Any = json.loads(path.read_text("utf-8"))
        check_document(document, FORMAT, VERSION)
        of, done = str(document["recording"]), frozenset(map(int, document["done"]))
    except (OSError, KeyError, TypeError, AttributeError, OverflowError, *DAMAGED_JSON) as error:
        raise _damaged(folder) from error
    if of != name:
        raise LimbError(
            "{folder} holds labels of {recording}. Choose another folder for this recording.",
            folder=folder.name,
            recording=of,
        )
    return done


def _damaged(folder: Path) -> LimbError:
    return LimbError(
        "progress.json in {folder} is damaged. Remove it: the labels stay, and each frame must "
        "be looked at again.",
        folder=folder.name,
    )
