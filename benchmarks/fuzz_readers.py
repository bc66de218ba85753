"""How each kind of file is read, all of it, as the program would."""

import struct
import tempfile
import warnings
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from adibas.calibration.files import read_calibration
from adibas.errors import RecordingError
from adibas.exchange.servers import read_servers
from adibas.forests.files import load_forest
from adibas.gestures.model_file import read_model as read_gestures
from adibas.limbs.training_set import LimbFolder
from adibas.markers.color_files import read_colors
from adibas.measures.protocol_file import check_protocol
from adibas.pipeline.calibrating import read_images
from adibas.pipeline.labels import read_labels
from adibas.pipeline.learning import read_picture
from adibas.pipeline.limb_label_files import LabelFiles
from adibas.pipeline.pose_model import read_joint_model
from adibas.recordings import open_recording
from adibas.recordings.codings import read_codings
from adibas.recordings.decoding import decode_color, to_rgbd
from adibas.recordings.ethogram_json import read_ethogram
from adibas.recordings.events_csv import read_events_csv
from adibas.recordings.joints_csv import read_joints_csv
from adibas.recordings.messages import read_color, read_depth
from adibas.sessions.backup_format import BackupReader
from adibas.sessions.key_file import read_key_file
from adibas.sessions.restoring import extract
from adibas.skeleton.model_files import read_model
from adibas.skeleton.namer import Namer
from adibas.skeleton.points_csv import read_points
from benchmarks import fuzz_model_seeds as models
from benchmarks import fuzz_seeds as seeds

MOST_FRAMES = 50
LONGEST_NAME = 200
LENGTH = struct.Struct("<I")
STANDING_M = np.array([
    [0.02, -0.64, -0.1], [0.0, -0.44, 0.0], [0.17, -0.4, 0.01], [-0.17, -0.41, 0.0],
    [0.22, -0.11, 0.02], [-0.2, -0.12, 0.05], [0.24, 0.12, -0.07], [0.01, -0.15, -0.1],
    [0.1, 0.03, -0.08], [-0.1, 0.03, -0.09], [0.12, 0.47, -0.03], [-0.1, 0.46, -0.04],
    [0.1, 0.86, -0.01], [-0.12, 0.87, 0.02], [0.4, 0.3, 0.2],
])  # fmt: skip
"""Head, neck, shoulders, elbows, a left hand, torso, hips, knees, feet, and a chance point."""


def recording(path: Path) -> None:
    """Read every frame."""
    with open_recording(path) as reader:
        if len(reader) != len(reader.timestamps_ns):
            raise ValueError("not as many frames as times")
        for index in range(min(len(reader), MOST_FRAMES)):
            to_rgbd(reader.read(index), reader.info)


def messages(path: Path) -> None:
    """Read one message; its first byte says which kind it is."""
    data = path.read_bytes()
    kind = seeds.MESSAGES[data[0] % len(seeds.MESSAGES)] if data else "rvl"
    try:
        if kind in ("rvl", "raw"):
            read_depth("adibas.RvlImage" if kind == "rvl" else "foxglove.RawImage", data[1:])
        else:
            decode_color(read_color(data[1:]), 0)
    except ValueError as error:  # as `McapReader` takes it for a damaged frame
        raise RecordingError("{file} is damaged.", file=path.name) from error


def codings(path: Path) -> None:
    """Read a coding."""
    read_codings(path, seeds.CODING.ethogram if path.suffix == ".tsv" else None)


def excel_parts(path: Path) -> None:
    """Read a workbook made of parts, whose sums are right."""
    archive = path.with_suffix(".xlsx")
    _pack(path, archive)
    read_codings(archive)


def forest_parts(path: Path) -> None:
    """Read a forest made of arrays, whose sums are right."""
    archive = path.with_suffix(".npz")
    _pack(path, archive)
    load_forest(archive)


def backup(path: Path) -> None:
    """Unpack a backup."""
    with tempfile.TemporaryDirectory() as folder, BackupReader(path) as opened:
        extract(opened, opened.key(seeds.PASSPHRASE), Path(folder))


def backup_pieces(path: Path) -> None:
    """Unpack a backup whose pieces are sealed as they should be."""
    sealed = path.with_suffix(".backup")
    seeds.sealed_backup(sealed, _pieces(path.read_bytes()))
    with tempfile.TemporaryDirectory() as folder, BackupReader(sealed) as opened:
        extract(opened, seeds.KEY, Path(folder))


def core_and_limbs(path: Path) -> None:
    """Read a skeleton model that has them, and name the points of somebody who stands."""
    whole = path.with_suffix(".whole")
    whole.write_bytes(models.in_a_skeleton(path.read_bytes()))
    namer = Namer(read_model(whole))
    if namer.knows(3):
        namer.holding_still().label(STANDING_M, "anterior")


def limb_folder(path: Path) -> None:
    """Open a folder of labelled limbs to train with, and to go on labelling in."""
    images = LimbFolder(path)
    for index in range(len(images)):
        images.read(index)
    LabelFiles(path, "a.mcap", 2, models.LIMB_SIZE, images.header).kept(0)


def board_picture(path: Path) -> None:
    """Read a picture of a board."""
    for _image in read_images([path]):
        pass


def _pack(path: Path, archive: Path) -> None:
    pieces = iter(list(_pieces(path.read_bytes())))
    with warnings.catch_warnings(), zipfile.ZipFile(archive, "w") as parts:
        warnings.simplefilter("ignore")  # of names that are there twice
        for name in pieces:
            told = name[:LONGEST_NAME].decode("latin-1").replace("\0", "")
            parts.writestr(told or "a", next(pieces, b""))


def _pieces(data: bytes) -> Iterator[bytes]:
    while len(data) >= LENGTH.size:
        (length,) = LENGTH.unpack(data[: LENGTH.size])
        yield data[LENGTH.size : LENGTH.size + length]
        data = data[LENGTH.size + length :]


ethogram = read_ethogram
events = read_events_csv
joints = read_joints_csv
points = read_points
calibration = read_calibration
picture = read_picture
protocol = check_protocol
gesture_model = read_gestures
forest = load_forest
skeleton_model = read_model
joint_model = read_joint_model
colors = read_colors
servers = read_servers
key_file = read_key_file
names_of_markers = read_labels
