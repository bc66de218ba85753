"""What the report of behaviour says in lines of name and value."""

from adibas.data.coding import MS_PER_S
from adibas.pipeline.behaviour import BehaviourAnalysis
from adibas.reports.facts import analysed, intended_use
from adibas.texts import decimal_text
from adibas.texts import translate as _

Pairs = list[tuple[str, str | float]]


def behaviour_facts(analysis: BehaviourAnalysis) -> Pairs:
    """Return what was watched, how, and what the reader must know."""
    detected, observed = analysis.detected, analysis.observed
    told: Pairs = [
        (_("Patient (pseudonym)"), analysis.patient),
        (_("Recording"), analysis.recording),
        (_("Recordings"), ", ".join(analysis.parts)),
        (_("Duration [s]"), decimal_text(detected.duration_ms / MS_PER_S, 1)),
        (_("People"), str(len(analysis.people))),
        (_("Observer"), "" if observed is None else observed.observer or _("not told")),
        (_("Ethogram"), "" if observed is None else observed.ethogram.name),
        (_("What this is"), no_score_text()),
        (_("Movement"), movement_text()),
        (_("Posture change"), posture_text()),
    ]
    told = [(name, value) for name, value in told if value]
    return [*told, *((_("Notice"), notice.text) for notice in analysis.notices)]


def general_facts(analysis: BehaviourAnalysis) -> Pairs:
    """Return where the numbers come from."""
    provenance = analysis.provenance
    return [
        (_("Software version"), provenance.version),
        (_("Intended use"), intended_use()),
        (_("Recording (SHA-256)"), provenance.recording_sha256),
        analysed(provenance),
    ]


def no_score_text() -> str:
    """Return what these figures are not."""
    return _(
        "Indicators beside the coding of a human observer. They are no score and no diagnosis, and "
        "no value is called normal or not."
    )


def movement_text() -> str:
    """Return when a joint moves, in words."""
    return _(
        "Positions are smoothed; a joint moves where it goes farther from one sample to the next "
        "than 99 of 100 steps of the sensor's noise. Only such steps are in the path."
    )


def posture_text() -> str:
    """Return when a posture has changed, in words."""
    return _(
        "The mean place of the trunk in the second before and in the second after differ by 10 cm "
        "or more, and most of all at that moment."
    )
