"""Joints of motion capture kept as skeleton and motion (ASF/AMC), and markers of C3D files.

Source: the Acclaim formats as the CMU database (mocap.cs.cmu.edu) describes them; The C3D file
format user guide (c3d.org). Only what the recordings of the labelling benchmark need is read.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES

ASF_UNIT_M = 0.0254 / 0.45
"""CMU's lengths are inches divided by 0.45."""
Y_UP_TO_CAMERA = np.diag([1.0, -1.0, -1.0])
Z_UP_TO_CAMERA = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
BLOCK = 512

END_OF_BONE = {
    "neck": "thorax",
    "torso": "lowerback",
    **{
        f"{side}_{joint}": f"{side[0]}{bone}"
        for side in ("left", "right")
        for joint, bone in (
            ("shoulder", "clavicle"),
            ("elbow", "humerus"),
            ("hand", "wrist"),
            ("hip", "hipjoint"),
            ("knee", "femur"),
            ("foot", "tibia"),
        )
    },
}
"""Our joints as the far ends of the bones; the head is the middle of its own."""

MARKERS_OF_JOINT = {
    "head": ("LFHD", "RFHD", "LBHD", "RBHD"),
    "neck": ("C7", "CLAV"),
    "torso": ("T10", "STRN"),
    **{
        f"{side}_{joint}": tuple(f"{side[0].upper()}{marker}" for marker in markers)
        for side in ("left", "right")
        for joint, markers in (
            ("shoulder", ("SHO",)),
            ("elbow", ("ELB",)),
            ("hand", ("WRA", "WRB")),
            ("hip", ("ASI",)),
            ("knee", ("KNE",)),
            ("foot", ("ANK",)),
        )
    },
}
"""Plug-in-Gait markers whose mean stands for a joint."""


@dataclass(slots=True)
class _Bone:
    direction: FloatArray = field(default_factory=lambda: np.zeros(3))
    length: float = 0.0
    axes: FloatArray = field(default_factory=lambda: np.eye(3))
    turns: tuple[str, ...] = ()
    parent: str = ""


def read_mocap_joints(asf: Path, amc: Path) -> FloatArray:
    """Return (T, 15, 3) joints in metres, y down; the heading is the recording's."""
    bones = _read_asf(asf)
    frames = [_placed(bones, pose) for pose in _read_amc(amc)]
    return np.stack(frames) * ASF_UNIT_M @ Y_UP_TO_CAMERA.T


def read_c3d_joints(path: Path) -> FloatArray:
    """Return (T, 15, 3) means of the markers of each joint, metres, y down; NaN where hidden."""
    markers = _read_c3d(path)
    present = {
        joint: [markers[name] for name in names if name in markers]
        for joint, names in MARKERS_OF_JOINT.items()
    }
    joints_mm = [np.mean(present[joint], axis=0) for joint in JOINT_NAMES]
    return np.asarray(np.stack(joints_mm, axis=1) / 1000.0 @ Z_UP_TO_CAMERA.T)


def c3d_rate_hz(path: Path) -> float:
    """Return how many frames a second a C3D file has, as its header says."""
    (rate_hz,) = struct.unpack_from("<f", path.read_bytes(), 20)
    return float(rate_hz)


def _read_asf(path: Path) -> dict[str, _Bone]:
    bones: dict[str, _Bone] = {"root": _Bone()}
    section, bone = "", _Bone()
    for line in path.read_text("latin-1").splitlines():
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            section = words[0]
        elif section == ":bonedata":
            if words[0] == "begin":
                bone = _Bone()
            _read_bone_line(words, bone, bones)
        elif section == ":hierarchy" and words[0] not in ("begin", "end"):
            for child in words[1:]:
                bones[child].parent = words[0]
    return bones


def _read_bone_line(words: list[str], bone: _Bone, bones: dict[str, _Bone]) -> None:
    match words[0]:
        case "name":
            bones[words[1]] = bone
        case "direction":
            bone.direction = np.array(words[1:4], float)
        case "length":
            bone.length = float(words[1])
        case "axis":
            bone.axes = _turned(np.array(words[1:4], float), ("rx", "ry", "rz"))
        case "dof":
            bone.turns = tuple(words[1:])


def _read_amc(path: Path) -> Iterator[dict[str, FloatArray]]:
    pose: dict[str, FloatArray] = {}
    for line in path.read_text("latin-1").splitlines():
        words = line.split()
        if not words or words[0][0] in "#:":
            continue
        if words[0].isdecimal() and len(words) == 1:
            if pose:
                yield pose
            pose = {}
        else:
            pose[words[0]] = np.array(words[1:], float)
    if pose:
        yield pose


def _placed(bones: dict[str, _Bone], pose: dict[str, FloatArray]) -> FloatArray:
    root = pose["root"]
    turn = {"root": _turned(root[3:], ("rx", "ry", "rz"))}
    end = {"root": root[:3]}
    for name, bone in bones.items():
        if name == "root":
            continue
        own = _turned(pose.get(name, np.zeros(0)), bone.turns)
        turn[name] = turn[bone.parent] @ bone.axes @ own @ bone.axes.T
        end[name] = end[bone.parent] + turn[name] @ bone.direction * bone.length
    ends = {joint: end[bone] for joint, bone in END_OF_BONE.items()}
    ends["head"] = 0.5 * (end["head"] + end[bones["head"].parent])
    return np.stack([ends[joint] for joint in JOINT_NAMES])


def _turned(degrees: FloatArray, names: tuple[str, ...]) -> FloatArray:
    """Return the rotation of the angles, the first one done first."""
    total = np.eye(3)
    for angle, name in zip(np.radians(degrees), names, strict=False):
        i, j = {"rx": (1, 2), "ry": (2, 0), "rz": (0, 1)}[name]
        one = np.eye(3)
        one[i, i] = one[j, j] = np.cos(angle)
        one[i, j], one[j, i] = -np.sin(angle), np.sin(angle)
        total = one @ total
    return total


def _read_c3d(path: Path) -> dict[str, FloatArray]:
    data = path.read_bytes()
    n_points, n_analog = struct.unpack_from("<HH", data, 2)
    first, last = struct.unpack_from("<HH", data, 6)
    (start,) = struct.unpack_from("<H", data, 16)
    n_frames = last - first + 1
    row = 4 * n_points + n_analog
    values = np.frombuffer(data, "<f4", n_frames * row, (start - 1) * BLOCK).reshape(n_frames, row)
    points = values[:, : 4 * n_points].reshape(n_frames, n_points, 4).astype(float)
    points[points[..., 3] < 0] = np.nan
    names = _c3d_labels(data)
    return {name: points[:, i, :3] for i, name in enumerate(names[:n_points])}


def _c3d_labels(data: bytes) -> list[str]:
    """Return POINT:LABELS of the parameter section."""
    at = (data[0] - 1) * BLOCK + 4
    while True:
        length, group = struct.unpack_from("<bb", data, at)
        if length == 0:
            raise ValueError("the C3D file names no points")
        length = abs(length)
        name = data[at + 2 : at + 2 + length].decode("latin-1")
        step_at = at + 2 + length
        if group > 0 and name == "LABELS":
            width, count = data[step_at + 4], data[step_at + 5]
            begin = step_at + 6
            text = data[begin : begin + width * count].decode("latin-1")
            return [text[i : i + width].strip() for i in range(0, width * count, width)]
        at = step_at + struct.unpack_from("<h", data, step_at)[0]
