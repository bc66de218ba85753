"""From joints over time to a timeline: activity, posture changes, gestures, and observers beside.

Indicators beside a human's own coding, never a diagnosis or a score.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.behaviour.activity import ActivityParams
from adibas.behaviour.budget import Condition, Span, conditions
from adibas.behaviour.posture_changes import PostureParams, hidden_spans_s, posture_changes_s
from adibas.clock import Clock, to_text, utc_now
from adibas.data.coding import MS_PER_S, Coding, Occurrence, Section, whole_ms
from adibas.data.ethogram import Behaviour, Ethogram, Subject
from adibas.data.events import TimedEvent
from adibas.data.posture import Provenance
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import BehaviourError
from adibas.gestures.descriptor import NECK
from adibas.gestures.model import GestureModel
from adibas.gestures.model_file import read_model
from adibas.pipeline.behaviour_activity import (
    PersonActivity,
    activity_of,
    subject_of,
    under_conditions,
    unseen_while_still,
)
from adibas.pipeline.behaviour_times import check_still, in_ms, sections_of, session_of
from adibas.pipeline.found_joints import FoundJoints, JointSource, find_joints
from adibas.pipeline.gesture_examples import unseen_joints
from adibas.pipeline.gesture_work import detected_events
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.progress import Progress
from adibas.recordings.checksum import recording_sha256
from adibas.recordings.codings import read_codings
from adibas.recordings.ethogram_json import read_ethogram
from adibas.recordings.joints_csv import recording_name
from adibas.texts import message

PROGRAM = "ADiBAS"
POSTURE_CHANGE, OUT_OF_VIEW = "posture change", "out of view"
OWN_SOURCE = "own definition, docs/behaviour.md"

PERSON_OUT_OF_VIEW = message(
    "Person {person} is out of view in {percent} % of the time. What happens then is not in any "
    "figure."
)
FEW_FRAMES = message(
    "The joints come {rate} times a second: faster movements than {half} a second are not seen."
)
OTHER_SESSION = message(
    "{file} holds {n} sessions; the first one, {name}, is shown beside the joints."
)
NO_NECK = message(
    "The neck of person {person} never appears, from which gestures are measured: none is looked "
    "for."
)
ESTIMATED = message(
    "The joints are estimated without markers: how far they wander while somebody is still looks "
    "like movement. Tell a still time with --still."
)
ESTIMATED_STILL = message(
    "The joints are estimated without markers: how far they wander in the still time counts as "
    "noise."
)
SLOWEST_HZ = 20.0


@dataclass(frozen=True, slots=True)
class BehaviourRequest:
    """What to measure.

    Attributes
    ----------
    source : Path
        A table of joints (``.csv``), or a recording in which they are found without markers.
    models : tuple of Path
        Of gestures, to be found.
    ethogram : Path or None
        For the coding, and for what gestures are called in the report.
    coding : Path or None
        Of a human observer, beside.
    sections : tuple of (name, begin_s, end_s)
        Conditions; added to those of the coding.
    bin_s : float
        Length of a time bin.
    patient : str
        A pseudonym or empty.
    access : RecordingAccess
        How the recording is opened: usually as a file.
    joints : FoundJoints or None
        Of the same recording, found before; None: they are read or found now.
    name : str
        What the recording is called, or several together; empty: as its file.
    parts : tuple of str
        Names of the recordings, where several are watched as one.
    rotation_deg : int
        How far the picture is turned clockwise to be upright; see `turn_to_upright`.
    view : str
        Which side everybody shows to the camera, ``anterior`` or ``posterior``; empty: found out.
    """

    source: Path
    models: tuple[Path, ...] = ()
    ethogram: Path | None = None
    coding: Path | None = None
    sections: tuple[tuple[str, float, float], ...] = ()
    bin_s: float = 60.0
    patient: str = ""
    activity: ActivityParams = field(default_factory=ActivityParams)
    posture: PostureParams = field(default_factory=PostureParams)
    access: RecordingAccess = FILES
    joints: FoundJoints | None = None
    name: str = ""
    parts: tuple[str, ...] = ()
    rotation_deg: int = 0
    view: str = ""

    @property
    def called(self) -> str:
        """Return what the recording is called in the report."""
        return self.name or recording_name(self.source)

    @property
    def joint_source(self) -> JointSource:
        """Return where the joints come from."""
        return JointSource(self.source, self.access, self.rotation_deg, self.view)


@dataclass(frozen=True, slots=True, eq=False)
class BehaviourAnalysis:
    """A timeline and all that is counted in it.

    Attributes
    ----------
    recording, patient : str
    people : tuple of PersonActivity
    detected : Coding
        What the program saw, with its sections.
    observed : Coding or None
        What a human observer coded.
    bin_ms : int
    provenance : Provenance
    notices : tuple of Sentence
    joints : FoundJoints
        What all this was measured in.
    parts : tuple of str
        Names of the recordings that were watched as one; empty where there was one.
    """

    recording: str
    patient: str
    people: tuple[PersonActivity, ...]
    detected: Coding
    observed: Coding | None
    bin_ms: int
    provenance: Provenance
    notices: tuple[Sentence, ...]
    joints: FoundJoints
    parts: tuple[str, ...] = ()


def analyse_behaviour(
    request: BehaviourRequest, progress: Progress, clock: Clock = utc_now
) -> BehaviourAnalysis:
    """Measure the behaviour in a table of joints, or in a recording.

    Raises
    ------
    RecordingError, CalibrationError, LimbError, GestureError, BehaviourError
        A file cannot be used.
    """
    joints = request.joints or find_joints(request.joint_source, progress, clock)
    tracks, notices = joints.tracks, _of_joints(joints, request.activity)
    name = request.called
    ethogram = None if request.ethogram is None else read_ethogram(request.ethogram)
    observed, more = _observed(request, ethogram)
    notices += more
    models = [read_model(path) for path in request.models]
    session_ms = session_of(tracks, observed)
    sections = sections_of(request.sections, observed, session_ms)
    if request.activity.still_s is not None:
        check_still(request.activity.still_s, session_ms)
    occurrences: list[Occurrence] = []
    people: list[PersonActivity] = []
    total = len(tracks)
    for number, track in enumerate(tracks):
        progress(number, total)
        if models:
            notices += _unseen(request.source.name, track)
        found = _occurrences(name, track, models, session_ms, request)
        occurrences += found
        notices += _notices(track, found, session_ms)
        people.append(activity_of(track, sections, session_ms, request.activity))
        notices += unseen_while_still(people[-1], request.activity)
    progress(total, total)
    scheme = program_ethogram(models, [track.person for track in tracks], ethogram)
    detected = Coding(name, scheme, *session_ms, tuple(occurrences), PROGRAM, sections)
    return BehaviourAnalysis(
        *(name, request.patient, tuple(people), detected, observed),
        max(whole_ms(request.bin_s), 1),
        _provenance(request, clock),
        _once(notices),
        joints,
        request.parts,
    )


def divided(
    analysis: BehaviourAnalysis, sections: Sequence[Section], bin_ms: int
) -> BehaviourAnalysis:
    """Return the same analysis with other sections, cut to its time, and other time bins."""
    begin_ms, end_ms = analysis.detected.begin_ms, analysis.detected.end_ms
    inside = tuple(
        replace(one, begin_ms=max(one.begin_ms, begin_ms), end_ms=min(one.end_ms, end_ms))
        for one in sections
        if one.begin_ms < end_ms and one.end_ms > begin_ms
    )
    return replace(
        analysis,
        people=tuple(
            under_conditions(person, inside, (begin_ms, end_ms)) for person in analysis.people
        ),
        detected=replace(analysis.detected, sections=inside),
        bin_ms=bin_ms,
    )


def _of_joints(joints: FoundJoints, params: ActivityParams) -> list[Sentence]:
    """Return what is to be said of the joints: nobody is asked for a still time that is told."""
    if not joints.is_estimated:
        return list(joints.notices)
    told = ESTIMATED if params.still_s is None else ESTIMATED_STILL
    return [Sentence(told), *joints.notices]


def _unseen(file: str, track: SkeletonTrack) -> list[Sentence]:
    if track.seen[:, NECK].any():
        return unseen_joints(file, [track])
    return [Sentence(NO_NECK, {"person": track.person})]


def program_ethogram(
    models: Sequence[GestureModel], people: Sequence[int], ethogram: Ethogram | None
) -> Ethogram:
    """Return the ethogram of what the program can see; descriptions as in the observer's."""
    known = {one.name: one for one in ethogram.behaviours} if ethogram is not None else {}
    gestures = dict.fromkeys(label for model in models for label in model.labels)
    behaviours = [
        Behaviour(
            label,
            description=known[label].description if label in known else "",
            category="gesture",
            sources=known[label].sources if label in known else (),
        )
        for label in gestures
    ]
    behaviours += [
        Behaviour(POSTURE_CHANGE, "point", category="posture", sources=(OWN_SOURCE,)),
        Behaviour(OUT_OF_VIEW, "state", category="view", sources=(OWN_SOURCE,)),
    ]
    return Ethogram(PROGRAM, tuple(behaviours), tuple(Subject(subject_of(p)) for p in people))


