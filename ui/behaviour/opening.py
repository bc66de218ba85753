"""Opens a recording, or several as one, with what is coded of it. Knows nothing of Qt."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from adibas.behaviour.editing import Draft
from adibas.data.coding import MS_PER_S
from adibas.errors import AdibasError, RecordingError
from adibas.pipeline.coding_drafts import new_draft
from adibas.pipeline.draft_history import Kept, blind_observer, read_history
from adibas.recordings.ethogram_json import shipped_ethogram
from adibas.recordings.joined import begins_ns_of
from adibas.texts import translate as _
from ui.behaviour.playing import NS_PER_MS, frame_times_ms
from ui.behaviour.ports import Source

if TYPE_CHECKING:
    from adibas.recordings.ports import RecordingReader


@dataclass(frozen=True, slots=True, eq=False)
class Opened:
    """A recording and what is coded of it: by the first observer, and by one who codes blind."""

    source: Source
    reader: "RecordingReader"
    times_ms: tuple[int, ...]
    first: Kept | None
    observer: str
    second: Kept | None
    begins_ms: tuple[int, ...] = ()


def notices_of(opened: Opened) -> list[str]:
    """Return what is to be said of a recording that was opened."""
    kept = (opened.first, opened.second)
    told = [one.notice.text for one in kept if one is not None and one.notice is not None]
    if opened.source.parts:
        sentence = _(
            "{n} recordings one after another: between two of them a second stands for the break, "
            "however long it was."
        )
        told.append(sentence.format(n=len(opened.source.parts)))
    return told if opened.reader.notice is None else [opened.reader.notice, *told]


def open_source(source: Source) -> Opened:
    """Open a recording and take up what is coded of it.

    Raises
    ------
    RecordingError, StoreError, BehaviourError
        It cannot be opened, has no frames, or what is coded of it cannot be read.
    """
    reader = source.access.open(source.path)
    try:
        times_ms = frame_times_ms(reader.timestamps_ns)
        if not times_ms:
            raise RecordingError(
                "{file} has no frames. Choose another recording.", file=source.title
            )
        observer = blind_observer(source.place_for(""))
        second = read_history(source.place_for(observer)) if observer else None
        first = read_history(source.place_for(""))
        begins_ms = tuple(begin_ns // NS_PER_MS for begin_ns in begins_ns_of(reader))
        return Opened(source, reader, times_ms, first, observer, second, begins_ms)
    except AdibasError:
        reader.close()
        raise


def first_draft(opened: Opened, operator: str) -> Draft:
    """Return a draft in which nothing is coded yet; of several parts it tells their begins."""
    source, times_ms = opened.source, opened.times_ms
    observed_ms = (times_ms[0], times_ms[-1])
    draft = new_draft(source.name, observed_ms, shipped_ethogram(), operator)
    if not source.parts:
        return draft
    begins = tuple(
        (f"{name} begins [s]", f"{begin_ms / MS_PER_S:.3f}")
        for name, begin_ms in zip(source.parts, opened.begins_ms, strict=True)
    )
    return replace(draft, coding=replace(draft.coding, media=source.parts, variables=begins))
