"""Folders of labelled depth images: ``NNNN.depth.png``, ``NNNN.labels.png`` and ``labels.json``.

Depth is 16 bit in units of `depth_unit_m`, 0 = no reading; labels are 8 bit, 0 = background, label
k of the list is value k + 1. ``people`` in ``labels.json`` says who is in an image, by its number.
"""

import hashlib
import json
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from adibas.arrays import AnyArray, Float32Array, IntArray, UInt8Array, UInt16Array
from adibas.data.joints import mirror_order
from adibas.errors import LimbError
from adibas.files import DAMAGED_JSON, written_whole
from adibas.forests.samples import TrainingImages

HEADER = "labels.json"
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
PNG_HEAD = struct.Struct(">8s8xII")
PNG_CHUNK, PNG_SUM_BYTES, PNG_END = struct.Struct(">I4s"), 4, b"IEND"
MOST_PIXELS_PER_BYTE = 1032
"""Of a packed image: zlib cannot do more."""

DEPTH, LABELS = ".depth.png", ".labels.png"


@dataclass(frozen=True, slots=True)
class FolderHeader:
    """What holds for all images of a folder.

    Attributes
    ----------
    labels : tuple of str
    depth_unit_m, fx, fy, cx, cy : float
    people : mapping
        From the name of an image (``0001``) to who is in it.
    source : mapping
        How it was made; plain JSON values.
    """

    labels: tuple[str, ...]
    depth_unit_m: float
    fx: float
    fy: float
    cx: float
    cy: float
    people: Mapping[str, str] = field(default_factory=dict)
    source: Mapping[str, object] = field(default_factory=dict)


def write_header(folder: Path, header: FolderHeader) -> None:
    """Write ``labels.json``.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    document = {name: getattr(header, name) for name in FolderHeader.__slots__}
    with written_whole(folder / HEADER) as unfinished:
        unfinished.write_text(json.dumps(document, indent=1), "utf-8")


def read_header(folder: Path) -> FolderHeader:
    """Read ``labels.json``.

    Raises
    ------
    LimbError
        It is missing, damaged, or lacks something.
    """
    try:
        document: Any = json.loads((folder / HEADER).read_text("utf-8"))
        header = FolderHeader(
            tuple(str(name) for name in document["labels"]),
            float(document["depth_unit_m"]),
            float(document["fx"]),
            float(document["fy"]),
            float(document["cx"]),
            float(document["cy"]),
            {str(name): str(who) for name, who in document.get("people", {}).items()},
            dict(document.get("source", {})),
        )
    except OSError as error:
        raise LimbError(
            "{folder} has no labels.json. Choose a folder of labelled depth images.",
            folder=folder.name,
        ) from error
    except (KeyError, TypeError, AttributeError, OverflowError, *DAMAGED_JSON) as error:
        raise LimbError(
            "labels.json in {folder} cannot be used: labels, depth_unit_m, fx, fy, cx and cy must "
            "be in it.",
            folder=folder.name,
        ) from error
    if not header.labels or not all(0 < one < math.inf for one in (header.fx, header.depth_unit_m)):
        raise LimbError(
            "labels.json in {folder} cannot be used: it has no labels, or fx or depth_unit_m is "
            "not above zero.",
            folder=folder.name,
        )
    return header


def write_image(folder: Path, name: str, depth: UInt16Array, labels: UInt8Array) -> None:
    """Write one image; the labels last, so that an image with labels is whole.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    for ending, image in ((DEPTH, depth), (LABELS, labels)):
        payload: AnyArray = cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1]
        with written_whole(folder / f"{name}{ending}") as unfinished:
            unfinished.write_bytes(payload.tobytes())


