"""What may fail in the world outside the program.

An `AdibasError` is never a bug: a cable, a disk, a file. Its text says what failed, on which
thing, and what to do. `adibas.texts.describe` says it in the user's language.
"""

from functools import partial


class AdibasError(Exception):
    """Something outside the program failed.

    Parameters
    ----------
    message_id : str
        The English sentence with ``{field}`` places; it is also the key of the translation.
    **fields : object
        What stands at those places. Never a patient's name or birth date.
    """

    def __init__(self, message_id: str, **fields: object) -> None:
        super().__init__(message_id, fields)
        self.message_id = message_id
        self.fields = fields

    def __reduce__(self) -> tuple[object, ...]:
        """Cross from one process to another with its fields."""
        return partial(type(self), self.message_id, **self.fields), ()

    def __str__(self) -> str:
        return self.message_id.format(**self.fields)


class RecordingError(AdibasError):
    """A recording cannot be read or written."""


class CalibrationError(AdibasError):
    """A calibration is missing, broken, or does not fit the recording."""


class SensorError(AdibasError):
    """A camera is missing, was unplugged, or refuses a mode."""


class MarkerError(AdibasError):
    """A colour model is unusable, or the markers do not suffice."""


class ProtocolError(AdibasError):
    """A protocol cannot be read, or does not fit what was captured."""


class GestureError(AdibasError):
    """Examples or a model of gestures cannot be used."""


class BehaviourError(AdibasError):
    """An ethogram or a coding cannot be read, written or compared."""


class LimbError(AdibasError):
    """Labelled images or a model of limbs cannot be used."""


class BodyError(AdibasError):
    """The surface of the body cannot be had from what was recorded."""


class MapError(AdibasError):
    """A map cannot be made with what is installed."""


class ReportError(AdibasError):
    """A report cannot be written."""


class ExchangeError(AdibasError):
    """Another system of the clinic cannot be reached, or does not take what it is given."""


class StoreError(AdibasError):
    """The store of patients and sessions cannot be opened, read or changed."""


class PassphraseError(StoreError):
    """The store needs a passphrase, or another one."""


class RecoveryKeyTypedError(PassphraseError):
    """What was typed is no recovery key: a letter is wrong, missing or too many."""


class BackupLockedError(PassphraseError):
    """A backup needs a passphrase, and none was given."""


class NotAllowedError(StoreError):
    """Whoever has the store open may not do this: it is for another role."""


class ConsentError(StoreError):
    """No consent of the patient stands for what is to be done."""


class ServerPasswordError(StoreError):
    """The server of the store's database needs a password, or another one."""


class ServerAwayError(StoreError):
    """The server of the store's database does not answer: the same can be tried again."""


class FileError(AdibasError):
    """A file cannot be read or written."""
