"""What a report says in lines of name and value: one place, so that every format says the same."""

from collections import Counter
from datetime import datetime

from adibas.data.posture import PostureAnalysis, Provenance
from adibas.data.protocol_measures import INSTRUMENT_ONLY, PLANE_TEXTS, VERTICAL_TEXTS
from adibas.data.reliability import Comparison, Verdict
from adibas.data.report import CaptureReport, SessionReport
from adibas.texts import decimal_text, translate_plural
from adibas.texts import translate as _

Pairs = list[tuple[str, str | float]]

HASH_LENGTH = len("sha256:") + 12
N_TO_SECONDS = len("2026-03-27T16:05:09")
"""Of an ISO 8601 moment: what follows is the zone, and that is told beside it."""


def view_name(view: str) -> str:
    """Return the name of one of `VIEWS` for a reader."""
    names = {
        "": _("not told"),
        "anterior": _("anterior"),
        "posterior": _("posterior"),
        "right_lateral": _("right lateral"),
        "left_lateral": _("left lateral"),
    }
    return names[view]


def capture_names(report: SessionReport) -> tuple[str, ...]:
    """Return the name of each capture's view; a view that comes again is numbered."""
    counts: Counter[str] = Counter()
    names = []
    for capture in report.captures:
        view = capture.analysis.view
        counts[view] += 1
        name = view_name(view)
        names.append(name if counts[view] == 1 else f"{name} ({counts[view]})")
    return tuple(names)


def session_facts(report: SessionReport) -> Pairs:
    """Return who was measured, when, by whom and how."""
    begun = "" if report.started_utc is None else report.started_utc.isoformat(timespec="seconds")
    told = [
        (_("Session begun (UTC)"), begun),
        (_("Operator"), report.operator),
        (_("Protocol"), report.protocol),
        (_("Notes"), report.notes),
    ]
    return [(_("Patient (pseudonym)"), report.patient), *((n, v) for n, v in told if v)]


def capture_facts(report: SessionReport, capture: CaptureReport) -> Pairs:
    """Return what was found in a capture, and on what calibration it rests."""
    analysis = capture.analysis
    measured = sum(marker.position_m is not None for marker in analysis.markers)
    return [
        (_("View"), view_name(analysis.view)),
        analysed(analysis.provenance),
        (_("Frames in the burst"), analysis.n_frames),
        (_("Markers found"), len(analysis.markers)),
        (_("Markers with a position"), measured),
        (_("Markers placed by hand"), len(capture.placed_by_hand)),
        (_("Calibration"), calibration_text(analysis)),
        (_("Age of the calibration"), calibration_age(report, analysis) or _("not known")),
    ]


def general_facts(report: SessionReport) -> Pairs:
    """Return what the reader must know about every report."""
    return [
        (_("Software version"), report.version),
        (_("Intended use"), intended_use()),
        (
            _("Intervals"),
            _("95 %, instrument only: the palpation of landmarks and the stance are not in them."),
        ),
    ]


def protocol_facts(analysis: PostureAnalysis) -> Pairs:
    """Return which protocol was followed, in what plane, and what its reader must know."""
    measures = analysis.measures
    if measures is None:
        return []
    protocol = measures.protocol
    facts: Pairs = [
        (_("Measures of"), f"{protocol.title.text} ({protocol.protocol_id}, {protocol.revision})"),
        (_("Source of the protocol"), protocol.source),
        (_("Plane of projected values"), _(PLANE_TEXTS[measures.plane])),
        (_("Vertical"), _(VERTICAL_TEXTS[measures.vertical])),
        (_("Intervals of measures"), _(INSTRUMENT_ONLY)),
        (_("Measured on"), _("markers; nothing of it was estimated without markers")),
    ]
    if protocol.notes is not None:
        facts.append((_("Note on the protocol"), protocol.notes.text))
    return facts + [(_("Notice"), notice.text) for notice in measures.notices]


def comparison_facts(report: SessionReport) -> Pairs:
    """Return with what the session was compared, and what chance alone would mark."""
    if report.comparison is None:
        return []
    chance = chance_text(report.comparison.comparison)
    since = report.comparison.since_utc.isoformat(timespec="seconds")
    return [(_("Compared with the session of (UTC)"), since), (_("Beyond MDC95"), chance)]


def chance_text(found: Comparison) -> str:
    """Return how many changes are marked, and how many would be if nothing had changed."""
    if not found.n_judged:
        return _(
            "No change can be marked: the smallest detectable change is not known without repeats."
        )
    return _(
        "{beyond} of {judged} measures are marked; if nothing had changed, {expected} would be."
    ).format(
        beyond=found.n_beyond,
        judged=found.n_judged,
        expected=decimal_text(found.expected_by_chance, 1),
    )


def verdict_text(verdict: Verdict) -> str:
    """Return what a change is against the smallest detectable one, for a reader."""
    return {
        Verdict.INSIDE: _("inside MDC95"),
        Verdict.BEYOND: _("beyond MDC95"),
        Verdict.UNKNOWN: _("not known"),
    }[verdict]


def analysed(provenance: Provenance) -> tuple[str, str]:
    """Return when the numbers were computed, to the second, and what that is called."""
    return _("Analysed (UTC)"), provenance.created_utc[:N_TO_SECONDS].replace("T", " ")


def intended_use() -> str:
    """Return what a report may be used for."""
    return _("Research, education and documentation. Not for diagnosis.")


def notices(analysis: PostureAnalysis) -> Pairs:
    """Return what the reader must know about the input, and what was refused."""
    facts: Pairs = [(_("Notice"), _(notice)) for notice in analysis.notices]
    for blob in analysis.rejected:
        where = f"({blob.u:.0f}, {blob.v:.0f}) {_(blob.reason)}"
        facts.append((_("Not counted as a marker"), where))
    return facts


def notice_texts(analysis: PostureAnalysis) -> tuple[str, ...]:
    """Return what the reader must know about the input and the protocol's measures."""
    of_measures = () if analysis.measures is None else analysis.measures.notices
    return (*(_(notice) for notice in analysis.notices), *(one.text for one in of_measures))


def calibration_text(analysis: PostureAnalysis) -> str:
    """Return sensor, date and identity of the calibration, as far as they are known."""
    calibration = analysis.calibration
    known = [
        calibration.sensor_serial,
        calibration.created_utc,
        analysis.provenance.calibration[:HASH_LENGTH],
    ]
    return ", ".join(part for part in known if part)


def calibration_age(report: SessionReport, analysis: PostureAnalysis) -> str:
    """Return how old the calibration was when the session began; empty where not known."""
    made = _parsed(analysis.calibration.created_utc)
    used = report.started_utc or _parsed(analysis.provenance.created_utc)
    if made is None or used is None or (made.tzinfo is None) != (used.tzinfo is None):
        return ""
    n_days = max((used - made).days, 0)
    return translate_plural("{n} day", "{n} days", n_days).format(n=n_days)


def _parsed(moment: str) -> datetime | None:
    try:
        return datetime.fromisoformat(moment)
    except ValueError:
        return None