def observed_conditions(analysis: BehaviourAnalysis) -> tuple[Condition, ...]:
    """Return the conditions of what an observer coded; those of the program where nobody did."""
    return conditions(analysis.detected if analysis.observed is None else analysis.observed)


def _observed(
    request: BehaviourRequest, ethogram: Ethogram | None
) -> tuple[Coding | None, list[Sentence]]:
    if request.coding is None:
        return None, []
    found = read_codings(request.coding, ethogram)
    if not found:
        raise BehaviourError("{file} holds no session.", file=request.coding.name)
    name = request.called
    chosen = next((one for one in found if one.name == name), found[0])
    if len(found) == 1 or chosen.name == name:
        return chosen, []
    told = {"file": request.coding.name, "n": len(found), "name": chosen.name}
    return chosen, [Sentence(OTHER_SESSION, told)]


def _occurrences(
    name: str,
    track: SkeletonTrack,
    models: Sequence[GestureModel],
    session_ms: Span,
    request: BehaviourRequest,
) -> list[Occurrence]:
    subject = subject_of(track.person)
    found: list[Occurrence] = []
    if models and track.seen[:, NECK].any():
        found += gesture_occurrences(detected_events(name, track, models), subject)
    session_s = (session_ms[0] / MS_PER_S, session_ms[1] / MS_PER_S)
    for begin, end in hidden_spans_s(track, session_s, request.posture):
        found.append(Occurrence(OUT_OF_VIEW, *in_ms((begin, end)), subject))
    for at in posture_changes_s(track, request.posture):
        moment, _same = in_ms((float(at), float(at)))
        found.append(Occurrence(POSTURE_CHANGE, moment, moment, subject))
    return found


