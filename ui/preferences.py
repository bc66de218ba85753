"""What one user of one computer prefers; a small file beside the store, without any patient."""

import json
import logging
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import platformdirs

from adibas.errors import FileError
from adibas.files import written_whole
from adibas.sessions.defaults import ADULT_AGE, CHILD_UNTIL_AGE, RETENTION_YEARS
from adibas.texts import LANGUAGES, system_language
from ui.events import Event

logger = logging.getLogger(__name__)

FILE = "preferences.json"
THEMES = ("system", "light", "dark")
FONT_SCALES = (1.0, 1.25, 1.5, 1.75, 2.0)
MOST_BACKUP_DAYS, MOST_BACKUPS = 365, 100
MOST_RETENTION_YEARS = 100


@dataclass(frozen=True, slots=True)
class Preferences:
    """Settings of the window.

    Attributes
    ----------
    language : str
        Two letters.
    theme : str
        Of `THEMES`.
    font_scale : float
        1 to 2.
    autolock_minutes : int
        Without mouse or key, until the window locks; 0 = never.
    operator : str
        Who works here; goes into the audit trail.
    has_sound : bool
        Of the countdown.
    countdown_s, burst_frames : int
        Of a capture.
    calibration_days : int
        Older ones are told: when the sensor is live, and in every capture.
    wand_length_mm : float
        Of the wand that was measured last.
    protocol : str
        Of sessions that begin; empty = none.
    store : str
        Folder of the store; empty = the usual one.
    backup_folder : str
        Where backups are made every few days; empty = none are.
    backup_days, backup_keep : int
        Days between two of them, and how many are kept.
    retention_years, child_until_age : int
        How long patients are kept after the last session, and children at least.
    geometry, docks : str
        Of the window and of the help beside it, as Qt packs them, hexadecimal.
    splitters : dict of str
        The same of the bars between the parts of screens.
    """

    language: str = ""
    theme: str = "system"
    font_scale: float = 1.0
    autolock_minutes: int = 10
    operator: str = ""
    has_sound: bool = True
    countdown_s: int = 3
    burst_frames: int = 30
    calibration_days: int = 180
    wand_length_mm: float = 500.0
    protocol: str = ""
    store: str = ""
    backup_folder: str = ""
    backup_days: int = 7
    backup_keep: int = 4
    retention_years: int = RETENTION_YEARS
    child_until_age: int = CHILD_UNTIL_AGE
    geometry: str = ""
    docks: str = ""
    splitters: dict[str, str] = field(default_factory=dict)


class PreferencesFile:
    """The preferences in use; a change is told, and written at once.

    A file that is missing or damaged means the usual preferences: none of them is worth an error
    at the start of a session.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path or platformdirs.user_config_path("adibas", appauthor=False) / FILE
        self.changed: Event[[Preferences]] = Event()
        self.now = _read(self._path)
        if not self.now.language:
            self.now = replace(self.now, language=system_language())

    def change(self, **changes: Any) -> None:
        """Take new values, tell who subscribed, and write the file."""
        wanted = replace(self.now, **changes)
        if wanted == self.now:
            return
        self.now = wanted
        self.changed.emit(wanted)
        self._write()

    def _write(self) -> None:
        try:
            with written_whole(self._path) as unfinished:
                unfinished.write_text(json.dumps(asdict(self.now), indent=1), encoding="utf-8")
        except FileError:
            logger.warning("the preferences cannot be written; they hold until the end")


def _read(path: Path) -> Preferences:
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return Preferences()
    if not isinstance(values, dict):
        return Preferences()
    usual = Preferences()
    known = {}
    for one in fields(Preferences):
        value = _understood(values.get(one.name))
        if type(value) is type(getattr(usual, one.name)):
            known[one.name] = value
    return _bounded(Preferences(**known))


def _understood(value: Any) -> Any:
    """Return a value of the file as the preferences hold it."""
    if isinstance(value, dict):
        return {name: str(part) for name, part in value.items()}
    return value


def _bounded(preferences: Preferences) -> Preferences:
    """Return the preferences with what makes no sense put right."""
    scale = preferences.font_scale
    return replace(
        preferences,
        language=preferences.language if preferences.language in LANGUAGES else "",
        theme=preferences.theme if preferences.theme in THEMES else "system",
        font_scale=min(FONT_SCALES, key=lambda offered: abs(offered - scale)),
        autolock_minutes=max(preferences.autolock_minutes, 0),
        backup_days=min(max(preferences.backup_days, 1), MOST_BACKUP_DAYS),
        backup_keep=min(max(preferences.backup_keep, 1), MOST_BACKUPS),
        retention_years=min(max(preferences.retention_years, 1), MOST_RETENTION_YEARS),
        child_until_age=min(max(preferences.child_until_age, ADULT_AGE), MOST_RETENTION_YEARS),
        countdown_s=min(max(preferences.countdown_s, 0), 60),
        burst_frames=min(max(preferences.burst_frames, 1), 300),
        calibration_days=min(max(preferences.calibration_days, 1), 3650),
    )
