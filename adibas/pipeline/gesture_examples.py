"""From a folder of joints and events to examples of gestures."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.events import TimedEvent
from adibas.data.joints import JOINT_NAMES
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import GestureError
from adibas.gestures.described_track import DescribedTrack, describe
from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.segments import Examples, Segment, split_names
from adibas.recordings.events_csv import read_events_csv
from adibas.recordings.joints_csv import SUFFIX, read_joints_csv, recording_name
from adibas.texts import message

EVENTS_FILE = "events.csv"
END_SLACK_S = 0.15
"""An event that leaves no more than this at both ends fills its recording."""

Tracks = Mapping[tuple[str, int], SkeletonTrack]


def read_examples(
    folder: Path, params: DescriptorParams, labels: Sequence[str] | None = None
) -> tuple[Examples, str, tuple[Sentence, ...]]:
    """Read a folder with ``*.joints.csv`` and one ``events.csv``.

    Parameters
    ----------
    folder : Path
    params : DescriptorParams
    labels : sequence of str, optional
        Of a model: other gestures are left out, and a notice says so.

    Returns
    -------
    examples : Examples
    rule : str
        By what examples are kept apart: ``subject``, ``recording`` or ``example``.
    notices : tuple of Sentence

    Raises
    ------
    GestureError
        There is nothing to read, or an event is of no recording.
    RecordingError
        A file is broken.
    """
    paths = sorted(folder.glob(f"*{SUFFIX}")) if folder.is_dir() else []
    if not paths:
        raise GestureError(
            "{folder} holds no joints: it must be a folder with files such as "
            "walk.joints.csv and one events.csv.",
            folder=folder.name or str(folder),
        )
    events = read_events_csv(folder / EVENTS_FILE)
    tracks: dict[tuple[str, int], SkeletonTrack] = {}
    notices: list[Sentence] = []
    for path in paths:
        read = read_joints_csv(path)
        notices += read.notices
        notices += unseen_joints(path.name, read.tracks)
        tracks |= {(recording_name(path), track.person): track for track in read.tracks}
    found, rule, more = examples_of(tracks, events, params, labels)
    return found, rule, (*notices, *more)


def examples_of(
    tracks: Tracks,
    events: Sequence[TimedEvent],
    params: DescriptorParams,
    labels: Sequence[str] | None = None,
) -> tuple[Examples, str, tuple[Sentence, ...]]:
    """Return examples of tracks, named by recording and person; see `read_examples`."""
    kept, notices = _usable(tracks, events, labels)
    if not kept:
        raise GestureError("There are no examples of gestures. Mark some in events.csv.")
    names = tuple(labels) if labels is not None else tuple(sorted({one.label for one in kept}))
    places = sorted({(event.recording, event.person) for event in kept})
    streams = [describe(tracks[place], params) for place in places]
    gestures = [
        _segment(event, places.index((event.recording, event.person)), streams, names)
        for event in kept
    ]
    rule, groups = split_names(kept)
    numbers = {name: number for number, name in enumerate(sorted(set(groups)))}
    found = Examples(
        names,
        streams,
        gestures,
        np.array([numbers[group] for group in groups], np.int64),
        _are_isolated(kept, tracks),
    )
    return found, rule, notices


def unseen_joints(file: str, tracks: Sequence[SkeletonTrack]) -> list[Sentence]:
    """Say which joints never appear in a file."""
    sentences = []
    for track in tracks:
        never = [
            name.replace("_", " ")
            for joint, name in enumerate(JOINT_NAMES)
            if not track.seen[:, joint].any()
        ]
        if "neck" in never:
            raise GestureError(
                "{file}: the neck never appears, from which all joints are measured. Record "
                "again with the whole upper body in view.",
                file=file,
            )
        if never:
            sentences.append(
                Sentence(
                    message("{file}: {joints} never appear; the other joints decide."),
                    {"file": file, "joints": ", ".join(never)},
                )
            )
    return sentences


def _usable(
    tracks: Tracks, events: Sequence[TimedEvent], labels: Sequence[str] | None
) -> tuple[list[TimedEvent], tuple[Sentence, ...]]:
    kept, n_points, n_others = [], 0, 0
    for event in events:
        track = tracks.get((event.recording, event.person))
        if track is None:
            raise GestureError(
                "events.csv names person {person} of the recording {recording}, which is not in "
                "the folder. Add {recording}.joints.csv, or remove the event.",
                person=event.person,
                recording=event.recording,
            )
        if event.begin_s > track.times_s[-1] or event.end_s < track.times_s[0]:
            raise GestureError(
                "{label} at {at} s lies outside the recording {recording}. Times are those of "
                "its timestamp_s.",
                label=event.label,
                at=event.begin_s,
                recording=event.recording,
            )
        n_points += event.kind == "point"
        n_others += labels is not None and event.label not in labels
        if event.kind == "state" and (labels is None or event.label in labels):
            kept.append(event)
    told = (
        (n_points, message("Point events have no duration and are left out: {n}.")),
        (n_others, message("Events that are no gestures of this model are left out: {n}.")),
    )
    return kept, tuple(Sentence(text, {"n": n}) for n, text in told if n)


def _segment(
    event: TimedEvent,
    stream: int,
    streams: Sequence[DescribedTrack[FloatArray]],
    labels: Sequence[str],
) -> Segment:
    track = streams[stream]
    begin, end = track.index_at(event.begin_s), track.index_at(event.end_s)
    return Segment(stream, labels.index(event.label), begin, end)


def _are_isolated(events: Sequence[TimedEvent], tracks: Tracks) -> bool:
    if len({(event.recording, event.person) for event in events}) < len(events):
        return False
    return all(_fills(event, tracks[event.recording, event.person]) for event in events)


def _fills(event: TimedEvent, track: SkeletonTrack) -> bool:
    begin_s, end_s = track.times_s[[0, -1]]
    return bool(event.begin_s <= begin_s + END_SLACK_S and event.end_s >= end_s - END_SLACK_S)
