"""The words of a report of behaviour."""

from adibas.pipeline.behaviour import OUT_OF_VIEW, POSTURE_CHANGE
from adibas.texts import Message, message
from adibas.texts import translate as _

OWN: dict[str, Message] = {
    POSTURE_CHANGE: message("posture change"),
    OUT_OF_VIEW: message("out of view"),
}
UNTAGGED = message("rest of the session")
NOBODY = message("nobody in particular")
PERSON = message("Person {n}")


def behaviour_text(name: str) -> str:
    """Return what the program calls its own behaviours in the language in use; others stay."""
    return _(OWN[name]) if name in OWN else name


def subject_text(subject: str) -> str:
    """Return who acts, for a reader."""
    kind, _space, number = subject.partition(" ")
    if kind == "person" and number.isdecimal():
        return _(PERSON).format(n=number)
    return subject or _(NOBODY)


def condition_text(name: str) -> str:
    """Return a condition's name for a reader."""
    return name or _(UNTAGGED)
