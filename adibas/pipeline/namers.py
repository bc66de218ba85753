"""Who names the markers of a protocol: the clinic's own model where it fits, or the shipped one."""

import functools
import logging
from pathlib import Path

import platformdirs

from adibas.data.protocols import Protocol, same_label
from adibas.errors import AdibasError
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.skeleton.model import SkeletonModel
from adibas.skeleton.model_files import read_model, write_model
from adibas.skeleton.namer import Namer


def own_model_path() -> Path:
    """Return the file of the model that this user learned from own sessions; it may lack."""
    return platformdirs.user_data_path("adibas", appauthor=False) / "models" / "names.json"


def keep_own_model(model: SkeletonModel) -> Path:
    """Let markers be named by this model from now on; return its file.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    path = own_model_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    write_model(model, path)
    return path


def namer_of(protocol: Protocol) -> Namer | None:
    """Return who knows the landmarks of a protocol; None where nobody does.

    A model of joints names no other places: a marker on the chin is no neck.
    """
    known = frozenset[str]().union(*(landmark.labels for landmark in protocol.landmarks))
    own = _own_namer()
    if own is not None and {same_label(name) for name in own.names} <= known:
        return own
    landmarks = {landmark.landmark_id for landmark in protocol.landmarks}
    return shipped_namer() if landmarks <= set(shipped_namer().names) else None


def _own_namer() -> Namer | None:
    path = own_model_path()
    try:
        return _read(path, path.stat().st_mtime_ns)
    except OSError:
        return None
    except AdibasError as error:
        logging.getLogger(__name__).warning("own model of names left aside: %s", error)
        return None


@functools.lru_cache(maxsize=1)
def _read(path: Path, _changed_ns: int) -> Namer:
    """Read each state of the file once."""
    return Namer(read_model(path))