def decoded_png(payload: UInt8Array) -> AnyArray | None:
    """Return the image in a PNG file; None where it is damaged.

    A head or chunk that promises more than its file can hold is not believed: room for it would be
    taken, and that of a chunk is up to 4 GB.
    """
    head = payload[: PNG_HEAD.size].tobytes()
    if len(head) < PNG_HEAD.size:
        return None
    signature, width, height = PNG_HEAD.unpack(head)
    if signature != PNG_SIGNATURE or width * height > MOST_PIXELS_PER_BYTE * payload.size:
        return None
    if not _has_all_chunks(payload):
        return None
    try:
        image: AnyArray | None = cv2.imdecode(payload, cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None
    return image


def _has_all_chunks(payload: UInt8Array) -> bool:
    """Say whether every chunk of a PNG file lies in it, up to the last."""
    data, at, kind = payload.data, len(PNG_SIGNATURE), b""
    while at + PNG_CHUNK.size <= len(data) and kind != PNG_END:
        length, kind = PNG_CHUNK.unpack_from(data, at)
        at += PNG_CHUNK.size + length + PNG_SUM_BYTES
    return kind == PNG_END and at <= len(data)


class LimbFolder:
    """The images of a folder, read when they are needed.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    LimbError
        There is no such folder, no image in it, or its header is broken.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.header = read_header(folder)
        self.names = tuple(
            sorted(path.name.removesuffix(LABELS) for path in folder.glob(f"*{LABELS}"))
        )
        if not self.names:
            raise LimbError(
                "{folder} holds no NNNN.labels.png. Choose a folder of labelled depth images.",
                folder=folder.name,
            )

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the names of the labels."""
        return self.header.labels

    @property
    def people(self) -> tuple[str, ...]:
        """Return who is in each image.

        Raises
        ------
        LimbError
            Of an image the header does not say it.
        """
        for name in self.names:
            if name not in self.header.people:
                raise LimbError(
                    "labels.json in {folder} does not say who is in image {name}. Name the person "
                    "of each image there, under people, or leave out folds.",
                    folder=self._folder.name,
                    name=name,
                )
        return tuple(self.header.people[name] for name in self.names)

    def sha256(self) -> str:
        """Return a fingerprint of the images: of their names and the files of their labels.

        Raises
        ------
        LimbError
            A file cannot be read.
        """
        total = hashlib.sha256()
        for name in self.names:
            payload = self._payload(f"{name}{LABELS}").tobytes()
            total.update(f"{name} {hashlib.sha256(payload).hexdigest()}\n".encode())
        return total.hexdigest()

    def __len__(self) -> int:
        return len(self.names)

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return (H, W) metres with NaN, (H, W) labels 1 to L or 0, and focal_px.

        Raises
        ------
        LimbError
            An image is missing or damaged, or has labels that the header does not name.
        """
        name = self.names[index]
        depth, labels = self._image(name, DEPTH), self._image(name, LABELS)
        is_fit = depth.dtype == np.uint16 and labels.dtype == np.uint8
        if not is_fit or depth.ndim != 2 or depth.shape != labels.shape:  # noqa: PLR2004
            raise LimbError(
                "Image {name} in {folder} does not fit: depth must have 16 bits, labels 8, and "
                "both one size.",
                name=name,
                folder=self._folder.name,
            )
        if labels.max(initial=0) > len(self.labels):
            raise LimbError(
                "Image {name} in {folder} has label {value}, and labels.json names {n}.",
                name=name,
                folder=self._folder.name,
                value=int(labels.max()),
                n=len(self.labels),
            )
        depth_m = depth.astype(np.float32) * np.float32(self.header.depth_unit_m)
        depth_m[depth == 0] = np.nan
        return depth_m, labels, self.header.fx

    def _image(self, name: str, ending: str) -> AnyArray:
        image = decoded_png(self._payload(f"{name}{ending}"))
        if image is None:
            raise LimbError(
                "{file} in {folder} is damaged. Remove it and its labels, or copy it again.",
                file=f"{name}{ending}",
                folder=self._folder.name,
            )
        return image

    def _payload(self, file: str) -> UInt8Array:
        try:
            return np.fromfile(self._folder / file, np.uint8)
        except OSError as error:
            raise LimbError(
                "{file} is missing in {folder}. Copy the folder again.",
                file=file,
                folder=self._folder.name,
            ) from error


def check_people(images: TrainingImages, least_pixels: int = 1) -> None:
    """See that an image has so many labelled pixels with depth: something can be learned.

    Raises
    ------
    LimbError
        None has, or an image cannot be read.
    """
    for index in range(len(images)):
        depth_m, labels, _ = images.read(index)
        if np.count_nonzero(np.isfinite(depth_m[labels > 0])) >= least_pixels:
            return
    raise nobody_with_depth()


def nobody_with_depth() -> LimbError:
    """Return what is told of images that nothing can be learned from."""
    return LimbError("Nobody with depth is in the images. Choose other images.")


class Chosen:
    """Some images of a set.

    Parameters
    ----------
    images : TrainingImages
    indices : sequence of int
    """

    def __init__(self, images: TrainingImages, indices: Sequence[int] | IntArray) -> None:
        self._images, self._indices = images, np.asarray(indices, np.int64)

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the names of the labels."""
        return self._images.labels

    def __len__(self) -> int:
        return len(self._indices)

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return image `index` of those chosen."""
        return self._images.read(int(self._indices[index]))


class Mirrored:
    """A set and, behind it, each of its images as a mirror shows it, left and right exchanged.

    Parameters
    ----------
    images : TrainingImages
        Of what is as likely the other way round.
    """

    def __init__(self, images: TrainingImages) -> None:
        self._images = images
        order = mirror_order(images.labels)
        self._value = np.array([0, *(place + 1 for place in order)], np.uint8)

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the names of the labels."""
        return self._images.labels

    def __len__(self) -> int:
        return 2 * len(self._images)

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return image `index`; from the number of images on, mirrored."""
        depth_m, labels, focal_px = self._images.read(index % len(self._images))
        if index < len(self._images):
            return depth_m, labels, focal_px
        other = np.ascontiguousarray(self._value[labels[:, ::-1]])
        return np.ascontiguousarray(depth_m[:, ::-1]), other, focal_px


class Relabelled:
    """A set with fewer labels.

    Parameters
    ----------
    images : TrainingImages
    labels : tuple of str
        The new names.
    onto : mapping
        The new name of each old one; one that is missing keeps its own.
    """

    def __init__(
        self, images: TrainingImages, labels: tuple[str, ...], onto: Mapping[str, str]
    ) -> None:
        self._images = images
        self.labels = labels
        values = [labels.index(onto.get(name, name)) + 1 for name in images.labels]
        self._value = np.array([0, *values], np.uint8)

    def __len__(self) -> int:
        return len(self._images)

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return image `index` with the new labels."""
        depth_m, labels, focal_px = self._images.read(index)
        return depth_m, self._value[labels], focal_px


TO_TORSO = dict.fromkeys(
    (
        *("head", "neck"),
        *(
            f"{side}_{part}"
            for side in ("left", "right")
            for part in ("upper_leg", "lower_leg", "foot")
        ),
    ),
    "torso",
)
"""What the thesis' seven labels call everything but the arms."""
