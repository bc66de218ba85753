"""What is kept of an unfinished map, so that the same request goes on.

Of a command beside its output: arrays and a JSON header in one ``.npz``, nothing that could run. A
file of a zip archive has a checksum of every part, so that damage is noticed. Of the window in
memory: how a patient moved belongs into no file outside the store.
"""

import hashlib
import json
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import monotonic
from typing import Any, Protocol

import numpy as np

from adibas import __version__
from adibas.alignment.camera_track import Following, KeyFrameParams
from adibas.alignment.pairing import Unaligned
from adibas.alignment.pose_graph import Edge
from adibas.arrays import FloatArray
from adibas.calibration.json_format import calibration_to_json
from adibas.data.calibration import RgbdCalibration
from adibas.files import DAMAGED_ARRAYS, is_there, remove_file, written_whole
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.texts import Message, message

FORMAT, VERSION = "adibas-unfinished-map", 1
SUFFIX = ".unfinished"
EVERY_S = 5.0
DAMAGED = message(
    "What was kept of an interrupted map is damaged and was not used: all frames were looked at "
    "anew."
)
FOREIGN = message(
    "What was kept of an interrupted map is of another recording or other settings and was not "
    "used: all frames were looked at anew."
)
NUMBERS = 12
"""Of a motion: rotation row by row, shift."""


@dataclass(frozen=True, slots=True, eq=False)
class Unfinished:
    """How far following the camera came.

    Attributes
    ----------
    next_index : int
        Of the recording's frame that comes next.
    indices, times_ns : tuple of int
        Of the moments that the tracker was given.
    left_out : dict of int to int
        Why frames before `next_index` were left out: index of a reason in `map_frames.REASONS`.
    following : Following
    """

    next_index: int = 0
    indices: tuple[int, ...] = ()
    times_ns: tuple[int, ...] = ()
    left_out: dict[int, int] = field(default_factory=dict)
    following: Following = field(default_factory=Following)


def unfinished_path(out: Path) -> Path:
    """Return where the state of a map is kept that is written to `out`."""
    return out.with_name(out.name + SUFFIX)


def settings_of(
    sha256: str,
    calibration: RgbdCalibration,
    frames: tuple[int, int | None],
    params: KeyFrameParams,
    *,
    is_body: bool,
) -> dict[str, Any]:
    """Return what must be the same for a map to go on."""
    told = json.dumps(calibration_to_json(calibration), sort_keys=True)
    settings = {
        "version": __version__,
        "recording_sha256": sha256,
        "calibration_sha256": hashlib.sha256(told.encode()).hexdigest(),
        "frames": list(frames),
        "is_body": is_body,
        "params": asdict(params),
    }
    same: dict[str, Any] = json.loads(json.dumps(settings))  # as it is read again
    return same


class Keeper(Protocol):
    """Keeps the state of one map."""

    def load(self) -> Unfinished | Message | None:
        """Return what was kept, why it cannot be used, or None where there is nothing.

        Raises
        ------
        FileError
            Nobody can say whether there is anything.
        """

    def keep_at_times(self, make: Callable[[], Unfinished]) -> None:
        """Keep the state every few seconds.

        Raises
        ------
        FileError
            It cannot be written.
        """

    def keep(self, state: Unfinished) -> None:
        """Keep the state now.

        Raises
        ------
        FileError
            It cannot be written.
        """


class MapMemory:
    """Holds the state of one map as long as the program has it; no file is written."""

    def __init__(self) -> None:
        self._held: tuple[dict[str, Any], Unfinished] | None = None

    def keeper(self, settings: dict[str, Any]) -> Keeper:
        """Return what keeps the state of a map with these settings, from `settings_of`."""
        return _MemoryKeeper(self, settings)

    def forget(self) -> None:
        """Hold nothing any more."""
        self._held = None

    def held_for(self, settings: dict[str, Any]) -> Unfinished | Message | None:
        """Return what is held; see `Keeper.load`."""
        if self._held is None:
            return None
        of_settings, state = self._held
        return deepcopy(state) if of_settings == settings else FOREIGN

    def hold(self, settings: dict[str, Any], state: Unfinished) -> None:
        """Hold a state in place of what was held."""
        self._held = settings, deepcopy(state)  # whoever goes on may change what it was given


class _MemoryKeeper(Keeper):
    """Keeps the state in a `MapMemory`."""

    def __init__(self, memory: MapMemory, settings: dict[str, Any]) -> None:
        self._memory = memory
        self._settings = settings

    def load(self) -> Unfinished | Message | None:
        return self._memory.held_for(self._settings)

    def keep_at_times(self, make: Callable[[], Unfinished]) -> None:
        """Leave it to the end: what stops the work keeps its state, and a kill takes memory."""

    def keep(self, state: Unfinished) -> None:
        self._memory.hold(self._settings, state)


