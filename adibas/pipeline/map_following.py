"""The camera's path through a recording, kept on the way so that it goes on after a break."""

from dataclasses import dataclass

import numpy as np

from adibas.alignment.camera_track import KeyFrameParams, Track
from adibas.alignment.key_frames import Tracker
from adibas.alignment.pairing import ByShape, Moment
from adibas.alignment.sights import see
from adibas.arrays import IntArray
from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame
from adibas.data.sentence import Sentence
from adibas.pipeline.in_order import in_order
from adibas.pipeline.map_frames import REASONS, MapFrames, Shown
from adibas.pipeline.map_preview import GrowingPicture, MapWatch
from adibas.pipeline.map_state import Keeper, Unfinished
from adibas.progress import Progress
from adibas.texts import Message, message

N_THREADS = 2
JUMP_S = 1.0
WENT_ON = message(
    "An earlier run was interrupted after {done} of {total} frames; this one went on."
)


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """Where the camera was.

    Attributes
    ----------
    indices, times_ns : (M,) arrays
        Of the frames that were followed.
    track : Track
        Of them.
    left_out : tuple of Message
        Why each of the others was left out.
    notices : tuple of Sentence
        On what an earlier run had kept.
    """

    indices: IntArray
    times_ns: IntArray
    track: Track
    left_out: tuple[Message, ...]
    notices: tuple[Sentence, ...]

    @property
    def n_jumps(self) -> int:
        """How often more than a second lies between two frames."""
        return int((np.diff(self.times_ns) > JUMP_S * NS_PER_S).sum())


class Follower:
    """Goes through frames once, from where an earlier run stood.

    Parameters
    ----------
    keeper : Keeper or None
        Nothing is kept without one.
    watch : callable or None
        Is told of every new key-frame.
    """

    def __init__(
        self,
        frames: MapFrames,
        params: KeyFrameParams,
        keeper: Keeper | None = None,
        watch: MapWatch | None = None,
    ) -> None:
        self._frames = frames
        self._params = params
        self._keeper = keeper
        self._watch = watch
        self._growing = GrowingPicture()

    def follow(self, progress: Progress) -> Followed:
        """Follow the camera; what stops it on the way leaves its state with the keeper.

        Raises
        ------
        RecordingError, CalibrationError
            As frames raise them.
        FileError
            The state cannot be kept.
        """
        before = None if self._keeper is None else self._keeper.load()
        notices = [Sentence(before)] if isinstance(before, Message) else []
        known = before if isinstance(before, Unfinished) else Unfinished()
        self._indices, self._times_ns = list(known.indices), list(known.times_ns)
        self._next_index = known.next_index
        frames = self._frames
        frames.left_out = {index: REASONS[why] for index, why in known.left_out.items()}
        aligner = ByShape(frames.level, self._params.turning) if frames.is_body else None
        self._tracker = Tracker(self._recall, self._params, known.following, aligner)
        if known.indices:
            done = known.next_index - frames.wanted.start
            notices.append(Sentence(WENT_ON, {"done": done, "total": len(frames)}))
        self._is_between_frames, is_through = True, False
        try:
            self._go_on(progress)
            is_through = True
        finally:
            if not is_through:
                self._keep_interrupted()
        return Followed(
            np.array(self._indices, np.int64),
            np.array(self._times_ns, np.int64),
            self._tracker.track(),
            tuple(frames.left_out.values()),
            tuple(notices),
        )

    def _keep_interrupted(self) -> None:
        if self._keeper is not None and self._indices and self._is_between_frames:
            self._keeper.keep(self._state())

    def _go_on(self, progress: Progress) -> None:
        frames = self._frames
        last_ns = self._times_ns[-1] if self._times_ns else None
        coming = frames.usable(self._next_index, last_ns)
        with in_order(self._prepare, coming, N_THREADS) as prepared:
            for shown, moment in prepared:
                self._is_between_frames = False
                self._add(shown, moment)
                self._is_between_frames = True
                progress(shown.index + 1 - frames.wanted.start, 2 * len(frames))
        self._next_index = frames.wanted.stop
        if self._keeper is not None and self._indices:
            self._keeper.keep(self._state())

    def _add(self, shown: Shown, moment: Moment | Message) -> None:
        self._next_index = shown.index + 1
        if isinstance(moment, Message):
            self._frames.left_out[shown.index] = moment
            return
        self._indices.append(shown.index)
        self._times_ns.append(shown.time_ns)
        self._tracker.add(moment)
        self._show(shown, moment)
        if self._keeper is not None:
            self._keeper.keep_at_times(self._state)

    def _prepare(self, numbered: tuple[int, SensorFrame]) -> tuple[Shown, Moment | Message]:
        shown, lack = self._frames.show(numbered)
        return shown, self._moment(shown) if lack is None else lack

    def _recall(self, number: int) -> Moment:
        shown, _ = self._frames.show(self._frames.read(self._indices[number]))
        return self._moment(shown)

    def _moment(self, shown: Shown) -> Moment:
        sight = see(shown.depth_m, shown.color_rgb, self._frames.calibration)
        return Moment(sight, self._params.pairing.features)

    def _state(self) -> Unfinished:
        left_out = {
            index: REASONS.index(why)
            for index, why in self._frames.left_out.items()
            if index < self._next_index
        }
        return Unfinished(
            self._next_index,
            tuple(self._indices),
            tuple(self._times_ns),
            left_out,
            self._tracker.following,
        )

    def _show(self, shown: Shown, moment: Moment) -> None:
        """Tell of a new key-frame; after a break, of those before it too."""
        if self._watch is None:
            return
        keys = self._tracker.keys
        if keys[-1] != len(self._indices) - 1:
            return
        if len(keys) == 1:
            self._growing = GrowingPicture()
        for number in keys[len(self._growing) : -1]:
            earlier, _ = self._frames.show(self._frames.read(self._indices[number]))
            self._growing.add(self._moment(earlier).sight, earlier.color_rgb)
        self._growing.add(moment.sight, shown.color_rgb)
        self._watch(self._growing.picture(self._tracker.world_from_key))
