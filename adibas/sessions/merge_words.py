"""What came of a backup that was restored into a store in use, in sentences."""

from typing import TYPE_CHECKING

from adibas.texts import translate as _
from adibas.texts import translate_plural

if TYPE_CHECKING:
    from adibas.sessions.merging import MergeSummary


def merge_texts(summary: "MergeSummary") -> tuple[str, ...]:
    """Return one sentence for each thing that there is to know."""
    return (_added(summary), *_told(summary))


def _added(summary: "MergeSummary") -> str:
    n_patients, n_sessions = summary.n_patients, summary.n_sessions
    n_captures, n_recordings = summary.n_captures, summary.n_recordings
    patients = translate_plural("{n} patient", "{n} patients", n_patients)
    sessions = translate_plural("{n} session", "{n} sessions", n_sessions)
    captures = translate_plural("{n} capture", "{n} captures", n_captures)
    recordings = translate_plural("{n} recording", "{n} recordings", n_recordings)
    told = _("Added from the backup: {patients}, {sessions}, {captures}, {recordings}.")
    return told.format(
        patients=patients.format(n=n_patients),
        sessions=sessions.format(n=n_sessions),
        captures=captures.format(n=n_captures),
        recordings=recordings.format(n=n_recordings),
    )


def _told(summary: "MergeSummary") -> tuple[str, ...]:
    told = []
    if n := summary.n_purged:
        text = translate_plural(
            "{n} patient or session that was purged here stays gone.",
            "{n} patients and sessions that were purged here stay gone.",
            n,
        )
        told.append(text.format(n=n))
    if n := len(summary.newer_here):
        text = translate_plural(
            "{n} thing is newer here and stays as it is here: {ids}",
            "{n} things are newer here and stay as they are here: {ids}",
            n,
        )
        told.append(text.format(n=n, ids=" ".join(summary.newer_here)))
    if n := len(summary.both_kept):
        text = translate_plural(
            "{n} thing was changed on both sides; the newer one holds, the other is kept in its "
            "notes or its corrections: {ids}",
            "{n} things were changed on both sides; the newer ones hold, the others are kept in "
            "their notes or their corrections: {ids}",
            n,
        )
        told.append(text.format(n=n, ids=" ".join(summary.both_kept)))
    if n := len(summary.other_codings):
        text = translate_plural(
            "Something else was coded here in {n} recording, and stays: {ids} Restore the backup "
            "into a folder of its own to see what it has.",
            "Something else was coded here in {n} recordings, and stays: {ids} Restore the backup "
            "into a folder of its own to see what it has.",
            n,
        )
        told.append(text.format(n=n, ids=" ".join(summary.other_codings)))
    if summary.not_added:
        text = _(
            "These pseudonyms stand for somebody else here, and were not added: {ids} Restore the "
            "backup into a folder of its own to see them."
        )
        told.append(text.format(ids=" ".join(summary.not_added)))
    return tuple(told)
