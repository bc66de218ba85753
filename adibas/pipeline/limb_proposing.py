"""Labels proposed for every frame of a recording, for somebody to correct."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from adibas.data.limbs import FULL_BODY, LABEL_SETS
from adibas.errors import LimbError
from adibas.pipeline.limb_labelling import DeskSetup, LabellingDesk
from adibas.pipeline.session import wanted_frames
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.texts import describe


@dataclass(frozen=True, slots=True)
class ProposingRequest:
    """What to label.

    Attributes
    ----------
    recording : Path
    out : Path
        Folder; what is labelled in it already stays.
    labels : str
        Of `LABEL_SETS`; a folder that exists keeps its own.
    calibration : Path or None
        In place of the recording's own.
    frames : (first, one past the last or None)
    is_done : bool
        The proposals are images to train on, without a look at them.
    rotation_deg : int
        How far the picture is turned clockwise to be upright; see `turn_to_upright`.
    """

    recording: Path
    out: Path
    labels: str = FULL_BODY.name
    calibration: Path | None = None
    frames: tuple[int, int | None] = (0, None)
    is_done: bool = False
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True)
class Proposed:
    """What was labelled.

    Attributes
    ----------
    n_frames, n_known, n_proposed : int
        Frames that were wanted; of these, labelled before; labelled now.
    notices : tuple of (str, int)
        Why others were not, and how many frames that holds for.
    """

    n_frames: int
    n_known: int
    n_proposed: int
    notices: tuple[tuple[str, int], ...]


def propose_recording(request: ProposingRequest, progress: Progress) -> Proposed:
    """Label the frames that nobody has labelled; stopped, it goes on where it stood.

    Raises
    ------
    RecordingError
        The recording cannot be read, or has no such frames.
    CalibrationError
        There is none of the depth camera, or one for another resolution.
    LimbError, FileError
        The folder is of another recording, or cannot be written.
    """
    said: Counter[str] = Counter()
    n_proposed = 0
    with open_recording(request.recording) as recording:
        wanted = wanted_frames(recording, request.frames, request.recording.name)
        desk = LabellingDesk(
            recording,
            request.recording.name,
            request.out,
            DeskSetup(request.calibration, LABEL_SETS[request.labels], request.rotation_deg),
        )
        known = desk.files.progress
        open_frames = [index for index in wanted if index not in known.done | known.begun]
        for number, index in enumerate(open_frames, 1):
            frame = desk.frame(index)
            try:
                labels = desk.proposed(frame)
            except LimbError as error:
                said[describe(error)] += 1
            else:
                desk.files.keep(index, frame.depth_raw, labels, is_done=request.is_done)
                n_proposed += 1
            progress(number, len(open_frames))
    notices = tuple(said.most_common())
    return Proposed(len(wanted), len(wanted) - len(open_frames), n_proposed, notices)
