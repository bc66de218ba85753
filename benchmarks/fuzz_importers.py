"""Everything that reads a file which somebody else may have written, and whole files for each."""

import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from adibas.errors import AdibasError
from benchmarks import fuzz_model_seeds as models
from benchmarks import fuzz_readers as readers
from benchmarks import fuzz_seeds as seeds

Outcome = Literal["read", "refused"]


@dataclass(frozen=True, slots=True)
class Importer:
    """One kind of file.

    Attributes
    ----------
    name : str
        Of the kind.
    file : str
        What a file is called; below a folder that is opened, where there is a ``/``.
    make : callable
        Writes a whole file (or folder) to a path; called once for each of `variants`.
    read : callable
        Reads all of a path.
    variants : tuple of str
        What `make` is told.
    is_text : bool
        Whether values may stand in place of others.
    """

    name: str
    file: str
    make: Callable[[Path, str], None]
    read: Callable[[Path], object]
    variants: tuple[str, ...] = ("",)
    is_text: bool = True

    def opened(self, folder: Path) -> Path:
        """Return what is opened: the file, or the folder that it lies in."""
        return folder / self.file.partition("/")[0]


TUM_FILES = ("depth.txt", "rgb.txt", "calibration.json", "adibas.json")
IMPORTERS = (
    Importer("mcap", "a.mcap", seeds.recording, readers.recording, ("jpeg", "array"), False),
    Importer("oni", "a.oni", seeds.recording, readers.recording, ("jpeg", "array"), False),
    Importer("mcap messages", "a.bin", seeds.messages, readers.messages, seeds.MESSAGES, False),
    *(Importer(f"tum {n}", f"tum/{n}", seeds.tum, readers.recording) for n in TUM_FILES),
    Importer("tum depth image", "tum/depth/*.png", seeds.tum, readers.recording, is_text=False),
    Importer("tum colour image", "tum/rgb/*.png", seeds.tum, readers.recording, is_text=False),
    Importer("boris", "a.boris", seeds.coding, readers.codings),
    Importer("boris table", "a.tsv", seeds.coding, readers.codings),
    Importer("elan", "a.eaf", seeds.coding, readers.codings),
    Importer("coding csv", "a.csv", seeds.coding, readers.codings),
    Importer("coding excel", "a.xlsx", seeds.coding, readers.codings, is_text=False),
    Importer("coding excel parts", "a.parts", seeds.excel_parts, readers.excel_parts),
    Importer("ethogram", "a.json", seeds.ethogram, readers.ethogram),
    Importer("events", "a.csv", seeds.events, readers.events),
    Importer("joints", "a.joints.csv", seeds.joints, readers.joints),
    Importer("point sets", "a.csv", seeds.points, readers.points),
    Importer("calibration", "a.json", seeds.calibration, readers.calibration),
    Importer(
        "foreign calibration", "a.yml", seeds.foreign_calibration, readers.calibration,
        ("opencv.yml", "opencv.xml", "ros"),
    ),
    Importer("picture of a board", "a.png", seeds.picture, readers.board_picture, is_text=False),
    Importer("protocol", "a.json", models.protocol, readers.protocol),
    Importer("gesture model", "a.json", models.gesture_model, readers.gesture_model),
    Importer("limb model", "a.npz", models.forest, readers.forest, is_text=False),
    Importer("limb model arrays", "a.parts", models.forest_parts, readers.forest_parts,
             is_text=False),
    Importer("skeleton model", "a.json", models.skeleton_model, readers.skeleton_model),
    Importer("core and limbs", "a.json", models.core_and_limbs, readers.core_and_limbs),
    Importer("joint model", "a.json", models.joint_model, readers.joint_model),
    Importer("marker colours", "a.json", models.colors, readers.colors),
    Importer("picture of markers", "a.jpg", seeds.picture, readers.picture, is_text=False),
    Importer("servers", "a.json", seeds.servers, readers.servers),
    Importer("backup", "a.backup", seeds.backup, readers.backup, is_text=False),
    Importer("backup pieces", "a.pieces", seeds.backup_pieces, readers.backup_pieces,
             is_text=False),
    Importer("labelled limbs", "limbs/labels.json", models.limb_folder, readers.limb_folder),
    Importer("progress of labelling", "limbs/progress.json", models.limb_folder,
             readers.limb_folder),
    Importer("image of limbs", "limbs/*.labels.png", models.limb_folder, readers.limb_folder,
             is_text=False),
    Importer("names of markers", "a.csv", models.names_of_markers, readers.names_of_markers),
    Importer("key file", "store/key.json", seeds.key_file, readers.key_file),
)  # fmt: skip


def importer_named(name: str) -> Importer:
    """Return the importer of that name."""
    return next(one for one in IMPORTERS if one.name == name)


class Trial:
    """A folder in which one importer is given file after file.

    Attributes
    ----------
    whole : tuple of bytes
        Files that it reads.
    """

    def __init__(self, importer: Importer) -> None:
        self._importer = importer
        self._closing = ExitStack()
        self._folder = Path(self._closing.enter_context(tempfile.TemporaryDirectory()))
        found = []
        for variant in importer.variants:
            importer.make(importer.opened(self._folder), variant)
            found.append(self._victim().read_bytes())
        self.whole = tuple(found)

    def give(self, data: bytes) -> Outcome:
        """Let the importer read `data`; anything but reading or refusing it is raised."""
        self._victim().write_bytes(data)
        try:
            self._importer.read(self._importer.opened(self._folder))
        except AdibasError as error:
            str(error)  # its fields are all there
            return "refused"
        return "read"

    def close(self) -> None:
        """Remove the folder."""
        self._closing.close()

    def _victim(self) -> Path:
        if "*" in self._importer.file:
            return next(iter(sorted(self._folder.glob(self._importer.file))))
        return self._folder / self._importer.file
