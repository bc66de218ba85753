"""The limbs of the person in every frame of a recording: pictures, and images to train on."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from adibas import __version__
from adibas.arrays import AnyArray, Float32Array, UInt8Array, UInt16Array
from adibas.body.absence import why_nobody
from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo, depth_in_metres
from adibas.data.limbs import FULL_BODY, HAND, LABEL_SETS, LimbParts
from adibas.data.sentence import Sentence
from adibas.errors import CalibrationError, LimbError
from adibas.files import written_whole
from adibas.geometry.planes import Plane
from adibas.limbs.judging import Judgement, judge_absence, judge_mask
from adibas.limbs.model import LimbModel, load_model
from adibas.limbs.segmentation import FrameBefore, LimbParams, segment
from adibas.limbs.training_set import FolderHeader
from adibas.pipeline.limb_label_files import LabelFiles
from adibas.pipeline.limb_pictures import limb_picture
from adibas.pipeline.mending import mended
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.session import calibration_of, wanted_frames
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.upright import turn_to_upright, turned_camera, turned_floor, turned_parts
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.ports import RecordingReader

PICTURE = ".limbs.png"


@dataclass(frozen=True, slots=True)
class SegmentingRequest:
    """What to segment.

    Attributes
    ----------
    recording : Path
    out : Path
        Folder; what is labelled in it already stays.
    model : Path or None
        None: the shipped one of `labels`.
    labels : str
        ``full-body-15`` or ``upper-body-7``; empty: those of `model`, or the full body.
    calibration : Path or None
        In place of the recording's own.
    frames : (first, one past the last or None)
    params : LimbParams
    rotation_deg : int
        How far the picture is turned clockwise to be upright; see `turn_to_upright`.
    """

    recording: Path
    out: Path
    model: Path | None = None
    labels: str = ""
    calibration: Path | None = None
    frames: tuple[int, int | None] = (0, None)
    params: LimbParams = field(default_factory=LimbParams)
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True)
class Segmented:
    """What was written, and what is to be said.

    Attributes
    ----------
    n_frames, n_people : int
        Frames looked at; frames with a person.
    n_known : int
        Frames that were labelled before, and stay as they are.
    notices : tuple of (Sentence, int)
        Each with the number of frames that it holds for.
    """

    n_frames: int
    n_people: int
    n_known: int
    notices: tuple[tuple[Sentence, int], ...]


def segment_recording(request: SegmentingRequest, progress: Progress) -> Segmented:
    """Write ``NNNNN.depth.png``, ``.labels.png`` and a picture of every frame with a person.

    With ``labels.json`` they are a folder to train on or to correct. Frames with labels are left
    alone: somebody may have made them by hand.

    Raises
    ------
    RecordingError
        The recording cannot be read, or has no such frames.
    CalibrationError
        There is none of the depth camera.
    FileError, LimbError
        The model cannot be used; the folder is of another recording, another camera or other
        labels, or cannot be written.
    """
    model = _model_of(request)
    said: Counter[str] = Counter()
    sentences: dict[str, Sentence] = {}
    n_frames = n_people = n_known = 0
    with open_recording(request.recording) as recording:
        wanted = wanted_frames(recording, request.frames, request.recording.name)
        calibration = calibration_of(recording, request.calibration)
        looker = Looker(calibration, recording.info, request.rotation_deg)
        files = _files_of(request, recording, model, looker.camera)
        for number, index in enumerate(wanted, start=1):
            # Asked anew each time: the window may be labelling the same folder.
            if files.is_labelled(index):
                n_known += 1
                looker.forget()
            else:
                n_frames += 1
                frame = recording.read(index)
                parts, judgement = looker.look(frame, model, request.params)
                for notice in judgement.notices:
                    said[notice.message] += 1
                    sentences[notice.message] = notice
                if parts is not None and frame.depth_raw is not None:
                    n_people += 1
                    _write(files, index, frame.depth_raw, parts)
            progress(number, len(wanted))
    notices = tuple((sentences[text], count) for text, count in said.most_common())
    return Segmented(n_frames, n_people, n_known, notices)


def _model_of(request: SegmentingRequest) -> LimbModel:
    if request.model is None:
        return shipped_model(request.labels or FULL_BODY.name)
    model = load_model(request.model)
    if request.labels:
        model.require(LABEL_SETS[request.labels])
    elif model.labels == HAND:
        # Whole people are segmented: one of them would be given fingers all over.
        model.require(FULL_BODY)
    return model


class Looker:
    """From frames of one camera to the limbs of whoever is in them.

    Parameters
    ----------
    calibration : RgbdCalibration
    info : SourceInfo
    rotation_deg : int
        How far the picture is turned clockwise to be upright.

    Raises
    ------
    CalibrationError
        The calibration is not of a depth camera.
    """

    def __init__(
        self, calibration: RgbdCalibration, info: SourceInfo, rotation_deg: int = 0
    ) -> None:
        if calibration.depth is None:
            raise CalibrationError(
                "The calibration is of a colour camera alone, and limbs are found in depth. Give "
                "one of the depth camera with --calibration FILE."
            )
        self.camera: CameraCalibration = calibration.depth
        self._calibration = calibration
        self._turn = turn_to_upright(calibration, rotation_deg)
        self._upright = turned_camera(calibration.depth, self._turn)
        self._floor: Plane | None = turned_floor(calibration.floor, self._turn)
        self._unit_m = info.depth_unit_m
        self._has_looked_for_floor = False
        self._before: FrameBefore | None = None

    def forget(self) -> None:
        """Take the next frame for itself: the one that was looked at last is not before it."""
        self._before = None

    def look(
        self, frame: SensorFrame, model: LimbModel, params: LimbParams
    ) -> tuple[LimbParts | None, Judgement]:
        """Return the limbs, None where nobody is, and what is to be said.

        With ``over_time`` each frame is tied to the one that was looked at before.
        """
        if frame.depth_raw is None:
            return None, judge_mask(np.zeros((1, 1), np.float32), None)
        depth_m = depth_in_metres(frame.depth_raw, self._unit_m)
        if depth_m.shape != (self.camera.height, self.camera.width):
            raise CalibrationError(
                "The calibration is for depth of {width}x{height} pixels, and the recording has "
                "{found}. Calibrate at this resolution.",
                width=self.camera.width,
                height=self.camera.height,
                found=f"{depth_m.shape[1]}x{depth_m.shape[0]}",
            )
        depth_m = np.ascontiguousarray(self._calibration.corrected_depth(depth_m), np.float32)
        upright_m = self._turn.picture(depth_m)
        parts, judgement = self._look_upright(upright_m, model, params)
        self._before = None if parts is None else FrameBefore(upright_m, parts)
        return None if parts is None else turned_parts(parts, self._turn.inverse()), judgement

    def _look_upright(
        self, depth_m: Float32Array, model: LimbModel, params: LimbParams
    ) -> tuple[LimbParts | None, Judgement]:
        """Return what `look` does, in the pixels of the picture that was turned upright."""
        depth_m, said = mended(depth_m)
        if not said.is_person:
            return None, said
        if self._floor is None and not self._has_looked_for_floor:
            self._floor = find_floor(depth_m, self._upright)
            self._has_looked_for_floor = True
        body = find_body(depth_m, self._upright, self._floor)
        if body is None:
            return None, judge_absence(why_nobody(depth_m, self._upright, self._floor))
        mask = body.pixels
        judgement = judge_mask(depth_m, mask)
        if not judgement.is_person:
            return None, judgement
        focal_px = self._upright.intrinsics.fx
        parts = segment(depth_m, mask, focal_px, model, params, self._before)
        found = person_judge(model, self._upright)(depth_m, mask, parts, None)
        notices = (*said.notices, *judgement.notices, *found.notices)
        return (parts if found.is_person else None), Judgement(found.is_person, notices)


def _files_of(
    request: SegmentingRequest,
    recording: RecordingReader,
    model: LimbModel,
    camera: CameraCalibration,
) -> LabelFiles:
    """Return the folder to write to.

    Raises
    ------
    LimbError
        It is of another recording, another camera or other labels, or cannot be read.
    """
    k = camera.intrinsics
    header = FolderHeader(
        model.labels.names,
        recording.info.depth_unit_m,
        *(k.fx, k.fy, k.cx, k.cy),
        source={"segmented_by": __version__},
    )
    size = camera.height, camera.width
    files = LabelFiles(request.out, request.recording.name, len(recording), size, header)
    if files.labels.names != model.labels.names:
        raise LimbError(
            "{folder} holds images with other labels than the model ({found}). Choose another "
            "folder, or a model with these labels.",
            folder=request.out.name,
            found=", ".join(files.labels.names),
        )
    return files


def _write(files: LabelFiles, index: int, depth_raw: UInt16Array, parts: LimbParts) -> None:
    labels: UInt8Array = (parts.chosen + 1).astype(np.uint8)
    picture = limb_picture(depth_raw.astype(np.float32), labels)
    payload: AnyArray = cv2.imencode(".png", picture[..., ::-1])[1]
    # The labels last: a frame that has them is not looked at again.
    with written_whole(files.folder / f"{index:05d}{PICTURE}") as unfinished:
        unfinished.write_bytes(payload.tobytes())
    files.add_found(index, depth_raw, labels)
