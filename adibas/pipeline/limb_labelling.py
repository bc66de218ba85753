"""The ground-truth editor's desk: frames of a recording, their labels, and a folder to train on.

Frames that are done are images as `adibas limbs train` reads them; what is still being worked on
lies beside them under another name, so that training never sees it. `progress.json` says whose
frames they are and which are done: work goes on after a restart, also in a folder that `adibas
limbs segment` has written.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

import cv2
import numpy as np

from adibas import __version__
from adibas.arrays import AnyArray, BoolArray, Float32Array, UInt8Array, UInt16Array, read_only
from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.body.rays import viewing_rays
from adibas.calibration.files import check_fits
from adibas.clock import NS_PER_S
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import FULL_BODY, LimbLabels, labels_named
from adibas.errors import CalibrationError, LimbError, RecordingError
from adibas.files import cannot_write, written_whole
from adibas.limbs.label_propagation import SeenPerson, carry_labels
from adibas.limbs.label_proposals import propose_labels
from adibas.limbs.training_set import (
    DEPTH,
    HEADER,
    LABELS,
    TO_TORSO,
    FolderHeader,
    read_header,
    write_header,
    write_image,
)
from adibas.pipeline.limb_segmenting import shipped_model
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
from adibas.pipeline.session import calibration_of
from adibas.recordings.ports import RecordingReader

PROGRESS, DRAFT = "progress.json", ".draft.png"
FORMAT, VERSION = "adibas-limb-labelling", 1


@dataclass(frozen=True, slots=True, eq=False)
class FrameToLabel:
    """One frame of the recording.

    Attributes
    ----------
    index : int
    depth_raw : (H, W) uint16 array
    depth_m : (H, W) float32 array
        NaN where not measured.
    mask : (H, W) bool array
        The person and what is labelled already; all False where nobody was found.
    """

    index: int
    depth_raw: UInt16Array
    depth_m: Float32Array
    mask: BoolArray

    def __post_init__(self) -> None:
        for array in (self.depth_raw, self.depth_m, self.mask):
            read_only(array)


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


class LabellingDesk:
    """A recording on one side, a folder of labelled images on the other.

    Parameters
    ----------
    recording : RecordingReader
        The desk closes it.
    name : str
        Of the recording: a folder belongs to one.
    folder : Path
        It may exist.
    calibration : Path or None
        In place of the recording's own.
    labels : LimbLabels
        Of a new folder; a folder that exists keeps its own.

    Raises
    ------
    RecordingError
        It has no frames.
    CalibrationError
        There is none of the depth camera.
    LimbError
        The folder is of another recording or another camera, or cannot be read.
    """

    def __init__(
        self,
        recording: RecordingReader,
        name: str,
        folder: Path,
        calibration: Path | None = None,
        labels: LimbLabels = FULL_BODY,
    ) -> None:
        self._recording = recording
        self._reading = Lock()
        self.name = name
        self.folder = folder
        self._calibration = calibration_of(recording, calibration)
        if self._calibration.depth is None:
            raise CalibrationError(
                "The calibration is of a colour camera alone, and limbs are found in depth. Give "
                "one of the depth camera with --calibration FILE."
            )
        self.camera: CameraCalibration = self._calibration.depth
        self._floor = self._calibration.floor
        self._header = self._header_of(labels)
        self.labels = labels_named(self._header.labels)
        self._done = _read_done(folder, name)
        self._estimator: PoseEstimator | None = None
        self._looked_at_ns = 0

    def __len__(self) -> int:
        return len(self._recording)

    def close(self) -> None:
        """Close the recording."""
        with self._reading:
            self._recording.close()

    @property
    def progress(self) -> LabellingProgress:
        """Return how far the work is, by the files that are there."""
        labelled = _numbers(self.folder, LABELS)
        done = self._done & labelled
        begun = (labelled | _numbers(self.folder, DRAFT)) - done
        return LabellingProgress(len(self), done, begun)

    def frame(self, index: int) -> FrameToLabel:
        """Return a frame and where the person is in it.

        Raises
        ------
        RecordingError
            The frame is damaged, or has no depth.
        CalibrationError
            It is of another resolution than the calibration.
        """
        with self._reading:
            frame = self._recording.read(index)
        if frame.depth_raw is None:
            raise RecordingError(
                "{file} has no depth, and limbs are found in depth. Record with a depth camera.",
                file=self.name,
            )
        depth_m = depth_in_metres(frame.depth_raw, self._recording.info.depth_unit_m)
        check_fits(self._calibration, None, depth_m.shape)
        depth_m = np.ascontiguousarray(self._calibration.corrected_depth(depth_m), np.float32)
        if self._floor is None:
            self._floor = find_floor(depth_m, self.camera)
        body = find_body(depth_m, self.camera, self._floor)
        mask = np.zeros(depth_m.shape, np.bool_) if body is None else body.pixels.copy()
        kept = self.kept_labels(index)
        if kept is not None and kept.shape == mask.shape:
            mask |= kept > 0
        return FrameToLabel(index, np.asarray(frame.depth_raw), depth_m, mask)

    def kept_labels(self, index: int) -> UInt8Array | None:
        """Return the labels that are kept of a frame; None where there are none.

        Raises
        ------
        LimbError
            The image is damaged or of another size.
        """
        for ending in (DRAFT, LABELS):
            path = self.folder / f"{_name_of(index)}{ending}"
            if path.is_file():
                return self._read(path)
        return None

    def _read(self, path: Path) -> UInt8Array:
        payload = np.fromfile(path, np.uint8)
        image = cv2.imdecode(payload, cv2.IMREAD_UNCHANGED) if payload.size else None
        shape = (self.camera.height, self.camera.width)
        if image is None or image.shape != shape or image.dtype != np.uint8:
            raise LimbError(
                "{file} in {folder} is damaged, or of another size than the recording. Remove it.",
                file=path.name,
                folder=self.folder.name,
            )
        labels: UInt8Array = np.asarray(image, np.uint8)
        labels[labels > len(self.labels)] = 0
        return labels

    def proposed(self, frame: FrameToLabel) -> UInt8Array:
        """Return labels from the joints that are found without markers.

        Raises
        ------
        LimbError
            No joints are found, or the folder's labels are not those of a body.
        """
        joints_m = self._joints_m(frame)
        points_m = viewing_rays(self.camera) * frame.depth_m[..., None]
        full = propose_labels(points_m, frame.mask, joints_m)
        return self._as_own(full)

    def _joints_m(self, frame: FrameToLabel) -> AnyArray:
        """Return (15, 3) joints of the person in the mask."""
        if not frame.mask.any():
            raise LimbError(
                "Nobody was found in the picture: there is nothing to propose. Paint the limbs, "
                "or go on to the next frame.",
            )
        now_ns = int(self._recording.timestamps_ns[frame.index])
        if self._estimator is None or now_ns <= self._looked_at_ns:
            segmenter = forest_segmenter(shipped_model(), self.camera)
            self._estimator = PoseEstimator(self.camera, segmenter, self._floor)
        self._looked_at_ns = now_ns
        pose = self._estimator.look_at(frame.depth_m, [frame.mask], now_ns / NS_PER_S)
        if not pose.people or not np.isfinite(pose.people[0].joints.joints_m).any():
            reason = pose.notices[0].text if pose.notices else ""
            raise LimbError(
                "No joints were found in the picture. {reason}",
                reason=reason,
            )
        return np.asarray(pose.people[0].joints.joints_m).reshape(len(JOINT_NAMES), 3)

    def _as_own(self, full: UInt8Array) -> UInt8Array:
        """Return labels of the full body as those of the folder."""
        own = self.labels.names
        named = [
            TO_TORSO.get(name, name) if "head" not in own else name for name in FULL_BODY.names
        ]
        if not set(named) & set(own):
            raise LimbError(
                "The labels of {folder} are not those of a body: they cannot be proposed from "
                "joints.",
                folder=self.folder.name,
            )
        value = [0, *(own.index(name) + 1 if name in own else 0 for name in named)]
        return np.asarray(np.array(value, np.uint8)[full], np.uint8)

    def carried(self, before: FrameToLabel, labels: UInt8Array, after: FrameToLabel) -> UInt8Array:
        """Return the labels of a frame as the next one has them."""
        rays = viewing_rays(self.camera)
        seen = [SeenPerson(rays * one.depth_m[..., None], one.mask) for one in (before, after)]
        return carry_labels(seen[0], labels, seen[1])

    def keep(self, frame: FrameToLabel, labels: UInt8Array, *, is_done: bool) -> None:
        """Keep the labels of a frame: as an image to train on, or as work to go on with.

        Raises
        ------
        FileError
            The folder cannot be written.
        """
        name = _name_of(frame.index)
        if not (self.folder / HEADER).is_file():
            write_header(self.folder, self._header)
        if is_done:
            write_image(self.folder, name, frame.depth_raw, labels)
        else:
            payload: AnyArray = cv2.imencode(".png", labels)[1]
            with written_whole(self.folder / f"{name}{DRAFT}") as unfinished:
                unfinished.write_bytes(payload.tobytes())
        self._note_done(self._done | {frame.index} if is_done else self._done - {frame.index})
        rest = (DRAFT,) if is_done else (LABELS, DEPTH)
        for ending in rest:
            path = self.folder / f"{name}{ending}"
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise cannot_write(path, error) from error

    def _note_done(self, done: frozenset[int]) -> None:
        document = {
            "format": FORMAT,
            "version": VERSION,
            "recording": self.name,
            "n_frames": len(self),
            "done": sorted(done),
        }
        with written_whole(self.folder / PROGRESS) as unfinished:
            unfinished.write_text(json.dumps(document), "utf-8")
        self._done = done

    def _header_of(self, labels: LimbLabels) -> FolderHeader:
        k, info = self.camera.intrinsics, self._recording.info
        wanted = FolderHeader(
            labels.names,
            info.depth_unit_m,
            *(k.fx, k.fy, k.cx, k.cy),
            source={"labelled_with": __version__},
        )
        if not (self.folder / HEADER).is_file():
            return wanted
        found = read_header(self.folder)
        if not np.allclose(_optics(found), _optics(wanted), rtol=1e-6):
            raise LimbError(
                "{folder} holds images of another camera. Choose another folder.",
                folder=self.folder.name,
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
    if not path.is_file():
        return frozenset()
    try:
        document: Any = json.loads(path.read_text("utf-8"))
        is_ours = (document["format"], document["version"]) == (FORMAT, VERSION)
        of, done = str(document["recording"]), frozenset(map(int, document["done"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise _damaged(folder) from error
    if not is_ours:
        raise _damaged(folder)
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
