"""Who may do what in a store: three roles, and one table of what each may see and do.

A role is a rule of the program: all who have a passphrase have the same key, see
`docs/session-store.md`. Each role may what the ones before it may.
"""

from enum import Enum

from adibas.errors import NotAllowedError
from adibas.texts import Message, message


class Role(Enum):
    """What somebody is in the clinic, the one who may least first."""

    OPERATOR = "operator"
    CLINICIAN = "clinician"
    ADMINISTRATOR = "administrator"


class Permission(Enum):
    """Something that may be seen or done; the value is its name in the audit log."""

    FIND_PATIENTS = "find-patients"
    REGISTER_PATIENTS = "register-patients"
    TAKE_SESSIONS = "take-sessions"
    SEE_ALL_NAMES = "see-all-names"
    SEE_NOTES = "see-notes"
    CHANGE_PATIENTS = "change-patients"
    REPORT = "report"
    COMPARE = "compare"
    EXPORT = "export"
    PURGE = "purge"
    RETAIN = "retain"
    BACK_UP = "back-up"
    READ_LOG = "read-log"
    MANAGE_PEOPLE = "manage-people"
    PROTECT = "protect"
    CHANGE_PROTOCOLS = "change-protocols"


LEAST = {
    Permission.FIND_PATIENTS: Role.OPERATOR,
    Permission.REGISTER_PATIENTS: Role.OPERATOR,
    Permission.TAKE_SESSIONS: Role.OPERATOR,
    Permission.SEE_ALL_NAMES: Role.CLINICIAN,
    Permission.SEE_NOTES: Role.CLINICIAN,
    Permission.CHANGE_PATIENTS: Role.CLINICIAN,
    Permission.REPORT: Role.CLINICIAN,
    Permission.COMPARE: Role.CLINICIAN,
    Permission.EXPORT: Role.CLINICIAN,
    Permission.PURGE: Role.ADMINISTRATOR,
    Permission.RETAIN: Role.ADMINISTRATOR,
    Permission.BACK_UP: Role.ADMINISTRATOR,
    Permission.READ_LOG: Role.ADMINISTRATOR,
    Permission.MANAGE_PEOPLE: Role.ADMINISTRATOR,
    Permission.PROTECT: Role.ADMINISTRATOR,
    Permission.CHANGE_PROTOCOLS: Role.ADMINISTRATOR,
}
"""The role that may it and that may least; those after it may it, too."""

WORDS = {
    Permission.FIND_PATIENTS: message("Looking for patients"),
    Permission.REGISTER_PATIENTS: message("Adding patients and their consents"),
    Permission.TAKE_SESSIONS: message("Recording sessions and reviewing markers"),
    Permission.SEE_ALL_NAMES: message("The list of all patients with their names"),
    Permission.SEE_NOTES: message("Reading the notes on patients"),
    Permission.CHANGE_PATIENTS: message("Changing and hiding patients and sessions"),
    Permission.REPORT: message("Making reports"),
    Permission.COMPARE: message("Comparing sessions"),
    Permission.EXPORT: message("Exporting out of the patient store"),
    Permission.PURGE: message("Removing patients and sessions for good"),
    Permission.RETAIN: message("Removing patients whose time is over"),
    Permission.BACK_UP: message("Making and restoring backups"),
    Permission.READ_LOG: message("Looking into the audit log"),
    Permission.MANAGE_PEOPLE: message("Saying who may open the store"),
    Permission.PROTECT: message("Changing how the store is protected"),
    Permission.CHANGE_PROTOCOLS: message("Changing protocols and who names the markers"),
}
TITLES = {
    Role.OPERATOR: message("Operator"),
    Role.CLINICIAN: message("Clinician"),
    Role.ADMINISTRATOR: message("Administrator"),
}
_ONE = {
    Role.OPERATOR: message("operator"),
    Role.CLINICIAN: message("clinician"),
    Role.ADMINISTRATOR: message("administrator"),
}
_ALL_FROM = {
    Role.OPERATOR: message("everybody"),
    Role.CLINICIAN: message("clinicians and administrators"),
    Role.ADMINISTRATOR: message("administrators"),
}

_LADDER = tuple(Role)


def may(role: Role, permission: Permission) -> bool:
    """Say whether somebody in `role` may do it."""
    return _LADDER.index(role) >= _LADDER.index(LEAST[permission])


def allowed(role: Role) -> tuple[Permission, ...]:
    """Return what a role may, in the order of the table."""
    return tuple(one for one in Permission if may(role, one))


def who_may(permission: Permission) -> Message:
    """Return the words for all who may do it, such as ``clinicians and administrators``."""
    return _ALL_FROM[LEAST[permission]]


def refusal(role: Role, permission: Permission) -> NotAllowedError:
    """Say that somebody in `role` may not do it, who may, and what to do."""
    return NotAllowedError(
        "{what} is only for {who}, and you are here as {role}. Nothing was done. Ask one of them "
        "to do it, or to open the store with their own passphrase.",
        what=WORDS[permission],
        who=who_may(permission),
        role=_ONE[role],
    )
