"""Whole files of every kind, small enough that a change hits heads and lengths often."""

import io
import shutil
import struct
import zipfile
from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from adibas.calibration.files import write_calibration
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.coding import Coding, Occurrence, Section
from adibas.data.ethogram import Behaviour, Ethogram, Modifier, Subject
from adibas.data.events import TimedEvent
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.data.skeleton_track import SkeletonTrack
from adibas.exchange.servers import DicomServer, write_servers
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.recordings import RecordingOptions, create_recording
from adibas.recordings.boris_tables import write_boris_table
from adibas.recordings.boris_writing import write_boris
from adibas.recordings.coding_csv import write_coding_csv
from adibas.recordings.elan_writing import write_elan
from adibas.recordings.ethogram_json import write_ethogram
from adibas.recordings.events_csv import write_events_csv
from adibas.recordings.joints_csv import write_joints_csv
from adibas.recordings.messages import Stamp, compressed_image, raw_image, rvl_image
from adibas.reports.coding_excel import write_coding_excel
from adibas.sessions.backup_format import PIECE_BYTES, BackupWriter, header_of
from adibas.sessions.key_file import KeyFile, write_key_file
from adibas.sessions.key_wrapping import Argon2Params
from adibas.sessions.keys import behind_passphrase
from adibas.skeleton.points_csv import PointSet, write_points

MESSAGES = ("rvl", "raw", "jpeg", "png")
PASSPHRASE = "of files that are thrown away"  # noqa: S105
KEY = bytes(range(32))
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)
LENGTH = struct.Struct("<I")
SHAPE = (12, 16)
CALIBRATION = RgbdCalibration(
    color=CameraCalibration(32, 24, Intrinsics(30.5, 31.5, 15.25, 11.75), (0.1, -0.2, 0, 0, 0)),
    depth=CameraCalibration(16, 12, Intrinsics(14.1, 14.2, 7.5, 5.5)),
    color_from_depth=RigidTransform(np.eye(3), np.array([0.025, 0.0, 0.0])),
    depth_unit_m=0.0001,
    depth_bias=DepthBias(0.001, 1.01, 0.002, (1e-3, -2e-3, 3e-3, -4e-3, 5e-3)),
    rms_px=0.2,
    parameter_names=("color.fx", "color.fy"),
    covariance=np.array([[0.3, 0.1], [0.1, 0.2]]),
    gravity=np.array([0.0, 1.0, 0.0]),
    floor=Plane(np.array([0.0, -1.0, 0.0]), 1.1),
    sensor_serial="A1",
    created_utc="2026-11-21T10:00:00+00:00",
    valid_region={"color": [[1, 1], [30, 20]]},
)
CODING = Coding(
    "session 1",
    Ethogram(
        "table",
        (
            Behaviour("seated", "state", "on the chair", "s", "place", "#009E73", (), ("up",)),
            Behaviour("up", "state", "", "u", "place"),
            Behaviour("nods", "point", modifiers=(Modifier("times", (), "number"),)),
        ),
        (Subject("child", "1", "observed"),),
        "for tests",
    ),
    0,
    60_000,
    (
        Occurrence("seated", 1000, 4000, "child"),
        Occurrence("nods", 2000, 2000, "child", ("3",), "twice, or so"),
        Occurrence("up", 4000, 5500, "child"),
    ),
    "AB",
    (Section("hidden", 10_000, 12_000),),
)
ROS = """image_width: 640
image_height: 480
camera_name: rgb
camera_matrix: {rows: 3, cols: 3, data: [525.0, 0, 319.5, 0, 525.0, 239.5, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0.001, 0.0, 0.0]}
"""


def recording(path: Path, encoding: str) -> None:
    """Write three frames; with ``array`` as plain as the format allows."""
    info = SourceInfo(calibration=CALIBRATION) if encoding == "jpeg" else SourceInfo()
    options = RecordingOptions(is_plain=encoding == "array")
    for older in path.parent.glob(f"{path.stem}.*"):
        older.unlink()
    with create_recording(path, info, options) as writer:
        for frame in _frames(encoding):
            writer.write(frame)


def tum(path: Path, _variant: str) -> None:
    """Write a folder of images."""
    shutil.rmtree(path, ignore_errors=True)
    with create_recording(path, SourceInfo(calibration=CALIBRATION), RecordingOptions()) as writer:
        for frame in _frames("png"):
            writer.write(frame)


def messages(path: Path, variant: str) -> None:
    """Write one message of a recording, after the number of its kind."""
    stamp, (frame, *_) = Stamp(10**9, "depth", 3), _frames("png" if variant == "png" else "jpeg")
    if frame.depth_raw is None or not isinstance(frame.color, EncodedImage):
        raise TypeError("a frame without images")
    if variant in ("rvl", "raw"):
        written = (
            rvl_image(frame.depth_raw, 0.001, stamp)
            if variant == "rvl"
            else raw_image(frame.depth_raw, stamp)
        )
    else:
        written = compressed_image(frame.color, stamp)
    path.write_bytes(bytes([MESSAGES.index(variant)]) + written)


