"""What is removed for good, in the words of the question before it."""

from PySide6.QtWidgets import QWidget

from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.patients.content import PurgeQuestion
from ui.widgets.dates import moment_text
from ui.widgets.typed_consent import TypedConsent


def purge_dialog(question: PurgeQuestion, parent: QWidget) -> TypedConsent:
    """Return the dialog that asks before a patient or a session is removed."""
    return TypedConsent(_explanation(question), question.word, parent)


def _explanation(question: PurgeQuestion) -> str:
    if question.kind == "session":
        return _(
            "The session of {when} of {name} will be removed with all its pictures and "
            "recordings. Nobody can bring it back."
        ).format(when=moment_text(question.started_utc), name=question.name)
    return translate_plural(
        "{name} will be removed with {count} session, its pictures and recordings. Nobody can "
        "bring them back.",
        "{name} will be removed with {count} sessions, their pictures and recordings. Nobody can "
        "bring them back.",
        question.n_sessions,
    ).format(name=question.name, count=question.n_sessions)
