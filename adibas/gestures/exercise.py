"""Repetitions of an exercise beside the therapist's: found, divided into phases, compared.

A repetition is a stretch of the patient's movement that aligns with the therapist's at less than
`ExerciseParams.largest_cost` of what standing still would cost: 1 is somebody who does not move, 0
one who moves as the therapist. Half the range of movement costs about a half.

Source: the warping of thesis, section 7.1.1; what is compared follows the exercise check of the
authors' later work (range, phases, tempo, symmetry).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d

from adibas.arrays import FloatArray
from adibas.errors import GestureError
from adibas.gestures.model import not_overlapping
from adibas.gestures.segments import Segment
from adibas.timeseries.dtw import warping_path
from adibas.timeseries.gaps import bridged
from adibas.timeseries.stream import StreamAligner

SHORTEST = 4
"""Frames of a model."""


@dataclass(frozen=True, slots=True)
class ExerciseParams:
    """How repetitions are found and compared.

    Attributes
    ----------
    rate_hz : float
        Of the angles: 15.
    least_range_deg : float
        An angle that the therapist moves less is no part of the exercise: 15.
    largest_cost : float
        Of a repetition, as a share of what standing still costs: 0.65.
    tempos : tuple of float
        The model is held against the patient at these durations; alignment bridges half to twice
        each of them: 0.5, 1 and 2.
    hold_share : float
        Of the greatest excursion, above which the position is held: 0.9.
    edge_share : float
        Of it, below which the repetition has not begun: 0.05.
    """

    rate_hz: float = 15.0
    least_range_deg: float = 15.0
    largest_cost: float = 0.65
    tempos: tuple[float, ...] = (0.5, 1.0, 2.0)
    hold_share: float = 0.9
    edge_share: float = 0.05

    def __post_init__(self) -> None:
        if min(self.rate_hz, self.least_range_deg, self.largest_cost, *self.tempos) <= 0:
            raise ValueError("rates, ranges, costs and tempos must be above zero")
        if not 0 < self.edge_share < self.hold_share < 1:
            raise ValueError("edge_share must be below hold_share, both between 0 and 1")


@dataclass(frozen=True, slots=True, eq=False)
class AngleTrack:
    """Joint angles at a steady rate.

    Attributes
    ----------
    begin_s, rate_hz : float
    names : tuple of str
    deg : (T, A) array
        NaN where not seen.
    """

    begin_s: float
    rate_hz: float
    names: tuple[str, ...]
    deg: FloatArray

    def time_s(self, index: int) -> float:
        """Return when frame `index` was."""
        return self.begin_s + index / self.rate_hz

    def picked(self, names: Sequence[str]) -> "AngleTrack":
        """Return some of the angles."""
        columns = [self.names.index(name) for name in names]
        return AngleTrack(self.begin_s, self.rate_hz, tuple(names), self.deg[:, columns])


@dataclass(frozen=True, slots=True, eq=False)
class ExerciseModel:
    """One repetition of the therapist.

    Attributes
    ----------
    angles : AngleTrack
        Of the angles that take part, from the first to the last frame of the movement.
    hold : (int, int)
        First and last frame in which the position is held; before it the way out, behind it back.
    still_cost : float
        What standing still in the first position costs, degrees.
    """

    angles: AngleTrack
    hold: tuple[int, int]
    still_cost: float

    @property
    def duration_s(self) -> float:
        """Return how long the repetition lasts."""
        return (len(self.angles.deg) - 1) / self.angles.rate_hz


@dataclass(frozen=True, slots=True, eq=False)
class Repetition:
    """One repetition of the patient beside the model.

    Attributes
    ----------
    begin_s, end_s : float
    cost : float
        0 as the therapist, 1 as standing still.
    phases_s : (float, float, float)
        The way out, holding, the way back.
    low_deg, high_deg : (A,) arrays
        Extremes of each angle; NaN where it was not seen.
    deviation_deg : (M, A) array
        Patient minus therapist at each frame of the model; NaN where not seen.
    """

    begin_s: float
    end_s: float
    cost: float
    phases_s: tuple[float, float, float]
    low_deg: FloatArray
    high_deg: FloatArray
    deviation_deg: FloatArray

    @property
    def duration_s(self) -> float:
        """Return how long it lasts."""
        return self.end_s - self.begin_s

    @property
    def range_deg(self) -> FloatArray:
        """Return (A,): how far each angle went."""
        return self.high_deg - self.low_deg


def exercise_model(shown: AngleTrack, params: ExerciseParams | None = None) -> ExerciseModel:
    """Return the model of one repetition that the therapist shows.

    Raises
    ------
    GestureError
        No angle moves enough, or the movement is too short.
    """
    params = params or ExerciseParams()
    names = tuple(
        name
        for name, curve in zip(shown.names, shown.deg.T, strict=True)
        if np.isfinite(curve).mean() >= 0.5  # noqa: PLR2004
        and np.nanmax(curve) - np.nanmin(curve) >= params.least_range_deg
    )
    if not names:
        raise GestureError(
            "The therapist moves no joint by {least} degrees or more: nothing can be compared. "
            "Record one whole repetition.",
            least=params.least_range_deg,
        )
    angles = shown.picked(names)
    deg = bridged(angles.deg)
    excursion = np.linalg.norm(deg - deg[0], axis=1)
    moving = np.flatnonzero(excursion >= params.edge_share * excursion.max())
    first, last = _to_rest(excursion, (int(moving[0]), int(moving[-1])), (0, len(deg) - 1))
    if last - first + 1 < SHORTEST:
        raise GestureError("The therapist's repetition is too short. Record it again, whole.")
    cut = deg[first : last + 1]
    away = np.linalg.norm(cut - cut[0], axis=1)
    held = np.flatnonzero(away >= params.hold_share * away.max())
    model = AngleTrack(angles.time_s(first), angles.rate_hz, names, cut)
    return ExerciseModel(model, (int(held[0]), int(held[-1])), float(away.mean()))


def repetitions(
    model: ExerciseModel, done: AngleTrack, params: ExerciseParams | None = None
) -> tuple[Repetition, ...]:
    """Return the patient's repetitions in the order of time.

    Raises
    ------
    GestureError
        An angle of the exercise was never seen.
    """
    params = params or ExerciseParams()
    patient = done.picked(model.angles.names)
    for name, curve in zip(patient.names, patient.deg.T, strict=True):
        if not np.isfinite(curve).any():
            raise GestureError(
                "The angle {angle}, which the therapist moves, is never seen in the patient. "
                "Record again with the whole movement in view.",
                angle=name.replace("_", " "),
            )
    found = _whole(_found(model, patient, params), model, patient)
    return tuple(_compared(model, patient, one) for one in found)


def _found(model: ExerciseModel, patient: AngleTrack, params: ExerciseParams) -> list[Segment]:
    """Return the cheapest stretches that do not overlap."""
    templates = [
        _at_length(model.angles.deg, max(round(tempo * len(model.angles.deg)), SHORTEST))
        for tempo in params.tempos
    ]
    aligner = StreamAligner(templates)
    # The root mean square over angles, as the model's own cost is a norm over all of them.
    costs, starts = aligner.feed(patient.deg)
    shares = costs / model.still_cost
    reach = max(min(map(len, templates)) // 2, 1)
    is_least = shares <= minimum_filter1d(shares, 2 * reach + 1, axis=0, mode="nearest")
    good = is_least & (shares <= params.largest_cost)
    segments = [
        Segment(0, 0, int(starts[end, tempo]), int(end), float(shares[end, tempo]))
        for end, tempo in np.argwhere(good)
        if end - starts[end, tempo] + 1 >= SHORTEST
    ]
    return not_overlapping(segments)


def _whole(segments: list[Segment], model: ExerciseModel, patient: AngleTrack) -> list[Segment]:
    """Return the segments from rest to rest: widened while the patient comes nearer to it.

    An alignment may leave out the slow first and last frames, and their share of the range.
    """
    rest = bridged(patient.deg) - model.angles.deg[0]
    away = np.linalg.norm(rest, axis=1)
    bounds = [-1, *(k for one in segments for k in (one.begin, one.end)), len(away)]
    found = []
    for place, one in enumerate(segments):
        within = (bounds[2 * place] + 1, bounds[2 * place + 3] - 1)
        found.append(Segment(0, 0, *_to_rest(away, (one.begin, one.end), within), one.cost))
    return found


def _to_rest(away: FloatArray, span: tuple[int, int], within: tuple[int, int]) -> tuple[int, int]:
    """Return the span, widened while the distance from rest falls."""
    begin, end = span
    while begin - 1 >= within[0] and away[begin - 1] < away[begin]:
        begin -= 1
    while end + 1 <= within[1] and away[end + 1] < away[end]:
        end += 1
    return begin, end


def _compared(model: ExerciseModel, patient: AngleTrack, found: Segment) -> Repetition:
    seen = patient.deg[found.begin : found.end + 1]
    _cost, path = warping_path(bridged(seen), model.angles.deg)
    n_frames, n_angles = model.angles.deg.shape
    sums, counts = np.zeros((2, n_frames, n_angles))
    for mine, theirs in path:
        known = np.isfinite(seen[mine])
        sums[theirs, known] += seen[mine, known] - model.angles.deg[theirs, known]
        counts[theirs, known] += 1
    with np.errstate(invalid="ignore", divide="ignore"):
        deviation = np.where(counts > 0, sums / counts, np.nan)
    first = int(path[path[:, 1] >= model.hold[0], 0].min())
    last = int(path[path[:, 1] <= model.hold[1], 0].max())
    step_s = 1.0 / patient.rate_hz
    phases = (first * step_s, (last - first) * step_s, (len(seen) - 1 - last) * step_s)
    known = np.isfinite(seen).any(axis=0)
    low, high = np.full((2, n_angles), np.nan)
    low[known], high[known] = np.nanmin(seen[:, known], axis=0), np.nanmax(seen[:, known], axis=0)
    return Repetition(
        *(patient.time_s(found.begin), patient.time_s(found.end), found.cost, phases),
        *(low, high, deviation),
    )


def _at_length(deg: FloatArray, n_frames: int) -> FloatArray:
    places = np.linspace(0, len(deg) - 1, n_frames)
    index = np.arange(len(deg))
    return np.column_stack([np.interp(places, index, column) for column in deg.T])
