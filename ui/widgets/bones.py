"""The bones between joints that have a place in the picture; without Qt."""

from collections.abc import Iterator, Mapping

from adibas.data.joints import PARENT_OF
from ui.widgets.overlays import Line, Role


def bones(places: Mapping[str, tuple[float, float]], role: Role = "bone") -> Iterator[Line]:
    """Join the joints among named pixels (u, v)."""
    for joint, parent in PARENT_OF.items():
        if joint in places and parent in places:
            yield Line(*places[joint], *places[parent], role)