class FileKeeper(Keeper):
    """Keeps the state of one map in a file.

    Parameters
    ----------
    path : Path
    settings : dict
        From `settings_of`.
    clock : callable
        Seconds.
    """

    def __init__(
        self, path: Path, settings: dict[str, Any], clock: Callable[[], float] = monotonic
    ) -> None:
        self._path = path
        self._settings = settings
        self._clock = clock
        self._kept_at_s = clock()

    def load(self) -> Unfinished | Message | None:
        """Return what was kept, why it cannot be used, or None where there is nothing.

        Raises
        ------
        FileError
            Nobody can say whether there is anything.
        """
        if not is_there(self._path):
            return None
        try:
            # NumPy leaves a damaged file open.
            with self._path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
                header = json.loads(arrays["header"].tobytes())
                if (header["format"], header["version"]) != (FORMAT, VERSION):
                    return FOREIGN
                if header["settings"] != self._settings:
                    return FOREIGN
                return _unpacked(header, arrays)
        except (OSError, *DAMAGED_ARRAYS, RecursionError, IndexError):
            return DAMAGED

    def keep_at_times(self, make: Callable[[], Unfinished]) -> None:
        """Keep the state every few seconds.

        Raises
        ------
        FileError
            It cannot be written.
        """
        if self._clock() - self._kept_at_s >= EVERY_S:
            self.keep(make())

    def keep(self, state: Unfinished) -> None:
        """Keep the state now.

        Raises
        ------
        FileError
            It cannot be written.
        """
        header = {
            "format": FORMAT,
            "version": VERSION,
            "settings": self._settings,
            "next_index": state.next_index,
            "n_moving": state.following.n_moving,
        }
        text = np.frombuffer(json.dumps(header).encode(), np.uint8)
        with written_whole(self._path) as unfinished, unfinished.open("wb") as file:
            np.savez(file, header=text, **_packed(state))
        self._kept_at_s = self._clock()

    def remove(self) -> None:
        """Forget what was kept: the work is done, or cannot be.

        Raises
        ------
        FileError
            It cannot be removed.
        """
        remove_file(self._path)


def _packed(state: Unfinished) -> dict[str, Any]:
    now = state.following
    placed = [place or (-1, IDENTITY) for place in now.places]
    whys = list(Unaligned)
    return {
        "indices": np.array(state.indices, np.int64),
        "times_ns": np.array(state.times_ns, np.int64),
        "left_out": np.array(list(state.left_out.items()), np.int64).reshape(-1, 2),
        "keys": np.array(now.keys, np.int64),
        "world_from_key": _rows(now.world_from_key),
        "edge_ends": np.array(
            [(one.target, one.source, one.is_doubtful) for one in now.edges], np.int64
        ).reshape(-1, 3),
        "edge_motions": _rows([one.target_from_source for one in now.edges]),
        "edge_information": np.array([one.information for one in now.edges]).reshape(-1, 6, 6),
        "place_keys": np.array([key for key, _ in placed], np.int64),
        "place_motions": _rows([motion for _, motion in placed]),
        "problems": np.array(
            [(number, whys.index(why)) for number, why in now.problems.items()], np.int64
        ).reshape(-1, 2),
        "last_and_step": _rows([now.last, now.step]),
        "last_information": np.array(
            [] if now.information is None else [now.information], float
        ).reshape(-1, 6, 6),
    }


def _unpacked(header: dict[str, Any], arrays: Any) -> Unfinished:
    whys = list(Unaligned)
    ends = arrays["edge_ends"].tolist()
    motions, information = _motions(arrays["edge_motions"]), arrays["edge_information"]
    places = zip(arrays["place_keys"].tolist(), _motions(arrays["place_motions"]), strict=True)
    last, step = _motions(arrays["last_and_step"])
    last_information = arrays["last_information"]
    if max(arrays["place_keys"], default=-1) >= len(arrays["keys"]):
        raise ValueError("a moment lies in a key-frame that is not there")
    following = Following(
        tuple(arrays["keys"].tolist()),
        tuple(_motions(arrays["world_from_key"])),
        tuple(
            Edge(target, source, motion, told.copy(), is_doubtful=bool(doubtful))
            for (target, source, doubtful), motion, told in zip(
                ends, motions, information, strict=True
            )
        ),
        tuple(None if key < 0 else (key, motion) for key, motion in places),
        {number: whys[why] for number, why in arrays["problems"].tolist()},
        last,
        step,
        last_information[0].copy() if len(last_information) else None,
        int(header["n_moving"]),
    )
    return Unfinished(
        int(header["next_index"]),
        tuple(arrays["indices"].tolist()),
        tuple(arrays["times_ns"].tolist()),
        dict(arrays["left_out"].tolist()),
        following,
    )


def _rows(motions: Sequence[RigidTransform]) -> FloatArray:
    rows = [np.append(one.rotation.ravel(), one.translation_m) for one in motions]
    return np.array(rows, float).reshape(-1, NUMBERS)


def _motions(rows: FloatArray) -> list[RigidTransform]:
    return [RigidTransform(row[:9].reshape(3, 3), row[9:]) for row in rows.reshape(-1, NUMBERS)]
