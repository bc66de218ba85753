"""The other markers of a capture get their names, after a hand has given some."""

from collections.abc import Mapping

from adibas.data.calibration import RgbdCalibration
from adibas.data.markers import Marker, is_numbered
from adibas.data.protocols import Protocol
from adibas.data.surface import BurstDisparity
from adibas.errors import MarkerError
from adibas.pipeline.namers import namer_of
from adibas.pipeline.seen_body import with_body
from adibas.pipeline.skeleton_names import with_names


def names_of_others(
    protocol: Protocol,
    markers: tuple[Marker, ...],
    view: str,
    calibration: RgbdCalibration,
    rotation_deg: int = 0,
    surface: BurstDisparity | None = None,
) -> Mapping[str, Marker]:
    """Return the markers that have only a number and get a name now, by that number.

    Parameters
    ----------
    protocol : Protocol
        Whose landmarks are looked for.
    markers : tuple of Marker
        Of one capture. The names that are there stay, and the new ones agree with them.
    view : str
        As declared; empty: left and right only where the shape or the names tell them.
    calibration : RgbdCalibration
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    surface : BurstDisparity or None
        Of the capture; None where it was not kept: places alone name then.

    Raises
    ------
    MarkerError
        No model knows the landmarks of this protocol in this view.
    """
    namer = namer_of(protocol, view)
    if namer is None:
        raise MarkerError(
            "No model knows the landmarks of this protocol yet. Name the markers one by one; from "
            "ten captures a model can be learned, in Settings."
        )
    named = frozenset(one.label for one in markers if not is_numbered(one.label))
    if surface is not None:
        namer = with_body(namer, surface.depth_m, view, calibration, rotation_deg)
    found = with_names(namer, markers, view, calibration, named, rotation_deg)
    pairs = zip(markers, found, strict=True)
    return {before.label: after for before, after in pairs if before.label != after.label}
