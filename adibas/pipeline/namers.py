"""Who names the markers of a protocol: a model of the clinic's own where it fits, or the shipped.

Each set of landmarks has its own model: those of a protocol, in one of its views where each view
marks other places. They are files in one folder.
"""

import functools
import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import platformdirs

from adibas.data.protocols import Protocol, same_label
from adibas.data.views import VIEWS
from adibas.errors import AdibasError
from adibas.files import remove_file
from adibas.pipeline.skeleton_examples import LandmarkSet
from adibas.pipeline.skeleton_labelling import shipped_knows, shipped_namer
from adibas.skeleton.model import SkeletonModel
from adibas.skeleton.model_files import read_model, write_model
from adibas.skeleton.namer import Namer

STEM = "names"
N_KEPT = 32
"""Models in memory: a protocol has four views."""


@dataclass(frozen=True, slots=True, eq=False)
class OwnNames:
    """A model that this user learned.

    Attributes
    ----------
    which : LandmarkSet
        Whose landmarks it was learned from; empty where it came from a file of points.
    namer : Namer
        The model at work.
    provenance : Mapping
        What it was learned from, as `SkeletonModel` has it.
    learned_utc : datetime or None
        When; None where the file does not tell.
    """

    which: LandmarkSet
    namer: Namer
    provenance: Mapping[str, object]
    learned_utc: datetime | None


def own_model_path(which: LandmarkSet | None = None) -> Path:
    """Return the file of the model of own sessions for a set of landmarks; it may lack."""
    which = which or LandmarkSet()
    name = "-".join(filter(None, (STEM, which.protocol, which.view)))
    return _folder() / f"{name}.json"


def keep_own_model(model: SkeletonModel) -> Path:
    """Let markers be named by this model from now on; return its file.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    path = own_model_path(_set_of(model.provenance))
    path.parent.mkdir(parents=True, exist_ok=True)
    write_model(model, path)
    return path


def forget_own_model(which: LandmarkSet) -> None:
    """Let markers be named as before there was an own model of these landmarks.

    Raises
    ------
    FileError
        The file cannot be removed.
    """
    remove_file(own_model_path(which))


def own_models() -> tuple[OwnNames, ...]:
    """Return the models that this user learned; damaged ones are left aside."""
    return tuple(_own_models())


def namer_of(protocol: Protocol, view: str = "") -> Namer | None:
    """Return who knows the landmarks of a protocol in a view; None where nobody does.

    A model of joints names no other places: a marker on the chin is no neck. An own model that
    knows fewer landmarks than the shipped one does not take its place.
    """
    wanted = {one.landmark_id for one in protocol.landmarks}
    is_shipped_known = shipped_knows(wanted)
    known = frozenset[str]().union(
        *(one.labels for one in protocol.landmarks if not view or view in one.views)
    )
    fitting = [
        own.namer
        for own in _own_models()
        if own.which.view in ("", view)
        and {same_label(name) for name in own.namer.names} <= known
        and not (is_shipped_known and len(own.namer.names) < len(wanted))
    ]
    if fitting:
        return max(fitting, key=lambda namer: len(namer.names))
    return shipped_namer() if is_shipped_known else None


def _folder() -> Path:
    return platformdirs.user_data_path("adibas", appauthor=False) / "models"


def _set_of(provenance: Mapping[str, object]) -> LandmarkSet:
    view = str(provenance.get("view", ""))
    return LandmarkSet(str(provenance.get("protocol", "")), view if view in VIEWS else "")


def _own_models() -> Iterator[OwnNames]:
    for path in sorted(_folder().glob(f"{STEM}*.json")):
        try:
            found = _read(path, path.stat().st_mtime_ns)
        except OSError:
            continue
        if found is not None:
            yield found


@functools.lru_cache(maxsize=N_KEPT)
def _read(path: Path, _changed_ns: int) -> OwnNames | None:
    """Read each state of the file once."""
    try:
        model = read_model(path)
    except AdibasError as error:
        logging.getLogger(__name__).warning("own model of names left aside: %s", error)
        return None
    told = model.provenance
    return OwnNames(_set_of(told), Namer(model), told, _moment(str(told.get("created_utc", ""))))


def _moment(text: str) -> datetime | None:
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        return None
    return None if found.tzinfo is None else found
