"""Pieces of described streams: what was done in them, and all of them at one length."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.data.events import TimedEvent
from adibas.gestures.described_track import DescribedTrack

N_FRAMES = 16
"""Length of a segment when segments are compared: enough for the strokes of a wave."""


@dataclass(frozen=True, slots=True)
class Segment:
    """Frames `begin` to `end`, both included, of one described stream.

    Attributes
    ----------
    stream : int
        Which of the streams.
    label : int
        What is or may be done there.
    begin, end : int
    cost : float
        Of the alignment that proposed it; 0 where a human said so.
    """

    stream: int
    label: int
    begin: int
    end: int
    cost: float = 0.0

    def overlap(self, other: "Segment") -> float:
        """Return intersection over union in frames; 0 in another stream."""
        if self.stream != other.stream:
            return 0.0
        shared = min(self.end, other.end) - max(self.begin, other.begin) + 1
        spanned = max(self.end, other.end) - min(self.begin, other.begin) + 1
        return max(0, shared) / spanned


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """Described streams and what is done in them.

    Attributes
    ----------
    labels : tuple of str
        In alphabetical order.
    streams : sequence of DescribedTrack
    gestures : sequence of Segment
    groups : (len(gestures),) integer array
        Who did it: gestures of one group are never on both sides of a split.
    is_isolated : bool
        Each stream is one gesture from end to end.
    """

    labels: tuple[str, ...]
    streams: Sequence[DescribedTrack[FloatArray]]
    gestures: Sequence[Segment]
    groups: IntArray
    is_isolated: bool
    _by_stream: dict[int, list[Segment]] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        for gesture in self.gestures:
            self._by_stream.setdefault(gesture.stream, []).append(gesture)

    def frames_of(self, segment: Segment) -> FloatArray:
        """Return the descriptors of a segment."""
        return self.streams[segment.stream].frames[segment.begin : segment.end + 1]

    def in_stream(self, stream: int) -> Sequence[Segment]:
        """Return the gestures in one stream."""
        return self._by_stream.get(stream, ())

    def marked(self, stream: int) -> BoolArray:
        """Return which frames (T,) of a stream are of a gesture."""
        marked = np.zeros(len(self.streams[stream].frames), bool)
        for gesture in self.in_stream(stream):
            marked[gesture.begin : gesture.end + 1] = True
        return marked

    def picked(self, kept: BoolArray) -> "Examples":
        """Return the examples whose place in `kept` (k,) is true; the streams stay."""
        gestures = [gesture for gesture, keep in zip(self.gestures, kept, strict=True) if keep]
        return Examples(self.labels, self.streams, gestures, self.groups[kept], self.is_isolated)

    def fewest_left(self) -> IntArray:
        """Return (labels,): examples of each gesture without the group that has most of them."""
        found = np.zeros(len(self.labels), np.int64)
        for label in range(len(self.labels)):
            mine = self.groups[[gesture.label == label for gesture in self.gestures]]
            found[label] = len(mine) - np.bincount(mine).max(initial=0)
        return found

    def without(self, held: BoolArray) -> "Examples":
        """Return the examples that are not `held` (k,), and streams in which the held are blank.

        Left in an otherwise kept stream they would be learned as what is no gesture. Where a kept
        one is done at the same time, its frames stay.
        """
        kept = self.picked(~held)
        streams = list(self.streams)
        for number, track in enumerate(self.streams):
            blank = self.marked(number) & ~kept.marked(number)
            if kept.in_stream(number) and blank.any():
                frames = np.where(blank[:, None], np.nan, track.frames)
                streams[number] = replace(track, frames=frames)
        return replace(kept, streams=streams)


def split_names(events: Sequence[TimedEvent]) -> tuple[str, list[str]]:
    """Return by what examples are kept apart, and the name of each event's group.

    By subject; where there is only one, by recording; where there is only one, each by itself.
    """
    for rule, names in (
        ("subject", [event.who for event in events]),
        ("recording", [event.recording for event in events]),
    ):
        if len(set(names)) > 1:
            return rule, names
    return "example", [str(number) for number in range(len(events))]


def at_one_length(frames: FloatArray, n_frames: int = N_FRAMES) -> FloatArray:
    """Return (n_frames, d): a segment stretched or squeezed evenly; NaN where nothing is near."""
    places = np.linspace(0, len(frames) - 1, n_frames)
    before = np.minimum(places.astype(np.int64), max(len(frames) - 2, 0))
    after = np.minimum(before + 1, len(frames) - 1)
    share = (places - before)[:, None]
    mixed = frames[before] * (1 - share) + frames[after] * share
    nearest = np.where(share < 0.5, frames[before], frames[after])  # noqa: PLR2004
    return np.where(np.isfinite(mixed), mixed, nearest)
