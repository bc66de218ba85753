"""Joints of everybody over time: of a table, or found in a recording without markers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from adibas.clock import Clock, utc_now
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.pipeline.pose import PoseRequest, pose_recording
from adibas.pipeline.pose_following import PoseParams
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.progress import Progress
from adibas.recordings.joints_csv import is_joint_table, read_joints_csv


@dataclass(frozen=True, slots=True)
class JointSource:
    """Where joints come from.

    Attributes
    ----------
    path : Path
        A table of joints (``.csv``), or a recording.
    access : RecordingAccess
        How the recording is opened: usually as a file.
    rotation_deg : int
        How far the picture is turned clockwise to be upright; see `turn_to_upright`.
    view : str
        Which side everybody shows to the camera, ``anterior`` or ``posterior``; empty: found out.
    """

    path: Path
    access: RecordingAccess = FILES
    rotation_deg: int = 0
    view: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class FoundJoints:
    """Joints of everybody over time, in axes in which they are upright, and what is to be said.

    Attributes
    ----------
    tracks : tuple of SkeletonTrack
    notices : tuple of Sentence
    is_estimated : bool
        They were found now, without markers; where a table has them from is not known.
    """

    tracks: tuple[SkeletonTrack, ...]
    notices: tuple[Sentence, ...] = ()
    is_estimated: bool = False


def find_joints(source: JointSource, progress: Progress, clock: Clock = utc_now) -> FoundJoints:
    """Return the joints of everybody.

    Raises
    ------
    RecordingError, CalibrationError, LimbError
        The file cannot be used, or nobody is in it.
    """
    if is_joint_table(source.path):
        read = read_joints_csv(source.path)
        turn = QuarterTurn(source.rotation_deg // 90)
        return FoundJoints(_upright(read.tracks, turn), tuple(read.notices))
    asked = PoseRequest(
        source.path,
        pose=PoseParams(view=source.view),
        access=source.access,
        rotation_deg=source.rotation_deg,
    )
    posed = pose_recording(asked, progress, clock)
    return FoundJoints(_upright(posed.tracks, posed.turn), posed.notices, is_estimated=True)


def _upright(tracks: Sequence[SkeletonTrack], turn: QuarterTurn) -> tuple[SkeletonTrack, ...]:
    """Return tracks as gestures are learned: of people who stand upright in the turned picture."""
    if turn.n_quarters == 0:
        return tuple(tracks)
    return tuple(replace(track, joints_m=turn.points(track.joints_m)) for track in tracks)
