"""What the lines of the audit log are called where somebody reads them."""

from adibas.texts import message
from adibas.texts import translate as _

ACTION_WORDS = {
    "create": message("created"),
    "view": message("looked at"),
    "change": message("changed"),
    "export": message("exported"),
    "delete": message("hidden"),
    "restore": message("shown again"),
    "purge": message("removed for good"),
    "open": message("opened"),
    "recover": message("recovered after a crash"),
    "backup": message("backed up"),
    "merge": message("restored from a backup"),
    "refuse": message("was refused"),
}
SUBJECT_WORDS = {
    "store": message("the patient store"),
    "patients": message("the list of patients"),
    "people": message("who may open the store"),
}


def action_text(action: str) -> str:
    """Return what was done; a later version's word as it is."""
    return _(ACTION_WORDS[action]) if action in ACTION_WORDS else action


def subject_text(subject: str) -> str:
    """Return what it was done to: an id, or the words for the whole."""
    return _(SUBJECT_WORDS[subject]) if subject in SUBJECT_WORDS else subject
