"""The desk of who labels limbs by hand: frames of a recording, and where labels start from."""

from dataclasses import dataclass
from pathlib import Path
from threading import Lock

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
from adibas.data.limbs import FULL_BODY, LimbLabels
from adibas.errors import CalibrationError, LimbError, RecordingError
from adibas.limbs.label_propagation import SeenPerson, carry_labels
from adibas.limbs.label_proposals import propose_labels
from adibas.limbs.training_set import TO_TORSO, FolderHeader
from adibas.pipeline.limb_label_files import LabelFiles
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
from adibas.pipeline.session import calibration_of
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.upright import turn_to_upright, turned_camera, turned_floor, turned_pose
from adibas.recordings.ports import RecordingReader


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
class DeskSetup:
    """How a recording is laid on the desk.

    Attributes
    ----------
    calibration : Path or None
        In place of the recording's own.
    labels : LimbLabels
        Of a new folder; a folder that exists keeps its own.
    rotation_deg : int
        How far the picture is turned clockwise to be upright; see `turn_to_upright`.
    """

    calibration: Path | None = None
    labels: LimbLabels = FULL_BODY
    rotation_deg: int = 0


class LabellingDesk:
    """A recording on one side, `files` of labelled images on the other.

    Parameters
    ----------
    recording : RecordingReader
        The desk closes it.
    name : str
        Of the recording: a folder belongs to one.
    folder : Path
        It may exist.
    setup : DeskSetup, optional

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
        setup: DeskSetup | None = None,
    ) -> None:
        setup = setup or DeskSetup()
        if not len(recording):
            raise RecordingError("{file} has no frames. Choose another recording.", file=name)
        self._recording = recording
        self._reading = Lock()
        self._calibration = calibration_of(recording, setup.calibration)
        if self._calibration.depth is None:
            raise CalibrationError(
                "The calibration is of a colour camera alone, and limbs are found in depth. Give "
                "one of the depth camera with --calibration FILE."
            )
        self.camera: CameraCalibration = self._calibration.depth
        self._turn = turn_to_upright(self._calibration, setup.rotation_deg)
        self._upright = turned_camera(self.camera, self._turn)
        self._floor = turned_floor(self._calibration.floor, self._turn)
        size = self.camera.height, self.camera.width
        self.files = LabelFiles(folder, name, len(recording), size, self._header(setup.labels))
        self._estimator: PoseEstimator | None = None
        self._looked_at_ns = 0

    def __len__(self) -> int:
        return len(self._recording)

    def close(self) -> None:
        """Close the recording."""
        with self._reading:
            self._recording.close()

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
                file=self.files.recording,
            )
        depth_m = depth_in_metres(frame.depth_raw, self._recording.info.depth_unit_m)
        check_fits(self._calibration, None, depth_m.shape)
        depth_m = np.ascontiguousarray(self._calibration.corrected_depth(depth_m), np.float32)
        upright_m = self._turn.picture(depth_m)
        if self._floor is None:
            self._floor = find_floor(upright_m, self._upright)
        body = find_body(upright_m, self._upright, self._floor)
        mask = np.zeros(depth_m.shape, np.bool_)
        if body is not None:
            mask |= self._turn.inverse().picture(body.pixels)
        kept = self.files.kept(index)
        if kept is not None and kept.shape == mask.shape:
            mask |= kept > 0
        return FrameToLabel(index, np.asarray(frame.depth_raw), depth_m, mask)

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
            segmenter = forest_segmenter(shipped_model(), self._upright)
            self._estimator = PoseEstimator(self._upright, segmenter, self._floor)
        self._looked_at_ns = now_ns
        turned = self._turn.picture
        pose = self._estimator.look_at(
            turned(frame.depth_m), [turned(frame.mask)], now_ns / NS_PER_S
        )
        pose = turned_pose(pose, self._turn.inverse())
        if not pose.people or not np.isfinite(pose.people[0].joints.joints_m).any():
            reason = pose.notices[0].text if pose.notices else ""
            raise LimbError(
                "No joints were found in the picture. {reason}",
                reason=reason,
            )
        return np.asarray(pose.people[0].joints.joints_m).reshape(len(JOINT_NAMES), 3)

    def _as_own(self, full: UInt8Array) -> UInt8Array:
        """Return labels of the full body as those of the folder."""
        own = self.files.labels.names
        named = [
            TO_TORSO.get(name, name) if "head" not in own else name for name in FULL_BODY.names
        ]
        if not set(named) & set(own):
            raise LimbError(
                "The labels of {folder} are not those of a body: they cannot be proposed from "
                "joints.",
                folder=self.files.folder.name,
            )
        value = [0, *(own.index(name) + 1 if name in own else 0 for name in named)]
        return np.asarray(np.array(value, np.uint8)[full], np.uint8)

    def carried(self, before: FrameToLabel, labels: UInt8Array, after: FrameToLabel) -> UInt8Array:
        """Return the labels of a frame as the next one has them."""
        rays = viewing_rays(self.camera)
        seen = [SeenPerson(rays * one.depth_m[..., None], one.mask) for one in (before, after)]
        return carry_labels(seen[0], labels, seen[1])

    def _header(self, labels: LimbLabels) -> FolderHeader:
        k, info = self.camera.intrinsics, self._recording.info
        return FolderHeader(
            labels.names,
            info.depth_unit_m,
            *(k.fx, k.fy, k.cx, k.cy),
            source={"labelled_with": __version__},
        )