def gesture_occurrences(events: Sequence[TimedEvent], subject: str) -> list[Occurrence]:
    """Return detected gestures; where the same one overlaps with itself, the later begins after."""
    found: list[Occurrence] = []
    ends: dict[str, int] = {}
    for event in sorted(events, key=lambda one: one.begin_s):
        begin, end = in_ms((event.begin_s, event.end_s))
        begin = max(begin, ends.get(event.label, begin))
        if end >= begin:
            found.append(Occurrence(event.label, begin, end, subject))
            ends[event.label] = end
    return found


def _notices(track: SkeletonTrack, found: Sequence[Occurrence], session_ms: Span) -> list[Sentence]:
    notices = []
    hidden_ms = sum(one.duration_ms for one in found if one.behaviour == OUT_OF_VIEW)
    length_ms = session_ms[1] - session_ms[0]
    if hidden_ms and length_ms:
        told = {"person": track.person, "percent": 100.0 * hidden_ms / length_ms}
        notices.append(Sentence(PERSON_OUT_OF_VIEW, told))
    if len(track) > 1:
        rate_hz = 1.0 / float(np.median(np.diff(track.times_s)))
        if rate_hz < SLOWEST_HZ:
            notices.append(Sentence(FEW_FRAMES, {"rate": rate_hz, "half": rate_hz / 2}))
    return notices


def _once(notices: Sequence[Sentence]) -> tuple[Sentence, ...]:
    return tuple({notice.text: notice for notice in notices}.values())


def _provenance(request: BehaviourRequest, clock: Clock) -> Provenance:
    parameters: dict[str, object] = {
        "activity": asdict(request.activity),
        "posture": asdict(request.posture),
        "bin_s": request.bin_s,
        "rotation_deg": request.rotation_deg,
        "view": request.view,
    }
    if request.models:
        parameters["models_sha256"] = [recording_sha256(path) for path in request.models]
    if request.coding is not None:
        parameters["coding_sha256"] = recording_sha256(request.coding)
    return Provenance(
        request.access.sha256(request.source), "", __version__, to_text(clock()), parameters
    )
