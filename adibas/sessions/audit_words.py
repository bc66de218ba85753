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
KIND_WORDS = {
    "recording": message("a recording"),
    "json": message("a report (JSON)"),
    "xlsx": message("a report (Excel)"),
    "pdf": message("a report (PDF)"),
    "report": message("a report"),
    "fhir": message("a FHIR file"),
    "dicom": message("DICOM files"),
    "dicom server": message("DICOM files to a server"),
    "back": message("the measures of the back"),
    "body": message("the measures of the body"),
    "plot": message("a plot of two sessions"),
    "coding": message("a coding"),
    "map": message("a map in 3-D"),
    "limb labels": message("a folder of labelled limbs"),
    "training of names": message("a model of names, learned from corrections"),
    "audit log": message("the audit log"),
}
"""What left the store, by its kind in the log."""
WITH_IDENTITY = ", with identity"
"""Ends the kind of what says who the patient is."""
PURPOSE_NAMES = {
    "treatment": message("Treatment"),
    "research": message("Research"),
    "teaching": message("Teaching"),
}
SUBJECT_WORDS = {
    "store": message("the patient store"),
    "patients": message("the list of patients"),
    "people": message("who may open the store"),
}


def action_text(action: str) -> str:
    """Return what was done; a later version's word as it is."""
    return _(ACTION_WORDS[action]) if action in ACTION_WORDS else action


def kind_text(kind: str) -> str:
    """Return what left the store; a later version's word as it is."""
    bare = kind.removesuffix(WITH_IDENTITY)
    told = _(KIND_WORDS[bare]) if bare in KIND_WORDS else bare
    return told if bare == kind else _("{what}, with identity").format(what=told)


def subject_text(subject: str) -> str:
    """Return what it was done to: an id, or the words for the whole."""
    return _(SUBJECT_WORDS[subject]) if subject in SUBJECT_WORDS else subject