def _frames(encoding: str) -> Iterable[SensorFrame]:
    rng = np.random.default_rng(4)
    depth = np.cumsum(rng.integers(-1, 2, SHAPE), axis=1).astype(np.uint16)
    color = cv2.GaussianBlur(rng.integers(0, 256, (24, 32, 3), np.uint8), (0, 0), 2)
    picture = np.asarray(color, np.uint8)
    for i in range(3):
        time_ns = 1_700_000_000_000_000_000 + i * 33_333_333
        if encoding == "array":
            yield SensorFrame(i, time_ns, depth.copy(), picture, time_ns, depth.copy())
        else:
            end = {"jpeg": ".jpg", "png": ".png"}[encoding]
            data = cv2.imencode(end, picture)[1].tobytes()
            image = EncodedImage("jpeg" if encoding == "jpeg" else "png", data)
            yield SensorFrame(i, time_ns, depth.copy(), image, time_ns)


def coding(path: Path, _variant: str) -> None:
    """Write a coding as the path's ending says."""
    if path.suffix == ".boris":
        write_boris(path, [CODING])
    elif path.suffix == ".tsv":
        write_boris_table(path, [CODING])
    elif path.suffix == ".eaf":
        write_elan(path, CODING)
    elif path.suffix == ".csv":
        write_coding_csv(path, [CODING])
    else:
        write_coding_excel(path, [CODING], "en")


def excel_parts(path: Path, _variant: str) -> None:
    """Write what a workbook holds, unpacked."""
    workbook = path.with_suffix(".xlsx")
    coding(workbook, "")
    with zipfile.ZipFile(workbook) as archive:
        path.write_bytes(in_one({name: archive.read(name) for name in archive.namelist()}))


def ethogram(path: Path, _variant: str) -> None:
    """Write a scheme."""
    write_ethogram(path, CODING.ethogram)


def events(path: Path, _variant: str) -> None:
    """Write two events."""
    write_events_csv(path, [TimedEvent("a", "clap", 1.0, 2.5, "P1"), TimedEvent("a", "jump", 3, 4)])


def joints(path: Path, _variant: str) -> None:
    """Write two persons in three frames."""
    rng = np.random.default_rng(1)
    times = np.array([10**9, 2 * 10**9, 3 * 10**9])
    tracks = [
        SkeletonTrack(times, rng.normal(size=(3, 15, 3)), rng.random((3, 15)), person)
        for person in (1, 2)
    ]
    write_joints_csv(path, tracks, "markerless", np.array([0.0, -1.0, 0.0]))


def points(path: Path, _variant: str) -> None:
    """Write two point sets."""
    positions_m = np.array([[0.0, 0.1, 2.0], [0.2, 0.3, 2.1]])
    sets = [PointSet(name, ("1", "2"), ("head", ""), positions_m, "anterior") for name in "ab"]
    write_points(sets, path, {})


def calibration(path: Path, _variant: str) -> None:
    """Write a calibration of our own."""
    write_calibration(path, CALIBRATION)


def foreign_calibration(path: Path, variant: str) -> None:
    """Write one of OpenCV or of ROS."""
    if variant == "ros":
        path.write_text(ROS, encoding="utf-8")
        return
    kept = path.with_name(variant)
    storage = cv2.FileStorage(str(kept), cv2.FileStorage_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", np.array([[525.0, 0, 320], [0, 525, 240], [0, 0, 1]]))
    storage.write("distortion_coefficients", np.array([[0.1, -0.2, 0.0, 0.0, 0.0]]))
    storage.release()
    path.write_bytes(kept.read_bytes())


def picture(path: Path, _variant: str) -> None:
    """Write a small picture."""
    rng = np.random.default_rng(2)
    cv2.imwrite(str(path), rng.integers(0, 256, (24, 32, 3), np.uint8))


def servers(path: Path, _variant: str) -> None:
    """Write two servers."""
    write_servers(
        path, {"pacs": DicomServer("localhost", 104, "PACS"), "a": DicomServer("b", 1, "C")}
    )


def key_file(path: Path, _variant: str) -> None:
    """Write the key of a store into its folder."""
    path.mkdir(exist_ok=True)
    write_key_file(path, _key_of_store())


def backup(path: Path, _variant: str) -> None:
    """Write a backup whose database is none."""
    with path.open("wb") as file:
        writer = BackupWriter(file, header_of(_key_of_store(), "2026-01-01T00:00:00+00:00", 9), KEY)
        for name, content in (("adibas.db", b"database"), (f"pictures/{'ab' * 16}", b"p")):
            writer.begin_file(name)
            writer.write(content)
        writer.finish()


def backup_pieces(path: Path, _variant: str) -> None:
    """Write the pieces of that backup before they are sealed."""
    pieces = (b"Fadibas.db", b"Ddatabase", b"Fpictures/" + b"ab" * 16, b"Dp", b"E2")
    path.write_bytes(b"".join(LENGTH.pack(len(piece)) + piece for piece in pieces))


def sealed_backup(path: Path, pieces: Iterable[bytes]) -> None:
    """Write a backup of any pieces, as someone with the key could."""
    with path.open("wb") as file:
        writer = BackupWriter(file, header_of(_key_of_store(), "2026-01-01T00:00:00+00:00", 9), KEY)
        for piece in pieces:
            writer._write(piece[:PIECE_BYTES])  # noqa: SLF001  (nobody else writes wrong ones)


def _key_of_store() -> KeyFile:
    return behind_passphrase("5" * 32, KEY, PASSPHRASE, CHEAP)


def in_one(parts: dict[str, bytes]) -> bytes:
    """Return named parts one after the other, each behind the lengths of its name and content."""
    out = io.BytesIO()
    for name, content in parts.items():
        out.write(LENGTH.pack(len(name)) + name.encode() + LENGTH.pack(len(content)) + content)
    return out.getvalue()
