"""What somebody else saved while the user changed the same, in words. Knows nothing of Qt."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

from adibas.data.landmark_texts import landmark_text
from adibas.data.markers import Marker
from adibas.sessions.conflicts import Choice, Conflict, Decision, Version
from adibas.texts import message
from adibas.texts import translate as _

TEXTS = ("notes",)
"""Fields of which both versions can stay, one below the other."""

FIELD_WORDS = {
    "notes": message("Notes"),
    "name": message("Name"),
    "birth_date": message("Birth date"),
    "record_number": message("Record number"),
    "sex": message("Sex"),
    "setup.source": message("Sensor"),
    "setup.color_size": message("Size of the picture"),
    "setup.markers": message("Markers that are looked for"),
    "setup.rotation_deg": message("Rotation of the picture"),
    "setup.protocol": message("Protocol"),
    "setup.wand": message("Check with the wand"),
    "setup.turn": message("Slow turn"),
    "setup.is_repeat": message("Repeats the session before it"),
}
VALUE_WORDS = {"true": message("yes"), "false": message("no"), "null": message("none")}
SEX_WORDS = {"female": message("female"), "male": message("male")}

Decide = Callable[[tuple[Decision, ...]], None]


@dataclass(frozen=True, slots=True)
class DisputeRow:
    """One field with two versions, as the user reads it."""

    field: str
    theirs: str
    mine: str
    operator: str
    changed_utc: datetime
    can_keep_both: bool


class Dispute:
    """A question to whoever saved second.

    Parameters
    ----------
    conflicts : tuple of Conflict
        What both changed.
    decide : callable
        Saves again with the decisions.
    put_off : callable
        Told where the user does not decide now.
    """

    def __init__(
        self, conflicts: tuple[Conflict, ...], decide: Decide, put_off: Callable[[], None]
    ) -> None:
        self._conflicts = conflicts
        self._decide = decide
        self.put_off = put_off
        self.rows = tuple(_row(one) for one in conflicts)

    def decide(self, choices: tuple[Choice, ...]) -> None:
        """Save, with one choice a row."""
        pairs = zip(self._conflicts, choices, strict=True)
        self._decide(tuple(Decision(conflict, choice) for conflict, choice in pairs))


def undecided(conflicts: tuple[Conflict, ...]) -> tuple[Decision, ...]:
    """Return the decisions that lose nothing: both texts, and of the rest the other version."""
    return tuple(Decision(one, "both" if one.field in TEXTS else "theirs") for one in conflicts)


def _row(conflict: Conflict) -> DisputeRow:
    word = FIELD_WORDS.get(conflict.field)
    is_marker = word is None
    field = (
        _("Marker {name}").format(name=landmark_text(conflict.field)) if word is None else _(word)
    )
    theirs, mine = (
        _marker_text(one) if is_marker else _value_text(conflict.field, one, is_mine=is_mine)
        for one, is_mine in ((conflict.theirs, False), (conflict.mine, True))
    )
    return DisputeRow(
        field,
        theirs,
        mine,
        conflict.operator,
        conflict.changed_utc,
        can_keep_both=conflict.field in TEXTS,
    )


def _marker_text(version: Version) -> str:
    if not isinstance(version, Marker):
        return _("deleted")
    return _("{name} at {u:.1f}, {v:.1f} px").format(
        name=landmark_text(version.label), u=version.u, v=version.v
    )


def _value_text(field: str, version: Version, *, is_mine: bool) -> str:
    text = version if isinstance(version, str) else ""
    if field == "sex":
        return _(SEX_WORDS[text]) if text in SEX_WORDS else _("not told")
    if not field.startswith("setup."):
        return text or _("nothing")
    value = json.loads(text)
    if isinstance(value, dict):  # colours or a wand: nothing that a line of text could tell
        return _("what was measured here") if is_mine else _("what was measured there")
    if text in VALUE_WORDS:
        return _(VALUE_WORDS[text])
    if isinstance(value, list):
        return " x ".join(map(str, value))
    return str(value) or _("none")
