"""An exercise of a patient beside the therapist's, from two tables of joints or recordings."""

from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.clock import Clock, to_text, utc_now
from adibas.data.movement import Movement, Origin
from adibas.data.posture import Provenance
from adibas.data.sentence import Sentence
from adibas.errors import GestureError
from adibas.gestures.exercise import (
    AngleTrack,
    ExerciseModel,
    ExerciseParams,
    Repetition,
    exercise_model,
    repetitions,
)
from adibas.movement.measuring import MovementParams
from adibas.pipeline.movement import MovementRequest, measure_moving
from adibas.pipeline.posture import PostureParams
from adibas.progress import Progress
from adibas.recordings.checksum import recording_sha256
from adibas.texts import message
from adibas.timeseries.lowpass import resample

NONE_FOUND = message(
    "No repetition was found: nothing in the recording is as near to the therapist's movement as "
    "it is to standing still."
)
LONGEST_GAP_S = 0.5


@dataclass(frozen=True, slots=True)
class ExerciseRequest:
    """What to compare.

    Attributes
    ----------
    patient, therapist : Path
        Tables of joints, or recordings in which they are found without markers.
    shown_s : (float, float) or None
        Which part of the therapist's recording is one repetition, from its first frame; all of it
        if not given.
    person : int or None
        Who is the patient; the one who was seen longest if not given.
    pseudonym : str
    params : ExerciseParams
    rotation_deg : int
        How far the picture of the camera is turned clockwise to be upright; both are before one.
    """

    patient: Path
    therapist: Path
    shown_s: tuple[float, float] | None = None
    person: int | None = None
    pseudonym: str = ""
    params: ExerciseParams = field(default_factory=ExerciseParams)
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class ExerciseCheck:
    """What came of it.

    Attributes
    ----------
    model : ExerciseModel
    shown_origin, done_origin : str
        Where the therapist's and the patient's joints come from; see `Movement`.
    done : AngleTrack
        The patient's angles, from the first frame on.
    repetitions : tuple of Repetition
    patient : str
        A pseudonym.
    provenance : Provenance
    notices : tuple of Sentence
    """

    model: ExerciseModel
    shown_origin: Origin
    done_origin: Origin
    done: AngleTrack
    repetitions: tuple[Repetition, ...]
    patient: str
    provenance: Provenance
    notices: tuple[Sentence, ...]


def check_exercise(
    request: ExerciseRequest, progress: Progress, clock: Clock = utc_now
) -> ExerciseCheck:
    """Find and compare the repetitions of a patient.

    Raises
    ------
    RecordingError, CalibrationError, LimbError, GestureError
        A file cannot be used, or the therapist's has no movement.
    """
    shown, done = (
        measure_moving(
            MovementRequest(
                source,
                is_markerless=True,
                person=person,
                posture=PostureParams(rotation_deg=request.rotation_deg),
                movement=MovementParams(takes_upright=True),
            ),
            progress,
            clock,
        )
        for source, person in ((request.therapist, None), (request.patient, request.person))
    )
    rate_hz = request.params.rate_hz
    model = exercise_model(_part(angle_track(shown, rate_hz), request.shown_s), request.params)
    patient = angle_track(done, rate_hz)
    found = repetitions(model, patient, request.params)
    provenance = Provenance(
        recording_sha256(request.patient),
        "",
        __version__,
        to_text(clock()),
        {
            **asdict(request.params),
            "rotation_deg": request.rotation_deg,
            "therapist_sha256": recording_sha256(request.therapist),
        },
    )
    notices = [*shown.notices, *done.notices]
    if not found:
        notices.append(Sentence(NONE_FOUND))
    told = tuple({one.text: one for one in notices}.values())
    return ExerciseCheck(
        *(model, shown.origin, done.origin, patient, found, request.pseudonym, provenance, told)
    )


def angle_track(movement: Movement, rate_hz: float) -> AngleTrack:
    """Return the angles of a movement at a steady rate, from 0 s on."""
    times_s = np.arange(int(movement.times_s[-1] * rate_hz + 1e-6) + 1) / rate_hz
    names = tuple(curve.name for curve in movement.curves)
    deg = np.column_stack([curve.deg for curve in movement.curves])
    return AngleTrack(0.0, rate_hz, names, resample(movement.times_s, deg, times_s, LONGEST_GAP_S))


def _part(shown: AngleTrack, span_s: tuple[float, float] | None) -> AngleTrack:
    if span_s is None:
        return shown
    first, last = (round(time * shown.rate_hz) for time in span_s)
    if last >= len(shown.deg) + 1 or last <= first:
        raise GestureError(
            "The therapist's recording ends at {end} s. Give a repetition within it.",
            end=round((len(shown.deg) - 1) / shown.rate_hz, 2),
        )
    return AngleTrack(span_s[0], shown.rate_hz, shown.names, shown.deg[first : last + 1])
